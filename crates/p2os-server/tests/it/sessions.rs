//! Clients that arrive, leave, fall silent, send garbage or flood: no robot keeps driving, and other clients
//! are not affected.

use crate::common::{Client, ROOM, Served, pose};
use jde_p2os::{Command, Form, Packet, SyncStep, Wheels};
use jde_p2os_server::{EventKind, Options, Server, ServerError};
use jde_sim::World;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

fn served() -> Served {
    Served::start(
        ROOM,
        Options {
            speed: 4.0,
            ..Options::default()
        },
    )
}

#[test]
fn robots_have_ports_and_clients_of_their_own() {
    let served = served();
    let mut first = Client::tcp(served.addresses[0]);
    let mut second = Client::tcp(served.addresses[1]);
    assert_eq!(first.open().name, "pioneer");
    assert_eq!(second.open().name, "second");
    first.say(&Command::Velocity(200));
    first.sip_with(|sip| pose(sip)[0] > 0.2);
    assert!(!second.sip().moving);
}

#[test]
fn synchronisation_is_in_order_and_can_begin_anew() {
    let served = served();
    let mut client = Client::tcp(served.addresses[0]);
    // Out of order, and packets that some clients send first: none is answered.
    client.send(&SyncStep::Two.to_packet().to_bytes());
    client.send(&SyncStep::One.to_packet().to_bytes());
    client.say(&Command::Close(Form::One));
    client.send(&SyncStep::Zero.to_packet().to_bytes());
    assert_eq!(client.packet(), SyncStep::Zero.to_packet());
    client.send(&SyncStep::Two.to_packet().to_bytes());
    client.send(&SyncStep::Zero.to_packet().to_bytes());
    assert_eq!(client.packet(), SyncStep::Zero.to_packet());
    assert_eq!(client.open().class, "Pioneer");
}

#[test]
fn a_client_that_closes_keeps_the_line_and_may_open_again() {
    let served = served();
    let mut client = Client::tcp(served.addresses[0]);
    client.open();
    client.say(&Command::Velocity(300));
    client.sip_with(|sip| sip.left_velocity > 200);
    client.say(&Command::Close(Form::Bare));
    served.until("pioneer", |what| *what == EventKind::Closed);
    client.open();
    let stopped = client.sip_with(|sip| sip.left_velocity == 0);
    assert!(stopped.motors());
    client.say(&Command::Velocity(100));
    client.sip_with(|sip| sip.left_velocity > 80);
}

#[test]
fn each_session_counts_from_where_it_was_opened() {
    let served = served();
    let mut client = Client::tcp(served.addresses[0]);
    for _ in 0..2 {
        client.open();
        let [x, y, _] = pose(&client.sip());
        assert!(x.abs() < 0.01 && y.abs() < 0.01, "{x} {y}");
        client.say(&Command::Move(300));
        client.sip_with(|sip| pose(sip)[0] > 0.28 && sip.left_velocity == 0);
        client.say(&Command::Close(Form::Bare));
    }
}

#[test]
fn a_client_that_leaves_stops_the_robot_and_another_may_come() {
    let served = served();
    for _ in 0..3 {
        let mut client = Client::tcp(served.addresses[0]);
        client.open();
        client.say(&Command::Velocity(200));
        client.sip_with(|sip| sip.left_velocity > 100);
    }
    while served.count(|what| matches!(what, EventKind::ClientLeft(_))) < 3 {
        std::thread::yield_now();
    }
    let mut client = Client::tcp(served.addresses[0]);
    client.open();
    let before = pose(&client.sip_with(|sip| sip.left_velocity == 0));
    for _ in 0..5 {
        assert_eq!(pose(&client.sip()), before);
        client.say(&Command::Pulse);
    }
    let tally = served.end();
    assert_eq!(tally[0].sessions, 4);
}

#[test]
fn a_silent_client_is_told_on_but_its_robot_stops() {
    let served = served();
    let mut client = Client::tcp(served.addresses[0]);
    client.open();
    client.say(&Command::Velocity(200));
    while client.sip().left_velocity < 100 {}
    // The client sends nothing from here on; the robot still sends its packets.
    while client.sip().left_velocity != 0 {}
    assert_eq!(served.count(|what| matches!(what, EventKind::Silent(_))), 1);
    let before = pose(&client.sip());
    client.say(&Command::Pulse);
    for _ in 0..5 {
        assert_eq!(pose(&client.sip()), before, "it waits to be asked again");
        client.say(&Command::Pulse);
    }
}

#[test]
fn a_second_client_is_turned_away_while_the_first_speaks() {
    let served = served();
    let mut first = Client::tcp(served.addresses[0]);
    first.open();
    let mut second = Client::tcp(served.addresses[0]);
    assert_eq!(second.try_packet(), None, "it is hung up on");
    served.until("pioneer", |what| matches!(what, EventKind::ClientRefused(_)));
    assert!(first.sip().motors());
}

#[test]
fn a_client_that_has_fallen_silent_makes_room() {
    let served = served();
    let mut first = Client::tcp(served.addresses[0]);
    first.open();
    served.until("pioneer", |what| matches!(what, EventKind::Silent(_)));
    let mut second = Client::tcp(served.addresses[0]);
    assert_eq!(second.open().name, "pioneer");
    while first.try_packet().is_some() {}
}

#[test]
fn a_client_on_a_serial_line_drives_and_may_be_another_each_time() {
    let served = on_terminals(4.0);
    for turn in 0..2 {
        let mut client = Client::serial(&served.terminals[0]);
        // The robot ignores bytes that an earlier client left on the line.
        client.say(&Command::Close(Form::Bare));
        client.open();
        client.say(&Command::Velocity(200));
        client.sip_with(|sip| sip.left_velocity > 150);
        if turn == 0 {
            client.say(&Command::Close(Form::Bare));
        }
    }
    // The second client did not close its session.
    served.until("pioneer", |what| matches!(what, EventKind::ClientLeft(_)));
}

fn on_terminals(speed: f64) -> Served {
    Served::start(
        ROOM,
        Options {
            terminal: true,
            speed,
            ..Options::default()
        },
    )
}

/// Returns a client on a terminal, with a driving robot.
fn driving(served: &Served) -> Client {
    let mut client = Client::serial(&served.terminals[0]);
    client.open();
    client.say(&Command::Velocity(200));
    client.sip_with(|sip| sip.left_velocity > 150);
    client
}

#[test]
fn a_client_that_is_gone_from_a_terminal_is_noticed_before_it_has_been_silent() {
    let served = on_terminals(1.0);
    drop(driving(&served));
    let gone = |what: &EventKind| matches!(what, EventKind::ClientLeft(why) if why.contains("closed"));
    served.until("pioneer", gone);
    assert_eq!(served.count(|what| matches!(what, EventKind::Silent(_))), 0);
}

#[test]
fn a_client_that_is_back_at_once_finds_a_robot_that_waits_for_its_hello() {
    let served = on_terminals(1.0);
    for round in 0..5 {
        drop(driving(&served));
        // Its first packet would count as a sign of life of the earlier client.
        let mut next = Client::serial(&served.terminals[0]);
        assert_eq!(next.shake_hands().name, "pioneer");
        next.say(&Command::Open(Form::One));
        let stopping = next.sip();
        assert!(!stopping.motors(), "{round}: {stopping:?}");
    }
    assert_eq!(served.count(|what| matches!(what, EventKind::Silent(_))), 0);
}

#[test]
fn a_look_at_the_terminal_of_a_client_disturbs_nobody() {
    let served = on_terminals(1.0);
    let mut client = driving(&served);
    for _ in 0..3 {
        drop(std::fs::File::open(&served.terminals[0]).expect("a terminal"));
        client.say(&Command::Pulse);
        client.sip_with(|sip| sip.left_velocity > 150);
    }
    assert_eq!(served.count(|what| matches!(what, EventKind::ClientLeft(_))), 0);
}

#[test]
fn a_whole_hello_in_an_open_session_is_that_of_another() {
    let served = on_terminals(1.0);
    let mut client = driving(&served);
    // Another program has the terminal open too, so the server cannot notice that this client has left.
    for sync in [SyncStep::Zero, SyncStep::One, SyncStep::Two] {
        client.send(&sync.to_packet().to_bytes());
    }
    let names = client.packet_with(|packet| packet.id() == 2);
    assert!(jde_p2os::Names::from_packet(&names).is_ok());
    client.say(&Command::Open(Form::One));
    assert!(!client.sip().motors(), "the other's motors are off");
    assert_eq!(served.end()[0].sessions, 2);
}

#[test]
fn pulse_open_and_close_right_after_the_hello_are_what_they_say() {
    let served = served();
    let mut client = Client::tcp(served.addresses[0]);
    client.shake_hands();
    for command in [
        Command::Pulse,
        Command::Open(Form::Bare),
        Command::Close(Form::Bare),
    ] {
        client.say(&command);
    }
    served.until("pioneer", |what| {
        *what == EventKind::Closed || matches!(what, EventKind::ClientLeft(_))
    });
    assert_eq!(served.count(|what| *what == EventKind::Closed), 1);
    assert_eq!(served.end()[0].sessions, 1);
}

/// Serves a world whose robots have TCP and a terminal each.
fn served_twice(speed: f64) -> Served {
    Served::start(
        ROOM,
        Options {
            tcp: Some("127.0.0.1:0".parse().expect("an address")),
            terminal: true,
            speed,
            ..Options::default()
        },
    )
}

#[test]
fn what_a_client_said_that_was_turned_away_is_not_obeyed_later() {
    let served = served_twice(1.0);
    let mut first = Client::tcp(served.addresses[0]);
    first.open();
    let mut second = Client::serial(&served.terminals[0]);
    for sync in [SyncStep::Zero, SyncStep::One, SyncStep::Two] {
        second.send(&sync.to_packet().to_bytes());
    }
    second.say(&Command::Open(Form::One));
    second.say(&Command::Enable(true));
    second.say(&Command::Velocity(200));
    served.until("pioneer", |what| matches!(what, EventKind::ClientRefused(_)));
    first.say(&Command::Pulse);
    first.sip();
    drop(first);
    served.until("pioneer", |what| matches!(what, EventKind::ClientLeft(_)));
    let mut third = Client::tcp(served.addresses[0]);
    third.open();
    for _ in 0..5 {
        third.say(&Command::Pulse);
        assert!(!third.sip().moving);
    }
    assert_eq!(served.end()[0].sessions, 2);
}

#[test]
fn a_silent_client_makes_room_on_a_serial_line_too() {
    let served = served_twice(4.0);
    let mut first = Client::tcp(served.addresses[0]);
    first.open();
    served.until("pioneer", |what| matches!(what, EventKind::Silent(_)));
    let mut second = Client::serial(&served.terminals[0]);
    assert_eq!(second.open().name, "pioneer");
    while first.try_packet().is_some() {}
}

#[test]
fn a_client_that_says_much_is_told_of_little() {
    let served = served();
    let mut client = Client::tcp(served.addresses[0]);
    client.open();
    for _ in 0..500 {
        client.say(&Command::Message(b"look at me".to_vec()));
    }
    served.until("pioneer", |what| matches!(what, EventKind::EventsDropped(_)));
    let told = served.count(|what| matches!(what, EventKind::Message(_)));
    assert!((1..500).contains(&told), "{told}");
}

#[test]
fn a_client_that_reads_nothing_is_let_go() {
    let served = served();
    let mut deaf = Client::tcp(served.addresses[0]);
    deaf.shake_hands();
    deaf.say(&Command::Open(Form::One));
    // Each is answered by a packet of a hundred bytes, which the client does not read.
    let question = Command::Config(Form::One)
        .to_packet()
        .expect("it fits")
        .to_bytes();
    let flood = question.repeat(100);
    let mut stream = deaf.into_wire();
    while stream.write_all(&flood).is_ok() {}
    served.until("pioneer", |what| matches!(what, EventKind::ClientLeft(_)));
    let mut next = Client::tcp(served.addresses[0]);
    next.open();
}

#[test]
fn ten_thousand_random_and_mutated_packets_crash_nothing_and_move_nothing() {
    let served = served();
    let mut good = Client::tcp(served.addresses[1]);
    good.open();
    let mut bad = Client::tcp(served.addresses[0]);
    bad.open();
    let known = [
        Command::Pulse,
        Command::Config(Form::One),
        Command::Tty2(HEAD.to_vec()),
        Command::LaserOn35(1),
        Command::SimStat(2),
        Command::Velocities2(Wheels::default()),
        Command::Velocity(0),
    ]
    .map(|command| command.to_packet().expect("it fits").to_bytes());
    let random = proptest::collection::vec(any::<u8>(), 1..60);
    let mutated = (0..known.len(), any::<prop::sample::Index>(), 1..=255u8);
    let mut runner = TestRunner::deterministic();
    let mut sent = 0;
    while sent < 10_000 {
        let bytes = match sent % 2 {
            0 => random.new_tree(&mut runner).expect("bytes").current(),
            _ => {
                let (which, place, flip) = mutated.new_tree(&mut runner).expect("a change").current();
                let mut bytes = known[which].clone();
                let place = place.index(bytes.len());
                bytes[place] ^= flip;
                bytes
            }
        };
        if asks_for_motion(&bytes) {
            continue;
        }
        sent += 1;
        if sent % 50 == 0 {
            // Reads what has arrived, so that the server does not drop the client. The bytes may have started
            // a packet that swallows the question, so the question is repeated.
            bad.send(&bytes);
            bad.say(&Command::SimStat(1));
            loop {
                match bad.packet().id() {
                    0x62 => break,
                    0x32 | 0x33 => bad.say(&Command::SimStat(1)),
                    _ => {}
                }
            }
            good.say(&Command::Pulse);
            assert!(!good.sip().moving);
        } else {
            bad.send(&bytes);
        }
    }
    assert_eq!(served.count(|what| matches!(what, EventKind::ClientLeft(_))), 0);
    let tally = served.end();
    assert!(tally.iter().all(|tally| tally.travelled < 1e-9), "{tally:?}");
}

const HEAD: [u8; 6] = [0xFF, 0x30, 0x30, 0x00, 0x53, 0xEF];

/// Returns whether these bytes may move the robot, change its pose, or end the session.
fn asks_for_motion(bytes: &[u8]) -> bool {
    let mut asks = false;
    jde_p2os::Receiver::new().receive(bytes, core::time::Duration::ZERO, |packet: Packet| {
        let command = Command::from_packet(&packet);
        asks |= command.moves() || matches!(packet.id(), 2 | 66..=69 | 224 | 225);
    });
    asks
}

#[test]
fn what_cannot_be_served_is_refused_in_words() {
    let world = || World::parse(ROOM, "room.toml", 1).expect("a world");
    let open = |world, options: &Options| match Server::open(world, options) {
        Ok(_) => panic!("it is served"),
        Err(error) => error.to_string(),
    };
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = taken.local_addr().expect("an address");
    let said = open(
        world(),
        &Options {
            tcp: Some(address),
            ..Options::default()
        },
    );
    assert!(said.contains("pioneer") && said.contains("in use"), "{said}");
    assert!(open(world(), &Options::default()).contains("no client could reach it"));
    let empty = World::parse(ROOM.split("[robots").next().expect("walls"), "empty.toml", 1).expect("a world");
    let said = open(
        empty,
        &Options {
            terminal: true,
            ..Options::default()
        },
    );
    assert!(said.contains("no robot"), "{said}");
    let long = ROOM.replace("second", &"a".repeat(150));
    let said = open(
        World::parse(&long, "long.toml", 1).expect("a world"),
        &Options {
            terminal: true,
            ..Options::default()
        },
    );
    assert!(said.contains("shorter name"), "{said}");
    let last = Some("127.0.0.1:65535".parse().expect("an address"));
    // The port may be in use. Otherwise the second robot has no port.
    match Server::open(
        world(),
        &Options {
            tcp: last,
            ..Options::default()
        },
    ) {
        Err(ServerError::NoPort(robot)) => assert_eq!(robot, "second"),
        Err(ServerError::Endpoint { .. }) => {}
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("it is served"),
    }
}
