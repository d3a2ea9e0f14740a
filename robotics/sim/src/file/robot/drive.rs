//! The drive and the odometry of a robot file.

use super::super::document::{Document, Item, Table};
use super::super::nearest;
use super::super::values::{self, Read, between};
use super::{degrees, section};
use crate::config::RobotConfig;
use crate::drive::Kinematics;

const KEYS: [&str; 6] = [
    "kinematics",
    "max_speed",
    "acceleration",
    "deceleration",
    "lag",
    "max_push",
];
const TURN_KEYS: [&str; 3] = ["max_turn_deg", "turn_acceleration_deg", "turn_deceleration_deg"];
const LATERAL_KEYS: [&str; 2] = ["max_lateral_speed", "lateral_acceleration"];
const CAR_KEYS: [&str; 3] = ["wheelbase", "max_steering_deg", "steering_rate_deg"];
const ODOMETRY_KEYS: [&str; 4] = ["track", "ticks_per_mm", "wheel_error", "slip"];

/// Least and greatest acceleration: far beyond any motor's, so that a file can say that there is no limit.
const ACCELERATION: (f64, f64) = (1e-3, 1e5);

/// The kinematics, without their numbers.
#[derive(Clone, Copy)]
enum Kind {
    Differential,
    Omnidirectional,
    Car,
}

const KINDS: [(&str, Kind); 3] = [
    ("differential", Kind::Differential),
    ("omnidirectional", Kind::Omnidirectional),
    ("car", Kind::Car),
];

/// Reads the drive, on the wheels of the odometry.
pub(super) fn read(
    document: &Document<'_>,
    root: &Table<'_>,
    wheels: Option<RobotConfig>,
) -> Option<RobotConfig> {
    // The kinematics decides which keys are known.
    let kind = root
        .get("drive")
        .and_then(|item| item.get_ref().get("kinematics"))
        .and_then(|item| self::kind(item).ok());
    let table = section(document, root, "drive", &known(kind))?;
    let acceleration = between(ACCELERATION.0, ACCELERATION.1, "m/s²");
    let max_linear = table.required("max_speed", between(0.01, 20.0, "m/s"));
    let gain = table.required("acceleration", acceleration);
    let loss = table.optional("deceleration", gain.unwrap_or(1.0), acceleration);
    let lag = table.optional("lag", 0.0, between(0.0, 10.0, "s"));
    let max_push = RobotConfig::default().max_push;
    let max_push = table.optional("max_push", max_push, between(0.01, 1e4, "kg"));
    let kind = table.required("kinematics", self::kind)?;
    let kinematics = kinematics(&table, kind);
    let config = match kind {
        Kind::Differential | Kind::Omnidirectional => turns(&table, wheels),
        Kind::Car => wheels,
    };
    Some(RobotConfig {
        kinematics: kinematics?,
        max_linear: max_linear?,
        linear_acceleration: gain?,
        linear_deceleration: loss?,
        lag: lag?,
        max_push: max_push?,
        ..config?
    })
}

/// Reads the odometry into the default robot.
pub(super) fn odometry(document: &Document<'_>, root: &Table<'_>) -> Option<RobotConfig> {
    let table = section(document, root, "odometry", &ODOMETRY_KEYS)?;
    let default = RobotConfig::default();
    let track = table.required("track", between(0.01, 10.0, "m"));
    let ticks = table.required("ticks_per_mm", between(1e-3, 1e6, "ticks"));
    let scale = table.optional("wheel_error", default.wheel_scale_sigma, between(0.0, 0.5, ""));
    let slip = table.optional("slip", default.slip_sigma, between(0.0, 1.0, "m"));
    Some(RobotConfig {
        track: track?,
        ticks_per_meter: ticks? * 1000.0,
        wheel_scale_sigma: scale?,
        slip_sigma: slip?,
        ..default
    })
}

/// Returns the keys of a kinematics; all for one that is not known, which is fault enough.
fn known(kind: Option<Kind>) -> Vec<&'static str> {
    match kind {
        Some(Kind::Differential) => [&KEYS[..], &TURN_KEYS].concat(),
        Some(Kind::Omnidirectional) => [&KEYS[..], &TURN_KEYS, &LATERAL_KEYS].concat(),
        Some(Kind::Car) => [&KEYS[..], &CAR_KEYS].concat(),
        None => [&KEYS[..], &TURN_KEYS, &LATERAL_KEYS, &CAR_KEYS].concat(),
    }
}

fn kind(item: &Item<'_>) -> Read<Kind> {
    let text = values::text(item)?;
    let found = KINDS.into_iter().find(|(name, _)| *name == text);
    found.map(|(_, kind)| kind).ok_or_else(|| {
        let names = KINDS.map(|(name, _)| name);
        let known = match nearest(&text, names.into_iter()) {
            Some(name) => format!("did you mean `{name}`?"),
            None => format!("expected one of `{}`", names.join("`, `")),
        };
        (item.span(), format!("is `{text}`: {known}"))
    })
}

fn kinematics(table: &Table<'_>, kind: Kind) -> Option<Kinematics> {
    let angle = |key, high, unit| table.required(key, degrees(1.0, high, unit));
    match kind {
        Kind::Differential => Some(Kinematics::Differential),
        Kind::Omnidirectional => {
            let max_lateral = table.required("max_lateral_speed", between(0.01, 20.0, "m/s"));
            let acceleration = between(ACCELERATION.0, ACCELERATION.1, "m/s²");
            let lateral_acceleration = table.required("lateral_acceleration", acceleration);
            Some(Kinematics::Omnidirectional {
                max_lateral: max_lateral?,
                lateral_acceleration: lateral_acceleration?,
            })
        }
        Kind::Car => {
            let wheelbase = table.required("wheelbase", between(0.01, 10.0, "m"));
            let max_steering = angle("max_steering_deg", 80.0, "degrees");
            let steering_rate = angle("steering_rate_deg", ACCELERATION.1, "degrees/s");
            Some(Kinematics::Car {
                wheelbase: wheelbase?,
                max_steering: max_steering?,
                steering_rate: steering_rate?,
            })
        }
    }
}

/// Reads the limits of the turn rate.
fn turns(table: &Table<'_>, wheels: Option<RobotConfig>) -> Option<RobotConfig> {
    let acceleration = || degrees(1.0, ACCELERATION.1, "degrees/s²");
    let max_angular = table.required("max_turn_deg", degrees(1.0, 5000.0, "degrees/s"));
    let gain = table.required("turn_acceleration_deg", acceleration());
    let loss = table.optional("turn_deceleration_deg", gain.unwrap_or(1.0), acceleration());
    Some(RobotConfig {
        max_angular: max_angular?,
        angular_acceleration: gain?,
        angular_deceleration: loss?,
        ..wheels?
    })
}
