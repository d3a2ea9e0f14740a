//! Connections: settings, losses, and nodes that do not communicate.

use jde_ros_node::{Direction, Settings};

use zenoh::liveliness::LivelinessToken;

use super::*;
use crate::topics::{Publication, Subscription};
use crate::velocity::TwistStamped;
use crate::{Base, Topics};

#[test]
fn a_lost_connection_is_restored_automatically() {
    let address = unused_address();
    let velocity = Entry::new::<Twist>("subscribe", "cmd_vel");
    let mut fixture = Fixture::<Topics>::with_lists(&address, &[velocity]).awake();
    fixture.until_note(
        Connection::LOST,
        "no router answers at this address; is it running?",
    );
    for _ in 0..2 {
        let session = open_router(&address);
        fixture.until_note(Connection::CONNECTED, &address);
        fixture.until(|bench| {
            put(&session, "/cmd_vel", &Twist::ZERO);
            bench.exported::<Twist>("cmd_vel").is_some()
        });
        session.close().wait().unwrap();
        fixture.until_note(Connection::LOST, "no router or node is connected any more");
        fixture.until(|bench| bench.exported::<Twist>("cmd_vel").is_none());
    }
}

#[test]
fn a_port_in_use_is_reported_and_opened_once_it_is_free() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("tcp/{}", taken.local_addr().unwrap());
    let mut fixture = Fixture::<Base>::connecting_to("");
    fixture.bench.set("listen", Text::<512>::new(&address));
    let mut fixture = fixture.awake();
    fixture.until_note(Connection::LOST, "Can not create a new TCP listener");
    drop(taken);
    fixture.until_note(Connection::CONNECTING, "no other node is connected yet");
}

#[test]
fn incompatible_topics_of_other_nodes_are_reported() {
    let address = unused_address();
    let session = open_router(&address);
    let announce = |topic: &Topic, direction, number| -> LivelinessToken {
        let token = topic.token(&name(), &session.zid().to_string(), direction, number);
        session.liveliness().declare_token(token).wait().unwrap()
    };
    let range_topic = announce(&topic::<Range>("/scan"), Direction::Publish, 1);
    let mut fixture = Fixture::<Base>::connecting_to(&address).awake();
    fixture.until_logged(
        "/scan of node /other is a sensor_msgs/msg/Range, and a sensor_msgs/msg/LaserScan here",
    );
    let old = Topic {
        hash: "RIHS01_0123456789abcdef".to_owned(),
        ..topic::<Twist>("/cmd_vel")
    };
    let version_token = announce(&old, Direction::Subscribe, 2);
    fixture.until_logged(
        "/cmd_vel of node /other is another version of geometry_msgs/msg/Twist, RIHS01_0123456789abc",
    );
    drop((range_topic, version_token));
}

#[test]
fn invalid_settings_are_rejected_on_awakening() {
    let assert_rejected = |change: &dyn Fn(&mut Bench<Topics>), expected: &str| {
        let mut fixture = Fixture::<Topics>::connecting_to("tcp/localhost:7448");
        change(&mut fixture.bench);
        let failure = fixture.bench.awake().unwrap_err().to_string();
        assert!(failure.contains(expected), "{failure}");
    };
    assert_rejected(
        &|bench| bench.set("connect", Text::<512>::new("localhost")),
        "tcp/HOST:PORT",
    );
    assert_rejected(
        &|bench| bench.set("connect", Text::<512>::EMPTY),
        "no address is set",
    );
    assert_rejected(
        &|bench| bench.set("tf_topic", Text::<128>::new("my tf")),
        "`my tf`",
    );
    assert_rejected(
        &|bench| bench.set("namespace", Text::<128>::new("a-b")),
        "namespace",
    );
    assert_rejected(&|bench| bench.set("node", Text::<128>::new("a/b")), "node");
    assert_rejected(
        &|bench| bench.set("config", Text::<1024>::new("no.json5")),
        "either",
    );
    assert_rejected(&|bench| bench.set_real_time(false), "run without --lockstep");
}

#[test]
fn an_inspection_names_the_modulation_without_connecting() {
    let problem_names = |change: &dyn Fn(&mut Bench<Topics>)| {
        let mut fixture = Fixture::<Topics>::connecting_to("tcp/localhost:7448");
        change(&mut fixture.bench);
        let problems = fixture.bench.inspect().unwrap();
        let names = problems.into_iter().map(|problem| problem.modulation);
        names.collect::<Vec<_>>()
    };
    assert!(problem_names(&|_| {}).is_empty());
    assert_eq!(
        problem_names(&|bench| bench.set("connect", Text::<512>::EMPTY)),
        ["connect"]
    );
    assert_eq!(
        problem_names(&|bench| bench.set("tf_topic", Text::<128>::new("my tf"))),
        ["tf_topic"]
    );
    assert_eq!(
        problem_names(&|bench| bench.set("namespace", Text::<128>::new("a-b"))),
        ["namespace"]
    );
    assert_eq!(
        problem_names(&|bench| bench.set("node", Text::<128>::new("a/b"))),
        ["node"]
    );
    assert_eq!(
        problem_names(&|bench| bench.set("config", Text::<1024>::new("no.json5"))),
        ["config"]
    );
}

#[test]
fn wrong_entries_of_lists_are_refused_with_what_is_wrong() {
    let published = |settings: Publication| Entry::new::<LaserScan>("publish", "scan").settings(&settings);
    let default = Publication::DEFAULT;
    let qos = Subscription {
        qos: Text::new("fast"),
        ..Subscription::DEFAULT
    };
    let yaw = Subscription {
        yaw: 1.0,
        ..Subscription::DEFAULT
    };
    let mount = Publication {
        mount: Pose2D::new(0.1, 0.0, 0.0),
        ..default
    };
    let frame = Publication {
        frame: Text::new("map"),
        ..default
    };
    let latched = Publication {
        qos: Text::new("latched"),
        ..default
    };
    let unmoved = Publication {
        transform: Flag::FALSE,
        ..default
    };
    let camera = Publication {
        field_of_view: 1.0,
        ..default
    };
    for (entries, place, expected) in [
        (
            vec![Entry::new::<Twist>("publish", "my scan")],
            "my scan",
            "`my scan` is not a valid name",
        ),
        (
            vec![published(default), Entry::new::<Twist>("publish", "/scan")],
            "/scan",
            "have the same topic",
        ),
        (
            vec![Entry::new::<Odometry>("publish", "odom").settings(&mount)],
            "odom",
            "`mount` belongs to laser",
        ),
        (
            vec![Entry::new::<Twist>("publish", "speed").settings(&frame)],
            "speed",
            "`frame` belongs to messages",
        ),
        (
            vec![Entry::new::<Twist>("publish", "speed").settings(&latched)],
            "speed",
            "a velocity cannot be latched",
        ),
        (
            vec![Entry::new::<Imu>("publish", "imu").settings(&unmoved)],
            "imu",
            "`transform` belongs to an odometry",
        ),
        (
            vec![
                Entry::new::<Image>("publish", "image").settings(&camera),
                Entry::new::<Image>("publish", "depth").settings(&camera),
            ],
            "depth",
            "have the same topic",
        ),
        (
            vec![published(Publication {
                period: -1.0,
                ..default
            })],
            "scan",
            "`period` is -1",
        ),
        (
            vec![Entry::new::<Imu>("subscribe", "imu").settings(&qos)],
            "imu",
            "`qos` is \"fast\"",
        ),
        (
            vec![Entry::new::<Imu>("subscribe", "imu").settings(&yaw)],
            "imu",
            "`yaw` belongs to laser",
        ),
    ] {
        let mut fixture = Fixture::<Topics>::with_lists("tcp/localhost:7447", &entries);
        let failure = fixture.bench.awake().unwrap_err().to_string();
        assert!(failure.contains(expected), "{failure}");
        let mut fixture = Fixture::<Topics>::with_lists("tcp/localhost:7447", &entries);
        let problems = fixture.bench.inspect().unwrap();
        let places: Vec<_> = problems.iter().map(|problem| &*problem.modulation).collect();
        assert_eq!(places, [place], "{expected}");
    }
}

#[test]
fn the_threads_of_zenoh_have_lower_priority() {
    let address = unused_address();
    let before: Vec<String> = threads().into_iter().map(|(name, _)| name).collect();
    let mut fixture = Fixture::<Topics>::connecting_to(&address).awake();
    fixture.until_note(Connection::LOST, &address);
    let after = threads();
    assert!(
        after.iter().any(|(name, nice)| name == "ros2" && *nice >= 10),
        "{after:?} after {before:?}"
    );
}

/// Names and niceness of this process's threads.
fn threads() -> Vec<(String, i32)> {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    tasks
        .filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("stat")).ok())
        .filter_map(|stat| {
            // The name is in brackets and may contain any character. The 17th field after it is the niceness
            // (proc_pid_stat(5)).
            let (name, rest) = (
                stat.split_once('(')?.1.rsplit_once(')')?.0,
                stat.rsplit_once(')')?.1,
            );
            Some((name.to_owned(), rest.split_whitespace().nth(16)?.parse().ok()?))
        })
        .collect()
}

#[test]
fn a_zenoh_configuration_file_states_the_addresses() {
    let address = unused_address();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("zenoh.json5");
    let text = format!("{{ mode: \"client\", connect: {{ endpoints: [\"{address}\"], timeout_ms: 0 }} }}");
    std::fs::write(&file, text).unwrap();
    let session = open_router(&address);
    let mut bench = Bench::<Topics>::new();
    bench.set("config", Text::<1024>::new(file.to_str().unwrap()));
    bench.set("domain", 3_i32);
    let mut fixture = Fixture {
        _watchdog: Watchdog::for_test(),
        bench,
        start: Instant::now(),
    }
    .awake();
    fixture.until_note(Connection::CONNECTED, "zenoh.json5");
    drop(session);
    let settings = Settings {
        config: folder.path().to_str().unwrap(),
        connect: "tcp/localhost:7447",
        listen: "",
        domain: 0,
        namespace: "",
        node: "",
        owner: "x",
        remap: "",
    };
    assert!(
        settings.connection_config().is_err(),
        "a folder is not a configuration"
    );
}

#[test]
fn nodes_of_humble_have_keys_and_tokens_without_hashes() {
    let address = unused_address();
    let session = open_router(&address);
    let tokens = tokens(&session, "@ros2_lv/3/**");
    let key = |topic: &str, kind: &str| format!("3/fleet/{topic}/{kind}/TypeHashNotSupported");
    let scans = session
        .declare_subscriber(key("scan", "sensor_msgs::msg::dds_::LaserScan_"))
        .wait()
        .unwrap();
    let entries = [
        Entry::new::<LaserScan>("publish", "scan"),
        Entry::new::<Odometry>("subscribe", "odom").named("odometry"),
        Entry::new::<Range>("subscribe", "ahead"),
        Entry::new::<Range>("publish", "left"),
    ];
    let mut fixture = Fixture::<Topics>::with_lists(&format!("humble/{address}"), &entries);
    let lefts = session
        .declare_subscriber(key("left", "sensor_msgs::msg::dds_::Range_"))
        .wait()
        .unwrap();
    let left = Range {
        max_range: 1.0,
        range: f32::INFINITY,
        ..Range::default()
    };
    fixture.bench.import("left", &left);
    fixture.bench.set("namespace", Text::<128>::new("fleet"));
    fixture.bench.import("scan", &one_beam());
    let mut fixture = fixture.awake();
    // It has a subscriber once there is a token of one without a hash.
    let subscription = Topic {
        hash: "TypeHashNotSupported".to_owned(),
        ..topic::<LaserScan>("/fleet/scan")
    };
    let token = subscription.token(&name(), "ab12", jde_ros_node::Direction::Subscribe, 1);
    let _token = session.liveliness().declare_token(token).wait().unwrap();
    fixture.until(|_| receive::<LaserScan>(&scans).is_some());
    let odometry = Odometry::planar(Duration::from_secs(1), Pose2D::new(1.0, 2.0, 0.0), Twist::ZERO);
    fixture.until(|bench| {
        session
            .put(
                key("odom", "nav_msgs::msg::dds_::Odometry_"),
                Codec::new().encode(&odometry),
            )
            .wait()
            .unwrap();
        bench
            .exported::<Odometry>("odometry")
            .is_some_and(|seen| seen.pose == odometry.pose)
    });
    // The variance, which is its last field, is not in Humble.
    let range = Range {
        range: 1.5,
        max_range: 2.0,
        ..Range::default()
    };
    let mut message = Codec::new().encode(&range);
    message.truncate(message.len() - 4);
    let subscription = Topic {
        hash: "TypeHashNotSupported".to_owned(),
        ..topic::<Range>("/fleet/left")
    };
    let token = subscription.token(&name(), "ab12", jde_ros_node::Direction::Subscribe, 2);
    let _left = session.liveliness().declare_token(token).wait().unwrap();
    fixture.until(|_| {
        let sample = lefts.try_recv().unwrap();
        sample
            .is_some_and(|sample| sample.payload().len() == Codec::new().encode(&Range::default()).len() - 4)
    });
    fixture.until(|bench| {
        session
            .put(key("ahead", "sensor_msgs::msg::dds_::Range_"), message.clone())
            .wait()
            .unwrap();
        bench
            .exported::<Range>("ahead")
            .is_some_and(|seen| (seen.range, seen.variance) == (1.5, 0.0))
    });
    let mut tokens = tokens.iter().map(|token| token.key_expr().to_string());
    let announced = tokens.find(|token| token.contains("/MP/")).unwrap();
    assert!(
        announced.contains("LaserScan_/TypeHashNotSupported/"),
        "{announced}"
    );
}

#[test]
fn a_velocity_has_the_quality_that_its_entry_states_in_both_forms() {
    let address = unused_address();
    let session = open_router(&address);
    let tokens = tokens(&session, "@ros2_lv/3/**");
    // Another node has the stamped form, so that it is announced.
    let stamped = topic::<TwistStamped>("/cmd_vel");
    let _theirs = [Direction::Publish, Direction::Subscribe].map(|direction| {
        let token = stamped.token(&name(), "ab12", direction, 1);
        session.liveliness().declare_token(token).wait().unwrap()
    });
    let published = Publication {
        reliability: Text::new("best_effort"),
        depth: 3,
        ..Publication::DEFAULT
    };
    let subscribed = Subscription {
        reliability: Text::new("best_effort"),
        depth: 4,
        ..Subscription::DEFAULT
    };
    let mut fixture = Fixture::<Topics>::with_lists(
        &address,
        &[
            Entry::new::<Twist>("publish", "cmd_vel").settings(&published),
            Entry::new::<Twist>("subscribe", "cmd_vel")
                .settings(&subscribed)
                .named("velocity"),
        ],
    )
    .awake();
    let mut announced = Vec::new();
    fixture.until(|_| {
        let seen = std::iter::from_fn(|| tokens.try_recv().unwrap());
        announced.extend(seen.map(|sample| sample.key_expr().to_string()));
        announced.iter().filter(|token| token.contains("/bench/")).count() == 4
    });
    for (kind, profile) in [("/MP/", "2::,3:"), ("/MS/", "2::,4:")] {
        for form in ["Twist_", "TwistStamped_"] {
            let is_it = |token: &&String| {
                token.contains("/bench/") && token.contains(kind) && token.contains(&format!("::{form}/"))
            };
            let token = announced.iter().find(is_it).unwrap();
            assert!(token.contains(&format!("/{profile}")), "{token}");
        }
    }
}
