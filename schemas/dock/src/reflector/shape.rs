//! What is bright in a scan, and which of it has the shape of a reflector. All is in the frame of the laser.

use core::f64::consts::FRAC_PI_2;

use jde_schema::prelude::*;
use jde_schema::types::Echo;

/// Neighbouring beams that end farther apart, m, do not end at the same thing.
const GAP: f64 = 0.1;
/// Ends on both sides of a single dull beam that are farther apart, m, are not of one strip.
const HOLE: f64 = 0.03;
/// The greatest angle, rad, at which a strip is seen: 70 degrees. Seen from the side it is narrower than its beams tell.
const MAX_ANGLE: f64 = 1.22;
/// How far before or behind the plane of the strips, m, something bright is part of the reflector.
const DEPTH: f64 = 0.1;

/// A thing that is bright to the laser.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Bright {
    /// The mean of where its beams end.
    pub(crate) middle: (f64, f64),
    /// From the end of its first beam to that of its last one, m.
    extent: f64,
    /// The distance from one beam to the next, m.
    spacing: f64,
}

/// A reflector.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReflectorShape<'a> {
    /// The places of the strips along its own y, ascending, m.
    pub(crate) offsets: &'a [f64],
    /// Of a strip, m.
    pub(crate) width: f64,
    /// How far a strip may be from its place, m.
    pub(crate) tolerance: f64,
}

/// Returns what is at least as bright as `least`, and at most `range` m away.
pub(crate) fn bright(scan: &LaserScan, least: f64, range: f64) -> Vec<Bright> {
    let count = scan.ranges.len();
    let end = |beam: usize| {
        let Echo::Hit(length) = Echo::of(scan.ranges[beam], scan.range_min, scan.range_max) else {
            return None;
        };
        let length = f64::from(length);
        let is_bright = f64::from(scan.intensities[beam]) >= least && length <= range;
        let (sin, cos) = libm::sincos(scan.angle(beam));
        is_bright.then_some((length * cos, length * sin))
    };
    // It begins beside a thing: one of a full turn may lie across the first beam.
    let Some(first) = (0..count).find(|beam| end(*beam).is_none()) else {
        return Vec::new();
    };
    let mut things = Vec::new();
    let mut ends: Vec<(f64, f64)> = Vec::new();
    let mut close = |ends: &mut Vec<(f64, f64)>| {
        if let (Some(first), Some(last)) = (ends.first(), ends.last()) {
            let sum = ends
                .iter()
                .fold((0.0, 0.0), |sum, end| (sum.0 + end.0, sum.1 + end.1));
            let middle = (sum.0 / ends.len() as f64, sum.1 / ends.len() as f64);
            things.push(Bright {
                middle,
                extent: apart(*first, *last),
                spacing: libm::hypot(middle.0, middle.1) * f64::from(scan.angle_increment).abs(),
            });
        }
        ends.clear();
    };
    let mut missing = 0;
    for beam in (first..count).chain(0..first) {
        let Some(end) = end(beam) else {
            missing += 1;
            continue;
        };
        let most = match missing {
            0 => GAP,
            1 => HOLE,
            _ => 0.0,
        };
        if ends.last().is_some_and(|last| apart(*last, end) > most) {
            close(&mut ends);
        }
        ends.push(end);
        missing = 0;
    }
    close(&mut ends);
    things
}

impl ReflectorShape<'_> {
    /// Returns whether a thing may be as wide as a strip.
    pub(crate) fn is_strip(&self, thing: &Bright) -> bool {
        let most = thing.extent + 2.0 * thing.spacing;
        thing.extent <= self.width + self.tolerance && most >= self.width * libm::cos(MAX_ANGLE)
    }

    /// Returns the reflectors of this shape among bright things: the middle, and the direction in which each faces.
    pub(crate) fn find(&self, things: &[Bright]) -> Vec<Pose2D> {
        let ends = self.offsets.first().zip(self.offsets.last());
        let Some((right, left)) = ends.filter(|(right, left)| right < left) else {
            return Vec::new();
        };
        let strips: Vec<&Bright> = things.iter().filter(|thing| self.is_strip(thing)).collect();
        let pairs = strips
            .iter()
            .flat_map(|from| strips.iter().map(move |to| (*from, *to)));
        pairs
            .filter(|(from, to)| {
                (apart(from.middle, to.middle) - (left - right)).abs() <= self.reach(from).max(self.reach(to))
            })
            .filter_map(|(from, to)| {
                let along = libm::atan2(to.middle.1 - from.middle.1, to.middle.0 - from.middle.0);
                let first = Pose2D::new(from.middle.0, from.middle.1, along - FRAC_PI_2);
                let guess = first.transform(&Pose2D::new(0.0, -right, 0.0));
                self.fit(&guess, things)
            })
            .collect()
    }

    /// How far a strip may be from its place.
    fn reach(&self, strip: &Bright) -> f64 {
        self.tolerance + strip.spacing
    }

    /// Returns the pose under which the strips are at their places with the least squares; `None` if one of them is not
    /// there, if something else is bright between them, or if the reflector faces elsewhere.
    fn fit(&self, guess: &Pose2D, things: &[Bright]) -> Option<Pose2D> {
        let local = |pose: &Pose2D, thing: &Bright| {
            let local = pose.localize(&Pose2D::new(thing.middle.0, thing.middle.1, 0.0));
            (local.x, local.y)
        };
        let (right, left) = (self.offsets.first()?, self.offsets.last()?);
        let mut parts: Vec<(&Bright, (f64, f64))> = things
            .iter()
            .map(|thing| (thing, local(guess, thing)))
            .filter(|(thing, (x, y))| {
                let reach = self.reach(thing);
                x.abs() <= DEPTH && *y >= right - reach && *y <= left + reach
            })
            .collect();
        parts.sort_by(|a, b| a.1.1.total_cmp(&b.1.1));
        if parts.len() != self.offsets.len() || !parts.iter().all(|(thing, _)| self.is_strip(thing)) {
            return None;
        }
        let count = parts.len() as f64;
        let mean = |part: fn((f64, f64)) -> f64| parts.iter().map(|(_, at)| part(*at)).sum::<f64>() / count;
        let (x, y) = (mean(|at| at.0), mean(|at| at.1));
        let middle = self.offsets.iter().sum::<f64>() / count;
        let (mut sin, mut cos) = (0.0, 0.0);
        for ((_, at), offset) in parts.iter().zip(self.offsets) {
            cos += (offset - middle) * (at.1 - y);
            sin -= (offset - middle) * (at.0 - x);
        }
        let turned = Pose2D::new(x, y, libm::atan2(sin, cos)).transform(&Pose2D::new(0.0, -middle, 0.0));
        let pose = guess.transform(&turned);
        let is_there = |(thing, offset): (&Bright, &f64)| {
            apart(local(&pose, thing), (0.0, *offset)) <= self.reach(thing)
        };
        let laser = pose.localize(&Pose2D::ORIGIN);
        let faces = laser.x > 0.0 && libm::atan2(laser.y, laser.x).abs() <= MAX_ANGLE;
        let mut places = parts.iter().map(|(thing, _)| *thing).zip(self.offsets);
        (faces && places.all(is_there)).then_some(pose)
    }
}

fn apart(a: (f64, f64), b: (f64, f64)) -> f64 {
    libm::hypot(a.0 - b.0, a.1 - b.1)
}
