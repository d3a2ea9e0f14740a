//! Variables without contention: reading a small one, and a picture that is read in place.

use std::hint::black_box;
use std::sync::Mutex;

use anyhow::{Context as _, Result};
use iceoryx2::prelude::*;
use jde_board::Access;
use jde_board::typed::TypedReader;
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{Rounds, interleave, see};
use jde_paths::{Words, ends, variable};

use crate::scope::Scope;

/// Words of a 640 x 480 picture of three bytes a pixel.
const IMAGE: usize = 640 * 480 * 3 / 8;
/// Words of 64 bytes.
const SMALL: usize = 8;

pub(crate) fn read(scope: &Scope) -> Result<Vec<Line>> {
    Ok([read_of::<1>(scope)?, read_of::<SMALL>(scope)?].concat())
}

fn read_of<const WORDS: usize>(scope: &Scope) -> Result<Vec<Line>> {
    let bytes = WORDS * 8;
    let (mut writer, mut reader) = ends::<WORDS>(Access::Export)?;
    let plain = [1u64; WORDS];
    let mutex = Mutex::new(plain);
    let peers = Peers::<WORDS>::new()?;
    let (_writer, mut other) = ends::<WORDS>(Access::Export)?;
    let [ours, stamped, copy, locked, blackboard] = interleave(
        scope.effort(),
        [
            &mut |times| (0..times).for_each(|_| look(&mut reader)),
            &mut |times| (0..times).for_each(|_| see(other.get())),
            &mut |times| (0..times).for_each(|_| see(*black_box(&plain))),
            &mut |times| {
                (0..times).for_each(|_| see(*black_box(&mutex).lock().expect("nobody panics")));
            },
            &mut |times| (0..times).for_each(|_| see(*peers.entry.get())),
        ],
    );
    let [passed, sent] = interleave(
        scope.effort(),
        [
            &mut |times| {
                for time in 0..times {
                    see(writer.write(black_box(plain), time, time));
                    look(&mut reader);
                }
            },
            &mut |times| (0..times).for_each(|_| peers.pass(black_box(plain))),
        ],
    );
    let beside = |what: String, ours: &Rounds, name: &str, theirs: &Rounds, goal| {
        Line::beside(
            what,
            Figure::Time(ours.median()),
            name,
            Figure::Time(theirs.median()),
            goal,
        )
        .paired(ours.by(theirs))
    };
    let line = |name, theirs, goal| beside(format!("read {bytes} B"), &ours, name, theirs, goal);
    Ok(vec![
        line("plain copy", &copy, Goal::AtMost(2.0)),
        line("std Mutex", &locked, Goal::TimesFaster(3.0)),
        line("iceoryx2 blackboard", &blackboard, Goal::Told),
        beside(
            format!("read {bytes} B with a copy of the stamp"),
            &stamped,
            "plain copy",
            &copy,
            Goal::Told,
        ),
        beside(
            format!("publish and read {bytes} B"),
            &passed,
            "iceoryx2 publish-subscribe",
            &sent,
            Goal::TimesFaster(10.0),
        ),
    ])
}

/// The newest value where it is, its bytes copied as those of the yardsticks are. Its stamp is at hand, and not looked at.
#[inline(always)]
fn look<const WORDS: usize>(reader: &mut TypedReader<Words<WORDS>>) {
    if let Some(value) = reader.borrow() {
        see(*value);
    }
}

/// iceoryx2 as its documentation has it, within one process and without protection against several threads, which is its fastest.
struct Peers<const WORDS: usize> {
    entry: iceoryx2::port::reader::EntryHandle<local::Service, u64, Words<WORDS>>,
    publisher: iceoryx2::port::publisher::Publisher<local::Service, Words<WORDS>, ()>,
    subscriber: iceoryx2::port::subscriber::Subscriber<local::Service, Words<WORDS>, ()>,
    _node: Node<local::Service>,
}

impl<const WORDS: usize> Peers<WORDS> {
    fn new() -> Result<Self> {
        set_log_level(LogLevel::Error);
        let node = NodeBuilder::new().create::<local::Service>()?;
        let blackboard = node
            .service_builder(&"jde/bench/blackboard".try_into()?)
            .blackboard_creator::<u64>()
            .add::<Words<WORDS>>(0, [1; WORDS])
            .create()?;
        let entry = blackboard.reader_builder().create()?.entry::<Words<WORDS>>(&0)?;
        let topic = node
            .service_builder(&"jde/bench/topic".try_into()?)
            .publish_subscribe::<Words<WORDS>>()
            .subscriber_max_buffer_size(1)
            .enable_safe_overflow(true)
            .open_or_create()?;
        Ok(Self {
            entry,
            publisher: topic.publisher_builder().create()?,
            subscriber: topic.subscriber_builder().create()?,
            _node: node,
        })
    }

    /// Publishes and receives.
    fn pass(&self, value: Words<WORDS>) {
        let room = self.publisher.loan_uninit().expect("there is room for one");
        room.write_payload(value).send().expect("there is a subscriber");
        let received = self.subscriber.receive().expect("it is connected");
        see(received.map(|sample| *sample.payload()));
    }
}

pub(crate) fn image(scope: &Scope) -> Result<Vec<Line>> {
    // A modulation of any size is borrowed in place; so is an export as large as a picture.
    let mut large = pass_in_place(IMAGE, Access::Export, 1)?;
    let mut small = pass_in_place(SMALL, Access::Modulation, 1)?;
    let [picture, bytes] = interleave(
        scope.effort(),
        [&mut |times| (0..times).for_each(|_| large()), &mut |times| {
            (0..times).for_each(|_| small())
        }],
    );
    let size = Line::beside(
        "publish to read of 900 kB in place",
        Figure::Time(picture.median()),
        "64 B in place",
        Figure::Time(bytes.median()),
        Goal::AtMost(1.2),
    )
    .paired(picture.by(&bytes));

    let held = variable(IMAGE, Access::Export, 3)?;
    let mut writer = held.writer(1, "writer")?;
    writer.loan();
    writer.publish(0, 0)?;
    let mut readers = [(); 3].map(|()| held.reader("reader"));
    for reader in &mut readers {
        // Each holds another value.
        reader.latch().context("there is a value")?;
        writer.loan();
        writer.publish(0, 0)?;
    }
    let free = variable(IMAGE, Access::Export, 3)?;
    let mut alone = free.writer(1, "writer")?;
    let [among, without] = interleave(
        scope.effort(),
        [
            &mut |times| (0..times).for_each(|time| publish(&mut writer, time)),
            &mut |times| (0..times).for_each(|time| publish(&mut alone, time)),
        ],
    );
    let holding = Line::beside(
        "publish 900 kB while three readers hold one each",
        Figure::Time(among.median()),
        "while nobody reads",
        Figure::Time(without.median()),
        Goal::AtMost(1.2),
    )
    .paired(among.by(&without));
    drop(readers);
    Ok(vec![size, holding])
}

/// Loans room, touches it, publishes it, and reads it where it is.
fn pass_in_place(words: usize, access: Access, readers: usize) -> Result<impl FnMut()> {
    let variable = variable(words, access, readers)?;
    let mut writer = variable.writer(1, "writer")?;
    let mut reader = variable.reader("reader");
    let mut time = 0;
    Ok(move || {
        time += 1;
        publish(&mut writer, time);
        see(reader.latch().map(|latched| latched.bytes[0]));
        reader.release();
    })
}

fn publish(writer: &mut jde_board::Writer, time: u64) {
    writer.loan()[0] = time as u8;
    see(writer.publish(time, time));
}
