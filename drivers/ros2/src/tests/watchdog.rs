//! A watchdog beside a program that drives.

use super::*;
use crate::drive::MIN_STOP_TIME;
use crate::velocity::TwistStamped;
use crate::{Base, Watchdog};

const AHEAD: Twist = Twist::planar(0.3, 0.0);

/// A watchdog, and the session of the program that drives, which also is the robot.
struct Watched {
    session: Session,
    robot: Subscriber<FifoChannelHandler<ReceivedSample>>,
    fixture: Fixture<Watchdog>,
    address: String,
}

impl Watched {
    fn new() -> Self {
        let address = unused_address();
        let session = open_router(&address);
        let robot = listen::<Twist>(&session, "/cmd_vel");
        let mut fixture = Fixture::<Watchdog>::connecting_to(&address);
        fixture.bench.set("timeout", 0.2);
        Self {
            session,
            robot,
            fixture: fixture.awake(),
            address,
        }
    }

    /// A turn of the watchdog. Returns whether it is READY.
    fn turn(&mut self) -> bool {
        let bench = &mut self.fixture.bench;
        bench.set_now(self.fixture.start.elapsed());
        let is_ready = bench.check().expect("the network fails no check").ready;
        if is_ready {
            bench.iterate().expect("the network fails no iteration");
        }
        thread::yield_now();
        is_ready
    }

    /// The velocities of nodes that have come to the robot.
    fn received(&self) -> Vec<Twist> {
        of_nodes(&self.robot)
    }

    /// Drives for so many turns, in which no zero comes.
    fn drive(&mut self, turns: usize) {
        for _ in 0..turns {
            put(&self.session, "/cmd_vel", &AHEAD);
            self.turn();
            assert!(!self.received().contains(&Twist::ZERO), "it drives");
        }
    }

    /// Publishes a velocity and no other, until the watchdog has noticed it. Returns a time just before that.
    fn abandon<T: Value>(&mut self, velocity: &T) -> Instant {
        loop {
            put(&self.session, "/cmd_vel", velocity);
            let sent = Instant::now();
            while sent.elapsed() < Duration::from_secs(1) {
                let before = Instant::now();
                if self.turn() {
                    return before;
                }
            }
        }
    }

    /// Waits for so many zeros.
    fn until_zeros(&mut self, mut count: usize) {
        while count > 0 {
            self.turn();
            count = count.saturating_sub(
                self.received()
                    .iter()
                    .filter(|twist| **twist == Twist::ZERO)
                    .count(),
            );
        }
    }
}

/// The messages that came from nodes, and not from the session of the test.
fn of_nodes<T: Value>(subscriber: &Subscriber<FifoChannelHandler<ReceivedSample>>) -> Vec<T> {
    let samples = std::iter::from_fn(|| subscriber.try_recv().unwrap());
    samples
        .filter(|sample| sample.attachment().is_some())
        .map(|sample| {
            let mut value = T::zeroed();
            let decoded = Codec::new().decode_into(&[&sample.payload().to_bytes()], &mut value);
            decoded.map(|()| value).unwrap()
        })
        .collect()
}

#[test]
fn zeros_are_published_once_velocities_have_ceased_and_until_they_come_again() {
    let mut watched = Watched::new();
    watched.fixture.start -= Duration::from_secs(10);
    for _ in 0..50 {
        assert!(!watched.turn(), "nobody has driven");
    }
    assert!(watched.received().is_empty());
    while watched.fixture.connection().state != Connection::CONNECTED {
        watched.turn();
    }
    // Each in time, however slow this machine is.
    watched.fixture.bench.set("timeout", 60.0);
    watched.drive(200);
    assert_eq!(watched.fixture.bench.exported("velocity"), Some(AHEAD));
    watched.fixture.bench.set("timeout", 0.2);
    put(&watched.session, "/cmd_vel", &AHEAD);
    let last = Instant::now();
    watched.until_zeros(1);
    assert!(last.elapsed() >= Duration::from_millis(200), "it came too early");
    watched.until_zeros(3);
    let said = "zeros are published until one comes";
    assert_eq!(count_log(&watched.fixture.bench, said), 1);
    while watched.turn() {
        put(&watched.session, "/cmd_vel", &AHEAD);
    }
    assert_eq!(
        count_log(&watched.fixture.bench, "velocities come on /cmd_vel again"),
        1
    );
    watched.fixture.bench.set("timeout", 60.0);
    watched.received();
    watched.drive(50);
}

#[test]
fn a_program_that_stopped_the_robot_may_be_silent() {
    let mut watched = Watched::new();
    let before = watched.abandon(&AHEAD);
    put(&watched.session, "/cmd_vel", &Twist::ZERO);
    while watched.turn() {}
    assert!(before.elapsed() >= MIN_STOP_TIME, "one zero may be lost");
    watched.fixture.start -= Duration::from_secs(10);
    for _ in 0..50 {
        assert!(!watched.turn(), "the robot stands");
    }
}

#[test]
fn a_stamped_velocity_is_watched_and_its_robot_gets_stamped_zeros() {
    let mut watched = Watched::new();
    let robot = listen::<TwistStamped>(&watched.session, "/cmd_vel");
    let stamped = TwistStamped {
        twist: AHEAD,
        ..TwistStamped::default()
    };
    watched.abandon(&stamped);
    let is_zero = |stamped: &TwistStamped| stamped.twist == Twist::ZERO;
    while !of_nodes(&robot).iter().any(is_zero) {
        watched.turn();
    }
}

#[test]
fn a_base_does_not_take_its_watchdog_for_a_rival() {
    let mut watched = Watched::new();
    let tokens = tokens(&watched.session, "@ros2_lv/3/**");
    let mut base = Fixture::<Base>::connecting_to(&watched.address).awake();
    // The base drives, and falls silent as if it were killed.
    let mut has_noticed = false;
    while !has_noticed {
        while watched.received().is_empty() {
            base.bench.command("velocity", &AHEAD);
            base.step();
        }
        let sent = Instant::now();
        while !has_noticed && sent.elapsed() < Duration::from_secs(1) {
            has_noticed = watched.turn();
        }
    }
    watched.until_zeros(1);
    for _ in 0..50 {
        base.step();
    }
    assert_eq!(count_log(&base.bench, "do not pass through this application"), 0);
    assert_eq!(count_log(&watched.fixture.bench, "ignores its own messages"), 0);
    let announced: Vec<String> = std::iter::from_fn(|| tokens.try_recv().unwrap())
        .map(|sample| sample.key_expr().to_string())
        .collect();
    let of_watchdog = |kind: &str| {
        let is_its = |token: &&String| token.contains(kind) && token.contains("/schema/");
        announced.iter().filter(is_its).count()
    };
    assert_eq!(of_watchdog("/MP/"), 0, "{announced:?}");
}
