//! One writer and three readers of one value at the same time, ours and the best crates for it. Each takes what is newest.

use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Result, ensure};
use arc_swap::ArcSwap;
use jde_board::Access;
use jde_board::typed::{TypedReader, TypedWriter};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{Rounds, see};
use jde_paths::{Words, variable};
use rustix::time::{ClockId, clock_gettime};

use crate::scope::Scope;

const READERS: usize = 3;
/// Reads and writes between two looks at whether it is over.
const BATCH: u64 = 64;

/// Who writes, again and again: is given the number to write into every word.
type Write<'a> = Box<dyn FnMut(u64) + Send + 'a>;
/// Who reads: answers with the number that it found, or nothing if the words did not agree.
type Read<'a> = Box<dyn FnMut() -> Option<u64> + Send + 'a>;

/// What a window came to: processor time of a read and of a write in ns, and the reads of the reader that had fewest.
struct Window {
    read: f64,
    write: f64,
    fewest: u64,
}

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    Ok([of::<8>(scope, "64 B")?, of::<175>(scope, "1.4 kB")?].concat())
}

fn of<const WORDS: usize>(scope: &Scope, size: &str) -> Result<Vec<Line>> {
    let windows = scope.either(3, 15);
    let time = Duration::from_millis(scope.either(50, 150));
    let kinds: [(&str, fn(Duration) -> Result<Window>); 3] = [
        ("ours", ours::<WORDS>),
        ("triple_buffer", triple::<WORDS>),
        ("arc-swap", swapped::<WORDS>),
    ];
    let mut reads = [const { Vec::new() }; 3];
    let mut writes = [const { Vec::new() }; 3];
    let mut fewest = u64::MAX;
    for round in 0..windows {
        for turn in 0..kinds.len() {
            let place = (round + turn) % kinds.len();
            let window = kinds[place].1(time)?;
            reads[place].push(window.read);
            writes[place].push(window.write);
            if place == 0 {
                fewest = fewest.min(window.fewest);
            }
        }
    }
    let reads = reads.map(Rounds::of);
    let writes = writes.map(Rounds::of);
    let best = |all: &[Rounds; 3]| if all[1].median() < all[2].median() { 1 } else { 2 };
    let line = |what: String, all: &[Rounds; 3]| {
        let best = best(all);
        Line::beside(
            what,
            Figure::Time(all[0].median()),
            kinds[best].0,
            Figure::Time(all[best].median()),
            Goal::AtMost(1.5),
        )
        .paired(all[0].by(&all[best]))
    };
    Ok(vec![
        line(format!("contended read of {size}, CPU time"), &reads),
        line(format!("contended write of {size}, CPU time"), &writes),
        Line::alone(
            format!("reads of {size} of whoever had fewest in {} ms", time.as_millis()),
            Figure::Count(fewest as f64),
            Goal::Least(Figure::Count(1.0)),
        ),
    ])
}

fn ours<const WORDS: usize>(time: Duration) -> Result<Window> {
    let variable = variable(WORDS, Access::Export, READERS)?;
    let mut writer: TypedWriter<Words<WORDS>> = TypedWriter::open(&variable, 1, "writer")?;
    writer.write([0; WORDS], 0, 0)?;
    let mut reads: Vec<Read> = Vec::new();
    for _ in 0..READERS {
        let mut reader: TypedReader<Words<WORDS>> = TypedReader::open(&variable, "reader")?;
        reads.push(Box::new(move || reader.borrow().and_then(|words| agreed(&words))));
    }
    let write = move |number| {
        let mut loan = writer.loan();
        loan.fill(number);
        see(loan.publish(number, number));
    };
    window(time, Box::new(write), reads)
}

/// One buffer a reader, since each has one consumer.
fn triple<const WORDS: usize>(time: Duration) -> Result<Window> {
    let (mut inputs, mut reads) = (Vec::new(), Vec::<Read>::new());
    for _ in 0..READERS {
        let (input, mut output) = triple_buffer::TripleBuffer::new(&[0u64; WORDS]).split();
        inputs.push(input);
        reads.push(Box::new(move || agreed(output.read())));
    }
    let write = move |number| {
        for input in &mut inputs {
            input.input_buffer_mut().fill(number);
            input.publish();
        }
    };
    window(time, Box::new(write), reads)
}

/// A new allocation a value, and what `arc-swap` calls its fast way to read: a guard.
fn swapped<const WORDS: usize>(time: Duration) -> Result<Window> {
    let shared = Arc::new(ArcSwap::from_pointee([0u64; WORDS]));
    let mut reads: Vec<Read> = Vec::new();
    for _ in 0..READERS {
        let shared = Arc::clone(&shared);
        reads.push(Box::new(move || agreed(&shared.load())));
    }
    let write = move |number| shared.store(Arc::new([number; WORDS]));
    window(time, Box::new(write), reads)
}

/// Has all of them at it for that long.
fn window(time: Duration, mut write: Write, reads: Vec<Read>) -> Result<Window> {
    let over = AtomicBool::new(false);
    let over = &over;
    std::thread::scope(|scope| {
        let readers: Vec<_> = reads
            .into_iter()
            .map(|mut read| {
                scope.spawn(move || {
                    let (mut count, mut last, mut sound) = (0u64, 0, true);
                    let start = processor_time();
                    while !over.load(Ordering::Relaxed) {
                        for _ in 0..BATCH {
                            let number = black_box(read());
                            // Whole, and never older than what it saw before.
                            sound &= number.is_some_and(|number| number >= last);
                            last = number.unwrap_or(last);
                        }
                        count += BATCH;
                    }
                    (count, processor_time() - start, sound)
                })
            })
            .collect();
        let writer = scope.spawn(move || {
            let mut count = 0u64;
            let start = processor_time();
            while !over.load(Ordering::Relaxed) {
                for _ in 0..BATCH {
                    count += 1;
                    write(count);
                }
            }
            (processor_time() - start) as f64 / count as f64
        });
        std::thread::sleep(time);
        over.store(true, Ordering::Relaxed);
        let write = writer.join().expect("the writer returns");
        let (mut all, mut spent, mut fewest) = (0, 0, u64::MAX);
        for reader in readers {
            let (count, took, sound) = reader.join().expect("a reader returns");
            ensure!(sound, "a reader saw a torn value, or an older one after a newer");
            (all, spent, fewest) = (all + count, spent + took, fewest.min(count));
        }
        Ok(Window {
            read: spent as f64 / all as f64,
            write,
            fewest,
        })
    })
}

/// The number in all words, if it is the same.
fn agreed<const WORDS: usize>(words: &Words<WORDS>) -> Option<u64> {
    let differs = words.iter().fold(0, |differs, word| differs | (word ^ words[0]));
    (differs == 0).then_some(words[0])
}

/// That the calling thread has used, ns.
fn processor_time() -> u64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}
