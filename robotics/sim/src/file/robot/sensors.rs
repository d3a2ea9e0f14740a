//! The sensors of a robot file beside its lasers, and the head.

use std::time::Duration;

use super::super::fixtures::each;
use super::super::starts;
use super::super::values::{self, between};
use super::{degrees, section};
use crate::geometry::Pose2;
use crate::head::HeadConfig;
use crate::model::SampledSensor;
use crate::sensor::{Delivery, ImuConfig, LineSensorConfig, PositionConfig, SonarConfig};
use jde_document::{FaultReport, Section};

pub(super) const RANGE_KEYS: [&str; 4] = ["range_min", "range_max", "noise", "rate"];
/// How the measurements of any sensor arrive.
pub(super) const DELIVERY_KEYS: [&str; 3] = ["latency", "jitter", "dropped"];
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

pub(super) fn sonars(
    report: &mut FaultReport<'_>,
    root: &Section<'_>,
) -> Option<Option<SampledSensor<SonarConfig>>> {
    if root.get("sonars").is_none() {
        return Some(None);
    }
    let table = section(
        report,
        root,
        "sonars",
        &[
            &["mounts", "cone_deg", "dropped_echoes"][..],
            &RANGE_KEYS,
            &DELIVERY_KEYS,
        ]
        .concat(),
    )?;
    let default = SonarConfig::default();
    let mounts = each(
        report,
        &table,
        "mounts",
        "mount",
        &starts::POSE_KEYS,
        |report, table, _| starts::pose(report, table),
    );
    let cone = table.required(report, "cone_deg", degrees(0.0, 180.0, "degrees"));
    let range = range(report, &table, default.range_min, default.sigma);
    let dropped = table.optional(report, "dropped_echoes", 0.0, between(0.0, 1.0, ""));
    let delivery = delivery(report, &table);
    let mounts = mounts?;
    if !(1..=1000).contains(&mounts.len()) {
        let message = format!("has {} `mounts`: expected 1 to 1000", mounts.len());
        table.fault(report, &table.span, message);
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
            dropped_echoes: dropped?,
            stream: 0,
        },
        period,
        delivery: delivery?,
    }))
}

pub(super) fn line(
    report: &mut FaultReport<'_>,
    root: &Section<'_>,
) -> Option<Option<SampledSensor<LineSensorConfig>>> {
    if root.get("line_sensor").is_none() {
        return Some(None);
    }
    let keys = [&["mounts", "spot", "noise", "rate"][..], &DELIVERY_KEYS].concat();
    let table = section(report, root, "line_sensor", &keys)?;
    let mounts = table.required(report, "mounts", values::centers);
    let spot = table.optional(report, "spot", SPOT, between(0.001, 1.0, "m"));
    let sigma = table.optional(report, "noise", BRIGHTNESS_NOISE, between(0.0, 1.0, ""));
    let (period, delivery) = (period(report, &table), delivery(report, &table));
    Some(Some(SampledSensor {
        config: LineSensorConfig {
            mounts: mounts?,
            spot: spot?,
            sigma: sigma?,
            stream: 0,
        },
        period: period?,
        delivery: delivery?,
    }))
}

pub(super) fn imu(
    report: &mut FaultReport<'_>,
    root: &Section<'_>,
) -> Option<Option<SampledSensor<ImuConfig>>> {
    if root.get("imu").is_none() {
        return Some(None);
    }
    let table = section(report, root, "imu", &[&IMU_KEYS[..], &DELIVERY_KEYS].concat())?;
    let default = ImuConfig::default();
    let mount = mount(report, &table);
    let mut gyro = |key, default| table.optional(report, key, default, degrees(0.0, 1000.0, "degrees/s"));
    let (gyro_sigma, gyro_bias) = (
        gyro("gyro_noise_deg", default.gyro_sigma),
        gyro("gyro_bias_deg", default.gyro_bias),
    );
    let mut accelerometer = |key, default| table.optional(report, key, default, between(0.0, 1000.0, "m/s²"));
    let (sigma, bias) = (
        accelerometer("accelerometer_noise", default.accelerometer_sigma),
        accelerometer("accelerometer_bias", default.accelerometer_bias),
    );
    let (period, delivery) = (period(report, &table), delivery(report, &table));
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
        delivery: delivery?,
    }))
}

pub(super) fn position(
    report: &mut FaultReport<'_>,
    root: &Section<'_>,
) -> Option<Option<SampledSensor<PositionConfig>>> {
    if root.get("position").is_none() {
        return Some(None);
    }
    let table = section(
        report,
        root,
        "position",
        &[&POSITION_KEYS[..], &DELIVERY_KEYS].concat(),
    )?;
    let default = PositionConfig::default();
    let mount = table.optional(report, "mount", default.mount, values::point);
    let sigma = table.optional(report, "noise", default.sigma, between(0.0, 1000.0, "m"));
    let outage = table.optional(report, "outage", default.outage, between(0.0, 1.0, ""));
    let time = table.optional(
        report,
        "outage_time",
        default.outage_time,
        between(0.01, 1e5, "s"),
    );
    let (period, delivery) = (period(report, &table), delivery(report, &table));
    Some(Some(SampledSensor {
        config: PositionConfig {
            mount: mount?,
            sigma: sigma?,
            outage: outage?,
            outage_time: time?,
            stream: 0,
        },
        period: period?,
        delivery: delivery?,
    }))
}

pub(super) fn head(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<Option<HeadConfig>> {
    if root.get("head").is_none() {
        return Some(None);
    }
    let table = section(report, root, "head", &HEAD_KEYS)?;
    let mount = table.required(report, "mount", values::place);
    let mut angle = |key| table.required(report, key, degrees(0.0, 180.0, "degrees"));
    let (pan, down, up) = (
        angle("max_pan_deg"),
        angle("max_tilt_down_deg"),
        angle("max_tilt_up_deg"),
    );
    let mut rate = |key| table.required(report, key, degrees(0.0, 5000.0, "degrees/s"));
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

pub(super) struct Range {
    pub(super) min: f64,
    pub(super) max: f64,
    pub(super) sigma: f64,
}

/// Reads what all range sensors have, with the time between two measurements.
pub(super) fn range(
    report: &mut FaultReport<'_>,
    table: &Section<'_>,
    min: f64,
    sigma: f64,
) -> Option<(Range, Option<Duration>)> {
    let min = table.optional(report, "range_min", min, between(0.0, 1e3, "m"));
    let max = table.required(report, "range_max", between(0.01, 1e3, "m"));
    let sigma = table.optional(report, "noise", sigma, between(0.0, 10.0, "m"));
    let period = period(report, table);
    let (min, max) = (min?, max?);
    if min >= max {
        let message = format!(
            "{} is {min}: expected less than `range_max`, {max}",
            table.key("range_min")
        );
        report.fault(&table.key_span("range_min"), message);
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

/// Reads how the measurements of a sensor arrive.
pub(super) fn delivery(report: &mut FaultReport<'_>, table: &Section<'_>) -> Option<Delivery> {
    let seconds = between(0.0, 10.0, "s");
    let latency = table.optional(report, "latency", 0.0, seconds);
    let jitter = table.optional(report, "jitter", 0.0, seconds);
    let dropped = table.optional(report, "dropped", 0.0, between(0.0, 1.0, ""));
    Some(Delivery {
        latency: latency?,
        jitter: jitter?,
        dropped: dropped?,
    })
}

/// Reads the `rate` of a sensor, as the time between two measurements.
fn period(report: &mut FaultReport<'_>, table: &Section<'_>) -> Option<Option<Duration>> {
    let rate = table.optional(report, "rate", None, |node| {
        between(0.01, 100.0, "Hz")(node).map(Some)
    });
    Some(rate?.map(|rate| Duration::from_secs_f64(1.0 / rate)))
}

/// Reads the pose of a sensor in the robot's frame: its centre without one.
pub(super) fn mount<'a>(report: &mut FaultReport<'_>, table: &Section<'a>) -> Option<Pose2> {
    match table.get("mount") {
        None => Some(Pose2::default()),
        Some(_) => {
            let table = table.nested(report, "mount", &starts::POSE_KEYS)?;
            starts::pose(report, &table)
        }
    }
}
