//! `jde watch`: prints or plots values as they arrive.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_link::value::to_json;
use jde_link::{Rate, Remote, Sample, Subscription};
use jde_session::cli::print_json;
use jde_terminal::interrupt::SignalListener;
use jde_terminal::queue::{Popped, Queue};
use jde_terminal::{self as terminal, FAINT, WARN};
use serde_json::json;

use super::{Context, Target};
use crate::complete;
use crate::failure::Failure;
use crate::quantity;
use crate::remote::field::VariableField;
use crate::remote::name;
use crate::strip_chart;

/// The rate of values for a plot: at least two for each redraw.
const PLOT_RATE: Rate = Rate::Hz(50);
/// The most values that may wait to be shown: a few seconds of the fastest variable. Beyond that, the oldest
/// are dropped, counted and reported.
const MAX_QUEUED: usize = 4096;

/// Show values of variables or of their fields as they arrive.
#[derive(Args)]
#[command(after_help = "Examples:
  jde watch pioneer.odometry.pose.pose.position.x --rate 2
  jde watch example.mission --count 1 --json
  jde watch --plot pioneer.odometry.twist.twist.linear.x pioneer.velocity.linear.x")]
pub(crate) struct Watch {
    /// The variables: SCHEMA.VARIABLE, with .FIELD after it and APP: before it if needed.
    #[arg(value_name = "VARIABLE", required = true, add = ArgValueCompleter::new(complete::variables))]
    variables: Vec<String>,
    #[command(flatten)]
    target: Target,
    /// Show at most this many values of each variable per second, the newest ones. By default, every value.
    #[arg(long, value_name = "HZ", value_parser = quantity::rate)]
    rate: Option<f64>,
    /// End after this many values.
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    /// Plot numbers over time.
    #[arg(long, conflicts_with_all = ["json", "count"])]
    plot: bool,
    /// Print each value as one line of JSON.
    #[arg(long)]
    json: bool,
}

/// Input from the subscriptions and signals.
struct WatchInput {
    /// Values, with the index of their variable.
    samples: Arc<Queue<(usize, Sample)>>,
    /// The first application that is gone.
    gone: Arc<OnceLock<String>>,
    interrupted: Arc<AtomicBool>,
}

/// A watched variable.
struct WatchedVariable {
    application: String,
    variable: String,
    part: VariableField,
}

impl Watch {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        if self.plot && !terminal::is_interactive() {
            return Err(Failure::usage(
                "--plot needs a terminal",
                "omit it, or give --json, to watch in a pipe",
            ));
        }
        let input = WatchInput {
            samples: Queue::new(MAX_QUEUED),
            gone: Arc::default(),
            interrupted: Arc::default(),
        };
        let rate = match (self.rate, self.plot) {
            (Some(hz), _) => Rate::at_least(hz),
            (None, true) => PLOT_RATE,
            (None, false) => Rate::Full,
        };
        let mut watched = Vec::new();
        let mut subscriptions = Vec::new();
        for requested in &self.variables {
            let (remote, requested) = context.resolve(&self.target, requested)?;
            let (variable, subscription) = self.subscribe(&remote, requested, watched.len(), rate, &input)?;
            watched.push(variable);
            subscriptions.push(subscription);
        }
        let _interrupts = {
            let (interrupted, samples) = (Arc::clone(&input.interrupted), Arc::clone(&input.samples));
            SignalListener::on_first(move || {
                interrupted.store(true, Ordering::Relaxed);
                samples.close();
            })?
        };
        if self.plot {
            return self.draw(&watched, input);
        }
        self.print_values(&watched, &input)
    }

    fn subscribe(
        &self,
        remote: &Remote,
        requested: &str,
        number: usize,
        rate: Rate,
        input: &WatchInput,
    ) -> Result<(WatchedVariable, Subscription), Failure> {
        let known = remote.variables(false)?;
        let (variable, path) =
            name::split_variable(requested, known.iter().map(|known| known.name.as_str()))?;
        let info = remote.variable(variable)?;
        let part = VariableField::resolve(&info, path)?;
        if self.plot && !part.is_number() {
            return Err(Failure::usage(
                format!("`{requested}` is not a number, and only numbers are drawn"),
                format!("name a field, such as {requested}.FIELD; `jde get {variable}` shows them"),
            ));
        }
        let application = remote.about().name.clone();
        remote.on_gone({
            let (application, gone) = (application.clone(), Arc::clone(&input.gone));
            let samples = Arc::clone(&input.samples);
            move || {
                // Only the first one is reported.
                let _ = gone.set(application);
                samples.close();
            }
        });
        let samples = Arc::clone(&input.samples);
        let watch = remote.watch(variable, rate, move |sample| samples.push((number, sample)))?;
        let watched = WatchedVariable {
            application,
            variable: variable.to_owned(),
            part,
        };
        Ok((watched, watch))
    }

    fn print_values(&self, watched: &[WatchedVariable], input: &WatchInput) -> Result<(), Failure> {
        let mut remaining = self.count;
        while remaining != Some(0) {
            let next = input.samples.pop();
            if input.interrupted.load(Ordering::Relaxed) {
                return Ok(());
            }
            let Some(((number, sample), missed)) = next else {
                break;
            };
            self.print_value(&watched[number], watched.len() > 1, &sample, missed)?;
            remaining = remaining.map(|remaining| remaining - 1);
        }
        match input.gone.get() {
            Some(name) if remaining != Some(0) => Err(jde_link::Error::Disconnected(name.clone()).into()),
            Some(_) | None => Ok(()),
        }
    }

    fn print_value(
        &self,
        watched: &WatchedVariable,
        several: bool,
        sample: &Sample,
        missed: u64,
    ) -> Result<(), Failure> {
        let part = &watched.part;
        // An element past the end of a list has no value.
        let value = sample.bytes.as_deref().and_then(|bytes| part.decode(bytes).ok());
        if self.json {
            return Ok(print_json(&json!({
                "application": watched.application,
                "variable": watched.variable,
                "name": part.name(),
                "unit": part.unit,
                "time_s": sample.time as f64 / 1e9,
                "sequence": sample.sequence,
                "writer": sample.writer,
                "value": value.as_ref().map(to_json),
                "missed": missed,
            }))?);
        }
        let mut out = terminal::out();
        if missed > 0 {
            writeln!(
                out,
                "{WARN}{missed} values were missed{WARN:#}: they were not read in time"
            )?;
        }
        write!(out, "{FAINT}{:>9.3} s{FAINT:#}  ", sample.time as f64 / 1e9)?;
        if several {
            write!(out, "{}  ", part.name())?;
        }
        match value {
            Some(value) => writeln!(out, "{}", part.format_value(value))?,
            None => writeln!(out, "{FAINT}no value{FAINT:#}")?,
        }
        out.flush()?;
        Ok(())
    }

    fn draw(&self, watched: &[WatchedVariable], input: WatchInput) -> Result<(), Failure> {
        let names = watched.iter().map(|watched| match watched.part.unit.as_str() {
            "" => watched.part.name().to_owned(),
            unit => format!("{} [{unit}]", watched.part.name()),
        });
        let mut applications: Vec<_> = watched
            .iter()
            .map(|watched| watched.application.as_str())
            .collect();
        applications.dedup();
        let mut source = PlotSource {
            input,
            watched,
            several: applications.len() > 1,
            start: Instant::now(),
        };
        strip_chart::run(&applications.join(", "), names.collect(), &mut source)?;
        Ok(())
    }
}

/// Values that arrive for a plot.
struct PlotSource<'w> {
    input: WatchInput,
    watched: &'w [WatchedVariable],
    /// Whether the variables are of several applications.
    several: bool,
    start: Instant,
}

impl strip_chart::NumberSource for PlotSource<'_> {
    fn take_samples(&mut self) -> Vec<strip_chart::TracePoint> {
        let mut samples = Vec::new();
        // Ignore how many values were dropped: they arrived between two redraws and would not be visible.
        while let Popped::Next {
            item: (trace, sample),
            ..
        } = self.input.samples.try_pop()
        {
            let number = sample
                .bytes
                .as_deref()
                .and_then(|bytes| self.watched[trace].part.decode_number(bytes));
            let time = if self.several {
                // Each application's clock starts with it. Use the common time since the start of this
                // command.
                self.start.elapsed().as_secs_f64() - sample.age as f64 / 1e9
            } else if sample.sequence == 0 {
                // A value from the start of the application is drawn from now on.
                (sample.time + sample.age) as f64 / 1e9
            } else {
                sample.time as f64 / 1e9
            };
            samples.push(strip_chart::TracePoint {
                trace,
                time,
                // A missing value interrupts the line.
                value: number.unwrap_or(f64::NAN),
            });
        }
        samples
    }

    fn status(&self) -> Option<String> {
        let name = self.input.gone.get()?;
        Some(format!("{name} is gone   q quit"))
    }

    fn is_over(&self) -> bool {
        self.input.interrupted.load(Ordering::Relaxed)
    }
}
