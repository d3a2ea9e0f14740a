//! Tests of removal from the buffer, and of the values in force.

use super::*;

fn value(channel: usize, log: Nanos, bytes: usize) -> BufferedMessage {
    BufferedMessage {
        channel,
        times: Times {
            log,
            publish: log,
            sequence: log,
        },
        content: Content::Message {
            about: StateKey::Value,
            data: vec![0; bytes].into(),
        },
    }
}

fn times(buffer: &PreTriggerBuffer) -> Vec<Nanos> {
    (buffer.first()..buffer.next())
        .map(|number| buffer.get(number).unwrap().times.log)
        .collect()
}

#[test]
fn entries_expire_and_the_newest_expired_value_stays_in_force() {
    let mut buffer = PreTriggerBuffer::new(100, usize::MAX);
    for (channel, log) in [(0, 10), (1, 20), (1, 30), (0, 110), (1, 120)] {
        buffer.push(value(channel, log, 8));
    }
    buffer.expire(131, buffer.next());
    assert_eq!(times(&buffer), [110, 120]);
    let base: Vec<_> = buffer
        .base()
        .map(|(channel, times, _)| (channel, times.log))
        .collect();
    assert_eq!(base, [(0, 10), (1, 30)]);
    assert_eq!((buffer.first(), buffer.next(), buffer.evicted()), (3, 5, 0));
    assert!(buffer.get(2).is_none() && buffer.get(5).is_none());
}

#[test]
fn needed_entries_do_not_expire_and_memory_is_limited() {
    let mut buffer = PreTriggerBuffer::new(0, 10 * (MESSAGE_OVERHEAD + 100));
    for log in 0..10 {
        buffer.push(value(0, log, 100));
    }
    buffer.expire(1000, 4);
    assert_eq!(times(&buffer), [4, 5, 6, 7, 8, 9]);
    for log in 10..20 {
        buffer.push(value(0, log, 100));
    }
    assert_eq!(times(&buffer), (10..20).collect::<Vec<_>>());
    assert_eq!(buffer.evicted(), 6);
    buffer.push(value(0, 20, 5000));
    assert_eq!(times(&buffer), [20], "the newest entry is always kept");
}

#[test]
fn a_retracted_value_is_not_in_force_and_each_named_state_is() {
    let mut buffer = PreTriggerBuffer::new(0, usize::MAX);
    buffer.push(value(0, 1, 8));
    let mut entry = value(1, 2, 8);
    entry.content = Content::Retracted {
        of: 0,
        data: Arc::new([]),
    };
    buffer.push(entry);
    for (log, name) in [(3, "goon"), (4, "stop"), (5, "goon")] {
        let mut entry = value(2, log, 8);
        entry.content = Content::Message {
            about: StateKey::Named(name.into()),
            data: Arc::new([]),
        };
        buffer.push(entry);
    }
    buffer.expire(1000, buffer.next());
    let base: Vec<_> = buffer
        .base()
        .map(|(channel, times, _)| (channel, times.log))
        .collect();
    assert_eq!(base, [(2, 5), (2, 4)], "the last state of each name");
}
