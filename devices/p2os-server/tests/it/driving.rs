//! A client drives a robot: its commands take effect, and the robot's data are right.

use core::f64::consts::{FRAC_PI_2, PI};

use crate::common::{Client, ROOM, RunningServer, assert_near, pose};
use jde_p2os::{
    Assembler, Command, Config, Encoders, ForLaser, Form, HeadCommand, HeadFrame, HeadReply, LaserPacket,
    SerialAux, SimPose, SimState, Sip, Wheels,
};
use jde_p2os_server::{EventKind, Options};

/// Returns a room served at a multiple of real time, and a client that has opened the first robot.
fn served_room() -> (RunningServer, Client) {
    let server = RunningServer::start(
        ROOM,
        Options {
            speed: 4.0,
            ..Options::default()
        },
    );
    let mut client = Client::tcp(server.addresses[0]);
    client.open();
    (server, client)
}

fn is_at_rest(sip: &Sip) -> bool {
    sip.left_velocity == 0 && sip.right_velocity == 0
}

#[test]
fn the_robot_drives_ahead_at_the_commanded_speed_and_stops() {
    let (_server, mut client) = served_room();
    client.send_command(&Command::Velocity(200));
    let sip = client.sip_with(|sip| sip.left_velocity > 190);
    assert!(sip.moving && sip.left_velocity.abs_diff(sip.right_velocity) < 20);
    client.sip_with(|sip| pose(sip)[0] > 0.5);
    client.send_command(&Command::Velocity(0));
    let [x, y, th] = pose(&client.sip_with(is_at_rest));
    assert!(x < 1.0, "{x}");
    assert_near(y, 0.0, 0.02);
    assert_near((th + PI).rem_euclid(2.0 * PI), PI, 0.02);
}

#[test]
fn a_positive_turn_is_to_the_left() {
    let (_server, mut client) = served_room();
    client.send_command(&Command::RotVelocity(30));
    client.sip_with(|sip| (0.5..1.0).contains(&pose(sip)[2]));
    client.send_command(&Command::Stop);
    let [x, y, _] = pose(&client.sip_with(is_at_rest));
    assert_near(x, 0.0, 0.01);
    assert_near(y, 0.0, 0.01);
}

#[test]
fn each_wheel_has_its_own_speed() {
    let (_server, mut client) = served_room();
    client.send_command(&Command::Velocities2(Wheels { left: -4, right: 4 }));
    let sip = client.sip_with(|sip| sip.right_velocity > 70);
    assert!(sip.left_velocity < -70, "{sip:?}");
}

#[test]
fn the_robot_reaches_commanded_distances_and_headings() {
    let (_server, mut client) = served_room();
    client.send_command(&Command::Move(700));
    assert_near(
        pose(&client.sip_with(|sip| pose(sip)[0] > 0.69 && is_at_rest(sip)))[0],
        0.7,
        0.02,
    );
    client.send_command(&Command::Heading(90));
    let turned = |sip: &Sip| (pose(sip)[2] - FRAC_PI_2).abs() < 0.02 && is_at_rest(sip);
    client.sip_with(turned);
    client.send_command(&Command::DeltaHeading(-90));
    client.sip_with(|sip| pose(sip)[2].sin().abs() < 0.02 && pose(sip)[2].cos() > 0.0 && is_at_rest(sip));
}

#[test]
fn motors_that_are_off_do_not_move_and_are_reported_off() {
    let (_server, mut client) = served_room();
    client.send_command(&Command::Enable(false));
    client.sip_with(|sip| !sip.motors());
    client.send_command(&Command::Velocity(300));
    for _ in 0..10 {
        let sip = client.sip();
        assert!(is_at_rest(&sip) && !sip.moving, "{sip:?}");
    }
}

#[test]
fn a_client_can_set_the_origin() {
    let (_server, mut client) = served_room();
    client.send_command(&Command::Move(300));
    client.sip_with(|sip| pose(sip)[0] > 0.28 && is_at_rest(sip));
    client.send_command(&Command::SetOrigin(None));
    let [x, y, _] = pose(&client.sip_with(|sip| pose(sip)[0] < 0.1));
    assert_near(x, 0.0, 0.02);
    assert_near(y, 0.0, 0.02);
    client.send_command(&Command::SetOrigin(Some([1000, -500, 90])));
    let [x, y, th] = pose(&client.sip_with(|sip| pose(sip)[0] > 0.5));
    assert_near(x, 1.0, 0.01);
    assert_near(y, -0.5, 0.01);
    assert_near(th, FRAC_PI_2, 0.01);
}

#[test]
fn sonars_that_are_off_send_no_readings() {
    let (_server, mut client) = served_room();
    let sip = client.sip();
    assert_eq!(sip.sonars.len(), 16);
    // The wall on the right is 3 m from the middle and 2.86 m from the sonar.
    assert_near(f64::from(sip.sonars[7].range), 2864.0, 60.0);
    client.send_command(&Command::Sonar(0));
    let sip = client.sip_with(|sip| sip.sonars.is_empty());
    assert_eq!(sip.flags & 0b1_1110, 0);
}

#[test]
fn the_configuration_contains_the_settings_and_identifies_a_simulator() {
    let (_server, mut client) = served_room();
    client.send_command(&Command::Config(Form::One));
    let packet = client.packet_with(|packet| packet.id() == 0x20);
    let config = Config::from_packet(&packet).expect("a configuration");
    assert!(config.is_simulator());
    assert_eq!((&*config.class, &*config.subclass), ("Pioneer", "p3dx"));
    assert_eq!((config.watchdog, config.sip_cycle), (2000, 100));
}

#[test]
fn encoder_counts_are_sent_once_or_continuously() {
    let (_server, mut client) = served_room();
    let encoders = |packet: &jde_p2os::Packet| Encoders::from_packet(packet).ok();
    client.send_command(&Command::Encoder(1));
    let before = encoders(&client.packet_with(|packet| packet.id() == 0x90)).expect("encoder counts");
    client.send_command(&Command::Encoder(2));
    client.send_command(&Command::Move(200));
    loop {
        let now = encoders(&client.packet_with(|packet| packet.id() == 0x90)).expect("encoder counts");
        // There are 128 ticks per millimetre.
        if now.left - before.left > 190 * 128 && now.right - before.right > 190 * 128 {
            break;
        }
    }
    client.send_command(&Command::Encoder(0));
    client.sip();
    client.sip();
    for _ in 0..3 {
        assert_ne!(client.packet().id(), 0x90);
    }
}

/// Returns the next whole sweep, m.
fn sweep(client: &mut Client) -> Vec<f64> {
    let mut assembler = Assembler::default();
    loop {
        let packet = client.packet_with(LaserPacket::is_laser_packet);
        let packet = LaserPacket::from_packet(&packet).expect("a laser packet");
        if let Some(readings) = assembler.add(&packet) {
            return readings
                .iter()
                .map(|reading| f64::from(reading.range) / 1000.0)
                .collect();
        }
    }
}

#[test]
fn both_families_of_laser_commands_measure_the_walls() {
    let families: [&[Command]; 2] = [
        &[
            Command::LaserStart36(-90),
            Command::LaserEnd37(90),
            Command::LaserIncrement38(100),
            Command::LaserOn35(2),
        ],
        &[
            Command::LrfStart(ForLaser { value: -90, laser: 0 }),
            Command::LrfEnd(ForLaser { value: 90, laser: 0 }),
            Command::LrfResolution(ForLaser { value: 100, laser: 0 }),
            Command::LrfEnable(ForLaser { value: 1, laser: 0 }),
        ],
    ];
    for family in families {
        let (_server, mut client) = served_room();
        for command in family {
            client.send_command(command);
        }
        let ranges = sweep(&mut client);
        assert_eq!(ranges.len(), 181);
        assert_near(ranges[0], 3.0, 0.03);
        assert_near(ranges[90], 7.982, 0.03);
        // The second robot is on the left.
        assert_near(ranges[180], 2.75, 0.03);
    }
}

#[test]
fn a_simulated_robot_can_be_moved_but_not_into_a_wall() {
    let (server, mut client) = served_room();
    client.send_command(&Command::SimSetPose(SimPose {
        x: 5000,
        y: 4000,
        th: 180,
    }));
    client.send_command(&Command::SimStat(1));
    let packet = client.packet_with(|packet| packet.id() == 0x62);
    let state = SimState::from_packet(&packet).expect("the true state");
    assert_eq!((state.x, state.y, state.th.rem_euclid(360)), (5000, 4000, 180));
    client.send_command(&Command::SimSetPose(SimPose { x: 0, y: 4000, th: 0 }));
    server.until(
        "pioneer",
        |event| matches!(event, EventKind::Refused(reason) if reason.contains("room")),
    );
    client.send_command(&Command::SimReset);
    client.send_command(&Command::SimStat(1));
    let packet = client.packet_with(|packet| packet.id() == 0x62);
    let state = SimState::from_packet(&packet).expect("the true state");
    assert_eq!((state.x, state.y), (2000, 3000));
}

#[test]
fn the_camera_at_the_auxiliary_port_turns_and_replies() {
    let (_server, mut client) = served_room();
    client.send_command(&Command::GetAux(0));
    let mut query = |command: &HeadCommand, bytes: u16| {
        client.send_command(&Command::GetAux(bytes));
        client.send_command(&Command::Tty2(command.to_bytes()));
        let packet = client.packet_with(|packet| packet.id() == 0xB0);
        let bytes = SerialAux::from_packet(&packet).expect("bytes").bytes;
        match HeadFrame::from_bytes(&bytes).expect("a frame") {
            HeadFrame::Reply(reply) => reply,
            HeadFrame::Command(command) => panic!("{command:?}"),
        }
    };
    assert_eq!(query(&HeadCommand::Power(true), 6).status, HeadReply::OK);
    let aside = HeadCommand::PanTilt { pan: -400, tilt: 80 };
    assert_eq!(query(&aside, 6).status, HeadReply::OK);
    loop {
        let (pan, tilt) = query(&HeadCommand::GetPanTilt, 14).pan_tilt().expect("angles");
        if (pan, tilt) == (-400, 80) {
            break;
        }
        assert!(
            (-400..=0).contains(&pan) && (0..=80).contains(&tilt),
            "{pan} {tilt}"
        );
    }
}
