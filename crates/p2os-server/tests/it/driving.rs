//! A client drives a robot: its commands take effect, and the robot's data are right.

use core::f64::consts::{FRAC_PI_2, PI};

use crate::common::{Client, ROOM, Served, near, pose};
use jde_p2os::{
    Assembler, Command, Config, Encoders, ForLaser, Form, HeadCommand, HeadFrame, HeadReply, LaserPacket,
    SerialAux, SimPose, SimState, Sip, Wheels,
};
use jde_p2os_server::{EventKind, Options};

/// Returns a room served at a multiple of real time, and a client that has opened the first robot.
fn driven() -> (Served, Client) {
    let served = Served::start(
        ROOM,
        Options {
            speed: 4.0,
            ..Options::default()
        },
    );
    let mut client = Client::tcp(served.addresses[0]);
    client.open();
    (served, client)
}

fn stands(sip: &Sip) -> bool {
    sip.left_velocity == 0 && sip.right_velocity == 0
}

#[test]
fn it_drives_ahead_as_far_and_as_fast_as_it_is_told() {
    let (_served, mut client) = driven();
    client.say(&Command::Velocity(200));
    let sip = client.sip_with(|sip| sip.left_velocity > 190);
    assert!(sip.moving && sip.left_velocity.abs_diff(sip.right_velocity) < 20);
    client.sip_with(|sip| pose(sip)[0] > 0.5);
    client.say(&Command::Velocity(0));
    let [x, y, th] = pose(&client.sip_with(stands));
    assert!(x < 1.0, "{x}");
    near(y, 0.0, 0.02);
    near((th + PI).rem_euclid(2.0 * PI), PI, 0.02);
}

#[test]
fn a_positive_turn_is_to_the_left() {
    let (_served, mut client) = driven();
    client.say(&Command::RotVelocity(30));
    client.sip_with(|sip| (0.5..1.0).contains(&pose(sip)[2]));
    client.say(&Command::Stop);
    let [x, y, _] = pose(&client.sip_with(stands));
    near(x, 0.0, 0.01);
    near(y, 0.0, 0.01);
}

#[test]
fn the_wheels_can_be_told_apart() {
    let (_served, mut client) = driven();
    client.say(&Command::Velocities2(Wheels { left: -4, right: 4 }));
    let sip = client.sip_with(|sip| sip.right_velocity > 70);
    assert!(sip.left_velocity < -70, "{sip:?}");
}

#[test]
fn ways_and_headings_end_where_they_were_to_end() {
    let (_served, mut client) = driven();
    client.say(&Command::Move(700));
    near(
        pose(&client.sip_with(|sip| pose(sip)[0] > 0.69 && stands(sip)))[0],
        0.7,
        0.02,
    );
    client.say(&Command::Heading(90));
    let turned = |sip: &Sip| (pose(sip)[2] - FRAC_PI_2).abs() < 0.02 && stands(sip);
    client.sip_with(turned);
    client.say(&Command::DeltaHeading(-90));
    client.sip_with(|sip| pose(sip)[2].sin().abs() < 0.02 && pose(sip)[2].cos() > 0.0 && stands(sip));
}

#[test]
fn motors_that_are_off_do_nothing_and_say_so() {
    let (_served, mut client) = driven();
    client.say(&Command::Enable(false));
    client.sip_with(|sip| !sip.motors());
    client.say(&Command::Velocity(300));
    for _ in 0..10 {
        let sip = client.sip();
        assert!(stands(&sip) && !sip.moving, "{sip:?}");
    }
}

#[test]
fn the_origin_is_where_the_client_says() {
    let (_served, mut client) = driven();
    client.say(&Command::Move(300));
    client.sip_with(|sip| pose(sip)[0] > 0.28 && stands(sip));
    client.say(&Command::SetOrigin(None));
    let [x, y, _] = pose(&client.sip_with(|sip| pose(sip)[0] < 0.1));
    near(x, 0.0, 0.02);
    near(y, 0.0, 0.02);
    client.say(&Command::SetOrigin(Some([1000, -500, 90])));
    let [x, y, th] = pose(&client.sip_with(|sip| pose(sip)[0] > 0.5));
    near(x, 1.0, 0.01);
    near(y, -0.5, 0.01);
    near(th, FRAC_PI_2, 0.01);
}

#[test]
fn sonars_are_silent_when_they_are_off() {
    let (_served, mut client) = driven();
    let sip = client.sip();
    assert_eq!(sip.sonars.len(), 16);
    // The wall on the right is 3 m from the middle and 2.86 m from the sonar.
    near(f64::from(sip.sonars[7].range), 2864.0, 60.0);
    client.say(&Command::Sonar(0));
    let sip = client.sip_with(|sip| sip.sonars.is_empty());
    assert_eq!(sip.flags & 0b1_1110, 0);
}

#[test]
fn it_tells_its_settings_and_that_it_is_simulated() {
    let (_served, mut client) = driven();
    client.say(&Command::Config(Form::One));
    let packet = client.packet_with(|packet| packet.id() == 0x20);
    let config = Config::from_packet(&packet).expect("settings");
    assert!(config.is_simulator());
    assert_eq!((&*config.class, &*config.subclass), ("Pioneer", "p3dx"));
    assert_eq!((config.watchdog, config.sip_cycle), (2000, 100));
}

#[test]
fn wheels_count_once_or_always() {
    let (_served, mut client) = driven();
    let encoders = |packet: &jde_p2os::Packet| Encoders::from_packet(packet).ok();
    client.say(&Command::Encoder(1));
    let before = encoders(&client.packet_with(|packet| packet.id() == 0x90)).expect("counts");
    client.say(&Command::Encoder(2));
    client.say(&Command::Move(200));
    loop {
        let now = encoders(&client.packet_with(|packet| packet.id() == 0x90)).expect("counts");
        // 128 ticks a millimetre.
        if now.left - before.left > 190 * 128 && now.right - before.right > 190 * 128 {
            break;
        }
    }
    client.say(&Command::Encoder(0));
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
        let packet = LaserPacket::from_packet(&packet).expect("a good one");
        if let Some(readings) = assembler.add(&packet) {
            return readings
                .iter()
                .map(|reading| f64::from(reading.range) / 1000.0)
                .collect();
        }
    }
}

#[test]
fn both_families_of_laser_commands_see_the_walls_where_they_are() {
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
        let (_served, mut client) = driven();
        for command in family {
            client.say(command);
        }
        let ranges = sweep(&mut client);
        assert_eq!(ranges.len(), 181);
        near(ranges[0], 3.0, 0.03);
        near(ranges[90], 7.982, 0.03);
        // The second robot is on the left.
        near(ranges[180], 2.75, 0.03);
    }
}

#[test]
fn a_simulators_robot_can_be_put_elsewhere_but_not_into_a_wall() {
    let (served, mut client) = driven();
    client.say(&Command::SimSetPose(SimPose {
        x: 5000,
        y: 4000,
        th: 180,
    }));
    client.say(&Command::SimStat(1));
    let packet = client.packet_with(|packet| packet.id() == 0x62);
    let state = SimState::from_packet(&packet).expect("the truth");
    assert_eq!((state.x, state.y, state.th.rem_euclid(360)), (5000, 4000, 180));
    client.say(&Command::SimSetPose(SimPose { x: 0, y: 4000, th: 0 }));
    served.until(
        "pioneer",
        |what| matches!(what, EventKind::Refused(why) if why.contains("room")),
    );
    client.say(&Command::SimReset);
    client.say(&Command::SimStat(1));
    let packet = client.packet_with(|packet| packet.id() == 0x62);
    let state = SimState::from_packet(&packet).expect("the truth");
    assert_eq!((state.x, state.y), (2000, 3000));
}

#[test]
fn the_camera_at_the_auxiliary_port_turns_and_answers() {
    let (_served, mut client) = driven();
    client.say(&Command::GetAux(0));
    let mut ask = |command: &HeadCommand, bytes: u16| {
        client.say(&Command::GetAux(bytes));
        client.say(&Command::Tty2(command.to_bytes()));
        let packet = client.packet_with(|packet| packet.id() == 0xB0);
        let bytes = SerialAux::from_packet(&packet).expect("bytes").bytes;
        match HeadFrame::from_bytes(&bytes).expect("a frame") {
            HeadFrame::Reply(answer) => answer,
            HeadFrame::Command(command) => panic!("{command:?}"),
        }
    };
    assert_eq!(ask(&HeadCommand::Power(true), 6).status, HeadReply::OK);
    let aside = HeadCommand::PanTilt { pan: -400, tilt: 80 };
    assert_eq!(ask(&aside, 6).status, HeadReply::OK);
    loop {
        let (pan, tilt) = ask(&HeadCommand::GetPanTilt, 14).pan_tilt().expect("a place");
        if (pan, tilt) == (-400, 80) {
            break;
        }
        assert!(
            (-400..=0).contains(&pan) && (0..=80).contains(&tilt),
            "{pan} {tilt}"
        );
    }
}
