//! The client's session against a scripted robot: handshake, driving within limits, silence, closing; laser,
//! encoders and head.

use core::f64::consts::PI;
use core::time::Duration;

use crate::robot::{Dialogue, Robot, setpoint};
use jde_p2os::*;

fn p3dx() -> Robot {
    Robot::new("Emma", "p3dx")
}

fn simulator() -> Robot {
    Robot::new("AMRISim", "p3dx")
}

fn speeds(commands: &[Command]) -> Vec<i16> {
    let speed = |command: &Command| match command {
        Command::Velocity(speed) => Some(*speed),
        _ => None,
    };
    commands.iter().filter_map(speed).collect()
}

#[test]
fn the_handshake_runs_in_order_and_switches_the_robot_on() {
    let mut dialogue = Dialogue::connected(p3dx(), Options::default());
    let commands = dialogue.commands();
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
    assert_eq!(commands[..8], expected);
    assert!(!commands.iter().any(Command::moves));
    let State::Connected(names) = dialogue.session.state() else {
        panic!("the session is not connected")
    };
    assert_eq!(names.name, "Emma");
    assert_eq!(
        dialogue.session.model().map(|model| model.name.as_str()),
        Some("p3dx")
    );
}

#[test]
fn an_unanswered_step_is_repeated_each_second_and_finally_given_up() {
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
        session.drive(&setpoint(1.0, 1.0), Duration::from_secs(second));
    }
    assert!(matches!(session.state(), State::Lost(_)));
}

#[test]
fn an_open_robot_is_closed_first() {
    let mut dialogue = Dialogue::connected(p3dx().already_open(), Options::default());
    let commands = dialogue.commands();
    let closed = commands
        .iter()
        .position(|command| *command == Command::Close(Form::One))
        .unwrap();
    let rest = [
        Command::Pulse,
        Command::Open(Form::Bare),
        Command::Close(Form::Bare),
        Command::Open(Form::One),
    ];
    assert_eq!(commands[closed + 1..closed + 5], rest);
    assert_eq!(
        commands
            .iter()
            .filter(|command| **command == Command::Close(Form::One))
            .count(),
        1
    );
}

#[test]
fn a_robot_that_never_sends_its_configuration_can_be_driven() {
    let mut robot = p3dx();
    robot.config = None;
    let mut dialogue = Dialogue::connected(robot, Options::default());
    let requests = dialogue
        .commands()
        .iter()
        .filter(|command| **command == Command::Config(Form::One))
        .count();
    assert_eq!(requests, 3);
    assert_eq!(dialogue.session.config(), None);
}

#[test]
fn a_robot_of_an_unknown_subclass_is_refused_unless_a_model_is_configured() {
    let mut dialogue = Dialogue::new(Robot::new("Emma", "roomba"), Options::default());
    dialogue.run(&setpoint(1.0, 0.0), 2.0);
    let State::Refused(reason) = dialogue.session.state() else {
        panic!("the robot is not refused")
    };
    assert!(
        reason.contains("`roomba`") && reason.contains("`p3dx`"),
        "{reason}"
    );
    let model = Some(Model::named("p3at").unwrap());
    Dialogue::connected(
        Robot::new("Emma", "roomba"),
        Options {
            model,
            ..Options::default()
        },
    );
}

#[test]
fn speeds_are_sent_when_they_change_and_every_200_ms() {
    let mut dialogue = Dialogue::connected(p3dx(), Options::default());
    dialogue.commands();
    dialogue.run(&setpoint(0.25, -0.5), 1.0);
    let commands = dialogue.commands();
    assert_eq!(speeds(&commands), [250; 5]);
    assert!(commands.contains(&Command::RotVelocity(-29)));
    dialogue.step(Some(&setpoint(-0.1, 0.0)));
    assert_eq!(
        dialogue.commands(),
        [Command::Velocity(-100), Command::RotVelocity(0)]
    );
}

#[test]
fn nothing_is_sent_while_the_application_hangs() {
    let options = Options {
        laser: LaserMode::Auto(Beams::spread(180, PI)),
        head: HeadKind::VcC4,
        ..Options::default()
    };
    let mut dialogue = Dialogue::connected(simulator(), options);
    dialogue.run(&setpoint(0.3, 0.0), 1.0);
    dialogue.commands();
    dialogue.hang(10.0);
    assert_eq!(dialogue.commands(), []);
}

#[test]
fn speeds_stay_within_the_limits_of_the_model_and_the_robot() {
    let last = |robot| {
        let mut dialogue = Dialogue::connected(robot, Options::default());
        dialogue.commands();
        dialogue.run(&setpoint(50.0, -50.0), 0.1);
        dialogue.commands()
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
fn a_setpoint_that_is_not_finite_moves_nothing() {
    let mut dialogue = Dialogue::connected(p3dx(), Options::default());
    let head = HeadSetpoint {
        pan: f64::NAN,
        tilt: f64::INFINITY,
        pan_speed: f64::NAN,
        tilt_speed: 1.0,
    };
    dialogue.run(
        &Setpoint {
            linear: f64::NAN,
            angular: f64::NAN,
            head,
        },
        1.0,
    );
    assert!(!dialogue.commands().iter().any(Command::moves));
}

#[test]
fn motors_that_are_off_are_switched_on_for_a_motion_a_limited_number_of_times() {
    let mut dialogue = Dialogue::connected(p3dx(), Options::default());
    dialogue.robot.motors_broken = true;
    dialogue.robot.sip.flags = 0;
    dialogue.commands();
    dialogue.run(&setpoint(0.0, 0.0), 3.0);
    assert!(!dialogue.commands().contains(&Command::Enable(true)));
    dialogue.run(&setpoint(0.2, 0.0), 20.0);
    let attempts = dialogue
        .commands()
        .iter()
        .filter(|command| **command == Command::Enable(true))
        .count();
    assert_eq!(attempts, 5);
    let warnings = dialogue.warnings();
    assert!(
        warnings.len() == 1 && warnings[0].contains("motors"),
        "{warnings:?}"
    );
    dialogue.robot.motors_broken = false;
    dialogue.run(&setpoint(0.0, 0.0), 0.2);
    dialogue.run(&setpoint(0.2, 0.0), 2.0);
    assert!(dialogue.robot.sip.motors());
}

#[test]
fn a_robot_that_is_silent_for_a_second_is_lost_and_keeps_its_pose_after_reconnection() {
    let mut dialogue = Dialogue::connected(p3dx(), Options::default());
    dialogue.robot.sip.x = 1000;
    dialogue.run(&setpoint(0.2, 0.0), 2.0);
    let pose = dialogue.session.pose();
    dialogue.robot.silent = true;
    dialogue.run(&setpoint(0.2, 0.0), 1.0);
    assert!(dialogue.session.state().is_connected());
    dialogue.run(&setpoint(0.2, 0.0), 0.2);
    assert!(matches!(dialogue.session.state(), State::Lost(_)));
    let mut restarted = p3dx();
    restarted.sip.x = 7;
    dialogue.robot = restarted;
    dialogue.session.connected(dialogue.now);
    assert_eq!(dialogue.events(), [], "earlier events are discarded");
    dialogue.run(&Setpoint::default(), 2.0);
    assert!(dialogue.session.state().is_connected());
    assert_eq!(dialogue.session.pose(), pose);
}

#[test]
fn closing_stops_the_robot_and_switches_it_off() {
    let mut dialogue = Dialogue::connected(p3dx(), Options::default());
    dialogue.run(&setpoint(0.2, 0.1), 0.5);
    dialogue.commands();
    let closing_bytes = dialogue.session.close();
    dialogue.robot.receive(&closing_bytes, dialogue.now);
    let expected = [
        Command::Velocity(0),
        Command::RotVelocity(0),
        Command::Enable(false),
        Command::Sonar(0),
        Command::Close(Form::One),
    ];
    assert_eq!(dialogue.commands(), expected);
    assert!(dialogue.session.close().is_empty());
    dialogue.run(&setpoint(0.2, 0.1), 1.0);
    assert_eq!(dialogue.commands(), []);
}

#[test]
fn a_laser_is_requested_with_the_old_commands_and_then_with_the_new_ones() {
    let laser = LaserMode::Auto(Beams::spread(180, PI));
    let mut dialogue = Dialogue::connected(
        simulator(),
        Options {
            laser,
            ..Options::default()
        },
    );
    let commands = dialogue.commands();
    let old_commands = [
        Command::LaserStart36(-90),
        Command::LaserEnd37(89),
        Command::LaserIncrement38(100),
        Command::LaserOn35(2),
    ];
    assert!(
        commands.windows(4).any(|commands| commands == old_commands),
        "{commands:?}"
    );
    dialogue.run(&Setpoint::default(), 2.0);
    let first = |value| ForLaser { value, laser: 0 };
    assert!(dialogue.commands().contains(&Command::LrfEnable(first(2))));
    dialogue.run(&Setpoint::default(), 3.0);
    assert!(dialogue.warnings()[0].contains("laser"));
}

#[test]
fn a_laser_is_requested_from_a_robot_only_if_configured() {
    let beams = Beams::spread(180, PI);
    let requests = |laser| {
        let mut dialogue = Dialogue::connected(
            p3dx(),
            Options {
                laser,
                ..Options::default()
            },
        );
        dialogue.commands().contains(&Command::LaserOn35(2))
    };
    assert!(!requests(LaserMode::Auto(beams)));
    assert!(!requests(LaserMode::Off));
    assert!(requests(LaserMode::On(beams)));
}

#[test]
fn sweeps_arrive_complete_and_ticks_without_wrapping() {
    let laser = LaserMode::Auto(Beams::spread(180, PI));
    let mut dialogue = Dialogue::connected(
        simulator(),
        Options {
            laser,
            ..Options::default()
        },
    );
    dialogue.events();
    let sweep: Vec<_> = (0..180)
        .map(|range| Reading {
            range,
            reflectance: 3,
        })
        .collect();
    let form = LaserForm::Extended { device: 0, flags: 0 };
    for part in LaserPacket::sweep(form, &sweep) {
        dialogue
            .session
            .receive(&part.to_packet().unwrap().to_bytes(), dialogue.now);
    }
    for (left, right) in [(i32::MAX - 1, i32::MIN), (i32::MIN, i32::MAX)] {
        let encoders = Encoders { left, right };
        dialogue
            .session
            .receive(&encoders.to_packet().to_bytes(), dialogue.now);
    }
    let ticks = |left, right| Event::Encoders { left, right };
    assert_eq!(
        dialogue.events(),
        [Event::Laser(sweep), ticks(0, 0), ticks(2, -1)]
    );
    // Packets arrive, so the session does not try other commands.
    dialogue.commands();
    dialogue.run(&Setpoint::default(), 5.0);
    assert!(
        !dialogue
            .commands()
            .iter()
            .any(|command| matches!(command, Command::LrfEnable(_)))
    );
}

#[test]
fn ticks_continue_after_a_robot_restarts_its_count() {
    let mut dialogue = Dialogue::connected(p3dx(), Options::default());
    dialogue.events();
    let count = |dialogue: &mut Dialogue, left, right| {
        let encoders = Encoders { left, right };
        dialogue
            .session
            .receive(&encoders.to_packet().to_bytes(), dialogue.now);
    };
    count(&mut dialogue, 100_000, 90_000);
    count(&mut dialogue, 100_500, 90_600);
    dialogue.session.lost("its connection is gone");
    dialogue.robot = p3dx();
    dialogue.session.connected(dialogue.now);
    dialogue.run(&Setpoint::default(), 2.0);
    dialogue.events();
    count(&mut dialogue, 3, 4);
    count(&mut dialogue, 13, 24);
    let ticks = |left, right| Event::Encoders { left, right };
    assert_eq!(dialogue.events(), [ticks(500, 600), ticks(510, 620)]);
}

/// Returns the commands to the camera, without requests for its angles.
fn camera_commands(commands: &[Command]) -> Vec<HeadCommand> {
    let command = |command: &Command| match command {
        Command::Tty2(bytes) => match HeadFrame::from_bytes(bytes) {
            Ok(HeadFrame::Command(command)) if command != HeadCommand::GetPanTilt => Some(command),
            _ => None,
        },
        _ => None,
    };
    commands.iter().filter_map(command).collect()
}

fn head_setpoint(pan: f64, tilt: f64, speed: f64) -> Setpoint {
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

/// Creates a robot with a camera that replies, and a session that is configured for it.
fn with_camera() -> Dialogue {
    let mut robot = p3dx();
    robot.camera = true;
    Dialogue::new(
        robot,
        Options {
            head: HeadKind::VcC4,
            ..Options::default()
        },
    )
}

#[test]
fn a_camera_that_replies_receives_one_command_after_another() {
    let mut dialogue = with_camera();
    let setpoint = head_setpoint(45f64.to_radians(), -20f64.to_radians(), 90f64.to_radians());
    dialogue.run(&setpoint, 6.0);
    let expected = [
        HeadCommand::Power(true),
        HeadCommand::Control,
        HeadCommand::Init,
        HeadCommand::PanSpeed(800),
        HeadCommand::TiltSpeed(662),
        // Left is negative for the camera, and up is positive; in ROS, down is positive.
        HeadCommand::PanTilt { pan: -400, tilt: 178 },
    ];
    assert_eq!(camera_commands(&dialogue.commands()), expected);
    let events = dialogue.events();
    let Some(Event::Head { pan, tilt }) = events.iter().rfind(|event| matches!(event, Event::Head { .. }))
    else {
        panic!("the head's angles are not reported")
    };
    assert!((pan - setpoint.head.pan).abs() < HEAD_UNIT && (tilt - setpoint.head.tilt).abs() < HEAD_UNIT);
    assert!(!events.iter().any(|event| matches!(event, Event::Warning(_))));
}

#[test]
fn a_camera_is_queried_no_more_often_than_a_slow_line_permits() {
    let mut dialogue = with_camera();
    dialogue.run(&Setpoint::default(), 5.0);
    dialogue.commands();
    dialogue.run(&Setpoint::default(), 2.0);
    let query = Command::Tty2(HeadCommand::GetPanTilt.to_bytes());
    let commands = dialogue.commands();
    assert_eq!(commands.iter().filter(|command| **command == query).count(), 10);
}

#[test]
fn a_camera_that_does_not_reply_is_commanded_all_the_same() {
    let mut dialogue = Dialogue::new(
        p3dx(),
        Options {
            head: HeadKind::VcC4,
            ..Options::default()
        },
    );
    dialogue.run(&head_setpoint(0.5, 0.0, 1.0), 12.0);
    assert!(
        camera_commands(&dialogue.commands())
            .iter()
            .any(|command| matches!(command, HeadCommand::PanTilt { .. }))
    );
    assert!(dialogue.warnings()[0].contains("camera"));
}

#[test]
fn an_axis_without_speed_holds_its_angle() {
    let mut dialogue = Dialogue::new(
        p3dx(),
        Options {
            head: HeadKind::VcC4OneWay,
            ..Options::default()
        },
    );
    dialogue.run(&head_setpoint(1.0, 0.3, 0.2), 5.0);
    dialogue.events();
    dialogue.run(&head_setpoint(-1.0, -0.3, 0.0), 2.0);
    let heads: Vec<_> = dialogue
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
