//! The directions around a base, and what is first in each.

use core::f64::consts::{PI, TAU};

use jde_motion::Outline;
use jde_schema::types::{LaserScan, Point2D};

use crate::eye::TOLERANCE;

/// The beams of a merged scan: as many as divide a turn into thirds of a degree. A `LaserScan` has room for 1088.
const BEAMS: usize = 1080;
const INCREMENT: f64 = TAU / BEAMS as f64;
/// The least distance from the centre of the base, m: nearer, a thing is in no direction.
const RANGE_MIN: f64 = 0.001;
/// Step in which the way to the outline is searched, m.
const STEP: f64 = 0.01;
/// By how much of its distance a place on a ray is farther than the one before it, and by how much at least, m.
const GROWTH: f64 = 0.02;
const LEAST_STEP: f64 = 0.05;
/// A thing up to so far behind what no laser looks at is as near as that, m: more than a robot needs to stop. What is
/// farther behind it is left out, and the direction unknown.
const BEHIND: f64 = 0.3;

/// What is first in each direction from the centre of a base.
#[derive(Debug)]
pub(crate) struct Circle {
    /// Where the outline of the robot ends, m.
    edges: Vec<f64>,
    /// The distance of the nearest thing, m; +∞ if there is none.
    nearest: Vec<f64>,
}

impl Circle {
    /// Nothing is around a robot with this outline.
    pub(crate) fn new(outline: &Outline) -> Self {
        let edge = |beam| {
            let (sin, cos) = libm::sincos(angle(beam));
            let steps = (0..).map(|step| f64::from(step) * STEP);
            let inside = steps.take_while(|at| outline.distance(at * cos, at * sin) < 0.0);
            inside.last().unwrap_or_default() + STEP
        };
        Self {
            edges: (0..BEAMS).map(edge).collect(),
            nearest: vec![f64::INFINITY; BEAMS],
        }
    }

    /// Forgets what is around.
    pub(crate) fn clear(&mut self) {
        self.nearest.fill(f64::INFINITY);
    }

    /// Adds a thing at a point in the frame of the base.
    pub(crate) fn add(&mut self, point: &Point2D) {
        let beam = ((libm::atan2(point.y, point.x) + PI) / INCREMENT).round() as usize % BEAMS;
        let range = libm::hypot(point.x, point.y).max(RANGE_MIN * 2.0);
        self.nearest[beam] = self.nearest[beam].min(range);
    }

    /// Returns points along the edge of the outline from one direction to another, one for each beam.
    pub(crate) fn edge(&self, from: f64, to: f64) -> impl Iterator<Item = Point2D> {
        let count = ((to - from).abs() / INCREMENT).ceil().max(1.0);
        (0..=count as u32).map(move |step| {
            let angle = from + (to - from) * f64::from(step) / count;
            let beam = ((angle + PI) / INCREMENT).round().rem_euclid(BEAMS as f64) as usize;
            let (sin, cos) = libm::sincos(angle);
            let at = self.edges[beam.min(BEAMS - 1)];
            Point2D {
                x: at * cos,
                y: at * sin,
            }
        })
    }

    /// Returns a point, moved to the edge of the outline if it is inside.
    pub(crate) fn outward(&self, point: Point2D) -> Point2D {
        let angle = libm::atan2(point.y, point.x);
        let edge = self.edge(angle, angle).next().unwrap_or(point);
        if libm::hypot(point.x, point.y) < libm::hypot(edge.x, edge.y) {
            edge
        } else {
            point
        }
    }

    /// Writes the scan of it up to `range_max` m. A beam goes only through places that are seen, from the outline on. One
    /// that would go farther ends there if a thing is little farther, and is unknown otherwise. Returns whether anything is
    /// known.
    pub(crate) fn write(
        &self,
        scan: &mut LaserScan,
        range_max: f64,
        sees: impl Fn(&Point2D) -> bool,
    ) -> bool {
        scan.angle_min = -PI as f32;
        scan.angle_increment = INCREMENT as f32;
        scan.time_increment = 0.0;
        scan.scan_time = 0.0;
        scan.range_min = RANGE_MIN as f32;
        scan.range_max = range_max as f32;
        scan.intensities.clear();
        let mut is_known = false;
        for (beam, range) in scan.ranges.resize(BEAMS).iter_mut().enumerate() {
            let nearest = self.nearest[beam];
            let is_thing = nearest < range_max;
            // The place of a thing is known up to the tolerance.
            let until = if is_thing { nearest - TOLERANCE } else { range_max };
            *range = match self.first_unseen(beam, until, &sees) {
                None if is_thing => nearest as f32,
                None => f32::INFINITY,
                Some(at) if is_thing && nearest - at <= BEHIND => at as f32,
                Some(_) => f32::NAN,
            };
            is_known |= !range.is_nan();
        }
        scan.state_last_angle();
        is_known
    }

    /// Returns what is first in the directions in which something is, in the frame of the base.
    pub(crate) fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let things = self.nearest.iter().enumerate();
        things
            .filter(|(_, range)| range.is_finite())
            .map(|(beam, range)| {
                let (sin, cos) = libm::sincos(angle(beam));
                (range * cos, range * sin)
            })
    }

    /// Returns where the first place is that is not seen on the way from the outline to `until` m, m; `None` if all are.
    fn first_unseen(&self, beam: usize, until: f64, sees: impl Fn(&Point2D) -> bool) -> Option<f64> {
        let (sin, cos) = libm::sincos(angle(beam));
        let first = self.edges[beam] + STEP;
        let next = |at: &f64| (*at < until).then(|| (at + LEAST_STEP.max(GROWTH * at)).min(until));
        let mut places = core::iter::successors((first <= until).then_some(first), next);
        places.find(|at| {
            !sees(&Point2D {
                x: at * cos,
                y: at * sin,
            })
        })
    }
}

fn angle(beam: usize) -> f64 {
    beam as f64 * INCREMENT - PI
}
