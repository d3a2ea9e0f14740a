//! Merges past and new events into one order, without duplicates, and counts missing ones.

use std::sync::{Arc, Mutex, PoisonError};

use jde_records::{RecordKind, RunRecord};
use serde::Deserialize;

use crate::attachment;

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

/// An event as the application stores it.
#[derive(Deserialize)]
pub(super) struct StoredEvent {
    number: u64,
    line: serde_json::Value,
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
    pub(super) fn new(call: Callback) -> Arc<Self> {
        Arc::new(Self {
            state: Mutex::new(MergeState {
                callback: call,
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
    ) -> Result<(), String> {
        let number = attachment
            .and_then(attachment::number)
            .ok_or("a line without its number")?;
        let line = RunRecord::parse(kind, message).map_err(|error| error.to_string())?;
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        match &mut state.pending {
            Some(waiting) => {
                if waiting.len() == MAX_PENDING {
                    waiting.remove(0);
                }
                waiting.push((number, line));
            }
            None => state.deliver(number, line),
        }
        Ok(())
    }

    /// Delivers the past events, then those that arrived meanwhile, and from then on each on arrival.
    pub(super) fn begin(&self, earlier: Vec<(RecordKind, StoredEvent)>) -> Result<(), String> {
        let mut lines = Vec::with_capacity(earlier.len());
        for (kind, StoredEvent { number, line }) in earlier {
            let json = line.to_string();
            let line = RunRecord::parse(kind, json.as_bytes()).map_err(|error| error.to_string())?;
            lines.push((number, line));
        }
        // Each kind is in order already.
        lines.sort_by_key(|(_, line)| line.time());
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        lines.extend(state.pending.take().unwrap_or_default());
        for (number, line) in lines {
            state.deliver(number, line);
        }
        Ok(())
    }
}

impl MergeState {
    fn deliver(&mut self, number: u64, line: RunRecord) {
        let last = &mut self.last[line.kind() as usize];
        if last.is_some_and(|last| number <= last) {
            return;
        }
        let missed = last.map_or(0, |last| number - last - 1);
        *last = Some(number);
        (self.callback)(ReceivedEvent {
            record: line,
            number,
            missed,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(time_ms: u64) -> RunRecord {
        RunRecord::retracted(time_ms * 1_000_000, "pioneer.laser")
    }

    fn numbered(number: u64) -> (RecordKind, StoredEvent) {
        let line = serde_json::from_slice(&line(number).to_json()).unwrap();
        (RecordKind::Event, StoredEvent { number, line })
    }

    #[test]
    fn what_was_told_before_comes_first_and_nothing_twice() {
        let told = Arc::new(Mutex::new(Vec::new()));
        let tell = Arc::clone(&told);
        let merge = EventMerger::new(Box::new(move |happened: ReceivedEvent| {
            tell.lock().unwrap().push((happened.number, happened.missed));
        }));
        let hear = |number: u64| {
            merge
                .push(
                    RecordKind::Event,
                    &line(number).to_json(),
                    Some(&number.to_le_bytes()),
                )
                .unwrap();
        };
        hear(3);
        hear(4);
        merge.begin(vec![numbered(2), numbered(3)]).unwrap();
        hear(4);
        hear(7);
        assert_eq!(*told.lock().unwrap(), [(2, 0), (3, 0), (4, 0), (7, 2)]);
        assert!(merge.push(RecordKind::Decision, b"{", Some(&[0; 8])).is_err());
        assert!(merge.push(RecordKind::Event, &line(9).to_json(), None).is_err());
    }
}
