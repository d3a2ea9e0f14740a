//! The events of the application, for current subscribers and for later queries. The engine reports an event
//! while it holds the application's lock, so a report is a push into a queue and never more.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crossbeam_queue::ArrayQueue;
use jde_app::Application;
use jde_records::event::{Event, Observer};
use jde_records::{RecordBuilder, RecordKind, RunRecord};

/// Most events that wait for the worker: more than the busiest application has between two polls.
const MAX_PENDING: usize = 4096;
/// Lines of each kind kept for later queries.
const MAX_RECORDS: usize = 1000;
/// Their limit in bytes of JSON, approximately. A selection among hundreds lists each candidate, and a query
/// gets the last lines as one message, which must be transferred before its receiver counts as blocked.
const MAX_RECORD_BYTES: usize = 4 << 20;

/// Collects events and keeps them until the link has published them.
#[derive(Clone)]
pub struct Events {
    queue: Arc<EventQueue>,
    make_records: Arc<dyn Fn() -> Option<RecordBuilder> + Send + Sync>,
}

struct EventQueue {
    pending: ArrayQueue<QueuedItem>,
    lost: AtomicU64,
}

enum QueuedItem {
    Event(Event),
    Record(RunRecord),
}

/// The history of events.
pub(super) struct EventHistory {
    queue: Arc<EventQueue>,
    records: Option<RecordBuilder>,
    kinds: [KindHistory; RecordKind::ALL.len()],
}

#[derive(Default)]
struct KindHistory {
    records: VecDeque<NumberedRecord>,
    /// Their total weight.
    bytes: usize,
    /// The number of the last line.
    last: u64,
}

/// A line with its sequence number. A gap in the numbers is a lost line.
pub(super) struct NumberedRecord {
    pub(super) number: u64,
    pub(super) record: RunRecord,
}

impl Events {
    /// Events of an application, which become lines of its story.
    #[must_use]
    pub fn of(application: &Application) -> Self {
        let application = Arc::new(application.clone());
        Self {
            queue: EventQueue::new(),
            make_records: Arc::new(move || Some(RecordBuilder::new(&application))),
        }
    }

    /// Events that arrive as lines, for the replay of a recording.
    #[must_use]
    pub fn of_records() -> Self {
        Self {
            queue: EventQueue::new(),
            make_records: Arc::new(|| None),
        }
    }

    /// An observer of a running application. It never waits: without room the oldest events are dropped,
    /// which the numbers of the lines show.
    #[must_use]
    pub fn observer(&self) -> Box<dyn Observer> {
        let heard = Arc::clone(&self.queue);
        Box::new(move |event: &Event| heard.push(QueuedItem::Event(event.clone())))
    }

    /// Adds a line.
    pub fn push(&self, line: RunRecord) {
        self.queue.push(QueuedItem::Record(line));
    }

    pub(super) fn history(&self) -> EventHistory {
        EventHistory {
            queue: Arc::clone(&self.queue),
            records: (self.make_records)(),
            kinds: Default::default(),
        }
    }
}

impl EventQueue {
    fn new() -> Arc<Self> {
        Arc::new(Self {
            pending: ArrayQueue::new(MAX_PENDING),
            lost: AtomicU64::new(0),
        })
    }

    fn push(&self, happened: QueuedItem) {
        if self.pending.force_push(happened).is_some() {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl EventHistory {
    /// Processes the collected events; calls `tell` with each new line.
    pub(super) fn process(&mut self, mut tell: impl FnMut(RecordKind, &NumberedRecord)) {
        // At most the events present at the start, so that a busy application does not hold the worker here.
        for _ in 0..self.queue.pending.len() {
            let Some(happened) = self.queue.pending.pop() else {
                break;
            };
            // The kinds of the lost events are unknown, so the numbers of every kind skip them.
            let lost = self.queue.lost.swap(0, Ordering::Relaxed);
            self.kinds.iter_mut().for_each(|kind| kind.last += lost);
            let lines = match (happened, &mut self.records) {
                (QueuedItem::Event(event), Some(story)) => story.process(&event),
                (QueuedItem::Event(_), None) => Vec::new(),
                (QueuedItem::Record(line), _) => vec![line],
            };
            for line in lines {
                let kind = line.kind();
                tell(kind, self.kinds[kind as usize].add(line));
            }
        }
    }

    /// The last lines of a kind, oldest first, as JSON: a list of `{"number": 17, "line": {...}}`.
    pub(super) fn last(&self, kind: RecordKind, count: usize) -> Vec<u8> {
        let lines = &self.kinds[kind as usize].records;
        let mut json = vec![b'['];
        for NumberedRecord { number, record: line } in lines.range(lines.len().saturating_sub(count)..) {
            if json.len() > 1 {
                json.push(b',');
            }
            json.extend_from_slice(format!("{{\"number\":{number},\"line\":").as_bytes());
            json.extend_from_slice(&line.to_json());
            json.push(b'}');
        }
        json.push(b']');
        json
    }
}

impl KindHistory {
    fn add(&mut self, line: RunRecord) -> &NumberedRecord {
        self.last += 1;
        self.bytes += weight(&line);
        self.records.push_back(NumberedRecord {
            number: self.last,
            record: line,
        });
        // The newest line stays, whatever its weight.
        while self.records.len() > MAX_RECORDS || (self.bytes > MAX_RECORD_BYTES && self.records.len() > 1) {
            let oldest = self.records.pop_front();
            self.bytes -= oldest.map_or(0, |oldest| weight(&oldest.record));
        }
        &self.records[self.records.len() - 1]
    }
}

/// The approximate number of bytes of a line's JSON, without writing it.
fn weight(line: &RunRecord) -> usize {
    const PLAIN: usize = 200;
    match line {
        RunRecord::Decision(decision) => {
            let candidates = decision.candidates.iter();
            let each = candidates
                .map(|candidate| candidate.name.len() + 64)
                .sum::<usize>();
            PLAIN + decision.reason.len() + decision.cause.len() + each
        }
        RunRecord::State(_) => PLAIN,
        RunRecord::Event(happening) => PLAIN + happening.text.len(),
    }
}

#[cfg(test)]
mod tests {
    use jde_records::{CandidateRecord, Decision};

    use super::*;

    fn decision(candidates: usize) -> RunRecord {
        let candidate = |number: usize| CandidateRecord {
            name: format!("listener{number}"),
            state: "checking".to_owned(),
            ready: false,
            urgency: Some(0.0),
        };
        RunRecord::Decision(Decision {
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
        let mut short = KindHistory::default();
        for _ in 0..2 * MAX_RECORDS {
            short.add(decision(3));
        }
        assert_eq!(
            (short.records.len(), short.records[0].number),
            (MAX_RECORDS, MAX_RECORDS as u64 + 1)
        );
        let mut long = KindHistory::default();
        for _ in 0..200 {
            long.add(decision(500));
        }
        let json: usize = long.records.iter().map(|kept| kept.record.to_json().len()).sum();
        assert!(
            json <= MAX_RECORD_BYTES && json > MAX_RECORD_BYTES / 2,
            "{json} bytes"
        );
        assert_eq!(long.records.back().map(|kept| kept.number), Some(200));
        let huge = long.add(decision(100_000)).number;
        assert_eq!((long.records.len(), huge), (1, 201));
    }

    #[test]
    fn a_line_weighs_about_as_much_as_it_is_long() {
        for candidates in [1, 10, 500] {
            let line = decision(candidates);
            let (weight, json) = (weight(&line) as f64, line.to_json().len() as f64);
            assert!((0.8..1.5).contains(&(weight / json)), "{weight} for {json}");
        }
    }
}
