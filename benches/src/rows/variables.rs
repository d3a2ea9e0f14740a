//! Variables without contention: reads of a small value, and of a picture in place.

use std::hint::black_box;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context as _, Result};
use arc_swap::{ArcSwap, Cache};
use iceoryx2::prelude::*;
use jde_board::Access;
use jde_board::typed::TypedReader;
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{Rounds, consume, interleave};
use jde_paths::{EXPORT, Words, ends, variable};

use crate::schemas;
use crate::scope::Scope;

/// The size of a 640 x 480 picture with three bytes per pixel, in words of 8 bytes.
const IMAGE: usize = 640 * 480 * 3 / 8;
/// 64 bytes, in words.
const SMALL: usize = 8;

pub(crate) fn read(scope: &Scope) -> Result<Vec<Line>> {
    Ok([
        read_of::<1>(scope)?,
        publish_and_read::<1>(scope)?,
        read_of::<SMALL>(scope)?,
        publish_and_read::<SMALL>(scope)?,
        by_a_schema(scope)?,
    ]
    .concat())
}

/// Times reads of a value that is not written meanwhile. `black_box` hides the place of the value, so that
/// each side looks it up in every read.
fn read_of<const WORDS: usize>(scope: &Scope) -> Result<Vec<Line>> {
    let bytes = WORDS * 8;
    let (_writer, mut reader) = ends::<WORDS>(EXPORT)?;
    let (_writer, mut other) = ends::<WORDS>(EXPORT)?;
    let plain = [1u64; WORDS];
    let mutex = Mutex::new(plain);
    let blackboard = Blackboard::<WORDS>::new()?;
    let mut kept = blackboard.entry.get();
    let swap = ArcSwap::from_pointee(plain);
    let mut cache = Cache::new(&swap);
    let [ours, stamped, copy, locked, fetched, checked, cached] = interleave(
        scope.effort(),
        [
            &mut |times| (0..times).for_each(|_| read_borrowed(black_box(&mut reader))),
            &mut |times| (0..times).for_each(|_| consume(black_box(&mut other).get(0))),
            &mut |times| (0..times).for_each(|_| consume(*black_box(&plain))),
            &mut |times| {
                (0..times).for_each(|_| consume(*black_box(&mutex).lock().expect("no thread panicked")));
            },
            &mut |times| (0..times).for_each(|_| consume(*black_box(&blackboard.entry).get())),
            &mut |times| {
                for _ in 0..times {
                    if !black_box(&blackboard.entry).is_up_to_date(&kept) {
                        kept = blackboard.entry.get();
                    }
                    consume(**black_box(&kept));
                }
            },
            &mut |times| (0..times).for_each(|_| consume(**black_box(&mut cache).load())),
        ],
    );
    let what = format!("read {bytes} B");
    let line = |name, theirs, goal| beside(&what, &ours, name, theirs, goal);
    Ok(vec![
        line("plain copy", &copy, Goal::AtMost(2.0)),
        line("std Mutex", &locked, Goal::TimesFaster(3.0)),
        line("iceoryx2 blackboard, get", &fetched, Goal::ReportOnly),
        line(
            "iceoryx2 blackboard, kept while up to date",
            &checked,
            Goal::ReportOnly,
        ),
        line("arc-swap, cached", &cached, Goal::ReportOnly),
        beside(
            &format!("{what} with a copy of the stamp"),
            &stamped,
            "plain copy",
            &copy,
            Goal::ReportOnly,
        ),
    ])
}

/// Times a publication followed by a read.
fn publish_and_read<const WORDS: usize>(scope: &Scope) -> Result<Vec<Line>> {
    let (mut writer, mut reader) = ends::<WORDS>(EXPORT)?;
    let plain = [1u64; WORDS];
    let mutex = Mutex::new(plain);
    let topic = Topic::<WORDS>::new()?;
    let blackboard = Blackboard::<WORDS>::new()?;
    let [ours, sent, updated, locked] = interleave(
        scope.effort(),
        [
            &mut |times| {
                for time in 0..times {
                    consume(black_box(&mut writer).write(black_box(plain), time, time));
                    read_borrowed(black_box(&mut reader));
                }
            },
            &mut |times| (0..times).for_each(|_| black_box(&topic).pass(black_box(plain))),
            &mut |times| (0..times).for_each(|_| black_box(&blackboard).pass(black_box(plain))),
            &mut |times| {
                for _ in 0..times {
                    *black_box(&mutex).lock().expect("no thread panicked") = black_box(plain);
                    consume(*black_box(&mutex).lock().expect("no thread panicked"));
                }
            },
        ],
    );
    let what = format!("publish and read {} B", WORDS * 8);
    let line = |name, theirs, goal| beside(&what, &ours, name, theirs, goal);
    Ok(vec![
        line("iceoryx2 publish-subscribe", &sent, Goal::TimesFaster(10.0)),
        line("iceoryx2 blackboard", &updated, Goal::ReportOnly),
        line("std Mutex", &locked, Goal::ReportOnly),
    ])
}

/// Times reads of a schema through the ABI, beside a mutex in the same place.
fn by_a_schema(scope: &Scope) -> Result<Vec<Line>> {
    let reads = schemas::reads(scope.effort())?;
    let lines = reads.iter().map(|times| {
        let what = format!("read {} B by a schema, through the ABI", times.bytes);
        beside(
            &what,
            &times.imported,
            "std Mutex",
            &times.locked,
            Goal::ReportOnly,
        )
    });
    Ok(lines.collect())
}

fn beside(what: &str, ours: &Rounds, name: &str, theirs: &Rounds, goal: Goal) -> Line {
    Line::compared(
        what,
        Figure::Time(ours.median()),
        name,
        Figure::Time(theirs.median()),
        goal,
    )
    .paired(ours.ratio_to(theirs))
}

/// Copies the newest value from its place, as the yardsticks do. Its stamp is available but not read.
#[inline(always)]
fn read_borrowed<const WORDS: usize>(reader: &mut TypedReader<Words<WORDS>>) {
    if let Some(value) = reader.borrow(0) {
        consume(*value);
    }
}

/// iceoryx2's pattern for the newest value, used as its documentation describes: within one process, and in
/// the variant for one thread, which is the fastest.
struct Blackboard<const WORDS: usize> {
    entry: iceoryx2::port::reader::EntryHandle<local::Service, u64, Words<WORDS>>,
    writer: iceoryx2::port::writer::EntryHandleMut<local::Service, u64, Words<WORDS>>,
    _node: Node<local::Service>,
}

impl<const WORDS: usize> Blackboard<WORDS> {
    fn new() -> Result<Self> {
        let node = node()?;
        let service = node
            .service_builder(&format!("jde/bench/{}", unique()).as_str().try_into()?)
            .blackboard_creator::<u64>()
            .max_readers(1)
            .add::<Words<WORDS>>(0, [1; WORDS])
            .create()?;
        Ok(Self {
            entry: service.reader_builder().create()?.entry::<Words<WORDS>>(&0)?,
            writer: service.writer_builder().create()?.entry::<Words<WORDS>>(&0)?,
            _node: node,
        })
    }

    /// Updates the value and reads it.
    fn pass(&self, value: Words<WORDS>) {
        self.writer.update_with_copy(value);
        consume(*self.entry.get());
    }
}

/// iceoryx2's publish-subscribe in the same variant, with one publisher and one subscriber.
struct Topic<const WORDS: usize> {
    publisher: iceoryx2::port::publisher::Publisher<local::Service, Words<WORDS>, ()>,
    subscriber: iceoryx2::port::subscriber::Subscriber<local::Service, Words<WORDS>, ()>,
    _node: Node<local::Service>,
}

impl<const WORDS: usize> Topic<WORDS> {
    fn new() -> Result<Self> {
        let node = node()?;
        let topic = node
            .service_builder(&format!("jde/bench/{}", unique()).as_str().try_into()?)
            .publish_subscribe::<Words<WORDS>>()
            .max_publishers(1)
            .max_subscribers(1)
            .subscriber_max_buffer_size(1)
            .enable_safe_overflow(true)
            .create()?;
        Ok(Self {
            publisher: topic.publisher_builder().create()?,
            subscriber: topic.subscriber_builder().create()?,
            _node: node,
        })
    }

    /// Publishes a value and receives it.
    fn pass(&self, value: Words<WORDS>) {
        let loan = self.publisher.loan_uninit().expect("a buffer is free");
        loan.write_payload(value).send().expect("there is a subscriber");
        let received = self.subscriber.receive().expect("the subscriber is connected");
        consume(received.map(|sample| *sample.payload()));
    }
}

fn node() -> Result<Node<local::Service>> {
    set_log_level(LogLevel::Error);
    Ok(NodeBuilder::new().create::<local::Service>()?)
}

/// Returns a number that no other service of this process uses.
fn unique() -> usize {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

pub(crate) fn image(scope: &Scope) -> Result<Vec<Line>> {
    // A modulation of any size is borrowed in place, and so is an export as large as a picture.
    let mut large = pass_in_place(IMAGE, EXPORT, 1)?;
    let mut small = pass_in_place(SMALL, Access::Modulation, 1)?;
    let [picture, bytes] = interleave(
        scope.effort(),
        [&mut |times| (0..times).for_each(|_| large()), &mut |times| {
            (0..times).for_each(|_| small())
        }],
    );
    let size = Line::compared(
        "publish to read of 900 kB in place",
        Figure::Time(picture.median()),
        "64 B in place",
        Figure::Time(bytes.median()),
        Goal::AtMost(1.2),
    )
    .paired(picture.ratio_to(&bytes));

    let held = variable(IMAGE, EXPORT, 3)?;
    let mut writer = held.writer(1, "writer")?;
    writer.loan();
    writer.publish(0, 0)?;
    let mut readers = [(); 3].map(|()| held.reader("reader"));
    for reader in &mut readers {
        // Each reader holds a different value.
        reader.latch(0).context("there is a value")?;
        writer.loan();
        writer.publish(0, 0)?;
    }
    let free = variable(IMAGE, EXPORT, 3)?;
    let mut alone = free.writer(1, "writer")?;
    let [with_readers, without_readers] = interleave(
        scope.effort(),
        [
            &mut |times| (0..times).for_each(|time| publish(&mut writer, time)),
            &mut |times| (0..times).for_each(|time| publish(&mut alone, time)),
        ],
    );
    let holding = Line::compared(
        "publish 900 kB while three readers hold one each",
        Figure::Time(with_readers.median()),
        "while nobody reads",
        Figure::Time(without_readers.median()),
        Goal::AtMost(1.2),
    )
    .paired(with_readers.ratio_to(&without_readers));
    drop(readers);
    Ok(vec![size, holding])
}

/// Returns a function that loans a buffer, writes its first byte, publishes it, and reads it in place.
fn pass_in_place(words: usize, access: Access, readers: usize) -> Result<impl FnMut()> {
    let variable = variable(words, access, readers)?;
    let mut writer = variable.writer(1, "writer")?;
    let mut reader = variable.reader("reader");
    let mut time = 0;
    Ok(move || {
        time += 1;
        publish(&mut writer, time);
        consume(reader.latch(0).map(|latched| latched.bytes[0]));
        reader.release();
    })
}

fn publish(writer: &mut jde_board::Writer, time: u64) {
    writer.loan()[0] = time as u8;
    consume(writer.publish(time, time));
}
