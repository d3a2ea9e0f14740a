//! From scans and odometry to keyframes, and where the robot is among them.

mod settings;

use core::fmt;

use jde_types::{Pose2D, normalize_angle};

use crate::graph::{Edge, Graph, Relation};
use crate::icp::{Fit, Guess};
use crate::loops::Loops;
use crate::matrix::{Matrix, ZERO, add, diagonal, invert, product, transpose};
use crate::scan::Scan;
use crate::surface::Surface;

pub use settings::Settings;

/// How far keyframes may be that a scan is matched with, m.
pub(crate) const NEAR: f64 = 6.0;
/// The most keyframes that a scan is matched with.
const JOINED: usize = 16;
/// What a turn counts among the distances of keyframes, m/rad.
pub(crate) const LEVER: f64 = 0.5;
/// The most points that a correlation looks at.
const FEW: usize = 120;

/// Of so many scans of a robot that stands, one is compared with what is known.
const STANDING: usize = 10;

/// The covariance of a place at which no scan has fitted yet, and its inverse: 0.3 m and 0.2 rad.
const UNCERTAIN: Matrix = diagonal([0.09, 0.09, 0.04]);
const UNSURE: Matrix = diagonal([11.0, 11.0, 25.0]);

/// Where the robot is: a pose in the frame of a keyframe. It stays right when the graph moves the keyframe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// The number of the keyframe.
    pub keyframe: usize,
    /// The pose in its frame.
    pub pose: Pose2D,
}

/// What came of a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    /// There is no scan yet from which a map could begin.
    Empty,
    /// The scan fits what is known; the number is the share of its points that do.
    Fits(f64),
    /// It does not; the pose is that of the odometry.
    Differs(f64),
    /// It has too few points; the pose is that of the odometry.
    Blind,
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("no scan yet"),
            Self::Fits(share) => write!(f, "{:.0} % of the points are on known surfaces", 100.0 * share),
            Self::Differs(share) => write!(
                f,
                "only {:.0} % of the points are on known surfaces: the odometry says where the robot is",
                100.0 * share
            ),
            Self::Blind => f.write_str("the scan has too few points: the odometry says where the robot is"),
        }
    }
}

/// Keyframes, the graph of their poses, and the robot among them.
#[derive(Clone, Debug, Default)]
pub struct Slam {
    pub(crate) graph: Graph,
    pub(crate) scans: Vec<Scan>,
    /// For each keyframe those that edges lead to.
    pub(crate) near: Vec<Vec<usize>>,
    start: Pose2D,
    /// How many keyframes are of a map that is continued.
    pub(crate) given: usize,
    anchor: Option<Anchor>,
    /// The pose of the odometry at the anchor, or at the start until there is one.
    odometry: Option<Pose2D>,
    state: Option<State>,
    /// Whether the robot may be elsewhere since the last scan.
    is_doubted: bool,
    /// How many scans were not matched since one was, as the robot stood.
    unmatched: usize,
    /// The covariance of the pose at the anchor, in the frame of the map.
    covariance: Matrix,
    /// The surfaces around the anchor's keyframe, in its frame.
    surface: Option<Surface>,
    loops: Loops,
}

impl Slam {
    /// Returns an empty map, on which the robot is here when it takes its first scan.
    #[must_use]
    pub fn new(start: Pose2D) -> Self {
        Self {
            start,
            covariance: UNCERTAIN,
            ..Self::default()
        }
    }

    /// The robot is at the start at this pose of the odometry. Only the first call counts, before the first scan.
    pub fn start_at(&mut self, odometry: &Pose2D) {
        self.odometry.get_or_insert(*odometry);
    }

    /// Returns how many of the keyframes are of a map that is continued.
    #[must_use]
    pub const fn given(&self) -> usize {
        self.given
    }

    /// Returns the pose of the odometry at the last scan that was matched, or at the start until there is one.
    #[must_use]
    pub const fn odometry(&self) -> Option<Pose2D> {
        self.odometry
    }

    /// Returns the graph: a pose for each keyframe, in the frame of the map.
    #[must_use]
    pub const fn graph(&self) -> &Graph {
        &self.graph
    }

    /// Returns the scan of each keyframe.
    #[must_use]
    pub fn scans(&self) -> &[Scan] {
        &self.scans
    }

    /// Returns what came of the last scan.
    #[must_use]
    pub fn state(&self) -> State {
        self.state.unwrap_or(State::Empty)
    }

    /// Returns where the robot is at this pose of the odometry.
    #[must_use]
    pub fn anchor(&self, odometry: &Pose2D) -> Option<Anchor> {
        self.anchor.map(|anchor| Anchor {
            pose: anchor.pose.transform(&self.moved(odometry)),
            ..anchor
        })
    }

    /// Returns an anchor's pose in the frame of the map.
    #[must_use]
    pub fn place(&self, anchor: &Anchor) -> Pose2D {
        self.graph.poses()[anchor.keyframe].transform(&anchor.pose)
    }

    /// Returns the pose in the frame of the map at this pose of the odometry; before the first scan, by the start.
    #[must_use]
    pub fn pose(&self, odometry: &Pose2D) -> Pose2D {
        self.anchor(odometry).map_or_else(
            || self.start.transform(&self.moved(odometry)),
            |anchor| self.place(&anchor),
        )
    }

    /// Returns the points that keyframes show, in the frame of the map, m: every so many that they are at most `most`.
    pub fn points(&self, most: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
        let count: usize = self.scans.iter().map(|scan| scan.points().len()).sum();
        let all = (0..self.scans.len()).flat_map(|keyframe| self.hits(keyframe));
        all.step_by(count.div_ceil(most.max(1)).max(1))
    }

    /// The points that a keyframe shows, in the frame of the map, m.
    pub(crate) fn hits(&self, keyframe: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
        let pose = self.graph.poses()[keyframe];
        let points = self.scans[keyframe].points().iter();
        points.map(move |point| placed(&pose, point.at))
    }

    /// How far the robot has moved since the anchor, by the odometry.
    fn moved(&self, odometry: &Pose2D) -> Pose2D {
        self.odometry
            .map_or(Pose2D::ORIGIN, |last| last.localize(odometry))
    }

    /// Returns the covariance of the pose at this pose of the odometry, in the frame of the map: x, y, heading. The odometry
    /// adds to it, and each match takes away what the points of its scan say. From a scan that does not fit on, it begins with
    /// that of 0.3 m and 0.2 rad.
    #[must_use]
    pub fn covariance(&self, settings: &Settings, odometry: &Pose2D) -> Matrix {
        let mut covariance = self.covariance;
        let deviations = settings.deviations(&self.moved(odometry));
        add(&mut covariance, 1.0, &diagonal(deviations.map(|of| of * of)));
        covariance
    }

    /// Whether the last scan fits, and the robot was not moved since without the odometry.
    const fn is_sure(&self) -> bool {
        matches!(self.state, Some(State::Fits(_))) && !self.is_doubted
    }

    /// The robot may have been moved since the last scan: the next one is matched, to 0.3 m and 0.2 rad.
    pub const fn doubt(&mut self) {
        if self.is_sure() {
            self.covariance = UNCERTAIN;
        }
        self.is_doubted = true;
    }

    /// The odometry jumped to another pose without a motion of the robot.
    pub fn jump(&mut self, from: &Pose2D, to: &Pose2D) {
        self.odometry = self.odometry.map(|last| to.transform(&from.localize(&last)));
    }

    /// Takes a scan, and the pose of the odometry at its time.
    ///
    /// Takes time by the number of points of one scan and of the sixteen keyframes that it is matched with. While the robot
    /// stands, only every tenth scan is looked at, and matched if it fits no longer.
    pub fn step(&mut self, settings: &Settings, odometry: &Pose2D, scan: &Scan) -> State {
        let was_sure = self.is_sure();
        let state = self.take(settings, odometry, scan);
        self.state = Some(state);
        if was_sure && !self.is_sure() {
            self.covariance = UNCERTAIN;
        }
        state
    }

    fn take(&mut self, settings: &Settings, odometry: &Pose2D, scan: &Scan) -> State {
        self.start_at(odometry);
        let Some(anchor) = self.anchor(odometry) else {
            if !scan.is_enough() {
                return State::Empty;
            }
            self.add_keyframe(self.pose(odometry), scan);
            self.set_anchor(Anchor {
                keyframe: 0,
                pose: Pose2D::ORIGIN,
            });
            self.odometry = Some(*odometry);
            self.covariance = ZERO;
            self.is_doubted = false;
            return State::Fits(1.0);
        };
        if !scan.is_enough() {
            return State::Blind;
        }
        let motion = self.moved(odometry);
        let way = libm::hypot(motion.x, motion.y);
        let is_moved = way >= settings.update.0 || motion.theta.abs() >= settings.update.1;
        let was_sure = self.is_sure();
        if !is_moved && was_sure {
            self.unmatched += 1;
            if !self.unmatched.is_multiple_of(STANDING) {
                return self.state();
            }
            let share = self.surface(&anchor).share(scan.points(), &anchor.pose);
            if share >= settings.share {
                return State::Fits(share);
            }
        }
        self.unmatched = 0;
        let guess = Guess {
            pose: anchor.pose,
            information: if was_sure {
                settings.information(&motion)
            } else {
                UNSURE
            },
        };
        self.is_doubted = false;
        let fit = self.fit(settings, &guess, &anchor, scan);
        self.covariance = self.covariance(settings, odometry);
        self.odometry = Some(*odometry);
        let share = fit.map_or(0.0, |fit| fit.share);
        let fit = fit.filter(|fit| fit.share >= settings.share);
        let heading = self.graph.poses()[anchor.keyframe].theta;
        let information = turned(&fit.map_or(ZERO, |fit| fit.information), heading);
        if let Some(mut both) = invert(&self.covariance) {
            add(&mut both, 1.0, &information);
            self.covariance = invert(&both).unwrap_or(self.covariance);
        }
        let pose = fit.map_or(anchor.pose, |fit| fit.pose);
        let anchor = self.nearest(&Anchor { pose, ..anchor });
        self.set_anchor(anchor);
        if fit.is_none() {
            return State::Differs(share);
        }
        let (way, turn) = (libm::hypot(anchor.pose.x, anchor.pose.y), anchor.pose.theta.abs());
        let is_turned = turn >= settings.keyframe.1 && !self.scans[anchor.keyframe].is_all_around();
        let is_new = way >= settings.keyframe.0 || is_turned;
        // A match far around may be wrong by chance: what it says is kept when the next one agrees.
        let is_kept = was_sure && (is_new || self.is_beyond(settings, &anchor, share));
        if is_kept && self.scans.len() < settings.most {
            self.keep(settings, &anchor, scan, &information);
        }
        State::Fits(share)
    }

    /// Whether a scan shows much that the map does not have that is continued, and no keyframe of its own is near.
    fn is_beyond(&self, settings: &Settings, anchor: &Anchor, share: f64) -> bool {
        let place = self.place(anchor);
        anchor.keyframe < self.given
            && share < f64::midpoint(settings.share, 1.0)
            && (self.given..self.scans.len()).all(|at| self.distance(at, &place) >= settings.keyframe.0)
    }

    /// The surfaces around the keyframe of the anchor.
    fn surface(&mut self, anchor: &Anchor) -> &Surface {
        let surface = self.surface.take().unwrap_or_else(|| {
            let joined = self.around(anchor.keyframe, &self.place(anchor), JOINED);
            self.surface_of(anchor.keyframe, &joined, Surface::levels(0.6))
        });
        self.surface.insert(surface)
    }

    /// Matches a scan with the surfaces around the anchor's keyframe.
    fn fit(&mut self, settings: &Settings, guess: &Guess, anchor: &Anchor, scan: &Scan) -> Option<Fit> {
        let window = settings.window(guess);
        let surface = self.surface(anchor);
        let few: Vec<_> = thin(scan.points(), FEW).collect();
        let found = surface.search(&few, &guess.pose, &window);
        let start = found.map_or(guess.pose, |found| found.pose);
        surface.refine(scan.points(), &start, guess)
    }

    /// The same place in the frame of the nearest keyframe.
    fn nearest(&self, anchor: &Anchor) -> Anchor {
        let (place, poses) = (self.place(anchor), self.graph.poses());
        let keyframe = (self.around(anchor.keyframe, &place, usize::MAX).into_iter())
            .min_by(|&a, &b| self.distance(a, &place).total_cmp(&self.distance(b, &place)))
            .unwrap_or(anchor.keyframe);
        Anchor {
            keyframe,
            pose: poses[keyframe].localize(&place),
        }
    }

    pub(crate) fn set_anchor(&mut self, anchor: Anchor) {
        if self.anchor.replace(anchor).map(|last| last.keyframe) != Some(anchor.keyframe) {
            self.surface = None;
        }
    }

    /// Makes a scan at an anchor a keyframe.
    fn keep(&mut self, settings: &Settings, anchor: &Anchor, scan: &Scan, matched: &Matrix) {
        let keyframe = self.add_keyframe(self.place(anchor), scan);
        // Of what the odometry says since the other keyframe, and what the scan says.
        let mut information = settings.information(&anchor.pose);
        let heading = self.graph.poses()[anchor.keyframe].theta;
        add(&mut information, 1.0, &turned(matched, -heading));
        self.add_edge(Edge {
            from: anchor.keyframe,
            to: keyframe,
            pose: anchor.pose,
            information,
            relation: Relation::Successive,
        });
        self.set_anchor(Anchor {
            keyframe,
            pose: Pose2D::ORIGIN,
        });
    }

    pub(crate) fn add_keyframe(&mut self, pose: Pose2D, scan: &Scan) -> usize {
        self.scans.push(scan.clone());
        self.near.push(Vec::new());
        self.graph.add_pose(pose)
    }

    pub(crate) fn add_edge(&mut self, edge: Edge) {
        self.near[edge.from].push(edge.to);
        self.near[edge.to].push(edge.from);
        self.graph.add_edge(edge);
    }

    /// The keyframes near a place that edges lead to from one of them, over others that are near; the nearest first.
    pub(crate) fn around(&self, keyframe: usize, place: &Pose2D, most: usize) -> Vec<usize> {
        let poses = self.graph.poses();
        let mut found = vec![keyframe];
        let mut is_seen = vec![false; poses.len()];
        is_seen[keyframe] = true;
        let mut next = 0;
        while let Some(&from) = found.get(next) {
            next += 1;
            for &to in &self.near[from] {
                if !is_seen[to] && poses[to].distance_to(place) < NEAR {
                    is_seen[to] = true;
                    found.push(to);
                }
            }
        }
        if found.len() > most {
            found.sort_by(|&a, &b| self.distance(a, place).total_cmp(&self.distance(b, place)));
            found.truncate(most);
        }
        found
    }

    /// How far a keyframe is from a place, m; a turn is a way too, unless the keyframe shows what is on all sides.
    pub(crate) fn distance(&self, keyframe: usize, place: &Pose2D) -> f64 {
        let pose = &self.graph.poses()[keyframe];
        let lever = if self.scans[keyframe].is_all_around() {
            0.0
        } else {
            LEVER
        };
        pose.distance_to(place) + lever * turn_between(pose, place)
    }

    /// The surfaces that keyframes show, in the frame of one.
    pub(crate) fn surface_of(&self, frame: usize, keyframes: &[usize], levels: usize) -> Surface {
        let poses = self.graph.poses();
        let scans = keyframes
            .iter()
            .map(|&at| (poses[frame].localize(&poses[at]), &self.scans[at]));
        Surface::new(scans, levels)
    }

    /// Does a part of what is due behind the scans: an iteration of the graph, or a search for a loop.
    /// Returns whether keyframes moved.
    pub fn advance(&mut self, settings: &Settings) -> bool {
        if !self.graph.is_settled() {
            let moved = self.graph.iterate();
            if moved {
                self.surface = None;
            }
            return moved;
        }
        if let Some(anchor) = self.anchor {
            let mut loops = core::mem::take(&mut self.loops);
            let edges = loops.search(self, settings, anchor.keyframe);
            self.loops = loops;
            for edge in edges {
                self.add_edge(edge);
            }
        }
        false
    }
}

/// Every so many that there are at most `most`.
pub(crate) fn thin<T: Copy>(all: &[T], most: usize) -> impl Iterator<Item = T> + '_ {
    all.iter().step_by(all.len().div_ceil(most).max(1)).copied()
}

/// A matrix of x, y and heading in a frame that is turned back by an angle.
fn turned(matrix: &Matrix, angle: f64) -> Matrix {
    let (sin, cos) = libm::sincos(angle);
    let turn = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
    product(&product(&turn, matrix), &transpose(&turn))
}

/// A point of a keyframe in the frame that its pose is in, m.
pub(crate) fn placed(pose: &Pose2D, (x, y): (f32, f32)) -> (f64, f64) {
    let place = pose.transform(&Pose2D::new(x.into(), y.into(), 0.0));
    (place.x, place.y)
}

pub(crate) fn turn_between(a: &Pose2D, b: &Pose2D) -> f64 {
    normalize_angle(a.theta - b.theta).abs()
}

#[cfg(test)]
mod tests;
