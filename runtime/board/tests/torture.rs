//! Real threads that detect torn, moved or lost values. Bounded by counts, never by time.
//!
//! `JDE_TORTURE` scales the counts in percent: 1 under valgrind, more for a run over night.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use jde_board::{Access, Board, Declaration, Reader, Refused, Variable};

mod common;
use common::{COMMAND, EXPORT, declaration, word_array};

/// Words of a 640 x 480 image of three bytes per pixel, about 900 kB.
const IMAGE: usize = 640 * 480 * 3 / 8;
/// Far longer than any wake-up: a wait that takes this long was never woken.
const LOST: Duration = Duration::from_secs(60);

fn rounds(full: u64) -> u64 {
    let percent = match std::env::var("JDE_TORTURE") {
        Ok(percent) => percent.parse().expect("JDE_TORTURE is a whole number of percent"),
        Err(_) if cfg!(miri) => 1,
        Err(_) => 100,
    };
    (full * percent / 100).max(20)
}

fn declare(word_count: usize, access: Access, change: impl FnOnce(&mut Declaration)) -> Arc<Variable> {
    let word_count = if cfg!(miri) {
        word_count.min(64)
    } else {
        word_count
    };
    let mut declared = declaration("laser", &word_array(word_count), access);
    change(&mut declared);
    Board::new().declare(declared).unwrap()
}

/// Sets every word to `value`, by whole copies, because this also runs unoptimised.
fn fill(bytes: &mut [u8], value: u64) {
    bytes[..8].copy_from_slice(&value.to_ne_bytes());
    let mut filled = 8;
    while filled < bytes.len() {
        let chunk = filled.min(bytes.len() - filled);
        bytes.copy_within(..chunk, filled);
        filled += chunk;
    }
}

/// Returns whether every word is `value`: the first is, and each equals the one before.
fn is_filled(bytes: &[u8], value: u64) -> bool {
    bytes[..8] == value.to_ne_bytes() && bytes[8..] == bytes[..bytes.len() - 8]
}

/// Publishes `rounds` values as writer `id`. Every word and the time of a value are the same number, which is
/// unique.
fn write(variable: &Arc<Variable>, id: u32, rounds: u64) {
    let mut writer = variable.writer(id, "writer").unwrap();
    let mut last = 0;
    for round in 1..=rounds {
        let value = u64::from(id) << 32 | round;
        fill(writer.loan(), value);
        let sequence = writer.publish(value, value).unwrap();
        assert!(sequence > last, "the numbers of one writer increase");
        last = sequence;
    }
}

/// Checks a whole value, twice, and returns its number.
fn check(reader: &mut Reader) -> u64 {
    let Some(latched) = reader.latch(0) else { return 0 };
    for _ in 0..2 {
        assert!(
            is_filled(latched.bytes, latched.stamp.time),
            "a torn value, number {}",
            latched.stamp.sequence
        );
    }
    assert_eq!(latched.stamp.time >> 32, u64::from(latched.stamp.writer));
    latched.stamp.sequence
}

/// Reads until the writers have finished, and then once more. Returns the last number.
fn read(variable: &Arc<Variable>, done: &AtomicBool) -> u64 {
    let mut reader = variable.reader("reader");
    let mut last = 0;
    loop {
        let finished = done.load(Ordering::Acquire);
        let sequence = check(&mut reader);
        assert!(sequence >= last, "value {sequence} after value {last}");
        assert_eq!(
            check(&mut reader),
            sequence,
            "a latched value does not change, nor does its absence"
        );
        reader.release();
        last = sequence;
        if finished {
            return last;
        }
    }
}

/// Signals the end even if a writer panics, so that its readers end.
struct Done<'a>(&'a AtomicBool);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

fn torture(variable: &Arc<Variable>, writers: u32, readers: usize, rounds: u64) {
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let reader_threads: Vec<_> = (0..readers)
            .map(|_| scope.spawn(|| read(variable, &done)))
            .collect();
        {
            let _done = Done(&done);
            let writer_threads: Vec<_> = (1..=writers)
                .map(|id| scope.spawn(move || write(variable, id, rounds)))
                .collect();
            writer_threads
                .into_iter()
                .for_each(|writer| writer.join().unwrap());
        }
        for reader in reader_threads {
            assert_eq!(
                reader.join().unwrap(),
                u64::from(writers) * rounds,
                "no value is lost"
            );
        }
    });
}

#[test]
fn small_values_are_never_torn() {
    for count in [1, 6, 16] {
        torture(&declare(count, EXPORT, |_| ()), 1, 2, rounds(100_000));
    }
}

#[test]
fn values_of_a_few_lines_are_never_torn() {
    torture(&declare(17, EXPORT, |_| ()), 1, 2, rounds(100_000));
}

#[test]
fn images_are_never_torn() {
    torture(&declare(IMAGE, EXPORT, |_| ()), 1, 2, rounds(1_000));
}

#[test]
fn images_are_never_torn_for_readers_that_copy() {
    torture(
        &declare(IMAGE, EXPORT, |declaration| declaration.readers = 0),
        1,
        2,
        rounds(1_000),
    );
}

#[test]
fn values_of_several_writers_are_never_torn_and_keep_an_order() {
    for count in [1, 6, 300] {
        let variable = declare(count, Access::Modulation, |declaration| declaration.writers = 3);
        torture(&variable, 3, 2, rounds(30_000));
    }
}

#[test]
fn every_writer_finds_a_slot_with_more_readers_than_declared() {
    let variable = declare(40, Access::Modulation, |declaration| declaration.readers = 1);
    torture(&variable, 2, 5, rounds(10_000));
}

#[test]
fn r7_no_command_takes_effect_after_its_withdrawal() {
    let velocity = declare(6, COMMAND, |_| ());
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let _done = Done(&done);
        for id in [1, 2] {
            let (velocity, done) = (velocity.clone(), &done);
            scope.spawn(move || {
                let mut writer = velocity.writer(id, "writer").unwrap();
                while !done.load(Ordering::Relaxed) {
                    fill(writer.loan(), id.into());
                    match writer.publish(id.into(), id.into()) {
                        Ok(_) | Err(Refused::NoAuthority) => (),
                        Err(other) => panic!("{other}"),
                    }
                }
            });
        }
        let mut driver = velocity.reader("driver");
        for round in 0..rounds(20_000) {
            let winner = 1 + (round % 2) as u32;
            let before = velocity.newest();
            velocity.grant(winner);
            if round % 64 < 2 {
                assert!(
                    velocity.wait_newer(before, LOST) > before,
                    "commands with a grant take effect"
                );
            }
            velocity.withdraw(winner);
            let newest = velocity.newest();
            for _ in 0..20 {
                assert_eq!(velocity.newest(), newest, "no writer holds a grant");
            }
            driver.release();
            if newest > before {
                let latched = driver.latch(0).unwrap();
                assert_eq!(latched.stamp.writer, winner);
                assert!(is_filled(latched.bytes, winner.into()));
            }
        }
    });
}

#[test]
fn no_wake_up_is_lost() {
    let variables = [EXPORT, Access::Modulation].map(|access| declare(1, access, |_| ()));
    let [ping, pong] = &variables;
    let rounds = rounds(10_000);
    thread::scope(|scope| {
        scope.spawn(|| {
            let mut writer = pong.writer(2, "pong").unwrap();
            for round in 0..rounds {
                assert_eq!(ping.wait_newer(round, LOST), round + 1);
                writer.loan().fill(0);
                writer.publish(0, 0).unwrap();
            }
        });
        let mut writer = ping.writer(1, "ping").unwrap();
        for round in 0..rounds {
            writer.loan().fill(0);
            writer.publish(0, 0).unwrap();
            assert_eq!(pong.wait_newer(round, LOST), round + 1);
        }
    });
}
