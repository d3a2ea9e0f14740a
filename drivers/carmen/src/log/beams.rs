//! The angles of a scan's beams, and which of their ranges are objects. It knows no file.
//!
//! Old messages state only how many beams there are. What follows from it is what CARMEN (`readlog.c`) and GMapping
//! (`carmenconfiguration.cpp`) take it for; the parameters of the log come first where they fit the number.

use core::f64::consts::{PI, TAU};

use super::record::{Config, Sweep};

/// Most beams of the exported type. Adjacent beams of larger scans are replaced by their nearest.
const MAX_BEAMS: usize = 1088;
/// The increment of the lasers of Hokuyo, rad.
const HOKUYO: f64 = TAU / 1024.0;
/// Ranges by which a laser of SICK says that there is none, m: the greatest numbers of 13, 14 and 15 bits in millimetres;
/// and those of a number of 10 bits in units of 5 cm, beyond which GMapping takes no range for one.
const NO_RETURN: [(f32, f32); 4] = [(8.183, 8.192), (16.375, 16.384), (32.759, 32.768), (50.0, 51.3)];

/// A scan with its angles.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scan {
    /// Angle of the first beam, rad.
    pub(crate) angle_min: f64,
    /// Angle between beams, rad.
    pub(crate) angle_increment: f64,
    /// From this range on, a beam had no return, m.
    pub(crate) reach: f32,
    /// Distances, m.
    pub(crate) ranges: Vec<f32>,
}

/// The parameters of a log that say what its laser is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stated {
    /// The angle between beams, rad.
    pub(crate) increment: Option<f64>,
    /// The angle that the beams cover, rad.
    pub(crate) view: Option<f64>,
}

impl Stated {
    /// Takes a resolution as it is written: degrees, or radians if it is too small for them.
    pub(crate) fn resolution(&mut self, value: f64) {
        let degrees = if value < 0.05 { value.to_degrees() } else { value };
        self.increment.get_or_insert(degrees.to_radians());
    }

    /// Takes a field of view as it is written: radians, or degrees if it is too large for them.
    pub(crate) fn field_of_view(&mut self, value: f64) {
        let radians = if value > 1.05 * TAU {
            value.to_radians()
        } else {
            value
        };
        self.view.get_or_insert(radians);
    }
}

impl Scan {
    /// Returns the scan with its angles.
    pub(crate) fn new(sweep: Sweep, stated: &Stated) -> Self {
        let Sweep { mut ranges, config } = sweep;
        let (mut angle_min, mut angle_increment) = angles(ranges.len(), config.as_ref(), stated);
        let reach = reach(ranges.len(), config.as_ref());
        let size = ranges.len().div_ceil(MAX_BEAMS);
        if size > 1 {
            ranges = ranges.chunks(size).map(|group| nearest(group, reach)).collect();
            angle_min += angle_increment * (size - 1) as f64 / 2.0;
            angle_increment *= size as f64;
        }
        Self {
            angle_min,
            angle_increment,
            reach,
            ranges,
        }
    }

    /// Whether a beam ends at an object.
    pub(crate) fn hits(&self) -> bool {
        self.ranges
            .iter()
            .any(|range| *range > 0.0 && *range < self.reach)
    }
}

/// Returns the range from which on a log's beams had no return, by the greatest of its ranges; `None` if the laser is not
/// known by it.
pub(crate) fn no_return(greatest: f32) -> Option<f32> {
    let of_laser = |&&(least, most): &&(f32, f32)| (least..=most).contains(&greatest);
    NO_RETURN.iter().find(of_laser).map(|(least, _)| *least)
}

/// Returns the angle of the first beam and that between beams.
fn angles(beams: usize, config: Option<&Config>, stated: &Stated) -> (f64, f64) {
    let gaps = beams.saturating_sub(1).max(1) as f64;
    let fits = |increment: &f64| *increment > 0.0 && increment * gaps <= 1.05 * TAU;
    if let Some(config) = config
        && let Some(increment) = [config.increment, config.view / gaps].into_iter().find(fits)
    {
        let is_angle = config.start.abs() <= TAU;
        return (
            if is_angle {
                config.start
            } else {
                -increment * gaps / 2.0
            },
            increment,
        );
    }
    let agrees = |increment: &f64| {
        stated
            .view
            .is_some_and(|view| (view - increment * gaps).abs() < 1.5 * increment)
    };
    let increment = (stated.increment.filter(fits).filter(agrees))
        .or_else(|| usual(beams))
        .or_else(|| stated.view.map(|view| view / gaps).filter(fits))
        .or_else(|| stated.increment.filter(fits))
        .unwrap_or(PI / gaps);
    // A laser of SICK measures at both ends of its view, and many logs leave the last of these beams out.
    let whole = increment * beams as f64;
    let is_view = |view: f64| (view - whole).abs() < increment / 100.0;
    let lacks_last = [100.0_f64, 180.0, 270.0]
        .map(f64::to_radians)
        .into_iter()
        .any(is_view);
    (
        -(if lacks_last { whole } else { increment * gaps }) / 2.0,
        increment,
    )
}

/// Returns the increment of the lasers that have so many beams, rad.
fn usual(beams: usize) -> Option<f64> {
    match beams {
        180 | 181 => Some(1_f64.to_radians()),
        360 | 361 | 540 | 541 => Some(0.5_f64.to_radians()),
        400 | 401 | 1080 | 1081 => Some(0.25_f64.to_radians()),
        682 | 683 | 726 | 769 => Some(HOKUYO),
        _ => None,
    }
}

/// Returns how far the laser sees: what the message states, else what GMapping takes lasers with so many beams for.
fn reach(beams: usize, config: Option<&Config>) -> f32 {
    match (config.map(|config| config.max_range as f32), beams) {
        (Some(stated), _) if stated > 0.0 => stated,
        (_, 682 | 769) => 4.1,
        (_, 683) => 5.5,
        _ => f32::INFINITY,
    }
}

/// Returns the range of the nearest object, else that of a beam without a return, else NaN.
fn nearest(group: &[f32], reach: f32) -> f32 {
    let rank = |range: f32| match range {
        _ if range > 0.0 && range < reach => 0,
        _ if range >= reach => 1,
        _ => 2,
    };
    let order = |a: &&f32, b: &&f32| rank(**a).cmp(&rank(**b)).then_with(|| a.total_cmp(b));
    group.iter().min_by(order).copied().unwrap_or(f32::NAN)
}
