//! Recordings by other programs: with other or no compression, without chunks, or without an index.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

use jde_log::{ReadError, RecordedVariables, Recording, Survey};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions};

const MESSAGES: u64 = 50;

/// Writes a number each millisecond to two channels. The second channel lags by 10 ms.
fn write(path: &Path, options: WriteOptions) {
    let file = BufWriter::new(File::create(path).unwrap());
    let mut writer = options.create(file).unwrap();
    let schema = writer
        .add_schema("acme/Number", "ros1msg", b"uint64 number")
        .unwrap();
    let about = BTreeMap::from([("owner".to_owned(), "acme".to_owned())]);
    let channels =
        ["/early", "/late"].map(|topic| writer.add_channel(schema, topic, "ros1", &about).unwrap());
    for number in 0..MESSAGES {
        for (late, channel_id) in channels.into_iter().enumerate() {
            let header = MessageHeader {
                channel_id,
                sequence: number as u32,
                log_time: (number + late as u64 * 10) * 1_000_000,
                publish_time: 0,
            };
            // Compressible by more than LZ4 can achieve.
            let data = number.to_le_bytes().repeat(5_000);
            writer.write_to_known_channel(&header, &data).unwrap();
        }
    }
    writer.finish().unwrap();
}

#[test]
fn every_message_of_another_program_is_read_in_the_order_of_time() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("acme.mcap");
    let without_index = || {
        WriteOptions::new()
            .emit_summary_records(false)
            .emit_summary_offsets(false)
    };
    for (name, options) in [
        ("zstd", WriteOptions::new().compression(Some(Compression::Zstd))),
        ("lz4", WriteOptions::new().compression(Some(Compression::Lz4))),
        ("not compressed", WriteOptions::new().compression(None)),
        ("no chunks", WriteOptions::new().use_chunks(false)),
        (
            "no index of chunks",
            WriteOptions::new().emit_chunk_indexes(false),
        ),
        (
            "no channels in the index",
            WriteOptions::new().repeat_channels(false),
        ),
        ("no statistics", WriteOptions::new().emit_statistics(false)),
        ("no index", without_index()),
        ("no chunks and no index", without_index().use_chunks(false)),
    ] {
        write(&file, options);
        let recording = Recording::open(&file).unwrap();
        assert_eq!(recording.damage(), None, "{name}");
        let messages: Vec<_> = recording.messages().unwrap().map(Result::unwrap).collect();
        assert_eq!(messages.len() as u64, 2 * MESSAGES, "{name}");
        assert!(messages.is_sorted_by_key(|message| message.log_time), "{name}");
        for message in &messages {
            let number = u64::from(message.sequence);
            assert_eq!(message.data[..8], number.to_le_bytes(), "{name}");
            let late = u64::from(message.channel.topic == "/late") * 10;
            assert_eq!(message.log_time, (number + late) * 1_000_000, "{name}");
        }
        let survey = Survey::of(&recording).unwrap();
        assert_eq!((survey.application, survey.seed), (None, None));
        let topics: Vec<_> = survey
            .topics
            .iter()
            .map(|topic| (topic.topic.as_str(), topic.messages))
            .collect();
        assert_eq!(topics, [("/early", MESSAGES), ("/late", MESSAGES)], "{name}");
        assert_eq!(survey.topics[0].rate_hz, Some(1000.0));
    }
}

#[test]
fn a_truncated_file_of_another_program_is_read_up_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("acme.mcap");
    write(&file, WriteOptions::new().use_chunks(false));
    let bytes = std::fs::read(&file).unwrap();
    std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    let survey = Survey::of(&Recording::open(&file).unwrap()).unwrap();
    let damage = survey.damage.unwrap();
    assert!(damage.offset.unwrap() <= bytes.len() as u64 / 2);
    assert!(survey.messages > MESSAGES / 2 && survey.messages < 2 * MESSAGES);
}

#[test]
fn missing_parts_are_reported_as_ranges_for_any_numbers() {
    let folder = tempfile::tempdir().unwrap();
    for number in [3, 4, 7, u32::MAX - 1, u32::MAX] {
        let file = folder.path().join(format!("{number}.mcap"));
        let file = BufWriter::new(File::create(file).unwrap());
        let mut writer = WriteOptions::new().create(file).unwrap();
        let entries = [("recording", "acme".to_owned()), ("number", number.to_string())];
        let part = Metadata {
            name: "jde/part".to_owned(),
            metadata: entries.map(|(key, value)| (key.to_owned(), value)).into(),
        };
        writer.write_metadata(&part).unwrap();
        writer.finish().unwrap();
    }
    let survey = Survey::of(&Recording::open(folder.path()).unwrap()).unwrap();
    let parts = survey.parts.unwrap();
    assert_eq!((parts.files.len(), parts.first), (5, 3));
    assert_eq!(parts.missing, [5..=6, 8..=u32::MAX - 2]);
    let missing = parts.describe_missing().unwrap();
    assert!(
        missing.ends_with("4294967288 parts from 5 to 4294967293 are missing"),
        "{missing}"
    );
}

/// Writes a file of a bag of ROS 2 with one message, at this time.
fn write_bag_file(path: &Path, log_time: u64) {
    let mut writer = WriteOptions::new()
        .create(BufWriter::new(File::create(path).unwrap()))
        .unwrap();
    let mut channels = Vec::new();
    for (topic, name, encoding, text) in [
        ("/front/number", "std_msgs/msg/UInt64", "ros2msg", "uint64 data\n"),
        (
            "/bounds",
            "std_msgs/msg/Header",
            "ros2msg",
            "builtin_interfaces/Time stamp\nstring frame_id\n===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
        ),
        ("/unknown", "acme_msgs/msg/Notes", "ros2msg", "\nstring[] notes\n"),
        ("/fields", "std_msgs/msg/Header", "ros2msg", "string frame_id\n"),
        ("/undefined", "std_msgs/msg/Bool", "", ""),
        ("/idl", "acme_msgs/msg/Notes", "ros2idl", "module acme_msgs {};"),
    ] {
        let schema = writer.add_schema(name, encoding, text.as_bytes()).unwrap();
        channels.push(
            writer
                .add_channel(schema, topic, "cdr", &BTreeMap::new())
                .unwrap(),
        );
    }
    let header = MessageHeader {
        channel_id: channels[0],
        sequence: 0,
        log_time,
        publish_time: log_time,
    };
    let message = [0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0];
    writer.write_to_known_channel(&header, &message).unwrap();
    writer.finish().unwrap();
}

#[test]
fn the_files_of_a_bag_are_one_recording_of_the_types_that_are_known() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("metadata.yaml"), "").unwrap();
    assert!(matches!(Recording::open(folder.path()), Err(ReadError::Empty(_))));
    for number in [0, 9, 10] {
        write_bag_file(&folder.path().join(format!("bag_{number}.mcap")), 100 + number);
    }
    let recording = Recording::open(folder.path()).unwrap();
    let names: Vec<_> = recording.files().map(|file| file.file_name().unwrap()).collect();
    assert_eq!(names, ["bag_0.mcap", "bag_9.mcap", "bag_10.mcap"]);
    let times = recording
        .messages()
        .unwrap()
        .map(|message| message.unwrap().log_time);
    assert_eq!(times.collect::<Vec<_>>(), [100, 109, 110]);

    let all = RecordedVariables::of(&recording);
    let variables: Vec<_> = all
        .iter()
        .map(|variable| (variable.name.as_str(), variable.value_type.name.as_str()))
        .collect();
    assert_eq!(
        variables,
        [
            ("bounds", "std_msgs/msg/Header"),
            ("front.number", "std_msgs/msg/UInt64"),
            ("undefined", "std_msgs/msg/Bool"),
            ("unknown", "acme_msgs/msg/Notes"),
        ]
    );
    let others: Vec<_> = all.left_out().lines().collect();
    let [fields, idl, _] = &others[..] else {
        panic!("{others:?}");
    };
    assert!(
        fields.ends_with("its fields are not those of the standard type of this name"),
        "{fields}"
    );
    assert!(
        idl.ends_with("its definition is in `ros2idl`, not in `ros2msg`"),
        "{idl}"
    );
}

/// Writes one chunk of `megabytes` MB of zeros with the strongest compression.
fn zip_bomb(path: &Path, megabytes: usize, log_time: u64) -> mcap::Writer<BufWriter<File>> {
    let options = WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .chunk_size(None);
    let mut writer = options
        .create(BufWriter::new(File::create(path).unwrap()))
        .unwrap();
    let channel_id = writer.add_channel(0, "/zeros", "none", &BTreeMap::new()).unwrap();
    for sequence in 0..megabytes {
        let header = MessageHeader {
            channel_id,
            sequence: sequence as u32,
            log_time,
            publish_time: 0,
        };
        writer.write_to_known_channel(&header, &vec![0; 1 << 20]).unwrap();
    }
    writer
}

#[test]
fn a_chunk_that_is_too_large_is_not_decompressed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bomb.mcap");
    zip_bomb(&file, 150, 7).finish().unwrap();
    assert!(
        fs::metadata(&file).unwrap().len() < 1 << 20,
        "the compressed file is small"
    );
    let survey = Survey::of(&Recording::open(&file).unwrap()).unwrap();
    let damage = survey.damage.expect("the damage is reported");
    assert!(
        damage.reason.contains("the limits are 128 MB"),
        "{}",
        damage.reason
    );
    assert_eq!(survey.messages, 0);
}

#[test]
fn a_survey_of_very_many_topics_counts_each() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("many.mcap");
    let mut writer = WriteOptions::new()
        .create(BufWriter::new(File::create(&file).unwrap()))
        .unwrap();
    let topics = 20_000_u64;
    for number in 0..topics {
        let topic = format!("/{number}");
        let channel_id = writer.add_channel(0, &topic, "none", &BTreeMap::new()).unwrap();
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: number,
            publish_time: 0,
        };
        writer.write_to_known_channel(&header, &[1]).unwrap();
    }
    writer.finish().unwrap();
    let survey = Survey::of(&Recording::open(&file).unwrap()).unwrap();
    assert_eq!(survey.topics.len() as u64, topics);
    assert!(
        survey
            .topics
            .iter()
            .all(|topic| (topic.messages, topic.bytes) == (1, 1))
    );
}
