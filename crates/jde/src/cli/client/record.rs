//! `jde record`: records an application that runs elsewhere, from here.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant, SystemTime};

use clap::{Args, ValueHint};
use clap_complete::ArgValueCompleter;
use jde_core::Nanos;
use jde_host::story::Kind;
use jde_link::message::VariableInfo;
use jde_link::{Rate, Remote, Watching};
use jde_log::{Options, Origin, Recorder, Selection, Stamps};

use super::{Context, Target};
use crate::attached::name::split_application;
use crate::cli::quantity;
use crate::complete;
use crate::failure::{Failure, shown};
use crate::interrupt::Interrupts;
use crate::terminal::{self, BAD, FAINT, TITLE};

/// Lines of each kind that happened before and are kept as well: why who acts now was chosen.
const EARLIER: usize = 1000;
/// How often progress is told on a terminal.
const TELL: Duration = Duration::from_millis(500);

/// Record a running application from here: variables, selections and events, as `jde run --record` does it there.
///
/// Ends at Ctrl-C, after --for, or with the application. What the network or this machine is too slow for is lost, counted and
/// said; a recording made by `jde run --record` on the robot loses less, and only that can be replayed decision by decision.
#[derive(Args)]
#[command(after_help = "Examples:
  jde record drive.mcap
  jde record laser.mcap 'pioneer.laser' '*.mission' --for 60s
  jde record drive.mcap --app robot2 --at tcp/robot2:7447")]
pub(crate) struct Record {
    /// The file.
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// Only variables like these: full names with * for any letters.
    #[arg(value_name = "PATTERN", add = ArgValueCompleter::new(complete::variables))]
    only: Vec<String>,
    #[command(flatten)]
    target: Target,
    /// End after this time.
    #[arg(long = "for", value_name = "TIME", value_parser = quantity::time)]
    time: Option<Nanos>,
    /// Write over a recording that is there.
    #[arg(long)]
    overwrite: bool,
}

impl Record {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let mut named = None;
        let patterns = self.only.iter().map(|pattern| {
            let (application, pattern) = split_application(pattern);
            named = application.or(named);
            pattern.to_owned()
        });
        let patterns: Vec<_> = patterns.collect();
        let remote = context.remote(&self.target, named)?;
        let mut variables = remote.variables(false)?;
        let names: Vec<_> = variables.iter().map(|variable| variable.name.clone()).collect();
        let selection = Selection::new(patterns, &names)
            .map_err(|unknown| Failure::usage(unknown.to_string(), "`jde vars` lists the variables"))?;
        variables.retain(|variable| selection.has(&variable.name));
        let recorder = Arc::new(self.begin(&remote)?);
        let mut watching = Vec::with_capacity(variables.len() + 1);
        for variable in &variables {
            watching.push(watch(&remote, variable, &recorder)?);
        }
        let story = Arc::clone(&recorder);
        watching.push(remote.events(&Kind::ALL, EARLIER, move |happened| {
            story.line(happened.line);
        })?);
        self.wait(&remote, &recorder, variables.len())?;
        drop(watching);
        let status = recorder.finish();
        let mut out = terminal::out();
        writeln!(
            out,
            "recorded {TITLE}{}{TITLE:#}: {} messages, {:.1} MB, {}",
            shown(&self.file),
            status.kept,
            status.bytes as f64 / 1e6,
            match status.lost {
                0 => String::from("nothing lost"),
                lost => format!("{BAD}{lost} lost{BAD:#}"),
            }
        )?;
        for (topic, lost) in &status.lost_of {
            writeln!(out, "  {topic}: {lost} lost")?;
        }
        match status.trouble {
            Some(trouble) => Err(Failure::Broken(format!(
                "{} ends too soon: {trouble}",
                shown(&self.file)
            ))),
            None => Ok(()),
        }
    }

    fn begin(&self, remote: &Remote) -> Result<Recorder, Failure> {
        let about = remote.about();
        let options = Options {
            origin: Origin {
                application: about.application.clone(),
                seed: 0,
                started: SystemTime::UNIX_EPOCH + Duration::from_nanos(about.started_ns),
                // Its file is on its own machine.
                folder: None,
                file: None,
            },
            application: None,
            overwrite: self.overwrite,
            lossless: false,
            on_trouble: Box::new(|trouble| tracing::error!("the recording ends here: {trouble}")),
        };
        Recorder::create(&self.file, options).map_err(|error| crate::session::no_recording(error, &self.file))
    }

    /// Goes on until it is to end.
    fn wait(&self, remote: &Remote, recorder: &Recorder, variables: usize) -> Result<(), Failure> {
        let (tell, told) = channel();
        let _interrupts = {
            let tell = tell.clone();
            Interrupts::call(move || {
                let _ = tell.send(());
            })?
        };
        remote.on_gone(move || {
            let _ = tell.send(());
        });
        let end = self.time.map(|time| Instant::now() + Duration::from_nanos(time));
        let mut out = terminal::err();
        let live = terminal::is_interactive();
        let name = &remote.about().name;
        writeln!(
            out,
            "{FAINT}recording {variables} variables of {name}, until Ctrl-C{FAINT:#}"
        )?;
        let start = Instant::now();
        loop {
            let left = end.map_or(TELL, |end| {
                end.saturating_duration_since(Instant::now()).min(TELL)
            });
            let status = recorder.status();
            if left.is_zero() || status.trouble.is_some() {
                break;
            }
            if live {
                write!(
                    out,
                    "\r{FAINT}{:>6.1} s  {} messages  {:.1} MB  {} lost{FAINT:#} ",
                    start.elapsed().as_secs_f64(),
                    status.kept,
                    status.bytes as f64 / 1e6,
                    status.lost
                )?;
                out.flush()?;
            }
            match told.recv_timeout(left) {
                Err(RecvTimeoutError::Timeout) => {}
                Ok(()) | Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        if live {
            writeln!(out)?;
        }
        if !remote.alive() {
            writeln!(out, "{name} is gone, and the recording ends with it")?;
        }
        Ok(())
    }
}

/// Has every value of a variable go to a topic of the recording.
fn watch(remote: &Remote, variable: &VariableInfo, recorder: &Recorder) -> Result<Watching, Failure> {
    let value_type = variable.value_type().map_err(|error| {
        Failure::Broken(format!("the type of `{}` cannot be read: {error}", variable.name))
    })?;
    let about = BTreeMap::from([
        ("variable".to_owned(), variable.name.clone()),
        ("access".to_owned(), variable.access.clone()),
        ("doc".to_owned(), variable.doc.clone()),
        ("unit".to_owned(), variable.unit.clone()),
    ]);
    let topic = recorder.topic(&jde_log::topic_name(&variable.name), Arc::new(value_type), about);
    let mut last = None;
    let watching = remote.watch(&variable.name, Rate::Full, move |sample| {
        let Some(bytes) = &sample.bytes else { return };
        if let Some(last) = last
            && sample.sequence > last + 1
        {
            topic.lose(sample.sequence - last - 1);
        }
        last = Some(sample.sequence);
        let stamps = Stamps {
            published: sample.time.saturating_add(sample.age),
            measured: sample.time,
            sequence: sample.sequence,
        };
        topic.put(bytes, stamps);
    })?;
    Ok(watching)
}
