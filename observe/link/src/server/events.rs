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
/// Records of each kind kept for later queries.
const MAX_RECORDS: usize = 1000;
/// Their limit in bytes of JSON, approximately. A selection among hundreds lists each candidate, and a query
/// receives the last records as one message, which must be transferred before its receiver counts as blocked.
const MAX_RECORD_BYTES: usize = 4 << 20;
/// The limit of the selections that changed the choice and are older than those, in the same bytes: some thousands, which
/// is hours, since most selections change nothing.
const MAX_SWITCH_BYTES: usize = 2 << 20;

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
    /// Older selections that changed the choice, and their weight.
    switches: VecDeque<NumberedRecord>,
    switch_bytes: usize,
    /// The number of the last record.
    last: u64,
}

/// A record with its sequence number. A gap in the numbers is a lost record.
pub(super) struct NumberedRecord {
    pub(super) number: u64,
    pub(super) record: RunRecord,
}

impl Events {
    /// Events of an application, which are converted to records.
    #[must_use]
    pub fn of(application: &Application) -> Self {
        let application = Arc::new(application.clone());
        Self {
            queue: EventQueue::new(),
            make_records: Arc::new(move || Some(RecordBuilder::new(&application))),
        }
    }

    /// Events that arrive as records, for the replay of a recording.
    #[must_use]
    pub fn of_records() -> Self {
        Self {
            queue: EventQueue::new(),
            make_records: Arc::new(|| None),
        }
    }

    /// An observer of a running application. It never waits: if the queue is full, the oldest events are
    /// dropped, which the records' numbers show.
    #[must_use]
    pub fn observer(&self) -> Box<dyn Observer> {
        let queue = Arc::clone(&self.queue);
        Box::new(move |event: &Event| queue.push(QueuedItem::Event(event.clone())))
    }

    /// Adds a record.
    pub fn push(&self, record: RunRecord) {
        self.queue.push(QueuedItem::Record(record));
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

    fn push(&self, item: QueuedItem) {
        if self.pending.force_push(item).is_some() {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl EventHistory {
    /// Processes the collected events and calls `publish` with each new record.
    pub(super) fn process(&mut self, mut publish: impl FnMut(RecordKind, &NumberedRecord)) {
        // At most the events present at the start, so that a busy application does not occupy the worker.
        for _ in 0..self.queue.pending.len() {
            let Some(item) = self.queue.pending.pop() else {
                break;
            };
            // The kinds of the lost events are unknown, so the numbers of every kind skip them.
            let lost = self.queue.lost.swap(0, Ordering::Relaxed);
            self.kinds.iter_mut().for_each(|kind| kind.last += lost);
            let records = match (item, &mut self.records) {
                (QueuedItem::Event(event), Some(builder)) => builder.process(&event),
                (QueuedItem::Event(_), None) => Vec::new(),
                (QueuedItem::Record(record), _) => vec![record],
            };
            for record in records {
                let kind = record.kind();
                publish(kind, self.kinds[kind as usize].add(record));
            }
        }
    }

    /// The last records of a kind, oldest first, as JSON: a list of `{"number": 17, "line": {...}}`. Where more of them are
    /// requested than all of the newest, selections that changed the choice come before those.
    pub(super) fn last(&self, kind: RecordKind, count: usize) -> Vec<u8> {
        let KindHistory {
            records, switches, ..
        } = &self.kinds[kind as usize];
        let left_out = (records.len() + switches.len()).saturating_sub(count);
        let mut json = vec![b'['];
        for NumberedRecord { number, record } in switches.iter().chain(records).skip(left_out) {
            if json.len() > 1 {
                json.push(b',');
            }
            json.extend_from_slice(format!("{{\"number\":{number},\"line\":").as_bytes());
            json.extend_from_slice(&record.to_json());
            json.push(b'}');
        }
        json.push(b']');
        json
    }
}

impl KindHistory {
    fn add(&mut self, record: RunRecord) -> &NumberedRecord {
        self.last += 1;
        self.bytes += weight(&record);
        self.records.push_back(NumberedRecord {
            number: self.last,
            record,
        });
        // The newest record stays, whatever its weight.
        while (self.records.len() > MAX_RECORDS || (self.bytes > MAX_RECORD_BYTES && self.records.len() > 1))
            && let Some(oldest) = self.records.pop_front()
        {
            let weight = weight(&oldest.record);
            self.bytes -= weight;
            if matches!(&oldest.record, RunRecord::Decision(decision) if decision.changed) {
                self.switch_bytes += weight;
                self.switches.push_back(oldest);
            }
        }
        while self.switch_bytes > MAX_SWITCH_BYTES
            && let Some(oldest) = self.switches.pop_front()
        {
            self.switch_bytes -= weight(&oldest.record);
        }
        &self.records[self.records.len() - 1]
    }
}

/// The approximate number of bytes of a record's JSON, without writing it.
fn weight(record: &RunRecord) -> usize {
    const PLAIN: usize = 200;
    match record {
        RunRecord::Decision(decision) => {
            let candidates = decision.candidates.iter();
            let each = candidates
                .map(|candidate| candidate.name.len() + 64)
                .sum::<usize>();
            PLAIN + decision.reason.len() + decision.cause.len() + each
        }
        RunRecord::State(_) => PLAIN,
        RunRecord::Other(event) => PLAIN + event.text().len(),
    }
}

#[cfg(test)]
mod tests {
    use jde_core::{Case, State};
    use jde_records::{CandidateRecord, DecidedBy, Decision};

    use super::*;

    fn decision(candidates: usize) -> RunRecord {
        let candidate = |number: usize| CandidateRecord {
            name: format!("listener{number}"),
            state: State::Checking,
            ready: false,
            urgency: Some(0.0),
        };
        RunRecord::Decision(Decision {
            number: 1,
            time_s: 1.25,
            group: "roots".to_owned(),
            case: Case::Collision,
            candidates: (0..candidates).map(candidate).collect(),
            before: None,
            choice: Some("listener0".to_owned()),
            decider: DecidedBy::Policy("priority".to_owned()),
            reason: "the first of the ready in the father's order".to_owned(),
            cause: "the readiness of listener0 changed".to_owned(),
            changed: true,
            takeover_us: None,
            refused: Vec::new(),
        })
    }

    #[test]
    fn the_newest_records_are_kept_up_to_a_number_and_a_size() {
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
        let json: usize = long
            .records
            .iter()
            .map(|record| record.record.to_json().len())
            .sum();
        assert!(
            json <= MAX_RECORD_BYTES && json > MAX_RECORD_BYTES / 2,
            "{json} bytes"
        );
        assert_eq!(long.records.back().map(|record| record.number), Some(200));
        let huge = long.add(decision(100_000)).number;
        assert_eq!((long.records.len(), huge), (1, 201));
    }

    #[test]
    fn switches_are_kept_when_the_selections_around_them_are_not() {
        let mut history = Events::of_records().history();
        let kept = &mut history.kinds[RecordKind::Decision as usize];
        for number in 0..100_000 {
            let RunRecord::Decision(selection) = decision(3) else {
                unreachable!("it is a selection");
            };
            let changed = number % 100 == 0;
            kept.add(RunRecord::Decision(Decision { changed, ..selection }));
        }
        assert_eq!((kept.records.len(), kept.switches.len()), (MAX_RECORDS, 990));
        for _ in 0..20_000 {
            kept.add(decision(3));
        }
        assert!(kept.switch_bytes <= MAX_SWITCH_BYTES && kept.switches.len() > 3000);
        let numbers = |count: usize| -> Vec<u64> {
            let json: serde_json::Value =
                serde_json::from_slice(&history.last(RecordKind::Decision, count)).unwrap();
            let records = json.as_array().unwrap().iter();
            records.map(|record| record["number"].as_u64().unwrap()).collect()
        };
        assert_eq!(numbers(2), [119_999, 120_000]);
        assert_eq!(numbers(MAX_RECORDS + 1).len(), MAX_RECORDS + 1);
        assert!(numbers(usize::MAX).is_sorted());
    }

    #[test]
    fn the_weight_of_a_record_approximates_its_size_in_json() {
        for candidates in [1, 10, 500] {
            let record = decision(candidates);
            let (weight, json) = (weight(&record) as f64, record.to_json().len() as f64);
            assert!((0.8..1.5).contains(&(weight / json)), "{weight} for {json}");
        }
    }
}
