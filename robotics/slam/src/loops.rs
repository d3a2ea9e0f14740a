//! Places that are reached again.
//!
//! Keyframes of an earlier time that the graph has here already are matched with each new one. Where the graph may have
//! drifted, the surfaces around the robot are searched among those of an earlier place. Rooms look alike: such a match counts
//! only if others from farther on say the same.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

use jde_types::Pose2D;

use crate::correlation::Window;
use crate::graph::{Edge, Relation};
use crate::icp::{Fit, Guess};
use crate::matrix::{ZERO, invert};
use crate::slam::{LEVER, MATCHED_KEYFRAME_DISTANCE, Settings, Slam, thin, turn_between};
use crate::surface::Surface;

/// The most edges of a keyframe: no more are searched then.
const EDGES: usize = 12;
/// How many keyframes lie between two times that the robot is at a place.
const MIN_KEYFRAMES_BETWEEN: usize = 10;
/// How many keyframes before and after an earlier one show its surfaces.
const KEYFRAMES_AROUND: usize = 2;
/// How far keyframes may be that are linked, m, and with how many each is.
const LINKED: (f64, usize) = (2.0, 3);
/// How many keyframes show the surfaces around the robot, and around an earlier place.
const SHOWN: (usize, usize) = (5, 16);
/// Points that are searched.
const POINTS: usize = 250;
/// The smallest and the largest window, m.
const WINDOWS: (f64, f64) = (0.5, 6.0);
/// The smallest and the largest turn of a window, and how it grows with the way, rad and rad/m.
const TURNS: (f64, f64) = (0.15, 0.7);
const TURN_BY_WAY: f64 = 0.15;
/// How far an earlier place may be outside the window, m.
const SEEN: f64 = 3.0;
/// The most squares that a search looks at.
const MAX_SEARCHED_CELLS: usize = 60_000;
/// The greatest standard deviation of a match, m.
const DEVIATION: f64 = 0.1;
/// How far matches may differ that say the same, m and rad.
const MATCH_TOLERANCE: (f64, f64) = (0.2, 0.06);
/// How many matches wait for others.
const WAITING: usize = 8;

/// Matches that wait for others.
#[derive(Clone, Debug, Default)]
pub(crate) struct Loops {
    /// The keyframe for which a search was last done.
    last: Option<usize>,
    waiting: Vec<Edge>,
}

impl Loops {
    /// Returns the edges between a keyframe and earlier ones. Searches once after the robot goes to another keyframe.
    pub(crate) fn search(&mut self, slam: &Slam, settings: &Settings, keyframe: usize) -> Vec<Edge> {
        let is_known = keyframe < slam.given || slam.near[keyframe].len() >= EDGES;
        if is_known || self.last == Some(keyframe) {
            return Vec::new();
        }
        self.last = Some(keyframe);
        let links = links(slam, settings, keyframe);
        if !links.is_empty() {
            return links;
        }
        let found = candidate(slam, settings, keyframe)
            .and_then(|(earlier, window)| searched(slam, settings, (earlier, keyframe), window));
        found.map_or_else(Vec::new, |edge| self.agreeing(slam, settings, edge))
    }

    /// Takes the new numbers of keyframes, of which some have left.
    pub(crate) fn renumber(&mut self, numbers: &[Option<usize>]) {
        self.last = self.last.and_then(|last| numbers[last]);
        self.waiting.retain_mut(|edge| {
            let (from, to) = (numbers[edge.from], numbers[edge.to]);
            (edge.from, edge.to) = (from.unwrap_or(edge.from), to.unwrap_or(edge.to));
            from.and(to).is_some()
        });
    }

    /// Returns the matches that say the same as a new one, if they are enough.
    fn agreeing(&mut self, slam: &Slam, settings: &Settings, edge: Edge) -> Vec<Edge> {
        // Matches of one keyframe repeat its error.
        self.waiting.retain(|other| other.to != edge.to);
        self.waiting.push(edge);
        if self.waiting.len() > WAITING {
            self.waiting.remove(0);
        }
        let agreeing: Vec<Edge> = (self.waiting.iter())
            .filter(|other| agree(slam, &edge, other))
            .copied()
            .collect();
        if agreeing.len() < settings.loop_matches {
            return Vec::new();
        }
        self.waiting.retain(|other| !agreeing.contains(other));
        agreeing
    }
}

/// Matches of a keyframe with earlier ones near it, one for each time that the robot was here.
fn links(slam: &Slam, settings: &Settings, keyframe: usize) -> Vec<Edge> {
    let poses = slam.graph.poses();
    let here = &poses[keyframe];
    let mut near = slam.around(keyframe, here, usize::MAX);
    near.retain(|&at| {
        at.abs_diff(keyframe) > MIN_KEYFRAMES_BETWEEN && poses[at].distance_to(here) < LINKED.0
    });
    near.sort_by(|&a, &b| slam.distance(a, here).total_cmp(&slam.distance(b, here)));
    let mut times: Vec<usize> = Vec::new();
    for at in near {
        if times.len() < LINKED.1
            && times
                .iter()
                .all(|other| other.abs_diff(at) > MIN_KEYFRAMES_BETWEEN)
        {
            times.push(at);
        }
    }
    times.retain(|at| !slam.near[keyframe].contains(at));
    let edge = |earlier: usize| {
        let last = (earlier + KEYFRAMES_AROUND).min(poses.len() - 1);
        let mut shown: Vec<usize> = (earlier.saturating_sub(KEYFRAMES_AROUND)..=last).collect();
        shown.retain(|&at| poses[at].distance_to(&poses[earlier]) < MATCHED_KEYFRAME_DISTANCE);
        let surface = slam.surface_of(earlier, &shown, 0);
        let start = poses[earlier].localize(here);
        let guess = Guess {
            pose: start,
            information: ZERO,
        };
        let fit = surface.refine(slam.scans[keyframe].points(), &start, &guess)?;
        believed(settings, &fit, &start, (earlier, keyframe))
    };
    times.into_iter().filter_map(edge).collect()
}

/// The edge of a match, if it is narrow, near where it began, and enough points fit.
fn believed(settings: &Settings, fit: &Fit, start: &Pose2D, (from, to): (usize, usize)) -> Option<Edge> {
    let covariance = invert(&fit.information)?;
    let is_narrow = covariance[0][0].max(covariance[1][1]) < DEVIATION * DEVIATION;
    let is_same =
        fit.pose.distance_to(start) < MATCH_TOLERANCE.0 && turn_between(&fit.pose, start) < MATCH_TOLERANCE.1;
    (is_narrow && is_same && fit.share >= settings.loop_share).then_some(Edge {
        from,
        to,
        pose: fit.pose,
        information: fit.information,
        relation: Relation::Loop,
    })
}

/// The keyframe nearest to another of those that may be the same place but are not linked with it, and how far it may have
/// drifted, m.
fn candidate(slam: &Slam, settings: &Settings, keyframe: usize) -> Option<(usize, f64)> {
    let poses = slam.graph.poses();
    let here = &poses[keyframe];
    let mut is_linked = vec![false; poses.len()];
    for at in slam.around(keyframe, here, usize::MAX) {
        is_linked[at] = true;
    }
    let ways = ways(slam, keyframe);
    let drift = |at: usize| (settings.drift * ways[at]).clamp(WINDOWS.0, WINDOWS.1);
    (0..poses.len())
        .filter(|&at| !is_linked[at] && ways[at] > 2.0 * MATCHED_KEYFRAME_DISTANCE)
        .filter(|&at| poses[at].distance_to(here) < drift(at) + SEEN)
        .min_by(|&a, &b| slam.distance(a, here).total_cmp(&slam.distance(b, here)))
        .map(|at| (at, drift(at)))
}

/// The shortest way along edges to each keyframe, m.
fn ways(slam: &Slam, from: usize) -> Vec<f64> {
    let poses = slam.graph.poses();
    // Millimetres have an order.
    let mut ways = vec![u64::MAX; poses.len()];
    ways[from] = 0;
    let mut due = BinaryHeap::from([Reverse((0, from))]);
    while let Some(Reverse((way, at))) = due.pop() {
        if way > ways[at] {
            continue;
        }
        for &to in &slam.near[at] {
            let turned = LEVER * turn_between(&poses[at], &poses[to]);
            let longer = way + (1000.0 * (poses[at].distance_to(&poses[to]) + turned)) as u64;
            if longer < ways[to] {
                ways[to] = longer;
                due.push(Reverse((longer, to)));
            }
        }
    }
    ways.into_iter().map(|way| way as f64 / 1000.0).collect()
}

/// Searches the surfaces around a keyframe among those around an earlier one.
fn searched(slam: &Slam, settings: &Settings, (earlier, keyframe): (usize, usize), way: f64) -> Option<Edge> {
    let poses = slam.graph.poses();
    let shown = slam.around(earlier, &poses[earlier], SHOWN.1);
    let surface = slam.surface_of(earlier, &shown, Surface::levels(way));
    let around = slam.around(keyframe, &poses[keyframe], SHOWN.0);
    let seen = slam.surface_of(keyframe, &around, 0);
    let points: Vec<_> = thin(seen.points(), POINTS).collect();
    let window = Window {
        way,
        turn: (TURN_BY_WAY * way).clamp(TURNS.0, TURNS.1),
        least: settings.loop_share,
        loss: 0.05,
        most: MAX_SEARCHED_CELLS,
    };
    let found = surface.search(&points, &poses[earlier].localize(&poses[keyframe]), &window)?;
    let guess = Guess {
        pose: found.pose,
        information: ZERO,
    };
    let fit = surface.refine(&points, &found.pose, &guess)?;
    believed(settings, &fit, &found.pose, (earlier, keyframe))
}

/// Whether two matches say the same: the way over one and back over the other ends where it began.
fn agree(slam: &Slam, a: &Edge, b: &Edge) -> bool {
    let poses = slam.graph.poses();
    let earlier = poses[a.from].localize(&poses[b.from]);
    let later = poses[a.to].localize(&poses[b.to]);
    let (one, other) = (a.pose.transform(&later), earlier.transform(&b.pose));
    one.distance_to(&other) < MATCH_TOLERANCE.0 && turn_between(&one, &other) < MATCH_TOLERANCE.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::Scan;

    #[test]
    fn a_keyframe_counts_once_however_often_it_is_matched() {
        let mut slam = Slam::new(Pose2D::ORIGIN);
        for at in 0..4 {
            slam.add_keyframe(Pose2D::new(f64::from(at), 0.0, 0.0), &Scan::default());
        }
        let edge = |to: usize| Edge {
            from: 0,
            to,
            pose: Pose2D::new(to as f64 + 0.05, 0.0, 0.0),
            information: ZERO,
            relation: Relation::Loop,
        };
        let (mut loops, settings) = (Loops::default(), Settings::default());
        let agreeing = [1, 2, 1, 2, 3].map(|to| loops.agreeing(&slam, &settings, edge(to)).len());
        assert_eq!(agreeing, [0, 0, 0, 0, 3]);
    }
}
