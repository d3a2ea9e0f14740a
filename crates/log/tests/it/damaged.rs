//! Recordings that were cut off or corrupted at any byte: what is intact is read, and the place of the damage
//! is reported.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::SystemTime;

use jde_log::{Options, Origin, ReadError, Recorder, Recording, Stamps};
use jde_types::Value;

/// Enough for several chunks.
const MESSAGES: u64 = 3000;

fn record(file: &Path) {
    let options = Options {
        origin: Origin {
            application: "bench".to_owned(),
            seed: 0,
            started: SystemTime::UNIX_EPOCH,
            folder: None,
            file: Some(("app.toml".to_owned(), b"name = \"bench\"".to_vec())),
            hierarchy: None,
        },
        application: None,
        overwrite: false,
        lossless: true,
        on_error: Box::new(|trouble| panic!("{trouble}")),
    };
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
        Err(ReadError::NotMcap(_)) => return (0, true),
        Err(error) => panic!("{error}"),
    };
    let mut said = recording.damage().is_some();
    let mut count = 0;
    for message in recording.messages().unwrap() {
        match message {
            Ok(message) => {
                count += 1;
                assert_eq!(
                    message.log_time, count,
                    "in order, none missing before the damage"
                );
                assert_eq!(message.data[4..12], count.to_le_bytes(), "and whole");
            }
            Err(ReadError::Damaged { .. }) => said = true,
            Err(error) => panic!("{error}"),
        }
    }
    (count, said)
}

#[test]
fn a_file_cut_anywhere_reads_up_to_there() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, cut) = (folder.path().join("whole.mcap"), folder.path().join("cut.mcap"));
    record(&whole);
    assert_eq!(read(&whole), (MESSAGES, false));
    let bytes = std::fs::read(&whole).unwrap();
    let mut last = 0;
    for length in (0..bytes.len()).step_by(bytes.len() / 60) {
        std::fs::write(&cut, &bytes[..length]).unwrap();
        let (count, said) = read(&cut);
        assert!(said, "cut at {length}");
        assert!(count >= last, "{count} at {length}, {last} before");
        last = count;
    }
    assert_eq!(last, MESSAGES, "the index is not needed");
}

#[test]
fn a_spoilt_byte_is_never_a_wrong_message() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(&file);
    let bytes = std::fs::read(&file).unwrap();
    for place in (0..bytes.len()).step_by(bytes.len() / 60 + 1) {
        let mut spoilt = bytes.clone();
        spoilt[place] ^= 0x40;
        std::fs::write(&file, &spoilt).unwrap();
        // Any result is accepted, but no panic. `read` asserts that no message is wrong or out of order.
        read(&file);
    }
}

#[test]
fn a_chunk_that_claims_to_start_after_its_end_gives_times_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    record(&file);
    let mut bytes = std::fs::read(&file).unwrap();
    // Records are an opcode, a length and a body. The bodies of chunks and of their index begin with the
    // times of their messages.
    const MAGIC: usize = 8;
    let (mut place, mut turned) = (MAGIC, 0);
    while place + MAGIC < bytes.len() {
        let opcode = bytes[place];
        let body = place + 9;
        let length = u64::from_le_bytes(bytes[place + 1..body].try_into().unwrap()) as usize;
        if matches!(opcode, mcap::records::op::CHUNK | mcap::records::op::CHUNK_INDEX) {
            bytes[body..body + 16].rotate_left(8);
            turned += 1;
        }
        place = body + length;
    }
    assert!(turned > 2, "{turned}");
    // With the index at the end, and without it.
    for length in [bytes.len(), bytes.len() * 2 / 3] {
        std::fs::write(&file, &bytes[..length]).unwrap();
        let recording = Recording::open(&file).unwrap();
        let (first, last) = recording.times().unwrap();
        assert!(first <= last, "{first} {last}");
        assert!(recording.messages().unwrap().count() > 0);
    }
}
