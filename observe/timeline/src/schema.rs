//! What happened to one schema and to one group.

use std::collections::VecDeque;

use jde_core::{Health, Nanos, State};
use jde_records::DecidedBy;
use jde_records::event::{Naming, Occurrence, What};

use crate::keep::Keep;
use crate::mark::{Mark, MarkKind};
use crate::track::{Interval, Track};

/// The most refusals of a schema that are kept in words.
const MAX_REFUSALS: usize = 4;

/// What happened to a schema.
#[derive(Clone, Debug, PartialEq)]
pub struct SchemaTimeline {
    /// Its states. They begin when the first is known.
    pub states: Track<State>,
    /// Whether it is Faulted.
    pub faulted: Track<bool>,
    /// Its present health.
    pub health: Health,
    /// Its events, oldest first.
    pub marks: VecDeque<Mark>,
    /// What is counted of it.
    pub counts: Counts,
    /// What was refused, and why: the first four different ones.
    pub refusals: Vec<String>,
    /// The last fault in words; `None` without one, and for events without names.
    pub last_fault: Option<String>,
    /// Whether a call has not returned. The fault that follows is the same.
    hangs: bool,
    /// The time in each state before the kept intervals, ns, in the order of [`State::ALL`].
    ended: [Nanos; 4],
}

/// What is counted of a schema.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// How often it took over and began to iterate, as a motor schema.
    pub takeovers: u64,
    /// Iterations.
    pub iterations: u64,
    /// Missed deadlines; from records, the series of them.
    pub overruns: u64,
    /// Refused commands and wakes; from records, the series of them.
    pub refused: u64,
    /// Faults, including calls that did not return.
    pub faults: u64,
    /// Takeovers that took longer than their contract permits, and not because of the machine (R17).
    pub late: u64,
}

/// What happened to a group.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupTimeline {
    /// Its winners: the member that is WINNER. It has none while its father sleeps.
    pub winners: Track<Option<usize>>,
    /// The selections that changed the choice, oldest first.
    pub switches: VecDeque<Switch>,
    /// What is counted of it.
    pub counts: GroupCounts,
    most_switches: usize,
}

/// What is counted of a group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GroupCounts {
    /// Selections.
    pub selections: u64,
    /// Selections that changed the choice.
    pub switches: u64,
    /// The longest takeover, ns.
    pub worst: Option<Nanos>,
    /// The takeovers that took longer than the contract permits, and not because of the machine (R17).
    pub late: u64,
}

/// A selection that changed the choice of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct Switch {
    /// The number of the selection in the run; `None` while only snapshots show it.
    pub number: Option<u64>,
    /// When, ns.
    pub time: Nanos,
    /// The choice before.
    pub from: Option<usize>,
    /// The new choice.
    pub to: Option<usize>,
    /// Who decided.
    pub decider: DecidedBy,
    /// The reason, in words.
    pub reason: String,
    /// Time from the cause to the winner's first iteration, ns; `None` while that has not begun.
    pub latency: Option<Nanos>,
}

impl Switch {
    /// When, s since the application's start.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time as f64 / 1e9
    }
}

impl SchemaTimeline {
    pub(crate) fn new(keep: &Keep) -> Self {
        Self {
            states: Track::new(keep.intervals),
            faulted: Track::new(keep.intervals),
            health: Health::Ok,
            marks: VecDeque::new(),
            counts: Counts::default(),
            refusals: Vec::new(),
            last_fault: None,
            hangs: false,
            ended: [0; 4],
        }
    }

    /// Returns the present state; SLEPT if it is not known.
    #[must_use]
    pub fn state(&self) -> State {
        self.states.last().map_or(State::Slept, |interval| interval.value)
    }

    /// Returns how long it was in a state until a time that is not before the present, ns.
    #[must_use]
    pub fn time_in(&self, state: State, now: Nanos) -> Nanos {
        let ends = self.states.iter().skip(1).map(|next| next.from).chain([now]);
        let kept = self.states.iter().zip(ends);
        let kept = kept.filter(|(interval, _)| interval.value == state);
        let kept: Nanos = kept
            .map(|(interval, end)| end.saturating_sub(interval.from))
            .sum();
        self.ended[state as usize] + kept
    }

    /// Begins a state. Returns the interval that is kept no more, with its end.
    pub(crate) fn set_state(&mut self, time: Nanos, state: State) -> Option<(Interval<State>, Nanos)> {
        let (ended, end) = self.states.set(time, state)?;
        self.ended[ended.value as usize] += end - ended.from;
        Some((ended, end))
    }

    pub(crate) fn set_health(&mut self, time: Nanos, health: &Health) {
        self.faulted.set(time, matches!(health, Health::Faulted(_)));
        self.health.clone_from(health);
    }

    /// Counts an event, and takes the health from it. `words` describes it.
    pub(crate) fn count<N: Naming>(
        &mut self,
        time: Nanos,
        what: &What<N>,
        words: impl FnOnce() -> Option<String>,
    ) {
        match what {
            What::HealthChanged { health, .. } => {
                let is_fault = matches!(health, Health::Faulted(_));
                if is_fault {
                    self.counts.faults += u64::from(!self.hangs);
                    self.last_fault = words();
                }
                self.hangs &= !is_fault && *health != Health::Ok;
                self.set_health(time, health);
            }
            What::Hung { .. } => {
                self.counts.faults += 1;
                self.hangs = true;
                self.last_fault = words();
            }
            What::CallAbandoned { .. } => self.hangs = false,
            What::Overrun { .. } => {
                self.counts.overruns += 1;
                self.set_health(time, &Health::Overrun);
            }
            What::Refused { description, .. } => {
                self.counts.refused += 1;
                if self.refusals.len() < MAX_REFUSALS && !self.refusals.contains(description) {
                    self.refusals.push(description.clone());
                }
            }
            What::TookOver { .. } => self.counts.late += u64::from(what.is_late()),
            What::ChatteringStarted { .. }
            | What::ChatteringEnded { .. }
            | What::StoodStill { .. }
            | What::WentOn { .. }
            | What::Stalled { .. }
            | What::AbandonedCallReturned { .. }
            | What::Limited { .. }
            | What::Operator { .. }
            | What::Reloaded { .. }
            | What::ReloadRolledBack { .. }
            | What::Retracted { .. }
            | What::Triggered { .. }
            | What::Ended { .. }
            | What::Unknown { .. } => {}
        }
    }

    /// Counts a takeover.
    pub(crate) fn count_takeover(&mut self) {
        self.counts.takeovers += 1;
    }

    /// Marks an event. Returns whether it is of a kind that is marked.
    pub(crate) fn mark(&mut self, event: &Occurrence<String>) -> bool {
        let kind = MarkKind::of(&event.what);
        if matches!(kind, MarkKind::Other | MarkKind::Delayed) {
            return false;
        }
        // Readers search by time. Records of one kind arrive in that order.
        let time = self
            .marks
            .back()
            .map_or(event.time, |last| last.time.max(event.time));
        self.marks.push_back(Mark {
            time,
            kind,
            text: event.text(),
        });
        true
    }

    pub(crate) fn rewind(&mut self, now: Nanos) {
        self.states.rewind(now);
        self.faulted.rewind(now);
        self.marks.retain(|mark| mark.time <= now);
    }
}

impl GroupTimeline {
    pub(crate) fn new(keep: &Keep) -> Self {
        Self {
            winners: Track::new(keep.intervals),
            switches: VecDeque::new(),
            counts: GroupCounts::default(),
            most_switches: keep.switches,
        }
    }

    /// Returns the present winner.
    #[must_use]
    pub fn winner(&self) -> Option<usize> {
        self.winners.last()?.value
    }

    /// Adds a switch, or what is newly known of one: a snapshot shows it at once, and its record has its number.
    pub(crate) fn add_switch(&mut self, switch: Switch) {
        let first = self.switches.partition_point(|known| known.time < switch.time);
        let place = self.switches.partition_point(|known| known.time <= switch.time);
        // Several of one instant differ in their numbers.
        let is_same = |known: &&mut Switch| {
            known.number.is_none() || switch.number.is_none() || known.number == switch.number
        };
        if let Some(known) = self.switches.range_mut(first..place).rev().find(is_same) {
            *known = Switch {
                number: switch.number.or(known.number),
                latency: switch.latency.or(known.latency),
                ..switch
            };
            return;
        }
        self.switches.insert(place, switch);
        if self.switches.len() > self.most_switches {
            self.switches.pop_front();
        }
    }

    /// Adds the time of the takeover that follows from a selection.
    pub(crate) fn add_takeover(&mut self, record: u64, latency: Nanos) {
        let mut switches = self.switches.iter_mut().rev();
        if let Some(switch) = switches.find(|switch| switch.number == Some(record)) {
            switch.latency = Some(latency);
        }
    }

    pub(crate) fn rewind(&mut self, now: Nanos) {
        self.winners.rewind(now);
        self.switches.retain(|switch| switch.time <= now);
    }
}
