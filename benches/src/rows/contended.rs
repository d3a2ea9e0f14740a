//! One writer and three readers of one value at the same time, in jde and in the best crates for it. Each
//! read takes the newest value.

use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Result, ensure};
use arc_swap::{ArcSwap, Cache};
use jde_board::typed::{TypedReader, TypedWriter};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{Rounds, consume};
use jde_paths::{EXPORT, Words, variable};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use rustix::time::{ClockId, clock_gettime};

use crate::scope::Scope;

/// The number of reads or writes between two checks for the end.
const BATCH: u64 = 64;

/// A writer. It writes the given number into every word.
type Write<'a> = Box<dyn FnMut(u64) + Send + 'a>;
/// A reader. It returns the number that it found, or `None` if the words differ.
type Read<'a> = Box<dyn FnMut() -> Option<u64> + Send + 'a>;
/// One way to share a value between a writer and readers.
type Method = fn(Setting) -> Result<Window>;

/// The parameters of a measurement.
#[derive(Clone, Copy)]
struct Setting {
    readers: usize,
    time: Duration,
    /// Whether each thread has its own processor.
    separate: bool,
}

/// The result of one window. `read` and `write` are processor times of one operation, ns; `new` is the share
/// of reads that found a newer value than the read before; `fewest` is the number of reads of the slowest
/// reader.
struct Window {
    read: f64,
    write: f64,
    new: f64,
    fewest: u64,
}

/// The results of all windows of one method.
struct Windows {
    read: Rounds,
    write: Rounds,
    new: Rounds,
    fewest: u64,
}

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    Ok([of::<8>(scope, "64 B")?, of::<175>(scope, "1.4 kB")?].concat())
}

fn of<const WORDS: usize>(scope: &Scope, size: &str) -> Result<Vec<Line>> {
    let methods: [(&str, Method); 4] = [
        ("ours", jde::<WORDS>),
        ("triple_buffer", triple::<WORDS>),
        ("arc-swap", arc_swap::<WORDS>),
        ("arc-swap, cached", cached::<WORDS>),
    ];
    let several = Setting {
        readers: 3,
        time: Duration::from_millis(scope.either(50, 150)),
        separate: false,
    };
    let all = measure_all(scope, several, &methods)?;
    let [read, write] = compare(&methods, &all, Goal::AtMost(1.5));
    let mut lines = vec![
        read(format!("contended read of {size}, CPU time")),
        write(format!("contended write of {size}, CPU time")),
        Line::new(
            format!("contended reads of {size} that find a new value"),
            Figure::Share(100.0 * all[0].new.median()),
            Goal::ReportOnly,
        ),
        Line::new(
            format!(
                "reads of {size} by the slowest reader in {} ms",
                several.time.as_millis()
            ),
            Figure::Count(all[0].fewest as f64),
            Goal::Least(Figure::Count(1.0)),
        ),
    ];
    let pair = Setting {
        readers: 1,
        separate: true,
        ..several
    };
    if processors().len() >= 2 {
        // The case for which triple buffers are made. arc-swap is left out: its writer is slower, so its
        // reader would find fewer new values.
        let methods = &methods[..2];
        let all = measure_all(scope, pair, methods)?;
        let [read, write] = compare(methods, &all, Goal::ReportOnly);
        let share = |index: usize| Figure::Share(100.0 * all[index].new.median());
        lines.extend([
            read(format!("one reads {size}, one writes, a processor each: a read")),
            write(format!("one reads {size}, one writes, a processor each: a write")),
            Line::compared(
                format!("one reads {size}, one writes: reads that find a new value"),
                share(0),
                methods[1].0,
                share(1),
                Goal::ReportOnly,
            ),
        ]);
    }
    Ok(lines)
}

/// Runs each method once per round. Each round begins with a different method.
fn measure_all(scope: &Scope, setting: Setting, methods: &[(&str, Method)]) -> Result<Vec<Windows>> {
    let mut windows: Vec<Vec<Window>> = methods.iter().map(|_| Vec::new()).collect();
    for round in 0..scope.either(3, 15) {
        for turn in 0..methods.len() {
            let index = (round + turn) % methods.len();
            windows[index].push(methods[index].1(setting)?);
        }
    }
    let all = windows.iter().map(|windows| Windows {
        read: Rounds::of(windows.iter().map(|window| window.read).collect()),
        write: Rounds::of(windows.iter().map(|window| window.write).collect()),
        new: Rounds::of(windows.iter().map(|window| window.new).collect()),
        fewest: windows
            .iter()
            .map(|window| window.fewest)
            .min()
            .unwrap_or_default(),
    });
    Ok(all.collect())
}

/// Compares reads and writes of jde with the best other method for each.
fn compare<'a>(
    methods: &'a [(&'a str, Method)],
    all: &'a [Windows],
    goal: Goal,
) -> [impl Fn(String) -> Line + use<'a>; 2] {
    let sides: [fn(&Windows) -> &Rounds; 2] = [|windows| &windows.read, |windows| &windows.write];
    sides.map(|side| {
        move |what| {
            let elapsed = |index: &usize| side(&all[*index]).median();
            let best = (1..all.len()).min_by(|a, b| elapsed(a).total_cmp(&elapsed(b)));
            let best = best.unwrap_or_default();
            let (name, _) = methods[best];
            Line::compared(
                what,
                Figure::Time(elapsed(&0)),
                name,
                Figure::Time(elapsed(&best)),
                goal,
            )
            .paired(side(&all[0]).ratio_to(side(&all[best])))
        }
    })
}

/// Returns the processors that this process may use.
fn processors() -> Vec<usize> {
    let allowed = sched_getaffinity(None).unwrap_or_default();
    (0..CpuSet::MAX_CPU)
        .filter(|number| allowed.is_set(*number))
        .collect()
}

fn jde<const WORDS: usize>(setting: Setting) -> Result<Window> {
    let variable = variable(WORDS, EXPORT, setting.readers)?;
    let mut writer: TypedWriter<Words<WORDS>> = TypedWriter::open(&variable, 1, "writer")?;
    writer.write([0; WORDS], 0, 0)?;
    let mut reads: Vec<Read> = Vec::new();
    for _ in 0..setting.readers {
        let mut reader: TypedReader<Words<WORDS>> = TypedReader::open(&variable, "reader")?;
        reads.push(Box::new(move || {
            reader.borrow(0).and_then(|words| common_number(&words))
        }));
    }
    let write = move |number| {
        let mut loan = writer.loan();
        loan.fill(number);
        consume(loan.publish(number, number));
    };
    window(setting, Box::new(write), reads)
}

/// One buffer per reader, since each buffer has one consumer.
fn triple<const WORDS: usize>(setting: Setting) -> Result<Window> {
    let (mut inputs, mut reads) = (Vec::new(), Vec::<Read>::new());
    for _ in 0..setting.readers {
        let (input, mut output) = triple_buffer::TripleBuffer::new(&[0u64; WORDS]).split();
        inputs.push(input);
        reads.push(Box::new(move || common_number(output.read())));
    }
    let write = move |number| {
        for input in &mut inputs {
            input.input_buffer_mut().fill(number);
            input.publish();
        }
    };
    window(setting, Box::new(write), reads)
}

/// A new allocation for each value, and reads through a guard, the fast way according to `arc-swap`.
fn arc_swap<const WORDS: usize>(setting: Setting) -> Result<Window> {
    let shared = Arc::new(ArcSwap::from_pointee([0u64; WORDS]));
    let mut reads: Vec<Read> = Vec::new();
    for _ in 0..setting.readers {
        let shared = Arc::clone(&shared);
        reads.push(Box::new(move || common_number(&shared.load())));
    }
    let write = move |number| shared.store(Arc::new([number; WORDS]));
    window(setting, Box::new(write), reads)
}

/// The same, with reads through `arc-swap`'s cache, which keeps the last value while it is the newest.
fn cached<const WORDS: usize>(setting: Setting) -> Result<Window> {
    let shared = Arc::new(ArcSwap::from_pointee([0u64; WORDS]));
    let mut reads: Vec<Read> = Vec::new();
    for _ in 0..setting.readers {
        let mut cache = Cache::new(Arc::clone(&shared));
        reads.push(Box::new(move || common_number(cache.load())));
    }
    let write = move |number| shared.store(Arc::new([number; WORDS]));
    window(setting, Box::new(write), reads)
}

/// Runs the writer and all readers for the time of the setting.
fn window(setting: Setting, mut write: Write, reads: Vec<Read>) -> Result<Window> {
    let ended = AtomicBool::new(false);
    let ended = &ended;
    std::thread::scope(|scope| {
        let readers: Vec<_> = reads
            .into_iter()
            .enumerate()
            .map(|(number, mut read)| {
                scope.spawn(move || {
                    setting.bind(number + 1);
                    let (mut count, mut new, mut last, mut consistent) = (0u64, 0u64, 0, true);
                    let start = processor_time();
                    while !ended.load(Ordering::Relaxed) {
                        for _ in 0..BATCH {
                            let number = black_box(read());
                            // A value must be whole, and never older than the one before.
                            consistent &= number.is_some_and(|number| number >= last);
                            new += u64::from(number > Some(last));
                            last = number.unwrap_or(last);
                        }
                        count += BATCH;
                    }
                    (count, new, processor_time() - start, consistent)
                })
            })
            .collect();
        let writer = scope.spawn(move || {
            setting.bind(0);
            let mut count = 0u64;
            let start = processor_time();
            while !ended.load(Ordering::Relaxed) {
                for _ in 0..BATCH {
                    count += 1;
                    write(count);
                }
            }
            (processor_time() - start) as f64 / count as f64
        });
        std::thread::sleep(setting.time);
        ended.store(true, Ordering::Relaxed);
        let write = writer.join().expect("the writer returns");
        let (mut all, mut newer, mut spent, mut fewest) = (0, 0, 0, u64::MAX);
        for reader in readers {
            let (count, new, elapsed, consistent) = reader.join().expect("a reader returns");
            ensure!(
                consistent,
                "a reader read a torn value, or an older one after a newer"
            );
            (all, newer) = (all + count, newer + new);
            (spent, fewest) = (spent + elapsed, fewest.min(count));
        }
        Ok(Window {
            read: spent as f64 / all as f64,
            write,
            new: newer as f64 / all as f64,
            fewest,
        })
    })
}

impl Setting {
    /// Binds the calling thread to its processor if each has its own.
    fn bind(self, number: usize) {
        if self.separate {
            let mut processor = CpuSet::new();
            processor.set(processors()[number]);
            sched_setaffinity(None, &processor).expect("the processor is allowed");
        }
    }
}

/// Returns the number in all words, or `None` if they differ.
fn common_number<const WORDS: usize>(words: &Words<WORDS>) -> Option<u64> {
    let differs = words.iter().fold(0, |differs, word| differs | (word ^ words[0]));
    (differs == 0).then_some(words[0])
}

/// Returns the processor time of the calling thread, ns.
fn processor_time() -> u64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}
