//! From scans and odometry to keyframes, and where the robot is among them.
//!
//! Long because a scan reads and writes one state at each step: the anchor, its certainty and covariances.

mod conflict;
mod forget;
mod full;
mod settings;
mod state;

use jde_types::{Pose2D, normalize_angle};

use crate::graph::{Edge, Graph, Relation};
use crate::icp::{Fit, Guess};
use crate::loops::Loops;
use crate::matrix::{Matrix, ZERO, add, diagonal, invert, product, transpose};
use crate::scan::Scan;
use crate::surface::Surface;

use forget::Motion;
pub use settings::Settings;
use state::Certainty;
pub use state::State;

/// How far keyframes may be that a scan is matched with, m.
pub(crate) const MATCHED_KEYFRAME_DISTANCE: f64 = 6.0;
/// The most keyframes that a scan is matched with.
const JOINED: usize = 16;
/// What a turn counts among the distances of keyframes, m/rad.
pub(crate) const LEVER: f64 = 0.5;
/// The most points that a correlation looks at.
const MAX_CORRELATION_POINTS: usize = 120;

/// The greatest share of what can be compared that may contradict a scan which shows what is new: people, doors, and errors of
/// the poses.
const MAX_CONFLICT: f64 = 0.3;
/// The greatest standard deviation, by its points alone, of a match that finds a lost robot elsewhere than where the odometry
/// says, m and rad: a single wall is anywhere.
const FOUND_DEVIATION: f64 = 0.1;
/// The part of its view by which a narrow scan is turned from one keyframe to the next.
const TURNED_VIEW: f64 = 1.0 / 3.0;

/// Of so many scans of a robot that stands, one is compared with what is known.
const STANDING_SCAN_INTERVAL: usize = 10;

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
    certainty: Certainty,
    /// How many scans were not matched since one was, as the robot stood.
    unmatched: usize,
    /// The covariance of the pose at the anchor, among the keyframes there, in the frame of the map.
    covariance: Matrix,
    /// For each keyframe the covariance of its pose in the frame of the map.
    keyframe_covariance: Vec<Matrix>,
    /// The surfaces around the anchor's keyframe, in its frame.
    surface: Option<Surface>,
    loops: Loops,
    /// How often points were taken away, and keyframes replaced; and how often keyframes left.
    revision: u64,
    renumbered: u64,
    /// How far keyframes are apart since the first left, m.
    spacing: f64,
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

    /// Returns the points that keyframes show, in the frame of the map, m: an even selection, at most `most`.
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
    /// adds to it, and each match takes away what the points of its scan say; each new keyframe passes its own on to those after
    /// it, until a loop closes. From a scan that contradicts what is known on, it begins with that of 0.3 m and 0.2 rad.
    #[must_use]
    pub fn covariance(&self, settings: &Settings, odometry: &Pose2D) -> Matrix {
        let mut covariance = self.local_covariance(settings, odometry);
        if let Some(anchor) = self.anchor(odometry) {
            add(&mut covariance, 1.0, &self.carried(&anchor));
        }
        covariance
    }

    /// What the covariance of the anchor's keyframe is at the anchor: an error of its heading moves what is far from it.
    fn carried(&self, anchor: &Anchor) -> Matrix {
        let (from, to) = (&self.graph.poses()[anchor.keyframe], self.place(anchor));
        let slopes = [
            [1.0, 0.0, from.y - to.y],
            [0.0, 1.0, to.x - from.x],
            [0.0, 0.0, 1.0],
        ];
        let covariance = &self.keyframe_covariance[anchor.keyframe];
        product(&product(&slopes, covariance), &transpose(&slopes))
    }

    /// The covariance among the keyframes around the robot.
    fn local_covariance(&self, settings: &Settings, odometry: &Pose2D) -> Matrix {
        let mut covariance = self.covariance;
        let deviations = settings.deviations(&self.moved(odometry));
        add(&mut covariance, 1.0, &diagonal(deviations.map(|of| of * of)));
        covariance
    }

    /// The robot may have been moved since the last scan: the next one is matched, to 0.3 m and 0.2 rad.
    pub fn doubt(&mut self) {
        if self.certainty == Certainty::Sure {
            (self.certainty, self.covariance) = (Certainty::Doubted, UNCERTAIN);
        }
    }

    /// The odometry jumped to another pose: without a motion of the robot, unless the next scan says otherwise.
    pub fn jump(&mut self, from: &Pose2D, to: &Pose2D) {
        self.odometry = self.odometry.map(|last| to.transform(&from.localize(&last)));
        self.doubt();
    }

    /// Takes a scan, and the pose of the odometry at its time.
    ///
    /// Takes time by the number of points of one scan and of the sixteen keyframes that it is matched with. While the robot
    /// stands, only every tenth scan is looked at, and matched if it fits no longer.
    pub fn step(&mut self, settings: &Settings, odometry: &Pose2D, scan: &Scan) -> State {
        let state = self.take(settings, odometry, scan);
        self.state = Some(state);
        match state {
            State::Fits(_) => self.certainty = Certainty::Sure,
            State::Differs(_) => {
                self.doubt();
                self.certainty = Certainty::Lost;
            }
            State::Empty | State::New(_) | State::Blind => {}
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
            return State::Fits(1.0);
        };
        if !scan.is_enough() {
            return State::Blind;
        }
        let motion = self.moved(odometry);
        let way = libm::hypot(motion.x, motion.y);
        let is_moved = way >= settings.update.0 || motion.theta.abs() >= settings.update.1;
        let was_sure = self.certainty == Certainty::Sure;
        if !is_moved && was_sure && matches!(self.state, Some(State::Fits(_))) {
            self.unmatched += 1;
            if !self.unmatched.is_multiple_of(STANDING_SCAN_INTERVAL) {
                return self.state();
            }
            let share = self.surface(&anchor).share(scan.points(), &anchor.pose);
            if share >= settings.share {
                if share >= settings.loop_share {
                    self.forget(&anchor, scan, Motion::Standing);
                }
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
        let fit = self.fit(settings, &guess, &anchor, scan);
        self.covariance = self.local_covariance(settings, odometry);
        self.odometry = Some(*odometry);
        let share = fit.map_or(0.0, |fit| fit.share);
        let fit = fit.filter(|fit| self.is_believed(settings, fit, &anchor, scan));
        let is_unseen = fit.is_none() && was_sure && self.conflict(&anchor, scan) <= MAX_CONFLICT;
        let heading = self.graph.poses()[anchor.keyframe].theta;
        let information = turned(&fit.map_or(ZERO, |fit| fit.information), heading);
        if let Some(mut both) = invert(&self.covariance) {
            add(&mut both, 1.0, &information);
            self.covariance = invert(&both).unwrap_or(self.covariance);
        }
        let pose = fit.map_or(anchor.pose, |fit| fit.pose);
        let anchor = self.nearest(&Anchor { pose, ..anchor });
        self.set_anchor(anchor);
        if fit.is_none() && !is_unseen {
            return State::Differs(share);
        }
        let (way, turn) = (libm::hypot(anchor.pose.x, anchor.pose.y), anchor.pose.theta.abs());
        let most = settings.keyframe.1.min(TURNED_VIEW * scan.view());
        let is_turned = turn >= most && !self.scans[anchor.keyframe].is_all_around();
        // A match that few points support says where the robot is, and not that all others are gone.
        if was_sure && !is_unseen && share >= settings.loop_share {
            self.forget(&anchor, scan, Motion::Moved);
            if self.renew(settings, &anchor, scan) {
                self.set_anchor(Anchor {
                    pose: Pose2D::ORIGIN,
                    ..anchor
                });
                return State::Fits(share);
            }
        }
        let is_new = way >= self.spacing(settings) || is_turned;
        // A match far around may be wrong by chance: what it says is kept when the next one agrees.
        let is_kept = was_sure && (is_new || is_unseen || self.is_beyond(settings, &anchor, share));
        if is_kept && self.scans.len() < settings.most {
            self.keep(settings, &anchor, scan, &information);
            self.make_room(settings);
        }
        if is_unseen {
            State::New(share)
        } else {
            State::Fits(share)
        }
    }

    /// Whether a match is where the robot is. One that finds a robot again may be of another place that looks alike.
    fn is_believed(&mut self, settings: &Settings, fit: &Fit, anchor: &Anchor, scan: &Scan) -> bool {
        if self.certainty == Certainty::Sure {
            return fit.share >= settings.share;
        }
        let is_narrow =
            |covariance: Matrix| covariance[0][0].max(covariance[1][1]) < FOUND_DEVIATION * FOUND_DEVIATION;
        let is_expected = fit.pose.distance_to(&anchor.pose) < FOUND_DEVIATION
            && turn_between(&fit.pose, &anchor.pose) < FOUND_DEVIATION;
        let is_found = is_expected || invert(&fit.information).is_some_and(is_narrow);
        let (is_found, least) = match self.certainty {
            Certainty::Lost => (is_found, f64::midpoint(settings.share, 1.0)),
            Certainty::Doubted | Certainty::Sure => (true, settings.share.max(settings.loop_share)),
        };
        let place = Anchor {
            pose: fit.pose,
            ..*anchor
        };
        is_found && fit.share >= least && self.conflict(&place, scan) <= MAX_CONFLICT
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
        let few: Vec<_> = thin(scan.points(), MAX_CORRELATION_POINTS).collect();
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
        let mut covariance = self.carried(anchor);
        add(&mut covariance, 1.0, &self.covariance);
        (self.keyframe_covariance[keyframe], self.covariance) = (covariance, ZERO);
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
        self.keyframe_covariance.push(ZERO);
        self.graph.add_pose(pose)
    }

    pub(crate) fn add_edge(&mut self, edge: Edge) {
        self.near[edge.from].push(edge.to);
        self.near[edge.to].push(edge.from);
        self.graph.add_edge(edge);
    }

    /// The keyframes near a place that edges lead to from one of them, over others that are near; the nearest first.
    pub(crate) fn around(&self, keyframe: usize, place: &Pose2D, most: usize) -> Vec<usize> {
        let mut found = self.linked(keyframe, place, MATCHED_KEYFRAME_DISTANCE);
        if found.len() > most {
            found.sort_by(|&a, &b| self.distance(a, place).total_cmp(&self.distance(b, place)));
            found.truncate(most);
        }
        found
    }

    /// The keyframes nearer to a place than so many metres that edges lead to from one of them, over others that are.
    fn linked(&self, keyframe: usize, place: &Pose2D, distance: f64) -> Vec<usize> {
        let poses = self.graph.poses();
        let mut found = vec![keyframe];
        let mut is_seen = vec![false; poses.len()];
        is_seen[keyframe] = true;
        let mut next = 0;
        while let Some(&from) = found.get(next) {
            next += 1;
            for &to in &self.near[from] {
                if !is_seen[to] && poses[to].distance_to(place) < distance {
                    is_seen[to] = true;
                    found.push(to);
                }
            }
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
                // What was added since is as certain as the place that was reached again.
                let known = self.keyframe_covariance[edge.from];
                let later = &mut self.keyframe_covariance[edge.from + 1..];
                let sum = |of: &Matrix| of[0][0] + of[1][1];
                (later.iter_mut().filter(|of| sum(of) > sum(&known))).for_each(|of| *of = known);
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
