//! Poses that leave the graph, and poses that are chosen otherwise: what was measured over them stays.
//!
//! A pose that leaves hands its edges to the nearest of its neighbours, each the sum of two measurements (Kretzschmar and
//! Stachniss, "Information-theoretic compression of pose graphs for laser-based SLAM", 2012, with a star in place of their tree).

use jde_types::Pose2D;

use super::{Edge, Graph, Relation};
use crate::matrix::{Matrix, ZERO, add, diagonal, invert, product, transpose};

/// The covariance of a measurement that says nothing of some direction, m² and rad².
const VAGUE: Matrix = diagonal([1.0; 3]);

impl Graph {
    /// Removes poses. Returns the new number of each pose that stays. The first pose must stay.
    ///
    /// Takes time by the number of edges for each pose that leaves.
    pub(crate) fn remove(&mut self, is_leaving: &[bool]) -> Vec<Option<usize>> {
        for leaving in (0..self.poses.len()).filter(|&at| is_leaving[at]) {
            self.hand_over(leaving);
        }
        let mut next = 0..;
        let numbers: Vec<Option<usize>> = (is_leaving.iter())
            .map(|is_leaving| if *is_leaving { None } else { next.next() })
            .collect();
        self.edges.retain_mut(|edge| {
            let (from, to) = (numbers[edge.from], numbers[edge.to]);
            (edge.from, edge.to) = (from.unwrap_or(edge.from), to.unwrap_or(edge.to));
            from.and(to).is_some()
        });
        let mut numbered = numbers.iter();
        self.poses
            .retain(|_| numbered.next().is_some_and(Option::is_some));
        self.work = None;
        numbers
    }

    /// Hands the edges of a pose to the nearest of those that successive scans link with it.
    fn hand_over(&mut self, leaving: usize) {
        let (own, others): (Vec<Edge>, Vec<Edge>) =
            (self.edges.iter()).partition(|edge| edge.from == leaving || edge.to == leaving);
        // A loop that lost its weight is not passed on.
        let own = own.into_iter().filter(|edge| !self.is_doubted(edge));
        let own: Vec<(usize, Relation, Measured)> = own
            .map(|edge| match edge.from == leaving {
                true => (edge.to, edge.relation, Measured::of(&edge)),
                false => (edge.from, edge.relation, Measured::of(&edge).back()),
            })
            .collect();
        self.edges = others;
        let way = |of: &Measured| libm::hypot(of.pose.x, of.pose.y);
        let Some((heir, _, to_heir)) = (own.iter())
            .filter(|(_, relation, _)| *relation == Relation::Successive)
            .min_by(|a, b| way(&a.2).total_cmp(&way(&b.2)))
        else {
            return;
        };
        let from_heir = to_heir.back();
        for (to, relation, measured) in own.iter().filter(|(to, ..)| to != heir) {
            let is_linked =
                |edge: &Edge| [(edge.from, edge.to), (edge.to, edge.from)].contains(&(*heir, *to));
            if *relation == Relation::Loop && self.edges.iter().any(is_linked) {
                continue;
            }
            let edge = from_heir.then(measured).edge(*heir, *to, *relation);
            self.edges.push(edge);
        }
    }

    /// Moves a pose by an offset in its frame, and states what was measured from and to it accordingly.
    pub(crate) fn shift(&mut self, at: usize, offset: &Pose2D) {
        let offset = Measured {
            pose: *offset,
            covariance: ZERO,
        };
        self.poses[at] = self.poses[at].transform(&offset.pose);
        for edge in &mut self.edges {
            let (from, to, relation) = (edge.from, edge.to, edge.relation);
            if from == at {
                *edge = offset.back().then(&Measured::of(edge)).edge(from, to, relation);
            } else if to == at {
                *edge = Measured::of(edge).then(&offset).edge(from, to, relation);
            }
        }
        self.work = None;
    }
}

/// A pose in the frame of another, and its covariance there.
struct Measured {
    pose: Pose2D,
    covariance: Matrix,
}

impl Measured {
    fn of(edge: &Edge) -> Self {
        Self {
            pose: edge.pose,
            covariance: invert(&edge.information).unwrap_or(VAGUE),
        }
    }

    fn edge(&self, from: usize, to: usize, relation: Relation) -> Edge {
        let information = invert(&self.covariance).unwrap_or(VAGUE);
        Edge {
            from,
            to,
            pose: self.pose,
            information,
            relation,
        }
    }

    /// The other pose in the frame of this one.
    fn back(&self) -> Self {
        let pose = self.pose.localize(&Pose2D::ORIGIN);
        let (sin, cos) = libm::sincos(self.pose.theta);
        let slopes = [[-cos, -sin, pose.y], [sin, -cos, -pose.x], [0.0, 0.0, -1.0]];
        Self {
            pose,
            covariance: spread(&slopes, &self.covariance),
        }
    }

    /// The pose of what is measured from there.
    fn then(&self, next: &Self) -> Self {
        let pose = self.pose.transform(&next.pose);
        let (sin, cos) = libm::sincos(self.pose.theta);
        let (x, y) = (pose.x - self.pose.x, pose.y - self.pose.y);
        let turn = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
        let mut covariance = spread(
            &[[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]],
            &self.covariance,
        );
        add(&mut covariance, 1.0, &spread(&turn, &next.covariance));
        Self { pose, covariance }
    }
}

/// A covariance by these slopes.
fn spread(slopes: &Matrix, covariance: &Matrix) -> Matrix {
    product(&product(slopes, covariance), &transpose(slopes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(from: usize, to: usize, pose: Pose2D, relation: Relation) -> Edge {
        Edge {
            from,
            to,
            pose,
            information: diagonal([1e4, 1e4, 4e4]),
            relation,
        }
    }

    /// Poses along an arc, each measured from the one before it, and a loop over them.
    fn arc() -> Graph {
        let mut graph = Graph::default();
        let step = Pose2D::new(0.5, 0.1, 0.3);
        let mut pose = Pose2D::new(1.0, 2.0, 0.5);
        graph.add_pose(pose);
        for to in 1..6 {
            pose = pose.transform(&step);
            graph.add_pose(pose);
            graph.add_edge(edge(to - 1, to, step, Relation::Successive));
        }
        let over = graph.poses()[1].localize(&graph.poses()[4]);
        graph.add_edge(edge(1, 4, over, Relation::Loop));
        graph
    }

    #[test]
    fn what_was_measured_over_a_pose_that_leaves_stays() {
        let mut graph = arc();
        let before = graph.poses().to_vec();
        let numbers = graph.remove(&[false, false, true, false, true, false]);
        assert_eq!(numbers, [Some(0), Some(1), None, Some(2), None, Some(3)]);
        assert_eq!(graph.poses(), [0, 1, 3, 5].map(|at| before[at]));
        let mut links: Vec<_> = (graph.edges().iter()).map(|edge| (edge.from, edge.to)).collect();
        links.sort_unstable();
        assert_eq!(
            links,
            [(0, 1), (1, 2), (2, 3)],
            "each is reached over successive scans"
        );
        for edge in graph.edges() {
            let between = graph.poses()[edge.from].localize(&graph.poses()[edge.to]);
            assert!(between.distance_to(&edge.pose) < 1e-9, "{edge:?}");
            assert!(edge.information[0][0] > 0.0 && edge.information[0][0] <= 1e4 + 1e-6);
        }
        while !graph.is_settled() {
            graph.iterate();
        }
        let moved = graph.poses().iter().zip([0, 1, 3, 5]);
        assert!(
            moved
                .into_iter()
                .all(|(pose, at)| pose.distance_to(&before[at]) < 1e-6)
        );
    }

    #[test]
    fn a_pose_that_is_shifted_is_measured_where_it_is() {
        let mut graph = arc();
        graph.shift(1, &Pose2D::new(0.2, -0.1, 0.7));
        for edge in graph.edges() {
            let between = graph.poses()[edge.from].localize(&graph.poses()[edge.to]);
            assert!(between.distance_to(&edge.pose) < 1e-9, "{edge:?}");
        }
    }

    #[test]
    fn forth_and_back_are_as_certain() {
        let measured = Measured {
            pose: Pose2D::new(1.0, 2.0, 0.7),
            covariance: [[0.04, 0.01, 0.0], [0.01, 0.02, 0.003], [0.0, 0.003, 0.01]],
        };
        let back = measured.back().back();
        for (row, expected) in back.covariance.iter().zip(&measured.covariance) {
            for (number, expected) in row.iter().zip(expected) {
                assert!((number - expected).abs() < 1e-12);
            }
        }
    }
}
