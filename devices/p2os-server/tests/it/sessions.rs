//! Clients that connect, disconnect, fall silent, send garbage or flood: no robot keeps driving, and other
//! clients are not affected.

use crate::common::{Client, ROOM, RunningServer, pose};
use jde_p2os::{Command, Form, Packet, SyncStep, Wheels};
use jde_p2os_server::{EventKind, Options, Server, ServerError};
use jde_sim::World;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

fn start_server() -> RunningServer {
    RunningServer::start(
        ROOM,
        Options {
            speed: 4.0,
            ..Options::default()
        },
    )
}

#[test]
fn robots_have_ports_and_clients_of_their_own() {
    let server = start_server();
    let mut first = Client::tcp(server.addresses[0]);
    let mut second = Client::tcp(server.addresses[1]);
    assert_eq!(first.open().name, "pioneer");
    assert_eq!(second.open().name, "second");
    first.send_command(&Command::Velocity(200));
    first.sip_with(|sip| pose(sip)[0] > 0.2);
    assert!(!second.sip().moving);
}

#[test]
fn synchronisation_requires_its_order_and_can_restart() {
    let server = start_server();
    let mut client = Client::tcp(server.addresses[0]);
    // The robot ignores steps out of order, and packets that some clients send first.
    client.send(&SyncStep::Two.to_packet().to_bytes());
    client.send(&SyncStep::One.to_packet().to_bytes());
    client.send_command(&Command::Close(Form::One));
    client.send(&SyncStep::Zero.to_packet().to_bytes());
    assert_eq!(client.packet(), SyncStep::Zero.to_packet());
    client.send(&SyncStep::Two.to_packet().to_bytes());
    client.send(&SyncStep::Zero.to_packet().to_bytes());
    assert_eq!(client.packet(), SyncStep::Zero.to_packet());
    assert_eq!(client.open().class, "Pioneer");
}

#[test]
fn a_client_that_closes_its_session_may_open_another() {
    let server = start_server();
    let mut client = Client::tcp(server.addresses[0]);
    client.open();
    client.send_command(&Command::Velocity(300));
    client.sip_with(|sip| sip.left_velocity > 200);
    client.send_command(&Command::Close(Form::Bare));
    server.until("pioneer", |event| *event == EventKind::Closed);
    client.open();
    let sip = client.sip_with(|sip| sip.left_velocity == 0);
    assert!(sip.motors());
    client.send_command(&Command::Velocity(100));
    client.sip_with(|sip| sip.left_velocity > 80);
}

#[test]
fn each_session_counts_from_its_starting_pose() {
    let server = start_server();
    let mut client = Client::tcp(server.addresses[0]);
    for _ in 0..2 {
        client.open();
        let [x, y, _] = pose(&client.sip());
        assert!(x.abs() < 0.01 && y.abs() < 0.01, "{x} {y}");
        client.send_command(&Command::Move(300));
        client.sip_with(|sip| pose(sip)[0] > 0.28 && sip.left_velocity == 0);
        client.send_command(&Command::Close(Form::Bare));
    }
}

#[test]
fn a_client_that_disconnects_stops_the_robot_and_another_may_connect() {
    let server = start_server();
    for _ in 0..3 {
        let mut client = Client::tcp(server.addresses[0]);
        client.open();
        client.send_command(&Command::Velocity(200));
        client.sip_with(|sip| sip.left_velocity > 100);
    }
    while server.count(|event| matches!(event, EventKind::ClientLeft(_))) < 3 {
        std::thread::yield_now();
    }
    let mut client = Client::tcp(server.addresses[0]);
    client.open();
    let before = pose(&client.sip_with(|sip| sip.left_velocity == 0));
    for _ in 0..5 {
        assert_eq!(pose(&client.sip()), before);
        client.send_command(&Command::Pulse);
    }
    let stats = server.end();
    assert_eq!(stats[0].sessions, 4);
}

#[test]
fn a_silent_client_still_receives_packets_but_its_robot_stops() {
    let server = start_server();
    let mut client = Client::tcp(server.addresses[0]);
    client.open();
    client.send_command(&Command::Velocity(200));
    while client.sip().left_velocity < 100 {}
    // The client sends nothing from now on; the robot still sends its packets.
    while client.sip().left_velocity != 0 {}
    assert_eq!(server.count(|event| matches!(event, EventKind::Silent(_))), 1);
    let before = pose(&client.sip());
    client.send_command(&Command::Pulse);
    for _ in 0..5 {
        assert_eq!(pose(&client.sip()), before, "the robot waits for a new command");
        client.send_command(&Command::Pulse);
    }
}

#[test]
fn a_second_client_is_refused_while_the_first_is_active() {
    let server = start_server();
    let mut first = Client::tcp(server.addresses[0]);
    first.open();
    let mut second = Client::tcp(server.addresses[0]);
    assert_eq!(second.try_packet(), None, "the connection is closed");
    server.until("pioneer", |event| matches!(event, EventKind::ClientRefused(_)));
    assert!(first.sip().motors());
}

#[test]
fn a_silent_client_is_replaced_by_a_new_one() {
    let server = start_server();
    let mut first = Client::tcp(server.addresses[0]);
    first.open();
    server.until("pioneer", |event| matches!(event, EventKind::Silent(_)));
    let mut second = Client::tcp(server.addresses[0]);
    assert_eq!(second.open().name, "pioneer");
    while first.try_packet().is_some() {}
}

#[test]
fn successive_clients_on_a_serial_line_can_drive() {
    let server = start_on_terminals(4.0);
    for number in 0..2 {
        let mut client = Client::serial(&server.terminals[0]);
        // The robot ignores remaining bytes of an earlier client.
        client.send_command(&Command::Close(Form::Bare));
        client.open();
        client.send_command(&Command::Velocity(200));
        client.sip_with(|sip| sip.left_velocity > 150);
        if number == 0 {
            client.send_command(&Command::Close(Form::Bare));
        }
    }
    // The second client did not close its session.
    server.until("pioneer", |event| matches!(event, EventKind::ClientLeft(_)));
}

fn start_on_terminals(speed: f64) -> RunningServer {
    RunningServer::start(
        ROOM,
        Options {
            terminal: true,
            speed,
            ..Options::default()
        },
    )
}

/// Returns a client on a terminal whose robot drives.
fn driving_client(server: &RunningServer) -> Client {
    let mut client = Client::serial(&server.terminals[0]);
    client.open();
    client.send_command(&Command::Velocity(200));
    client.sip_with(|sip| sip.left_velocity > 150);
    client
}

#[test]
fn a_client_that_closes_its_terminal_is_noticed_before_it_counts_as_silent() {
    let server = start_on_terminals(1.0);
    drop(driving_client(&server));
    let left =
        |event: &EventKind| matches!(event, EventKind::ClientLeft(reason) if reason.contains("closed"));
    server.until("pioneer", left);
    assert_eq!(server.count(|event| matches!(event, EventKind::Silent(_))), 0);
}

#[test]
fn a_client_that_reconnects_at_once_finds_a_robot_that_waits_for_its_handshake() {
    let server = start_on_terminals(1.0);
    for round in 0..5 {
        drop(driving_client(&server));
        // Otherwise its first packet would count as one of the earlier client.
        let mut next = Client::serial(&server.terminals[0]);
        assert_eq!(next.handshake().name, "pioneer");
        next.send_command(&Command::Open(Form::One));
        let sip = next.sip();
        assert!(!sip.motors(), "{round}: {sip:?}");
    }
    assert_eq!(server.count(|event| matches!(event, EventKind::Silent(_))), 0);
}

#[test]
fn opening_the_terminal_of_a_client_does_not_end_its_session() {
    let server = start_on_terminals(1.0);
    let mut client = driving_client(&server);
    for _ in 0..3 {
        drop(std::fs::File::open(&server.terminals[0]).expect("a terminal"));
        client.send_command(&Command::Pulse);
        client.sip_with(|sip| sip.left_velocity > 150);
    }
    assert_eq!(server.count(|event| matches!(event, EventKind::ClientLeft(_))), 0);
}

#[test]
fn a_complete_handshake_in_an_open_session_starts_another_session() {
    let server = start_on_terminals(1.0);
    let mut client = driving_client(&server);
    // If another program has the terminal open too, the server cannot notice that a client has left.
    for sync in [SyncStep::Zero, SyncStep::One, SyncStep::Two] {
        client.send(&sync.to_packet().to_bytes());
    }
    let names = client.packet_with(|packet| packet.id() == 2);
    assert!(jde_p2os::Names::from_packet(&names).is_ok());
    client.send_command(&Command::Open(Form::One));
    assert!(!client.sip().motors(), "the motors are off in the new session");
    assert_eq!(server.end()[0].sessions, 2);
}

#[test]
fn pulse_open_and_close_after_the_handshake_are_commands_and_not_synchronisation() {
    let server = start_server();
    let mut client = Client::tcp(server.addresses[0]);
    client.handshake();
    for command in [
        Command::Pulse,
        Command::Open(Form::Bare),
        Command::Close(Form::Bare),
    ] {
        client.send_command(&command);
    }
    server.until("pioneer", |event| {
        *event == EventKind::Closed || matches!(event, EventKind::ClientLeft(_))
    });
    assert_eq!(server.count(|event| *event == EventKind::Closed), 1);
    assert_eq!(server.end()[0].sessions, 1);
}

/// Serves a world whose robots are reachable both over TCP and on a terminal.
fn start_on_tcp_and_terminals(speed: f64) -> RunningServer {
    RunningServer::start(
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
fn commands_of_a_refused_client_are_never_executed() {
    let server = start_on_tcp_and_terminals(1.0);
    let mut first = Client::tcp(server.addresses[0]);
    first.open();
    let mut second = Client::serial(&server.terminals[0]);
    for sync in [SyncStep::Zero, SyncStep::One, SyncStep::Two] {
        second.send(&sync.to_packet().to_bytes());
    }
    second.send_command(&Command::Open(Form::One));
    second.send_command(&Command::Enable(true));
    second.send_command(&Command::Velocity(200));
    server.until("pioneer", |event| matches!(event, EventKind::ClientRefused(_)));
    first.send_command(&Command::Pulse);
    first.sip();
    drop(first);
    server.until("pioneer", |event| matches!(event, EventKind::ClientLeft(_)));
    let mut third = Client::tcp(server.addresses[0]);
    third.open();
    for _ in 0..5 {
        third.send_command(&Command::Pulse);
        assert!(!third.sip().moving);
    }
    assert_eq!(server.end()[0].sessions, 2);
}

#[test]
fn a_silent_client_is_replaced_by_a_new_one_on_a_serial_line() {
    let server = start_on_tcp_and_terminals(4.0);
    let mut first = Client::tcp(server.addresses[0]);
    first.open();
    server.until("pioneer", |event| matches!(event, EventKind::Silent(_)));
    let mut second = Client::serial(&server.terminals[0]);
    assert_eq!(second.open().name, "pioneer");
    while first.try_packet().is_some() {}
}

#[test]
fn only_some_of_many_messages_of_a_client_are_reported() {
    let server = start_server();
    let mut client = Client::tcp(server.addresses[0]);
    client.open();
    for _ in 0..500 {
        client.send_command(&Command::Message(b"a message".to_vec()));
    }
    server.until("pioneer", |event| matches!(event, EventKind::EventsDropped(_)));
    let reported = server.count(|event| matches!(event, EventKind::Message(_)));
    assert!((1..500).contains(&reported), "{reported}");
}

#[test]
fn a_client_that_reads_nothing_is_disconnected() {
    let server = start_server();
    let mut client = Client::tcp(server.addresses[0]);
    client.handshake();
    client.send_command(&Command::Open(Form::One));
    // The reply to each is a packet of a hundred bytes, which the client does not read.
    let query = Command::Config(Form::One)
        .to_packet()
        .expect("the command fits into a packet")
        .to_bytes();
    let flood = query.repeat(100);
    let mut stream = client.into_stream();
    while stream.write_all(&flood).is_ok() {}
    server.until("pioneer", |event| matches!(event, EventKind::ClientLeft(_)));
    let mut next = Client::tcp(server.addresses[0]);
    next.open();
}

#[test]
fn ten_thousand_random_and_mutated_packets_neither_crash_the_server_nor_move_a_robot() {
    let server = start_server();
    let mut good = Client::tcp(server.addresses[1]);
    good.open();
    let mut fuzzer = Client::tcp(server.addresses[0]);
    fuzzer.open();
    let valid = [
        Command::Pulse,
        Command::Config(Form::One),
        Command::Tty2(HEAD.to_vec()),
        Command::LaserOn35(1),
        Command::SimStat(2),
        Command::Velocities2(Wheels::default()),
        Command::Velocity(0),
    ]
    .map(|command| {
        command
            .to_packet()
            .expect("the command fits into a packet")
            .to_bytes()
    });
    let random = proptest::collection::vec(any::<u8>(), 1..60);
    let mutated = (0..valid.len(), any::<prop::sample::Index>(), 1..=255u8);
    let mut runner = TestRunner::deterministic();
    let mut sent = 0;
    while sent < 10_000 {
        let bytes = match sent % 2 {
            0 => random.new_tree(&mut runner).expect("bytes").current(),
            _ => {
                let (index, position, flip) = mutated.new_tree(&mut runner).expect("a change").current();
                let mut bytes = valid[index].clone();
                let position = position.index(bytes.len());
                bytes[position] ^= flip;
                bytes
            }
        };
        if may_move(&bytes) {
            continue;
        }
        sent += 1;
        if sent % 50 == 0 {
            // Read what has arrived, so that the server does not disconnect the client. The bytes may have
            // started a packet that includes the query, so repeat the query.
            fuzzer.send(&bytes);
            fuzzer.send_command(&Command::SimStat(1));
            loop {
                match fuzzer.packet().id() {
                    0x62 => break,
                    0x32 | 0x33 => fuzzer.send_command(&Command::SimStat(1)),
                    _ => {}
                }
            }
            good.send_command(&Command::Pulse);
            assert!(!good.sip().moving);
        } else {
            fuzzer.send(&bytes);
        }
    }
    assert_eq!(server.count(|event| matches!(event, EventKind::ClientLeft(_))), 0);
    let stats = server.end();
    assert!(stats.iter().all(|stats| stats.travelled < 1e-9), "{stats:?}");
}

const HEAD: [u8; 6] = [0xFF, 0x30, 0x30, 0x00, 0x53, 0xEF];

/// Returns whether these bytes may move the robot, change its pose, or end the session.
fn may_move(bytes: &[u8]) -> bool {
    let mut moves = false;
    jde_p2os::Receiver::new().receive(bytes, core::time::Duration::ZERO, |packet: Packet| {
        let command = Command::from_packet(&packet);
        moves |= command.moves() || matches!(packet.id(), 2 | 66..=69 | 224 | 225);
    });
    moves
}

#[test]
fn worlds_and_addresses_that_cannot_be_served_are_refused_with_a_reason() {
    let world = || World::parse(ROOM, "room.toml", 1).expect("a world");
    let open = |world, options: &Options| match Server::open(world, options) {
        Ok(_) => panic!("the world is served"),
        Err(error) => error.to_string(),
    };
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let error = open(
        world(),
        &Options {
            tcp: Some(address),
            ..Options::default()
        },
    );
    assert!(error.contains("pioneer") && error.contains("in use"), "{error}");
    assert!(open(world(), &Options::default()).contains("no client could connect"));
    let empty = World::parse(ROOM.split("[robots").next().expect("walls"), "empty.toml", 1).expect("a world");
    let error = open(
        empty,
        &Options {
            terminal: true,
            ..Options::default()
        },
    );
    assert!(error.contains("no robot"), "{error}");
    let long = ROOM.replace("second", &"a".repeat(150));
    let error = open(
        World::parse(&long, "long.toml", 1).expect("a world"),
        &Options {
            terminal: true,
            ..Options::default()
        },
    );
    assert!(error.contains("shorter name"), "{error}");
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
        Ok(_) => panic!("the world is served"),
    }
}
