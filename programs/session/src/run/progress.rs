//! Prints the progress of a run line by line, where the oscilloscope is not shown.

use std::io::{self, Write};

use jde_app::Application;
use jde_core::{Nanos, State};
use jde_records::RunRecord;
use jde_terminal::{FAINT, GOOD, TextWriter};
use jde_timeline::{DriveTimeline, MarkKind, Timeline};

use crate::record_text::record_lines;
use jde_drawing::text::counted;

/// What is printed during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgressMode {
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
            for line in record_lines(record) {
                writeln!(self.output, "{line}")?;
            }
        }
        Ok(())
    }

    fn shows(&self, record: &RunRecord) -> bool {
        let every_takeover = self.mode == ProgressMode::Takeovers;
        match record {
            _ if self.mode == ProgressMode::Nothing => false,
            RunRecord::Decision(decision) => every_takeover && decision.is_takeover(),
            RunRecord::State(_) => false,
            RunRecord::Other(event) => match MarkKind::of(&event.what) {
                MarkKind::Recovered | MarkKind::Overrun | MarkKind::Refused | MarkKind::Ended => false,
                MarkKind::Delayed => every_takeover,
                MarkKind::Other
                | MarkKind::Operator
                | MarkKind::Reloaded
                | MarkKind::Standstill
                | MarkKind::Triggered
                | MarkKind::Limited
                | MarkKind::ArbitrationFailed
                | MarkKind::Calmed
                | MarkKind::Chattering
                | MarkKind::Stalled
                | MarkKind::Late
                | MarkKind::Fault => true,
            },
        }
    }

    /// Prints targets that were reached since the last call, and a status line when one is due.
    pub(crate) fn update(
        &mut self,
        time: Nanos,
        drive: &DriveTimeline,
        timeline: &Timeline,
    ) -> io::Result<()> {
        // Fails if earlier lines could not be written.
        self.output.flush()?;
        if self.mode == ProgressMode::Nothing {
            return Ok(());
        }
        // Only for places: other counts may rise by thousands.
        if let Some(mission) = drive.mission.newest().filter(|_| drive.mission.has_places()) {
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
                let text = self.status_text(time, drive, timeline);
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

    fn status_text(&mut self, time: Nanos, drive: &DriveTimeline, timeline: &Timeline) -> String {
        let mut parts = Vec::new();
        let robot = drive.led_robot(timeline.hierarchy());
        if let Some(pose) = robot.and_then(|robot| robot.pose) {
            parts.push(format!("at ({:.2}, {:.2})", pose.x, pose.y));
        }
        match drive.mission.newest() {
            Some(mission) if drive.mission.target().is_some() => {
                parts.push(format!(
                    "to target {}",
                    format_progress(mission.reached + 1, mission.total)
                ));
            }
            Some(mission) if !drive.mission.has_places() => {
                parts.push(format!(
                    "{} {}",
                    format_progress(mission.reached, mission.total),
                    mission.note.as_str()
                ));
            }
            Some(_) | None => {}
        }
        let passed = time.saturating_sub(self.status.time).max(1);
        for actor in timeline.hierarchy().actors() {
            let won = timeline.schemas()[actor].time_in(State::Winner, time);
            let share = won.saturating_sub(self.status.winner_times[actor]) as f64 / passed as f64;
            self.status.winner_times[actor] = won;
            if share >= 0.005 {
                parts.push(format!(
                    "{} {:.0} %",
                    timeline.hierarchy().name(Some(actor)),
                    share * 100.0
                ));
            }
        }
        let takeovers = timeline.takeovers();
        match takeovers - self.status.takeovers {
            0 => {}
            count => parts.push(counted(count, "takeover")),
        }
        (self.status.time, self.status.takeovers) = (time, takeovers);
        parts.join(", ")
    }
}

/// "2 of 8", or "2" if there is no total.
pub fn format_progress(count: u32, total: u32) -> String {
    if total == 0 {
        count.to_string()
    } else {
        format!("{count} of {total}")
    }
}
