//! The places at which scans may have been taken. Each follows the odometry and the scans, and is refuted when another
//! explains them clearly better. They are no particles: none is drawn, so none is lost by chance.

use core::f32::consts::TAU;

use jde_types::Pose2D;

use crate::beams::Beams;
use crate::fit::Comparison;
use crate::search::PoseSearch;

/// By how much more a place must speak for itself than another, so that it is clearly the better one. A scan says up to 1.
const CLEAR: f32 = 0.3;
/// How many places are kept.
const MOST: usize = 64;
/// Poses are of one place if they are nearer to each other than this, m and rad.
const NEAR: f32 = 0.5;
const NEAR_TURN: f32 = 0.35;
/// Differences between two scans below this are those of the map and of the laser.
pub(crate) const NOISE: f32 = 0.05;
/// Scans are independent of each other after this way and this turn, m and rad.
const WAY: f64 = 0.5;
const TURN: f64 = 0.5;
/// The beams by which a place follows the robot.
const BEAMS: usize = 60;
/// The first step by which a place follows a scan, m, and for each metre of way.
const FOLLOWS: f32 = 0.1;
/// The turns from which it begins, rad: after a long way the odometry errs by more than a fit notices.
const TURNS: [f32; 5] = [-0.1, -0.05, 0.0, 0.05, 0.1];

/// A place in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) pose: [f32; 3],
    /// How far the last scan speaks for it.
    pub(crate) support: f32,
    /// By how much the scans have spoken more for the best of all, in sum.
    behind: f32,
}

/// The places, the best of the last scan first after a search.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    places: Vec<Place>,
    /// Whether there may be more, as good as these.
    is_cut: bool,
    beams: Beams,
    /// In m.
    cell: f32,
}

impl Places {
    pub(crate) fn new(cell: f64) -> Self {
        Self {
            places: Vec::with_capacity(MOST),
            is_cut: false,
            beams: Beams::new(BEAMS),
            cell: cell as f32,
        }
    }

    pub(crate) fn clear(&mut self) {
        self.places.clear();
        self.is_cut = false;
    }

    /// Whether the search may have left out places that are as good.
    pub(crate) const fn is_cut(&self) -> bool {
        self.is_cut
    }

    pub(crate) fn as_slice(&self) -> &[Place] {
        &self.places
    }

    /// Whether two poses in cells are of one place.
    pub(crate) fn is_same(&self, a: [f32; 3], b: [f32; 3]) -> bool {
        let near = NEAR / self.cell;
        let turn = (a[2] - b[2] + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        libm::hypotf(a[0] - b[0], a[1] - b[1]) < near && turn.abs() < NEAR_TURN
    }

    /// Takes over the places of a search that is sorted. Each is fitted to the scan, by steps of at most `reach` cells.
    pub(crate) fn find(&mut self, search: &PoseSearch, scan: &Comparison<'_>, reach: f32) {
        self.clear();
        for pose in search.candidates() {
            if self.places.len() < MOST && !self.places.iter().any(|place| self.is_same(place.pose, pose)) {
                self.places.push(Place {
                    pose,
                    support: 0.0,
                    behind: 0.0,
                });
            }
        }
        for place in &mut self.places {
            // A pose of a search is far from the best of its place: the second climb begins with large steps again.
            place.pose = scan.climb(scan.climb(place.pose, reach), reach);
            place.support = scan.fit(place.pose).support;
        }
        // Behind the last come others that are no better at first sight.
        let last = self.places.last().map(|place| place.support);
        let count = self.places.len();
        self.places
            .sort_unstable_by(|a, b| b.support.total_cmp(&a.support));
        // Two may have climbed to one pose.
        let mut at = 0;
        while at < self.places.len() {
            let pose = self.places[at].pose;
            let is_double = self.places[..at]
                .iter()
                .any(|better| self.is_same(better.pose, pose));
            if is_double {
                self.places.remove(at);
            } else {
                at += 1;
            }
        }
        // One scan refutes only what it clearly speaks against, and is no evidence beyond that.
        let best = self.places.first().map_or(0.0, |place| place.support);
        self.places.retain(|place| best - place.support - NOISE < CLEAR);
        let worst = self.places.last().map(|place| place.support);
        self.is_cut = (count == MOST || search.is_cut()) && last >= worst;
    }

    /// Moves all by a motion of the base and then to where the scan fits.
    pub(crate) fn follow(&mut self, delta: &Pose2D, scan: &Comparison<'_>) {
        self.shift(delta);
        self.beams.thin(scan.beams);
        let scan = Comparison {
            beams: &self.beams,
            ..*scan
        };
        let way = libm::hypot(delta.x, delta.y);
        let reach = FOLLOWS * (way as f32).max(1.0) / self.cell;
        for place in &mut self.places {
            let [x, y, heading] = place.pose;
            let starts = TURNS.map(|turn| [x, y, heading + turn]);
            let best = starts
                .into_iter()
                .max_by(|a, b| scan.ends(*a).total_cmp(&scan.ends(*b)));
            place.pose = scan.climb(best.unwrap_or(place.pose), reach);
            place.support = scan.fit(place.pose).support;
        }
        self.compare((way / WAY + delta.theta.abs() / TURN).min(1.0) as f32);
    }

    /// Moves all by a motion of the base in m.
    pub(crate) fn shift(&mut self, delta: &Pose2D) {
        let (ahead, left) = (delta.x as f32 / self.cell, delta.y as f32 / self.cell);
        for Place { pose, .. } in &mut self.places {
            let (sin, cos) = libm::sincosf(pose[2]);
            pose[0] += cos * ahead - sin * left;
            pose[1] += sin * ahead + cos * left;
            pose[2] += delta.theta as f32;
        }
    }

    /// Counts the last scan with a weight, and leaves out what is refuted.
    fn compare(&mut self, weight: f32) {
        let best = (self.places.iter()).fold(f32::NEG_INFINITY, |best, place| best.max(place.support));
        for place in &mut self.places {
            let behind = (best - place.support - NOISE).max(0.0);
            place.behind += weight * behind;
        }
        let least = (self.places.iter()).fold(f32::INFINITY, |least, place| least.min(place.behind));
        self.places.retain(|place| place.behind < least + CLEAR);
    }

    /// How many explain the scans about as well as this pose; `None` if the pose is none of them.
    pub(crate) fn rivals(&self, pose: [f32; 3]) -> Option<usize> {
        let is_one = self.places.iter().any(|place| self.is_same(place.pose, pose));
        let others = self.places.iter().filter(|place| !self.is_same(place.pose, pose));
        is_one.then(|| others.count())
    }

    /// The best place that is that of this pose, and how far the last scan speaks for it.
    pub(crate) fn best_of(&self, pose: [f32; 3]) -> Option<([f32; 3], f32)> {
        let own = self.places.iter().filter(|place| self.is_same(place.pose, pose));
        let best = own.max_by(|a, b| a.support.total_cmp(&b.support));
        best.map(|place| (place.pose, place.support))
    }

    /// How far the last scan speaks for the best place that is not that of this pose.
    pub(crate) fn best_beside(&self, pose: [f32; 3]) -> Option<f32> {
        let others = self.places.iter().filter(|place| !self.is_same(place.pose, pose));
        others.map(|place| place.support).max_by(f32::total_cmp)
    }
}
