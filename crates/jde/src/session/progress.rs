//! Prints the progress of a run line by line, where the oscilloscope is not shown.

use std::io::{self, Write};

use jde_core::{Health, Nanos};
use jde_host::app::Application;
use jde_host::event::Event;

use super::sight::Seen;
use super::tally::{Takeover, Tally};
use crate::terminal::{BAD, FAINT, GOOD, WARN, Words};

/// What is printed during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Telling {
    /// Nothing: the run is shown elsewhere.
    Nothing,
    /// Every takeover with its reason.
    Takeovers,
    /// A status line at this interval, ns, with the share of time that each schema won since the last line.
    /// Single takeovers are not printed.
    Status(Nanos),
}

/// Prints the progress of a run.
pub(crate) struct Progress {
    words: Words,
    telling: Telling,
    schemas: Vec<String>,
    groups: Vec<String>,
    reached: u32,
    status: Status,
}

/// The values at the last status line.
#[derive(Default)]
struct Status {
    next: Nanos,
    time: Nanos,
    won: Vec<Nanos>,
    takeovers: u64,
}

impl Progress {
    /// Creates a printer of progress that writes to `words`.
    pub(crate) fn new(application: &Application, words: Words, telling: Telling) -> Self {
        let mut status = Status {
            won: vec![0; application.instances.len()],
            ..Status::default()
        };
        if let Telling::Status(every) = telling {
            status.next = every;
        }
        Self {
            words,
            telling,
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
    pub(crate) fn into_words(self) -> Words {
        self.words
    }

    /// Prints an event, if it is one that is shown.
    pub(crate) fn event(&mut self, event: &Event) -> io::Result<()> {
        if self.telling == Telling::Nothing {
            return Ok(());
        }
        let name = |schema: usize| &self.schemas[schema];
        let (time, text) = match event {
            Event::Health {
                time,
                schema,
                health: Health::Faulted(reason),
            } => {
                (time, format!("{BAD}{} faulted{BAD:#}: {reason}", name(*schema)))
            }
            Event::Health {
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
                let long = time.saturating_sub(*since) as f64 / 1e9;
                (time, format!(
                    "{BAD}{} hangs{BAD:#}: a call has not returned for {long:.1} s",
                    name(*schema)
                ))
            }
            Event::LeftBehind {
                time, schema, left, ..
            } => {
                (time, format!(
                    "{WARN}the call of {} is left behind{WARN:#}, {left} in all; its next awakening makes a fresh instance",
                    name(*schema)
                ))
            }
            Event::CameBack {
                time,
                schema,
                since,
                left,
                ..
            } => {
                let long = time.saturating_sub(*since) as f64 / 1e9;
                (time, format!(
                    "a call of {} that was left behind returned after {long:.1} s; {left} have not",
                    name(*schema)
                ))
            }
            Event::Chatters {
                time,
                group,
                between,
                switches,
            } => {
                let [one, other] = between.map(|schema| schema.map_or("nobody", |schema| name(schema).as_str()));
                (time, format!(
                    "{WARN}{} chatters{WARN:#} between {one} and {other}: {switches} switches within a second",
                    self.groups[*group]
                ))
            }
            Event::Calmed {
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
                (time, format!("{GOOD}{} reloaded{GOOD:#}: {}", name(*schema), takeover.words()))
            }
            Event::ReloadUndone {
                time,
                schema,
                build,
                reason,
            } => {
                (time, format!(
                    "{BAD}{} goes on with the build before {build}{BAD:#}: {reason}",
                    name(*schema)
                ))
            }
            Event::Operator { time, by, action } => {
                (time, format!("{by} {}", action.words(&self.schemas[action.schema()])))
            }
            Event::Changed { .. }
            | Event::Health {
                health: Health::Ok | Health::Overrun,
                ..
            }
            | Event::Decided(_)
            | Event::Took { .. }
            // The line of a takeover shows the time that it may take.
            | Event::Late { .. }
            | Event::Overrun { .. }
            | Event::Refused { .. }
            | Event::Ended { .. } => return Ok(()),
        };
        self.line(*time, &text)
    }

    /// Prints a takeover, if every takeover is shown.
    pub(crate) fn takeover(&mut self, takeover: &Takeover) -> io::Result<()> {
        if self.telling != Telling::Takeovers {
            return Ok(());
        }
        let name = |schema: Option<usize>| schema.map_or("nobody", |schema| &self.schemas[schema]);
        let took = match takeover.took {
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
        self.line(takeover.time, &text)
    }

    /// Prints targets that were reached since the last call, and a status line when one is due.
    pub(crate) fn seen(&mut self, time: Nanos, seen: &Seen, tally: &Tally) -> io::Result<()> {
        // Fails if earlier lines could not be written.
        self.words.flush()?;
        if self.telling == Telling::Nothing {
            return Ok(());
        }
        // Only for places: other counts may rise by thousands.
        if let Some(mission) = seen.mission.as_ref().filter(|mission| mission.of_places) {
            while self.reached < mission.reached {
                self.reached += 1;
                let text = format!("{GOOD}target {} reached{GOOD:#}", of(self.reached, mission.total));
                self.line(time, &text)?;
            }
        }
        match self.telling {
            Telling::Status(every) if time >= self.status.next => {
                self.status.next = time - time % every + every;
                let text = self.status(time, seen, tally);
                self.line(time, &text)
            }
            Telling::Status(_) | Telling::Takeovers | Telling::Nothing => Ok(()),
        }
    }

    fn line(&mut self, time: Nanos, text: &str) -> io::Result<()> {
        writeln!(self.words, "{FAINT}{:>9.2} s{FAINT:#}  {text}", time as f64 / 1e9)
    }

    fn status(&mut self, time: Nanos, seen: &Seen, tally: &Tally) -> String {
        let mut parts = Vec::new();
        if let Some(pose) = seen.truth.or(seen.odometry) {
            parts.push(format!("at ({:.2}, {:.2})", pose.x, pose.y));
        }
        match &seen.mission {
            Some(mission) if mission.target.is_some() => {
                parts.push(format!("to target {}", of(mission.reached + 1, mission.total)));
            }
            Some(mission) if !mission.of_places => {
                parts.push(format!("{} {}", of(mission.reached, mission.total), mission.note));
            }
            Some(_) | None => {}
        }
        let passed = time.saturating_sub(self.status.time).max(1);
        for actor in tally.actors() {
            let won = tally.won(actor, time);
            let share = won.saturating_sub(self.status.won[actor]) as f64 / passed as f64;
            self.status.won[actor] = won;
            if share >= 0.005 {
                parts.push(format!("{} {:.0} %", self.schemas[actor], share * 100.0));
            }
        }
        let takeovers = tally.all_takeovers();
        match takeovers - self.status.takeovers {
            0 => {}
            1 => parts.push("1 takeover".to_owned()),
            many => parts.push(format!("{many} takeovers")),
        }
        (self.status.time, self.status.takeovers) = (time, takeovers);
        parts.join(", ")
    }
}

/// "2 of 8", or "2" if there is no total.
pub(crate) fn of(count: u32, total: u32) -> String {
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
