//! Prints the progress of a run line by line, where the oscilloscope is not shown.

use std::io::{self, Write};

use jde_app::Application;
use jde_core::{Health, Nanos};
use jde_records::event::Event;

use super::sampler::Observation;
use super::statistics::{Statistics, Takeover};
use crate::summary::pluralize;
use crate::terminal::{BAD, FAINT, GOOD, TextWriter, WARN};

/// What is printed during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ProgressMode {
    /// Nothing: a view shows the run.
    Nothing,
    /// Every takeover with its reason.
    Takeovers,
    /// A status line at this interval, ns, with the share of time that each schema won since the last line.
    /// Single takeovers are not printed.
    Status(Nanos),
}

/// Prints the progress of a run.
pub(crate) struct ProgressPrinter {
    output: TextWriter,
    mode: ProgressMode,
    schemas: Vec<String>,
    groups: Vec<String>,
    reached: u32,
    status: StatusLine,
}

/// The values at the last status line.
#[derive(Default)]
struct StatusLine {
    next: Nanos,
    time: Nanos,
    winner_times: Vec<Nanos>,
    takeovers: u64,
}

impl ProgressPrinter {
    /// Creates a printer of progress that writes to `output`.
    pub(crate) fn new(application: &Application, output: TextWriter, mode: ProgressMode) -> Self {
        let mut status = StatusLine {
            winner_times: vec![0; application.instances.len()],
            ..StatusLine::default()
        };
        if let ProgressMode::Status(interval) = mode {
            status.next = interval;
        }
        Self {
            output,
            mode,
            schemas: application
                .instances
                .iter()
                .map(|instance| instance.name.clone())
                .collect(),
            groups: application
                .groups
                .iter()
                .map(|group| group.name.clone())
                .collect(),
            reached: 0,
            status,
        }
    }

    /// Returns the stream.
    pub(crate) fn into_output(self) -> TextWriter {
        self.output
    }

    /// Prints an event if its kind is shown.
    pub(crate) fn print_event(&mut self, event: &Event) -> io::Result<()> {
        if self.mode == ProgressMode::Nothing {
            return Ok(());
        }
        let name = |schema: usize| &self.schemas[schema];
        let (time, text) = match event {
            Event::HealthChanged {
                time,
                schema,
                health: Health::Faulted(reason),
            } => {
                (time, format!("{BAD}{} faulted{BAD:#}: {reason}", name(*schema)))
            }
            Event::HealthChanged {
                time,
                schema,
                health: Health::ArbitrationFailed(reason),
            } => {
                (time, format!(
                    "{WARN}the arbitration of {} failed{WARN:#}: {reason}",
                    name(*schema)
                ))
            }
            Event::Hung { time, schema, since } => {
                let seconds = time.saturating_sub(*since) as f64 / 1e9;
                (time, format!(
                    "{BAD}{} hangs{BAD:#}: a call has not returned for {seconds:.1} s",
                    name(*schema)
                ))
            }
            Event::CallAbandoned {
                time, schema, abandoned, ..
            } => {
                (time, format!(
                    "{WARN}the call of {} is left behind{WARN:#}, {abandoned} in all; its next awakening creates a new instance",
                    name(*schema)
                ))
            }
            Event::AbandonedCallReturned {
                time,
                schema,
                since,
                abandoned,
                ..
            } => {
                let seconds = time.saturating_sub(*since) as f64 / 1e9;
                (time, format!(
                    "a call of {} that was left behind returned after {seconds:.1} s; {abandoned} have not",
                    name(*schema)
                ))
            }
            Event::ChatteringStarted {
                time,
                group,
                between,
                switches,
            } => {
                let [first, second] = between.map(|schema| schema.map_or("nobody", |schema| name(schema).as_str()));
                (time, format!(
                    "{WARN}{} chatters{WARN:#} between {first} and {second}: {switches} switches within a second",
                    self.groups[*group]
                ))
            }
            Event::ChatteringEnded {
                time,
                group,
                since,
                switches,
            } => {
                (time, format!(
                    "{} has calmed down after {:.1} s and {switches} more switches",
                    self.groups[*group],
                    time.saturating_sub(*since) as f64 / 1e9
                ))
            }
            Event::Stalled {
                time,
                since,
                distance,
                reached,
                ..
            } => {
                (time, format!(
                    "{WARN}the mission has come no nearer{WARN:#} for {:.0} s: {distance:.2} m from its target, {reached} reached",
                    time.saturating_sub(*since) as f64 / 1e9
                ))
            }
            Event::Reloaded {
                time,
                schema,
                takeover,
            } => {
                (time, format!("{GOOD}{} reloaded{GOOD:#}: {}", name(*schema), takeover.summary()))
            }
            Event::ReloadRolledBack {
                time,
                schema,
                build,
                reason,
            } => {
                (time, format!(
                    "{BAD}{} continues with the build before {build}{BAD:#}: {reason}",
                    name(*schema)
                ))
            }
            Event::Operator { time, by, action } => {
                (time, format!("{by} {}", action.description(&self.schemas[action.schema()])))
            }
            Event::StateChanged { .. }
            | Event::HealthChanged {
                health: Health::Ok | Health::Overrun,
                ..
            }
            | Event::Decided(_)
            | Event::TookOver { .. }
            // The line of a takeover shows the time that it may take.
            | Event::TookOverLate { .. }
            | Event::Overrun { .. }
            | Event::Refused { .. }
            | Event::Ended { .. } => return Ok(()),
        };
        self.print_line(*time, &text)
    }

    /// Prints a takeover, if every takeover is shown.
    pub(crate) fn print_takeover(&mut self, takeover: &Takeover) -> io::Result<()> {
        if self.mode != ProgressMode::Takeovers {
            return Ok(());
        }
        let name = |schema: Option<usize>| schema.map_or("nobody", |schema| &self.schemas[schema]);
        let took = match takeover.latency {
            Some((took, allowed)) if took > allowed => {
                format!(
                    ", {WARN}took {}, allowed {}{WARN:#}",
                    Millis(took),
                    Millis(allowed)
                )
            }
            Some((took, _)) => format!("{FAINT}, took {}{FAINT:#}", Millis(took)),
            None => String::new(),
        };
        // The decider "nobody" means that there was no choice to make, and the reason states that.
        let decider = match takeover.decider {
            "nobody" => String::new(),
            decider => format!(" {FAINT}({decider}){FAINT:#}"),
        };
        let text = format!(
            "{}: {} -> {GOOD}{}{GOOD:#}  {}{decider}{took}",
            self.groups[takeover.group],
            name(takeover.from),
            name(takeover.to),
            takeover.reason,
        );
        self.print_line(takeover.time, &text)
    }

    /// Prints targets that were reached since the last call, and a status line when one is due.
    pub(crate) fn update(
        &mut self,
        time: Nanos,
        observation: &Observation,
        statistics: &Statistics,
    ) -> io::Result<()> {
        // Fails if earlier lines could not be written.
        self.output.flush()?;
        if self.mode == ProgressMode::Nothing {
            return Ok(());
        }
        // Only for places: other counts may rise by thousands.
        if let Some(mission) = observation
            .mission
            .as_ref()
            .filter(|mission| mission.counts_positions)
        {
            while self.reached < mission.reached {
                self.reached += 1;
                let text = format!(
                    "{GOOD}target {} reached{GOOD:#}",
                    format_progress(self.reached, mission.total)
                );
                self.print_line(time, &text)?;
            }
        }
        match self.mode {
            ProgressMode::Status(interval) if time >= self.status.next => {
                self.status.next = time - time % interval + interval;
                let text = self.status_text(time, observation, statistics);
                self.print_line(time, &text)
            }
            ProgressMode::Status(_) | ProgressMode::Takeovers | ProgressMode::Nothing => Ok(()),
        }
    }

    fn print_line(&mut self, time: Nanos, text: &str) -> io::Result<()> {
        writeln!(
            self.output,
            "{FAINT}{:>9.2} s{FAINT:#}  {text}",
            time as f64 / 1e9
        )
    }

    fn status_text(&mut self, time: Nanos, observation: &Observation, statistics: &Statistics) -> String {
        let mut parts = Vec::new();
        if let Some(pose) = observation.truth.or(observation.odometry) {
            parts.push(format!("at ({:.2}, {:.2})", pose.x, pose.y));
        }
        match &observation.mission {
            Some(mission) if mission.target.is_some() => {
                parts.push(format!(
                    "to target {}",
                    format_progress(mission.reached + 1, mission.total)
                ));
            }
            Some(mission) if !mission.counts_positions => {
                parts.push(format!(
                    "{} {}",
                    format_progress(mission.reached, mission.total),
                    mission.note
                ));
            }
            Some(_) | None => {}
        }
        let passed = time.saturating_sub(self.status.time).max(1);
        for actor in statistics.actors() {
            let won = statistics.winner_time(actor, time);
            let share = won.saturating_sub(self.status.winner_times[actor]) as f64 / passed as f64;
            self.status.winner_times[actor] = won;
            if share >= 0.005 {
                parts.push(format!("{} {:.0} %", self.schemas[actor], share * 100.0));
            }
        }
        let takeovers = statistics.total_takeovers();
        match takeovers - self.status.takeovers {
            0 => {}
            count => parts.push(pluralize(count, "takeover")),
        }
        (self.status.time, self.status.takeovers) = (time, takeovers);
        parts.join(", ")
    }
}

/// "2 of 8", or "2" if there is no total.
pub(crate) fn format_progress(count: u32, total: u32) -> String {
    if total == 0 {
        count.to_string()
    } else {
        format!("{count} of {total}")
    }
}

/// A time in ms with the digits that matter; whole seconds from a minute on in s.
pub(crate) struct Millis(pub(crate) Nanos);

impl std::fmt::Display for Millis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let seconds = self.0 / 1_000_000_000;
        if seconds >= 60 && self.0.is_multiple_of(1_000_000_000) {
            return write!(f, "{seconds} s");
        }
        let millis = self.0 as f64 / 1e6;
        let digits = match millis {
            whole if whole.fract() == 0.0 => 0,
            large if large >= 10.0 => 1,
            _ => 2,
        };
        write!(f, "{millis:.digits$} ms")
    }
}
