//! The events of the application, for current subscribers and for later queries. The engine reports an event
//! while it holds the application's lock, so a report is a push into a queue and never more.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crossbeam_queue::ArrayQueue;
use jde_host::app::Application;
use jde_host::event::{Event, Observer};
use jde_host::story::{Kind, Line, Story};

/// Most events that wait for the worker: more than the busiest application has between two polls.
const WAITING: usize = 4096;
/// Lines of each kind kept for later queries.
const KEPT: usize = 1000;
/// Their limit in bytes of JSON, approximately. A selection among hundreds lists each candidate, and a query
/// gets the last lines as one message, which must be transferred before its receiver counts as blocked.
const KEPT_BYTES: usize = 4 << 20;

/// Collects events and keeps them until the link has published them.
#[derive(Clone)]
pub struct Events {
    heard: Arc<Heard>,
    story: Arc<dyn Fn() -> Option<Story> + Send + Sync>,
}

struct Heard {
    waiting: ArrayQueue<Happened>,
    lost: AtomicU64,
}

enum Happened {
    Event(Event),
    Line(Line),
}

/// The history of events.
pub(super) struct Chronicle {
    heard: Arc<Heard>,
    story: Option<Story>,
    kinds: [Kept; Kind::ALL.len()],
}

#[derive(Default)]
struct Kept {
    lines: VecDeque<Numbered>,
    /// Their total weight.
    bytes: usize,
    /// The number of the last line.
    last: u64,
}

/// A line with its sequence number. A gap in the numbers is a lost line.
pub(super) struct Numbered {
    pub(super) number: u64,
    pub(super) line: Line,
}

impl Events {
    /// Events of an application, which become lines of its story.
    #[must_use]
    pub fn of(application: &Application) -> Self {
        let application = Arc::new(application.clone());
        Self {
            heard: Heard::new(),
            story: Arc::new(move || Some(Story::new(&application))),
        }
    }

    /// Events that arrive as lines, for the replay of a recording.
    #[must_use]
    pub fn told() -> Self {
        Self {
            heard: Heard::new(),
            story: Arc::new(|| None),
        }
    }

    /// An observer of a running application. It never waits: without room the oldest events are dropped,
    /// which the numbers of the lines show.
    #[must_use]
    pub fn observer(&self) -> Box<dyn Observer> {
        let heard = Arc::clone(&self.heard);
        Box::new(move |event: &Event| heard.push(Happened::Event(event.clone())))
    }

    /// Adds a line.
    pub fn tell(&self, line: Line) {
        self.heard.push(Happened::Line(line));
    }

    pub(super) fn chronicle(&self) -> Chronicle {
        Chronicle {
            heard: Arc::clone(&self.heard),
            story: (self.story)(),
            kinds: Default::default(),
        }
    }
}

impl Heard {
    fn new() -> Arc<Self> {
        Arc::new(Self {
            waiting: ArrayQueue::new(WAITING),
            lost: AtomicU64::new(0),
        })
    }

    fn push(&self, happened: Happened) {
        if self.waiting.force_push(happened).is_some() {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Chronicle {
    /// Processes the collected events; calls `tell` with each new line.
    pub(super) fn catch_up(&mut self, mut tell: impl FnMut(Kind, &Numbered)) {
        // At most the events present at the start, so that a busy application does not hold the worker here.
        for _ in 0..self.heard.waiting.len() {
            let Some(happened) = self.heard.waiting.pop() else {
                break;
            };
            // The kinds of the lost events are unknown, so the numbers of every kind skip them.
            let lost = self.heard.lost.swap(0, Ordering::Relaxed);
            self.kinds.iter_mut().for_each(|kind| kind.last += lost);
            let lines = match (happened, &mut self.story) {
                (Happened::Event(event), Some(story)) => story.hear(&event),
                (Happened::Event(_), None) => Vec::new(),
                (Happened::Line(line), _) => vec![line],
            };
            for line in lines {
                let kind = line.kind();
                tell(kind, self.kinds[kind as usize].add(line));
            }
        }
    }

    /// The last lines of a kind, oldest first, as JSON: a list of `{"number": 17, "line": {...}}`.
    pub(super) fn last(&self, kind: Kind, count: usize) -> Vec<u8> {
        let lines = &self.kinds[kind as usize].lines;
        let mut json = vec![b'['];
        for Numbered { number, line } in lines.range(lines.len().saturating_sub(count)..) {
            if json.len() > 1 {
                json.push(b',');
            }
            json.extend_from_slice(format!("{{\"number\":{number},\"line\":").as_bytes());
            json.extend_from_slice(&line.json());
            json.push(b'}');
        }
        json.push(b']');
        json
    }
}

impl Kept {
    fn add(&mut self, line: Line) -> &Numbered {
        self.last += 1;
        self.bytes += weight(&line);
        self.lines.push_back(Numbered {
            number: self.last,
            line,
        });
        // The newest line stays, whatever its weight.
        while self.lines.len() > KEPT || (self.bytes > KEPT_BYTES && self.lines.len() > 1) {
            let oldest = self.lines.pop_front();
            self.bytes -= oldest.map_or(0, |oldest| weight(&oldest.line));
        }
        &self.lines[self.lines.len() - 1]
    }
}

/// The approximate number of bytes of a line's JSON, without writing it.
fn weight(line: &Line) -> usize {
    const PLAIN: usize = 200;
    match line {
        Line::Decision(decision) => {
            let candidates = decision.candidates.iter();
            let each = candidates
                .map(|candidate| candidate.name.len() + 64)
                .sum::<usize>();
            PLAIN + decision.reason.len() + decision.cause.len() + each
        }
        Line::Change(_) => PLAIN,
        Line::Happening(happening) => PLAIN + happening.text.len(),
    }
}

#[cfg(test)]
mod tests {
    use jde_host::story::{Candidate, Decision};

    use super::*;

    fn decision(candidates: usize) -> Line {
        let candidate = |number: usize| Candidate {
            name: format!("listener{number}"),
            state: "checking".to_owned(),
            ready: false,
            urgency: Some(0.0),
        };
        Line::Decision(Decision {
            number: 1,
            time_s: 1.25,
            group: "roots".to_owned(),
            case: "collision".to_owned(),
            candidates: (0..candidates).map(candidate).collect(),
            before: None,
            choice: Some("listener0".to_owned()),
            decider: "priority".to_owned(),
            reason: "the first of the ready in the father's order".to_owned(),
            cause: "the readiness of listener0 changed".to_owned(),
            changed: true,
            takeover_us: None,
        })
    }

    #[test]
    fn of_many_lines_and_of_long_ones_the_newest_are_kept() {
        let mut short = Kept::default();
        for _ in 0..2 * KEPT {
            short.add(decision(3));
        }
        assert_eq!(
            (short.lines.len(), short.lines[0].number),
            (KEPT, KEPT as u64 + 1)
        );
        let mut long = Kept::default();
        for _ in 0..200 {
            long.add(decision(500));
        }
        let json: usize = long.lines.iter().map(|kept| kept.line.json().len()).sum();
        assert!(json <= KEPT_BYTES && json > KEPT_BYTES / 2, "{json} bytes");
        assert_eq!(long.lines.back().map(|kept| kept.number), Some(200));
        let huge = long.add(decision(100_000)).number;
        assert_eq!((long.lines.len(), huge), (1, 201));
    }

    #[test]
    fn a_line_weighs_about_as_much_as_it_is_long() {
        for candidates in [1, 10, 500] {
            let line = decision(candidates);
            let (weight, json) = (weight(&line) as f64, line.json().len() as f64);
            assert!((0.8..1.5).contains(&(weight / json)), "{weight} for {json}");
        }
    }
}
