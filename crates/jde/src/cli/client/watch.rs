//! `jde watch`: values as they come, in lines or drawn over time.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Instant;

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_link::value::to_json;
use jde_link::{Rate, Remote, Sample, Watching};
use serde_json::json;

use super::{Context, Target};
use crate::attached::name;
use crate::attached::part::Part;
use crate::cli::{print_json, quantity};
use crate::complete;
use crate::failure::Failure;
use crate::interrupt::Interrupts;
use crate::strip;
use crate::terminal::{self, FAINT};

/// How often a plot wants values: twice for each of its redraws.
const PLOT: Rate = Rate::Hz(50);

/// Show values as they come, of variables or of fields of them.
#[derive(Args)]
#[command(after_help = "Examples:
  jde watch pioneer.odometry.pose.pose.position.x --rate 2
  jde watch example.mission --count 1 --json
  jde watch --plot pioneer.odometry.twist.twist.linear.x pioneer.velocity.linear.x")]
pub(crate) struct Watch {
    /// The variables: SCHEMA.VARIABLE, with .FIELD behind it and APP: before it if need be.
    #[arg(value_name = "VARIABLE", required = true, add = ArgValueCompleter::new(complete::variables))]
    variables: Vec<String>,
    #[command(flatten)]
    target: Target,
    /// At most so many a second of each, the newest; without it every value.
    #[arg(long, value_name = "HZ", value_parser = quantity::rate)]
    rate: Option<f64>,
    /// End after so many.
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    /// Draw numbers over time.
    #[arg(long, conflicts_with_all = ["json", "count"])]
    plot: bool,
    /// A line of JSON each.
    #[arg(long)]
    json: bool,
}

/// What is told by those who watch.
enum Told {
    Sample(usize, Sample),
    /// The application of this number is gone.
    Gone(String),
    Interrupted,
}

/// One of the variables.
struct Watched {
    application: String,
    variable: String,
    part: Part,
}

impl Watch {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        if self.plot && !terminal::is_interactive() {
            return Err(Failure::usage(
                "--plot needs a terminal",
                "leave it out, or give --json, to watch in a pipe",
            ));
        }
        let (tell, told) = channel();
        let rate = match (self.rate, self.plot) {
            (Some(hz), _) => Rate::at_least(hz),
            (None, true) => PLOT,
            (None, false) => Rate::Full,
        };
        let mut watched = Vec::new();
        let mut watching = Vec::new();
        for asked in &self.variables {
            let (remote, asked) = context.of(&self.target, asked)?;
            let (one, watch) = self.begin(&remote, asked, watched.len(), rate, &tell)?;
            watched.push(one);
            watching.push(watch);
        }
        let _interrupts = Interrupts::call(move || {
            let _ = tell.send(Told::Interrupted);
        })?;
        if self.plot {
            return self.draw(&watched, told);
        }
        self.tell(&watched, &told)
    }

    fn begin(
        &self,
        remote: &Remote,
        asked: &str,
        number: usize,
        rate: Rate,
        tell: &Sender<Told>,
    ) -> Result<(Watched, Watching), Failure> {
        let known = remote.variables(false)?;
        let (variable, path) = name::variable(asked, known.iter().map(|known| known.name.as_str()))?;
        let info = remote.variable(variable)?;
        let part = Part::of(&info, path)?;
        if self.plot && !part.is_number() {
            return Err(Failure::usage(
                format!("`{asked}` is no number, and only numbers are drawn"),
                format!("name a field, such as {asked}.FIELD; `jde get {variable}` shows them"),
            ));
        }
        let gone = tell.clone();
        let application = remote.about().name.clone();
        remote.on_gone({
            let application = application.clone();
            move || {
                let _ = gone.send(Told::Gone(application));
            }
        });
        let tell = tell.clone();
        let watch = remote.watch(variable, rate, move |sample| {
            // Nobody listens any more at the end.
            let _ = tell.send(Told::Sample(number, sample));
        })?;
        let watched = Watched {
            application,
            variable: variable.to_owned(),
            part,
        };
        Ok((watched, watch))
    }

    fn tell(&self, watched: &[Watched], told: &Receiver<Told>) -> Result<(), Failure> {
        let mut left = self.count;
        while left != Some(0)
            && let Ok(told) = told.recv()
        {
            match told {
                Told::Sample(number, sample) => {
                    self.line(&watched[number], watched.len() > 1, &sample)?;
                    left = left.map(|left| left - 1);
                }
                Told::Gone(name) => return Err(jde_link::Error::Gone(name).into()),
                Told::Interrupted => break,
            }
        }
        Ok(())
    }

    fn line(&self, watched: &Watched, several: bool, sample: &Sample) -> Result<(), Failure> {
        let part = &watched.part;
        // An element past the end of a list is none.
        let value = sample.bytes.as_deref().and_then(|bytes| part.value(bytes).ok());
        if self.json {
            return print_json(&json!({
                "application": watched.application,
                "variable": watched.variable,
                "name": part.name(),
                "unit": part.unit,
                "time_s": sample.time as f64 / 1e9,
                "sequence": sample.sequence,
                "writer": sample.writer,
                "value": value.as_ref().map(to_json),
            }));
        }
        let mut out = terminal::out();
        write!(out, "{FAINT}{:>9.3} s{FAINT:#}  ", sample.time as f64 / 1e9)?;
        if several {
            write!(out, "{}  ", part.name())?;
        }
        match value {
            Some(value) => writeln!(out, "{}", part.shown(value))?,
            None => writeln!(out, "{FAINT}no value{FAINT:#}")?,
        }
        out.flush()?;
        Ok(())
    }

    fn draw(&self, watched: &[Watched], told: Receiver<Told>) -> Result<(), Failure> {
        let names = watched.iter().map(|watched| match watched.part.unit.as_str() {
            "" => watched.part.name().to_owned(),
            unit => format!("{} [{unit}]", watched.part.name()),
        });
        let mut applications: Vec<_> = watched
            .iter()
            .map(|watched| watched.application.as_str())
            .collect();
        applications.dedup();
        let mut source = Incoming {
            told,
            watched,
            gone: None,
            interrupted: false,
            several: applications.len() > 1,
            start: Instant::now(),
        };
        strip::run(&applications.join(", "), names.collect(), &mut source)?;
        Ok(())
    }
}

/// Values on their way into a plot.
struct Incoming<'w> {
    told: Receiver<Told>,
    watched: &'w [Watched],
    gone: Option<String>,
    interrupted: bool,
    /// Of several applications.
    several: bool,
    start: Instant,
}

impl strip::Source for Incoming<'_> {
    fn take(&mut self) -> Vec<strip::Sample> {
        let mut samples = Vec::new();
        while let Ok(told) = self.told.try_recv() {
            match told {
                Told::Sample(trace, sample) => {
                    let number = sample
                        .bytes
                        .as_deref()
                        .and_then(|bytes| self.watched[trace].part.number(bytes));
                    let time = if self.several {
                        // Each application counts from its own start: here all count from when this began.
                        self.start.elapsed().as_secs_f64() - sample.age as f64 / 1e9
                    } else if sample.sequence == 0 {
                        // What has been there since the start is drawn from now on.
                        (sample.time + sample.age) as f64 / 1e9
                    } else {
                        sample.time as f64 / 1e9
                    };
                    samples.push(strip::Sample {
                        trace,
                        time,
                        // A value that is none breaks the line.
                        value: number.unwrap_or(f64::NAN),
                    });
                }
                Told::Gone(name) => self.gone = Some(name),
                Told::Interrupted => self.interrupted = true,
            }
        }
        samples
    }

    fn status(&self) -> Option<String> {
        let name = self.gone.as_ref()?;
        Some(format!("{name} is gone   q leave"))
    }

    fn is_over(&self) -> bool {
        self.interrupted
    }
}
