//! The sensors and the head of a robot file.

use std::time::Duration;

use super::super::document::{Document, Item, Table};
use super::super::fixtures::each;
use super::super::starts;
use super::super::values::{self, Read, between};
use super::{degrees, section};
use crate::geometry::Pose2;
use crate::head::HeadConfig;
use crate::model::{LaserModel, SampledSensor};
use crate::sensor::{ImuConfig, LaserConfig, LineSensorConfig, PositionConfig, SonarConfig};

const RANGE_KEYS: [&str; 4] = ["range_min", "range_max", "noise", "rate"];
const IMU_KEYS: [&str; 6] = [
    "mount",
    "gyro_noise_deg",
    "gyro_bias_deg",
    "accelerometer_noise",
    "accelerometer_bias",
    "rate",
];
const POSITION_KEYS: [&str; 5] = ["mount", "noise", "outage", "outage_time", "rate"];
const HEAD_KEYS: [&str; 6] = [
    "mount",
    "max_pan_deg",
    "max_tilt_down_deg",
    "max_tilt_up_deg",
    "pan_rate_deg",
    "tilt_rate_deg",
];

/// The default side in metres of what a cell of a line sensor sees: an estimate for a cell 3 mm above the floor.
const SPOT: f64 = 0.005;
/// The default standard deviation of a brightness: an estimate, a few steps of a converter of eight bits.
const BRIGHTNESS_NOISE: f64 = 0.01;
/// Most beams of a laser: more than any has, few enough to fill a scan in milliseconds.
const MAX_BEAMS: f64 = 1e5;

pub(super) fn lasers(document: &Document<'_>, root: &Table<'_>) -> Option<Vec<LaserModel>> {
    let keys = [
        &["name", "mount", "beams", "view_deg", "intensity"][..],
        &RANGE_KEYS,
    ]
    .concat();
    let mut lasers = each(document, root, "lasers", "laser", &keys, |table, name| {
        let default = LaserConfig::default();
        let mount = mount(document, table);
        let beams = table.required("beams", beams);
        let view = table.required("view_deg", degrees(0.1, 360.0, "degrees"));
        let range = range(table, default.range_min, default.sigma);
        let intensity = table.optional("intensity", 0.0, between(0.0, 1e6, ""));
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
                    intensity: intensity?,
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

pub(super) fn sonars(
    document: &Document<'_>,
    root: &Table<'_>,
) -> Option<Option<SampledSensor<SonarConfig>>> {
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
    Some(Some(SampledSensor {
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

pub(super) fn line(
    document: &Document<'_>,
    root: &Table<'_>,
) -> Option<Option<SampledSensor<LineSensorConfig>>> {
    if root.get("line_sensor").is_none() {
        return Some(None);
    }
    let table = section(
        document,
        root,
        "line_sensor",
        &["mounts", "spot", "noise", "rate"],
    )?;
    let mounts = table.required("mounts", values::centers);
    let spot = table.optional("spot", SPOT, between(0.001, 1.0, "m"));
    let sigma = table.optional("noise", BRIGHTNESS_NOISE, between(0.0, 1.0, ""));
    let period = period(&table);
    Some(Some(SampledSensor {
        config: LineSensorConfig {
            mounts: mounts?,
            spot: spot?,
            sigma: sigma?,
            stream: 0,
        },
        period: period?,
    }))
}

pub(super) fn imu(document: &Document<'_>, root: &Table<'_>) -> Option<Option<SampledSensor<ImuConfig>>> {
    if root.get("imu").is_none() {
        return Some(None);
    }
    let table = section(document, root, "imu", &IMU_KEYS)?;
    let default = ImuConfig::default();
    let mount = mount(document, &table);
    let gyro = |key, default| table.optional(key, default, degrees(0.0, 1000.0, "degrees/s"));
    let (gyro_sigma, gyro_bias) = (
        gyro("gyro_noise_deg", default.gyro_sigma),
        gyro("gyro_bias_deg", default.gyro_bias),
    );
    let accelerometer = |key, default| table.optional(key, default, between(0.0, 1000.0, "m/s²"));
    let (sigma, bias) = (
        accelerometer("accelerometer_noise", default.accelerometer_sigma),
        accelerometer("accelerometer_bias", default.accelerometer_bias),
    );
    let period = period(&table);
    Some(Some(SampledSensor {
        config: ImuConfig {
            mount: mount?,
            gyro_sigma: gyro_sigma?,
            gyro_bias: gyro_bias?,
            accelerometer_sigma: sigma?,
            accelerometer_bias: bias?,
            stream: 0,
        },
        period: period?,
    }))
}

pub(super) fn position(
    document: &Document<'_>,
    root: &Table<'_>,
) -> Option<Option<SampledSensor<PositionConfig>>> {
    if root.get("position").is_none() {
        return Some(None);
    }
    let table = section(document, root, "position", &POSITION_KEYS)?;
    let default = PositionConfig::default();
    let mount = table.optional("mount", default.mount, values::point);
    let sigma = table.optional("noise", default.sigma, between(0.0, 1000.0, "m"));
    let outage = table.optional("outage", default.outage, between(0.0, 1.0, ""));
    let time = table.optional("outage_time", default.outage_time, between(0.01, 1e5, "s"));
    let period = period(&table);
    Some(Some(SampledSensor {
        config: PositionConfig {
            mount: mount?,
            sigma: sigma?,
            outage: outage?,
            outage_time: time?,
            stream: 0,
        },
        period: period?,
    }))
}

pub(super) fn head(document: &Document<'_>, root: &Table<'_>) -> Option<Option<HeadConfig>> {
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
    let period = period(table);
    let (min, max) = (min?, max?);
    if min >= max {
        table.fault(
            table.span(),
            format!("`range_min` is {min}: expected less than `range_max`"),
        );
        return None;
    }
    Some((
        Range {
            min,
            max,
            sigma: sigma?,
        },
        period?,
    ))
}

/// Reads the `rate` of a sensor, as the time between two measurements.
fn period(table: &Table<'_>) -> Option<Option<Duration>> {
    let rate = table.optional("rate", None, |item| between(0.01, 100.0, "Hz")(item).map(Some));
    Some(rate?.map(|rate| Duration::from_secs_f64(1.0 / rate)))
}

/// Reads the pose of a sensor in the robot's frame: its centre without one.
fn mount<'a>(document: &'a Document<'a>, table: &Table<'a>) -> Option<Pose2> {
    match table.get("mount") {
        None => Some(Pose2::default()),
        Some(item) => starts::pose(&Table::nested(document, item, "mount", &starts::POSE_KEYS)?),
    }
}
