//! The drivers against sessions of Zenoh in this process, over real sockets of the loopback.

use std::cell::RefCell;
use std::net::TcpListener;
use std::thread;
use std::time::Instant;

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use zenoh::handlers::FifoChannelHandler;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::sample::Sample as Heard;
use zenoh::{Session, Wait};

use crate::keys::{Name, Quality, Topic, Way};
use crate::messages::Codec;
use crate::scan::Sweep;
use crate::settings::Settings;
use crate::tf::Transforms;
use crate::{Base, Follow, Topics};

/// A driver on the bench, in time that passes.
struct Trial<S: Schema> {
    bench: Bench<S>,
    start: Instant,
}

impl<S: Schema> Trial<S> {
    /// A driver that goes to a place, in a domain of this test alone.
    fn at(place: &str) -> Self {
        let mut bench = Bench::new();
        bench.set("connect", Text::<512>::new(place));
        bench.set("domain", 3_i32);
        Self {
            bench,
            start: Instant::now(),
        }
    }

    fn awake(mut self) -> Self {
        self.bench.awake().expect("it is rightly configured");
        self
    }

    fn step(&mut self) {
        self.bench.set_now(self.start.elapsed());
        self.bench
            .iterate()
            .expect("a driver whose network fails does not fail");
        thread::yield_now();
    }

    /// Iterates until something is so; a driver that never gets there hangs, and the runner says so.
    fn until(&mut self, mut good: impl FnMut(&mut Bench<S>) -> bool) {
        while !good(&mut self.bench) {
            self.step();
        }
    }

    fn connection(&self) -> Connection {
        self.bench.exported("connection").unwrap_or_default()
    }

    fn until_note(&mut self, state: u8, words: &str) {
        let right = |note: &Connection| note.state == state && note.note.as_str().contains(words);
        while !right(&self.connection()) {
            self.step();
        }
    }

    fn until_said(&mut self, words: &str) {
        self.until(|bench| said(bench, words) > 0);
    }
}

fn said<S>(bench: &Bench<S>, words: &str) -> usize {
    bench
        .log()
        .iter()
        .filter(|(_, line)| line.contains(words))
        .count()
}

/// A place that nobody has.
fn free() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    format!("tcp/{}", listener.local_addr().unwrap())
}

/// Another program, which listens there.
fn other(place: &str) -> Session {
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("mode", "\"router\"".to_owned()),
        ("listen/endpoints", format!("[\"{place}\"]")),
        ("scouting/multicast/enabled", "false".to_owned()),
    ] {
        config.insert_json5(key, &value).unwrap();
    }
    zenoh::open(config).wait().unwrap()
}

fn name() -> Name {
    Name {
        domain: 3,
        namespace: String::new(),
        node: "other".to_owned(),
    }
}

fn topic<T: Value>(name: &str) -> Topic {
    Codec::<T>::new().topic(name.to_owned(), Quality::Sensor)
}

fn listen<T: Value>(session: &Session, name: &str) -> Subscriber<FifoChannelHandler<Heard>> {
    session
        .declare_subscriber(topic::<T>(name).key(&self::name()))
        .wait()
        .unwrap()
}

fn heard<T: Value>(ear: &Subscriber<FifoChannelHandler<Heard>>) -> Option<T> {
    let sample = ear.try_recv().unwrap()?;
    assert_eq!(sample.attachment().unwrap().len(), 33);
    let mut value = T::zeroed();
    Codec::new()
        .decode_into(&sample.payload().to_bytes(), &mut value)
        .unwrap();
    Some(value)
}

fn put<T: Value>(session: &Session, name: &str, value: &T) {
    session
        .put(topic::<T>(name).key(&self::name()), Codec::new().encode(value))
        .wait()
        .unwrap();
}

/// A stamp of now, by the wall's clock.
fn stamp() -> Time {
    std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .unwrap()
        .into()
}

fn scan(beams: usize) -> Box<Sweep> {
    let mut sweep = Box::new(Sweep::zeroed());
    sweep.header = Header::new(stamp(), "base_scan");
    sweep.angle_increment = 0.001;
    sweep.range_max = 10.0;
    sweep.ranges.resize(beams).fill(2.5);
    sweep
}

/// A picture that leaves room on a stack.
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
    let mut image = Picture::default();
    image.header = Header::new(stamp(), "camera");
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
    // As long as that of a picture of 1280 x 720 pixels: its length stands before its bytes.
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
fn a_connection_that_is_lost_comes_back_by_itself() {
    let place = free();
    let mut trial = Trial::<Topics>::at(&place).awake();
    trial.until_note(Connection::LOST, &place);
    for _ in 0..2 {
        let session = other(&place);
        trial.until_note(Connection::CONNECTED, &place);
        trial.until(|bench| {
            put(&session, "/cmd_vel", &Twist::ZERO);
            bench.exported::<Twist>("cmd_vel").is_some()
        });
        session.close().wait().unwrap();
        trial.until_note(Connection::LOST, "nobody is there any more");
        trial.until(|bench| bench.exported::<Twist>("cmd_vel").is_none());
    }
}

#[test]
fn a_port_in_use_is_named_and_taken_once_it_is_free() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = format!("tcp/{}", taken.local_addr().unwrap());
    let mut trial = Trial::<Base>::at("");
    trial.bench.set("listen", Text::<512>::new(&place));
    let mut trial = trial.awake();
    trial.until_note(Connection::LOST, "Can not create a new TCP listener");
    drop(taken);
    trial.until_note(Connection::CONNECTING, "looking for the other nodes");
}

#[test]
fn topics_of_others_that_never_meet_ours_are_named() {
    let place = free();
    let session = other(&place);
    let announce = |topic: &Topic, way, number| -> LivelinessToken {
        let token = topic.token(&name(), &session.zid().to_string(), way, number);
        session.liveliness().declare_token(token).wait().unwrap()
    };
    let clouds = announce(&topic::<Range>("/scan"), Way::Out, 1);
    let mut trial = Trial::<Base>::at(&place).awake();
    trial.until_said("/scan of node /other is a sensor_msgs/msg/Range, and a sensor_msgs/msg/LaserScan here");
    let old = Topic {
        hash: "RIHS01_0123456789abcdef".to_owned(),
        ..topic::<Twist>("/cmd_vel")
    };
    let other = announce(&old, Way::In, 2);
    trial.until_said(
        "/cmd_vel of node /other is another version of geometry_msgs/msg/Twist, RIHS01_0123456789abc",
    );
    drop((clouds, other));
}

#[test]
fn what_cannot_be_right_is_refused_on_awakening() {
    let refused = |change: &dyn Fn(&mut Bench<Topics>), words: &str| {
        let mut trial = Trial::<Topics>::at("tcp/localhost:7447");
        change(&mut trial.bench);
        let failure = trial.bench.awake().unwrap_err().to_string();
        assert!(failure.contains(words), "{failure}");
    };
    refused(
        &|bench| bench.set("connect", Text::<512>::new("localhost")),
        "tcp/HOST:PORT",
    );
    refused(
        &|bench| bench.set("connect", Text::<512>::EMPTY),
        "it can reach nobody",
    );
    refused(
        &|bench| bench.set("laser_topic", Text::<128>::new("my scan")),
        "`my scan`",
    );
    refused(
        &|bench| bench.set("laser_topic", Text::<128>::new("odom")),
        "two of its topics are called /odom",
    );
    refused(
        &|bench| bench.set("namespace", Text::<128>::new("a-b")),
        "namespace",
    );
    refused(&|bench| bench.set("node", Text::<128>::new("a/b")), "node");
    refused(
        &|bench| bench.set("config", Text::<1024>::new("no.json5")),
        "either",
    );
    refused(&|bench| bench.set_real_time(false), "run without --lockstep");
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

#[test]
fn the_threads_of_zenoh_give_way_to_those_of_the_robot() {
    let place = free();
    let own: Vec<String> = threads().into_iter().map(|(name, _)| name).collect();
    let mut trial = Trial::<Topics>::at(&place).awake();
    trial.until_note(Connection::LOST, &place);
    let theirs = threads();
    assert!(
        theirs.iter().any(|(name, nice)| name == "ros2" && *nice >= 10),
        "{theirs:?} after {own:?}"
    );
}

/// Names of this process's threads, and how much they give way.
fn threads() -> Vec<(String, i32)> {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    tasks
        .filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("stat")).ok())
        .filter_map(|stat| {
            // The name stands in brackets and may hold anything; of the fields behind it the 17th is the niceness (proc_pid_stat(5)).
            let (name, rest) = (
                stat.split_once('(')?.1.rsplit_once(')')?.0,
                stat.rsplit_once(')')?.1,
            );
            Some((name.to_owned(), rest.split_whitespace().nth(16)?.parse().ok()?))
        })
        .collect()
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
    // One driver for all of them: what harms it stays.
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

#[test]
fn a_configuration_of_zenoh_says_where_to_go() {
    let place = free();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("zenoh.json5");
    let text = format!("{{ mode: \"client\", connect: {{ endpoints: [\"{place}\"], timeout_ms: 0 }} }}");
    std::fs::write(&file, text).unwrap();
    let session = other(&place);
    let mut bench = Bench::<Topics>::new();
    bench.set("config", Text::<1024>::new(file.to_str().unwrap()));
    bench.set("domain", 3_i32);
    let mut trial = Trial {
        bench,
        start: Instant::now(),
    }
    .awake();
    trial.until_note(Connection::CONNECTED, "zenoh.json5");
    drop(session);
    let settings = Settings {
        config: folder.path().to_str().unwrap(),
        connect: "",
        listen: "",
        has_way: false,
        domain: 0,
        namespace: "",
        node: "",
        schema: "x",
    };
    assert!(settings.way().is_err(), "a folder is no configuration");
}
