//! A ROS 2 robot as a base.

use std::cell::RefCell;

use proptest::prelude::*;
use proptest::test_runner::TestRunner;

use super::*;
use crate::Base;

/// A picture that is small enough for a stack.
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
fn a_robot_of_ros_is_sensed_and_what_falls_silent_is_taken_back() {
    let place = free();
    let session = other(&place);
    let mut trial = Trial::<Base>::at(&place).awake();
    trial.bench.set("stale", 0.1);
    trial.until_note(Connection::CONNECTING, "looking for the robot");
    let mut odometry = Odometry::planar(stamp(), Pose2D::new(1.0, 2.0, 0.5), Twist::planar(0.2, 0.1));
    trial.until(|bench| {
        put(&session, "/odom", &odometry);
        put(&session, "/scan", &*scan(2000));
        bench.exported::<Odometry>("odometry").is_some() && bench.exported::<LaserScan>("laser").is_some()
    });
    let told: Odometry = trial.bench.exported("odometry").unwrap();
    assert_eq!((told.pose, told.twist), (odometry.pose, odometry.twist));
    assert!(
        Duration::from(told.header.stamp) <= trial.start.elapsed(),
        "in our time"
    );
    assert_eq!(
        trial.bench.exported_at("odometry"),
        Some(told.header.stamp.into())
    );
    assert_eq!(
        trial.bench.exported::<LaserScan>("laser").unwrap().ranges.len(),
        1000
    );
    trial.until_note(Connection::CONNECTED, "/");
    trial.until(|bench| {
        bench.exported::<Odometry>("odometry").is_none() && bench.exported::<LaserScan>("laser").is_none()
    });
    trial.until_note(Connection::CONNECTING, "looking for the robot");
    odometry.header.stamp = Time { sec: 12, nanosec: 0 };
    trial.until(|bench| {
        put(&session, "/odom", &odometry);
        bench.exported::<Odometry>("odometry").is_some()
    });
    assert_eq!(said(&trial.bench, "/odom is stamped "), 1);
    assert_eq!(
        said(&trial.bench, "behind this clock, perhaps in simulated time"),
        1
    );
}

#[test]
fn r7_the_robot_is_told_the_velocity_while_it_is_in_force_and_at_last_to_stop() {
    let place = free();
    let session = other(&place);
    let ear = listen::<Twist>(&session, "/cmd_vel");
    let mut trial = Trial::<Base>::at(&place).awake();
    trial.until_note(Connection::CONNECTING, "looking for the robot");
    for _ in 0..50 {
        trial.step();
    }
    assert_eq!(heard::<Twist>(&ear), None, "nobody has commanded anything");
    let ahead = Twist::planar(0.3, 0.0);
    trial.bench.command("velocity", &ahead);
    let mut told = Vec::new();
    trial.until(|_| {
        told.extend(heard::<Twist>(&ear));
        told.len() == 3
    });
    assert_eq!(told, [ahead; 3], "again and again");
    trial.bench.sleep().unwrap();
    while told.last() != Some(&Twist::ZERO) {
        told.extend(heard::<Twist>(&ear));
    }
}

#[test]
fn pictures_that_do_not_fit_or_lack_rows_are_named() {
    let place = free();
    let session = other(&place);
    let mut trial = Trial::<Base>::at(&place);
    trial
        .bench
        .set("image_topic", Text::<128>::new("camera/image_raw"));
    let mut trial = trial.awake();
    trial.until_note(Connection::CONNECTING, "looking for the robot");
    let mut image = Picture {
        header: Header::new(stamp(), "camera"),
        ..Picture::default()
    };
    (image.height, image.width, image.step) = (2, 2, 6);
    image.data.resize(12).fill(7);
    trial.until(|bench| {
        put(&session, "/camera/image_raw", &image);
        bench.exported_in_place::<Image>("image").is_some()
    });
    let told = trial.bench.exported_in_place::<Image>("image").unwrap();
    assert_eq!((told.height, told.data.as_slice()), (2, [7; 12].as_slice()));
    image.height = 3;
    trial.until(|bench| {
        put(&session, "/camera/image_raw", &image);
        said(bench, "/camera/image_raw: a picture with rows missing") == 1
    });
    // The length of a picture of 1280 x 720 pixels, which precedes its bytes.
    let key = topic::<Image>("/camera/image_raw").key(&name());
    image.data.clear();
    let mut large = Codec::new().encode(&image);
    let length = large.len() - 4;
    large[length..].copy_from_slice(&(1280_u32 * 720 * 3).to_le_bytes());
    large.resize(large.len() + 1280 * 720 * 3, 1);
    trial.until(|bench| {
        session.put(&key, large.clone()).wait().unwrap();
        said(bench, "`data` has 2764800 elements, and room for 921600") == 1
    });
}

#[test]
fn messages_nobody_meant_do_no_harm() {
    let place = free();
    let session = other(&place);
    let mut trial = Trial::<Base>::at(&place);
    trial.bench.set("image_topic", Text::<128>::new("image"));
    let mut trial = trial.awake();
    trial.until_note(Connection::CONNECTING, "looking for the robot");
    let odometry = Odometry::planar(stamp(), Pose2D::ORIGIN, Twist::ZERO);
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
    let trial = RefCell::new(trial);
    let damage = (
        0..messages.len(),
        any::<prop::sample::Index>(),
        any::<Vec<u8>>(),
        any::<bool>(),
    );
    let mut runner = TestRunner::new(ProptestConfig::with_cases(256));
    let harmless = runner.run(&damage, |(which, at, noise, cut)| {
        let (topic, mut message) = messages[which].clone();
        let at = at.index(message.len());
        if cut {
            message.truncate(at);
        }
        let end = (at + noise.len()).min(message.len());
        message.splice(at..end, noise);
        session.put(topic.key(&name()), message).wait().unwrap();
        (0..4).for_each(|_| trial.borrow_mut().step());
        Ok(())
    });
    harmless.unwrap();
    trial.borrow_mut().until(|bench| {
        put(&session, "/odom", &odometry);
        bench
            .exported::<Odometry>("odometry")
            .is_some_and(|told| told.pose == odometry.pose)
    });
}
