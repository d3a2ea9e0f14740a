//! What a scan shows: points of surfaces and which way they face, and how far nothing is.

use jde_types::{LaserScan, Pose2D};

/// The fewest points of a surface that say where a robot is.
pub(crate) const MIN_POINTS: usize = 8;
/// Beams to each side that make the line through a point.
const SIDE: usize = 2;
/// Neighbours of a line are no farther apart than this, m, or so many times the distance of beams there.
const GAP: (f32, f32) = (0.15, 5.0);
/// The deviation of points across a line, as a share of that along it.
const FLAT: f32 = 0.3;

/// So many beams beside each other must meet nothing for one of them to say that nothing is there: some lasers say the same of a
/// beam that comes back from a dark or an oblique surface too weakly.
const FREE_BEAMS: (f64, f64) = (2.0, 5.0);
/// Within these limits, so many that they are as wide as this, rad.
const FREE_WIDTH: f64 = 0.09;

/// The angle from which on beams are on all sides, rad.
const ALL_AROUND: f64 = 0.97 * core::f64::consts::TAU;
/// In how many directions a scan keeps how far it sees: as wide as a beam of a coarse laser.
const DIRECTIONS: usize = 120;
/// How far beams must go beyond a place to have gone through it, and how far to either side of it they must, m: more than
/// poses err. Along a wall, a small error of the pose is a large one of the depth.
pub(crate) const THROUGH: (f32, f32) = (0.3, 0.2);

/// The number of a beam, its length, +∞ if it met nothing, and where it ends, m.
pub(crate) type End = (usize, f32, (f32, f32));

/// A point of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfacePoint {
    /// Where it is, m.
    pub at: (f32, f32),
    /// The unit normal of the surface, toward the laser; zero at corners and at what is narrow.
    pub normal: (f32, f32),
}

impl SurfacePoint {
    /// Whether there is a normal.
    pub(crate) fn is_flat(&self) -> bool {
        self.normal != (0.0, 0.0)
    }

    /// The point, moved and turned from the frame of `pose` to that which `pose` is in.
    pub(crate) fn moved(&self, (x, y): (f32, f32), (sin, cos): (f32, f32)) -> Self {
        let turn = |(ahead, left): (f32, f32)| (cos * ahead - sin * left, sin * ahead + cos * left);
        let at = turn(self.at);
        Self {
            at: (x + at.0, y + at.1),
            normal: turn(self.normal),
        }
    }
}

/// A scan in the frame of the base.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scan {
    points: Vec<SurfacePoint>,
    /// Ends of beams that met nothing, m.
    free: Vec<(f32, f32)>,
    /// Where the beams begin, m.
    mount: (f32, f32),
    /// How far it sees at least in each direction around, m; 0 where no beam goes.
    depths: Vec<f32>,
    /// The angle between its first and its last beam, rad.
    view: f64,
    /// The angle between two beams, rad.
    increment: f32,
    /// For each point how many more scans looked through it than met it.
    pub(crate) doubts: Vec<i8>,
    /// How many points it has lost.
    forgotten: usize,
}

impl Scan {
    /// Reads a scan of a laser that is at `laser` at each beam, in the frame of the base: at most `most` beams, evenly chosen,
    /// and as far as `reach` m. Nothing of a scan that is none.
    #[must_use]
    pub fn new(scan: &LaserScan, laser: impl Fn(usize) -> Pose2D, most: usize, reach: f64) -> Self {
        let mount = laser(0);
        if !mount.is_finite() || !reach.is_finite() || scan.measured().is_err() {
            return Self::default();
        }
        let start = (mount.x as f32, mount.y as f32);
        let ends: Vec<End> = (scan.lengths())
            .map(|(beam, length, hit)| {
                let is_hit = hit && length <= reach as f32;
                let length = length.min(reach as f32);
                let range = if is_hit { length } else { f32::INFINITY };
                let from = laser(beam);
                let (sin, cos) = libm::sincos(from.theta + scan.angle(beam));
                let end = (
                    from.x as f32 + length * cos as f32,
                    from.y as f32 + length * sin as f32,
                );
                (beam, range, end)
            })
            .collect();
        let increment = scan.angle_increment.abs();
        let view = f64::from(increment) * scan.ranges.len() as f64;
        // What a narrow view has in common with the last one is little: all of it counts.
        let ends = if view > ALL_AROUND {
            let least = (FREE_WIDTH / f64::from(increment)).clamp(FREE_BEAMS.0, FREE_BEAMS.1);
            without_lone(&ends, scan.ranges.len(), least as usize)
        } else {
            ends
        };
        let mut read = Self::of_ends(&ends, increment, start, most);
        read.view = view;
        read
    }

    /// The scan with these ends of beams from a laser at `mount`: at most `most`, evenly chosen.
    pub(crate) fn of_ends(ends: &[End], increment: f32, mount: (f32, f32), most: usize) -> Self {
        let step = ends.len().div_ceil(most.max(1)).max(1);
        let mut read = Self {
            mount,
            depths: vec![0.0; DIRECTIONS],
            increment,
            ..Self::default()
        };
        for &(_, _, end) in ends {
            let (direction, length) = polar(end, mount);
            let depth = &mut read.depths[direction];
            *depth = if *depth == 0.0 { length } else { depth.min(length) };
        }
        for number in (0..ends.len()).step_by(step) {
            let (_, range, at) = ends[number];
            if range.is_finite() {
                let normal = normal(ends, number, increment, mount);
                read.points.push(SurfacePoint { at, normal });
            } else {
                read.free.push(at);
            }
        }
        read.doubts = vec![0; read.points.len()];
        read
    }

    /// Returns the points of surfaces.
    #[must_use]
    pub fn points(&self) -> &[SurfacePoint] {
        &self.points
    }

    /// Returns the ends of beams that met nothing, m.
    #[must_use]
    pub fn free(&self) -> &[(f32, f32)] {
        &self.free
    }

    /// Returns where the beams begin, m.
    #[must_use]
    pub const fn mount(&self) -> (f32, f32) {
        self.mount
    }

    /// The same, said to show what is on all sides.
    pub(crate) fn all_around(self) -> Self {
        Self {
            view: core::f64::consts::TAU,
            ..self
        }
    }

    /// Returns whether it shows what is on all sides, so that it shows the same with every heading.
    #[must_use]
    pub fn is_all_around(&self) -> bool {
        self.view > ALL_AROUND
    }

    /// Returns the angle between its first and its last beam, rad.
    #[must_use]
    pub const fn view(&self) -> f64 {
        self.view
    }

    /// Whether its beams go through a place in its frame, m: so far beyond it, and so far to either side of it. `None` if none
    /// of them tells.
    pub(crate) fn sees_through(&self, place: (f32, f32), (beyond, beside): (f32, f32)) -> Option<bool> {
        let (direction, length) = polar(place, self.mount);
        if self.depths.is_empty() || length < beside {
            return None;
        }
        let beside = beside / length * DIRECTIONS as f32 / core::f32::consts::TAU;
        let beside = libm::ceilf(beside) as usize;
        let first = direction + DIRECTIONS - beside;
        let depths = (first..=first + 2 * beside).map(|at| self.depths[at % DIRECTIONS]);
        let depth = depths.fold(f32::INFINITY, f32::min);
        (depth > 0.0 && length < depth + beyond).then_some(length < depth - beyond)
    }

    /// The angle between two beams, rad.
    pub(crate) const fn increment(&self) -> f32 {
        self.increment
    }

    /// A place as it is seen from the laser, m.
    pub(crate) fn ray_to(&self, place: (f32, f32)) -> (f32, f32) {
        (place.0 - self.mount.0, place.1 - self.mount.1)
    }

    /// Takes away the points that are gone: the beams that met them are free as far as that.
    pub(crate) fn forget(&mut self, is_gone: impl Fn(&SurfacePoint) -> bool) {
        let mut kept = 0;
        for at in 0..self.points.len() {
            if is_gone(&self.points[at]) {
                self.free.push(self.points[at].at);
                continue;
            }
            (self.points[kept], self.doubts[kept]) = (self.points[at], self.doubts[at]);
            kept += 1;
        }
        self.forgotten += self.points.len() - kept;
        self.points.truncate(kept);
        self.doubts.truncate(kept);
    }

    /// The share of its points that it has lost.
    pub(crate) fn forgotten_share(&self) -> f64 {
        self.forgotten as f64 / (self.forgotten + self.points.len()).max(1) as f64
    }

    /// Returns whether it has enough points to say where a robot is.
    #[must_use]
    pub fn is_enough(&self) -> bool {
        self.points.len() >= MIN_POINTS
    }
}

/// The ends without those beams that met nothing beside fewer than `least` others, of a scan of so many beams.
fn without_lone(ends: &[End], beams: usize, least: usize) -> Vec<End> {
    let mut is_free = vec![false; beams];
    for &(beam, ..) in ends.iter().filter(|(_, range, _)| range.is_infinite()) {
        is_free[beam] = true;
    }
    let mut kept = vec![true; beams];
    let mut first = 0;
    for run in is_free.chunk_by(|a, b| a == b) {
        kept[first..first + run.len()].fill(!run[0] || run.len() >= least);
        first += run.len();
    }
    ends.iter().filter(|(beam, ..)| kept[*beam]).copied().collect()
}

/// In which of the directions from a laser a place is, and how far, m.
fn polar(place: (f32, f32), laser: (f32, f32)) -> (usize, f32) {
    let (dx, dy) = (place.0 - laser.0, place.1 - laser.1);
    let turns = libm::atan2f(dy, dx) / core::f32::consts::TAU + 0.5;
    let direction = (turns * DIRECTIONS as f32) as usize;
    (direction.min(DIRECTIONS - 1), libm::hypotf(dx, dy))
}

/// The normal of the line through the neighbours of an end, toward the laser; zero if they are in no line.
fn normal(ends: &[End], number: usize, increment: f32, laser: (f32, f32)) -> (f32, f32) {
    let (_, range, at) = ends[number];
    let gap = GAP.0.max(GAP.1 * range * increment);
    let is_next = |a: usize, b: usize| {
        let ((beam, _, from), (other, range, to)) = (ends[a], ends[b]);
        beam.abs_diff(other) <= 2 && range.is_finite() && libm::hypotf(to.0 - from.0, to.1 - from.1) < gap
    };
    let (mut first, mut last) = (number, number);
    while first > 0 && number - first < SIDE && is_next(first, first - 1) {
        first -= 1;
    }
    while last + 1 < ends.len() && last - number < SIDE && is_next(last, last + 1) {
        last += 1;
    }
    let line = &ends[first..=last];
    if line.len() < 3 {
        return (0.0, 0.0);
    }
    let count = line.len() as f32;
    let sum = |of: fn((f32, f32)) -> f32| line.iter().map(|&(_, _, end)| of(end)).sum::<f32>() / count;
    let (x, y) = (sum(|end| end.0), sum(|end| end.1));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for &(_, _, end) in line {
        let (dx, dy) = (end.0 - x, end.1 - y);
        (xx, xy, yy) = (xx + dx * dx, xy + dx * dy, yy + dy * dy);
    }
    let (middle, radius) = (f32::midpoint(xx, yy), libm::hypotf((xx - yy) / 2.0, xy));
    let (along, across) = (middle + radius, (middle - radius).max(0.0));
    if across > FLAT * FLAT * along || along <= 0.0 {
        return (0.0, 0.0);
    }
    let direction = 0.5 * libm::atan2f(2.0 * xy, xx - yy);
    let (sin, cos) = libm::sincosf(direction);
    let toward = (laser.0 - at.0) * -sin + (laser.1 - at.1) * cos;
    if toward >= 0.0 { (-sin, cos) } else { (sin, -cos) }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use super::*;

    fn laser(ranges: &[f32]) -> LaserScan {
        let mut scan = LaserScan {
            angle_min: -0.5,
            angle_increment: 0.02,
            range_min: 0.1,
            range_max: 30.0,
            ..LaserScan::default()
        };
        scan.ranges.extend_from_slice(ranges).expect("few beams");
        scan.state_last_angle();
        scan
    }

    fn read(ranges: &[f32]) -> Scan {
        Scan::new(&laser(ranges), |_| Pose2D::ORIGIN, 360, 20.0)
    }

    /// A wall 3 m ahead.
    fn wall() -> Vec<f32> {
        (0..50)
            .map(|beam| 3.0 / libm::cosf(-0.5 + 0.02 * beam as f32))
            .collect()
    }

    #[test]
    fn a_wall_faces_the_laser() {
        let scan = read(&wall());
        assert_eq!(scan.points().len(), 50);
        for point in scan.points() {
            assert!((point.at.0 - 3.0).abs() < 1e-3, "{point:?}");
            assert!(
                point.normal.0 < -0.999 && point.normal.1.abs() < 0.02,
                "{point:?}"
            );
        }
    }

    #[test]
    fn corners_and_single_points_have_no_normal() {
        // A post before the wall.
        let mut ranges = wall();
        ranges[20] = 1.0;
        let scan = read(&ranges);
        let flat = scan.points().iter().filter(|point| point.is_flat()).count();
        assert_eq!((scan.points()[20].is_flat(), flat), (false, 49));
        // The wall in a corner, 3 m to each side.
        let corner = (0..50).map(|beam| {
            let (sin, cos) = libm::sincosf(-0.5 + 0.02 * beam as f32 + core::f32::consts::FRAC_PI_4);
            3.0 / sin.max(cos)
        });
        let scan = read(&corner.collect::<Vec<_>>());
        assert!(!scan.points()[25].is_flat() && scan.points()[10].is_flat());
    }

    #[test]
    fn what_says_nothing_is_left_out_and_what_is_far_is_free() {
        for range in [f32::NAN, f32::NEG_INFINITY, 0.05, -1.0] {
            let scan = read(&[range; 50]);
            assert_eq!((scan.points().len(), scan.free().len()), (0, 0), "{range}");
            assert!(!scan.is_enough());
        }
        for range in [f32::INFINITY, 25.0, 30.0] {
            let scan = read(&[range; 50]);
            assert_eq!((scan.points().len(), scan.free().len()), (0, 50), "{range}");
            assert!(
                scan.free()
                    .iter()
                    .all(|end| (end.0.hypot(end.1) - 20.0).abs() < 1e-4)
            );
        }
        let nowhere = Pose2D::new(f64::NAN, 0.0, 0.0);
        assert_eq!(
            Scan::new(&laser(&wall()), |_| nowhere, 360, 20.0),
            Scan::default()
        );
        assert_eq!(read(&[]), Scan::default());
    }

    #[test]
    fn a_beam_that_nothing_came_back_from_between_others_that_met_a_wall_says_nothing() {
        let around = |ranges: &[f32]| {
            let mut scan = laser(ranges);
            scan.angle_increment = core::f32::consts::TAU / ranges.len() as f32;
            scan.state_last_angle();
            let scan = Scan::new(&scan, |_| Pose2D::ORIGIN, 720, 20.0);
            (scan.points().len(), scan.free().len())
        };
        let mut ranges = [3.0; 500];
        (ranges[10], ranges[20], ranges[21]) = (f32::INFINITY, f32::INFINITY, 30.0);
        assert_eq!(around(&ranges), (497, 0));
        ranges[30..35].fill(f32::INFINITY);
        assert_eq!(around(&ranges), (492, 5), "a door");
        // A laser of few beams sees a door by two of them.
        let mut coarse = [3.0; 100];
        (coarse[10], coarse[20], coarse[21]) = (f32::INFINITY, f32::INFINITY, 30.0);
        assert_eq!(around(&coarse), (97, 2));
        // Of a narrow view all counts.
        let mut ranges = wall();
        ranges[10] = f32::INFINITY;
        let scan = read(&ranges);
        assert_eq!((scan.points().len(), scan.free().len()), (49, 1));
    }

    #[test]
    fn it_is_in_the_frame_of_the_base_and_thinned() {
        let mount = Pose2D::new(0.2, 0.1, FRAC_PI_2);
        let scan = Scan::new(&laser(&wall()), |_| mount, 10, 20.0);
        assert_eq!((scan.points().len(), scan.mount()), (10, (0.2, 0.1)));
        assert!(scan.points().iter().all(|point| (point.at.1 - 3.1).abs() < 1e-3));
    }
}
