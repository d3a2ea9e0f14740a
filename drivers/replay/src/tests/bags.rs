//! Playback of bags of ROS 2: definitions without bounds, headers by the wall clock, types that no schema has.

use std::io::BufWriter;

use jde_ros::cdr;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};

use super::*;

/// The definition of a scan as rosbag2 writes it.
const SCAN: &str = "\
# Single scan from a planar laser range-finder

std_msgs/Header header # timestamp in the header is the acquisition time of the first ray
float32 angle_min            # start angle of the scan [rad]
float32 angle_max            # end angle of the scan [rad]
float32 angle_increment      # angular distance between measurements [rad]
float32 time_increment       # time between measurements [seconds]
float32 scan_time            # time between scans [seconds]
float32 range_min            # minimum range value [m]
float32 range_max            # maximum range value [m]
float32[] ranges             # range data [m]
float32[] intensities        # intensity data [device-specific units].
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";
/// The wall clock at the beginning of the bag.
const START: Duration = Duration::from_secs(1_800_000_000);

/// Writes two files of a bag, with a scan each 100 ms, which was measured 40 ms before. Its range in metres is the
/// time in seconds.
fn write_bag(folder: &Path, definition: &str) {
    fs::write(folder.join("metadata.yaml"), "rosbag2_bagfile_information:\n").expect("it is written");
    for number in 0..2_u32 {
        let file = fs::File::create(folder.join(format!("bag_{number}.mcap"))).expect("a file");
        let options = WriteOptions::new()
            .profile("ros2")
            .compression(Some(Compression::Zstd));
        let mut writer = options.create(BufWriter::new(file)).expect("a writer");
        let mut channel = |topic: &str, name: &str, text: &str| {
            let schema = writer.add_schema(name, "ros2msg", text.as_bytes());
            let schema = schema.expect("a schema");
            writer
                .add_channel(schema, topic, "cdr", &BTreeMap::new())
                .expect("a channel")
        };
        channel("/notes", "acme_msgs/msg/Notes", "string[] notes\n");
        let channel_id = channel("/scan", "sensor_msgs/msg/LaserScan", definition);
        for sequence in number * 10..(number + 1) * 10 {
            let published = START + Duration::from_millis(100) * sequence;
            let mut scan = Box::new(LaserScan::zeroed());
            scan.header = Header::new(published - Duration::from_millis(40), "base_scan");
            scan.ranges.push(sequence as f32 / 10.0).expect("room for one");
            let mut data = Vec::new();
            cdr::encode(&LaserScan::describe(), scan.as_bytes(), &mut data);
            let ns = published.as_nanos() as u64;
            let header = MessageHeader {
                channel_id,
                sequence,
                log_time: ns,
                publish_time: ns,
            };
            writer
                .write_to_known_channel(&header, &data)
                .expect("it is written");
        }
        writer.finish().expect("it is written");
    }
}

fn fixture(definition: &str) -> Fixture {
    let folder = TempDir::new().expect("a folder");
    write_bag(folder.path(), definition);
    let mut bench = Bench::new();
    bench.set("file", text(folder.path()));
    Fixture { bench, folder }
}

#[test]
fn a_bag_in_several_files_is_played_at_the_times_of_its_headers() {
    let mut fixture = fixture(SCAN).awake();
    let playback = fixture.at(0.0);
    assert_eq!((playback.messages, playback.length), (1, 1.9));
    fixture.at(1.25);
    assert_eq!(fixture.first_range(), Some(1.2), "of the second file");
    let measured = Duration::from_millis(1160);
    assert_eq!(fixture.bench.exported_at("laser"), Some(measured));
    let laser: LaserScan = fixture.bench.exported("laser").expect("it is exported");
    assert_eq!(laser.header.stamp, measured.into());
    assert_eq!(laser.header.frame_id.as_str(), "base_scan");
}

#[test]
fn a_topic_of_a_type_with_other_fields_is_refused() {
    let mut fixture = fixture(&SCAN.replace("float32[] ranges", "float64[] ranges"));
    fixture.bench.set("laser_topic", Text::<120>::new("/scan"));
    let reason = fixture.refused();
    assert!(
        reason.contains("cannot be played: its fields are not those of the standard type of this name"),
        "{reason}"
    );
}

#[test]
fn a_message_that_is_no_value_is_left_out_with_the_reason() {
    let mut fixture = fixture(SCAN);
    let file = fixture.folder.path().join("bag_0.mcap");
    let mut long = Vec::new();
    let mut writer = cdr::Writer::new(&mut long);
    writer.number([0; 8]);
    writer.text("laser".as_bytes());
    (0..7).for_each(|_| writer.number([0; 4]));
    writer.length(100_000);
    writer.bytes(&[0; 400_000]);
    writer.length(0);
    let mut output = WriteOptions::new()
        .create(BufWriter::new(fs::File::create(file).expect("a file")))
        .expect("a writer");
    let schema = output
        .add_schema("sensor_msgs/msg/LaserScan", "ros2msg", SCAN.as_bytes())
        .expect("a schema");
    let channel_id = output
        .add_channel(schema, "/scan", "cdr", &BTreeMap::new())
        .expect("a channel");
    let ns = START.as_nanos() as u64;
    let header = MessageHeader {
        channel_id,
        sequence: 0,
        log_time: ns,
        publish_time: ns,
    };
    output
        .write_to_known_channel(&header, &long)
        .expect("it is written");
    output.finish().expect("it is written");
    fixture.bench.awake().expect("it is a recording");
    assert_eq!(fixture.at(0.5).spoilt, 1);
    let warned =
        |(_, text): &(_, String)| text == "a message of /scan is left out: its limits are 0 m and 0 m";
    assert!(
        fixture.bench.log().iter().any(warned),
        "{:?}",
        fixture.bench.log()
    );
}
