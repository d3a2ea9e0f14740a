//! The guard of a footprint: no command takes effect after which the robot could not stop in time. It knows what
//! the laser sees and has seen; it does not know what is below or above the laser.

use jde_motion::{MAX_POINTS, Outline, ScanPoints, Surroundings};
use jde_schema::prelude::*;
use jde_schema::types::{self, Point2D};

use crate::memory::Memory;

/// Refuses commands after which the robot could not stop before it touches something.
///
/// What the laser has not seen counts as occupied, so a robot does not back into the unknown. It is free where
/// the robot stands, and in a circle around the place where it starts. A scan that measures nothing, a missing
/// or old scan or pose, and a pose that is not finite leave the guard without a state, and every command is refused.
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
    /// Where the laser is on the base, and which way its x points.
    #[modulation(default = Pose2D::ORIGIN, fixed)]
    mount: Modulation<Pose2D>,
    /// Distance to keep. What went out of sight is known to 3.5 cm, half the diagonal of a cell.
    #[modulation(default = 0.05, unit = "m", min = 0.0, max = 1.0)]
    margin: Modulation<f64>,
    /// How long a command is in force before the next judgement of it takes effect: the periods of the guard and
    /// of the driver, and the lag of the base.
    #[modulation(default = 0.15, unit = "s", min = 0.0, max = 10.0)]
    reaction: Modulation<f64>,
    /// Greatest growth of the speed of the base.
    #[modulation(default = 0.3, unit = "m/s2", min = 0.01)]
    acceleration: Modulation<f64>,
    /// Greatest decline of the speed of the base.
    #[modulation(default = 0.3, unit = "m/s2", min = 0.01)]
    deceleration: Modulation<f64>,
    /// Greatest growth of the turn rate of the base.
    #[modulation(default = 1.0, unit = "rad/s2", min = 0.01)]
    turn_acceleration: Modulation<f64>,
    /// Greatest decline of the turn rate of the base.
    #[modulation(default = 1.0, unit = "rad/s2", min = 0.01)]
    turn_deceleration: Modulation<f64>,
    /// How far points count: more than the base needs to stop.
    #[modulation(default = 3.0, unit = "m", min = 0.5, max = 10.0, fixed)]
    reach: Modulation<f64>,
    /// How old a scan and a pose may be.
    #[modulation(default = 0.5, unit = "s", min = 0.0, max = 3600.0)]
    stale: Modulation<f64>,
    /// The greatest part of its speed that a command loses before it is refused. With 0, it is refused as soon as the
    /// robot could not stop.
    #[modulation(default = 0.0, min = 0.0, max = 0.95)]
    slowdown: Modulation<f64>,
    /// What it judges by.
    #[export]
    surroundings: Export<Surroundings>,
    outline: Option<Outline>,
    memory: Option<Memory>,
    scan_points: ScanPoints,
    /// Why it has no state.
    lacks: Option<&'static str>,
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
    fn observe(&mut self, cx: &Context) -> Result<(), &'static str> {
        let (Some(outline), Some(memory)) = (&self.outline, &mut self.memory) else {
            return Err("not awake");
        };
        let laser = self.laser.get(cx).ok_or("no scan")?;
        let odometry = self.pose.get(cx).ok_or("no pose")?;
        let stale = Duration::from_secs_f64(self.stale.get(cx));
        let is_stale = |time: Duration| cx.now().saturating_sub(time) > stale;
        if is_stale(laser.time()) {
            return Err("the scan is too old");
        }
        if is_stale(odometry.time()) {
            return Err("the pose is too old");
        }
        let (robot, mount) = (odometry.pose2d(), self.mount.get(cx));
        if !robot.theta.is_finite() {
            return Err("the pose is not finite");
        }
        let margin = self.margin.get(cx);
        let sensor = robot.transform(&mount);
        self.scan_points
            .update(&laser, &mount)
            .map_err(|_| "the laser measures nothing")?;
        memory
            .observe(&robot, &sensor, &laser, (outline, margin), cx.now())
            .map_err(|_| "the pose is not finite")?;
        let mut around = self.surroundings.loan(cx);
        around.velocity = odometry.twist.twist;
        around.footprint = self.footprint.get(cx);
        around.margin = margin;
        around.reaction = self.reaction.get(cx);
        around.slowdown = self.slowdown.get(cx);
        around.acceleration = self.acceleration.get(cx);
        around.deceleration = self.deceleration.get(cx);
        around.turn_acceleration = self.turn_acceleration.get(cx);
        around.turn_deceleration = self.turn_deceleration.get(cx);
        around.points.clear();
        let reach = self.reach.get(cx);
        let seen = self.scan_points.as_slice().iter().copied();
        let mut points: Vec<Point2D> = seen.filter(|point| distance(point) <= reach).collect();
        points.extend(memory.boundary(&robot));
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
    pub(crate) fn lacks(&self) -> Option<&'static str> {
        self.lacks
    }

    /// The points of the newest scan, in the frame of the base.
    pub(crate) fn seen(&self) -> &[Point2D] {
        self.scan_points.as_slice()
    }

    /// The boundary of what is known to be free, in the frame of the base.
    pub(crate) fn boundary(&self, cx: &Context) -> Vec<Point2D> {
        let pose = self.pose.get(cx).map(|odometry| odometry.pose2d());
        match (&self.memory, pose) {
            (Some(memory), Some(robot)) => memory.boundary(&robot).collect(),
            (None, _) | (_, None) => Vec::new(),
        }
    }
}

fn distance(point: &Point2D) -> f64 {
    point.x.hypot(point.y)
}
