//! The sensors and motors of an application, found by type, and their newest values. It draws nothing.

use jde_link::Rate;
use jde_link::message::VariableInfo;
use jde_timeline::outline;
use jde_types::{
    BatteryState, Bumpers, Imu, LaserScan, LineSensor, Mission, Odometry, PanTilt, Pose2D, PositionFix,
    RangeRing, Twist, Value, WheelEncoders,
};

use super::super::trail::Trail;
use super::reading::{VariableState, read};
use crate::session::WindowSession;

/// Rate of values that are drawn.
const DRAWN_RATE: Rate = Rate::Hz(20);
/// Rate of numbers: as fast as a person can read them.
const NUMBER_RATE: Rate = Rate::Hz(5);

/// The user's choice among several robots and lasers.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub(super) struct RobotChoice {
    /// The schema that drives the wheels.
    pub(super) body: Option<String>,
    /// The laser's variable.
    pub(super) laser: Option<String>,
}

/// The choices that the user has.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    /// The laser variables of the chosen robot.
    pub(super) lasers: Vec<String>,
}

/// The newest sensor data of the robot.
#[derive(Debug, Default)]
pub(super) struct Sensors {
    /// The schema that drives the wheels; empty if there is none.
    pub(super) body: String,
    /// All schemas that drive wheels.
    pub(super) bodies: Vec<String>,
    /// The corners of the robot, in its own frame.
    pub(super) outline: Vec<[f64; 2]>,
    /// Where the laser is on the robot.
    pub(super) mount: Pose2D,
    pub(super) odometry: VariableState<Odometry>,
    pub(super) laser: VariableState<Box<LaserScan>>,
    pub(super) sonars: VariableState<RangeRing>,
    pub(super) bumpers: VariableState<Bumpers>,
    pub(super) line: VariableState<LineSensor>,
    pub(super) imu: VariableState<Imu>,
    pub(super) position: VariableState<PositionFix>,
    pub(super) battery: VariableState<BatteryState>,
    pub(super) encoders: VariableState<WheelEncoders>,
    pub(super) head: VariableState<PanTilt>,
    /// The last command to the base, while it is in force.
    pub(super) commanded: VariableState<Twist>,
    /// The current target of a running mission.
    pub(super) target: Option<Pose2D>,
    /// The path that the robot has driven.
    pub(super) trail: Trail,
    /// The camera variables.
    pub(super) cameras: Vec<String>,
}

impl Sensors {
    /// Reads the newest values, and extends the path. Call in each frame. Returns the user's choices.
    pub(super) fn update(&mut self, session: &WindowSession, choice: &RobotChoice) -> Candidates {
        let bodies: Vec<String> = session
            .exports::<Odometry>()
            .map(|variable| variable.owner.clone())
            .collect();
        let chosen = choice.body.as_ref().filter(|body| bodies.contains(body));
        self.body = chosen.or(bodies.first()).cloned().unwrap_or_default();
        let body = self.body.as_str();
        let lasers: Vec<&VariableInfo> = session
            .exports::<LaserScan>()
            .filter(|variable| belongs(variable, body, &bodies))
            .collect();
        let laser = lasers
            .iter()
            .find(|laser| Some(&laser.name) == choice.laser.as_ref())
            .or_else(|| lasers.iter().find(|laser| laser.owner == body))
            .or(lasers.first())
            .copied();
        let odometry = sensor::<Odometry>(session, body, &bodies);
        let shape = session.body(body);
        self.outline = outline(shape.as_ref());
        self.odometry = read(session, odometry, DRAWN_RATE);
        self.laser = boxed(read(session, laser, DRAWN_RATE));
        let frame = self
            .laser
            .value()
            .map_or("", |scan| scan.header.frame_id.as_str());
        self.mount = shape.map_or(Pose2D::ORIGIN, |body| body.laser(frame));
        self.sonars = read(session, sensor::<RangeRing>(session, body, &bodies), DRAWN_RATE);
        self.bumpers = read(session, sensor::<Bumpers>(session, body, &bodies), DRAWN_RATE);
        self.line = read(session, sensor::<LineSensor>(session, body, &bodies), DRAWN_RATE);
        self.imu = read(session, sensor::<Imu>(session, body, &bodies), NUMBER_RATE);
        self.position = read(session, sensor::<PositionFix>(session, body, &bodies), DRAWN_RATE);
        self.battery = read(
            session,
            sensor::<BatteryState>(session, body, &bodies),
            NUMBER_RATE,
        );
        self.encoders = read(
            session,
            sensor::<WheelEncoders>(session, body, &bodies),
            NUMBER_RATE,
        );
        self.head = read(session, sensor::<PanTilt>(session, body, &bodies), DRAWN_RATE);
        self.commanded = commanded(session, body);
        let mission = session.exports::<Mission>().next();
        let mission: VariableState<Mission> = read(session, mission, NUMBER_RATE);
        self.target = mission
            .value()
            .filter(|mission| mission.state == Mission::RUNNING && mission.total > 0)
            .map(|mission| mission.target);
        if let Some(odometry) = odometry {
            self.trail.of(&odometry.name);
            for sample in session.values(&odometry.name, DRAWN_RATE, "path of the robot window") {
                let pose = sample.bytes.as_deref().and_then(Odometry::from_bytes);
                if let Some(odometry) = pose {
                    let pose = odometry.pose2d();
                    self.trail.add(sample.time, [pose.x, pose.y]);
                }
            }
        }
        self.cameras = session
            .exports::<jde_types::Image>()
            .filter(|variable| belongs(variable, body, &bodies))
            .map(|variable| variable.name.clone())
            .collect();
        self.bodies = bodies;
        Candidates {
            lasers: lasers.iter().map(|laser| laser.name.clone()).collect(),
        }
    }

    /// The pose by odometry, or the origin without odometry.
    pub(super) fn pose(&self) -> Pose2D {
        self.odometry.value().map_or(Pose2D::ORIGIN, Odometry::pose2d)
    }
}

/// Whether a sensor may belong to a body: it does not belong to another one.
fn belongs(variable: &VariableInfo, body: &str, bodies: &[String]) -> bool {
    variable.owner == body || !bodies.contains(&variable.owner)
}

/// The export of a type that belongs to the body, or else the first that belongs to no other body.
fn sensor<'a, T: Value>(
    session: &'a WindowSession,
    body: &str,
    bodies: &[String],
) -> Option<&'a VariableInfo> {
    let mut all = session
        .exports::<T>()
        .filter(|variable| belongs(variable, body, bodies));
    let first = all.next()?;
    if first.owner == body {
        return Some(first);
    }
    all.find(|variable| variable.owner == body).or(Some(first))
}

/// The command to the base that is in force.
fn commanded(session: &WindowSession, body: &str) -> VariableState<Twist> {
    let twist = Twist::describe().name;
    let command = session.variables().iter().find(|variable| {
        variable.access == "command" && variable.owner == body && variable.type_name == twist
    });
    let sample = super::reading::sampled(session, command, DRAWN_RATE);
    // An expired command is not in force: the driver takes the neutral value, which no schema sends.
    if let VariableState::Present(newest, _) = &sample
        && (newest.valid_until as f64 / 1e9) < session.now()
    {
        return VariableState::Absent;
    }
    read(session, command, DRAWN_RATE)
}

fn boxed<T>(reading: VariableState<T>) -> VariableState<Box<T>> {
    match reading {
        VariableState::Absent => VariableState::Absent,
        VariableState::None(name, reason) => VariableState::None(name, reason),
        VariableState::Present(value, fresh) => VariableState::Present(Box::new(value), fresh),
    }
}
