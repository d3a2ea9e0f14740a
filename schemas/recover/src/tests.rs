//! A closed loop without noise: a base of 0.25 m radius among points, which is driven ahead by others while the
//! recovery is not ready.

use core::f64::consts::TAU;

use jde_motion::{BaseDynamics, Travel};
use jde_schema::bench::Bench;
use jde_schema::types::Footprint;

use super::*;

const DYNAMICS: BaseDynamics = BaseDynamics {
    acceleration: 0.5,
    deceleration: 0.5,
    turn_acceleration: 2.0,
    turn_deceleration: 2.0,
    lag: 0.0,
};

/// A robot, the points that it must not touch, and what it does by itself.
struct World {
    bench: Bench<Recover>,
    points: Vec<Point2D>,
    footprint: Footprint,
    travel: Travel,
    /// The command of the other schemas.
    others: Twist,
    now: Duration,
    /// The least clearance so far, m.
    clearance: f64,
}

impl World {
    fn new(footprint: Footprint, points: &[(f64, f64)]) -> Self {
        let mut bench = Bench::new();
        bench.awake().expect("it awakes");
        Self {
            bench,
            points: points.iter().map(|&(x, y)| Point2D { x, y }).collect(),
            footprint,
            travel: Travel::default(),
            others: Twist::ZERO,
            now: Duration::ZERO,
            clearance: f64::INFINITY,
        }
    }

    fn round(points: &[(f64, f64)]) -> Self {
        Self::new(Footprint::circle(0.25), points)
    }

    /// Passes 0.1 s, and returns the command of the recovery; `None` if it is not ready.
    fn step(&mut self) -> Option<Twist> {
        let Travel { pose, velocity, .. } = self.travel;
        let mut around = Surroundings {
            velocity,
            footprint: self.footprint,
            reaction: 0.15,
            margin: 0.05,
            dynamics: DYNAMICS,
            ..Surroundings::default()
        };
        for point in &self.points {
            let Pose2D { x, y, .. } = pose.localize(&Pose2D::new(point.x, point.y, 0.0));
            around.points.push(Point2D { x, y }).expect("few points");
        }
        let outline = Outline::try_from(&self.footprint).expect("a valid footprint");
        self.clearance = self
            .clearance
            .min(outline.clearance(&Pose2D::ORIGIN, around.points.as_slice()));
        self.now += Duration::from_millis(100);
        self.bench.set_now(self.now);
        self.bench.import("surroundings", &around);
        self.bench
            .import("pose", &Odometry::planar(self.now, pose, velocity));
        let mission = Mission {
            target: Pose2D::new(9.0, 0.0, 0.0),
            distance: 9.0,
            ..Mission::default()
        };
        self.bench.import("mission", &mission);
        let ready = self.bench.check().expect("the check succeeds").ready;
        let command = ready.then(|| {
            self.bench.iterate().expect("the iteration succeeds");
            self.bench.commanded::<Twist>("base").expect("a command")
        });
        self.travel = self.travel.after(0.1, &command.unwrap_or(self.others), &DYNAMICS);
        command
    }

    /// Passes time until the recovery is ready or not; returns its commands.
    fn pass_until(&mut self, ready: bool) -> Vec<Twist> {
        let mut commands = Vec::new();
        for _ in 0..1000 {
            let command = self.step();
            if command.is_some() == ready {
                return commands;
            }
            commands.extend(command);
        }
        panic!("it is never ready: {ready}");
    }

    /// What was reported last.
    fn report(&self) -> Option<(u8, String)> {
        let recovery: Mission = self.bench.exported("recovery")?;
        Some((recovery.state, recovery.note.as_str().to_owned()))
    }
}

#[test]
fn it_is_ready_only_for_a_robot_with_a_target_that_stands_for_some_time() {
    let mut world = World::round(&[]);
    world.others = Twist::planar(0.1, 0.0);
    assert!((0..300).all(|_| world.step().is_none()), "it moves");
    world.others = Twist::ZERO;
    let stood = world.now;
    world.pass_until(true);
    assert!((world.now - stood).as_secs() >= 8, "{:?}", world.now - stood);
    world.bench.import(
        "mission",
        &Mission {
            state: Mission::DONE,
            ..Mission::default()
        },
    );
    assert!(
        !world.bench.check().expect("the check succeeds").ready,
        "no target"
    );
    world.pass_until(true);
    world.bench.retract("surroundings");
    assert!(
        !world.bench.check().expect("the check succeeds").ready,
        "it knows nothing"
    );
}

#[test]
fn a_pose_that_is_no_number_moves_nothing_and_one_that_jumps_ends_the_action() {
    let mut world = World::round(&[]);
    world.pass_until(true);
    for (x, theta) in [(f64::NAN, 0.0), (f64::INFINITY, 0.0), (0.0, f64::NAN)] {
        let odometry = Odometry::planar(world.now, Pose2D::new(x, 0.0, theta), Twist::ZERO);
        world.bench.import("pose", &odometry);
        assert!(
            !world.bench.check().expect("the check succeeds").ready,
            "{x}, {theta}"
        );
        world.bench.iterate().expect("the iteration succeeds");
        assert_eq!(world.bench.commanded("base"), Some(Twist::ZERO), "{x}, {theta}");
    }
    world.pass_until(true);
    world.travel.pose = Pose2D::new(5.0, 5.0, 1.0);
    assert!(world.step().is_none_or(|twist| twist == Twist::ZERO));
    assert_eq!(world.step(), None);
}

#[test]
fn it_goes_back_along_the_arc_that_it_came() {
    let mut world = World::round(&[]);
    world.bench.set("backup_dist", 1.0);
    world.bench.set("away", 2.0);
    world.others = Twist::planar(0.3, 0.3);
    for _ in 0..70 {
        world.step();
    }
    let way: Vec<Pose2D> = world.bench.schema().trail.poses().copied().collect();
    world.others = Twist::ZERO;
    world.pass_until(true);
    let from = world.travel.pose;
    world.pass_until(false);
    let to = world.travel.pose;
    assert!((0.9..1.2).contains(&from.distance_to(&to)), "{from:?} {to:?}");
    let off = way
        .iter()
        .map(|place| place.distance_to(&to))
        .fold(f64::INFINITY, f64::min);
    assert!(off < 0.05, "{off} m beside the way");
    assert_eq!(
        world.report(),
        Some((Mission::RUNNING, "goes back the way it came".into()))
    );
}

#[test]
fn it_goes_back_until_a_long_robot_has_room_to_turn() {
    // A corridor of 0.7 m that ends at x = 1; the robot is 0.9 m long.
    let corners = [(0.45, 0.2), (-0.45, 0.2), (-0.45, -0.2), (0.45, -0.2)].map(|(x, y)| Point2D { x, y });
    let footprint = Footprint {
        radius: 0.0,
        points: Seq::from_slice(&corners).expect("four corners"),
    };
    let sides = (-20..=0).flat_map(|x| {
        [
            (f64::from(x) * 0.05 + 2.0, 0.35),
            (f64::from(x) * 0.05 + 2.0, -0.35),
        ]
    });
    let mut points: Vec<(f64, f64)> = sides.collect();
    points.push((2.1, 0.0));
    let mut world = World::new(footprint, &points);
    world.others = Twist::planar(0.15, 0.0);
    while world.travel.pose.x < 1.5 {
        world.step();
    }
    world.others = Twist::ZERO;
    world.pass_until(true);
    let commands = world.pass_until(false);
    assert!(commands.iter().all(|command| command.linear.x <= 0.0));
    assert!(world.travel.pose.x < 0.6, "{:?}", world.travel.pose);
    assert!(world.clearance > 0.05, "{} m", world.clearance);
}

#[test]
fn a_robot_with_its_back_to_a_wall_turns_on_the_spot_instead() {
    let wall = (-10..=10).map(|y| (-0.32, f64::from(y) * 0.05));
    let mut world = World::round(&wall.collect::<Vec<_>>());
    world.pass_until(true);
    let commands = world.pass_until(false);
    assert!(
        commands.iter().all(|command| command.linear.x == 0.0),
        "{commands:?}"
    );
    let turned: f64 = commands.iter().map(|command| command.angular.z * 0.1).sum();
    assert!((TAU - 0.2..TAU + 0.5).contains(&turned), "{turned} rad");
    assert!(world.clearance > 0.05, "{} m", world.clearance);
}

#[test]
fn a_base_that_cannot_turn_on_the_spot_does_not_and_its_arcs_are_wide() {
    let mut world = World::round(&[]);
    world.bench.set("radius", 2.0);
    world.others = Twist::planar(0.3, 0.6);
    for _ in 0..50 {
        world.step();
    }
    world.others = Twist::ZERO;
    for _ in 0..800 {
        let command = world.step().unwrap_or_default();
        let (speed, turn) = (command.linear.x, command.angular.z);
        assert!(turn.abs() <= speed.abs() / 2.0 + 1e-9, "{command:?}");
    }
}

#[test]
fn a_robot_that_is_boxed_in_has_the_map_cleared_waits_and_gives_up_in_words() {
    let ring = (0..32).map(|i| (TAU * f64::from(i) / 32.0).sin_cos());
    let mut world = World::round(
        &ring
            .map(|(sin, cos)| (0.33 * cos, 0.33 * sin))
            .collect::<Vec<_>>(),
    );
    while world.report().is_none_or(|(state, _)| state != Mission::FAILED) {
        world.step();
        assert!(
            world.now.as_secs() < 200,
            "it does not give up: {:?}",
            world.report()
        );
    }
    let (_, words) = world.report().expect("a report");
    assert_eq!(words, "in vain: turned, asked to clear the map, waited");
    let cleared: Point2D = world.bench.exported("clear").expect("a request");
    assert!(cleared.x.hypot(cleared.y) < 0.03, "{cleared:?}");
    assert!(world.travel.pose.distance_to(&Pose2D::ORIGIN) < 0.03);
    let panel = world.bench.draw().expect("the panel is drawn");
    assert!(panel.texts().contains(&words.as_str()));
    assert!(panel.shapes("around").len() >= 2, "points and robot");
}

#[test]
fn a_robot_that_gets_away_is_no_longer_stuck() {
    let mut world = World::round(&[]);
    world.pass_until(true);
    world.pass_until(false);
    world.others = Twist::planar(0.3, 0.0);
    for _ in 0..80 {
        world.step();
    }
    assert_eq!(world.report(), Some((Mission::RUNNING, String::new())));
}
