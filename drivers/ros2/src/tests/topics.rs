//! The topics that a jde robot publishes, and the velocities that it follows.

use super::*;
use crate::tf::Transforms;
use crate::{Follow, Topics};

#[test]
fn what_is_sensed_is_published_in_the_time_of_ros_for_whoever_listens() {
    let place = free();
    let session = other(&place);
    let mut trial = Trial::<Topics>::at(&place);
    let odometry = Odometry::planar(
        Duration::from_millis(1),
        Pose2D::new(1.0, 2.0, 0.5),
        Twist::planar(0.2, 0.1),
    );
    trial.bench.import("odometry", &odometry);
    let mut ring = RangeRing::default();
    ring.ranges.extend_from_slice(&[1.0, 2.0]).unwrap();
    ring.poses.extend_from_slice(&[Pose2D::ORIGIN; 2]).unwrap();
    trial.bench.import("sonars", &ring);
    trial.bench.unbind("image");
    let mut trial = trial.awake();
    trial.until_note(Connection::CONNECTED, &place);

    let (ear, tree, echoes) = (
        listen::<Odometry>(&session, "/odom"),
        listen::<Transforms>(&session, "/tf"),
        listen::<Range>(&session, "/sonar"),
    );
    let mut told = None;
    trial.until(|_| {
        told = told.or_else(|| heard::<Odometry>(&ear));
        told.is_some()
    });
    let told = told.unwrap();
    assert_eq!((told.pose, told.twist), (odometry.pose, odometry.twist));
    assert_eq!(told.header.frame_id, "odom");
    assert!(
        i64::from(stamp().sec) - i64::from(told.header.stamp.sec) < 3600,
        "it is the wall's"
    );

    let mut steps = None;
    trial.until(|_| {
        steps = steps.or_else(|| heard::<Transforms>(&tree));
        steps.is_some()
    });
    let frames: Vec<_> = steps
        .unwrap()
        .transforms
        .iter()
        .map(|step| step.child_frame_id.to_string())
        .collect();
    assert_eq!(frames, ["base_link", "sonar_0", "sonar_1"]);

    let mut ranges = Vec::new();
    trial.until(|_| {
        ranges.extend(heard::<Range>(&echoes).map(|echo| (echo.header.frame_id.to_string(), echo.range)));
        ranges.len() == 2
    });
    assert_eq!(ranges, [("sonar_0".to_owned(), 1.0), ("sonar_1".to_owned(), 2.0)]);
}

#[test]
fn a_value_is_sent_once() {
    let place = free();
    let session = other(&place);
    let ear = listen::<LaserScan>(&session, "/scan");
    let mut trial = Trial::<Topics>::at(&place);
    let mut scans = 0;
    for number in 1..=3_u8 {
        let scan = LaserScan {
            range_min: f32::from(number),
            ..LaserScan::default()
        };
        trial.bench.import("laser", &scan);
        if number == 1 {
            trial = trial.awake();
        }
        let mut newest = None;
        trial.until(|_| {
            newest = heard::<LaserScan>(&ear);
            newest.is_some()
        });
        scans += 1;
        assert_eq!(newest.unwrap().range_min, f32::from(number));
        for _ in 0..50 {
            trial.step();
        }
    }
    assert_eq!((scans, heard::<LaserScan>(&ear)), (3, None));
}

#[test]
fn who_is_there_is_seen_in_ros() {
    let place = free();
    let session = other(&place);
    let tokens = session
        .liveliness()
        .declare_subscriber("@ros2_lv/3/**")
        .wait()
        .unwrap();
    let mut trial = Trial::<Topics>::at(&place);
    trial.bench.set("node", Text::<128>::new("pioneer"));
    trial.bench.set("namespace", Text::<128>::new("fleet"));
    for port in ["laser", "image", "sonars", "battery"] {
        trial.bench.unbind(port);
    }
    trial.bench.set("cmd_vel_topic", Text::<128>::new("/cmd_vel"));
    let mut trial = trial.awake();
    let mut seen = Vec::new();
    trial.until(|_| {
        while let Ok(Some(sample)) = tokens.try_recv() {
            seen.push(sample.key_expr().to_string());
        }
        seen.len() == 4
    });
    let all = seen.join("\n");
    for part in [
        "/0/0/NN/%/%fleet/pioneer",
        "/MP/%/%fleet/pioneer/%fleet%odom/nav_msgs::msg::dds_::Odometry_/RIHS01_3cc97dc7",
        "/MP/%/%fleet/pioneer/%tf/tf2_msgs::msg::dds_::TFMessage_/RIHS01_",
        "/MS/%/%fleet/pioneer/%cmd_vel/geometry_msgs::msg::dds_::Twist_/RIHS01_9c45bf16",
    ] {
        assert!(all.contains(part), "no {part} in\n{all}");
    }
    trial.bench.sleep().unwrap();
    let mut gone = 0;
    while gone < 4 {
        gone += usize::from(tokens.recv().is_ok());
    }
}

#[test]
fn a_velocity_counts_while_it_is_fresh() {
    let place = free();
    let session = other(&place);
    let mut trial = Trial::<Topics>::at(&place).awake();
    trial.bench.set("stale", 0.05);
    trial.until_note(Connection::CONNECTED, &place);
    let twist = Twist::planar(0.3, 0.1);
    trial.until(|bench| {
        put(&session, "/cmd_vel", &twist);
        bench.exported::<Twist>("cmd_vel").is_some()
    });
    assert_eq!(trial.bench.exported("cmd_vel"), Some(twist));
    trial.until(|bench| bench.exported::<Twist>("cmd_vel").is_none());
    trial.until(|bench| {
        put(&session, "/cmd_vel", &Twist::ZERO);
        bench.exported("cmd_vel") == Some(Twist::ZERO)
    });
    trial.bench.sleep().unwrap();
    assert_eq!(trial.bench.exported::<Twist>("cmd_vel"), None);
}

#[test]
fn what_is_no_velocity_is_said_once_and_not_obeyed() {
    let place = free();
    let session = other(&place);
    let mut trial = Trial::<Topics>::at(&place).awake();
    trial.until_note(Connection::CONNECTED, &place);
    let key = topic::<Twist>("/cmd_vel").key(&name());
    for (garbage, words) in [
        (vec![], "/cmd_vel: the message begins with []"),
        (vec![0, 1, 0, 0, 7], "/cmd_vel: the message ends within"),
        (
            Codec::new().encode(&Odometry::default()),
            "/cmd_vel: the message has",
        ),
        (
            Codec::new().encode(&Twist::planar(f64::NAN, 0.0)),
            "/cmd_vel: a velocity that is no number is not obeyed",
        ),
    ] {
        trial.until(|bench| {
            session.put(&key, garbage.clone()).wait().unwrap();
            said(bench, words) > 0
        });
        for _ in 0..20 {
            session.put(&key, garbage.clone()).wait().unwrap();
            trial.step();
        }
        assert_eq!(said(&trial.bench, words), 1, "{words}");
        assert_eq!(trial.bench.exported::<Twist>("cmd_vel"), None);
    }
}

#[test]
fn r13_a_velocity_from_elsewhere_is_obeyed_while_it_is_fresh() {
    let mut bench = Bench::<Follow>::new();
    assert!(!bench.check().unwrap().ready);
    let twist = Twist::planar(0.3, -0.1);
    bench.import("cmd_vel", &twist);
    assert!(bench.check().unwrap().ready);
    bench.iterate().unwrap();
    assert_eq!(bench.commanded("base"), Some(twist));
    bench.set_now(Duration::from_millis(501));
    assert!(!bench.check().unwrap().ready);
    bench.retract("cmd_vel");
    assert!(!bench.check().unwrap().ready);
}
