//! Sessions with the server for tests, in virtual time.

use core::time::Duration;

use jde_player::*;

use crate::server::{self, ALL, Address, Server};

/// A session and a server, connected by a wire.
struct Wire {
    session: Session,
    server: Server,
    now: Duration,
    events: Vec<Event>,
}

impl Wire {
    fn new(server: Server, options: Options) -> Self {
        let mut wire = Self {
            session: Session::new(options, Duration::ZERO),
            server,
            now: Duration::ZERO,
            events: Vec::new(),
        };
        let greeting = wire.server.connected();
        wire.receive(&greeting);
        wire.exchange();
        wire
    }

    fn receive(&mut self, bytes: &[u8]) {
        self.session.receive(bytes, self.now);
        self.events.extend(self.session.events());
    }

    /// Exchanges bytes until neither side sends any more.
    fn exchange(&mut self) {
        loop {
            let sent = self.session.output();
            if sent.is_empty() {
                return;
            }
            let replies = self.server.receive(&sent);
            self.receive(&replies);
        }
    }

    /// Lets the server send the data of all devices.
    fn data(&mut self) {
        let data = self.server.data();
        self.receive(&data);
    }

    fn drive(&mut self, setpoint: Setpoint) {
        self.session.drive(&setpoint, self.now);
        self.exchange();
    }

    fn robot(&self) -> &Robot {
        match self.session.state() {
            State::Connected => self.session.robot().expect("it is connected"),
            state => panic!("{state:?}"),
        }
    }

    fn lost(&self) -> &str {
        match self.session.state() {
            State::Lost(reason) => reason,
            state => panic!("{state:?}"),
        }
    }

    fn warnings(&self) -> Vec<&str> {
        let warnings = self.events.iter().filter_map(|event| match event {
            Event::Warning(words) => Some(&**words),
            _ => None,
        });
        warnings.collect()
    }
}

fn connected(devices: &[Address], options: Options) -> Wire {
    Wire::new(Server::new(devices), options)
}

fn named(interface: Interface, index: u16) -> Choice {
    Choice::Device(interface.at(index))
}

#[test]
fn a_robot_is_found_with_all_its_devices() {
    let wire = connected(&ALL, Options::default());
    let robot = wire.robot();
    assert_eq!(
        robot.to_string(),
        "Player 3.1.0, position2d:0 (stage), laser ranger:1 at 0.10, 0.00 m, 0°, 4 sonars ranger:0, \
         bumper:0, power:0, ptz:0"
    );
    assert_eq!(wire.events, [Event::Ready(Box::new(robot.clone()))]);
    assert!(wire.server.motors_on);
    let used = [
        server::BASE,
        server::SONARS,
        server::LASER,
        server::BUMPERS,
        server::POWER,
        server::HEAD,
    ];
    assert_eq!(
        wire.server.subscribed, used,
        "nothing is subscribed that is not used"
    );
    let ring = robot.sonars.as_ref().unwrap();
    assert_eq!((ring.view, ring.range_min, ring.range_max), (2.0, 0.05, 8.0));
    assert_eq!(
        ring.mounts[3],
        Mount {
            x: 0.0,
            y: 0.1 * 3.0,
            yaw: 0.0
        }
    );
    let (_, bumpers) = robot.bumpers.as_ref().unwrap();
    assert_eq!(
        bumpers[2],
        Mount {
            x: -0.2,
            y: 0.0,
            yaw: 0.0
        }
    );
}

#[test]
fn data_are_decoded() {
    let mut wire = connected(&ALL, Options::default());
    wire.server.stalled = true;
    wire.events.clear();
    wire.data();
    let Event::Sonars(sonars) = wire.events.remove(1) else {
        panic!("{:?}", wire.events)
    };
    assert_eq!(sonars[..3], [1.0, 2.0, 8.0]);
    assert!(sonars[3].is_nan());
    let base = Base {
        pose: [1.0, 2.0, 0.5],
        velocity: [0.3, 0.0, -0.1],
        stalled: true,
    };
    let scan = Scan {
        angle_min: -1.0,
        angle_max: 1.0,
        range_min: 0.05,
        range_max: 8.0,
        ranges: vec![1.0, 2.0, 8.0, 0.01, 3.0],
    };
    let power = Power {
        volts: Some(12.5),
        percent: Some(80.0),
        charging: Some(-1),
        ..Power::default()
    };
    let head = Head {
        pan: 0.1,
        tilt: 0.2,
        zoom: 0.8,
        ..Head::default()
    };
    let bumpers = vec![true, false, true];
    let expected = [
        Event::Base(base),
        Event::Laser(scan),
        Event::Bumpers(bumpers),
        Event::Battery(power),
        Event::Head(head),
    ];
    assert_eq!(wire.events, expected);
}

#[test]
fn deprecated_interfaces_are_used_where_there_is_no_ranger() {
    let mut wire = connected(
        &[server::BASE, server::OLD_LASER, server::OLD_SONARS],
        Options::default(),
    );
    assert_eq!(wire.robot().laser.map(|laser| laser.mount.x), Some(0.15));
    assert_eq!(
        wire.robot().sonars.as_ref().map(|ring| ring.mounts.len()),
        Some(2)
    );
    wire.data();
    let scan = Scan {
        angle_min: -0.5,
        angle_max: 0.5,
        range_min: 0.0,
        range_max: 6.0,
        ranges: vec![1.0, 2.0, 3.0, 4.0, 6.0],
    };
    assert_eq!(
        wire.events[2..],
        [Event::Laser(scan), Event::Sonars(vec![0.5, 5.0])]
    );
}

#[test]
fn named_devices_are_used_and_others_are_not() {
    let options = Options {
        laser: named(Interface::LASER, 0),
        sonars: Choice::None,
        bumpers: Choice::None,
        battery: Choice::None,
        head: Choice::None,
        ..Options::default()
    };
    assert_eq!(
        connected(&ALL, options).server.subscribed,
        [server::BASE, server::OLD_LASER]
    );
    let options = Options {
        laser: Choice::None,
        sonars: named(Interface::RANGER, 1),
        ..options
    };
    let wire = connected(&ALL, options);
    assert_eq!(wire.server.subscribed, [server::BASE, server::LASER]);
    assert_eq!(
        wire.robot().sonars.as_ref().map(|ring| ring.mounts.len()),
        Some(1)
    );
}

#[test]
fn a_missing_device_is_named_with_those_that_are_there() {
    let devices = [server::BASE, (31, 0), server::LASER];
    let lost = |options: Options| connected(&devices, options).lost().to_owned();
    let options = Options {
        base: 3,
        ..Options::default()
    };
    assert_eq!(
        lost(options),
        "it has no position2d:3; it has position2d:0, interface-31:0, ranger:1"
    );
    let options = Options {
        head: named(Interface::HEAD, 2),
        ..Options::default()
    };
    assert!(lost(options).starts_with("it has no ptz:2"));
}

#[test]
fn refused_devices_are_left_out_but_the_base() {
    let refusing = |refused: &[(Address, u32)]| {
        let mut server = Server::new(&ALL);
        server.refused = refused.to_vec();
        Wire::new(server, Options::default())
    };
    let wire = refusing(&[(server::POWER, 0), (server::BASE, 2)]);
    assert_eq!(
        (wire.robot().battery, wire.warnings()),
        (None, vec!["the server refused power:0"])
    );
    let wire = refusing(&[(server::LASER, 5)]);
    assert_eq!(
        wire.warnings(),
        ["ranger:1 does not report its angles, so it cannot be the laser"]
    );
    assert_eq!(
        wire.robot().laser.map(|laser| laser.device),
        Some(Interface::LASER.at(0))
    );
    assert!(!wire.server.subscribed.contains(&server::LASER));
    let wire = refusing(&[(server::BASE, 0)]);
    assert_eq!(wire.lost(), "it refused position2d:0; its own messages say why");
}

#[test]
fn a_velocity_is_sent_when_it_changes_and_five_times_a_second() {
    let mut wire = connected(&[server::BASE], Options::default());
    let fast = Setpoint {
        velocity: [0.5, 0.1, f64::NAN],
        ..Setpoint::default()
    };
    for millis in [0, 50, 199, 200, 250] {
        wire.now = Duration::from_millis(millis);
        wire.drive(fast);
    }
    assert_eq!(wire.server.velocities, [[0.5, 0.1, 0.0]; 2]);
    wire.drive(Setpoint::default());
    assert_eq!(wire.server.velocities[2..], [[0.0; 3]]);
    let stop = wire.session.stop();
    wire.server.receive(&stop);
    assert_eq!(wire.server.velocities[3..], [[0.0; 3]]);
    let mut unconnected = Session::new(Options::default(), Duration::ZERO);
    unconnected.drive(&fast, Duration::ZERO);
    assert!(unconnected.output().is_empty() && unconnected.stop().is_empty());
}

#[test]
fn an_axis_of_the_head_without_a_speed_stays_where_it_is() {
    let mut wire = connected(&ALL, Options::default());
    wire.data();
    let mut turn = |angles: [f32; 2], speeds: [f32; 2]| {
        let head = HeadSetpoint { angles, speeds };
        wire.drive(Setpoint {
            head,
            ..Setpoint::default()
        });
        std::mem::take(&mut wire.server.heads)
    };
    assert_eq!(turn([0.0; 2], [0.0; 2]), [[0.0; 5]; 0], "it holds already");
    assert_eq!(turn([0.5, 0.9], [1.0, 0.0]), [[0.5, 0.2, 0.8, 1.0, 0.0]]);
    assert_eq!(turn([0.5, 0.9], [1.0, 0.0]), [[0.0; 5]; 0], "nothing has changed");
    assert_eq!(
        turn([0.0; 2], [0.0; 2]),
        [[0.1, 0.2, 0.8, 0.0, 0.0]],
        "it stops where it was measured"
    );
}

#[test]
fn silence_ends_a_session() {
    let after = |mut wire: Wire, seconds: f64| {
        wire.now += Duration::from_secs_f64(seconds);
        wire.receive(&[]);
        wire
    };
    let wire = connected(&[server::BASE], Options::default());
    let mut wire = after(wire, 2.9);
    wire.data();
    assert!(
        after(wire, 3.0)
            .lost()
            .starts_with("no data of position2d:0 for 3 s")
    );
    let deaf = || Wire {
        session: Session::new(Options::default(), Duration::ZERO),
        server: Server::new(&ALL),
        now: Duration::ZERO,
        events: Vec::new(),
    };
    assert!(after(deaf(), 3.0).lost().contains("no greeting"));
    let mut wire = deaf();
    let greeting = wire.server.connected();
    wire.receive(&greeting);
    assert_eq!(after(wire, 20.0).lost(), "no reply of player:0 for 20 s");
}

#[test]
fn useless_bytes_end_a_session_with_the_reason() {
    let after = |bytes: &[u8]| {
        let mut wire = connected(&ALL, Options::default());
        wire.receive(bytes);
        wire.lost().to_owned()
    };
    let data = |device: Address, body: &[u8]| after(&server::message(device, 1, 1, body));
    assert_eq!(
        data(server::BASE, &[0; 40]),
        "a message of position2d:0 ends within its velocity"
    );
    let counts = [[0, 0, 0, 2], [0, 0, 0, 3]].concat();
    assert_eq!(
        data(server::LASER, &counts),
        "a message of ranger:1 states 2 and then 3 ranges"
    );
    assert_eq!(
        data(server::LASER, &[0xFF; 8]),
        "a message of ranger:1 ends within its ranges"
    );
    assert_eq!(
        data(server::BUMPERS, &[0xFF; 8]),
        "a message of bumper:0 ends within its bumpers"
    );
    let nan = [f64::NAN; 7].map(f64::to_be_bytes);
    assert_eq!(
        data(server::BASE, nan.as_flattened()),
        "position2d:0 reports a pose that is not finite"
    );
    assert!(after(&[0xFF; 40]).starts_with("it sent interface"));
}

#[test]
fn an_overflow_of_the_server_is_reported_once() {
    let mut wire = connected(&ALL, Options::default());
    let overflow = server::message((1, 0), 5, 2, &[0, 0, 0, 9]);
    wire.receive(&overflow);
    wire.receive(&overflow);
    assert_eq!(
        wire.warnings(),
        ["the server dropped messages: it sends more than is read"]
    );
}
