//! A ROS 2 robot as a base.

use std::cell::RefCell;

use proptest::prelude::*;
use proptest::test_runner::TestRunner;

use jde_schema::types::Route;

use super::*;
use crate::Base;
use crate::base::{BUMP, HazardDetection, HazardDetectionVector};
use crate::velocity::TwistStamped;

/// An image that is small enough for a stack.
#[derive(Clone, Copy, Default, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/Image")]
struct Picture {
    header: Header,
    height: u32,
    width: u32,
    encoding: Text<28>,
    is_bigendian: u8,
    padding: Padding<3>,
    step: u32,
    data: Seq<u8, 16>,
}

#[test]
fn a_scan_has_the_time_of_its_oldest_beam() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Base>::connecting_to(&address).awake();
    for (increment, before) in [(0.001, 0.0), (-0.001, 0.039)] {
        let mut scan = scan(40);
        (scan.time_increment, scan.scan_time) = (increment, 0.1);
        // A beam before the start of the application would have the time 0.
        let since = Duration::from_millis(100);
        let has_scan = |bench: &Bench<Base>| {
            (bench.exported::<LaserScan>("laser")).is_some_and(|laser| {
                laser.time_increment == increment && Duration::from(laser.header.stamp) > since
            })
        };
        fixture.until(|bench| {
            scan.header.stamp = stamp();
            put(&session, "/scan", &*scan);
            has_scan(bench)
        });
        let laser: LaserScan = fixture.bench.exported("laser").unwrap();
        let first = Duration::from(laser.header.stamp);
        let oldest = fixture.bench.exported_at("laser").unwrap();
        let between = first.saturating_sub(oldest).as_secs_f64();
        assert!((between - before).abs() < 1e-6, "{between} s");
    }
}

#[test]
fn messages_of_a_robot_are_exported_and_retracted_when_they_stop() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Base>::connecting_to(&address).awake();
    fixture.bench.set("stale", 0.1);
    fixture.until_note(Connection::CONNECTING, "looking for the robot");
    let mut odometry = Odometry::planar(stamp(), Pose2D::new(1.0, 2.0, 0.5), Twist::planar(0.2, 0.1));
    fixture.until(|bench| {
        odometry.header.stamp = stamp();
        put(&session, "/odom", &odometry);
        put(&session, "/scan", &*scan(2000));
        bench.exported::<Odometry>("odometry").is_some() && bench.exported::<LaserScan>("laser").is_some()
    });
    let received: Odometry = fixture.bench.exported("odometry").unwrap();
    assert_eq!((received.pose, received.twist), (odometry.pose, odometry.twist));
    assert!(
        Duration::from(received.header.stamp) <= fixture.start.elapsed(),
        "it must be converted to application time"
    );
    assert_eq!(
        fixture.bench.exported_at("odometry"),
        Some(received.header.stamp.into())
    );
    assert_eq!(
        fixture.bench.exported::<LaserScan>("laser").unwrap().ranges.len(),
        1000
    );
    fixture.until_note(Connection::CONNECTED, "/");
    fixture.until(|bench| {
        bench.exported::<Odometry>("odometry").is_none() && bench.exported::<LaserScan>("laser").is_none()
    });
    fixture.until_note(Connection::CONNECTING, "looking for the robot");
    odometry.header.stamp = Time { sec: 12, nanosec: 0 };
    fixture.until(|bench| {
        put(&session, "/odom", &odometry);
        bench.exported::<Odometry>("odometry").is_some()
    });
    assert_eq!(count_log(&fixture.bench, "/odom is stamped "), 1);
    assert_eq!(
        count_log(&fixture.bench, "behind this clock, perhaps in simulated time"),
        1
    );
}

#[test]
fn messages_that_are_older_than_stale_when_they_arrive_are_not_taken() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Base>::connecting_to(&address);
    fixture.bench.set("stale", 0.5);
    // Times before the start of the application count as its start.
    fixture.start -= Duration::from_secs(100);
    let mut fixture = fixture.awake();
    let old = || {
        let now = Duration::from(stamp());
        Time::from(now - Duration::from_secs(2))
    };
    let (mut odometry, mut scan) = (Odometry::default(), scan(40));
    let said = "are older than `stale`, 0.5 s, when they arrive, one by 2.";
    fixture.until(|bench| {
        (odometry.header.stamp, scan.header.stamp) = (old(), old());
        put(&session, "/odom", &odometry);
        put(&session, "/scan", &*scan);
        count_log(bench, said) == 2
    });
    (0..4).for_each(|_| fixture.step());
    assert_eq!(fixture.bench.exported_at("odometry"), None);
    assert_eq!(fixture.bench.exported_at("laser"), None);
    assert_eq!(count_log(&fixture.bench, said), 2, "once for each topic");
    fixture.until(|bench| {
        scan.header.stamp = stamp();
        put(&session, "/scan", &*scan);
        bench.exported_at("laser").is_some()
    });
}

#[test]
fn a_scan_or_an_odometry_that_is_none_ends_the_one_before_it() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Base>::connecting_to(&address).awake();
    let has = |bench: &Bench<Base>| ["laser", "odometry"].map(|export| bench.exported_at(export).is_some());
    fixture.until(|bench| {
        put(&session, "/odom", &Odometry::default());
        put(&session, "/scan", &*scan(40));
        has(bench) == [true, true]
    });
    let mut nowhere = Odometry::default();
    nowhere.pose.pose.orientation.w = 0.0;
    let mut zeros = scan(40);
    zeros.ranges.as_mut_slice().fill(0.0);
    put(&session, "/odom", &nowhere);
    put(&session, "/scan", &*zeros);
    fixture.until(|bench| has(bench) == [false, false]);
    assert_eq!(
        count_log(
            &fixture.bench,
            "/scan: the scan is no measurement: it measures nothing"
        ),
        1
    );
    assert_eq!(
        count_log(
            &fixture.bench,
            "/odom: its orientation is a quaternion without a length"
        ),
        1
    );
}

#[test]
fn depths_inertial_units_and_positions_are_exported_and_retracted_when_they_stop() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Base>::connecting_to(&address);
    fixture.bench.set("depth_topic", Text::<128>::new("depth/image"));
    fixture.bench.set("stale", 0.1);
    let mut fixture = fixture.awake();
    fixture.until_note(Connection::CONNECTING, "looking for the robot");
    let mut imu = Imu {
        header: Header::new(Time::default(), "imu"),
        ..Imu::default()
    };
    imu.angular_velocity.z = 0.5;
    let fix = PositionFix {
        header: Header::new(Time::default(), "map"),
        x: 3.0,
        y: -4.0,
        covariance: [0.25, 0.0, 0.0, 0.5],
    };
    let mut depth = Picture {
        header: Header::new(Time::default(), "camera"),
        ..Picture::default()
    };
    (depth.height, depth.width, depth.step) = (1, 2, 8);
    depth.data.resize(8).fill(7);
    let exports = ["imu", "position", "depth"];
    let send = |export| match export {
        "imu" => put(&session, "/imu", &imu),
        "position" => put(&session, "/position", &PoseWithCovarianceStamped::from(&fix)),
        _ => put(&session, "/depth/image", &depth),
    };
    for export in exports {
        fixture.until_note(Connection::CONNECTING, "looking for the robot");
        fixture.until(|bench| {
            send(export);
            let connection: Option<Connection> = bench.exported("connection");
            let is_connected = connection.is_some_and(|connection| connection.state == Connection::CONNECTED);
            // A message of the export before may arrive late.
            is_connected && bench.exported_at(export).is_some()
        });
    }
    fixture.until(|bench| {
        exports.into_iter().for_each(send);
        exports.iter().all(|export| bench.exported_at(export).is_some())
    });
    let received: Imu = fixture.bench.exported("imu").unwrap();
    assert_eq!(received.angular_velocity, imu.angular_velocity);
    let received: PositionFix = fixture.bench.exported("position").unwrap();
    assert_eq!(
        (received.x, received.y, received.covariance),
        (fix.x, fix.y, fix.covariance)
    );
    fixture.until(|bench| exports.iter().all(|export| bench.exported_at(export).is_none()));
    imu.angular_velocity.z = f64::NAN;
    fixture.until(|bench| {
        put(&session, "/imu", &imu);
        count_log(bench, "/imu: its rates and accelerations are not finite numbers") == 1
    });
    assert_eq!(fixture.bench.exported_at("imu"), None);
}

#[test]
fn hazards_are_exported_as_bumpers_and_retracted_when_they_stop() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Base>::connecting_to(&address);
    fixture
        .bench
        .set("hazard_topic", Text::<128>::new("hazard_detection"));
    fixture.bench.set("stale", 0.1);
    let mut fixture = fixture.awake();
    let mut hazards = HazardDetectionVector {
        header: Header::new(Time::default(), "base_link"),
        ..HazardDetectionVector::default()
    };
    let bumpers = |bench: &Bench<Base>| bench.exported::<Bumpers>("bumpers");
    fixture.until(|bench| {
        put(&session, "/hazard_detection", &hazards);
        bumpers(bench).is_some_and(|bumpers| !bumpers.any())
    });
    let bump = HazardDetection {
        header: Header::new(Time::default(), "bump_left"),
        r#type: BUMP,
        ..HazardDetection::default()
    };
    hazards.detections.push(bump).unwrap();
    fixture.until(|bench| {
        put(&session, "/hazard_detection", &hazards);
        bumpers(bench).is_some_and(|bumpers| bumpers.any())
    });
    assert!(bumpers(&fixture.bench).unwrap().front[0].get());
    fixture.until(|bench| bumpers(bench).is_none());
}

#[test]
fn a_robot_whose_laser_never_speaks_is_reported_once() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Base>::connecting_to(&address).awake();
    let said = "nothing has arrived on /scan yet";
    let turn = |fixture: &mut Fixture<Base>, later: Duration| {
        put(&session, "/odom", &Odometry::default());
        fixture.bench.set_now(fixture.start.elapsed() + later);
        fixture.bench.iterate().unwrap();
        count_log(&fixture.bench, said)
    };
    while fixture.bench.exported::<Odometry>("odometry").is_none() {
        assert_eq!(turn(&mut fixture, Duration::ZERO), 0, "it may still come");
    }
    while turn(&mut fixture, Duration::from_secs(6)) == 0 {}
    for _ in 0..10 {
        assert_eq!(turn(&mut fixture, Duration::from_secs(7)), 1);
    }
    assert_eq!(count_log(&fixture.bench, "nothing has arrived"), 1);
}

#[test]
fn r7_the_velocity_is_sent_while_it_is_in_force_and_then_zero() {
    let address = unused_address();
    let session = open_router(&address);
    let subscriber = listen::<Twist>(&session, "/cmd_vel");
    let mut fixture = Fixture::<Base>::connecting_to(&address).awake();
    fixture.until_note(Connection::CONNECTING, "looking for the robot");
    for _ in 0..50 {
        fixture.step();
    }
    assert_eq!(receive::<Twist>(&subscriber), None, "no command is in force");
    let ahead = Twist::planar(0.3, 0.0);
    fixture.bench.command("velocity", &ahead);
    let mut received = Vec::new();
    fixture.until(|_| {
        received.extend(receive::<Twist>(&subscriber));
        received.len() == 3
    });
    assert_eq!(received, [ahead; 3], "the command must be repeated");
    let stamped_subscriber = listen::<TwistStamped>(&session, "/cmd_vel");
    let mut stamped = None;
    fixture.until(|_| {
        stamped = stamped.or_else(|| receive::<TwistStamped>(&stamped_subscriber));
        stamped.is_some()
    });
    let stamped = stamped.unwrap();
    assert_eq!(
        (stamped.twist, stamped.header.frame_id),
        (ahead, Frame::new("base_link"))
    );
    assert!(i64::from(stamp().sec) - i64::from(stamped.header.stamp.sec) < 3600);
    // The command ends, and the robot rolls on: zero is sent for longer than to a robot that stands.
    let rolling = Odometry::planar(stamp(), Pose2D::default(), ahead);
    let (start, mut ended) = (fixture.start, None);
    fixture.until(|_| {
        put(&session, "/odom", &rolling);
        let stops = receive::<Twist>(&subscriber) == Some(Twist::ZERO);
        if stops {
            ended.get_or_insert(start.elapsed());
        }
        stops && ended.is_some_and(|ended| start.elapsed() > ended + Duration::from_millis(800))
    });
    // Asleep it sends as much as to a robot that stands.
    fixture.bench.command("velocity", &ahead);
    fixture.until(|_| receive::<Twist>(&subscriber) == Some(ahead));
    fixture.bench.sleep().unwrap();
    let mut zeros = 0;
    while zeros < 10 {
        zeros += usize::from(receive::<Twist>(&subscriber) == Some(Twist::ZERO));
    }
}

#[test]
fn images_that_do_not_fit_or_lack_rows_are_reported() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Base>::connecting_to(&address);
    fixture
        .bench
        .set("image_topic", Text::<128>::new("camera/image_raw"));
    let mut fixture = fixture.awake();
    fixture.until_note(Connection::CONNECTING, "looking for the robot");
    let mut image = Picture {
        header: Header::new(Time::default(), "camera"),
        ..Picture::default()
    };
    (image.height, image.width, image.step) = (2, 2, 6);
    image.data.resize(12).fill(7);
    fixture.until(|bench| {
        put(&session, "/camera/image_raw", &image);
        bench.exported_in_place::<Image>("image").is_some()
    });
    let received = fixture.bench.exported_in_place::<Image>("image").unwrap();
    assert_eq!(
        (received.height, received.data.as_slice()),
        (2, [7; 12].as_slice())
    );
    image.height = 3;
    fixture.until(|bench| {
        put(&session, "/camera/image_raw", &image);
        count_log(bench, "/camera/image_raw: a picture with rows missing") == 1
    });
    // The length of a picture of 1280 x 720 pixels, which precedes its bytes.
    let key = topic::<Image>("/camera/image_raw").key(&name());
    image.data.clear();
    let mut large = Codec::new().encode(&image);
    let length = large.len() - 4;
    large[length..].copy_from_slice(&(1280_u32 * 720 * 3).to_le_bytes());
    large.resize(large.len() + 1280 * 720 * 3, 1);
    fixture.until(|bench| {
        session.put(&key, large.clone()).wait().unwrap();
        count_log(bench, "`data` has 2764800 elements, and room for 921600") == 1
    });
}

#[test]
fn damaged_messages_do_no_harm() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Base>::connecting_to(&address);
    fixture.bench.set("image_topic", Text::<128>::new("image"));
    let mut fixture = fixture.awake();
    fixture.until_note(Connection::CONNECTING, "looking for the robot");
    let odometry = Odometry::planar(Time::default(), Pose2D::ORIGIN, Twist::ZERO);
    let messages = [
        (topic::<LaserScan>("/scan"), Codec::new().encode(&*scan(40))),
        (topic::<Odometry>("/odom"), Codec::new().encode(&odometry)),
        (topic::<Image>("/image"), Codec::new().encode(&Picture::default())),
        (
            topic::<BatteryState>("/battery_state"),
            Codec::new().encode(&BatteryState::default()),
        ),
    ];
    // One driver receives all of them, so that damage would persist.
    let fixture = RefCell::new(fixture);
    let damage = (
        0..messages.len(),
        any::<prop::sample::Index>(),
        any::<Vec<u8>>(),
        any::<bool>(),
    );
    let mut runner = TestRunner::new(ProptestConfig::with_cases(256));
    let result = runner.run(&damage, |(index, position, noise, truncated)| {
        let (topic, mut message) = messages[index].clone();
        let position = position.index(message.len());
        if truncated {
            message.truncate(position);
        }
        let end = (position + noise.len()).min(message.len());
        message.splice(position..end, noise);
        session.put(topic.key(&name()), message).wait().unwrap();
        (0..4).for_each(|_| fixture.borrow_mut().step());
        Ok(())
    });
    result.unwrap();
    fixture.borrow_mut().until(|bench| {
        put(&session, "/odom", &odometry);
        bench
            .exported::<Odometry>("odometry")
            .is_some_and(|received| received.pose == odometry.pose)
    });
}

#[test]
fn sonars_of_several_topics_are_one_ring() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Base>::connecting_to(&address);
    let mounts = [Pose2D::new(0.1, 0.05, 0.5), Pose2D::new(0.1, -0.05, -0.5)];
    fixture
        .bench
        .set("sonar_topics", Text::<1024>::new("left, sonar/right"));
    assert!(fixture.bench.awake().is_err(), "they need their places");
    let mut fixture = Fixture::<Base>::connecting_to(&address);
    fixture
        .bench
        .set("sonar_topics", Text::<1024>::new("left, sonar/right"));
    let poses = Seq::from_slice(&mounts).unwrap();
    fixture.bench.set("sonar_mounts", Route { poses });
    fixture.bench.set("stale", 0.3);
    let mut fixture = fixture.awake();
    let sonar = |range| Range {
        header: Header::new(stamp(), "sonar"),
        max_range: 5.0,
        range,
        ..Range::default()
    };
    let ranges = |bench: &Bench<Base>| {
        let ring = bench.exported::<RangeRing>("sonars");
        ring.map_or(Vec::new(), |ring| ring.ranges.to_vec())
    };
    fixture.until(|bench| {
        put(&session, "/left", &sonar(1.5));
        put(&session, "/sonar/right", &sonar(f32::INFINITY));
        ranges(bench) == [1.5, f32::INFINITY]
    });
    let ring: RangeRing = fixture.bench.exported("sonars").unwrap();
    assert_eq!((ring.poses.as_slice(), ring.max_range), (&mounts[..], 5.0));
    fixture.until(|bench| {
        put(&session, "/sonar/right", &sonar(2.0));
        matches!(ranges(bench)[..], [left, right] if left.is_nan() && right == 2.0)
    });
    fixture.until(|bench| bench.exported::<RangeRing>("sonars").is_none());
}
