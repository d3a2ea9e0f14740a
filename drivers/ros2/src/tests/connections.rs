//! Connections: settings, losses, and nodes that do not communicate.

use zenoh::liveliness::LivelinessToken;

use super::*;
use crate::keys::Direction;
use crate::settings::Settings;
use crate::{Base, Topics};

#[test]
fn a_connection_that_is_lost_comes_back_by_itself() {
    let place = free();
    let mut trial = Trial::<Topics>::at(&place).awake();
    trial.until_note(Connection::LOST, "nobody answers there; is the router running?");
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
    let clouds = announce(&topic::<Range>("/scan"), Direction::Publish, 1);
    let mut trial = Trial::<Base>::at(&place).awake();
    trial.until_said("/scan of node /other is a sensor_msgs/msg/Range, and a sensor_msgs/msg/LaserScan here");
    let old = Topic {
        hash: "RIHS01_0123456789abcdef".to_owned(),
        ..topic::<Twist>("/cmd_vel")
    };
    let other = announce(&old, Direction::Subscribe, 2);
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
fn an_inspection_names_the_modulation_and_calls_nobody() {
    let found = |change: &dyn Fn(&mut Bench<Topics>)| {
        let mut trial = Trial::<Topics>::at("tcp/localhost:7447");
        change(&mut trial.bench);
        let found = trial.bench.inspect().unwrap();
        let names = found.into_iter().map(|problem| problem.modulation);
        names.collect::<Vec<_>>()
    };
    assert!(found(&|_| {}).is_empty());
    assert_eq!(
        found(&|bench| bench.set("connect", Text::<512>::EMPTY)),
        ["connect"]
    );
    assert_eq!(
        found(&|bench| bench.set("laser_topic", Text::<128>::new("my scan"))),
        ["laser_topic"]
    );
    assert_eq!(
        found(&|bench| bench.set("namespace", Text::<128>::new("a-b"))),
        ["namespace"]
    );
    assert_eq!(
        found(&|bench| bench.set("node", Text::<128>::new("a/b"))),
        ["node"]
    );
    assert_eq!(
        found(&|bench| bench.set("config", Text::<1024>::new("no.json5"))),
        ["config"]
    );
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
        _watchdog: Watchdog::for_test(),
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
        has_endpoint: false,
        domain: 0,
        namespace: "",
        node: "",
        schema: "x",
    };
    assert!(
        settings.connection_config().is_err(),
        "a folder is no configuration"
    );
}
