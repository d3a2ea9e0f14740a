//! What a ring removes, and what stays in force.

use super::*;

fn value(channel: usize, log: Nanos, bytes: usize) -> Entry {
    Entry {
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

fn times(ring: &PreTriggerBuffer) -> Vec<Nanos> {
    (ring.first()..ring.next())
        .map(|number| ring.get(number).unwrap().times.log)
        .collect()
}

#[test]
fn what_is_older_than_the_time_goes_and_the_newest_of_it_stays_in_force() {
    let mut ring = PreTriggerBuffer::new(100, usize::MAX);
    for (channel, log) in [(0, 10), (1, 20), (1, 30), (0, 110), (1, 120)] {
        ring.push(value(channel, log, 8));
    }
    ring.expire(131, ring.next());
    assert_eq!(times(&ring), [110, 120]);
    let base: Vec<_> = ring
        .base()
        .map(|(channel, times, _)| (channel, times.log))
        .collect();
    assert_eq!(base, [(0, 10), (1, 30)]);
    assert_eq!((ring.first(), ring.next(), ring.evicted()), (3, 5, 0));
    assert!(ring.get(2).is_none() && ring.get(5).is_none());
}

#[test]
fn what_is_still_wanted_stays_and_memory_is_bounded_all_the_same() {
    let mut ring = PreTriggerBuffer::new(0, 10 * (OVERHEAD + 100));
    for log in 0..10 {
        ring.push(value(0, log, 100));
    }
    ring.expire(1000, 4);
    assert_eq!(times(&ring), [4, 5, 6, 7, 8, 9]);
    for log in 10..20 {
        ring.push(value(0, log, 100));
    }
    assert_eq!(times(&ring), (10..20).collect::<Vec<_>>());
    assert_eq!(ring.evicted(), 6);
    ring.push(value(0, 20, 5000));
    assert_eq!(times(&ring), [20], "the newest is always there");
}

#[test]
fn a_value_that_was_taken_back_is_not_in_force_and_states_are_told_apart() {
    let mut ring = PreTriggerBuffer::new(0, usize::MAX);
    ring.push(value(0, 1, 8));
    let mut entry = value(1, 2, 8);
    entry.content = Content::Retracted {
        of: 0,
        data: Arc::new([]),
    };
    ring.push(entry);
    for (log, name) in [(3, "goon"), (4, "stop"), (5, "goon")] {
        let mut entry = value(2, log, 8);
        entry.content = Content::Message {
            about: StateKey::Named(name.into()),
            data: Arc::new([]),
        };
        ring.push(entry);
    }
    ring.expire(1000, ring.next());
    let base: Vec<_> = ring
        .base()
        .map(|(channel, times, _)| (channel, times.log))
        .collect();
    assert_eq!(base, [(2, 5), (2, 4)], "the last of each, by name");
}
