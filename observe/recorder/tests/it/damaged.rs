//! Recordings that are truncated or corrupted at any byte: the reader returns the intact messages and reports
//! the offset of the damage.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use jde_log::{ReadError, Recording};
use jde_recorder::{Recorder, Stamps};
use jde_types::Value;

use crate::support::options;

/// Enough for several chunks.
const MESSAGES: u64 = 3000;

fn record(file: &Path) {
    let mut options = options("bench", true);
    options.origin.file = Some(("app.toml".to_owned(), b"name = \"bench\"".to_vec()));
    let recorder = Recorder::create(file, options).unwrap();
    let topic = recorder.topic("/bench/data", Arc::new(<[u64; 128]>::describe()), BTreeMap::new());
    for number in 1..=MESSAGES {
        let stamps = Stamps {
            published: number,
            measured: number,
            sequence: number,
        };
        topic.put(&number.to_ne_bytes().repeat(128), stamps);
    }
    assert_eq!(recorder.finish().written, MESSAGES);
}

/// Returns how many messages can be read, and whether damage was reported.
fn read(file: &Path) -> (u64, bool) {
    let recording = match Recording::open(file) {
        Ok(recording) => recording,
        Err(ReadError::NotRecording(_)) => return (0, true),
        Err(error) => panic!("{error}"),
    };
    let mut damaged = recording.damage().is_some();
    let mut count = 0;
    for message in recording.messages().unwrap() {
        match message {
            Ok(message) => {
                count += 1;
                assert_eq!(
                    message.log_time, count,
                    "messages are in order and none is missing"
                );
                assert_eq!(message.data[4..12], count.to_le_bytes(), "the data is complete");
            }
            Err(ReadError::Damaged { .. }) => damaged = true,
            Err(error) => panic!("{error}"),
        }
    }
    (count, damaged)
}

#[test]
fn a_file_truncated_anywhere_is_read_up_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let (complete, cut) = (
        folder.path().join("complete.mcap"),
        folder.path().join("cut.mcap"),
    );
    record(&complete);
    assert_eq!(read(&complete), (MESSAGES, false));
    let bytes = std::fs::read(&complete).unwrap();
    let mut last = 0;
    for length in (0..bytes.len()).step_by(bytes.len() / 60) {
        std::fs::write(&cut, &bytes[..length]).unwrap();
        let (count, damaged) = read(&cut);
        assert!(damaged, "cut at {length}");
        assert!(count >= last, "{count} at {length}, {last} before");
        last = count;
    }
    assert_eq!(last, MESSAGES, "all messages are read without the index");
}

#[test]
fn a_corrupted_byte_never_gives_a_wrong_message() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(&file);
    let bytes = std::fs::read(&file).unwrap();
    for position in (0..bytes.len()).step_by(bytes.len() / 60 + 1) {
        let mut corrupted = bytes.clone();
        corrupted[position] ^= 0x40;
        std::fs::write(&file, &corrupted).unwrap();
        // `read` asserts that no message is wrong or out of order.
        read(&file);
    }
}

#[test]
fn a_chunk_whose_start_is_after_its_end_gives_times_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(&file);
    let mut bytes = std::fs::read(&file).unwrap();
    // Records are an opcode, a length and a body. The bodies of chunks and of their index begin with the
    // times of their messages.
    const MAGIC: usize = 8;
    let (mut position, mut swapped) = (MAGIC, 0);
    while position + MAGIC < bytes.len() {
        let opcode = bytes[position];
        let body = position + 9;
        let length = u64::from_le_bytes(bytes[position + 1..body].try_into().unwrap()) as usize;
        if matches!(opcode, mcap::records::op::CHUNK | mcap::records::op::CHUNK_INDEX) {
            bytes[body..body + 16].rotate_left(8);
            swapped += 1;
        }
        position = body + length;
    }
    assert!(swapped > 2, "{swapped}");
    // With the index at the end, and without it.
    for length in [bytes.len(), bytes.len() * 2 / 3] {
        std::fs::write(&file, &bytes[..length]).unwrap();
        let recording = Recording::open(&file).unwrap();
        let (first, last) = recording.times().unwrap();
        assert!(first <= last, "{first} {last}");
        assert!(recording.messages().unwrap().count() > 0);
    }
}

#[test]
fn a_file_that_is_being_written_is_not_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("written.mcap");
    let recorder = Recorder::create(&file, options("bench", true)).unwrap();
    let damage = Recording::open(&file).unwrap().damage().cloned();
    assert!(damage.is_some_and(|damage| damage.is_unfinished()));
    recorder.finish();
    assert_eq!(Recording::open(&file).unwrap().damage(), None);
}

#[test]
fn a_damaged_chunk_does_not_hide_those_behind_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(&file);
    let mut bytes = std::fs::read(&file).unwrap();
    let (mut position, mut chunks) = (8, Vec::new());
    while position + 9 < bytes.len() {
        let body = position + 9;
        let length = u64::from_le_bytes(bytes[position + 1..body].try_into().unwrap()) as usize;
        if bytes[position] == mcap::records::op::CHUNK {
            chunks.push((body, length));
        }
        position = body + length;
    }
    let [_, (body, length), .., (last, last_length)] = chunks[..] else {
        panic!("{} chunks", chunks.len());
    };
    bytes[body + length / 2] ^= 0x40;
    // Without an index, as of a recorder that was killed.
    std::fs::write(&file, &bytes[..last + last_length]).unwrap();
    let recording = Recording::open(&file).unwrap();
    let [gap] = recording.gaps() else {
        panic!("{:?}", recording.gaps());
    };
    assert!(gap.to_string().contains("nothing can be read from "), "{gap}");
    let messages = recording.messages().unwrap().map(Result::unwrap);
    let times: Vec<_> = messages.map(|message| message.log_time).collect();
    let until = gap.until.unwrap();
    assert!(times.iter().any(|time| *time < gap.from) && times.contains(&(until + 1)));
    assert!(!times.iter().any(|time| (gap.from..=until).contains(time)));
}
