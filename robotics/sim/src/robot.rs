//! One robot: its motion, its contacts and its ground truth.
//!
//! The world provides the clearance to its surroundings.

use crate::battery::Battery;
use crate::config::{OdometryOrigin, RobotConfig};
use crate::drive::{Kinematics, Motors};
use crate::footprint::RobotBody;
use crate::geometry::{Pose2, Twist2};
use crate::head::{Head, HeadCommand};
use crate::odometer::Odometer;
use crate::random::Noise;
use crate::trail::Trail;

/// A gap at which bodies count as touching, in metres: the travel of a bumper.
pub(crate) const CONTACT: f64 = 0.001;
/// The gap at which a contact ends, in metres. It exceeds [`CONTACT`], so that one touch is counted once.
const RELEASE: f64 = 0.003;
/// How many times a piece of a step is halved to find the moment of contact.
const HALVINGS: u32 = 24;

/// The ground truth of a robot, which none of its own sensors can measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Its pose, in the frame of the world.
    pub pose: Pose2,
    /// Its twist, in its own frame.
    pub twist: Twist2,
    /// The distance driven in metres, forwards and backwards alike.
    pub travelled: f64,
    /// The gap between its body and the nearest thing, mover or robot, in metres; infinite when there is
    /// none. Loose things are not counted: pushing one is no collision.
    pub clearance: f64,
    /// The smallest clearance since it was added to the world.
    pub min_clearance: f64,
    /// Whether it touches something. A contact begins at a gap below 1 mm and ends at one above 3 mm.
    pub contact: bool,
    /// How many contacts have begun.
    pub collisions: u64,
    /// Whether an obstacle blocks the motion of its wheels.
    pub stalled: bool,
}

/// A motion at a constant twist, in the robot's frame: metres ahead and to the left, and radians.
#[derive(Clone, Copy, Debug)]
struct Displacement {
    ahead: f64,
    left: f64,
    turn: f64,
}

#[derive(Debug)]
pub(crate) struct SimulatedRobot {
    pub(crate) config: RobotConfig,
    pub(crate) truth: Truth,
    pub(crate) odometer: Odometer,
    pub(crate) head: Head,
    pub(crate) battery: Battery,
    /// The change of its twist over the last step, in its own frame, for each second.
    pub(crate) change: Twist2,
    motors: Motors,
    /// Kilograms that it pushed over the last step.
    load: f64,
    /// Amperes from the charger that it stands on.
    supply: f64,
    head_command: HeadCommand,
    /// Where it was at the last steps.
    trail: Trail,
}

impl SimulatedRobot {
    pub(crate) fn new(config: RobotConfig, start: Pose2, clearance: f64, scale: &Noise) -> Self {
        let origin = match config.odometry_origin {
            OdometryOrigin::Zero => Pose2::default(),
            OdometryOrigin::StartPose => start,
        };
        let odometer = Odometer::new(&config, origin, scale);
        let truth = Truth {
            pose: start,
            twist: Twist2::default(),
            travelled: 0.0,
            clearance,
            min_clearance: clearance,
            contact: false,
            collisions: 0,
            stalled: false,
        };
        let battery = Battery::full(config.battery_capacity);
        let trail = Trail::new(config.trail);
        let mut robot = Self {
            config,
            truth,
            odometer,
            head: Head::default(),
            battery,
            change: Twist2::default(),
            motors: Motors::default(),
            load: 0.0,
            supply: 0.0,
            head_command: HeadCommand::default(),
            trail,
        };
        robot.update_contact(clearance);
        robot
    }

    pub(crate) fn command(&mut self, twist: Twist2) {
        self.motors.command(&self.config, twist);
    }

    /// Sets the amperes from a charger for the next step.
    pub(crate) fn supply(&mut self, amperes: f64) {
        self.supply = amperes;
    }

    pub(crate) fn command_head(&mut self, command: HeadCommand) {
        self.head_command = command;
    }

    /// Moves it to another pose, at rest, until the next command. Its wheels measure nothing of it.
    pub(crate) fn place(&mut self, pose: Pose2, clearance: f64) {
        self.motors.stop();
        self.change = Twist2::default();
        self.odometer.odometry.twist = Twist2::default();
        self.trail.clear();
        let truth = &mut self.truth;
        (truth.pose, truth.twist, truth.stalled) = (pose, Twist2::default(), false);
        // A robot that is put down beside a thing has not collided with it.
        truth.contact = clearance < CONTACT;
    }

    /// Moves for `dt` seconds, while `clearance_at` is not negative and `make_room` returns `Some`, and
    /// updates the odometer, head and battery. `make_room` moves loose things out of the body's way at a pose
    /// that the body reaches within the given seconds, and returns the kilograms that moved.
    pub(crate) fn step(
        &mut self,
        dt: f64,
        slip: &Noise,
        clearance_at: impl Fn(Pose2) -> f64,
        make_room: impl FnMut(Pose2, f64) -> Option<f64>,
    ) {
        self.trail.push(self.truth.pose);
        let before = self.truth.twist;
        let after = self.motors.step(&self.config, before, self.load, dt);
        // Under a constant acceleration the mean of the two speeds gives the exact distance.
        let mean = |before: f64, after: f64| (before + after) / 2.0 * dt;
        let motion = Displacement {
            ahead: mean(before.linear, after.linear),
            left: mean(before.lateral, after.lateral),
            turn: mean(before.angular, after.angular),
        };
        let free = self.free_part(motion, &clearance_at);
        let part = self.push(free, motion, dt, make_room);
        let moved = motion.part(part);
        self.truth.pose = moved.end(self.truth.pose);
        self.truth.stalled = part < 1.0;
        let turns_on_the_spot = match self.config.kinematics {
            Kinematics::Differential | Kinematics::Omnidirectional { .. } => true,
            Kinematics::Car { .. } => false,
        };
        // The rest of the turn takes place on the spot. A round body always has room for it.
        let rest = Displacement::turn(if turns_on_the_spot {
            (1.0 - part) * motion.turn
        } else {
            0.0
        });
        let turned = self.free_part(rest, &clearance_at);
        self.truth.pose = rest.part(turned).end(self.truth.pose);
        let turns = turned == 1.0 && (turns_on_the_spot || part == 1.0);
        let turn = if turns {
            motion.turn
        } else {
            moved.turn + turned * rest.turn
        };
        self.truth.twist = Twist2 {
            linear: if self.truth.stalled { 0.0 } else { after.linear },
            lateral: if self.truth.stalled { 0.0 } else { after.lateral },
            angular: if turns { after.angular } else { 0.0 },
        };
        let rate = |before: f64, after: f64| (after - before) / dt;
        self.change = Twist2 {
            linear: rate(before.linear, self.truth.twist.linear),
            lateral: rate(before.lateral, self.truth.twist.lateral),
            angular: rate(before.angular, self.truth.twist.angular),
        };
        if self.truth.stalled {
            self.motors.resume(&self.config, self.truth.twist);
        }
        self.truth.travelled += moved.distance();
        self.odometer
            .roll(&self.config, [moved.ahead, moved.left], turn, dt, slip);
        self.head.step(&self.config.head, self.head_command, dt);
        self.battery
            .step(self.truth.twist, self.truth.stalled, self.supply, dt);
    }

    /// Returns where it was some seconds ago, at most those of its trail.
    pub(crate) fn pose_ago(&self, seconds: f64) -> Pose2 {
        self.trail.pose_ago(seconds, self.truth.pose)
    }

    /// Returns its body where it is.
    pub(crate) fn body(&self) -> RobotBody {
        self.config.footprint.at(self.truth.pose)
    }

    /// Updates the clearance and the contact, after all robots have moved.
    pub(crate) fn update_contact(&mut self, clearance: f64) {
        let truth = &mut self.truth;
        truth.clearance = clearance;
        truth.min_clearance = truth.min_clearance.min(clearance);
        let contact = clearance < if truth.contact { RELEASE } else { CONTACT };
        if contact && !truth.contact {
            truth.collisions += 1;
        }
        truth.contact = contact;
    }

    /// Pushes loose things out of the first `part` of a motion. Returns how much of it the body can make.
    fn push(
        &mut self,
        part: f64,
        motion: Displacement,
        dt: f64,
        mut make_room: impl FnMut(Pose2, f64) -> Option<f64>,
    ) -> f64 {
        self.load = 0.0;
        let distance = part * motion.distance();
        if distance == 0.0 {
            return part;
        }
        let (start, pieces) = (self.truth.pose, self.config.footprint.pieces(distance));
        let mut free = 0.0;
        for piece in 1..=pieces as u32 {
            let next = part * (f64::from(piece) / pieces);
            match make_room(motion.part(next).end(start), dt / pieces) {
                Some(load) => self.load = self.load.max(load),
                None => return free,
            }
            free = next;
        }
        part
    }

    /// Returns the part of a motion, from 0 to 1, that the body can make without entering anything.
    fn free_part(&self, motion: Displacement, clearance_at: &impl Fn(Pose2) -> f64) -> f64 {
        let start = self.truth.pose;
        let footprint = &self.config.footprint;
        let travel = footprint.travel(motion.distance(), motion.turn);
        // The gap shrinks by no more than the travel: far from everything one check is enough.
        if travel == 0.0 || clearance_at(start) > travel {
            return 1.0;
        }
        let at = |part: f64| clearance_at(motion.part(part).end(start));
        let pieces = footprint.pieces(travel);
        let mut free = 0.0;
        for piece in 1..=pieces as u32 {
            let next = f64::from(piece) / pieces;
            if at(next) < 0.0 {
                return halve(free, next, at);
            }
            free = next;
        }
        1.0
    }
}

impl Displacement {
    /// Creates a turn on the spot.
    fn turn(turn: f64) -> Self {
        Self {
            ahead: 0.0,
            left: 0.0,
            turn,
        }
    }

    /// Returns its first part, from 0 to 1.
    fn part(self, part: f64) -> Self {
        Self {
            ahead: part * self.ahead,
            left: part * self.left,
            turn: part * self.turn,
        }
    }

    /// Returns the distance in metres, whatever the direction.
    fn distance(self) -> f64 {
        libm::hypot(self.ahead, self.left)
    }

    /// Returns the pose after it.
    fn end(self, start: Pose2) -> Pose2 {
        start.along([self.ahead, self.left], self.turn)
    }
}

/// Returns the greatest part known to be free, by bisection between a free one and a blocked one.
fn halve(mut free: f64, mut blocked: f64, at: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..HALVINGS {
        let middle = (free + blocked) / 2.0;
        if at(middle) < 0.0 {
            blocked = middle;
        } else {
            free = middle;
        }
    }
    free
}
