//! Converts Player's data to the standard interfaces: REP-103 axes, and ranges by REP-117.

use core::time::Duration;

use jde_player::{Mount, Power, Scan};
use jde_schema::prelude::*;
use jde_schema::types::{self, Body};

/// Values of `BatteryState`.
const CHARGING: u8 = 1;
const DISCHARGING: u8 = 2;
const NOT_CHARGING: u8 = 3;
/// Seconds of an hour.
const HOUR: f32 = 3600.0;

/// Returns a body of unknown outline with a laser.
pub(crate) fn body(now: Duration, laser: Option<Mount>) -> Body {
    let mount = |Mount { x, y, yaw }| types::Mount {
        frame: Text::new("laser"),
        pose: Pose2D::new(x, y, yaw),
    };
    Body {
        header: Header::new(now, "base_link"),
        lasers: laser.map(mount).into_iter().collect(),
        ..Body::default()
    }
}

/// Returns a range by REP-117: +∞ without an echo within the greatest range, −∞ below the least one, NaN if
/// it is no measurement.
pub(crate) fn range(metres: f64, min: f64, max: f64) -> f32 {
    if metres.is_nan() || metres < 0.0 {
        f32::NAN
    } else if metres >= max {
        f32::INFINITY
    } else if metres < min {
        f32::NEG_INFINITY
    } else {
        metres as f32
    }
}

/// Fills a laser scan. Its beams are evenly spread from the first angle to the last.
pub(crate) fn fill_scan(scan: &mut LaserScan, sweep: &Scan, default_max: f64) {
    let max = if sweep.range_max > 0.0 {
        sweep.range_max
    } else {
        default_max
    };
    let group = sweep.ranges.len().div_ceil(Seq::<f32, 1088>::CAPACITY).max(1);
    let steps = sweep.ranges.len().saturating_sub(1).max(1) as f64;
    let increment = (sweep.angle_max - sweep.angle_min) / steps;
    let first = sweep.angle_min + increment * (group as f64 - 1.0) / 2.0;
    scan.angle_min = first as f32;
    scan.angle_increment = (increment * group as f64) as f32;
    scan.time_increment = 0.0;
    scan.range_min = sweep.range_min as f32;
    scan.range_max = max as f32;
    scan.ranges.clear();
    scan.intensities.clear();
    for beams in sweep.ranges.chunks(group) {
        let ranges = beams.iter().map(|beam| range(*beam, sweep.range_min, max));
        // The size of the groups ensures that they fit.
        let _ = scan.ranges.push(ranges.fold(f32::NAN, f32::min));
    }
    let last = scan.ranges.len().saturating_sub(1) as f32;
    scan.angle_max = scan.angle_min + last * scan.angle_increment;
}

/// Returns the bumpers. They count as front bumpers unless their places are behind the centre; each row is
/// sorted from left to right.
pub(crate) fn bumpers(now: Duration, states: &[bool], mounts: &[Mount], stalled: bool) -> Bumpers {
    let mut bumpers = Bumpers {
        header: Header::new(now, "base_link"),
        stalled: stalled.into(),
        ..Bumpers::default()
    };
    let place = |index: usize| mounts.get(index).copied().unwrap_or_default();
    let mut order: Vec<usize> = (0..states.len()).collect();
    order.sort_by(|a, b| place(*b).y.total_cmp(&place(*a).y));
    for index in order {
        let row = if place(index).x < 0.0 {
            &mut bumpers.rear
        } else {
            &mut bumpers.front
        };
        let pressed = Flag::from(states[index]);
        // More bumpers than fit: the last one stands for the rest of its row.
        if row.push(pressed).is_err()
            && let Some(last) = row.last_mut()
        {
            *last = (last.get() || pressed.get()).into();
        }
    }
    bumpers
}

pub(crate) fn battery(now: Duration, power: &Power) -> BatteryState {
    let volts = power.volts.unwrap_or(f32::NAN);
    BatteryState {
        header: Header::new(now, "base_link"),
        voltage: volts,
        current: power.watts.map_or(f32::NAN, |watts| watts / volts),
        charge: power.joules.map_or(f32::NAN, |joules| joules / HOUR / volts),
        percentage: power.percent.map_or(f32::NAN, |percent| percent / 100.0),
        power_supply_status: match power.charging {
            Some(1) => CHARGING,
            Some(-1) => DISCHARGING,
            Some(0) => NOT_CHARGING,
            Some(_) | None => 0,
        },
        present: Flag::TRUE,
        ..BatteryState::default()
    }
}
