//! What contradicts or ends what was measured: a second node that publishes it, and a time of a simulation that stands or
//! jumps.

use jde_ros_node::Node;

use super::*;
use crate::clock_source::{ClockMessage, FollowedClock};
use crate::topics::Subscription;
use crate::{Base, Topics};

/// A node of that name that publishes scans.
fn lidar(address: &str, name: &str) -> Node {
    let mut config = config(address);
    name.clone_into(&mut config.name.node);
    config.publications = vec![topic::<Sweep>("/scan")];
    Node::start(config).unwrap()
}

fn send(node: &Node) {
    node.append(0, Codec::new().encode(&*scan(40)));
}

/// Lets two nodes publish the scans of a driver, and returns when it has said so.
#[track_caller]
fn assert_neither_counts<S: Schema>(mut fixture: Fixture<S>, address: &str, laser: &str) {
    let [first, second] = ["lidar", "bag"].map(|name| lidar(address, name));
    let has_scan = |bench: &Bench<S>| bench.exported_at(laser).is_some();
    fixture.until(|bench| {
        send(&first);
        has_scan(bench)
    });
    let said = "node /bag and node /lidar publish /scan, and contradict each other";
    fixture.until(|bench| {
        send(&first);
        send(&second);
        !has_scan(bench) && count_log(bench, said) == 1
    });
    for _ in 0..20 {
        send(&first);
        fixture.step();
        assert!(!has_scan(&fixture.bench));
        send(&second);
        fixture.step();
        assert!(!has_scan(&fixture.bench));
    }
    assert_eq!(count_log(&fixture.bench, said), 1, "it is said once");
    drop(second);
    fixture.until(|bench| {
        send(&first);
        has_scan(bench)
    });
}

#[test]
fn r19_a_base_has_no_scan_while_two_nodes_publish_it() {
    let address = unused_address();
    let _router = open_router(&address);
    let fixture = Fixture::<Base>::connecting_to(&address).awake();
    assert_neither_counts(fixture, &address, "laser");
}

#[test]
fn r19_a_topic_of_a_sensor_has_no_value_while_two_nodes_publish_it() {
    let address = unused_address();
    let _router = open_router(&address);
    let entry = Entry::new::<LaserScan>("subscribe", "scan").settings(&Subscription::DEFAULT);
    let fixture = Fixture::<Topics>::with_lists(&address, &[entry]).awake();
    assert_neither_counts(fixture, &address, "scan");
}

/// A base that follows the time of a simulation, and its robot.
struct Simulation {
    session: Session,
    fixture: Fixture<Base>,
    time: Duration,
}

impl Simulation {
    fn new() -> Self {
        let address = unused_address();
        let session = open_router(&address);
        let mut fixture = Fixture::<Base>::connecting_to(&address);
        fixture.bench.set("clock", FollowedClock::Follow);
        fixture.bench.set("stale", 5.0);
        Self {
            session,
            fixture: fixture.awake(),
            time: Duration::from_secs(50),
        }
    }

    fn has_scan(&self) -> bool {
        self.fixture.bench.exported_at("laser").is_some()
    }

    /// Publishes a scan of the present time of the simulation.
    fn publish_scan(&self, beams: usize) {
        let mut scan = scan(beams);
        scan.header.stamp = self.time.into();
        put(&self.session, "/scan", &*scan);
    }

    /// Measures a scan at the present time of the simulation.
    fn measure(&mut self) {
        self.publish_scan(40);
        self.fixture.step();
    }

    /// Lets the time of the simulation go on by a millisecond.
    fn tick(&mut self) {
        self.time += Duration::from_millis(1);
        let clock = self.time.into();
        put(&self.session, "/clock", &ClockMessage { clock });
    }

    /// Lets the time of the simulation jump by these seconds, before its next millisecond.
    fn jump(&mut self, step: i64) {
        let size = Duration::from_secs(step.unsigned_abs());
        self.time = if step < 0 {
            self.time - size
        } else {
            self.time + size
        };
    }

    /// Lets the time of the simulation go on until the base has a scan, or none.
    fn run_until(&mut self, has_scan: bool) {
        while self.has_scan() != has_scan {
            self.tick();
            self.measure();
        }
    }

    /// Lets the time of the simulation stand, and returns when no message with an earlier one is under way. The messages of
    /// a session arrive in the order in which it sent them.
    fn stand(&mut self) {
        const LAST: usize = 41;
        self.tick();
        let beams = |bench: &Bench<Base>| Some(bench.exported::<LaserScan>("laser")?.ranges.len());
        while beams(&self.fixture.bench) != Some(LAST) {
            self.publish_scan(LAST);
            self.fixture.step();
        }
    }
}

#[test]
fn r19_what_was_measured_ends_when_the_time_of_a_simulation_stands_or_jumps() {
    let mut simulation = Simulation::new();
    simulation.run_until(true);
    simulation.stand();
    // The application's time goes on, and that of the simulation does not.
    simulation.fixture.start -= Duration::from_secs(3);
    let said = "the time on /clock stands";
    simulation.fixture.until_logged(said);
    assert!(!simulation.has_scan());
    simulation.fixture.until_note(Connection::CONNECTING, "/clock");
    (0..20).for_each(|_| simulation.measure());
    assert!(
        !simulation.has_scan(),
        "there is no time to compare its stamp with"
    );
    for (step, said) in [
        (3600, "the time on /clock has jumped forward, by 36"),
        (-3640, "the time on /clock has jumped back, by 36"),
    ] {
        simulation.run_until(true);
        simulation.stand();
        simulation.jump(step);
        simulation.run_until(false);
        // A scan of another time may have arrived before the time on /clock.
        simulation.fixture.until_logged(said);
        assert_eq!(count_log(&simulation.fixture.bench, said), 1);
    }
    simulation.run_until(true);
    assert_eq!(count_log(&simulation.fixture.bench, said), 1);
}

#[test]
fn another_clock_is_taken_while_the_driver_is_awake() {
    let mut simulation = Simulation::new();
    simulation.run_until(true);
    simulation.fixture.bench.set("clock", FollowedClock::Wall);
    simulation.fixture.step();
    assert!(!simulation.has_scan(), "it was measured by another clock");
    let session = &simulation.session;
    simulation.fixture.until(|bench| {
        put(session, "/scan", &*scan(40));
        bench.exported_at("laser").is_some()
    });
    simulation.fixture.bench.set("clock", FollowedClock::Follow);
    simulation.fixture.step();
    assert!(!simulation.has_scan());
    simulation.run_until(true);
}

#[test]
fn r7_no_velocity_is_sent_while_the_time_of_a_simulation_stands() {
    let mut simulation = Simulation::new();
    let robot = listen::<Twist>(&simulation.session, "/cmd_vel");
    let ahead = Twist::planar(0.3, 0.0);
    let received = || std::iter::from_fn(|| receive::<Twist>(&robot)).last();
    let drive_until = |simulation: &mut Simulation, expected: Twist, ticks: bool| {
        while received() != Some(expected) {
            simulation.fixture.bench.command("velocity", &ahead);
            if ticks {
                simulation.tick();
            }
            simulation.fixture.step();
        }
    };
    drive_until(&mut simulation, ahead, true);
    simulation.run_until(true);
    simulation.stand();
    simulation.fixture.start -= Duration::from_secs(3);
    simulation.fixture.until_logged("the time on /clock stands");
    drive_until(&mut simulation, Twist::ZERO, false);
    for _ in 0..50 {
        simulation.fixture.bench.command("velocity", &ahead);
        simulation.fixture.step();
        assert_ne!(received(), Some(ahead), "nobody sees where the robot goes");
    }
    drive_until(&mut simulation, ahead, true);
}
