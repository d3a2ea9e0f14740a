//! Merges past and new events into one order, without duplicates, and counts missing ones.

use std::sync::Arc;

use parking_lot::Mutex;

use crate::attachment;
use crate::decode::{self, Refused};
use jde_records::{RecordKind, RunRecord};

/// Most new events kept while past ones are fetched. Of more, the oldest are dropped and counted as missing.
const MAX_PENDING: usize = 4096;

/// An event.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceivedEvent {
    /// The event.
    pub record: RunRecord,
    /// Its sequence number among events of its kind.
    pub number: u64,
    /// Upper bound of the events of this kind lost since the previous one.
    pub missed: u64,
}

type Callback = Box<dyn FnMut(ReceivedEvent) + Send>;

/// Merges the events of all kinds.
pub(super) struct EventMerger {
    state: Mutex<MergeState>,
}

struct MergeState {
    callback: Callback,
    last: [Option<u64>; RecordKind::ALL.len()],
    /// Events that arrived while past ones were fetched.
    pending: Option<Vec<(u64, RunRecord)>>,
}

impl EventMerger {
    pub(super) fn new(callback: Callback) -> Arc<Self> {
        Arc::new(Self {
            state: Mutex::new(MergeState {
                callback,
                last: [None; RecordKind::ALL.len()],
                pending: Some(Vec::new()),
            }),
        })
    }

    /// Accepts a published event.
    pub(super) fn push(
        &self,
        kind: RecordKind,
        message: &[u8],
        attachment: Option<&[u8]>,
    ) -> Result<(), Refused> {
        let number = attachment
            .and_then(attachment::number)
            .ok_or_else(|| Refused::Unreadable("an event without its number".to_owned()))?;
        let record = decode::record(kind, message)?;
        let mut state = self.state.lock();
        match &mut state.pending {
            Some(pending) => {
                if pending.len() == MAX_PENDING {
                    pending.remove(0);
                }
                pending.push((number, record));
            }
            None => state.deliver(number, record),
        }
        Ok(())
    }

    /// Delivers the past events, then those that arrived meanwhile, and from then on each on arrival.
    pub(super) fn begin(&self, mut records: Vec<(u64, RunRecord)>) {
        // Each kind is in order already.
        records.sort_by_key(|(_, record)| record.time());
        let mut state = self.state.lock();
        let arrived = state.pending.take().unwrap_or_default();
        for (number, record) in records {
            // What lies between past events is kept no more, and was not lost on its way.
            let last = &mut state.last[record.kind() as usize];
            if last.is_some_and(|last| last < number) {
                *last = Some(number - 1);
            }
            state.deliver(number, record);
        }
        for (number, record) in arrived {
            state.deliver(number, record);
        }
    }
}

impl MergeState {
    fn deliver(&mut self, number: u64, record: RunRecord) {
        let last = &mut self.last[record.kind() as usize];
        if last.is_some_and(|last| number <= last) {
            return;
        }
        let missed = last.map_or(0, |last| number - last - 1);
        *last = Some(number);
        (self.callback)(ReceivedEvent {
            record,
            number,
            missed,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(time_ms: u64) -> RunRecord {
        RunRecord::retracted(time_ms * 1_000_000, "pioneer.laser")
    }

    #[test]
    fn past_events_come_first_and_none_is_delivered_twice() {
        let delivered = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&delivered);
        let merger = EventMerger::new(Box::new(move |event: ReceivedEvent| {
            sink.lock().push((event.number, event.missed));
        }));
        let push = |number: u64| {
            merger
                .push(
                    RecordKind::Event,
                    &record(number).to_json(),
                    Some(&number.to_le_bytes()),
                )
                .unwrap();
        };
        push(3);
        push(4);
        merger.begin(vec![(1, record(1)), (3, record(3))]);
        push(4);
        push(7);
        assert_eq!(*delivered.lock(), [(1, 0), (3, 0), (4, 0), (7, 2)]);
        assert!(merger.push(RecordKind::Decision, b"{", Some(&[0; 8])).is_err());
        assert!(
            merger
                .push(RecordKind::Event, &record(9).to_json(), None)
                .is_err()
        );
    }
}
