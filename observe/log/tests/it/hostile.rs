//! Bags that are small and would take all memory or minutes, and those that are damaged anywhere.

use std::fs::{self, File};
use std::io::{Seek, SeekFrom, Write};

use jde_log::{Channel, Recording, Survey};
use rusqlite::Connection;

use crate::bags::{SEVEN, write_database, write_mcap};

#[test]
fn a_database_that_is_a_program_or_damaged_is_said_to_be() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("view.db3");
    let connection = Connection::open(&path).unwrap();
    connection
        .execute_batch(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format);
             CREATE VIEW messages AS WITH RECURSIVE all_of(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM all_of)
             SELECT id, 1 AS topic_id, id AS timestamp, zeroblob(100) AS data FROM all_of;",
        )
        .unwrap();
    connection.close().unwrap();
    let recording = Recording::open(&path).unwrap();
    assert_eq!(recording.damage().unwrap().reason, "it has no table `messages`");
    assert_eq!(recording.messages().unwrap().count(), 0);

    let path = folder.path().join("bag.db3");
    write_database(&path, 3, &[("/number", "std_msgs/msg/Int32", SEVEN)], 2000);
    let whole = fs::read(&path).unwrap();
    for position in (100..whole.len()).step_by(whole.len() / 40) {
        let mut damaged = whole.clone();
        damaged[position..][..50.min(whole.len() - position)].fill(0xa5);
        fs::write(&path, &damaged).unwrap();
        if let Ok(recording) = Recording::open(&path) {
            let read = recording.messages().unwrap().filter_map(Result::ok).count();
            assert!(read <= 2000, "{position}");
        }
    }
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let survey = Recording::open(&path).map(|recording| Survey::of(&recording).unwrap());
    assert!(survey.is_ok_and(|survey| survey.damage.is_some()));
}

#[test]
fn a_file_with_holes_ends_there_and_takes_no_memory_for_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sparse.mcap");
    // A message, an attachment, a record of no known kind and a definition, each of a terabyte.
    for (opcode, expected) in [
        (5_u8, "a message has"),
        (9, "there is no record"),
        (0x80, "there is no record"),
        (3, "MB"),
    ] {
        write_mcap(&path, &[("/number", "std_msgs/msg/Int32", "int32 data\n", SEVEN)]);
        let whole = fs::read(&path).unwrap();
        // Without the end of the data and the index behind it.
        let end = whole
            .windows(9)
            .rposition(|record| record == [15, 4, 0, 0, 0, 0, 0, 0, 0])
            .unwrap();
        let mut file = File::create(&path).unwrap();
        file.write_all(&whole[..end]).unwrap();
        file.write_all(&[opcode]).unwrap();
        file.write_all(&(1_u64 << 40).to_le_bytes()).unwrap();
        file.seek(SeekFrom::Current(1 << 40)).unwrap();
        file.write_all(&[0; 100]).unwrap();
        file.set_len(file.metadata().unwrap().len() + (1 << 30)).unwrap();
        drop(file);
        let recording = Recording::open(&path).unwrap();
        let reason = &recording.damage().unwrap().reason;
        assert!(reason.contains(expected), "{opcode}: {reason}");
        assert_eq!(recording.messages().unwrap().filter_map(Result::ok).count(), 1);
    }
}

#[test]
fn equal_channels_of_many_parts_are_one_and_share_a_definition() {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path();
    let names: Vec<_> = (0..500).map(|number| format!("/{number}")).collect();
    let definition = format!("int32 data\n#{}\n", "x".repeat(100_000));
    for part in 0..3 {
        let topics: Vec<_> = names
            .iter()
            .map(|name| (name.as_str(), "std_msgs/msg/Int32", definition.as_str(), SEVEN))
            .collect();
        write_mcap(&bag.join(format!("bag_{part}.mcap")), &topics);
    }
    fs::write(bag.join("metadata.yaml"), "rosbag2_bagfile_information:\n").unwrap();
    let recording = Recording::open(bag).unwrap();
    let channels: Vec<&Channel> = recording.channels().collect();
    assert_eq!(channels.len(), 500);
    assert!(
        channels
            .iter()
            .all(|channel| std::sync::Arc::ptr_eq(&channel.definition, &channels[0].definition))
    );
    assert_eq!(recording.messages().unwrap().count(), 1500);
}

#[test]
fn packed_zeros_of_hours_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("zeros.mcap.zstd");
    let mut packing = zstd::Encoder::new(File::create(&path).unwrap(), 3).unwrap();
    packing.write_all(mcap::MAGIC).unwrap();
    (0..80).for_each(|_| packing.write_all(&[0; 1 << 20]).unwrap());
    packing.finish().unwrap();
    let error = Recording::open(&path).err().expect("it is refused").to_string();
    assert!(error.contains("it would have more than 64 MB"), "{error}");
}
