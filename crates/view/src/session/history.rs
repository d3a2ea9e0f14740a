//! What has happened: the states of every schema over time, selections and events. Bounded; the oldest goes first.

use std::collections::{HashMap, VecDeque};

use jde_core::State;
use jde_host::snapshot::Snapshot;
use jde_host::story::{Decision, Happening, Line};

/// How many of each are kept.
const MOST_DECISIONS: usize = 20_000;
/// And of how many candidates they may tell: those of a group of hundreds would fill the memory long before.
const MOST_CANDIDATES: usize = 400_000;
const MOST_HAPPENINGS: usize = 20_000;
/// Bands of one schema.
const MOST_BANDS: usize = 20_000;

/// A time during which a schema was in one state; it lasts until the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StateInterval {
    /// s since the application's start.
    pub(crate) from: f64,
    /// Its state since.
    pub(crate) state: State,
}

/// What has happened as far as it is kept.
#[derive(Debug, Default)]
pub(crate) struct History {
    bands: HashMap<String, VecDeque<StateInterval>>,
    decisions: VecDeque<Decision>,
    /// Of all of them.
    candidates: usize,
    happenings: VecDeque<Happening>,
    progress: Progress,
    missed: u64,
    since: Option<f64>,
    last: f64,
}

/// How much has been heard: whoever remembers it knows what is new, and whether what he remembers still counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Progress {
    /// Times that a recording went back.
    pub(crate) turns: u64,
    /// Selections, with those that are no longer kept.
    pub(crate) decisions: u64,
    /// Events, with those that are no longer kept.
    pub(crate) happenings: u64,
}

impl History {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// A line, and how many before it did not come.
    pub(crate) fn add_line(&mut self, line: Line, missed: u64) {
        self.missed += missed;
        match line {
            Line::Change(change) => {
                let Some(state) = state(&change.to) else { return };
                let before = state_or_slept(&change.from);
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
                        from: change.time_s,
                        state,
                    },
                );
            }
            Line::Decision(decision) => {
                self.progress.decisions += 1;
                self.decide(decision);
            }
            Line::Happening(happening) => {
                self.progress.happenings += 1;
                keep(&mut self.happenings, happening, MOST_HAPPENINGS);
            }
        }
    }

    fn decide(&mut self, decision: Decision) {
        self.candidates += decision.candidates.len();
        self.decisions.push_back(decision);
        while self.decisions.len() > MOST_DECISIONS || self.candidates > MOST_CANDIDATES {
            let Some(oldest) = self.decisions.pop_front() else {
                break;
            };
            self.candidates -= oldest.candidates.len();
        }
    }

    /// So many lines did not come to be heard.
    pub(crate) fn add_missed(&mut self, lines: u64) {
        self.missed += lines;
    }

    /// A snapshot: what lines did not tell is made up for.
    pub(crate) fn add_snapshot(&mut self, snapshot: &Snapshot) {
        let now = snapshot.time as f64 / 1e9;
        self.rewind(now);
        self.last = now;
        self.since = Some(self.since.map_or(now, |since| since.min(now)));
        for view in &snapshot.schemas {
            if let Some(bands) = self.bands.get_mut(&view.name) {
                // Lines come before the snapshot that shows what they tell, or are lost.
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

    /// A recording went back: what was ahead has not happened yet.
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
        self.happenings.retain(|happening| happening.time_s <= now);
        self.last = now;
        self.progress.turns += 1;
    }

    /// The bands of a schema, oldest first.
    pub(crate) fn states(&self, schema: &str) -> Option<&VecDeque<StateInterval>> {
        self.bands.get(schema)
    }

    /// Selections, oldest first.
    pub(crate) fn decisions(&self) -> &VecDeque<Decision> {
        &self.decisions
    }

    /// Events, oldest first.
    pub(crate) fn happenings(&self) -> &VecDeque<Happening> {
        &self.happenings
    }

    /// How much has been heard.
    pub(crate) fn progress(&self) -> Progress {
        self.progress
    }

    /// When looking began, s since the application's start.
    pub(crate) fn since(&self) -> Option<f64> {
        self.since
    }

    /// Lines that did not come: the network or this machine was too slow.
    pub(crate) fn missed(&self) -> u64 {
        self.missed
    }
}

fn push(bands: &mut VecDeque<StateInterval>, band: StateInterval) {
    match bands.back_mut() {
        // Two changes at one instant: the last stays.
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

fn state(word: &str) -> Option<State> {
    Some(match word {
        "slept" => State::Slept,
        "checking" => State::Checking,
        "ready" => State::Ready,
        "winner" => State::Winner,
        _ => return None,
    })
}

fn state_or_slept(word: &str) -> State {
    state(word).unwrap_or(State::Slept)
}

#[cfg(test)]
mod tests {
    use jde_abi::describe::Kind;
    use jde_host::story::Change;

    use super::*;
    use crate::window::scope::fixture;

    fn see(past: &mut History, seconds: f64, state: State) {
        let mut schema = fixture::schema("goon", Kind::Motor, None, Some(0));
        schema.state = state;
        past.add_snapshot(&Snapshot {
            time: (seconds * 1e9) as u64,
            schemas: vec![schema],
            groups: Vec::new(),
        });
    }

    fn wins(past: &mut History, seconds: f64) {
        let change = Change {
            time_s: seconds,
            schema: "goon".to_owned(),
            from: "ready".to_owned(),
            to: "winner".to_owned(),
        };
        past.add_line(Line::Change(change), 0);
    }

    #[test]
    fn a_recording_that_goes_back_in_small_steps_forgets_what_is_ahead() {
        let mut past = History::new();
        see(&mut past, 8.0, State::Ready);
        wins(&mut past, 9.2);
        see(&mut past, 10.0, State::Winner);
        see(&mut past, 9.5, State::Winner);
        see(&mut past, 9.0, State::Ready);
        let bands = past.states("goon").expect("it is known");
        let inbox: Vec<_> = bands.iter().map(|band| (band.from, band.state)).collect();
        assert_eq!(inbox, [(8.0, State::Ready)]);
        assert_eq!(past.progress().turns, 2);
        wins(&mut past, 9.2);
        see(&mut past, 9.3, State::Winner);
        assert_eq!(
            past.states("goon").map(VecDeque::len),
            Some(2),
            "and hears it again"
        );
        see(&mut past, 2.0, State::Ready);
        assert_eq!(past.since(), Some(2.0), "looking began there by now");
    }

    #[test]
    fn selections_among_hundreds_are_kept_by_how_much_they_tell() {
        let one = fixture::navigation().past.decisions[0].clone();
        let mut past = History::new();
        let few = one.candidates.len();
        assert!(few > 0 && few * MOST_DECISIONS < MOST_CANDIDATES);
        for number in 0..MOST_DECISIONS as u64 + 5 {
            past.add_line(
                Line::Decision(Decision {
                    number,
                    ..one.clone()
                }),
                0,
            );
        }
        assert_eq!(
            (past.decisions().len(), past.decisions()[0].number),
            (MOST_DECISIONS, 5)
        );
        let many = vec![one.candidates[0].clone(); 1000];
        for number in 0..500 {
            let candidates = many.clone();
            past.add_line(
                Line::Decision(Decision {
                    number,
                    candidates,
                    ..one.clone()
                }),
                0,
            );
        }
        assert_eq!((past.decisions().len(), past.decisions()[0].number), (400, 100));
    }

    #[test]
    fn lines_that_were_dropped_are_counted_as_missed() {
        let mut past = History::new();
        past.add_missed(3);
        past.add_line(Line::Happening(Happening::default()), 2);
        assert_eq!(past.missed(), 5);
    }
}
