//! `jde ready`: whether a reboot or an update may come now. It says yes only of what it knows: what gives no answer, has no
//! value yet or runs out of reach is a reason against it.

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use clap::{Args, Command, CommandFactory};
use jde_abi::describe::Kind;
use jde_core::{Nanos, State};
use jde_link::message::{Schemas, VariableInfo};
use jde_link::{Client, Reach, Remote, Sample};
use jde_records::snapshot::Snapshot;
use jde_session::cli::print_json;
use jde_terminal::{self as terminal, BAD, GOOD, TITLE};
use jde_types::{Mission, Value as _};
use serde::Serialize;

use super::apps::present;
use super::record::is_true;
use super::{Context, Target};
use crate::cli::Cli;
use crate::failure::Failure;
use crate::quantity;

/// Nobody may act for this long: a robot that plans its next motion stands still too.
const STILL: Duration = Duration::from_secs(2);
/// The time between two trials of `--wait`.
const POLL: Duration = Duration::from_secs(1);
/// The variable of the environment with another folder than /proc. Only tests set it, because other tests run beside them.
const PROCESSES: &str = "JDE_TEST_PROC";
/// The verbs that run an application.
const RUNNING_VERBS: [&str; 2] = ["run", "demo"];

/// Say whether a reboot or an update may come now.
///
/// The exit status is 0 if each application on this machine is idle, and 1 if one is not, or if that is not known. An
/// application is idle if for two seconds no motor schema with an actuator acts, no command is in force, and every mission
/// that it exports is done, has failed, or waits for a target. Whether a robot is docked, or carries something, is known
/// to its variables: name them with --also.
#[derive(Args)]
#[command(after_help = "Examples:
  jde ready && reboot
  jde ready --also 'dock.docking.state == 1'
  jde ready --wait 10min --json

Exit status: 0 ready, 1 not ready or not known, 2 wrong use.")]
pub(crate) struct Ready {
    #[command(flatten)]
    target: Target,
    /// This must be true too; a condition as of --when (repeatable). Without a value of its variables it is not.
    #[arg(long, value_name = "CONDITION")]
    also: Vec<String>,
    /// Wait until it is ready, at most for this time.
    #[arg(long, value_name = "TIME", num_args = 0..=1, value_parser = quantity::time)]
    wait: Option<Option<Nanos>>,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
}

/// The answer.
#[derive(Serialize)]
struct Answer {
    ready: bool,
    applications: Vec<Verdict>,
    /// What may run, and cannot be asked.
    unknown: Vec<String>,
}

/// The answer about an application.
#[derive(Serialize)]
struct Verdict {
    name: String,
    id: String,
    pid: u32,
    /// Why it is not idle; none if it is.
    reasons: Vec<String>,
}

impl Ready {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let begun = Instant::now();
        let limit = self
            .wait
            .map(|limit| limit.map_or(Duration::MAX, Duration::from_nanos));
        loop {
            let answer = self.ask(context)?;
            if answer.ready || limit.is_none_or(|limit| begun.elapsed() >= limit) {
                return self.print(&answer);
            }
            thread::sleep(POLL);
        }
    }

    fn ask(&self, context: &Context) -> Result<Answer, Failure> {
        let client = context.client(&self.target)?;
        let is_local = matches!(context.reach(&self.target)?, Reach::Local(_));
        let name = context.application_name(&self.target);
        let abouts = client.applications()?;
        let mut unknown: Vec<_> = client.unanswered().into_iter().map(|one| one.reason).collect();
        if name.is_none() && is_local {
            let found = abouts.iter().map(|about| about.pid).collect();
            let processes = env::var_os(PROCESSES).unwrap_or_else(|| "/proc".into());
            unknown.extend(out_of_reach(Path::new(&processes), &found));
        }
        let is_at = self.target.at.iter().any(|endpoint| !endpoint.is_empty());
        if is_at && !self.target.has_typed_endpoint() {
            unknown.push(
                "JDE_AT is set, so this machine was not asked; unset it to ask this machine".to_owned(),
            );
        }
        let mut applications = Vec::new();
        let is_asked = |it: &str| {
            name.as_deref()
                .is_none_or(|name| name.split('@').next() == Some(it))
        };
        for about in abouts.into_iter().filter(|about| is_asked(&about.name)) {
            applications.push(Verdict {
                reasons: self.reasons(&client, &format!("{}@{}", about.name, about.id), is_local)?,
                name: about.name,
                id: about.id,
                pid: about.pid,
            });
        }
        if let Some(name) = name.filter(|_| applications.is_empty()) {
            unknown.push(format!("no application is called `{name}`"));
        }
        let ready = unknown.is_empty() && applications.iter().all(|one| one.reasons.is_empty());
        Ok(Answer {
            ready,
            applications,
            unknown,
        })
    }

    /// Returns why an application is not idle. `is_local` states that it runs on this machine.
    fn reasons(&self, client: &Client, name: &str, is_local: bool) -> Result<Vec<String>, Failure> {
        let asked = client
            .application(Some(name))
            .map_err(Failure::from)
            .and_then(|remote| self.look(&remote));
        match asked {
            Ok(reasons) => Ok(reasons),
            // It may have ended meanwhile, and then it is in nobody's way. Over a network it looks the same if the network is
            // lost.
            Err(Failure::Link(_)) if is_local && !is_running(client, name)? => Ok(Vec::new()),
            Err(Failure::Link(error)) => Ok(vec![error.to_string()]),
            Err(other) => Err(other),
        }
    }

    fn look(&self, remote: &Remote) -> Result<Vec<String>, Failure> {
        // One that has ended stays to be looked at, and a replay moves nothing.
        let before = remote.hierarchy()?;
        if remote.about().executor == "replay" || present(remote)?.1.is_some() {
            return Ok(Vec::new());
        }
        let (schemas, variables) = (remote.schemas()?, remote.variables(false)?);
        let mut reasons = acting(&before, &schemas);
        if reasons.is_empty() {
            if remote.wait_gone(STILL) {
                return Err(jde_link::Error::Disconnected(remote.about().name.clone()).into());
            }
            let after = remote.hierarchy()?;
            reasons = acting(&after, &schemas);
            reasons.extend(changed(&before, &after));
        }
        for variable in &variables {
            let is_mission = variable.type_name == Mission::describe().name;
            if variable.access == "command" {
                let sample = remote.get(&variable.name)?;
                reasons.extend(in_force(variable, &sample));
            } else if variable.access == "export" && is_mission {
                let sample = remote.get(&variable.name)?;
                reasons.extend(under_way(variable, &sample));
            }
        }
        for condition in &self.also {
            if !is_true(remote, condition)? {
                reasons.push(format!("`{condition}` is not true"));
            }
        }
        Ok(reasons)
    }

    fn print(&self, answer: &Answer) -> Result<(), Failure> {
        if self.json {
            print_json(answer)?;
        } else {
            let mut out = terminal::out();
            for one in &answer.applications {
                let (style, text) = match one.reasons.is_empty() {
                    true => (GOOD, "idle".to_owned()),
                    false => (BAD, one.reasons.join("; ")),
                };
                writeln!(out, "{TITLE}{}{TITLE:#}  {style}{text}{style:#}", one.name)?;
            }
            for reason in &answer.unknown {
                writeln!(out, "{BAD}{reason}{BAD:#}")?;
            }
            if answer.applications.is_empty() && answer.ready {
                writeln!(out, "no application runs")?;
            }
            out.flush()?;
        }
        if answer.ready {
            return Ok(());
        }
        Err(Failure::NoMatch("not ready for a reboot or an update".to_owned()))
    }
}

fn is_running(client: &Client, name: &str) -> Result<bool, Failure> {
    let running = client.applications()?;
    // One that gives no answer is not listed, and it runs.
    let is_listed = running
        .iter()
        .any(|about| format!("{}@{}", about.name, about.id) == name);
    Ok(is_listed || !client.unanswered().is_empty())
}

/// Returns which motor schemas act on actuators, and why time stands still.
fn acting(snapshot: &Snapshot, schemas: &Schemas) -> Vec<String> {
    let has_actuator = |name: &str| {
        let info = schemas.schemas.iter().find(|info| info.name == name);
        info.is_none_or(|info| {
            info.ports
                .iter()
                .any(|port| port.role == "actuator" && port.variable.is_some())
        })
    };
    let acts = snapshot.schemas.iter().filter(|schema| {
        schema.kind == Kind::Motor && schema.state == State::Winner && has_actuator(&schema.name)
    });
    let mut reasons: Vec<_> = acts.map(|schema| format!("`{}` acts", schema.name)).collect();
    reasons.extend(
        snapshot
            .standstill
            .iter()
            .map(|why| format!("its time stands still: {why}")),
    );
    reasons
}

/// Returns the groups whose winners changed between two snapshots.
fn changed(before: &Snapshot, after: &Snapshot) -> Vec<String> {
    let pairs = before.groups.iter().zip(&after.groups);
    let changed = pairs.filter(|(before, after)| before.switches != after.switches);
    changed
        .map(|(group, _)| format!("the winner of `{}` has just changed", group.name))
        .collect()
}

/// Says that a command is in force, unless it is neutral.
fn in_force(variable: &VariableInfo, sample: &Sample) -> Option<String> {
    let is_in_force = sample
        .bytes
        .as_deref()
        .is_some_and(|bytes| bytes.iter().any(|byte| *byte != 0));
    is_in_force.then(|| {
        format!(
            "the command `{}` of `{}` is in force",
            variable.name, sample.writer
        )
    })
}

/// Says why a mission may not be over.
fn under_way(variable: &VariableInfo, sample: &Sample) -> Option<String> {
    let name = &variable.name;
    let Some(mission) = sample.bytes.as_deref().and_then(Mission::from_bytes) else {
        return Some(format!(
            "`{name}` has no value: nobody knows whether the mission is over"
        ));
    };
    match mission.state {
        Mission::DONE | Mission::FAILED => None,
        // Without an open target it waits for one.
        Mission::RUNNING if mission.reached >= mission.total => None,
        Mission::RUNNING => Some(format!(
            "`{name}` is under way: {} of {} reached",
            mission.reached, mission.total
        )),
        state => Some(format!("`{name}` has the unknown state {state}")),
    }
}

/// Returns the processes that run an application and were not found: those of other users, and those without a link.
fn out_of_reach(processes: &Path, found: &BTreeSet<u32>) -> Vec<String> {
    let listed = fs::read_dir(processes).and_then(|entries| entries.collect::<Result<Vec<_>, _>>());
    let listed = match listed {
        Ok(listed) => listed,
        Err(error) => return vec![format!("what runs on this machine is not known: {error}")],
    };
    let verbs = Cli::command();
    let ids = listed
        .iter()
        .filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    ids.filter(|id| !found.contains(id))
        .filter_map(|id| {
            let line = fs::read(processes.join(id.to_string()).join("cmdline")).ok()?;
            let verb = running_verb(&line, &verbs)?;
            Some(format!(
                "process {id} runs `jde {verb}` and cannot be asked: another user's, without a link, or in another folder"
            ))
        })
        .collect()
}

/// Returns the verb of a command line of this program, which has these verbs, if it runs an application.
fn running_verb(line: &[u8], verbs: &Command) -> Option<&'static str> {
    let mut words = line.split(|byte| *byte == 0).map(String::from_utf8_lossy);
    let program = words.next()?;
    let is_jde = Path::new(&*program).file_name().is_some_and(|name| name == "jde");
    // An option with a value may come before the verb, and an argument of another verb may look like one.
    let first = words.find(|word| word == "help" || verbs.find_subcommand(&**word).is_some())?;
    RUNNING_VERBS.into_iter().find(|verb| is_jde && *verb == first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::snapshots::navigation;

    #[test]
    fn only_processes_of_this_program_that_run_an_application_count() {
        let verbs = Command::new("jde").subcommands(["run", "demo", "top", "docs", "view"].map(Command::new));
        for (line, verb) in [
            ("/usr/bin/jde\0run\0robot.toml\0", Some("run")),
            ("jde\0--log\0debug\0run\0a.toml\0", Some("run")),
            ("jde\0--quiet\0demo\0", Some("demo")),
            ("jde\0top\0", None),
            ("jde\0docs\0run\0", None),
            ("jde\0view\0demo\0", None),
            ("jde\0help\0run\0", None),
            ("vim\0run\0", None),
            ("", None),
        ] {
            assert_eq!(running_verb(line.as_bytes(), &verbs), verb, "{line:?}");
        }
    }

    #[test]
    fn processes_that_cannot_be_listed_are_not_known() {
        let unknown = out_of_reach(Path::new("/there/is/no/such/folder"), &BTreeSet::new());
        assert!(
            unknown[0].starts_with("what runs on this machine is not known: "),
            "{unknown:?}"
        );
    }

    #[test]
    fn a_winner_with_an_actuator_acts_and_so_does_one_of_which_nothing_is_known() {
        let snapshot = navigation();
        let reasons = acting(&snapshot, &Schemas::default());
        assert!(reasons.contains(&"`vff` acts".to_owned()), "{reasons:?}");
        let mut later = snapshot.clone();
        later.groups[0].switches += 1;
        assert_eq!(
            changed(&snapshot, &later),
            [format!(
                "the winner of `{}` has just changed",
                later.groups[0].name
            )]
        );
    }
}
