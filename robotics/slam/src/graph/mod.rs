//! A graph of poses and of what is measured between them, and the poses that fit best: Levenberg and Marquardt's method,
//! at most an iteration a call.

mod removal;

use jde_types::{Pose2D, normalize_angle};

use crate::matrix::{
    Matrix, ZERO, add, diagonal, product, product_transposed, square, times, times_transposed,
};
use crate::sparse::{NotPositive, System};

/// How certain the first pose is, which holds all others.
const HELD: f64 = 1e9;
/// The damping at first, and its limits.
const DAMPING: f64 = 1e-4;
const MIN_DAMPING: f64 = 1e-9;
const MAX_DAMPING: f64 = 1e6;
/// The steps of a part of an iteration: products of blocks, or links that are merged.
const PART: usize = 500_000;
/// A step that ends it, m and rad.
const CONVERGED_STEP: f64 = 1e-4;
/// From what square of the error on, in standard deviations, a loop has less weight.
const ROBUST_THRESHOLD: f64 = 12.0;

/// What an edge comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// Successive scans. It is right.
    Successive,
    /// A place that was reached again. It may be wrong.
    Loop,
}

/// A measurement between two poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The number of one pose.
    pub from: usize,
    /// The number of the other pose.
    pub to: usize,
    /// The other pose in the frame of the first.
    pub pose: Pose2D,
    /// The inverse of its covariance, in the frame of the first pose.
    pub information: Matrix,
    /// What it comes from.
    pub relation: Relation,
}

/// The iteration under way.
#[derive(Clone, Debug)]
struct Work {
    system: System,
    /// How many edges it has: those that there were when it began.
    edges: usize,
    is_filled: bool,
}

/// Poses, and edges between them. The first pose stays.
#[derive(Clone, Debug)]
pub struct Graph {
    poses: Vec<Pose2D>,
    edges: Vec<Edge>,
    work: Option<Work>,
    damping: f64,
    /// The square from which on loops have less weight: falls to [`ROBUST_THRESHOLD`].
    doubted: f64,
    is_settled: bool,
}

impl Default for Graph {
    fn default() -> Self {
        Self {
            poses: Vec::new(),
            edges: Vec::new(),
            work: None,
            damping: DAMPING,
            doubted: ROBUST_THRESHOLD,
            is_settled: true,
        }
    }
}

impl Graph {
    /// Returns the poses.
    #[must_use]
    pub fn poses(&self) -> &[Pose2D] {
        &self.poses
    }

    /// Returns the edges.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Returns the edges between visits of the same place.
    pub fn loops(&self) -> impl Iterator<Item = &Edge> {
        self.edges.iter().filter(|edge| edge.relation == Relation::Loop)
    }

    /// Adds a pose, and returns its number.
    pub fn add_pose(&mut self, pose: Pose2D) -> usize {
        self.poses.push(pose);
        self.poses.len() - 1
    }

    /// Adds an edge between poses that there are; one with numbers that are not finite, or between others, is left out.
    pub fn add_edge(&mut self, edge: Edge) {
        let numbers = [edge.pose.x, edge.pose.y, edge.pose.theta];
        let mut numbers = numbers.iter().chain(edge.information.iter().flatten());
        let is_known = edge.from.max(edge.to) < self.poses.len() && edge.from != edge.to;
        if !is_known || !numbers.all(|number| number.is_finite()) {
            return;
        }
        if edge.relation == Relation::Loop {
            self.damping = DAMPING;
            self.is_settled = false;
            // At first a new loop has its weight; if it contradicts the others, it loses that as the limit falls.
            self.doubted = self.doubted.max(self.error(&edge).1);
        }
        self.edges.push(edge);
    }

    /// Returns whether the poses fit as well as they can.
    #[must_use]
    pub const fn is_settled(&self) -> bool {
        self.is_settled
    }

    /// Does a part of an iteration. Returns whether poses moved.
    ///
    /// Takes time by the number of edges, and some milliseconds; an iteration over hundreds of poses is one part.
    pub fn iterate(&mut self) -> bool {
        if self.is_settled {
            return false;
        }
        let mut work = self.work.take().unwrap_or_else(|| self.begin());
        if !work.is_filled {
            if !work.system.order(PART) {
                self.work = Some(work);
                return false;
            }
            self.fill(&mut work);
        }
        let (moved, is_done) = match work.system.solve(PART) {
            Ok(None) => (false, false),
            Ok(Some(step)) => (self.move_by(&step, work.edges), true),
            Err(NotPositive) => (self.hold_back(), true),
        };
        // Without other edges the order stays.
        if !is_done || work.edges == self.edges.len() {
            if is_done {
                work.is_filled = false;
                work.system.clear();
            }
            self.work = Some(work).filter(|_| !self.is_settled);
        }
        moved
    }

    fn begin(&self) -> Work {
        Work {
            system: System::new(
                self.poses.len(),
                self.edges.iter().map(|edge| (edge.from, edge.to)),
            ),
            edges: self.edges.len(),
            is_filled: false,
        }
    }

    /// Moves the poses, if they fit better then. Those that were added meanwhile go along. The step is by the first `edges`.
    fn move_by(&mut self, step: &[[f64; 3]], edges: usize) -> bool {
        let before = self.cost();
        let old = self.poses.clone();
        let mut farthest = 0.0_f64;
        for (pose, &[x, y, turn]) in self.poses.iter_mut().zip(step) {
            *pose = Pose2D::new(pose.x + x, pose.y + y, normalize_angle(pose.theta + turn));
            farthest = farthest.max(x.abs()).max(y.abs()).max(turn.abs());
        }
        for edge in &self.edges {
            if edge.to >= step.len() && edge.relation == Relation::Successive {
                self.poses[edge.to] =
                    self.poses[edge.from].transform(&old[edge.from].localize(&old[edge.to]));
            }
        }
        let after = self.cost();
        if !after.is_finite() || after > before * (1.0 + 1e-9) {
            self.poses = old;
            return self.hold_back();
        }
        self.damping = (self.damping / 10.0).max(MIN_DAMPING);
        // Keyframes that were added since fit where they are.
        let is_loop = |edge: &Edge| edge.relation == Relation::Loop;
        if farthest < CONVERGED_STEP
            && self.doubted <= ROBUST_THRESHOLD
            && !self.edges[edges..].iter().any(is_loop)
        {
            self.is_settled = true;
        }
        self.doubted = (self.doubted / 2.0).max(ROBUST_THRESHOLD);
        true
    }

    /// Lets the next step be smaller. Nothing moves.
    fn hold_back(&mut self) -> bool {
        self.damping *= 10.0;
        if self.damping > MAX_DAMPING {
            self.damping = DAMPING;
            self.is_settled = self.doubted <= ROBUST_THRESHOLD;
            self.doubted = (self.doubted / 2.0).max(ROBUST_THRESHOLD);
        }
        false
    }

    fn fill(&self, work: &mut Work) {
        work.is_filled = true;
        let system = &mut work.system;
        system.damp(self.damping);
        system.add_diagonal(0, &diagonal([HELD; 3]));
        for edge in &self.edges[..work.edges] {
            let (error, square) = self.error(edge);
            let weight = self.weight(edge, square);
            let mut information = ZERO;
            add(&mut information, weight * weight, &edge.information);
            let (from, to) = self.slopes(edge);
            let (left, right) = (product(&information, &from), product(&information, &to));
            system.add_diagonal(edge.from, &product_transposed(&from, &left));
            system.add_diagonal(edge.to, &product_transposed(&to, &right));
            system.add_link(edge.from, edge.to, &product_transposed(&from, &right));
            let pull = times(&information, &error).map(|number| -number);
            system.add_right(edge.from, &times_transposed(&from, &pull));
            system.add_right(edge.to, &times_transposed(&to, &pull));
        }
    }

    /// By how far the poses miss what was measured, in the frame of the first, and the square of that in standard deviations.
    fn error(&self, edge: &Edge) -> ([f64; 3], f64) {
        let between = self.poses[edge.from].localize(&self.poses[edge.to]);
        let error = [
            between.x - edge.pose.x,
            between.y - edge.pose.y,
            normalize_angle(between.theta - edge.pose.theta),
        ];
        (error, square(&edge.information, &error))
    }

    /// Dynamic covariance scaling (Agarwal et al., equation 8).
    fn weight(&self, edge: &Edge, square: f64) -> f64 {
        match edge.relation {
            Relation::Successive => 1.0,
            Relation::Loop => (2.0 * self.doubted / (self.doubted + square)).min(1.0),
        }
    }

    fn cost(&self) -> f64 {
        let cost = |edge| {
            let (_, square) = self.error(edge);
            let weight = self.weight(edge, square);
            weight * weight * square + self.doubted * (1.0 - weight) * (1.0 - weight)
        };
        self.edges.iter().map(cost).sum()
    }

    /// Returns whether an edge has lost at least half of its weight, since it contradicts the others.
    #[must_use]
    pub fn is_doubted(&self, edge: &Edge) -> bool {
        let weight = self.weight(edge, self.error(edge).1);
        weight * weight < 0.5
    }

    /// The derivatives of the error by both poses.
    fn slopes(&self, edge: &Edge) -> (Matrix, Matrix) {
        let (from, to) = (&self.poses[edge.from], &self.poses[edge.to]);
        let (sin, cos) = libm::sincos(from.theta);
        let turn = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]];
        let between = from.localize(to);
        let mut back = turn.map(|row| row.map(|number| -number));
        (back[0][2], back[1][2]) = (between.y, -between.x);
        (back, turn)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const CERTAIN: Matrix = diagonal([1e4, 1e4, 4e4]);

    /// Poses along a ring that is driven twice, and edges that measure them.
    fn ring(error: impl Fn(usize) -> [f64; 3]) -> (Vec<Pose2D>, Graph) {
        let truth: Vec<Pose2D> = (0..80)
            .map(|at| {
                let turn = f64::from(at) * core::f64::consts::TAU / 40.0;
                Pose2D::new(5.0 * turn.sin(), 5.0 - 5.0 * turn.cos(), normalize_angle(turn))
            })
            .collect();
        let mut graph = Graph::default();
        graph.add_pose(truth[0]);
        for at in 1..truth.len() {
            let [x, y, turn] = error(at);
            let step = truth[at - 1].localize(&truth[at]);
            let step = Pose2D::new(step.x + x, step.y + y, step.theta + turn);
            graph.add_pose(graph.poses()[at - 1].transform(&step));
            graph.add_edge(Edge {
                from: at - 1,
                to: at,
                pose: step,
                information: CERTAIN,
                relation: Relation::Successive,
            });
        }
        (truth, graph)
    }

    fn close(graph: &mut Graph, from: usize, to: usize, pose: Pose2D) {
        graph.add_edge(Edge {
            from,
            to,
            pose,
            information: CERTAIN,
            relation: Relation::Loop,
        });
    }

    fn settle(graph: &mut Graph) {
        let mut iterations = 0;
        while !graph.is_settled() {
            graph.iterate();
            iterations += 1;
            assert!(iterations < 200, "it does not settle");
        }
    }

    fn farthest(truth: &[Pose2D], graph: &Graph) -> f64 {
        let away = |(a, b): (&Pose2D, &Pose2D)| a.distance_to(b);
        truth.iter().zip(graph.poses()).map(away).fold(0.0, f64::max)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        /// The measured steps are right and the poses are not: the optimum is known.
        #[test]
        fn poses_come_to_the_known_optimum(shifts in proptest::collection::vec(-0.4..0.4f64, 240)) {
            let (truth, mut graph) = ring(|_| [0.0; 3]);
            for (from, to) in [(0, 40), (10, 50), (20, 60), (39, 79)] {
                close(&mut graph, from, to, truth[from].localize(&truth[to]));
            }
            for (pose, shift) in graph.poses.iter_mut().zip(shifts.chunks(3)).skip(1) {
                *pose = Pose2D::new(pose.x + shift[0], pose.y + shift[1], pose.theta + 0.5 * shift[2]);
            }
            settle(&mut graph);
            prop_assert!(farthest(&truth, &graph) < 1e-3, "{} m", farthest(&truth, &graph));
            prop_assert!(graph.cost() < 1e-3);
        }
    }

    #[test]
    fn loops_spread_the_drift() {
        let (truth, mut graph) = ring(|_| [0.005, -0.003, 0.004]);
        let before = farthest(&truth, &graph);
        for at in 0..40 {
            close(&mut graph, at, at + 40, Pose2D::ORIGIN);
        }
        settle(&mut graph);
        let after = farthest(&truth, &graph);
        assert!(before > 1.5 && after < 0.4, "{before} and {after} m");
        let apart = graph.poses()[5].distance_to(&graph.poses()[45]);
        assert!(apart < 0.02, "{apart} m");
        assert!(!graph.edges().iter().any(|edge| graph.is_doubted(edge)));
    }

    #[test]
    fn a_wrong_loop_is_refused() {
        let (truth, mut graph) = ring(|at| [0.0, 0.0, if at % 2 == 0 { 0.002 } else { -0.002 }]);
        for at in (0..40).step_by(4) {
            close(&mut graph, at, at + 40, Pose2D::ORIGIN);
        }
        settle(&mut graph);
        let before = farthest(&truth, &graph);
        // These places are 10 m apart.
        close(&mut graph, 10, 70, Pose2D::ORIGIN);
        settle(&mut graph);
        let after = farthest(&truth, &graph);
        assert!(after < before + 0.02, "{before} and {after} m");
        let doubted: Vec<_> = (graph.edges().iter())
            .filter(|edge| graph.is_doubted(edge))
            .map(|edge| (edge.from, edge.to))
            .collect();
        assert_eq!(doubted, [(10, 70)]);
        // A right loop after it is taken.
        close(&mut graph, 38, 78, Pose2D::ORIGIN);
        settle(&mut graph);
        assert!(farthest(&truth, &graph) < before + 0.02);
    }

    #[test]
    fn it_settles_while_poses_are_added() {
        let (_, mut graph) = ring(|_| [0.005, -0.003, 0.004]);
        close(&mut graph, 0, 40, Pose2D::ORIGIN);
        for _ in 0..200 {
            // Each is added after an iteration has begun.
            if !graph.is_settled() {
                graph.work = Some(graph.work.take().unwrap_or_else(|| graph.begin()));
            }
            let from = graph.poses().len() - 1;
            let step = Pose2D::new(0.5, 0.0, 0.1);
            let to = graph.add_pose(graph.poses()[from].transform(&step));
            graph.add_edge(Edge {
                from,
                to,
                pose: step,
                information: CERTAIN,
                relation: Relation::Successive,
            });
            graph.iterate();
        }
        assert!(graph.is_settled());
    }

    #[test]
    fn edges_that_cannot_be_are_left_out() {
        let (_, mut graph) = ring(|_| [0.0; 3]);
        let edges = graph.edges().len();
        close(&mut graph, 3, 3, Pose2D::ORIGIN);
        close(&mut graph, 3, 80, Pose2D::ORIGIN);
        close(&mut graph, 3, 9, Pose2D::new(f64::NAN, 0.0, 0.0));
        assert_eq!(graph.edges().len(), edges);
        assert!(graph.is_settled() && !graph.iterate());
    }
}
