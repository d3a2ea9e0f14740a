//! Watches a variable for a recording. It runs on the thread of the variable's publisher and never waits for
//! another thread.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

use jde_board::{Access, Nanos, Reader, Variable, Watch};

use crate::lane::{Holds, Lane, Note, Shared, Stamps, Told, Topic};
use crate::recorder::Clock;

/// Larger values, in bytes, are fetched by the writing thread instead of copied by their publisher. Copying
/// this many bytes takes a few microseconds.
const LARGE: usize = 32 << 10;

/// The state of a variable's watch.
struct Tap {
    topic: Topic,
    clock: Clock,
    /// Publications that are not yet processed. The thread that increments it from zero processes them,
    /// including those that are added meanwhile.
    pending: AtomicU32,
    /// Never contended, because of `pending`.
    eye: Mutex<Eye>,
}

struct Eye {
    reader: Reader,
    seen: Seen,
}

/// The values of a variable that have been seen. It detects gaps and retractions.
pub(crate) struct Seen {
    /// The number of the first value that could be seen.
    first: u64,
    last: Option<u64>,
    shown: bool,
}

/// What has changed since the last look at a variable.
pub(crate) enum News {
    /// Nothing has changed.
    None,
    /// A new value, with the number of values between it and the last one seen, which were missed.
    Value(u64),
    /// The value was retracted.
    Retracted,
}

/// Copies every value of a variable to a topic, including the present one, until the watch is dropped. Files
/// contain them only if `kept` is true.
pub(crate) fn watch(
    variable: &Arc<Variable>,
    shared: &Arc<Shared>,
    clock: Clock,
    kept: bool,
) -> (Topic, Watch) {
    let declared = variable.describe();
    let about = BTreeMap::from([
        ("variable".to_owned(), declared.full_name()),
        ("access".to_owned(), access(declared.access).to_owned()),
        ("doc".to_owned(), declared.doc.clone()),
        ("unit".to_owned(), declared.unit.clone()),
    ]);
    let note = (declared.value_type.bytes > LARGE && !shared.lossless).then(|| Note {
        variable: Arc::clone(variable),
        since: variable.newest(),
        new: true.into(),
        published: clock().into(),
    });
    let name = topic_name(&declared.full_name());
    let value_type = Arc::clone(&declared.value_type);
    let topic = Topic {
        lane: Arc::new(Lane::new(name, Holds::Values(value_type), about, note, kept)),
        shared: Arc::clone(shared),
    };
    let watch = if topic.lane.note.is_some() {
        let topic = topic.clone();
        variable.watch(move || {
            if let Some(note) = &topic.lane.note {
                note.published.store(clock(), Ordering::Relaxed);
                note.new.store(true, Ordering::Release);
                topic.shared.wake();
            }
        })
    } else {
        let tap = Arc::new(Tap {
            topic: topic.clone(),
            clock,
            pending: AtomicU32::new(0),
            eye: Mutex::new(Eye {
                reader: variable.reader("recording"),
                seen: Seen::since(variable.newest()),
            }),
        });
        let called = Arc::clone(&tap);
        let watch = variable.watch(move || called.look());
        tap.look();
        watch
    };
    (topic, watch)
}

/// Converts `owner.name` to a topic name of ROS 2, `/owner/name`.
#[must_use]
pub fn topic_name(variable: &str) -> String {
    format!("/{}", variable.replace('.', "/"))
}

fn access(access: Access) -> &'static str {
    match access {
        Access::Export => "export",
        Access::Modulation => "modulation",
        Access::Command { .. } => "command",
    }
}

impl Tap {
    fn look(&self) {
        if self.pending.fetch_add(1, Ordering::AcqRel) != 0 {
            return;
        }
        let mut looked_for = 1;
        loop {
            if let Ok(mut eye) = self.eye.try_lock() {
                self.take(&mut eye);
            }
            match self
                .pending
                .compare_exchange(looked_for, 0, Ordering::AcqRel, Ordering::Acquire)
            {
                Ok(_) => return,
                Err(more) => looked_for = more,
            }
        }
    }

    fn take(&self, eye: &mut Eye) {
        let now = (self.clock)();
        let latched = eye.reader.latch();
        match eye.seen.news(latched.map(|latched| latched.stamp.sequence)) {
            News::None => {}
            News::Value(missed) => {
                self.topic.lose(missed);
                if let Some(latched) = latched {
                    let stamps = Stamps {
                        published: now,
                        measured: latched.stamp.time,
                        sequence: latched.stamp.sequence,
                    };
                    self.topic.put(latched.bytes, stamps);
                }
            }
            News::Retracted => self.topic.shared.tell(retracted(now, &self.topic.lane)),
        }
        eye.reader.release();
    }
}

/// Returns the notice that the value of a topic was retracted.
pub(crate) fn retracted(time: Nanos, lane: &Lane) -> Told {
    let variable = lane.about.get("variable").unwrap_or(&lane.name).clone();
    Told::Retracted { time, variable }
}

impl Seen {
    /// Starts with nothing seen of a variable whose newest value has this number.
    pub(crate) fn since(newest: u64) -> Self {
        Self {
            // Numbers start at 1.
            first: newest.max(1),
            last: None,
            shown: false,
        }
    }

    /// Compares the number of the newest value, if there is one, with what has been seen.
    pub(crate) fn news(&mut self, newest: Option<u64>) -> News {
        let Some(newest) = newest else {
            return if std::mem::take(&mut self.shown) {
                News::Retracted
            } else {
                News::None
            };
        };
        self.shown = true;
        let last = self.last.replace(newest);
        match last {
            None => News::Value(newest.saturating_sub(self.first)),
            Some(last) if newest > last => News::Value(newest - last - 1),
            Some(_) => News::None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_came_before_the_first_look_is_counted() {
        assert!(matches!(Seen::since(0).news(Some(0)), News::Value(0)));
        assert!(matches!(Seen::since(0).news(Some(4)), News::Value(3)));
        assert!(matches!(Seen::since(2).news(Some(4)), News::Value(2)));
    }

    #[test]
    fn gaps_are_counted_and_a_value_taken_back_is_told_once() {
        let mut seen = Seen::since(3);
        assert!(matches!(seen.news(None), News::None));
        assert!(matches!(seen.news(Some(3)), News::Value(0)));
        assert!(matches!(seen.news(Some(3)), News::None));
        assert!(matches!(seen.news(Some(6)), News::Value(2)));
        assert!(matches!(seen.news(None), News::Retracted));
        assert!(matches!(seen.news(None), News::None));
        assert!(matches!(seen.news(Some(7)), News::Value(0)));
    }
}
