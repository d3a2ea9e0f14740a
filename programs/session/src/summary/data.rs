//! The result of a run as data: the object that `--json` prints, and the source of the summary as text.

use std::io;
use std::path::Path;
use std::time::Duration;

use jde_core::{GroupId, Id, SchemaId, State};
use jde_host::Handle;
use jde_records::event::Outcome;
use jde_terminal as terminal;
use jde_timeline::MissionTimeline;
use serde::Serialize;

use crate::failure::display_path;
use crate::run::{RecordingSummary, RunData};

/// The result of a run. Times are in seconds unless a key names another unit.
#[derive(Debug, Serialize)]
pub struct RunSummary {
    /// The name of the application.
    pub application: String,
    /// How the run ended.
    pub outcome: Ending,
    /// The mission's own text, or the reason why the application could not continue.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub note: String,
    /// Whether the application has a mission that can be completed. True also if the mission has published no
    /// progress, or had nothing to do.
    #[serde(skip)]
    pub has_mission: bool,
    /// What the mission counts: "targets", or its own text.
    #[serde(skip)]
    pub counts: String,
    /// The seed.
    pub seed: u64,
    /// Targets of the mission, or whatever else it counts; 0 for a mission without end, `None` without a
    /// mission.
    pub targets: Option<u32>,
    /// Targets reached; `None` without a mission.
    pub reached: Option<u32>,
    /// Contacts with obstacles; `None` without ground truth.
    pub collisions: Option<u64>,
    /// When the first of them began.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_contact_s: Option<f64>,
    /// The least distance to an obstacle; `None` without ground truth.
    pub min_clearance_m: Option<f64>,
    /// How often a motor schema became WINNER.
    pub takeovers: u64,
    /// The longest time from the cause of a takeover to the winner's first iteration; `None` without
    /// takeovers.
    pub worst_takeover_us: Option<f64>,
    /// The length of the run in application time.
    pub sim_seconds: f64,
    /// The length of the run on this machine's clock.
    pub wall_seconds: f64,
    /// SHA-256 of the decisions, one line of JSON each.
    pub decisions_sha256: String,
    /// The recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<RecordingSummary>,
    /// The files that are missing or not complete, and why.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unwritten: Vec<String>,
    /// Output that was not read in time.
    #[serde(skip_serializing_if = "Unread::is_none")]
    pub unread: Unread,
    /// The shares of time that schemas won, by group.
    pub groups: Vec<GroupSummary>,
    /// The counters of each schema.
    pub schemas: Vec<SchemaSummary>,
    /// Whether a schema faulted although the application does not expect it, and no person had it in a debugger.
    #[serde(skip)]
    pub has_unexpected_fault: bool,
}

/// Output that was dropped because its reader was too slow: a robot never waits for a reader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Unread {
    /// Lines of standard output.
    pub output_lines: u64,
    /// Lines of the log.
    pub log_lines: u64,
    /// Decisions for the file of `--decisions`.
    pub decisions: u64,
    /// Events that are missing in this summary.
    pub events: u64,
}

impl Unread {
    fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// The mission is done.
    Done,
    /// The mission failed.
    Failed,
    /// The time limit was reached.
    TimeUp,
    /// The run was asked to stop.
    Stopped,
    /// The application could not continue.
    Broken,
}

/// The shares of time that the members of a group won.
#[derive(Debug, Serialize)]
pub struct GroupSummary {
    /// The name of the group.
    pub group: String,
    /// The members, in the father's order.
    pub winners: Vec<Share>,
    /// Time without a winner while the father was WINNER; for the roots, during the whole run.
    pub nobody_seconds: f64,
    /// The longest takeover; `None` without takeovers.
    pub worst_takeover_us: Option<f64>,
    /// The longest takeover that the contract allows (R17).
    pub allowed_takeover_us: f64,
    /// The takeovers that took longer, and not because of the machine (R17).
    pub late_takeovers: u64,
}

/// How long a schema was WINNER.
#[derive(Debug, Serialize)]
pub struct Share {
    /// The name of the schema.
    pub schema: String,
    /// Time as WINNER.
    pub seconds: f64,
    /// The share of the whole run, 0 to 1.
    pub share: f64,
    /// How often it became WINNER.
    pub takeovers: u64,
}

/// The counters of a schema.
#[derive(Debug, Serialize)]
pub struct SchemaSummary {
    /// The name of the schema.
    pub schema: String,
    /// Iterations.
    pub iterations: u64,
    /// Missed deadlines and exceeded budgets.
    pub overruns: u64,
    /// Refused commands and wakes.
    pub refused: u64,
    /// What was refused, and why: the first different ones.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub refusals: Vec<String>,
    /// Triggers that were dropped or had to rest.
    pub triggers_dropped: u64,
    /// Faults.
    pub faults: u64,
    /// In lockstep: turns that took longer than the budget by the machine's clock.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slow: Option<SlowTurns>,
}

/// Turns that would overrun in real time.
#[derive(Debug, Serialize)]
pub struct SlowTurns {
    /// How many.
    pub turns: u64,
    /// The longest of them, ms.
    pub longest_ms: f64,
    /// The budget, ms.
    pub budget_ms: f64,
}

impl RunSummary {
    /// Sums up a run that has ended.
    pub fn new(
        handle: &Handle,
        kept: &RunData,
        outcome: &Outcome,
        wall: Duration,
        decisions_sha256: String,
        recording: Option<RecordingSummary>,
    ) -> Self {
        let application = handle.application();
        let mission = kept.drive.mission.newest();
        let groups = application.groups.ids();
        let groups: Vec<_> = groups.map(|group| group_summary(handle, kept, group)).collect();
        let note = match outcome {
            Outcome::Broken(reason) => reason.clone(),
            Outcome::Done | Outcome::Failed | Outcome::TimeUp | Outcome::Stopped => {
                mission.map_or(String::new(), |mission| mission.note.to_string())
            }
        };
        let worst = groups
            .iter()
            .filter_map(|group| group.worst_takeover_us)
            .reduce(f64::max);
        let schemas = handle.snapshot().schemas;
        let mut faulted = schemas.iter().zip(application.instances.iter());
        let has_fault = faulted.any(|(schema, instance)| schema.faults > 0 && !instance.debugged);
        let schemas = schemas.into_iter();
        let [output_lines, log_lines] = terminal::lost();
        Self {
            application: application.name.clone(),
            outcome: match outcome {
                Outcome::Done => Ending::Done,
                Outcome::Failed => Ending::Failed,
                Outcome::TimeUp => Ending::TimeUp,
                Outcome::Stopped => Ending::Stopped,
                Outcome::Broken(_) => Ending::Broken,
            },
            note,
            has_mission: application.mission.is_some()
                && mission.is_none_or(|mission| mission.total > 0 || !has_task(&kept.drive.mission)),
            counts: match mission {
                Some(mission) if !kept.drive.mission.has_places() && !mission.note.is_empty() => {
                    mission.note.to_string()
                }
                Some(_) | None => "targets".to_owned(),
            },
            seed: application.seed,
            targets: mission.map(|mission| mission.total),
            reached: mission.map(|mission| mission.reached),
            collisions: kept.drive.collisions(),
            first_contact_s: kept.drive.first_contact().map(seconds),
            min_clearance_m: kept.drive.min_clearance(),
            takeovers: kept.timeline.takeovers(),
            worst_takeover_us: worst,
            sim_seconds: seconds(kept.end_time),
            wall_seconds: wall.as_secs_f64(),
            decisions_sha256,
            recording,
            unwritten: Vec::new(),
            unread: Unread {
                output_lines,
                log_lines,
                decisions: kept.unread,
                events: kept.missed,
            },
            groups,
            schemas: schemas
                .enumerate()
                .map(|(number, schema)| SchemaSummary {
                    refusals: kept.timeline.schemas()[number].refusals.clone(),
                    schema: schema.name,
                    iterations: schema.iterations,
                    overruns: schema.overruns,
                    refused: schema.refused,
                    triggers_dropped: schema.triggers_dropped,
                    faults: schema.faults,
                    slow: (schema.slow_turns > 0).then(|| SlowTurns {
                        turns: schema.slow_turns,
                        longest_ms: schema.slowest_turn as f64 / 1e6,
                        budget_ms: application.instances[SchemaId::new(number)].budget_ns as f64 / 1e6,
                    }),
                })
                .collect(),
            has_unexpected_fault: has_fault && !application.ignores_faults,
        }
    }

    /// Adds a file that is not complete.
    pub fn add_unwritten(&mut self, file: &Path, error: &io::Error) {
        self.unwritten
            .push(format!("{} is not complete: {error}", display_path(file)));
    }

    /// How many takeovers took longer than their contracts permit (R17).
    pub fn late_takeovers(&self) -> u64 {
        self.groups.iter().map(|group| group.late_takeovers).sum()
    }

    /// Whether the run was asked to end.
    pub fn was_stopped(&self) -> bool {
        self.outcome == Ending::Stopped
    }

    /// Whether the run achieved its purpose: its mission is done, or it has none and neither failed nor
    /// broke.
    pub fn is_fulfilled(&self) -> bool {
        match self.outcome {
            Ending::Done => true,
            Ending::TimeUp => !self.has_mission,
            // A person may stop one that waits for a target.
            Ending::Stopped => !self.has_mission || self.targets == Some(0),
            Ending::Failed | Ending::Broken => false,
        }
    }
}

/// Whether a mission without a total had anything to do: a place, a count, or words of its own.
fn has_task(mission: &MissionTimeline) -> bool {
    let newest = mission.newest();
    mission.has_places() || newest.is_some_and(|newest| newest.reached > 0 || !newest.note.is_empty())
}

fn group_summary(handle: &Handle, kept: &RunData, id: GroupId) -> GroupSummary {
    let application = handle.application();
    let group = &application.groups[id];
    let known = &kept.timeline.groups()[id.index()];
    let schemas = kept.timeline.schemas();
    let won = |schema: SchemaId| schemas[schema.index()].time_in(State::Winner, kept.end_time);
    let open = group.father.map_or(kept.end_time, won);
    let by_members: u64 = group.members.iter().map(|member| won(*member)).sum();
    GroupSummary {
        group: group.name.clone(),
        winners: group
            .members
            .iter()
            .map(|member| Share {
                schema: application.instances[*member].name.clone(),
                seconds: seconds(won(*member)),
                share: won(*member) as f64 / kept.end_time.max(1) as f64,
                takeovers: schemas[member.index()].counts.takeovers,
            })
            .collect(),
        nobody_seconds: seconds(open.saturating_sub(by_members)),
        worst_takeover_us: known.counts.worst.map(|worst| worst as f64 / 1e3),
        allowed_takeover_us: handle.snapshot().groups[id.index()].allowed as f64 / 1e3,
        late_takeovers: known.counts.late,
    }
}

fn seconds(nanos: u64) -> f64 {
    nanos as f64 / 1e9
}
