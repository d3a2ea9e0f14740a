//! `jde record`: records a running application from another process or machine.

use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use clap::{Args, ValueHint};
use clap_complete::ArgValueCompleter;
use jde_abi::describe::Type;
use jde_conditions::{Condition, Names, Triggers};
use jde_core::Nanos;
use jde_link::message::{Schemas, VariableInfo};
use jde_link::{Rate, Remote, Subscription};
use jde_log::Selection;
use jde_recorder::{Origin, Recorder, RecorderOptions, Stamps, Topic};
use jde_records::event::{StateChange, What};
use jde_records::snapshot::Snapshot;
use jde_records::{RecordKind, RunRecord};
use jde_session::summary;
use jde_terminal::interrupt::SignalListener;
use jde_terminal::{self as terminal, FAINT, WARN};

use super::rate_limiter::RateLimiter;
use super::{Context, Target};
use crate::cli::tools::recording::SplitArgs;
use crate::complete;
use crate::extensions::{
    PanelOptions, TriggerWindow, condition_failure, parse_triggers, recording_failure, recording_summary,
    report_trouble,
};
use crate::failure::{Failure, display_path};
use crate::quantity;

/// Number of earlier lines of each kind that are recorded as well. They contain the reasons for the current
/// winners.
const MAX_EARLIER: usize = 1000;
/// The interval of progress messages on a terminal.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(500);

/// Record a running application from this process: variables, selections and events, like `jde run --record`.
///
/// Ends at Ctrl-C, after --for, or with the application. Data that arrives faster than the network or this
/// machine can take is lost; the losses are counted and reported. A recording made by `jde run --record` on
/// the robot loses less, and only such a recording can be replayed decision by decision.
#[derive(Args)]
#[command(after_help = "Examples:
  jde record drive.mcap
  jde record laser.mcap 'pioneer.laser' '*.mission' --for 60s
  jde record drive.mcap --when conflict --when 'pioneer.laser.ranges.exists(r, r < 0.3)'
  jde record drive.mcap --split 10min --keep 20GB
  jde record drive.mcap --panels=example
  jde record drive.mcap --app robot2 --at tcp/robot2:7447")]
pub(crate) struct Record {
    /// The recording to write.
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// Record only the variables that match: full names with * for any text.
    #[arg(value_name = "PATTERN", add = ArgValueCompleter::new(complete::variables))]
    only: Vec<String>,
    #[command(flatten)]
    target: Target,
    /// End after this time.
    #[arg(long = "for", value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    time: Option<Nanos>,
    /// Overwrite an existing recording.
    #[arg(long)]
    overwrite: bool,
    /// End at the end of standard input, and so with the process that started this one, even if that is killed.
    #[arg(long, hide = true)]
    until_eof: bool,
    #[command(flatten)]
    panels: Option<PanelOptions>,
    #[command(flatten)]
    trigger: Option<TriggerWindow>,
    #[command(flatten)]
    splitting: SplitArgs,
}

impl Record {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let split = self.splitting.into_split()?;
        let (remote, patterns) = context.resolve_all(&self.target, &self.only)?;
        let variables = remote.variables(false)?;
        let names: Vec<_> = variables.iter().map(|variable| variable.name.clone()).collect();
        let selection = Selection::new(patterns, &names)
            .map_err(|unknown| Failure::usage(unknown.to_string(), "`jde vars` lists the variables"))?;
        // Check the panels before the file is created, because that may overwrite another one.
        let panels = self.panels.map(|panels| resolve_panels(&remote, panels));
        let panels = panels.transpose()?;
        let options = options(&remote, display_path(&self.file), self.overwrite);
        let is_triggered = self.trigger.is_some();
        let recorder = match (self.trigger, split) {
            (Some(trigger), _) => {
                let names = condition_names(&remote, &variables)?;
                let mut trigger = parse_triggers(&trigger, names)?;
                process_states(&mut trigger.triggers, &remote.hierarchy()?);
                Recorder::create_triggered(&self.file, options, trigger)
            }
            (None, Some(split)) => Recorder::create_split(&self.file, options, split),
            (None, None) => Recorder::create(&self.file, options),
        };
        let recorder = recorder.map_err(|error| recording_failure(error, &self.file))?;
        let recorder = Arc::new(recorder);
        let mut subscriptions = Vec::with_capacity(variables.len() + 1);
        let mut recorded_variables = 0;
        for variable in &variables {
            let topic = if selection.contains(&variable.name) {
                recorded_variables += 1;
                Some(recorder.topic(
                    &jde_log::topic_name(&variable.name),
                    value_type(variable)?,
                    metadata(variable),
                ))
            } else {
                recorder.condition_topic(&variable.name, value_type(variable)?)
            };
            if let Some(topic) = topic {
                subscriptions.push(watch(&remote, variable, topic)?);
            }
        }
        if let Some((names, rate)) = panels {
            for name in names {
                subscriptions.push(watch_panel(&remote, &recorder, &name, rate)?);
            }
        }
        let recorder_of_events = Arc::clone(&recorder);
        let has_ended = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&has_ended);
        // The application's clock starts with the application, but the recording starts now.
        let beginning = remote.hierarchy()?.time;
        subscriptions.push(remote.events(&RecordKind::ALL, MAX_EARLIER, move |event| {
            if matches!(event.record.what(), Some(What::Ended { .. })) {
                ended.store(true, Ordering::Relaxed);
            }
            if event.record.time() < beginning {
                recorder_of_events.push_earlier_record(event.record, beginning);
            } else {
                recorder_of_events.push_record(event.record);
            }
        })?);
        let end = self.time.map(|time| Instant::now() + Duration::from_nanos(time));
        let limit = Limit {
            end,
            until_eof: self.until_eof,
        };
        wait_for_end(&remote, &recorder, recorded_variables, &limit, is_triggered)?;
        drop(subscriptions);
        let recorded = recording_summary(&self.file, is_triggered, recorder.finish());
        let mut out = terminal::out();
        summary::print_recording(&recorded, &mut out)?;
        let status = recorder.status();
        for (topic, lost) in &status.lost_by_topic {
            writeln!(out, "  {topic}: {lost} lost")?;
        }
        if status.lost > 0 {
            let all = status.lost.saturating_add(status.written);
            writeln!(
                out,
                "{WARN}{} of {all} messages were lost{WARN:#}; `jde run --record` on the robot loses less, and so do fewer variables",
                status.lost
            )?;
        }
        out.flush()?;
        recorded.check_complete()?;
        if remote.is_alive() || has_ended.load(Ordering::Relaxed) {
            return Ok(());
        }
        Err(jde_link::Error::Disconnected(remote.about().name.clone()).into())
    }
}

fn options(remote: &Remote, named: String, overwrite: bool) -> RecorderOptions<'static> {
    let about = remote.about();
    RecorderOptions {
        origin: Origin {
            application: about.application.clone(),
            seed: 0,
            started: SystemTime::UNIX_EPOCH + Duration::from_nanos(about.started_ns),
            // The application's file may be on another machine.
            folder: None,
            file: None,
            hierarchy: None,
        },
        application: None,
        overwrite,
        lossless: false,
        on_trouble: report_trouble(named),
    }
}

/// Returns the names that conditions may contain.
fn condition_names(remote: &Remote, variables: &[VariableInfo]) -> Result<Names, Failure> {
    let Schemas { schemas, groups } = remote.schemas()?;
    let types = variables
        .iter()
        .map(|variable| Ok((variable.name.clone(), value_type(variable)?)));
    Ok(Names {
        seed: None,
        schemas: schemas.into_iter().map(|schema| schema.name).collect(),
        groups: groups.into_iter().map(|group| group.name).collect(),
        variables: types.collect::<Result<_, Failure>>()?,
    })
}

/// Returns whether a condition is true now. Without a value of a variable that it names it is not.
///
/// # Errors
/// Wrong use if it waits for an event or counts events since the start: whoever asks now has seen none of them.
pub(super) fn is_true(remote: &Remote, condition: &str) -> Result<bool, Failure> {
    let names = condition_names(remote, &remote.variables(false)?)?;
    let condition = Condition::new(condition, &names).map_err(condition_failure)?;
    let mut triggers = Triggers::new(names, vec![condition]);
    if let Some(unknown) = triggers.unknown_to_late() {
        return Err(Failure::usage(
            format!("`{unknown}` is an event or counts events since the start, which is not known now"),
            "name variables, or the state of a schema: dock.docking.state == 1",
        ));
    }
    let hierarchy = remote.hierarchy()?;
    process_states(&mut triggers, &hierarchy);
    let variables: Vec<String> = triggers.variables().into_iter().map(str::to_owned).collect();
    let mut fired = Vec::new();
    for variable in variables {
        if let Some(bytes) = remote.get(&variable)?.bytes {
            triggers.process_value(hierarchy.time, &variable, &bytes, &mut fired);
        }
    }
    // The last value may be too near to the one before to be evaluated at once.
    triggers.advance(hierarchy.time + 1_000_000_000, &mut fired);
    Ok(!fired.is_empty())
}

/// Passes the present states to the conditions. They make no condition true.
fn process_states(triggers: &mut Triggers, hierarchy: &Snapshot) {
    for schema in &hierarchy.schemas {
        let state = StateChange {
            time: hierarchy.time,
            schema: schema.name.clone(),
            from: schema.state,
            to: schema.state,
        };
        triggers.process_record(&RunRecord::State(state), &mut Vec::new());
    }
}

/// What ends a recording besides Ctrl-C and the application's end.
struct Limit {
    /// A time.
    end: Option<Instant>,
    /// The end of standard input.
    until_eof: bool,
}

/// Waits until the recording has to end.
fn wait_for_end(
    remote: &Remote,
    recorder: &Recorder,
    variables: usize,
    limit: &Limit,
    is_triggered: bool,
) -> Result<(), Failure> {
    let (sender, receiver) = channel();
    let _interrupts = {
        let sender = sender.clone();
        SignalListener::on_first(move || {
            let _ = sender.send(());
        })?
    };
    if limit.until_eof {
        let sender = sender.clone();
        // The thread is not joined. It ends at the latest with the process.
        thread::Builder::new().name("stdin".to_owned()).spawn(move || {
            // The end of the input and an error both mean that the recording is to end.
            let _ = io::copy(&mut io::stdin().lock(), &mut io::sink());
            let _ = sender.send(());
        })?;
    }
    remote.on_gone(move || {
        let _ = sender.send(());
    });
    // The recording must not wait for a reader of the progress messages.
    let _no_waiting = terminal::never_block();
    let mut out = terminal::err();
    let live = terminal::is_interactive();
    let name = &remote.about().name;
    writeln!(
        out,
        "{FAINT}recording {variables} variables of {name}{}, until Ctrl-C{FAINT:#}",
        if is_triggered {
            " when a condition becomes true"
        } else {
            ""
        }
    )?;
    let start = Instant::now();
    loop {
        let wait = limit.end.map_or(PROGRESS_INTERVAL, |end| {
            end.saturating_duration_since(Instant::now())
                .min(PROGRESS_INTERVAL)
        });
        let status = recorder.status();
        if wait.is_zero() || (!is_triggered && status.error.is_some()) {
            break;
        }
        if live {
            out.write_all(b"\r")?;
            write!(
                out,
                "{FAINT}{:>6.1} s  {} messages  {:.1} MB  {} lost{FAINT:#} ",
                start.elapsed().as_secs_f64(),
                status.written,
                status.bytes as f64 / 1e6,
                status.lost
            )?;
            out.flush()?;
        }
        match receiver.recv_timeout(wait) {
            Err(RecvTimeoutError::Timeout) => {}
            Ok(()) | Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    if live {
        writeln!(out)?;
    }
    if !remote.is_alive() {
        writeln!(out, "{name} is gone, and the recording ends with it")?;
    }
    Ok(())
}

/// Records every value of a variable in a topic.
fn watch(remote: &Remote, variable: &VariableInfo, topic: Topic) -> Result<Subscription, Failure> {
    let mut last = None;
    let watching = remote.watch(&variable.name, Rate::Full, move |sample| {
        let published = sample.time.saturating_add(sample.age);
        let Some(bytes) = &sample.bytes else {
            // Without an earlier value there is none to retract.
            if last.is_some() {
                topic.retract(published);
            }
            return;
        };
        // The sequence numbers of another application need not increase.
        let missed = last.map_or(0, |last| sample.sequence.saturating_sub(last).saturating_sub(1));
        topic.add_lost(missed);
        last = Some(sample.sequence);
        let stamps = Stamps {
            published,
            measured: sample.time,
            sequence: sample.sequence,
        };
        topic.put(bytes, stamps);
    })?;
    Ok(watching)
}

/// Returns the schemas whose panels to record, and the rate.
fn resolve_panels(remote: &Remote, panels: PanelOptions) -> Result<(Vec<String>, f64), Failure> {
    let schemas = remote.schemas()?.schemas.into_iter();
    let names: Vec<_> = schemas
        .filter(|schema| schema.panel)
        .map(|schema| schema.name)
        .collect();
    let indices = panels.select_names(&names)?.into_iter();
    Ok((
        indices.map(|index| names[index].clone()).collect(),
        panels.panel_rate,
    ))
}

/// Records a panel in a topic.
fn watch_panel(
    remote: &Remote,
    recorder: &Recorder,
    schema: &str,
    rate: f64,
) -> Result<Subscription, Failure> {
    let topic = recorder.panel(schema);
    let offered = Rate::at_least(rate);
    let mut limiter = RateLimiter::new(rate, offered);
    let watching = remote.watch_panel(schema, offered, move |sample| {
        if limiter.accept(sample.time) {
            let stamps = Stamps {
                published: sample.time.saturating_add(sample.age),
                measured: sample.time,
                sequence: sample.sequence,
            };
            topic.put_panel(&sample.list, stamps);
        }
    })?;
    Ok(watching)
}

fn value_type(variable: &VariableInfo) -> Result<Arc<Type>, Failure> {
    let read = variable
        .value_type()
        .map_err(|error| Failure::broken(format!("the type of `{}` cannot be read: {error}", variable.name)));
    Ok(Arc::new(read?))
}

/// Returns a variable's metadata for the recording.
fn metadata(variable: &VariableInfo) -> BTreeMap<String, String> {
    BTreeMap::from([
        ("variable".to_owned(), variable.name.clone()),
        ("access".to_owned(), variable.access.clone()),
        ("doc".to_owned(), variable.doc.clone()),
        ("unit".to_owned(), variable.unit.clone()),
    ])
}
