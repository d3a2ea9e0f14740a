//! The past of the application: the states of each schema over time, selections and events. It is bounded and
//! discards the oldest entries first.

use std::collections::{HashMap, VecDeque};

use jde_core::State;
use jde_records::event::{Occurrence, StateChange};
use jde_records::snapshot::Snapshot;
use jde_records::{Decision, RunRecord};

/// Maximum number of selections kept.
const MOST_DECISIONS: usize = 20_000;
/// Maximum number of candidates in all kept selections. Selections of a group of hundreds would otherwise
/// fill the memory.
const MOST_CANDIDATES: usize = 400_000;
const MOST_EVENTS: usize = 20_000;
/// Maximum number of changes of state kept as lines, for readers that read new lines.
const MOST_CHANGES: usize = 20_000;
/// Maximum number of state intervals kept for one schema.
const MOST_BANDS: usize = 20_000;

/// An interval during which a schema was in one state. It ends where the next begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StateInterval {
    /// In s since the application's start.
    pub(crate) from: f64,
    /// The state from then on.
    pub(crate) state: State,
}

/// The past that is kept.
#[derive(Debug, Default)]
pub(crate) struct History {
    bands: HashMap<String, VecDeque<StateInterval>>,
    decisions: VecDeque<Decision>,
    /// Number of candidates in all `decisions`.
    candidates: usize,
    events: VecDeque<Occurrence<String>>,
    changes: VecDeque<StateChange<String>>,
    progress: Progress,
    missed: u64,
    since: Option<f64>,
    last: f64,
}

/// Counters of all that was received. A reader that keeps a copy knows what is new, and whether its derived
/// data is still valid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Progress {
    /// How often a recording jumped back.
    pub(crate) turns: u64,
    /// Selections received, including discarded ones.
    pub(crate) decisions: u64,
    /// Events received, including discarded ones.
    pub(crate) events: u64,
    /// Changes of state received, including discarded ones.
    pub(crate) changes: u64,
}

impl History {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Adds a line, and the number of lines that were lost before it.
    pub(crate) fn add_line(&mut self, line: RunRecord, missed: u64) {
        self.missed += missed;
        match line {
            RunRecord::State(change) => {
                self.progress.changes += 1;
                keep(&mut self.changes, change.clone(), MOST_CHANGES);
                let (before, state) = (change.from, change.to);
                let bands = self.bands.entry(change.schema).or_default();
                if bands.is_empty() {
                    bands.push_back(StateInterval {
                        from: 0.0,
                        state: before,
                    });
                }
                push(
                    bands,
                    StateInterval {
                        from: change.time as f64 / 1e9,
                        state,
                    },
                );
            }
            RunRecord::Decision(decision) => {
                self.progress.decisions += 1;
                self.add_decision(decision);
            }
            RunRecord::Other(event) => {
                self.progress.events += 1;
                keep(&mut self.events, event, MOST_EVENTS);
            }
        }
    }

    fn add_decision(&mut self, decision: Decision) {
        self.candidates += decision.candidates.len();
        self.decisions.push_back(decision);
        while self.decisions.len() > MOST_DECISIONS || self.candidates > MOST_CANDIDATES {
            let Some(oldest) = self.decisions.pop_front() else {
                break;
            };
            self.candidates -= oldest.candidates.len();
        }
    }

    /// Counts lines that were discarded before they could be added.
    pub(crate) fn add_missed(&mut self, lines: u64) {
        self.missed += lines;
    }

    /// Adds a snapshot. It supplies changes of state whose lines were lost.
    pub(crate) fn add_snapshot(&mut self, snapshot: &Snapshot) {
        let now = snapshot.time as f64 / 1e9;
        self.rewind(now);
        self.last = now;
        self.since = Some(self.since.map_or(now, |since| since.min(now)));
        for view in &snapshot.schemas {
            if let Some(bands) = self.bands.get_mut(&view.name) {
                // A line arrives before the snapshot that shows its change, or was lost.
                if bands
                    .back()
                    .is_some_and(|band| band.state != view.state && band.from < now)
                {
                    push(
                        bands,
                        StateInterval {
                            from: now,
                            state: view.state,
                        },
                    );
                }
            } else {
                let band = StateInterval {
                    from: now,
                    state: view.state,
                };
                self.bands.insert(view.name.clone(), VecDeque::from([band]));
            }
        }
    }

    /// Removes what is later than `now` after a recording jumped back.
    fn rewind(&mut self, now: f64) {
        if now >= self.last {
            return;
        }
        for bands in self.bands.values_mut() {
            bands.retain(|band| band.from <= now);
        }
        self.decisions.retain(|decision| decision.time_s <= now);
        self.candidates = self
            .decisions
            .iter()
            .map(|decision| decision.candidates.len())
            .sum();
        self.events.retain(|event| event.time_s() <= now);
        self.changes.retain(|change| change.time as f64 / 1e9 <= now);
        self.last = now;
        self.progress.turns += 1;
    }

    /// The state intervals of a schema, oldest first.
    pub(crate) fn states(&self, schema: &str) -> Option<&VecDeque<StateInterval>> {
        self.bands.get(schema)
    }

    /// Selections, oldest first.
    pub(crate) fn decisions(&self) -> &VecDeque<Decision> {
        &self.decisions
    }

    /// Events, oldest first.
    pub(crate) fn events(&self) -> &VecDeque<Occurrence<String>> {
        &self.events
    }

    /// Changes of state, oldest first.
    pub(crate) fn changes(&self) -> &VecDeque<StateChange<String>> {
        &self.changes
    }

    /// The counters of all that was received.
    pub(crate) fn progress(&self) -> Progress {
        self.progress
    }

    /// The earliest time of a snapshot, in s since the application's start.
    pub(crate) fn since(&self) -> Option<f64> {
        self.since
    }

    /// Number of lost lines: the network or this machine was too slow.
    pub(crate) fn missed(&self) -> u64 {
        self.missed
    }
}

fn push(bands: &mut VecDeque<StateInterval>, band: StateInterval) {
    match bands.back_mut() {
        // Of two changes at one instant, the last is kept.
        Some(last) if last.from >= band.from => last.state = band.state,
        Some(last) if last.state == band.state => {}
        _ => keep(bands, band, MOST_BANDS),
    }
}

fn keep<T>(list: &mut VecDeque<T>, new: T, most: usize) {
    if list.len() == most {
        list.pop_front();
    }
    list.push_back(new);
}

#[cfg(test)]
mod tests {
    use jde_abi::describe::Kind;

    use super::*;
    use crate::window::scope::fixture;

    fn add_snapshot(past: &mut History, seconds: f64, state: State) {
        let mut schema = fixture::schema("goon", Kind::Motor, None, Some(0));
        schema.state = state;
        past.add_snapshot(&Snapshot {
            time: (seconds * 1e9) as u64,
            schemas: vec![schema],
            groups: Vec::new(),
            ..Snapshot::default()
        });
    }

    fn add_win(past: &mut History, seconds: f64) {
        let change = StateChange {
            time: (seconds * 1e9).round() as u64,
            schema: "goon".to_owned(),
            from: State::Ready,
            to: State::Winner,
        };
        past.add_line(RunRecord::State(change), 0);
    }

    #[test]
    fn a_recording_that_goes_back_in_small_steps_removes_later_entries() {
        let mut past = History::new();
        add_snapshot(&mut past, 8.0, State::Ready);
        add_win(&mut past, 9.2);
        add_snapshot(&mut past, 10.0, State::Winner);
        add_snapshot(&mut past, 9.5, State::Winner);
        add_snapshot(&mut past, 9.0, State::Ready);
        let bands = past.states("goon").expect("the schema is known");
        let states: Vec<_> = bands.iter().map(|band| (band.from, band.state)).collect();
        assert_eq!(states, [(8.0, State::Ready)]);
        assert_eq!(past.progress().turns, 2);
        add_win(&mut past, 9.2);
        add_snapshot(&mut past, 9.3, State::Winner);
        assert_eq!(
            past.states("goon").map(VecDeque::len),
            Some(2),
            "the change is added again"
        );
        add_snapshot(&mut past, 2.0, State::Ready);
        assert_eq!(past.since(), Some(2.0), "the observation now begins there");
    }

    #[test]
    fn the_number_of_kept_selections_is_limited_by_their_candidates() {
        let selection = fixture::navigation().past.decisions[0].clone();
        let mut past = History::new();
        let few = selection.candidates.len();
        assert!(few > 0 && few * MOST_DECISIONS < MOST_CANDIDATES);
        for number in 0..MOST_DECISIONS as u64 + 5 {
            past.add_line(
                RunRecord::Decision(Decision {
                    number,
                    ..selection.clone()
                }),
                0,
            );
        }
        assert_eq!(
            (past.decisions().len(), past.decisions()[0].number),
            (MOST_DECISIONS, 5)
        );
        let many = vec![selection.candidates[0].clone(); 1000];
        for number in 0..500 {
            let candidates = many.clone();
            past.add_line(
                RunRecord::Decision(Decision {
                    number,
                    candidates,
                    ..selection.clone()
                }),
                0,
            );
        }
        assert_eq!((past.decisions().len(), past.decisions()[0].number), (400, 100));
    }

    #[test]
    fn dropped_lines_are_counted_as_missed() {
        let mut past = History::new();
        past.add_missed(3);
        past.add_line(RunRecord::retracted(0, "goon.command"), 2);
        assert_eq!(past.missed(), 5);
    }
}
