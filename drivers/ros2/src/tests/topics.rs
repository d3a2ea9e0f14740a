//! The topics that a jde robot publishes, and the velocities that it executes.

use super::*;
use crate::messages::PoseWithCovarianceStamped;
use crate::tf::Transforms;
use crate::topics::{Publication, Subscription};
use crate::velocity::TwistStamped;
use crate::{Follow, Topics};

/// The topic of velocities, exported as `cmd_vel`.
fn velocity(label: &str) -> Entry {
    Entry::new::<Twist>("subscribe", label).named("cmd_vel")
}

#[test]
fn sensors_are_published_to_subscribers_with_wall_clock_stamps() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Topics>::with_lists(
        &address,
        &[
            Entry::new::<Odometry>("publish", "odom"),
            Entry::new::<RangeRing>("publish", "sonar"),
            Entry::new::<PositionFix>("publish", "position"),
            Entry::new::<Imu>("publish", "imu"),
        ],
    );
    let odometry = Odometry::planar(
        Duration::from_millis(1),
        Pose2D::new(1.0, 2.0, 0.5),
        Twist::planar(0.2, 0.1),
    );
    fixture.bench.import("odom", &odometry);
    let mut ring = RangeRing {
        max_range: 5.0,
        ..RangeRing::default()
    };
    ring.ranges.extend_from_slice(&[1.0, 2.0]).unwrap();
    ring.poses.extend_from_slice(&[Pose2D::ORIGIN; 2]).unwrap();
    fixture.bench.import("sonar", &ring);
    let fix = PositionFix {
        x: 3.0,
        y: 4.0,
        covariance: [0.04, 0.01, 0.01, 0.09],
        ..PositionFix::default()
    };
    fixture.bench.import("position", &fix);
    let mut imu = Imu::default();
    imu.angular_velocity.z = 0.5;
    fixture.bench.import("imu", &imu);
    let mut fixture = fixture.awake();
    fixture.until_note(Connection::CONNECTED, &address);

    let (subscriber, tree, ranges_subscriber) = (
        listen::<Odometry>(&session, "/odom"),
        listen::<Transforms>(&session, "/tf"),
        listen::<Range>(&session, "/sonar"),
    );
    let mut received = None;
    fixture.until(|_| {
        received = received.or_else(|| receive::<Odometry>(&subscriber));
        received.is_some()
    });
    let received = received.unwrap();
    assert_eq!((received.pose, received.twist), (odometry.pose, odometry.twist));
    assert_eq!(received.header.frame_id, "odom");
    assert!(
        i64::from(stamp().sec) - i64::from(received.header.stamp.sec) < 3600,
        "it must be wall-clock time"
    );

    let mut frames = None;
    fixture.until(|_| {
        frames = frames.take().or_else(|| receive_frames(&tree));
        frames.is_some()
    });
    assert_eq!(frames.unwrap(), ["base_link"]);

    let (imus, positions) = (
        listen::<Imu>(&session, "/imu"),
        listen::<PoseWithCovarianceStamped>(&session, "/position"),
    );
    let (mut inertia, mut place) = (None, None);
    fixture.until(|_| {
        inertia = inertia.or_else(|| receive::<Imu>(&imus));
        place = place.or_else(|| receive::<PoseWithCovarianceStamped>(&positions));
        inertia.is_some() && place.is_some()
    });
    assert_eq!(inertia.unwrap().angular_velocity.z, 0.5);
    let place = place.unwrap().pose;
    assert_eq!((place.pose.position.x, place.pose.position.y), (3.0, 4.0));
    assert_eq!(place.covariance[..2], [0.04, 0.01]);
    assert_eq!(place.covariance[6..8], [0.01, 0.09]);
    assert!(place.covariance[35] > 1e3, "no heading is measured");

    let mut ranges = Vec::new();
    fixture.until(|_| {
        ranges.extend(
            receive::<Range>(&ranges_subscriber)
                .map(|range| (range.header.frame_id.to_string(), range.range)),
        );
        ranges.len() == 2
    });
    assert_eq!(ranges, [("sonar_0".to_owned(), 1.0), ("sonar_1".to_owned(), 2.0)]);
}

/// The frames of a message of transforms.
fn receive_frames(subscriber: &Subscriber<FifoChannelHandler<ReceivedSample>>) -> Option<Vec<String>> {
    let sample = subscriber.try_recv().unwrap()?;
    let mut message = Transforms::boxed();
    Codec::new()
        .decode_into(&[&sample.payload().to_bytes()], &mut *message)
        .unwrap();
    let steps = message.transforms.iter();
    Some(steps.map(|step| step.child_frame_id.to_string()).collect())
}

#[test]
fn each_sonar_of_a_ring_is_sent_once() {
    let address = unused_address();
    let session = open_router(&address);
    let settings = Publication {
        frame: Text::new("rear"),
        ..Publication::DEFAULT
    };
    let entry = Entry::new::<RangeRing>("publish", "sonar").settings(&settings);
    let mut fixture = Fixture::<Topics>::with_lists(&address, &[entry]);
    let mut ring = RangeRing {
        max_range: 5.0,
        ..RangeRing::default()
    };
    ring.ranges.extend_from_slice(&[1.0; 16]).unwrap();
    ring.poses.extend_from_slice(&[Pose2D::ORIGIN; 16]).unwrap();
    fixture.bench.import("sonar", &ring);
    let mut fixture = fixture.awake();
    let subscriber = listen::<Range>(&session, "/sonar");
    let mut frames = Vec::new();
    fixture.until(|_| {
        frames.extend(
            std::iter::from_fn(|| receive::<Range>(&subscriber))
                .map(|range| range.header.frame_id.to_string()),
        );
        frames.len() >= 16
    });
    let expected: Vec<_> = (0..16).map(|number| format!("rear_{number}")).collect();
    assert_eq!(frames, expected);
}

#[test]
fn a_value_is_published_once() {
    let address = unused_address();
    let session = open_router(&address);
    let subscriber = listen::<LaserScan>(&session, "/scan");
    let mut fixture = Fixture::<Topics>::with_lists(&address, &[Entry::new::<LaserScan>("publish", "scan")]);
    let mut scans = 0;
    for number in 1..=3_u8 {
        let scan = LaserScan {
            range_min: f32::from(number),
            ..one_beam()
        };
        fixture.bench.import("scan", &scan);
        if number == 1 {
            fixture = fixture.awake();
        }
        let mut newest = None;
        fixture.until(|_| {
            newest = receive::<LaserScan>(&subscriber);
            newest.is_some()
        });
        scans += 1;
        assert_eq!(newest.unwrap().range_min, f32::from(number));
        for _ in 0..50 {
            fixture.step();
        }
    }
    assert_eq!((scans, receive::<LaserScan>(&subscriber)), (3, None));
}

#[test]
fn the_node_and_its_topics_are_announced() {
    let address = unused_address();
    let session = open_router(&address);
    let tokens = tokens(&session, "@ros2_lv/3/**");
    let mut fixture = Fixture::<Topics>::with_lists(
        &address,
        &[Entry::new::<Odometry>("publish", "odom"), velocity("/cmd_vel")],
    );
    fixture.bench.set("node", Text::<128>::new("pioneer"));
    fixture.bench.set("namespace", Text::<128>::new("fleet"));
    let mut fixture = fixture.awake();
    let mut seen = Vec::new();
    fixture.until(|_| {
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
    fixture.bench.sleep().unwrap();
    let mut gone = 0;
    while gone < 4 {
        gone += usize::from(tokens.recv().is_ok());
    }
}

#[test]
fn a_velocity_is_exported_while_it_is_fresh() {
    let address = unused_address();
    let session = open_router(&address);
    let settings = Subscription {
        stale: 0.05,
        ..Subscription::DEFAULT
    };
    let quick = velocity("cmd_vel").settings(&settings);
    let mut fixture = Fixture::<Topics>::with_lists(&address, &[quick]).awake();
    fixture.until_note(Connection::CONNECTED, &address);
    let twist = Twist::planar(0.3, 0.1);
    fixture.until(|bench| {
        put(&session, "/cmd_vel", &twist);
        bench.exported::<Twist>("cmd_vel").is_some()
    });
    assert_eq!(fixture.bench.exported("cmd_vel"), Some(twist));
    fixture.until(|bench| bench.exported::<Twist>("cmd_vel").is_none());
    fixture.until(|bench| {
        put(&session, "/cmd_vel", &Twist::ZERO);
        bench.exported("cmd_vel") == Some(Twist::ZERO)
    });
    fixture.bench.sleep().unwrap();
    assert_eq!(fixture.bench.exported::<Twist>("cmd_vel"), None);
}

#[test]
fn an_invalid_velocity_is_reported_once_and_ignored() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Topics>::with_lists(&address, &[velocity("cmd_vel")]).awake();
    fixture.until_note(Connection::CONNECTED, &address);
    let key = topic::<Twist>("/cmd_vel").key(&name());
    for (garbage, expected) in [
        (vec![], "/cmd_vel: the message begins with []"),
        (vec![0, 1, 0, 0, 7], "/cmd_vel: the message ends within"),
        (
            Codec::new().encode(&Odometry::default()),
            "/cmd_vel: the message has",
        ),
        (
            Codec::new().encode(&Twist::planar(f64::NAN, 0.0)),
            "/cmd_vel: a velocity that is not finite is ignored",
        ),
    ] {
        fixture.until(|bench| {
            session.put(&key, garbage.clone()).wait().unwrap();
            count_log(bench, expected) > 0
        });
        for _ in 0..20 {
            session.put(&key, garbage.clone()).wait().unwrap();
            fixture.step();
        }
        assert_eq!(count_log(&fixture.bench, expected), 1, "{expected}");
        assert_eq!(fixture.bench.exported::<Twist>("cmd_vel"), None);
    }
}

#[test]
fn r13_an_external_velocity_is_commanded_while_it_is_fresh() {
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

#[test]
fn r13_a_velocity_of_its_own_topic_is_commanded_while_it_is_fresh() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture = Fixture::<Follow>::connecting_to(&address);
    fixture.bench.unbind("cmd_vel");
    fixture.bench.set("topic", Text::<128>::new("teleop/cmd_vel"));
    fixture.bench.set("patience", 0.1);
    let mut fixture = fixture.awake();
    let until_ready = |fixture: &mut Fixture<Follow>, ready: bool, send: &dyn Fn()| loop {
        fixture.bench.set_now(fixture.start.elapsed());
        send();
        if fixture.bench.check().unwrap().ready == ready {
            return;
        }
        thread::yield_now();
    };
    assert!(!fixture.bench.check().unwrap().ready, "nothing arrived");
    let twist = Twist::planar(0.3, -0.1);
    until_ready(&mut fixture, true, &|| put(&session, "/teleop/cmd_vel", &twist));
    fixture.bench.iterate().unwrap();
    assert_eq!(fixture.bench.commanded("base"), Some(twist));
    until_ready(&mut fixture, false, &|| ());
    let stamped = TwistStamped {
        twist: Twist::planar(0.1, 0.2),
        ..TwistStamped::default()
    };
    until_ready(&mut fixture, true, &|| put(&session, "/teleop/cmd_vel", &stamped));
    // A plain one may have been on its way.
    until_ready(&mut fixture, false, &|| ());
    until_ready(&mut fixture, true, &|| put(&session, "/teleop/cmd_vel", &stamped));
    fixture.bench.iterate().unwrap();
    assert_eq!(fixture.bench.commanded("base"), Some(stamped.twist));
    assert_eq!(fixture.connection().state, Connection::CONNECTED);
    fixture.bench.sleep().unwrap();
    assert_eq!(fixture.bench.exported::<Connection>("connection"), None);
}

#[test]
fn velocities_come_from_one_source() {
    for (is_bound, topic) in [(true, "/cmd_vel"), (false, "")] {
        let mut bench = Bench::<Follow>::new();
        if !is_bound {
            bench.unbind("cmd_vel");
        }
        bench.set("topic", Text::<128>::new(topic));
        let problems = bench.inspect().unwrap();
        assert_eq!(problems.len(), 1, "{problems:?}");
        assert_eq!(problems[0].modulation, "topic");
        bench.awake().unwrap();
        assert!(!bench.check().unwrap().ready);
    }
}

#[test]
fn any_type_is_published_with_its_frame_and_period_and_exported_while_it_is_fresh() {
    let address = unused_address();
    let session = open_router(&address);
    let published = Publication {
        period: 10.0,
        frame: Text::new("world"),
        ..Publication::DEFAULT
    };
    let fresh = Subscription {
        stale: 0.05,
        ..Subscription::DEFAULT
    };
    let kept = Subscription {
        stale: 0.0,
        ..Subscription::DEFAULT
    };
    let mut fixture = Fixture::<Topics>::with_lists(
        &address,
        &[
            Entry::new::<Path>("publish", "plan").settings(&published),
            Entry::new::<Mission>("publish", "/mission"),
            Entry::new::<PoseStamped>("subscribe", "goal_pose")
                .settings(&fresh)
                .named("goal"),
            Entry::new::<Pose2D>("subscribe", "place").settings(&kept),
        ],
    )
    .awake();
    fixture.until_note(Connection::CONNECTED, &address);
    let (plans, missions) = (
        listen::<Path>(&session, "/plan"),
        listen::<Mission>(&session, "/mission"),
    );
    let mut path = Path::default();
    path.poses
        .push(PoseStamped {
            header: Header::new(Time::default(), "odom"),
            pose: Pose2D::new(1.0, 2.0, 0.5).into(),
        })
        .unwrap();
    let mission = Mission {
        reached: 3,
        ..Mission::default()
    };
    fixture.bench.import("plan", &path);
    fixture.bench.import("/mission", &mission);
    let (mut plan, mut seen) = (None, None);
    fixture.until(|_| {
        plan = plan.take().or_else(|| receive::<Path>(&plans));
        seen = seen.or_else(|| receive::<Mission>(&missions));
        plan.is_some() && seen.is_some()
    });
    let plan = plan.unwrap();
    assert_eq!((plan.header.frame_id.as_str(), plan.poses.len()), ("world", 1));
    assert_eq!(plan.poses[0].pose, path.poses[0].pose);
    assert_eq!(seen.unwrap(), mission);

    fixture.bench.import("plan", &path);
    fixture.bench.import("/mission", &mission);
    fixture.until(|_| receive::<Mission>(&missions).is_some());
    assert_eq!(receive::<Path>(&plans), None, "ten seconds have not passed");

    let goal = PoseStamped {
        header: Header::new(stamp(), "map"),
        pose: Pose2D::new(3.0, 4.0, 1.0).into(),
    };
    let place = Pose2D::new(5.0, 6.0, 0.0);
    fixture.until(|bench| {
        put(&session, "/goal_pose", &goal);
        put(&session, "/place", &place);
        bench.exported::<PoseStamped>("goal").is_some() && bench.exported::<Pose2D>("place").is_some()
    });
    let exported = fixture.bench.exported::<PoseStamped>("goal").unwrap();
    assert_eq!(
        (exported.pose, exported.header.frame_id),
        (goal.pose, goal.header.frame_id)
    );
    assert!(exported.header.stamp.sec < 3600, "the application's time");
    fixture.until(|bench| bench.exported::<PoseStamped>("goal").is_none());
    assert_eq!(fixture.bench.exported("place"), Some(place), "it stays");
    fixture.bench.sleep().unwrap();
    assert_eq!(fixture.bench.exported::<Pose2D>("place"), None);
}

#[test]
fn a_message_that_does_not_fit_is_reported_once() {
    let address = unused_address();
    let session = open_router(&address);
    let mut fixture =
        Fixture::<Topics>::with_lists(&address, &[Entry::new::<PoseStamped>("subscribe", "goal")]).awake();
    fixture.until_note(Connection::CONNECTED, &address);
    let key = topic::<PoseStamped>("/goal").key(&name());
    for garbage in [
        vec![],
        vec![0, 1, 0, 0, 7],
        vec![0, 1, 0, 0, 7, 7, 7, 7, 7, 7, 7, 7, 255, 255, 255, 255],
    ] {
        fixture.until(|bench| {
            session.put(&key, garbage.clone()).wait().unwrap();
            count_log(bench, "/goal: the message") > 0
        });
    }
    assert_eq!(fixture.bench.exported::<PoseStamped>("goal"), None);
}

#[test]
fn a_latched_value_reaches_who_subscribes_later_both_ways() {
    let address = unused_address();
    let _router = open_router(&address);
    let map = |list: &str| Entry::new::<OccupancyGrid>(list, "map");
    let mut early = Fixture::<Topics>::with_lists(&address, &[map("publish")]).awake();
    early.until_note(Connection::CONNECTED, &address);
    let mut grid = OccupancyGrid::boxed();
    grid.info.width = 3;
    early.bench.import("map", &*grid);
    for _ in 0..50 {
        early.step();
    }
    let mut late = Fixture::<Topics>::with_lists(&address, &[map("subscribe")]).awake();
    late.until(|bench| {
        early.step();
        bench
            .exported_in_place::<OccupancyGrid>("map")
            .is_some_and(|map| map.info.width == 3)
    });
}
