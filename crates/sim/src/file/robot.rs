//! Robot files: TOML with the footprint, the drive, the odometry and the sensors of a robot, in metres,
//! degrees and seconds.
//!
//! The faults of a file are reported together. The reader ignores nothing.

use std::path::Path;
use std::time::Duration;

use super::document::{Document, Item, Table};
use super::fixtures::each;
use super::values::{self, Read, between};
use super::{parse, starts};
use crate::config::{OdometryOrigin, RobotConfig};
use crate::drive::Kinematics;
use crate::error::Fault;
use crate::footprint::{Footprint, Polygon};
use crate::geometry::Pose2;
use crate::head::HeadConfig;
use crate::model::{LaserModel, RobotModel, SonarModel};
use crate::sensor::{LaserConfig, SonarConfig};

const KEYS: [&str; 10] = [
    "name",
    "doc",
    "footprint",
    "drive",
    "odometry",
    "lasers",
    "sonars",
    "bumpers",
    "head",
    "battery",
];
const DRIVE_KEYS: [&str; 6] = [
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
const RANGE_KEYS: [&str; 4] = ["range_min", "range_max", "noise", "rate"];
const HEAD_KEYS: [&str; 6] = [
    "mount",
    "max_pan_deg",
    "max_tilt_down_deg",
    "max_tilt_up_deg",
    "pan_rate_deg",
    "tilt_rate_deg",
];

/// The limits of a motor's accelerations: far above any, so that a file can say that there is no limit.
const ACCELERATION: (f64, f64) = (1e-3, 1e5);
const MAX_BEAMS: f64 = 1e5;

pub(crate) fn read(text: &str, path: &Path) -> Result<RobotModel, Vec<Fault>> {
    parse(text, path, "robot", &KEYS, robot)
}

/// Reads all parts before it returns, so that every fault is reported.
fn robot(document: &Document<'_>, root: &Table<'_>) -> Option<RobotModel> {
    let stem = document.path().file_stem().unwrap_or_default();
    let name = root.optional("name", stem.to_string_lossy().into_owned(), values::text);
    let doc = root.optional("doc", String::new(), values::text);
    let footprint =
        section(document, root, "footprint", &["radius", "polygon"]).and_then(|table| footprint(&table));
    let drive = drive(document, root);
    let odometry = odometry(document, root);
    let lasers = lasers(document, root);
    let sonars = sonars(document, root);
    let bumpers = root.optional("bumpers", false, values::flag);
    let battery = root.optional("battery", false, values::flag);
    let head = head(document, root);
    let head = head?;
    Some(RobotModel {
        name: name?,
        doc: doc?,
        config: RobotConfig {
            footprint: footprint?,
            head: head.clone().unwrap_or_default(),
            ..odometry?.over(drive?)
        },
        lasers: lasers?,
        sonars: sonars?,
        bumpers: bumpers?,
        head: head.is_some(),
        battery: battery?,
    })
}

fn footprint(table: &Table<'_>) -> Option<Footprint> {
    match (table.get("radius"), table.get("polygon")) {
        (Some(_), None) => {
            let radius = table.required("radius", between(0.01, 10.0, "m"))?;
            Some(Footprint::Circle { radius })
        }
        (None, Some(_)) => table.required("polygon", polygon).map(Footprint::Polygon),
        (Some(_), Some(_)) | (None, None) => {
            table.fault(table.span(), "expected either a `radius` or a `polygon`");
            None
        }
    }
}

fn polygon(item: &Item<'_>) -> Read<Polygon> {
    Polygon::new(&values::points(item)?).map_err(|reason| (item.span(), reason))
}

fn drive(document: &Document<'_>, root: &Table<'_>) -> Option<RobotConfig> {
    // The kinematics decides which keys are known.
    let kind = root
        .get("drive")
        .and_then(|item| item.get_ref().get("kinematics"))
        .and_then(|kind| kind.get_ref().as_str());
    let known = match kind {
        Some("car") => [&DRIVE_KEYS[..], &CAR_KEYS].concat(),
        Some("omnidirectional") => [&DRIVE_KEYS[..], &TURN_KEYS, &LATERAL_KEYS].concat(),
        _ => [&DRIVE_KEYS[..], &TURN_KEYS].concat(),
    };
    let table = section(document, root, "drive", &known)?;
    let acceleration = between(ACCELERATION.0, ACCELERATION.1, "m/s²");
    let angle = |key, low, high, unit| table.required(key, degrees(low, high, unit));
    let default = RobotConfig::default();
    let max_linear = table.required("max_speed", between(0.01, 20.0, "m/s"));
    let gain = table.required("acceleration", acceleration);
    let loss = table.optional("deceleration", gain.unwrap_or(1.0), acceleration);
    let lag = table.optional("lag", 0.0, between(0.0, 10.0, "s"));
    let max_push = table.optional("max_push", default.max_push, between(0.01, 1e4, "kg"));
    let kinematics = table
        .required("kinematics", kinematics_name)
        .and_then(|kind| match kind {
            "car" => {
                let wheelbase = table.required("wheelbase", between(0.01, 10.0, "m"));
                let max_steering = angle("max_steering_deg", 1.0, 80.0, "degrees");
                let steering_rate = angle("steering_rate_deg", 1.0, ACCELERATION.1, "degrees/s");
                Some(Kinematics::Car {
                    wheelbase: wheelbase?,
                    max_steering: max_steering?,
                    steering_rate: steering_rate?,
                })
            }
            "omnidirectional" => {
                let max_lateral = table.required("max_lateral_speed", between(0.01, 20.0, "m/s"));
                let lateral_acceleration = table.required("lateral_acceleration", acceleration);
                Some(Kinematics::Omnidirectional {
                    max_lateral: max_lateral?,
                    lateral_acceleration: lateral_acceleration?,
                })
            }
            _ => Some(Kinematics::Differential),
        });
    let config = RobotConfig {
        kinematics: kinematics?,
        max_linear: max_linear?,
        linear_acceleration: gain?,
        linear_deceleration: loss?,
        lag: lag?,
        max_push: max_push?,
        odometry_origin: OdometryOrigin::default(),
        ..default
    };
    if let Kinematics::Car { .. } = config.kinematics {
        return Some(config);
    }
    let max_angular = angle("max_turn_deg", 1.0, 5000.0, "degrees/s");
    let gain = angle("turn_acceleration_deg", 1.0, ACCELERATION.1, "degrees/s²");
    let turns = degrees(1.0, ACCELERATION.1, "degrees/s²");
    let loss = table.optional("turn_deceleration_deg", gain.unwrap_or(1.0), turns);
    Some(RobotConfig {
        max_angular: max_angular?,
        angular_acceleration: gain?,
        angular_deceleration: loss?,
        ..config
    })
}

/// Reads the name of a kinematics.
fn kinematics_name<'a>(item: &Item<'a>) -> Read<&'static str> {
    const NAMES: [&str; 3] = ["differential", "omnidirectional", "car"];
    let text = values::text(item)?;
    NAMES.into_iter().find(|name| *name == text).ok_or_else(|| {
        let known = match super::nearest(&text, NAMES.into_iter()) {
            Some(name) => format!("did you mean `{name}`?"),
            None => format!("expected one of `{}`", NAMES.join("`, `")),
        };
        (item.span(), format!("is `{text}`: {known}"))
    })
}

/// The wheels as the odometry sees them.
struct Wheels {
    track: f64,
    ticks_per_meter: f64,
    wheel_scale_sigma: f64,
    slip_sigma: f64,
}

impl Wheels {
    fn over(self, config: RobotConfig) -> RobotConfig {
        let Self {
            track,
            ticks_per_meter,
            wheel_scale_sigma,
            slip_sigma,
        } = self;
        RobotConfig {
            track,
            ticks_per_meter,
            wheel_scale_sigma,
            slip_sigma,
            ..config
        }
    }
}

fn odometry(document: &Document<'_>, root: &Table<'_>) -> Option<Wheels> {
    let table = section(document, root, "odometry", &ODOMETRY_KEYS)?;
    let default = RobotConfig::default();
    let track = table.required("track", between(0.01, 10.0, "m"));
    let ticks = table.required("ticks_per_mm", between(1e-3, 1e6, "ticks"));
    let scale = table.optional("wheel_error", default.wheel_scale_sigma, between(0.0, 0.5, ""));
    let slip = table.optional("slip", default.slip_sigma, between(0.0, 1.0, "m"));
    Some(Wheels {
        track: track?,
        ticks_per_meter: ticks? * 1000.0,
        wheel_scale_sigma: scale?,
        slip_sigma: slip?,
    })
}

fn lasers(document: &Document<'_>, root: &Table<'_>) -> Option<Vec<LaserModel>> {
    let keys = [&["name", "mount", "beams", "view_deg"][..], &RANGE_KEYS].concat();
    let mut lasers = each(document, root, "lasers", "laser", &keys, |table, name| {
        let default = LaserConfig::default();
        let mount = mount(document, table);
        let beams = table.required("beams", beams);
        let view = table.required("view_deg", degrees(0.1, 360.0, "degrees"));
        let range = range(table, default.range_min, default.sigma);
        let (range, period) = range?;
        Some((
            LaserModel {
                name,
                config: LaserConfig {
                    mount: mount?,
                    beams: beams?,
                    field_of_view: view?,
                    range_min: range.min,
                    range_max: range.max,
                    sigma: range.sigma,
                    stream: 0,
                },
                period,
            },
            table.span().clone(),
        ))
    })?;
    for index in 0..lasers.len() {
        let (earlier, rest) = lasers.split_at_mut(index);
        let (laser, span) = &mut rest[0];
        if earlier.iter().any(|(other, _)| other.name == laser.name) {
            let message = format!("laser `{}` is there twice: give each its own name", laser.name);
            document.fault(span, message);
        }
        laser.config.stream = u16::try_from(index).unwrap_or(u16::MAX);
    }
    Some(lasers.into_iter().map(|(laser, _)| laser).collect())
}

fn beams(item: &Item<'_>) -> Read<usize> {
    let number = between(1.0, MAX_BEAMS, "beams")(item)?;
    if number.fract() == 0.0 {
        Ok(number as usize)
    } else {
        Err((item.span(), format!("is {number}: expected a whole number")))
    }
}

fn sonars(document: &Document<'_>, root: &Table<'_>) -> Option<Option<SonarModel>> {
    if root.get("sonars").is_none() {
        return Some(None);
    }
    let table = section(
        document,
        root,
        "sonars",
        &[&["mounts", "cone_deg"][..], &RANGE_KEYS].concat(),
    )?;
    let default = SonarConfig::default();
    let mounts = each(
        document,
        &table,
        "mounts",
        "mount",
        &starts::POSE_KEYS,
        |table, _| starts::pose(table),
    );
    let cone = table.required("cone_deg", degrees(0.0, 180.0, "degrees"));
    let range = range(&table, default.range_min, default.sigma);
    let mounts = mounts?;
    if !(1..=1000).contains(&mounts.len()) {
        let message = format!("`mounts` has {} poses: expected 1 to 1000", mounts.len());
        table.fault(table.span(), message);
        return None;
    }
    let (range, period) = range?;
    Some(Some(SonarModel {
        config: SonarConfig {
            mounts,
            cone: cone?,
            range_min: range.min,
            range_max: range.max,
            sigma: range.sigma,
            stream: 0,
        },
        period,
    }))
}

fn head(document: &Document<'_>, root: &Table<'_>) -> Option<Option<HeadConfig>> {
    if root.get("head").is_none() {
        return Some(None);
    }
    let table = section(document, root, "head", &HEAD_KEYS)?;
    let angle = |key| table.required(key, degrees(0.0, 180.0, "degrees"));
    let rate = |key| table.required(key, degrees(0.0, 5000.0, "degrees/s"));
    let mount = table.required("mount", values::place);
    let (pan, down, up) = (
        angle("max_pan_deg"),
        angle("max_tilt_down_deg"),
        angle("max_tilt_up_deg"),
    );
    let (pan_rate, tilt_rate) = (rate("pan_rate_deg"), rate("tilt_rate_deg"));
    Some(Some(HeadConfig {
        mount: mount?,
        max_pan: pan?,
        max_tilt_down: down?,
        max_tilt_up: up?,
        max_pan_speed: pan_rate?,
        max_tilt_speed: tilt_rate?,
    }))
}

struct Range {
    min: f64,
    max: f64,
    sigma: f64,
}

/// Reads what all range sensors have, with the time between two measurements.
fn range(table: &Table<'_>, min: f64, sigma: f64) -> Option<(Range, Option<Duration>)> {
    let min = table.optional("range_min", min, between(0.0, 1e3, "m"));
    let max = table.required("range_max", between(0.01, 1e3, "m"));
    let sigma = table.optional("noise", sigma, between(0.0, 10.0, "m"));
    let rate = table.optional("rate", None, |item| between(0.01, 100.0, "Hz")(item).map(Some));
    let (min, max) = (min?, max?);
    if min >= max {
        table.fault(
            table.span(),
            format!("`range_min` is {min}: expected less than `range_max`"),
        );
        return None;
    }
    let period = rate?.map(|rate| Duration::from_secs_f64(1.0 / rate));
    Some((
        Range {
            min,
            max,
            sigma: sigma?,
        },
        period,
    ))
}

/// Reads the pose of a sensor in the robot's frame: its centre without one.
fn mount<'a>(document: &'a Document<'a>, table: &Table<'a>) -> Option<Pose2> {
    match table.get("mount") {
        None => Some(Pose2::default()),
        Some(item) => starts::pose(&Table::nested(document, item, "mount", &starts::POSE_KEYS)?),
    }
}

/// Returns a table of the file; a missing one is a fault.
fn section<'a>(document: &'a Document<'a>, root: &Table<'a>, key: &str, known: &[&str]) -> Option<Table<'a>> {
    let Some(item) = root.get(key) else {
        root.fault(
            root.span(),
            format!("[{key}] is missing: expected `{}`", known.join("`, `")),
        );
        return None;
    };
    Table::nested(document, item, key, known)
}

/// Returns a reader of degrees, which returns radians.
fn degrees(low: f64, high: f64, unit: &'static str) -> impl Fn(&Item<'_>) -> Read<f64> {
    move |item| Ok(between(low, high, unit)(item)?.to_radians())
}
