//! The client's session against a scripted robot: handshake, driving within limits, silence, closing; laser,
//! encoders and head.

use core::f64::consts::PI;
use core::time::Duration;

use crate::robot::{Robot, Talk, wish};
use jde_p2os::*;

fn p3dx() -> Robot {
    Robot::new("Emma", "p3dx")
}

fn simulator() -> Robot {
    Robot::new("AMRISim", "p3dx")
}

fn speeds(heard: &[Command]) -> Vec<i16> {
    let speed = |command: &Command| match command {
        Command::Velocity(speed) => Some(*speed),
        _ => None,
    };
    heard.iter().filter_map(speed).collect()
}

#[test]
fn it_says_hello_in_order_and_switches_on() {
    let mut talk = Talk::connected(p3dx(), Options::default());
    let heard = talk.heard();
    let expected = [
        Command::Pulse,
        Command::Open(Form::Bare),
        Command::Close(Form::Bare),
        Command::Open(Form::One),
        Command::Config(Form::One),
        Command::Sonar(1),
        Command::Enable(true),
        Command::Encoder(2),
    ];
    assert_eq!(heard[..8], expected);
    assert!(!heard.iter().any(Command::moves));
    let State::Connected(names) = talk.session.state() else {
        panic!("connected")
    };
    assert_eq!(names.name, "Emma");
    assert_eq!(
        talk.session.model().map(|model| model.name.as_str()),
        Some("p3dx")
    );
}

#[test]
fn what_is_not_answered_is_said_again_each_second_and_given_up_in_the_end() {
    let mut session = Session::new(Options::default());
    session.connected(Duration::ZERO);
    let zero = SyncStep::Zero.to_packet().to_bytes();
    assert_eq!(session.output(), zero);
    session.drive(&Setpoint::default(), Duration::from_millis(999));
    assert!(session.output().is_empty());
    session.drive(&Setpoint::default(), Duration::from_secs(1));
    assert_eq!(session.output(), zero);
    // The echo of another step is not an answer.
    session.receive(&SyncStep::One.to_packet().to_bytes(), Duration::from_secs(1));
    assert!(session.output().is_empty());
    for second in 2..=10 {
        session.drive(&wish(1.0, 1.0), Duration::from_secs(second));
    }
    assert!(matches!(session.state(), State::Lost(_)));
}

#[test]
fn a_robot_left_open_is_closed_first() {
    let mut talk = Talk::connected(p3dx().left_open(), Options::default());
    let heard = talk.heard();
    let closed = heard
        .iter()
        .position(|command| *command == Command::Close(Form::One))
        .unwrap();
    let rest = [
        Command::Pulse,
        Command::Open(Form::Bare),
        Command::Close(Form::Bare),
        Command::Open(Form::One),
    ];
    assert_eq!(heard[closed + 1..closed + 5], rest);
    assert_eq!(
        heard
            .iter()
            .filter(|command| **command == Command::Close(Form::One))
            .count(),
        1
    );
}

#[test]
fn it_goes_on_with_a_robot_that_never_tells_its_configuration() {
    let mut robot = p3dx();
    robot.config = None;
    let mut talk = Talk::connected(robot, Options::default());
    let asked = talk
        .heard()
        .iter()
        .filter(|command| **command == Command::Config(Form::One))
        .count();
    assert_eq!(asked, 3);
    assert_eq!(talk.session.config(), None);
}

#[test]
fn a_robot_of_an_unknown_kind_is_refused_unless_its_model_is_given() {
    let mut talk = Talk::new(Robot::new("Emma", "roomba"), Options::default());
    talk.run(&wish(1.0, 0.0), 2.0);
    let State::Refused(words) = talk.session.state() else {
        panic!("refused")
    };
    assert!(words.contains("`roomba`") && words.contains("`p3dx`"), "{words}");
    let model = Some(Model::named("p3at").unwrap());
    Talk::connected(
        Robot::new("Emma", "roomba"),
        Options {
            model,
            ..Options::default()
        },
    );
}

#[test]
fn speeds_are_said_when_they_change_and_every_200_ms() {
    let mut talk = Talk::connected(p3dx(), Options::default());
    talk.heard();
    talk.run(&wish(0.25, -0.5), 1.0);
    let heard = talk.heard();
    assert_eq!(speeds(&heard), [250; 5]);
    assert!(heard.contains(&Command::RotVelocity(-29)));
    talk.step(Some(&wish(-0.1, 0.0)));
    assert_eq!(talk.heard(), [Command::Velocity(-100), Command::RotVelocity(0)]);
}

#[test]
fn nothing_is_said_to_a_robot_whose_application_hangs() {
    let options = Options {
        laser: LaserMode::Auto(Beams::spread(180, PI)),
        head: HeadKind::VcC4,
        ..Options::default()
    };
    let mut talk = Talk::connected(simulator(), options);
    talk.run(&wish(0.3, 0.0), 1.0);
    talk.heard();
    talk.hang(10.0);
    assert_eq!(talk.heard(), []);
}

#[test]
fn speeds_stay_within_what_the_model_and_the_robot_allow() {
    let last = |robot| {
        let mut talk = Talk::connected(robot, Options::default());
        talk.heard();
        talk.run(&wish(50.0, -50.0), 0.1);
        talk.heard()
    };
    assert_eq!(
        last(p3dx()),
        [Command::Velocity(2200), Command::RotVelocity(-500)]
    );
    let mut slow = p3dx();
    slow.config = Some(Config {
        trans_vel_max: 400,
        rot_vel_max: 90,
        ..Config::default()
    });
    assert_eq!(last(slow), [Command::Velocity(400), Command::RotVelocity(-90)]);
}

#[test]
fn a_wish_that_is_no_number_is_no_wish() {
    let mut talk = Talk::connected(p3dx(), Options::default());
    let head = HeadSetpoint {
        pan: f64::NAN,
        tilt: f64::INFINITY,
        pan_speed: f64::NAN,
        tilt_speed: 1.0,
    };
    talk.run(
        &Setpoint {
            linear: f64::NAN,
            angular: f64::NAN,
            head,
        },
        1.0,
    );
    assert!(!talk.heard().iter().any(Command::moves));
}

#[test]
fn motors_that_went_off_are_switched_on_for_a_motion_and_not_for_ever() {
    let mut talk = Talk::connected(p3dx(), Options::default());
    talk.robot.motors_broken = true;
    talk.robot.sip.flags = 0;
    talk.heard();
    talk.run(&wish(0.0, 0.0), 3.0);
    assert!(!talk.heard().contains(&Command::Enable(true)));
    talk.run(&wish(0.2, 0.0), 20.0);
    let tries = talk
        .heard()
        .iter()
        .filter(|command| **command == Command::Enable(true))
        .count();
    assert_eq!(tries, 5);
    let warnings = talk.warnings();
    assert!(
        warnings.len() == 1 && warnings[0].contains("motors"),
        "{warnings:?}"
    );
    talk.robot.motors_broken = false;
    talk.run(&wish(0.0, 0.0), 0.2);
    talk.run(&wish(0.2, 0.0), 2.0);
    assert!(talk.robot.sip.motors());
}

#[test]
fn a_robot_that_is_silent_for_a_second_is_lost_and_found_again_where_it_was() {
    let mut talk = Talk::connected(p3dx(), Options::default());
    talk.robot.sip.x = 1000;
    talk.run(&wish(0.2, 0.0), 2.0);
    let pose = talk.session.pose();
    talk.robot.mute = true;
    talk.run(&wish(0.2, 0.0), 1.0);
    assert!(talk.session.state().is_connected());
    talk.run(&wish(0.2, 0.0), 0.2);
    assert!(matches!(talk.session.state(), State::Lost(_)));
    let mut again = p3dx();
    again.sip.x = 7;
    talk.robot = again;
    talk.session.connected(talk.now);
    assert_eq!(talk.events(), [], "what was heard before is no news");
    talk.run(&Setpoint::default(), 2.0);
    assert!(talk.session.state().is_connected());
    assert_eq!(talk.session.pose(), pose);
}

#[test]
fn goodbye_stops_everything() {
    let mut talk = Talk::connected(p3dx(), Options::default());
    talk.run(&wish(0.2, 0.1), 0.5);
    talk.heard();
    let farewell = talk.session.close();
    talk.robot.take(&farewell, talk.now);
    let expected = [
        Command::Velocity(0),
        Command::RotVelocity(0),
        Command::Enable(false),
        Command::Sonar(0),
        Command::Close(Form::One),
    ];
    assert_eq!(talk.heard(), expected);
    assert!(talk.session.close().is_empty());
    talk.run(&wish(0.2, 0.1), 1.0);
    assert_eq!(talk.heard(), []);
}

#[test]
fn a_laser_is_asked_for_in_the_old_words_and_then_in_the_new_ones() {
    let laser = LaserMode::Auto(Beams::spread(180, PI));
    let mut talk = Talk::connected(
        simulator(),
        Options {
            laser,
            ..Options::default()
        },
    );
    let heard = talk.heard();
    let old = [
        Command::LaserStart36(-90),
        Command::LaserEnd37(89),
        Command::LaserIncrement38(100),
        Command::LaserOn35(2),
    ];
    assert!(heard.windows(4).any(|commands| commands == old), "{heard:?}");
    talk.run(&Setpoint::default(), 2.0);
    let first = |value| ForLaser { value, laser: 0 };
    assert!(talk.heard().contains(&Command::LrfEnable(first(2))));
    talk.run(&Setpoint::default(), 3.0);
    assert!(talk.warnings()[0].contains("laser"));
}

#[test]
fn a_robot_is_not_asked_for_a_laser_unless_told_so() {
    let beams = Beams::spread(180, PI);
    let asked = |laser| {
        let mut talk = Talk::connected(
            p3dx(),
            Options {
                laser,
                ..Options::default()
            },
        );
        talk.heard().contains(&Command::LaserOn35(2))
    };
    assert!(!asked(LaserMode::Auto(beams)));
    assert!(!asked(LaserMode::Off));
    assert!(asked(LaserMode::On(beams)));
}

#[test]
fn sweeps_and_ticks_come_whole_and_without_wrapping() {
    let laser = LaserMode::Auto(Beams::spread(180, PI));
    let mut talk = Talk::connected(
        simulator(),
        Options {
            laser,
            ..Options::default()
        },
    );
    talk.events();
    let sweep: Vec<_> = (0..180)
        .map(|range| Reading {
            range,
            reflectance: 3,
        })
        .collect();
    let form = LaserForm::Extended { device: 0, flags: 0 };
    for part in LaserPacket::sweep(form, &sweep) {
        talk.session
            .receive(&part.to_packet().unwrap().to_bytes(), talk.now);
    }
    for (left, right) in [(i32::MAX - 1, i32::MIN), (i32::MIN, i32::MAX)] {
        let encoders = Encoders { left, right };
        talk.session.receive(&encoders.to_packet().to_bytes(), talk.now);
    }
    let ticks = |left, right| Event::Encoders { left, right };
    assert_eq!(talk.events(), [Event::Laser(sweep), ticks(0, 0), ticks(2, -1)]);
    // Packets arrive, so the session does not try other commands.
    talk.heard();
    talk.run(&Setpoint::default(), 5.0);
    assert!(
        !talk
            .heard()
            .iter()
            .any(|command| matches!(command, Command::LrfEnable(_)))
    );
}

#[test]
fn ticks_go_on_where_they_were_with_a_robot_that_counts_anew() {
    let mut talk = Talk::connected(p3dx(), Options::default());
    talk.events();
    let count = |talk: &mut Talk, left, right| {
        let encoders = Encoders { left, right };
        talk.session.receive(&encoders.to_packet().to_bytes(), talk.now);
    };
    count(&mut talk, 100_000, 90_000);
    count(&mut talk, 100_500, 90_600);
    talk.session.lost("its connection is gone");
    talk.robot = p3dx();
    talk.session.connected(talk.now);
    talk.run(&Setpoint::default(), 2.0);
    talk.events();
    count(&mut talk, 3, 4);
    count(&mut talk, 13, 24);
    let ticks = |left, right| Event::Encoders { left, right };
    assert_eq!(talk.events(), [ticks(500, 600), ticks(510, 620)]);
}

/// Returns the commands to the camera, without requests for its angles.
fn camera(heard: &[Command]) -> Vec<HeadCommand> {
    let command = |command: &Command| match command {
        Command::Tty2(bytes) => match HeadFrame::from_bytes(bytes) {
            Ok(HeadFrame::Command(command)) if command != HeadCommand::GetPanTilt => Some(command),
            _ => None,
        },
        _ => None,
    };
    heard.iter().filter_map(command).collect()
}

fn look(pan: f64, tilt: f64, speed: f64) -> Setpoint {
    let head = HeadSetpoint {
        pan,
        tilt,
        pan_speed: speed,
        tilt_speed: speed,
    };
    Setpoint {
        head,
        ..Setpoint::default()
    }
}

/// Creates a robot with a camera that answers, and a session that is configured for it.
fn with_camera() -> Talk {
    let mut robot = p3dx();
    robot.camera = true;
    Talk::new(
        robot,
        Options {
            head: HeadKind::VcC4,
            ..Options::default()
        },
    )
}

#[test]
fn a_camera_that_answers_is_told_one_thing_after_another() {
    let mut talk = with_camera();
    let wish = look(45f64.to_radians(), -20f64.to_radians(), 90f64.to_radians());
    talk.run(&wish, 6.0);
    let expected = [
        HeadCommand::Power(true),
        HeadCommand::Control,
        HeadCommand::Init,
        HeadCommand::PanSpeed(800),
        HeadCommand::TiltSpeed(662),
        // Left is negative for the camera, and up is positive; in ROS, down is positive.
        HeadCommand::PanTilt { pan: -400, tilt: 178 },
    ];
    assert_eq!(camera(&talk.heard()), expected);
    let events = talk.events();
    let Some(Event::Head { pan, tilt }) = events.iter().rfind(|event| matches!(event, Event::Head { .. }))
    else {
        panic!("it says where it looks")
    };
    assert!((pan - wish.head.pan).abs() < HEAD_UNIT && (tilt - wish.head.tilt).abs() < HEAD_UNIT);
    assert!(!events.iter().any(|event| matches!(event, Event::Warning(_))));
}

#[test]
fn a_camera_is_asked_where_it_looks_no_oftener_than_a_slow_line_bears() {
    let mut talk = with_camera();
    talk.run(&Setpoint::default(), 5.0);
    talk.heard();
    talk.run(&Setpoint::default(), 2.0);
    let question = Command::Tty2(HeadCommand::GetPanTilt.to_bytes());
    let heard = talk.heard();
    assert_eq!(heard.iter().filter(|command| **command == question).count(), 10);
}

#[test]
fn a_camera_that_does_not_answer_is_told_all_the_same() {
    let mut talk = Talk::new(
        p3dx(),
        Options {
            head: HeadKind::VcC4,
            ..Options::default()
        },
    );
    talk.run(&look(0.5, 0.0, 1.0), 12.0);
    assert!(
        camera(&talk.heard())
            .iter()
            .any(|command| matches!(command, HeadCommand::PanTilt { .. }))
    );
    assert!(talk.warnings()[0].contains("camera"));
}

#[test]
fn an_axis_without_speed_holds_where_it_is() {
    let mut talk = Talk::new(
        p3dx(),
        Options {
            head: HeadKind::VcC4OneWay,
            ..Options::default()
        },
    );
    talk.run(&look(1.0, 0.3, 0.2), 5.0);
    talk.events();
    talk.run(&look(-1.0, -0.3, 0.0), 2.0);
    let heads: Vec<_> = talk
        .events()
        .into_iter()
        .filter_map(|event| match event {
            Event::Head { pan, tilt } => Some((pan, tilt)),
            _ => None,
        })
        .collect();
    let (pan, tilt) = *heads.last().unwrap();
    assert!(pan > 0.1 && pan < 0.9 && tilt > 0.1, "{pan} {tilt}");
    assert!((heads[heads.len() / 2].0 - pan).abs() < 0.01);
}
