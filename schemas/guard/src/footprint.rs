//! The guard of a footprint: no command takes effect after which the robot could not stop in time. It knows what
//! the laser sees and has seen; it does not know what is below or above the laser.

use jde_motion::{
    BaseDynamics, MAX_POINTS, Momentum, Motors, OdometryHistory, Outline, ScanPoints, Surroundings,
};
use jde_schema::prelude::*;
use jde_schema::types::{self, Point2D};

use crate::memory::Memory;

/// Refuses commands after which the robot could not stop before it touches something.
///
/// A place that the laser has not seen counts as occupied, so a robot does not back into the unknown. The place of
/// the robot is free, and so is a circle around the place where it starts. A scan without a measurement, a missing or
/// old scan or pose, and a pose that is not finite leave the guard without a state, and every command is refused.
/// With `slowdown` it limits a command to a part of its speed with which the robot can stop, if there is one.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "20ms")]
pub struct Footprint {
    /// The scan of the laser. It judges by each at once.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// The estimated pose and velocity of the robot.
    #[import]
    pose: Import<Odometry>,
    /// The outline of the robot.
    #[modulation(default = types::Footprint::circle(0.25), fixed)]
    footprint: Modulation<types::Footprint>,
    /// The pose of the laser on the base.
    #[modulation(default = Pose2D::ORIGIN, fixed, mount)]
    mount: Modulation<Pose2D>,
    /// Distance to keep, less than that of each schema that it judges, or both dispute the last centimetre. The place of an
    /// obstacle that went out of sight is known to 3.5 cm, half the diagonal of a cell.
    #[modulation(default = 0.05, unit = "m", min = 0.0, max = 1.0, margin)]
    margin: Modulation<f64>,
    /// Time for which a command is in force before the next judgement of it takes effect: the periods of the guard
    /// and of the driver, and the dead time of the base.
    #[modulation(default = 0.15, unit = "s", min = 0.0, max = 10.0)]
    reaction: Modulation<f64>,
    /// Greatest growth of the speed of the base.
    #[modulation(default = 0.3, unit = "m/s2", min = 0.01)]
    acceleration: Modulation<f64>,
    /// Greatest decline of the speed of the base.
    #[modulation(default = 0.3, unit = "m/s2", min = 0.01, limit)]
    deceleration: Modulation<f64>,
    /// Greatest growth of the turn rate of the base.
    #[modulation(default = 1.0, unit = "rad/s2", min = 0.01)]
    turn_acceleration: Modulation<f64>,
    /// Greatest decline of the turn rate of the base.
    #[modulation(default = 1.0, unit = "rad/s2", min = 0.01, limit)]
    turn_deceleration: Modulation<f64>,
    /// Time constant by which the speeds of the base follow a command.
    #[modulation(default = 0.0, unit = "s", min = 0.0, max = 2.0)]
    lag: Modulation<f64>,
    /// How the base follows its commands, from its driver. The numbers that it knows count instead of `acceleration`,
    /// `deceleration`, `turn_acceleration`, `turn_deceleration` and `lag`.
    #[import(optional)]
    dynamics: Import<BaseDynamics>,
    /// What the driver leads the base to at present. Without it, it is estimated from the odometry.
    #[import(optional)]
    setpoint: Import<Twist>,
    /// Greatest range at which points count: more than the base needs to stop.
    #[modulation(default = 3.0, unit = "m", min = 0.5, max = 10.0, fixed)]
    reach: Modulation<f64>,
    /// Whether a place that the laser has not seen counts as free: for a laser that measures nothing where nothing is within its
    /// range. What is below, above or beside its view is not seen then, and the robot drives there.
    #[modulation(default = false)]
    allow_unknown: Modulation<bool>,
    /// Greatest age of a scan and of a pose. Above 1 s a scan is too old in any case.
    #[modulation(default = 0.5, unit = "s", min = 0.0, max = 3600.0)]
    stale: Modulation<f64>,
    /// The greatest part of its speed that a command loses before it is refused. With 0, it is refused as soon as the
    /// robot could not stop.
    #[modulation(default = 0.0, min = 0.0, max = 0.95)]
    slowdown: Modulation<f64>,
    /// The state by which it judges.
    #[export]
    surroundings: Export<Surroundings>,
    outline: Option<Outline>,
    memory: Option<Memory>,
    history: OdometryHistory,
    scan_points: ScanPoints,
    momentum: Momentum,
    /// Why it has no state.
    lacks: Option<String>,
}

impl Schema for Footprint {
    fn awake(&mut self, cx: &Context) -> Result {
        self.outline = Some(Outline::try_from(&self.footprint.get(cx))?);
        self.memory = Some(Memory::new(self.reach.get(cx))?);
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.lacks = self.observe(cx).err();
        if self.lacks.is_some() {
            self.surroundings.retract(cx);
        }
        Ok(())
    }
}

impl Guard for Footprint {
    type State = Surroundings;
    type Command = Twist;
    const STATE_EXPORT: &'static str = "surroundings";

    fn judge(state: &Surroundings, age: Duration, command: &Twist) -> Result<(), String> {
        state.judge(age, command)
    }

    fn limit(state: &Surroundings, age: Duration, command: &Twist) -> Option<Twist> {
        state.limit(age, command)
    }
}

impl Inspect for Footprint {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.footprint, Outline::try_from(&self.footprint.get(cx)));
    }
}

impl Footprint {
    /// Exports what is around the robot.
    ///
    /// # Errors
    /// What is missing.
    fn observe(&mut self, cx: &Context) -> Result<(), String> {
        let (Some(outline), Some(memory)) = (&self.outline, &mut self.memory) else {
            return Err("not awake".into());
        };
        let laser = self.laser.get(cx).ok_or("no scan")?;
        let odometry = self.pose.get(cx).ok_or("no pose")?;
        let stale = Duration::from_secs_f64(self.stale.get(cx));
        let is_stale = |time: Duration| cx.now().saturating_sub(time) > stale;
        if is_stale(odometry.time()) {
            return Err("the pose is too old".into());
        }
        let (robot, mount) = (odometry.pose2d(), self.mount.get(cx));
        if !robot.theta.is_finite() {
            return Err("the pose is not finite".into());
        }
        let margin = self.margin.get(cx);
        self.history.add(odometry.time(), &odometry);
        let sweep = self.history.sweep(&laser, laser.time(), cx.now())?;
        // A laser that turns slowly is not late: the next scan is a turn away from the newest beam.
        if is_stale(sweep.ended()) {
            return Err("the scan is too old".into());
        }
        self.scan_points
            .update(&laser, sweep.seen_from(&robot, &mount))
            .map_err(|_| "the laser measures nothing")?;
        let sensor = sweep.middle().transform(&mount);
        memory
            .observe(
                &robot,
                (outline, margin),
                (laser.sequence(), laser.time()),
                self.history.jumps(),
                || (sensor, sweep.rays(&laser, &mount)),
            )
            .map_err(|_| "the pose is not finite")?;
        let stated = BaseDynamics {
            acceleration: self.acceleration.get(cx),
            deceleration: self.deceleration.get(cx),
            turn_acceleration: self.turn_acceleration.get(cx),
            turn_deceleration: self.turn_deceleration.get(cx),
            lag: self.lag.get(cx),
        };
        let dynamics = match self.dynamics.get(cx) {
            Some(known) => known.or(&stated),
            None if self.dynamics.is_bound(cx) => return Err("the dynamics of the base are unknown".into()),
            None => stated,
        };
        if let Err(error) = dynamics.check() {
            let error = error.to_string();
            if self.lacks.as_ref() != Some(&error) {
                warn!(cx, "{error}");
            }
            return Err(error);
        }
        let setpoint = self.setpoint.get(cx);
        let motors = Motors::new(dynamics, setpoint.map(|setpoint| (*setpoint, setpoint.age(cx))));
        // Not by its header: that of ROS may have no time.
        let moves = self.momentum.update(odometry.time(), &odometry.twist, &motors);
        let mut around = self.surroundings.loan(cx);
        around.velocity = moves.velocity;
        around.footprint = self.footprint.get(cx);
        around.margin = margin;
        around.reaction = self.reaction.get(cx);
        around.slowdown = self.slowdown.get(cx);
        around.lead = moves.lead;
        around.dynamics = dynamics;
        around.points.clear();
        let reach = self.reach.get(cx);
        let seen = self.scan_points.as_slice().iter().copied();
        let mut points: Vec<Point2D> = seen.filter(|point| distance(point) <= reach).collect();
        points.extend(memory.obstacles(&robot, self.allow_unknown.get(cx), cx.now()));
        if points.len() > MAX_POINTS {
            // The nearest ones decide.
            points.select_nth_unstable_by(MAX_POINTS, |a, b| distance(a).total_cmp(&distance(b)));
            points.truncate(MAX_POINTS);
        }
        around.points.resize(points.len()).copy_from_slice(&points);
        around.publish();
        Ok(())
    }

    /// What the guard judges by; `None` if it refuses everything.
    pub(crate) fn lacks(&self) -> Option<&str> {
        self.lacks.as_deref()
    }

    /// The points of the newest scan, in the frame of the base.
    pub(crate) fn seen(&self) -> &[Point2D] {
        self.scan_points.as_slice()
    }

    /// What it takes for obstacles beside the newest scan, in the frame of the base.
    pub(crate) fn remembered(&self, cx: &Context) -> Vec<Point2D> {
        let pose = self.pose.get(cx).map(|odometry| odometry.pose2d());
        match (&self.memory, pose) {
            (Some(memory), Some(robot)) => memory.obstacles(&robot, self.allow_unknown.get(cx), cx.now()),
            (None, _) | (_, None) => Vec::new(),
        }
    }
}

fn distance(point: &Point2D) -> f64 {
    libm::hypot(point.x, point.y)
}
