//! Transforms of other nodes as exports, and those that a jde robot publishes.

use jde_ros::cdr;
use jde_schema::types::{Transform as Tf, TransformStamped};

use super::*;
use crate::clock_source::ClockMessage;
use crate::tf::{Placed, Transforms, message};
use crate::topics::Publication;
use crate::{Topics, Transform};

/// Publishes where a frame is in another one.
fn publish(session: &Session, topic: &str, stamp: Time, [parent, child]: [&str; 2], x: f64) {
    let placed = Placed {
        parent: Frame::new(parent),
        child: Frame::new(child),
        transform: Pose::from(Pose2D::new(x, 0.0, 0.0)).into(),
    };
    put(session, topic, &*message([placed], stamp));
}

/// A schema that looks up `base_link` in `map`, with a router and that router's session.
fn fixture() -> (Session, Fixture<Transform>) {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Transform>::connecting_to(&address);
    fixture.bench.unbind("laser");
    let mut odometry = Odometry::default();
    odometry.twist.twist = Twist::planar(0.2, 0.0);
    fixture.bench.import("odometry", &odometry);
    (session, fixture)
}

fn state(bench: &Bench<Transform>) -> String {
    bench
        .exported::<Text<160>>("state")
        .map_or(String::new(), |state| state.to_string())
}

#[test]
fn the_base_on_the_map_of_a_localizer_is_exported_until_it_is_stale() {
    let (session, mut fixture) = fixture();
    fixture.bench.set("stale", 0.3);
    let mut fixture = fixture.awake();
    fixture.until(|bench| state(bench).contains("nobody publishes the frame `map`; known are none"));
    fixture.until(|bench| {
        let now = stamp();
        // As AMCL does, ahead of time.
        let ahead = Time {
            sec: now.sec + 1,
            ..now
        };
        publish(&session, "/tf", ahead, ["map", "odom"], 5.0);
        publish(&session, "/tf", now, ["odom", "base_link"], 1.0);
        bench.exported::<Odometry>("pose").is_some()
    });
    let pose: Odometry = fixture.bench.exported("pose").unwrap();
    assert_eq!(pose.pose2d(), Pose2D::new(6.0, 0.0, 0.0));
    assert_eq!(pose.twist.twist, Twist::planar(0.2, 0.0));
    let frames = (pose.header.frame_id.as_str(), pose.child_frame_id.as_str());
    assert_eq!(frames, ("map", "base_link"));
    let transform: TransformStamped = fixture.bench.exported("transform").unwrap();
    assert_eq!(transform.transform.translation.x, 6.0);
    assert!(
        Duration::from(transform.header.stamp) <= fixture.start.elapsed(),
        "it is in the application's time"
    );
    fixture.until(|bench| bench.exported::<Odometry>("pose").is_none());
    fixture.until(|bench| state(bench).contains("is older than 0.3 s"));
    assert!(fixture.bench.exported::<TransformStamped>("transform").is_none());
}

#[test]
fn a_frame_that_gets_a_second_parent_is_retracted_at_once() {
    let (session, fixture) = fixture();
    let mut fixture = fixture.awake();
    let address = fixture.connection();
    assert!(!address.is_up());
    fixture.until(|bench| {
        publish(&session, "/tf", stamp(), ["map", "base_link"], 1.0);
        bench.exported::<TransformStamped>("transform").is_some()
    });
    publish(&session, "/tf", stamp(), ["odom", "base_link"], 2.0);
    fixture.until(|bench| bench.exported::<TransformStamped>("transform").is_none());
    assert!(state(&fixture.bench).contains("`base_link` has two parents, `map` and `odom`"));
    fixture.until_logged("/tf: `base_link` has two parents");
}

#[test]
fn the_laser_is_given_at_the_time_of_its_scan() {
    let (session, mut fixture) = fixture();
    let measured_at = Duration::from_millis(1);
    let scan = LaserScan {
        header: Header::new(measured_at, "laser"),
        ..one_beam()
    };
    fixture.bench.import("laser", &scan);
    fixture.bench.set("stale", 3600.0);
    let mut fixture = fixture.awake();
    // The scan is half way between the two.
    let begin = stamp();
    let at = |seconds: i32| Time {
        sec: begin.sec + seconds,
        nanosec: 0,
    };
    fixture.until(|bench| {
        for (seconds, x) in [(-2, 0.0), (2, 4.0)] {
            publish(&session, "/tf", at(seconds), ["map", "laser"], x);
        }
        bench.exported::<TransformStamped>("transform").is_some()
    });
    let found: TransformStamped = fixture.bench.exported("transform").unwrap();
    let frames = (found.header.frame_id.as_str(), found.child_frame_id.as_str());
    assert_eq!(
        (frames, Duration::from(found.header.stamp)),
        (("map", "laser"), measured_at)
    );
    let x = found.transform.translation.x;
    assert!((0.0..4.0).contains(&x), "{x}");
    assert_eq!(fixture.bench.exported_at("transform"), Some(measured_at));
}

#[test]
fn a_simulated_clock_is_followed_and_its_jump_back_forgets_what_was() {
    let (session, mut fixture) = fixture();
    fixture
        .bench
        .set("clock", crate::clock_source::FollowedClock::Follow);
    let mut fixture = fixture.awake();
    let at = |sec| Time { sec, nanosec: 0 };
    fixture.until_note(Connection::CONNECTING, "/clock");
    // A time that stands is none.
    let mut ms = 50_000;
    let mut tick = || {
        ms += 1;
        let clock = Duration::from_millis(ms).into();
        put(&session, "/clock", &ClockMessage { clock });
    };
    fixture.until(|bench| {
        tick();
        publish(&session, "/tf", at(50), ["map", "base_link"], 1.0);
        bench.exported::<TransformStamped>("transform").is_some()
    });
    assert_eq!(count_log(&fixture.bench, "another clock"), 0);
    put(&session, "/clock", &ClockMessage { clock: at(3) });
    fixture.until(|bench| bench.exported::<TransformStamped>("transform").is_none());
    fixture.until_logged("has jumped back");
    let mut ms = 3_000;
    fixture.until(|bench| {
        ms += 1;
        let clock = Duration::from_millis(ms).into();
        put(&session, "/clock", &ClockMessage { clock });
        publish(&session, "/tf", at(3), ["map", "base_link"], 7.0);
        bench.exported::<TransformStamped>("transform").is_some()
    });
    let found: TransformStamped = fixture.bench.exported("transform").unwrap();
    assert_eq!(found.transform.translation.x, 7.0);
}

#[test]
fn transforms_of_another_clock_are_refused_in_words() {
    let (session, fixture) = fixture();
    let mut fixture = fixture.awake();
    fixture.until(|bench| {
        publish(
            &session,
            "/tf",
            Time { sec: 5, nanosec: 0 },
            ["map", "base_link"],
            1.0,
        );
        count_log(bench, "is stamped more than 10 s from this clock and is ignored") > 0
    });
    assert!(fixture.bench.exported::<TransformStamped>("transform").is_none());
}

#[test]
fn mounts_of_a_jde_robot_reach_a_lookup_that_begins_later() {
    let address = unused_address();
    let _router = open_router(&address);
    let mut robot = Fixture::<Topics>::with_lists(
        &address,
        &[
            Entry::new::<LaserScan>("publish", "scan").settings(&Publication {
                mount: Pose2D::new(0.25, 0.0, 0.0),
                ..Publication::DEFAULT
            }),
            Entry::new::<Odometry>("publish", "odom"),
        ],
    );
    let scan = LaserScan {
        header: Header::new(Time::default(), "laser"),
        ..one_beam()
    };
    robot.bench.import("scan", &scan);
    robot.bench.import(
        "odom",
        &Odometry::planar(Duration::ZERO, Pose2D::ORIGIN, Twist::ZERO),
    );
    let mut robot = robot.awake();
    robot.until_note(Connection::CONNECTED, &address);
    let mut late = Fixture::<Transform>::connecting_to(&address);
    for port in ["laser", "odometry"] {
        late.bench.unbind(port);
    }
    late.bench.set("target", Frame::new("base_link"));
    late.bench.set("source", Frame::new("laser"));
    let mut late = late.awake();
    late.until(|bench| {
        robot.step();
        bench.exported::<TransformStamped>("transform").is_some()
    });
    let found: TransformStamped = late.bench.exported("transform").unwrap();
    assert_eq!(found.transform, Tf::from(Pose::from(Pose2D::new(0.25, 0.0, 0.0))));
    assert!(state(&late.bench).contains("`laser` in `base_link` is static"));
}

#[test]
fn frames_have_names_longer_than_those_of_values() {
    let (session, fixture) = fixture();
    let mut fixture = fixture.awake();
    let long = "arm/".repeat(40);
    let mut message = Vec::new();
    let mut writer = cdr::Writer::new(&mut message);
    let now = stamp();
    let steps = [("map", &*long, 1.0), (&long, "base_link", 2.0)];
    writer.length(steps.len());
    for (parent, child, x) in steps {
        writer.number(now.sec.to_le_bytes());
        writer.number(now.nanosec.to_le_bytes());
        writer.text(parent.as_bytes());
        writer.text(child.as_bytes());
        for number in [x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0_f64] {
            writer.number(number.to_le_bytes());
        }
    }
    fixture.until(|bench| {
        let key = topic::<Transforms>("/tf").key(&name());
        session.put(key, message.clone()).wait().unwrap();
        bench.exported::<TransformStamped>("transform").is_some()
    });
    let found: TransformStamped = fixture.bench.exported("transform").unwrap();
    assert_eq!(found.transform.translation.x, 3.0);
}

#[test]
fn two_lasers_in_one_frame_are_said_to_have_one_mount() {
    let address = unused_address();
    let _router = open_router(&address);
    let laser = |label, x| {
        Entry::new::<LaserScan>("publish", label).settings(&Publication {
            mount: Pose2D::new(x, 0.0, 0.0),
            ..Publication::DEFAULT
        })
    };
    let entries = [laser("front", 0.25), laser("again", 0.25), laser("back", -0.25)];
    let mut fixture = Fixture::<Topics>::with_lists(&address, &entries);
    let scan = LaserScan {
        header: Header::new(Time::default(), "laser"),
        ..one_beam()
    };
    for label in ["front", "again", "back"] {
        fixture.bench.import(label, &scan);
    }
    let mut fixture = fixture.awake();
    fixture.until_logged(
        "`back` and `front` in `publish` are both in the frame `laser`, which is where `front` is mounted: state a `frame` of its own \
         for one of them",
    );
    for _ in 0..20 {
        fixture.step();
    }
    assert_eq!(count_log(&fixture.bench, "in the frame `laser`"), 1);
}
