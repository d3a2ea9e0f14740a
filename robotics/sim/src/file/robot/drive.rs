//! The drive and the odometry of a robot file.

use super::super::values::{self, between};
use super::sensors::{DELIVERY_KEYS, delivery};
use super::{degrees, section};
use crate::config::RobotConfig;
use crate::drive::Kinematics;
use crate::sensor::Delivery;
use jde_document::{Checked, FaultReport, Node, Section};

const KEYS: [&str; 7] = [
    "kinematics",
    "max_speed",
    "acceleration",
    "deceleration",
    "lag",
    "dead_band",
    "max_push",
];
const TURN_KEYS: [&str; 5] = [
    "max_turn_deg",
    "turn_acceleration_deg",
    "turn_deceleration_deg",
    "turn_dead_band_deg",
    "skid",
];
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
    report: &mut FaultReport<'_>,
    root: &Section<'_>,
    wheels: Option<RobotConfig>,
) -> Option<RobotConfig> {
    // The kinematics decides which keys are known.
    let kind = root
        .get("drive")
        .and_then(|node| node.get_ref().get("kinematics"))
        .and_then(|node| self::kind(node).ok());
    let table = section(report, root, "drive", &known(kind))?;
    let acceleration = between(ACCELERATION.0, ACCELERATION.1, "m/s²");
    let max_linear = table.required(report, "max_speed", between(0.01, 20.0, "m/s"));
    let gain = table.required(report, "acceleration", acceleration);
    let loss = table.optional(report, "deceleration", gain.unwrap_or(1.0), acceleration);
    let lag = table.optional(report, "lag", 0.0, between(0.0, 10.0, "s"));
    let dead_band = table.optional(report, "dead_band", 0.0, between(0.0, 1.0, "m/s"));
    let max_push = RobotConfig::default().max_push;
    let max_push = table.optional(report, "max_push", max_push, between(0.01, 1e4, "kg"));
    let kind = table.required(report, "kinematics", self::kind)?;
    let kinematics = kinematics(report, &table, kind);
    let config = match kind {
        Kind::Differential | Kind::Omnidirectional => turns(report, &table, wheels),
        Kind::Car => wheels,
    };
    Some(RobotConfig {
        kinematics: kinematics?,
        max_linear: max_linear?,
        linear_acceleration: gain?,
        linear_deceleration: loss?,
        lag: lag?,
        dead_band: dead_band?,
        max_push: max_push?,
        ..config?
    })
}

/// Reads the odometry into the default robot, and how its measurements arrive.
pub(super) fn odometry(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<(RobotConfig, Delivery)> {
    let keys = [&ODOMETRY_KEYS[..], &DELIVERY_KEYS].concat();
    let table = section(report, root, "odometry", &keys)?;
    let delivery = delivery(report, &table);
    let default = RobotConfig::default();
    let track = table.required(report, "track", between(0.01, 10.0, "m"));
    let ticks = table.required(report, "ticks_per_mm", between(1e-3, 1e6, "ticks"));
    let scale = table.optional(
        report,
        "wheel_error",
        default.wheel_scale_sigma,
        between(0.0, 0.5, ""),
    );
    let slip = table.optional(report, "slip", default.slip_sigma, between(0.0, 1.0, "m"));
    let config = RobotConfig {
        track: track?,
        ticks_per_meter: ticks? * 1000.0,
        wheel_scale_sigma: scale?,
        slip_sigma: slip?,
        ..default
    };
    Some((config, delivery?))
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

fn kind(node: &Node<'_>) -> Checked<Kind> {
    values::one_of(node, "a kinematics", &KINDS)
}

fn kinematics(report: &mut FaultReport<'_>, table: &Section<'_>, kind: Kind) -> Option<Kinematics> {
    match kind {
        Kind::Differential => Some(Kinematics::Differential),
        Kind::Omnidirectional => {
            let max_lateral = table.required(report, "max_lateral_speed", between(0.01, 20.0, "m/s"));
            let acceleration = between(ACCELERATION.0, ACCELERATION.1, "m/s²");
            let lateral_acceleration = table.required(report, "lateral_acceleration", acceleration);
            Some(Kinematics::Omnidirectional {
                max_lateral: max_lateral?,
                lateral_acceleration: lateral_acceleration?,
            })
        }
        Kind::Car => {
            let wheelbase = table.required(report, "wheelbase", between(0.01, 10.0, "m"));
            let max_steering = table.required(report, "max_steering_deg", degrees(1.0, 80.0, "degrees"));
            let steering_rate = table.required(
                report,
                "steering_rate_deg",
                degrees(1.0, ACCELERATION.1, "degrees/s"),
            );
            Some(Kinematics::Car {
                wheelbase: wheelbase?,
                max_steering: max_steering?,
                steering_rate: steering_rate?,
            })
        }
    }
}

/// Reads the limits of the turn rate.
fn turns(
    report: &mut FaultReport<'_>,
    table: &Section<'_>,
    wheels: Option<RobotConfig>,
) -> Option<RobotConfig> {
    let acceleration = || degrees(1.0, ACCELERATION.1, "degrees/s²");
    let max_angular = table.required(report, "max_turn_deg", degrees(1.0, 5000.0, "degrees/s"));
    let gain = table.required(report, "turn_acceleration_deg", acceleration());
    let loss = table.optional(
        report,
        "turn_deceleration_deg",
        gain.unwrap_or(1.0),
        acceleration(),
    );
    let band = table.optional(
        report,
        "turn_dead_band_deg",
        0.0,
        degrees(0.0, 500.0, "degrees/s"),
    );
    let skid = table.optional(report, "skid", 0.0, between(0.0, 0.9, ""));
    Some(RobotConfig {
        turn_dead_band: band?,
        skid: skid?,
        max_angular: max_angular?,
        angular_acceleration: gain?,
        angular_deceleration: loss?,
        ..wheels?
    })
}
