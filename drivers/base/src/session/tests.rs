//! The session with the sketch's own board, in the time of the test.

use jde_schema::prelude::Pose2D;
use proptest::prelude::*;

use super::*;
use crate::tests::board::{Board as HostBoard, Fault, Wired};

/// Time between two iterations of the driver.
const STEP: u64 = 10;

/// A session and a board.
struct Run {
    session: BaseSession,
    wired: Wired,
    now: u64,
    /// What is on its way to the board.
    to_board: Vec<u8>,
    twist: Twist,
    pose: Pose2D,
    names: Vec<String>,
    warnings: Vec<String>,
    lost: Option<String>,
    last: Option<Report>,
}

impl Run {
    fn new(kind: &str) -> Self {
        Self::with(kind, "")
    }

    fn with(kind: &str, wanted: &str) -> Self {
        let config = BaseConfig {
            serial_number: wanted.to_owned(),
        };
        let mut events = Vec::new();
        let session = BaseSession::start(config, Duration::from_millis(1000), &mut events);
        let mut run = Self {
            session,
            wired: Wired::new(HostBoard::new(kind, "kit-07")),
            now: 1000,
            to_board: Vec::new(),
            twist: Twist::ZERO,
            pose: Pose2D::ORIGIN,
            names: Vec::new(),
            warnings: Vec::new(),
            lost: None,
            last: None,
        };
        run.take(events);
        run
    }

    /// One that is ready.
    fn ready(kind: &str) -> Self {
        let mut run = Self::new(kind);
        run.run(200);
        assert!(run.session.is_ready(), "{:?}", run.lost);
        run
    }

    fn take(&mut self, events: Vec<Event<Data>>) {
        for event in events {
            match event {
                Event::Send(bytes) => self.to_board.extend(bytes),
                Event::Ready(name) => self.names.push(name),
                Event::Warn(words) => self.warnings.push(words),
                Event::Disconnect(reason) => self.lost = Some(reason),
                Event::Data(Data::State { report, step, .. }) => {
                    self.pose = self.pose.transform(&step.motion);
                    self.last = Some(*report);
                }
                Event::Data(Data::Hello(_)) => {}
                Event::Baud(_) => panic!("it knows its speed"),
            }
        }
    }

    /// Iterates for so many milliseconds, or until the board is lost.
    fn run(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds / STEP {
            if self.lost.is_some() {
                return;
            }
            self.now += STEP;
            let bytes = core::mem::take(&mut self.to_board);
            let arrived = self.wired.advance(STEP, &bytes);
            self.receive(&arrived);
        }
    }

    fn receive(&mut self, arrived: &[u8]) {
        let (now, mut events) = (Duration::from_millis(self.now), Vec::new());
        self.session.receive(arrived, now, &mut events);
        self.take(events);
        let bytes = self.session.drive(&self.twist, now);
        self.to_board.extend(bytes);
    }

    /// Runs on until it is lost, and returns why and after how many milliseconds.
    fn until_lost(&mut self) -> (String, u64) {
        let start = self.now;
        self.run(20_000);
        (self.lost.clone().expect("it is lost"), self.now - start)
    }

    fn speed(&self) -> f64 {
        self.wired.board.truth.speeds[0]
    }
}

#[track_caller]
fn near(value: f64, expected: f64, tolerance: f64) {
    assert!(
        (value - expected).abs() <= tolerance,
        "{value} instead of {expected}"
    );
}

#[test]
fn a_base_drives_as_commanded_and_its_odometry_is_the_way_of_its_wheels() {
    for (kind, left) in [("differential", 0.0), ("mecanum", -0.2)] {
        let mut run = Run::ready(kind);
        run.twist = Twist::planar(0.3, 0.5);
        run.twist.linear.y = left;
        run.run(6000);
        let truth = run.wired.board.truth;
        near(truth.speeds[0], 0.3, 0.02);
        near(truth.speeds[1], left, 0.02);
        near(truth.speeds[2], 0.5, 0.05);
        run.twist = Twist::ZERO;
        run.run(2000);
        let truth = run.wired.board.truth;
        near(truth.speeds[0], 0.0, 0.01);
        near(run.pose.x, truth.pose[0], 0.02);
        near(run.pose.y, truth.pose[1], 0.02);
        near(
            run.pose.theta,
            jde_schema::types::normalize_angle(truth.pose[2]),
            0.03,
        );
        assert!(run.warnings.is_empty(), "{:?}", run.warnings);
        assert!(run.names[0].starts_with("kit-07, a"), "{:?}", run.names);
    }
}

#[test]
fn a_board_that_hears_no_commands_stops_within_its_watchdog_and_its_deceleration() {
    let mut run = Run::ready("differential");
    run.twist = Twist::planar(0.4, 0.0);
    run.run(2000);
    near(run.speed(), 0.4, 0.03);
    run.wired.advance(250, &[]);
    near(run.speed(), 0.4, 0.03);
    // 300 ms, then 0.4 m/s at 1.2 m/s², and the motors' lag.
    run.wired.advance(900, &[]);
    near(run.speed(), 0.0, 0.01);
}

#[test]
fn a_board_that_falls_silent_is_told_to_stop_and_lost_within_the_validity_of_the_odometry() {
    let mut run = Run::ready("differential");
    run.twist = Twist::planar(0.4, 0.0);
    run.run(2000);
    run.wired.fault = Fault::Silent;
    let (reason, after) = run.until_lost();
    assert!(reason.contains("it sends nothing"), "{reason}");
    assert!(after <= 500 + 2 * STEP, "{after} ms");
    let bytes = core::mem::take(&mut run.to_board);
    run.wired.advance(800, &bytes);
    near(run.speed(), 0.0, 0.01);
}

#[test]
fn a_board_that_ignores_commands_is_named_before_and_after_it_is_ready() {
    let mut run = Run::new("differential");
    run.wired.fault = Fault::Deaf;
    let (reason, _) = run.until_lost();
    assert!(reason.contains("no reply to `?`"), "{reason}");
    let mut run = Run::ready("differential");
    run.twist = Twist::planar(0.4, 0.0);
    run.wired.fault = Fault::Deaf;
    let (reason, after) = run.until_lost();
    assert!(reason.contains("does not acknowledge commands"), "{reason}");
    assert!(after <= 700, "{after} ms");
}

#[test]
fn lines_that_are_lost_or_corrupt_are_counted_and_cost_no_way() {
    for (fault, words) in [
        (Fault::Missing(3), "lines of the board, 0 with wrong"),
        (Fault::Corrupt(3), "with wrong checksums"),
        (Fault::Noisy, "with wrong checksums"),
    ] {
        let mut run = Run::ready("differential");
        run.wired.fault = fault;
        run.twist = Twist::planar(0.3, 0.3);
        run.run(12_000);
        assert_eq!(run.lost, None);
        let truth = run.wired.board.truth;
        near(run.pose.x, truth.pose[0], 0.03);
        near(run.pose.y, truth.pose[1], 0.03);
        assert_eq!(
            run.warnings.len(),
            2,
            "at once, and ten seconds later: {:?}",
            run.warnings
        );
        assert!(run.warnings[1].contains(words), "{:?}", run.warnings);
    }
}

#[test]
fn a_board_that_starts_anew_stands_until_it_is_known_again_and_the_pose_goes_on() {
    let mut run = Run::ready("differential");
    run.twist = Twist::planar(0.4, 0.0);
    run.run(3000);
    let before = run.pose;
    assert!(before.x > 0.8);
    let greeting = run.wired.board.change("reset");
    run.receive(&greeting);
    assert!(!run.session.is_ready());
    assert!(run.warnings[0].contains("started anew"), "{:?}", run.warnings);
    near(run.pose.x, before.x, 1e-9);
    run.run(3000);
    assert!(run.session.is_ready() && run.lost.is_none(), "{:?}", run.lost);
    near(run.speed(), 0.4, 0.03);
    assert!(run.pose.x > before.x + 0.8);
}

#[test]
fn another_board_than_the_wanted_one_is_refused() {
    let mut run = Run::with("differential", "kit-08");
    let (reason, _) = run.until_lost();
    assert!(
        reason.contains("is kit-07, not kit-08") && reason.contains("swapped"),
        "{reason}"
    );
    let mut run = Run::with("differential", "kit-07");
    run.run(200);
    assert!(run.session.is_ready());
}

#[test]
fn wheels_that_run_although_they_must_stand_are_named_while_they_do() {
    let mut run = Run::ready("differential");
    run.wired.board.change("race");
    run.run(4000);
    assert!(
        run.names[1].starts_with("its wheels run although they must stand"),
        "{:?}",
        run.names
    );
    run.wired.board.change("race");
    run.run(2000);
    assert!(run.names[2].starts_with("kit-07"), "{:?}", run.names);
    assert_eq!((run.names.len(), run.lost), (3, None));
}

#[test]
fn blocked_wheels_and_an_encoder_that_counts_backwards_stop_the_motors_until_a_command_to_stand() {
    for fault in ["block", "reverse"] {
        let mut run = Run::ready("differential");
        run.wired.board.change(fault);
        run.twist = Twist::planar(0.3, 0.0);
        run.run(3000);
        assert!(run.last.as_ref().is_some_and(|report| report.stalled), "{fault}");
        assert!(run.names[1].starts_with("a wheel is blocked"), "{:?}", run.names);
        run.wired.board.change(fault);
        run.run(500);
        near(run.speed(), 0.0, 0.01);
        run.twist = Twist::ZERO;
        run.run(200);
        run.twist = Twist::planar(0.3, 0.0);
        run.run(2000);
        near(run.speed(), 0.3, 0.03);
    }
}

#[test]
fn wheels_whose_encoders_count_backwards_stand_when_they_must() {
    let mut run = Run::ready("differential");
    run.twist = Twist::planar(0.3, 0.0);
    run.run(1000);
    run.wired.board.change("reverse");
    run.twist = Twist::ZERO;
    run.run(1500);
    near(run.speed(), 0.0, 0.01);
    // Nobody commands anything, and a person pushes it.
    let mut board = HostBoard::new("differential", "kit-07");
    board.change("reverse");
    board.change("push");
    board.advance(1000, &[]);
    near(board.truth.speeds[0], 0.0, 0.01);
}

#[test]
fn an_encoder_that_counts_nothing_adds_little_voltage_and_stops_the_motors() {
    let mut run = Run::ready("differential");
    run.wired.board.change("dead");
    run.twist = Twist::planar(0.2, 0.0);
    let mut fastest = 0.0;
    for _ in 0..300 {
        run.run(STEP);
        fastest = f64::max(fastest, run.speed());
    }
    assert!(fastest < 0.4, "{fastest} m/s of the middle");
    assert!(run.last.as_ref().is_some_and(|report| report.stalled));
    near(run.speed(), 0.0, 0.01);
}

#[test]
fn a_line_that_is_always_late_is_refused_although_its_delay_is_constant() {
    for is_ready in [true, false] {
        let mut run = Run::new("differential");
        if is_ready {
            run.run(200);
        }
        run.wired.fault = Fault::Late(300);
        let (reason, after) = run.until_lost();
        assert!(reason.contains("take more than 0.2 s"), "{reason}");
        assert!(after < 4000, "{after} ms");
        assert_eq!(run.names.len(), usize::from(is_ready));
    }
}

#[test]
fn counts_that_leap_say_nothing_of_the_base() {
    let mut run = Run::ready("differential");
    run.twist = Twist::planar(0.3, 0.0);
    run.run(1000);
    let (pose, before) = (run.pose, run.last.clone().expect("a line"));
    for leap in 1..3 {
        let number = before.number.wrapping_add(leap);
        let time = before.time.wrapping_add(leap.into());
        let count = 1_000_000 * i32::from(leap);
        run.receive(&line(&format!("s {number} t={time} left={count} right=0")));
    }
    assert_eq!((run.pose, run.last.clone()), (pose, Some(before)));
    assert_eq!(run.warnings.len(), 1, "{:?}", run.warnings);
    assert!(run.warnings[0].contains("leapt"), "{:?}", run.warnings);
}

#[test]
fn a_board_whose_line_has_no_room_drives_on_and_says_what_it_is_later() {
    let mut board = HostBoard::new("differential", "kit-07");
    board.advance(100, &[]);
    board.change("full");
    board.advance(0, &line("? 9"));
    assert_eq!(board.advance(200, &line("v 8 500 0 0")), b"");
    assert!(board.truth.speeds[0] > 0.05);
    let sent = [board.change("full"), board.advance(50, &[])].concat();
    let sent = String::from_utf8(sent).expect("a text");
    assert!(
        sent.starts_with("hello 1 for=9 ") && sent.contains(" ack=8 "),
        "{sent}"
    );
}

#[test]
fn a_board_that_has_no_command_in_force_is_named_once_while_it_is_connected() {
    let mut run = Run::ready("differential");
    for _ in 0..3 {
        run.wired.advance(0, b"stop\n");
        run.run(200);
    }
    assert_eq!((run.warnings.len(), &run.lost), (1, &None), "{:?}", run.warnings);
    assert!(
        run.warnings[0].contains("no command in force"),
        "{:?}",
        run.warnings
    );
}

#[test]
fn refused_lines_are_counted_only_from_counts_that_grow() {
    let mut run = Run::ready("differential");
    let Report { number, time, .. } = run.last.clone().expect("a line");
    for (more, bad) in (1..).zip([" bad=7", "", " bad=9", " bad=12", " bad=1"]) {
        let (number, time) = (number.wrapping_add(more), time.wrapping_add(more.into()));
        run.receive(&line(&format!(
            "s {number} t={time}{bad} left=4294967000 right=4294967000"
        )));
    }
    // 7 more than the board's own 0, and 3 more than 9.
    assert_eq!(run.session.losses.refused, 10);
}

#[test]
fn an_arc_that_is_too_fast_stays_its_arc() {
    let mut board = HostBoard::new("differential", "kit-07");
    for number in 0..30 {
        board.advance(100, &line(&format!("v {number} 1000 0 2000")));
    }
    near(board.truth.speeds[0], 0.5, 0.03);
    near(board.truth.speeds[2], 1.0, 0.1);
}

#[test]
fn another_speed_of_the_line_and_a_wire_that_is_open_are_told_apart() {
    for (fault, words) in [
        (Fault::OtherBaud, "the speed of the line"),
        (Fault::Silent, "it sends nothing"),
    ] {
        let mut run = Run::new("differential");
        run.wired.fault = fault;
        let (reason, after) = run.until_lost();
        assert!(reason.contains(words), "{reason}");
        near(after as f64, 6000.0, 20.0);
    }
}

#[test]
fn after_a_pause_of_the_driver_the_lines_that_waited_are_old_and_the_base_stands() {
    let mut run = Run::ready("differential");
    run.twist = Twist::planar(0.4, 0.0);
    run.run(2000);
    let waited = run.wired.advance(3000, &[]);
    near(run.speed(), 0.0, 0.01);
    run.now += 3000;
    run.receive(&waited);
    run.run(2000);
    assert_eq!(run.lost, None);
    near(run.speed(), 0.4, 0.03);
    near(run.pose.x, run.wired.board.truth.pose[0], 0.02);
}

#[test]
fn a_board_that_another_program_drives_is_refused() {
    let mut run = Run::ready("differential");
    run.wired.advance(0, &line("v 4000 100 0 0"));
    let (reason, _) = run.until_lost();
    assert!(reason.contains("who else"), "{reason}");
    // A number that is long past is none of this driver's.
    let mut run = Run::ready("differential");
    run.wired.advance(0, &line("v 65000 100 0 0"));
    let (reason, _) = run.until_lost();
    assert!(reason.contains("who else"), "{reason}");
}

#[test]
fn a_person_at_a_terminal_greets_and_stops_without_a_checksum_and_drives_nothing() {
    let mut board = HostBoard::new("differential", "kit-07");
    board.advance(100, &[]);
    let reply = String::from_utf8(board.advance(0, b"?\r\n")).expect("a text");
    assert!(reply.starts_with("hello 1 for=0 kind=differential"), "{reply}");
    board.advance(500, b"v 1 300 0 0\r\n");
    near(board.truth.speeds[0], 0.0, 1e-9);
    board.advance(250, &line("v 1 300 0 0"));
    assert!(board.truth.speeds[0] > 0.1);
    board.advance(250, b"stop\n");
    near(board.truth.speeds[0], 0.0, 0.05);
}

proptest! {
    #[test]
    fn no_bytes_break_a_session(pieces in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..200), 0..8)) {
        let mut events = Vec::new();
        let config = BaseConfig { serial_number: String::new() };
        let mut session = BaseSession::start(config, Duration::ZERO, &mut events);
        for (tenth, piece) in (1..).zip(&pieces) {
            session.receive(piece, Duration::from_millis(tenth * 100), &mut events);
            prop_assert!(!session.is_ready());
            prop_assert!(session.drive(&Twist::planar(1.0, 0.0), Duration::from_millis(tenth * 100)).is_empty());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn no_bytes_move_a_board_or_keep_it_from_hearing(
        noise in prop::collection::vec(any::<u8>(), 0..300),
        place in any::<prop::sample::Index>(),
        change in 1..=255_u8,
    ) {
        let mut board = HostBoard::new("differential", "kit-07");
        board.advance(100, &noise);
        let mut command = line("v 7 500 0 0");
        let place = place.index(command.len() - 1);
        command[place] ^= change;
        board.advance(200, &[b"\n", &command[..]].concat());
        prop_assert_eq!(board.truth.speeds, [0.0; 3]);
        let sent = board.advance(100, &[b"\n", &line("? 9")[..], &line("v 8 500 0 0")].concat());
        let sent = String::from_utf8(sent).expect("a text");
        prop_assert!(sent.contains("hello 1 for=9 ") && sent.contains(" ack=8 "), "{}", sent);
        prop_assert!(board.truth.speeds[0] > 0.0);
    }
}
