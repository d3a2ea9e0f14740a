//! The cells under loom, which checks the interleavings of a few threads and the stale values that the memory
//! model allows. Run by `RUSTFLAGS="--cfg loom" cargo test -p jde-board --release --test loom`; empty
//! otherwise.
//!
//! Values are chosen so that a torn one is detected: every word and stamp of value number `s` is `s`, or the
//! writer's own number.
#![cfg(loom)]
#![allow(unsafe_code, reason = "loom's pointers are read and written raw, and checked")]

use jde_board::cell::{Pinned, Ring, SlotStamp, Withdrawn};
use loom::sync::Arc;
use loom::thread;

/// Context switches that a model tries beyond those where a thread waits. Without a bound the larger models
/// take hours.
const PREEMPTIONS: usize = 3;

fn model(body: impl Fn() + Sync + Send + 'static) {
    let mut builder = loom::model::Builder::new();
    builder.preemption_bound = Some(PREEMPTIONS);
    builder.check(body);
}

/// Publishes a value with `value` in every part.
fn publish(cell: &Pinned, writer_index: Option<usize>, value: u64) -> Result<u64, Withdrawn> {
    let claim = cell.claim();
    {
        let block = cell.block(&claim);
        // SAFETY: claimed, and loom checks it.
        unsafe { *block.deref() = value };
    }
    cell.publish(claim, writer_index, value, value as u32, value)
}

/// Pins, reads twice, and checks that the value neither moved nor was torn.
fn read(cell: &Pinned) -> SlotStamp {
    let pin = cell.pin();
    let stamp = cell.stamp(&pin);
    for _ in 0..2 {
        let block = cell.pinned_block(&pin);
        // SAFETY: pinned, and loom checks it.
        let value = unsafe { *block.deref() };
        assert_eq!(value, stamp.time, "a value and its stamp belong together");
        thread::yield_now();
        drop(block);
    }
    assert_eq!(stamp, cell.stamp(&pin), "a pinned value keeps its stamp");
    cell.unpin(pin);
    stamp
}

#[test]
fn a_ring_never_returns_a_torn_value() {
    model(|| {
        let ring = Arc::new(Ring::new(2, 2, &[0, 0]));
        let writer = {
            let ring = ring.clone();
            thread::spawn(move || {
                for value in 1..=3 {
                    assert_eq!(ring.publish(&[value, value], value, value as u32, value), value);
                }
            })
        };
        let mut last = 0;
        for _ in 0..2 {
            let mut value = [u64::MAX; 2];
            let stamp = ring.read(&mut value);
            assert_eq!(value, [stamp.sequence; 2]);
            assert_eq!(stamp.time, stamp.sequence);
            // Value number 0 does not expire.
            assert!(stamp.sequence == 0 || stamp.valid_until == stamp.sequence);
            assert!(stamp.sequence >= last, "values never run backwards");
            last = stamp.sequence;
        }
        writer.join().unwrap();
        assert_eq!(ring.newest(), 3);
    });
}

#[test]
fn a_reader_that_a_ring_overtakes_retries() {
    model(|| {
        let ring = Arc::new(Ring::new(1, 4, &[0]));
        let writer = {
            let ring = ring.clone();
            thread::spawn(move || {
                (1..=5).for_each(|value| assert_eq!(ring.publish(&[value], value, 0, value), value))
            })
        };
        let mut value = [0];
        let stamp = ring.read(&mut value);
        assert_eq!((value[0], stamp.time), (stamp.sequence, stamp.sequence));
        writer.join().unwrap();
    });
}

#[test]
fn a_pinned_value_is_neither_torn_nor_overwritten() {
    model(|| {
        let cell = Arc::new(Pinned::new(8, 0, 1, 1));
        let writer = {
            let cell = cell.clone();
            thread::spawn(move || {
                (1..=3).for_each(|value| assert_eq!(publish(&cell, None, value), Ok(value)))
            })
        };
        let first = read(&cell).sequence;
        let second = read(&cell).sequence;
        assert!(second >= first, "values never run backwards");
        writer.join().unwrap();
        assert_eq!(read(&cell).sequence, 3);
    });
}

#[test]
fn two_readers_pin_without_disturbing_each_other_or_the_writer() {
    model(|| {
        let cell = Arc::new(Pinned::new(8, 0, 1, 2));
        let reader = {
            let cell = cell.clone();
            thread::spawn(move || {
                read(&cell);
            })
        };
        let writer = {
            let cell = cell.clone();
            thread::spawn(move || {
                (1..=2).for_each(|value| assert_eq!(publish(&cell, None, value), Ok(value)))
            })
        };
        read(&cell);
        reader.join().unwrap();
        writer.join().unwrap();
    });
}

#[test]
fn two_writers_are_ordered_and_none_is_lost() {
    model(|| {
        let cell = Arc::new(Pinned::new(8, 0, 2, 1));
        let other = {
            let cell = cell.clone();
            thread::spawn(move || [publish(&cell, None, 10), publish(&cell, None, 11)])
        };
        let own = publish(&cell, None, 20).unwrap();
        let seen = read(&cell);
        assert!(seen.sequence >= own);
        let [first, second] = other.join().unwrap().map(Result::unwrap);
        assert!(first < second);
        let mut all = [first, second, own];
        all.sort();
        assert_eq!(all, [1, 2, 3], "every value has a distinct number");
        let newest = read(&cell);
        assert_eq!(newest.sequence, 3);
        assert_eq!(newest.time, if own == 3 { 20 } else { 11 });
    });
}

#[test]
fn reading_the_newest_stamp_is_not_torn() {
    model(|| {
        let cell = Arc::new(Pinned::new(8, 0, 1, 0));
        let writer = {
            let cell = cell.clone();
            thread::spawn(move || {
                (1..=3).for_each(|value| assert_eq!(publish(&cell, None, value), Ok(value)))
            })
        };
        let stamp = cell.newest();
        assert_eq!((stamp.time, stamp.sequence), (stamp.sequence, stamp.time));
        writer.join().unwrap();
    });
}

#[test]
fn r7_after_a_withdrawal_no_publish_takes_effect_and_the_new_winner_commands() {
    model(|| {
        let cell = Arc::new(Pinned::new(8, 2, 2, 1));
        cell.grant(0);
        let loser = {
            let cell = cell.clone();
            thread::spawn(move || [publish(&cell, Some(0), 10), publish(&cell, Some(0), 11)])
        };
        cell.withdraw(0);
        let at_withdrawal = cell.newest().sequence;
        cell.grant(1);
        assert_eq!(
            publish(&cell, Some(1), 20),
            Ok(at_withdrawal + 1),
            "no value was published in between"
        );
        let [first, second] = loser.join().unwrap();
        for late in [first, second].into_iter().flatten() {
            assert!(
                late <= at_withdrawal,
                "value {late} took effect after the withdrawal at {at_withdrawal}"
            );
        }
        assert!(
            first.is_ok() || second.is_err(),
            "a refused writer remains refused"
        );
        assert_eq!(read(&cell).time, 20);
    });
}

#[test]
fn r7_a_withdrawal_does_not_affect_other_grants() {
    model(|| {
        let cell = Arc::new(Pinned::new(8, 2, 2, 0));
        cell.grant(0);
        cell.grant(1);
        let winner = {
            let cell = cell.clone();
            thread::spawn(move || publish(&cell, Some(1), 20))
        };
        cell.withdraw(0);
        assert_eq!(publish(&cell, Some(0), 10), Err(Withdrawn));
        assert_eq!(winner.join().unwrap(), Ok(1));
    });
}

#[test]
fn r7_two_withdrawals_in_a_row_both_take_effect() {
    model(|| {
        let cell = Arc::new(Pinned::new(8, 1, 1, 0));
        cell.grant(0);
        let writer = {
            let cell = cell.clone();
            thread::spawn(move || publish(&cell, Some(0), 10))
        };
        cell.withdraw(0);
        let first = cell.newest().sequence;
        cell.grant(0);
        cell.withdraw(0);
        let second = cell.newest().sequence;
        match writer.join().unwrap() {
            Ok(_) => assert_eq!(second, 1, "the command was published while granted"),
            Err(Withdrawn) => assert_eq!((first, second), (0, 0)),
        }
        assert_eq!(cell.newest().sequence, second);
    });
}
