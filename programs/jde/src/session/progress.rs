//! Prints the progress of a run line by line, where the oscilloscope is not shown.

use std::io::{self, Write};

use jde_app::Application;
use jde_core::{Health, Nanos};
use jde_records::RunRecord;
use jde_records::event::What;

use super::sampler::Observation;
use super::statistics::Statistics;
use crate::record_text::format_record;
use crate::summary::pluralize;
use crate::terminal::{FAINT, GOOD, TextWriter};

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
            reached: 0,
            status,
        }
    }

    /// Returns the stream.
    pub(crate) fn into_output(self) -> TextWriter {
        self.output
    }

    /// Prints a message of the run if its kind is shown.
    pub(crate) fn print_record(&mut self, record: &RunRecord) -> io::Result<()> {
        if self.shows(record) {
            writeln!(self.output, "{}", format_record(record))?;
        }
        Ok(())
    }

    fn shows(&self, record: &RunRecord) -> bool {
        let every_takeover = self.mode == ProgressMode::Takeovers;
        match record {
            _ if self.mode == ProgressMode::Nothing => false,
            RunRecord::Decision(decision) => every_takeover && decision.is_takeover(),
            RunRecord::State(_) => false,
            RunRecord::Other(event) => match &event.what {
                What::HealthChanged { health, .. } => match health {
                    Health::Ok | Health::Overrun => false,
                    Health::ArbitrationFailed(_) | Health::Faulted(_) => true,
                },
                What::Overrun { .. } | What::Refused { .. } | What::Ended { .. } => false,
                What::TookOver { .. } => every_takeover || event.what.is_late(),
                What::ChatteringStarted { .. }
                | What::ChatteringEnded { .. }
                | What::StoodStill { .. }
                | What::WentOn { .. }
                | What::Stalled { .. }
                | What::Hung { .. }
                | What::CallAbandoned { .. }
                | What::AbandonedCallReturned { .. }
                | What::Limited { .. }
                | What::Operator { .. }
                | What::Reloaded { .. }
                | What::ReloadRolledBack { .. }
                | What::Retracted { .. }
                | What::Triggered { .. }
                | What::Unknown { .. } => true,
            },
        }
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
            "{FAINT}{:>9.3} s{FAINT:#}  {text}",
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
