//! What an application has of sensors and motors, found by type, and what they say now. It draws nothing.

use jde_link::Rate;
use jde_link::message::VariableInfo;
use jde_types::{
    BatteryState, Bumpers, LaserScan, Mission, Odometry, PanTilt, Pose2D, RangeRing, Twist, Value,
    WheelEncoders,
};

use super::super::trail::Trail;
use super::reading::{Reading, read};
use crate::session::Session;

/// Senses for drawing come so often.
const LIVELY: Rate = Rate::Hz(20);
/// Numbers come so often: nobody reads faster.
const CALM: Rate = Rate::Hz(5);

/// What a person chose among several.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub(super) struct Choice {
    /// The schema that drives the wheels.
    pub(super) body: Option<String>,
    /// The laser, as a variable.
    pub(super) laser: Option<String>,
}

/// What there is to choose from.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    /// Variables that are lasers of the chosen one.
    pub(super) lasers: Vec<String>,
}

/// What the robot senses now.
#[derive(Debug, Default)]
pub(super) struct Sensors {
    /// The schema that drives the wheels; empty for none.
    pub(super) body: String,
    /// All schemas that do.
    pub(super) bodies: Vec<String>,
    /// What is known of its outline.
    pub(super) outline: Outline,
    pub(super) odometry: Reading<Odometry>,
    pub(super) laser: Reading<Box<LaserScan>>,
    pub(super) sonars: Reading<RangeRing>,
    pub(super) bumpers: Reading<Bumpers>,
    pub(super) battery: Reading<BatteryState>,
    pub(super) encoders: Reading<WheelEncoders>,
    pub(super) head: Reading<PanTilt>,
    /// What the base was told last, as long as it is in force.
    pub(super) commanded: Reading<Twist>,
    /// Where the mission goes.
    pub(super) target: Option<Pose2D>,
    /// Where it has been.
    pub(super) trail: Trail,
    /// Cameras, as variables.
    pub(super) cameras: Vec<String>,
}

/// What is known of a robot's outline.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Outline {
    /// Nothing: a mark for where it is.
    #[default]
    Unknown,
    /// A Pioneer, by the type of its driver.
    Pioneer,
    /// A simulated Pioneer, whose body is round; its radius, m.
    Round(f64),
}

impl Sensors {
    /// Takes up what came since the last frame; keeps the path.
    pub(super) fn update(&mut self, session: &Session, choice: &Choice) -> Candidates {
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
        let odometry = one::<Odometry>(session, body, &bodies);
        self.outline = outline(session, body);
        self.odometry = read(session, odometry, LIVELY);
        self.laser = boxed(read(session, laser, LIVELY));
        self.sonars = read(session, one::<RangeRing>(session, body, &bodies), LIVELY);
        self.bumpers = read(session, one::<Bumpers>(session, body, &bodies), LIVELY);
        self.battery = read(session, one::<BatteryState>(session, body, &bodies), CALM);
        self.encoders = read(session, one::<WheelEncoders>(session, body, &bodies), CALM);
        self.head = read(session, one::<PanTilt>(session, body, &bodies), LIVELY);
        self.commanded = commanded(session, body);
        let mission = session.exports::<Mission>().next();
        let mission: Reading<Mission> = read(session, mission, CALM);
        self.target = mission
            .value()
            .filter(|mission| mission.state == Mission::RUNNING && mission.total > 0)
            .map(|mission| mission.target);
        if let Some(odometry) = odometry {
            self.trail.of(&odometry.name);
            for sample in session.values(&odometry.name, LIVELY, "path of the robot window") {
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

    /// Where it believes it is; the origin if it does not tell.
    pub(super) fn pose(&self) -> Pose2D {
        self.odometry.value().map_or(Pose2D::ORIGIN, Odometry::pose2d)
    }
}

/// Whether a sensor may be of this body: it is not of another.
fn belongs(variable: &VariableInfo, body: &str, bodies: &[String]) -> bool {
    variable.owner == body || !bodies.contains(&variable.owner)
}

/// The export of a type that is the body's own, or else the first that is of no other body.
fn one<'a, T: Value>(session: &'a Session, body: &str, bodies: &[String]) -> Option<&'a VariableInfo> {
    let mut all = session
        .exports::<T>()
        .filter(|variable| belongs(variable, body, bodies));
    let first = all.next()?;
    if first.owner == body {
        return Some(first);
    }
    all.find(|variable| variable.owner == body).or(Some(first))
}

/// What the base is told.
fn commanded(session: &Session, body: &str) -> Reading<Twist> {
    let twist = Twist::describe().name;
    let command = session.variables().iter().find(|variable| {
        variable.access == "command" && variable.owner == body && variable.type_name == twist
    });
    let told = super::reading::sampled(session, command, LIVELY);
    // When it is over the driver is given the neutral value, which nobody sends.
    if let Reading::Here(sample, _) = &told
        && (sample.valid_until as f64 / 1e9) < session.now()
    {
        return Reading::Absent;
    }
    read(session, command, LIVELY)
}

fn outline(session: &Session, body: &str) -> Outline {
    let Some(schema) = session.schema(body) else {
        return Outline::Unknown;
    };
    if !schema.type_name.ends_with("/pioneer") {
        return Outline::Unknown;
    }
    let radius = schema
        .ports
        .iter()
        .any(|port| port.role == "modulation" && port.name == "radius" && port.unit == "m");
    if !radius {
        return Outline::Pioneer;
    }
    match session.read::<f64>(&format!("{body}.radius"), Rate::Hz(1)) {
        Some((radius, _)) => Outline::Round(radius),
        None => Outline::Pioneer,
    }
}

fn boxed<T>(reading: Reading<T>) -> Reading<Box<T>> {
    match reading {
        Reading::Absent => Reading::Absent,
        Reading::None(name, why) => Reading::None(name, why),
        Reading::Here(value, fresh) => Reading::Here(Box::new(value), fresh),
    }
}
