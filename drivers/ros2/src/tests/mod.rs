//! The drivers against Zenoh sessions in this process, over real sockets of the loopback interface.

mod actions;
mod base;
mod bridge;
mod commands;
mod connections;
mod goals;
mod neighbours;
mod pictures;
mod services;
mod standard;
mod topics;
mod transform;
mod watchdog;

use std::net::TcpListener;
use std::thread;
use std::time::Instant;

use jde_ros_node::{Middleware, NodeConfig, NodeName, Quality, Settings, Topic};
use jde_schema::bench::{Bench, Entry};
use jde_schema::prelude::*;
use jde_watchdog::Watchdog;
use zenoh::handlers::FifoChannelHandler;
use zenoh::pubsub::Subscriber;
use zenoh::sample::Sample as ReceivedSample;
use zenoh::{Session, Wait};

use crate::messages::{Codec, PoseWithCovarianceStamped};
use crate::scan::Sweep;

/// A scan of one beam, which hits nothing.
fn one_beam() -> LaserScan {
    let mut scan = LaserScan {
        range_max: 100.0,
        ..LaserScan::default()
    };
    scan.ranges.push(f32::INFINITY).expect("it fits");
    scan
}

/// A driver on the bench, in real time.
struct Fixture<S: Schema> {
    bench: Bench<S>,
    start: Instant,
    _watchdog: Watchdog,
}

impl<S: Schema> Fixture<S> {
    /// A driver that connects to an address, in a domain of this test only.
    fn connecting_to(address: &str) -> Self {
        Self::with_lists(address, &[])
    }

    /// The same, with these entries in its lists.
    fn with_lists(address: &str, entries: &[Entry]) -> Self {
        let mut bench = Bench::with_lists(entries);
        bench.set("connect", Text::<512>::new(address));
        bench.set("domain", 3_i32);
        Self {
            bench,
            start: Instant::now(),
            _watchdog: Watchdog::for_test(),
        }
    }

    fn awake(mut self) -> Self {
        self.bench.awake().expect("its configuration is valid");
        self
    }

    fn step(&mut self) {
        self.bench.set_now(self.start.elapsed());
        self.bench
            .iterate()
            .expect("a failure of the network must not fail the driver");
        thread::yield_now();
    }

    /// Iterates until a condition holds.
    fn until(&mut self, mut condition: impl FnMut(&mut Bench<S>) -> bool) {
        while !condition(&mut self.bench) {
            self.step();
        }
    }

    fn connection(&self) -> Connection {
        self.bench.exported("connection").unwrap_or_default()
    }

    fn until_note(&mut self, state: u8, text: &str) {
        let is_expected = |note: &Connection| note.state == state && note.note.as_str().contains(text);
        while !is_expected(&self.connection()) {
            self.step();
        }
    }

    fn until_logged(&mut self, text: &str) {
        self.until(|bench| count_log(bench, text) > 0);
    }
}

fn count_log<S>(bench: &Bench<S>, text: &str) -> usize {
    bench.log().iter().filter(|(_, line)| line.contains(text)).count()
}

/// Returns an unused address.
fn unused_address() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    format!("tcp/{}", listener.local_addr().unwrap())
}

/// Opens the session of another program, which listens at that address.
fn open_router(address: &str) -> Session {
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("mode", "\"router\"".to_owned()),
        ("listen/endpoints", format!("[\"{address}\"]")),
        ("scouting/multicast/enabled", "false".to_owned()),
    ] {
        config.insert_json5(key, &value).unwrap();
    }
    zenoh::open(config).wait().unwrap()
}

/// The tokens of nodes and topics with these keys.
fn tokens(session: &Session, keys: &str) -> Subscriber<FifoChannelHandler<ReceivedSample>> {
    session.liveliness().declare_subscriber(keys).wait().unwrap()
}

/// The other program's node.
fn config(address: &str) -> NodeConfig {
    let settings = Settings {
        config: "",
        connect: address,
        listen: "",
        domain: 3,
        namespace: "",
        node: "other",
        owner: "",
        remap: "",
    };
    settings.node_config().unwrap()
}

fn name() -> NodeName {
    NodeName {
        domain: 3,
        namespace: String::new(),
        node: "other".to_owned(),
        middleware: Middleware::Rmw,
    }
}

fn topic<T: Value>(name: &str) -> Topic {
    Codec::<T>::new().topic(name.to_owned(), Quality::SENSOR_DATA)
}

fn listen<T: Value>(session: &Session, name: &str) -> Subscriber<FifoChannelHandler<ReceivedSample>> {
    session
        .declare_subscriber(topic::<T>(name).key(&self::name()))
        .wait()
        .unwrap()
}

fn receive<T: Value>(subscriber: &Subscriber<FifoChannelHandler<ReceivedSample>>) -> Option<T> {
    let sample = subscriber.try_recv().unwrap()?;
    assert_eq!(sample.attachment().unwrap().len(), 33);
    let mut value = T::zeroed();
    Codec::new()
        .decode_into(&[&sample.payload().to_bytes()], &mut value)
        .unwrap();
    Some(value)
}

fn put<T: Value>(session: &Session, name: &str, value: &T) {
    session
        .put(topic::<T>(name).key(&self::name()), Codec::new().encode(value))
        .wait()
        .unwrap();
}

/// A stamp of the present wall-clock time.
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
    sweep.angle_max = 0.001 * (beams - 1) as f32;
    sweep
}
