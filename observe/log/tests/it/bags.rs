//! Bags of ROS 2: databases in all versions of their tables, packed files and messages, and values that have no room.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

use jde_log::{LeftOut, ReadError, RecordedVariables, Recording, Survey};
use jde_ros::cdr;
use jde_types::{Frame, Header, Image, LaserScan, Time, Value};
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use rusqlite::Connection;

/// The definition of a scan as ROS 2 has it.
const SCAN: &str = "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n\
    float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\n\
    float32[] intensities\n===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n===\n\
    MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
const PICTURE: &str = "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\n\
    uint8[] data\n===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n===\n\
    MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";

/// Writes a database whose tables are of a version, with so many messages of each topic at 100 ns each.
pub(crate) fn write_database(path: &Path, version: u32, topics: &[(&str, &str, &[u8])], messages: i64) {
    let connection = Connection::open(path).unwrap();
    connection
        .execute_batch("PRAGMA synchronous = OFF; PRAGMA journal_mode = MEMORY; BEGIN")
        .unwrap();
    let more = match version {
        1 => "",
        2 | 3 => ", offered_qos_profiles TEXT NOT NULL",
        _ => ", offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL",
    };
    connection
        .execute_batch(&format!(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, \
             serialization_format TEXT NOT NULL{more});
             CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, \
             data BLOB NOT NULL);
             CREATE INDEX timestamp_idx ON messages (timestamp ASC);"
        ))
        .unwrap();
    if version >= 4 {
        connection
            .execute_batch(
                "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
                 INSERT INTO schema VALUES(4, 'jazzy');
                 CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, \
                 encoding TEXT NOT NULL, encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
                 INSERT INTO message_definitions VALUES(1, 'acme_msgs/msg/Number', 'ros2msg', 'int32 number', '');
                 INSERT INTO message_definitions VALUES(2, 'acme_msgs/msg/Lost', 'unknown', '', '');",
            )
            .unwrap();
    }
    for (topic, (name, type_name, data)) in (1..).zip(topics) {
        let values = ["", ", ''", ", ''", ", '', ''"][version as usize - 1];
        let insert = format!("INSERT INTO topics VALUES({topic}, ?1, ?2, 'cdr'{values})");
        connection.execute(&insert, [name, type_name]).unwrap();
        // The last message is the first in time.
        for number in (0..messages).rev() {
            let insert = "INSERT INTO messages(topic_id, timestamp, data) VALUES(?1, ?2, ?3)";
            connection
                .execute(
                    insert,
                    rusqlite::params![topic, 1000 + 100 * number + topic, data],
                )
                .unwrap();
        }
    }
    connection.execute_batch("COMMIT").unwrap();
    connection.close().unwrap();
}

pub(crate) fn write_mcap(path: &Path, topics: &[(&str, &str, &str, &[u8])]) {
    let file = BufWriter::new(File::create(path).unwrap());
    let mut writer = WriteOptions::new().profile("ros2").create(file).unwrap();
    for (topic, type_name, definition, data) in topics {
        let schema = writer
            .add_schema(type_name, "ros2msg", definition.as_bytes())
            .unwrap();
        let channel_id = writer
            .add_channel(schema, topic, "cdr", &BTreeMap::new())
            .unwrap();
        let header = MessageHeader {
            channel_id,
            sequence: 1,
            log_time: 7,
            publish_time: 7,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
}

/// Returns the values of a recording, by the names of their variables, and what is left out of it.
fn values(path: &Path) -> (Vec<(String, Vec<u8>)>, Vec<String>) {
    let recording = Recording::open(path).unwrap();
    let variables = RecordedVariables::of(&recording);
    let mut left_out = variables.left_out().clone();
    let mut values = Vec::new();
    for message in recording.messages().unwrap() {
        let message = message.unwrap();
        let mut cuts = LeftOut::default();
        match variables
            .get(&message.channel)
            .map(|variable| (variable, variable.decode(&message.data, &mut cuts)))
        {
            Some((variable, Ok(value))) => values.push((variable.name.clone(), value)),
            Some((variable, Err(reason))) => {
                left_out.add_again(format_args!("a message of {}", variable.topic), reason);
            }
            None => {}
        }
        left_out.extend(&cuts);
    }
    (values, left_out.lines().collect())
}

/// The one value of a recording.
fn value<T: Value>(path: &Path) -> (Box<T>, Vec<String>) {
    let (values, left_out) = values(path);
    let [(_, bytes)] = values.as_slice() else {
        panic!("{} values; {left_out:?}", values.len());
    };
    let mut value = T::boxed();
    value.as_bytes_mut().copy_from_slice(bytes);
    (value, left_out)
}

/// Seven, in CDR.
pub(crate) const SEVEN: &[u8] = &[0, 1, 0, 0, 7, 0, 0, 0];

#[test]
fn a_database_of_each_version_is_read_in_the_order_of_time() {
    let folder = tempfile::tempdir().unwrap();
    for version in 1..=4 {
        let path = folder.path().join(format!("{version}.db3"));
        let number = if version < 4 {
            "std_msgs/Int32"
        } else {
            "acme_msgs/msg/Number"
        };
        let topics = [("/number", number, SEVEN), ("lost", "acme_msgs/msg/Lost", SEVEN)];
        write_database(&path, version, &topics, 300);
        let recording = Recording::open(&path).unwrap();
        assert_eq!(recording.times(), Some((1001, 1000 + 29_900 + 2)));
        let messages: Vec<_> = recording.messages().unwrap().map(Result::unwrap).collect();
        assert_eq!(messages.len(), 600);
        assert!(messages.is_sorted_by_key(|message| message.log_time));
        let later = recording.messages_from(20_001).unwrap().count();
        assert_eq!(
            later,
            messages
                .iter()
                .filter(|message| message.log_time >= 20_001)
                .count()
        );
        let (values, left_out) = values(&path);
        assert!(
            values
                .iter()
                .all(|(name, bytes)| (name.as_str(), bytes.as_slice()) == ("number", &[7, 0, 0, 0]))
        );
        assert_eq!(values.len(), 300);
        let lost = "lost (acme_msgs/msg/Lost) is left out: the recording contains no definition of it";
        assert_eq!(left_out, [lost], "{version}");
    }
}

#[test]
fn long_messages_of_a_database_are_read_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.db3");
    let mut long = vec![0; 3 << 20];
    long[1] = 1;
    write_database(&path, 4, &[("/long", "acme_msgs/msg/Lost", &long)], 3);
    let recording = Recording::open(&path).unwrap();
    let lengths = recording
        .messages()
        .unwrap()
        .map(|message| message.unwrap().data.len());
    assert_eq!(lengths.collect::<Vec<_>>(), [3 << 20; 3]);
}

#[test]
fn packed_files_and_messages_are_unpacked() {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("bag");
    fs::create_dir(&bag).unwrap();
    let packed = zstd::encode_all(SEVEN, 3).unwrap();
    let plain = folder.path().join("plain");
    write_database(&plain, 2, &[("/number", "std_msgs/msg/Int32", &packed)], 2);
    fs::write(
        bag.join("bag_0.db3.zstd"),
        zstd::encode_all(File::open(&plain).unwrap(), 3).unwrap(),
    )
    .unwrap();
    write_mcap(
        &plain,
        &[("/number", "std_msgs/msg/Int32", "int32 data\n", &packed)],
    );
    fs::write(
        bag.join("bag_1.mcap.zstd"),
        zstd::encode_all(File::open(&plain).unwrap(), 3).unwrap(),
    )
    .unwrap();
    fs::write(
        bag.join("metadata.yaml"),
        "rosbag2_bagfile_information:\n  version: 4\n  compression_format: zstd\n  compression_mode: FILE\n  \
         relative_file_paths:\n    - bag/bag_0.db3.zstd\n    - bag/bag_1.mcap.zstd\n",
    )
    .unwrap();
    let (read, left_out) = values(&bag);
    assert_eq!(read, vec![("number".to_owned(), vec![7, 0, 0, 0]); 3]);
    assert_eq!(left_out, [""; 0]);
    assert_eq!(values(&bag.join("bag_0.db3.zstd")).0.len(), 2);
    // One that was cut off is read as far as it goes, and says so.
    let whole = fs::read(bag.join("bag_1.mcap.zstd")).unwrap();
    let cut = folder.path().join("cut.mcap.zstd");
    fs::write(&cut, &whole[..whole.len() - 5]).unwrap();
    match Recording::open(&cut) {
        Ok(recording) => assert!(recording.damage().is_some()),
        Err(error) => assert!(matches!(error, ReadError::NotRecording(_)), "{error}"),
    }
}

#[test]
fn a_file_of_a_bag_that_cannot_be_read_is_named_and_the_others_are_read() {
    let folder = tempfile::tempdir().unwrap();
    write_mcap(
        &folder.path().join("bag_0.mcap"),
        &[("/number", "std_msgs/msg/Int32", "int32 data\n", SEVEN)],
    );
    fs::write(folder.path().join("bag_1.mcap"), "no recording").unwrap();
    fs::write(
        folder.path().join("metadata.yaml"),
        "rosbag2_bagfile_information: {version: 9, relative_file_paths: [bag_0.mcap, bag_1.mcap]}",
    )
    .unwrap();
    let (read, left_out) = values(folder.path());
    assert_eq!(read.len(), 1);
    assert!(
        left_out[0].starts_with("the file bag_1.mcap is left out: "),
        "{left_out:?}"
    );
    let survey = Survey::of(&Recording::open(folder.path()).unwrap()).unwrap();
    assert_eq!((survey.messages, survey.left_out), (1, left_out));
}

#[test]
fn messages_of_another_type_of_a_topic_are_named_and_not_read_as_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.mcap");
    let half = [0, 1, 0, 0, 0, 0, 0, 63];
    write_mcap(
        &path,
        &[
            ("/level", "std_msgs/msg/UInt32", "uint32 data\n", SEVEN),
            ("/level", "std_msgs/msg/Float32", "float32 data\n", &half),
            (
                "/level",
                "std_msgs/msg/UInt32",
                "# The level.\nuint32 data\n",
                SEVEN,
            ),
            ("level", "std_msgs/msg/UInt32", "uint32 data\n", SEVEN),
        ],
    );
    let (read, left_out) = values(&path);
    assert_eq!(read, vec![("level".to_owned(), vec![7, 0, 0, 0]); 2]);
    assert_eq!(
        left_out,
        [
            "/level (std_msgs/msg/Float32) is left out: the topic also has messages of std_msgs/msg/UInt32, which are read",
            "level is left out: /level is called `level`, too",
        ]
    );
}

/// A scan with the nearest object at beam 1000, in a frame of a long name.
fn scan(beams: usize, frame: &str) -> Vec<u8> {
    let mut message = Vec::new();
    let mut writer = cdr::Writer::new(&mut message);
    writer.number([0; 8]);
    writer.text(frame.as_bytes());
    let last = -1.0 + 0.001 * (beams - 1) as f32;
    for number in [-1.0, last, 0.001, 0.0, 0.1, 0.1, 30.0] {
        writer.number(f32::to_le_bytes(number));
    }
    writer.length(beams);
    (0..beams).for_each(|beam| writer.number(f32::to_le_bytes(if beam == 1000 { 2.0 } else { 5.0 })));
    writer.length(0);
    message
}

#[test]
fn a_scan_of_many_beams_is_merged_and_a_long_frame_is_cut_with_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.mcap");
    let frame = "f".repeat(53);
    write_mcap(
        &path,
        &[("/scan", "sensor_msgs/msg/LaserScan", SCAN, &scan(1440, &frame))],
    );
    let (read, left_out) = value::<LaserScan>(&path);
    assert_eq!(
        (read.ranges.len(), read.ranges[500], read.ranges[0]),
        (720, 2.0, 5.0)
    );
    assert!((read.angle(500) - (-1.0 + 1000.5 * 0.001)).abs() < 1e-5);
    assert_eq!(read.header.frame_id.as_str(), &frame[..52]);
    assert_eq!(
        left_out,
        ["the end of `frame_id` in /scan is left out: it has room for 52 bytes"]
    );
    write_mcap(
        &path,
        &[("/scan", "sensor_msgs/msg/LaserScan", SCAN, &scan(1088, "laser"))],
    );
    let (read, left_out) = value::<LaserScan>(&path);
    assert_eq!(
        (read.ranges.len(), read.ranges[1000], left_out.len()),
        (1088, 2.0, 0)
    );
}

#[test]
fn pictures_become_those_that_schemas_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.mcap");
    let picture = |encoding: &str, [width, height]: [u32; 2], step: u32, data: &[u8]| {
        let mut message = Vec::new();
        let mut writer = cdr::Writer::new(&mut message);
        writer.number([0; 8]);
        writer.text(b"camera");
        writer.number(height.to_le_bytes());
        writer.number(width.to_le_bytes());
        writer.text(encoding.as_bytes());
        writer.number([0]);
        writer.number(step.to_le_bytes());
        writer.length(data.len());
        writer.bytes(data);
        write_mcap(&path, &[("/image", "sensor_msgs/msg/Image", PICTURE, &message)]);
    };
    picture("bgra8", [640, 480], 2560, &[1, 2, 3, 4].repeat(640 * 480));
    let (image, left_out) = value::<Image>(&path);
    assert_eq!(
        (image.encoding.as_str(), image.step, left_out.len()),
        ("bgr8", 1920, 0)
    );
    assert_eq!(
        (image.data.len(), &image.data[..6]),
        (640 * 480 * 3, &[1, 2, 3, 1, 2, 3][..])
    );
    assert_eq!(image.header.frame_id.as_str(), "camera");
    picture("mono16", [2, 1], 4, &[0, 0, 255, 255]);
    let (image, _) = value::<Image>(&path);
    assert_eq!((image.encoding.as_str(), &*image.data), ("mono8", &[0, 255][..]));
    picture("rgb8", [800, 600], 2400, &[0; 2400 * 600]);
    let (_, left_out) = values(&path);
    let large =
        "a message of /image is left out: the picture needs 1440000 bytes, and there is room for 921600";
    assert!(left_out[0].starts_with(large), "{left_out:?}");
}

#[test]
fn headers_of_standard_types_keep_their_stamps() {
    let header = Header {
        stamp: Time { sec: 3, nanosec: 4 },
        frame_id: Frame::new("map"),
    };
    let mut message = Vec::new();
    cdr::encode(&Header::describe(), header.as_bytes(), &mut message);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("header.db3");
    write_database(&path, 1, &[("/clock", "std_msgs/Header", &message)], 1);
    assert_eq!(*value::<Header>(&path).0, header);
}
