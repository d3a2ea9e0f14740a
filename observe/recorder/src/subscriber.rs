//! Watches a variable for a recording. It runs on the thread of the variable's publisher and never waits for
//! another thread.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use jde_board::{Access, LASTING, Nanos, Reader, Variable, Watch};
use jde_log::topic_name;
use parking_lot::Mutex;

use crate::recorder::Clock;
use crate::topic::{FetchFlag, Notice, Shared, Stamps, Topic, TopicContent, TopicQueue};

/// Larger values, in bytes, are fetched by the writing thread instead of copied by their publisher. Copying
/// this many bytes takes a few microseconds.
const FETCHED_BYTES: usize = 32 << 10;

/// The state of a variable's watch.
struct Subscriber {
    topic: Topic,
    clock: Clock,
    /// Publications that are not yet processed. The thread that increments it from zero processes them,
    /// including those that are added during the processing.
    pending: AtomicU32,
    /// Never contended, because of `pending`.
    state: Mutex<ReaderState>,
}

struct ReaderState {
    reader: Reader,
    tracker: SequenceTracker,
}

/// The values of a variable that have been seen. It detects gaps and retractions.
pub(crate) struct SequenceTracker {
    /// The number of the first value that could be seen.
    first: u64,
    last: Option<u64>,
    has_value: bool,
}

/// The change of a variable since the last check.
pub(crate) enum ValueChange {
    /// Nothing has changed.
    Unchanged,
    /// A new value, with the number of values between it and the last one seen, which were missed.
    Value(u64),
    /// The value was retracted.
    Retracted,
}

/// Copies every value of a variable to a topic, including the present one, until the watch is dropped. Files
/// contain them only if `is_recorded` is true.
pub(crate) fn watch(
    variable: &Arc<Variable>,
    shared: &Arc<Shared>,
    clock: Clock,
    is_recorded: bool,
) -> (Topic, Watch) {
    let declared = variable.describe();
    let metadata = BTreeMap::from([
        ("variable".to_owned(), declared.full_name()),
        ("access".to_owned(), access(declared.access).to_owned()),
        ("doc".to_owned(), declared.doc.clone()),
        ("unit".to_owned(), declared.unit.clone()),
        ("validity".to_owned(), validity(declared.access)),
    ]);
    let fetch_flag = (declared.value_type.bytes > FETCHED_BYTES && !shared.lossless).then(|| FetchFlag {
        variable: Arc::clone(variable),
        first: variable.newest(),
        is_new: true.into(),
        published: clock().into(),
    });
    let name = topic_name(&declared.full_name());
    let value_type = Arc::clone(&declared.value_type);
    let topic = Topic {
        queue: Arc::new(TopicQueue::new(
            name,
            TopicContent::Values(value_type),
            metadata,
            fetch_flag,
            is_recorded,
        )),
        shared: Arc::clone(shared),
    };
    let watch = if topic.queue.fetch_flag.is_some() {
        let topic = topic.clone();
        variable.watch(move || {
            if let Some(flag) = &topic.queue.fetch_flag {
                flag.published.store(clock(), Ordering::Relaxed);
                flag.is_new.store(true, Ordering::Release);
                topic.shared.wake();
            }
        })
    } else {
        let subscriber = Arc::new(Subscriber {
            topic: topic.clone(),
            clock,
            pending: AtomicU32::new(0),
            state: Mutex::new(ReaderState {
                reader: variable.reader("recording"),
                tracker: SequenceTracker::starting_at(variable.newest()),
            }),
        });
        let notified = Arc::clone(&subscriber);
        let watch = variable.watch(move || notified.poll());
        subscriber.poll();
        watch
    };
    (topic, watch)
}

/// Returns how long a value is valid or in force after it was published (R19, R7): "150ms", or "lasting".
fn validity(access: Access) -> String {
    match access {
        Access::Export { validity } | Access::Command { validity } if validity != LASTING => {
            format!("{}ms", validity as f64 / 1e6)
        }
        Access::Export { .. } | Access::Command { .. } | Access::Modulation => "lasting".to_owned(),
    }
}

fn access(access: Access) -> &'static str {
    match access {
        Access::Export { .. } => "export",
        Access::Modulation => "modulation",
        Access::Command { .. } => "command",
    }
}

impl Subscriber {
    fn poll(&self) {
        if self.pending.fetch_add(1, Ordering::AcqRel) != 0 {
            return;
        }
        let mut expected = 1;
        loop {
            if let Some(mut state) = self.state.try_lock() {
                self.read_value(&mut state);
            }
            match self
                .pending
                .compare_exchange(expected, 0, Ordering::AcqRel, Ordering::Acquire)
            {
                Ok(_) => return,
                Err(pending) => expected = pending,
            }
        }
    }

    fn read_value(&self, state: &mut ReaderState) {
        let now = (self.clock)();
        let latched = state.reader.latch(now);
        match state
            .tracker
            .update(latched.map(|latched| latched.stamp.sequence))
        {
            ValueChange::Unchanged => {}
            ValueChange::Value(missed) => {
                self.topic.add_lost(missed);
                if let Some(latched) = latched {
                    let stamps = Stamps {
                        published: now,
                        measured: latched.stamp.time,
                        sequence: latched.stamp.sequence,
                    };
                    self.topic.put(latched.bytes, stamps);
                }
            }
            ValueChange::Retracted => self
                .topic
                .shared
                .push_notice(retraction_notice(now, &self.topic.queue)),
        }
        state.reader.release();
    }
}

/// Returns the notice that the value of a topic was retracted.
pub(crate) fn retraction_notice(time: Nanos, queue: &TopicQueue) -> Notice {
    let variable = queue.metadata.get("variable").unwrap_or(&queue.name).clone();
    Notice::Retracted { time, variable }
}

impl SequenceTracker {
    /// Starts with nothing seen of a variable whose newest value has this number.
    pub(crate) fn starting_at(newest: u64) -> Self {
        Self {
            // Numbers start at 1.
            first: newest.max(1),
            last: None,
            has_value: false,
        }
    }

    /// Compares the number of the newest value, if there is one, with what has been seen.
    pub(crate) fn update(&mut self, newest: Option<u64>) -> ValueChange {
        let Some(newest) = newest else {
            return if std::mem::take(&mut self.has_value) {
                ValueChange::Retracted
            } else {
                ValueChange::Unchanged
            };
        };
        self.has_value = true;
        let last = self.last.replace(newest);
        match last {
            None => ValueChange::Value(newest.saturating_sub(self.first)),
            Some(last) if newest > last => ValueChange::Value(newest - last - 1),
            Some(_) => ValueChange::Unchanged,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_before_the_first_check_are_counted() {
        assert!(matches!(
            SequenceTracker::starting_at(0).update(Some(0)),
            ValueChange::Value(0)
        ));
        assert!(matches!(
            SequenceTracker::starting_at(0).update(Some(4)),
            ValueChange::Value(3)
        ));
        assert!(matches!(
            SequenceTracker::starting_at(2).update(Some(4)),
            ValueChange::Value(2)
        ));
    }

    #[test]
    fn gaps_are_counted_and_a_retraction_is_reported_once() {
        let mut tracker = SequenceTracker::starting_at(3);
        assert!(matches!(tracker.update(None), ValueChange::Unchanged));
        assert!(matches!(tracker.update(Some(3)), ValueChange::Value(0)));
        assert!(matches!(tracker.update(Some(3)), ValueChange::Unchanged));
        assert!(matches!(tracker.update(Some(6)), ValueChange::Value(2)));
        assert!(matches!(tracker.update(None), ValueChange::Retracted));
        assert!(matches!(tracker.update(None), ValueChange::Unchanged));
        assert!(matches!(tracker.update(Some(7)), ValueChange::Value(0)));
    }
}
