//! Recordings in MCAP, and verbs and drivers that read them.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::Path;

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};

use super::files::{app, lines, write};

/// An empty list of bytes, in CDR.
const EMPTY: &[u8] = &[0, 1, 0, 0, 0, 0, 0, 0];
/// The kinds of records.
const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const CHUNK: u8 = 6;
const ATTACHMENT: u8 = 9;

/// A hundred topics whose lists may have 260 MB each, and have nothing.
pub(super) fn bounds(folder: &Path) {
    topics(folder, 100, "uint8[<=260000000] data", EMPTY);
}

/// A hundred topics of 15 MB each, of which only a part is there.
pub(super) fn large(folder: &Path) {
    topics(folder, 100, "uint8[15000000] data", &[0; 1000]);
}

/// A hundred topics without a bound, with a message of 15 MB each.
pub(super) fn unbound(folder: &Path) {
    let mut message = EMPTY.to_vec();
    message[4..].copy_from_slice(&15_000_000_u32.to_le_bytes());
    message.resize(8 + 15_000_000, 0);
    topics(folder, 100, "uint8[] data", &message);
}

/// So many topics; a file can have 65,535.
pub(super) fn channels(folder: &Path, count: usize) {
    topics(folder, count, "uint8[<=9] data", EMPTY);
}

/// A definition whose parts multiply.
pub(super) fn nested(folder: &Path) {
    topics(folder, 10, &multiplied("A[1000] a"), EMPTY);
}

/// Definitions that contain each other, of which the last has a list of a million.
pub(super) fn multiplied(first: &str) -> String {
    let level = |n: usize| format!("===\nMSG: acme_msgs/A{n}\nA{}[1000] a", n + 1);
    let levels = lines(12, level).replace("A0\n", "A\n");
    format!("{first}\n{levels}===\nMSG: acme_msgs/A12\nfloat64[1000000] a\n")
}

/// Thirty thousand fields.
pub(super) fn fields(folder: &Path) {
    let fields = lines(30_000, |n| format!("uint8 f{n}"));
    topics(folder, 100, &fields, EMPTY);
}

/// A terabyte of nothing behind the first bytes.
pub(super) fn sparse(folder: &Path) {
    write(folder, "a.mcap", mcap::MAGIC);
    super::files::lengthen(folder, "a.mcap");
}

/// A terabyte of nothing behind a message.
pub(super) fn sparse_end(folder: &Path) {
    topics(folder, 1, "uint8[<=9] data", EMPTY);
    super::files::lengthen(folder, "a.mcap");
}

/// A chunk that would have a terabyte when it is unpacked.
pub(super) fn stated_chunk(folder: &Path) {
    with_records(folder, |file| {
        let chunk = chunk(file);
        let mut chunk = chunk.to_vec();
        // Behind the head and two times.
        chunk[9 + 16..][..8].copy_from_slice(&(1_u64 << 40).to_le_bytes());
        chunk
    });
}

/// Two hundred chunks of zeros, which are small only as long as they are packed: in messages, or without any.
pub(super) fn packed_zeros(folder: &Path) {
    large_chunks(folder, &vec![0; 1 << 20], 60, true);
}

/// The same, all at the same time.
pub(super) fn overlapping(folder: &Path) {
    large_chunks(folder, &vec![0; 1 << 20], 60, false);
}

/// A hundred million messages with nothing in them.
pub(super) fn empty_messages(folder: &Path) {
    large_chunks(folder, &[], 500_000, true);
}

/// An attached file and a channel whose lengths are those of other files.
pub(super) fn stated_records(folder: &Path) {
    with_records(folder, |_| {
        let long = |opcode: u8| [&[opcode][..], &(120_u64 << 20).to_le_bytes(), &[0; 40]].concat();
        [long(ATTACHMENT), long(SCHEMA), long(CHANNEL)].concat()
    });
}

/// Metadata of a run with a million entries.
pub(super) fn metadata(folder: &Path) {
    let mut writer = writer(folder);
    for name in ["jde", "jde/lost", "jde/trigger", "jde/part", "jde/gap"] {
        let metadata = (0..100_000).map(|n| (format!("topic{n}"), "18446744073709551615".to_owned()));
        let metadata = mcap::records::Metadata {
            name: name.to_owned(),
            metadata: metadata.collect(),
        };
        writer.write_metadata(&metadata).expect("it is written");
    }
    add(&mut writer, 0, "uint8[<=9] data", EMPTY);
    writer.finish().expect("it is written");
}

/// An application that reads a recording, as sensors and as definitions.
pub(super) fn played(folder: &Path, make: fn(&Path)) {
    make(folder);
    app(
        folder,
        "roots = [\"a\"]\ninterfaces = [\"a.mcap\"]\n[schemas.a]\ntype = \"replay/recording\"\nfile = \"a.mcap\"\n",
    );
}

fn topics(folder: &Path, count: usize, definition: &str, message: &[u8]) {
    let mut writer = writer(folder);
    for number in 0..count {
        add(&mut writer, number, definition, message);
    }
    writer.finish().expect("it is written");
}

fn writer(folder: &Path) -> Writer<BufWriter<File>> {
    let file = File::create(folder.join("a.mcap")).expect("a file");
    let options = WriteOptions::new().compression(Some(Compression::Zstd));
    options.create(BufWriter::new(file)).expect("it is written")
}

/// Adds a topic with a message.
fn add(writer: &mut Writer<BufWriter<File>>, number: usize, definition: &str, message: &[u8]) {
    let schema = writer
        .add_schema("acme_msgs/msg/T", "ros2msg", definition.as_bytes())
        .expect("a definition");
    let topic = format!("/t{number}");
    let channel_id = writer
        .add_channel(schema, &topic, "cdr", &BTreeMap::new())
        .expect("a channel");
    let header = MessageHeader {
        channel_id,
        sequence: 0,
        log_time: 1,
        publish_time: 1,
    };
    writer
        .write_to_known_channel(&header, message)
        .expect("it is written");
}

/// Writes a chunk with so many messages, two hundred times, and no index.
fn large_chunks(folder: &Path, message: &[u8], messages: usize, follow: bool) {
    let path = folder.join("a.mcap");
    let file = BufWriter::new(File::create(&path).expect("a file"));
    let options = WriteOptions::new()
        .chunk_size(Some(1 << 40))
        .compression(Some(Compression::Zstd));
    let mut writer = options.create(file).expect("it is written");
    let channel_id = writer
        .add_channel(0, "/a", "cdr", &BTreeMap::new())
        .expect("a channel");
    let header = MessageHeader {
        channel_id,
        sequence: 0,
        log_time: 1,
        publish_time: 1,
    };
    for _ in 0..messages {
        writer
            .write_to_known_channel(&header, message)
            .expect("it is written");
    }
    writer.finish().expect("it is written");
    let whole = fs::read(&path).expect("it was written");
    let mut chunk = chunk(&whole).to_vec();
    let mut file = BufWriter::new(File::create(&path).expect("a file"));
    file.write_all(head(&whole)).expect("it is written");
    for number in 0..200_u64 {
        if follow {
            // The times of the first and of the last message, as the chunk states them.
            chunk[9..][..8].copy_from_slice(&(2 + number).to_le_bytes());
            chunk[17..][..8].copy_from_slice(&(2 + number).to_le_bytes());
        }
        file.write_all(&chunk).expect("it is written");
    }
    file.flush().expect("it is written");
}

/// Writes a recording of one message, and the records that `more` makes of it in the place of its end.
fn with_records(folder: &Path, more: impl FnOnce(&[u8]) -> Vec<u8>) {
    topics(folder, 1, "uint8[<=9] data", EMPTY);
    let whole = fs::read(folder.join("a.mcap")).expect("it was written");
    let records = [head(&whole), chunk(&whole), &more(&whole)].concat();
    write(folder, "a.mcap", records);
}

/// The first bytes of a file and its first record, which states who wrote it.
fn head(file: &[u8]) -> &[u8] {
    let start = mcap::MAGIC.len();
    &file[..start + length(&file[start..])]
}

/// The second record of a file.
fn chunk(file: &[u8]) -> &[u8] {
    let rest = &file[head(file).len()..];
    assert_eq!(rest[0], CHUNK);
    &rest[..length(rest)]
}

/// The bytes of a record with its head.
fn length(record: &[u8]) -> usize {
    let length = record[1..9]
        .try_into()
        .map(u64::from_le_bytes)
        .expect("eight bytes");
    9 + length as usize
}
