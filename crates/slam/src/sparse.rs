//! Sparse symmetric systems of equations with blocks of 3 × 3, by Cholesky's method (LDLᵀ) in an order of least degree.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::matrix::{
    Matrix, Vector, ZERO, add, invert, product, product_transposed, times, times_transposed, transpose,
};

/// A system of equations over nodes; each pair of linked nodes has a block.
#[derive(Clone, Debug, Default)]
pub(crate) struct System {
    /// The place of each node in the order in which they are eliminated.
    places: Vec<u32>,
    /// By place: the places of those that are linked when it is eliminated, all of them later.
    links: Vec<Vec<u32>>,
    diagonal: Vec<Matrix>,
    /// By place and link: the block with its row in `place` and its column in the link.
    blocks: Vec<Vec<Matrix>>,
    right: Vec<Vector>,
}

impl System {
    /// Finds the order for so many nodes with links.
    pub(crate) fn new(nodes: usize, links: impl IntoIterator<Item = (usize, usize)>) -> Self {
        let mut near: Vec<Vec<u32>> = vec![Vec::new(); nodes];
        for (a, b) in links {
            near[a].push(b as u32);
            near[b].push(a as u32);
        }
        for (node, near) in near.iter_mut().enumerate() {
            near.sort_unstable();
            near.dedup();
            near.retain(|&other| other as usize != node);
        }
        let mut due: BinaryHeap<_> = (0..nodes).map(|node| Reverse((near[node].len(), node))).collect();
        let mut places = vec![u32::MAX; nodes];
        let mut order = Vec::with_capacity(nodes);
        while let Some(Reverse((degree, node))) = due.pop() {
            // Its degree may have changed since.
            if places[node] != u32::MAX || degree != near[node].len() {
                continue;
            }
            places[node] = order.len() as u32;
            let linked = core::mem::take(&mut near[node]);
            for &other in &linked {
                let merged = merge(&near[other as usize], &linked, [node as u32, other]);
                near[other as usize] = merged;
                due.push(Reverse((near[other as usize].len(), other as usize)));
            }
            order.push(linked);
        }
        let links: Vec<Vec<u32>> = (order.into_iter())
            .map(|linked| {
                let mut links: Vec<u32> = linked.iter().map(|&node| places[node as usize]).collect();
                links.sort_unstable();
                links
            })
            .collect();
        Self {
            blocks: links.iter().map(|links| vec![ZERO; links.len()]).collect(),
            diagonal: vec![ZERO; nodes],
            right: vec![[0.0; 3]; nodes],
            places,
            links,
        }
    }

    /// Sets all numbers to zero.
    pub(crate) fn clear(&mut self) {
        self.diagonal.fill(ZERO);
        self.right.fill([0.0; 3]);
        self.blocks.iter_mut().for_each(|blocks| blocks.fill(ZERO));
    }

    /// Adds to the block of a node.
    pub(crate) fn add_diagonal(&mut self, node: usize, block: &Matrix) {
        add(&mut self.diagonal[self.places[node] as usize], 1.0, block);
    }

    /// Adds to the block with its row in one node and its column in another; they are linked.
    pub(crate) fn add_link(&mut self, row: usize, column: usize, block: &Matrix) {
        let (row, column) = (self.places[row], self.places[column]);
        let (first, last) = (row.min(column), row.max(column));
        if let Ok(link) = self.links[first as usize].binary_search(&last) {
            let to = &mut self.blocks[first as usize][link];
            if row < column {
                add(to, 1.0, block);
            } else {
                add(to, 1.0, &transpose(block));
            }
        }
    }

    /// Adds to the right side.
    pub(crate) fn add_right(&mut self, node: usize, vector: &Vector) {
        let right = &mut self.right[self.places[node] as usize];
        (0..3).for_each(|axis| right[axis] += vector[axis]);
    }

    /// Adds to the numbers of the diagonal, which damps the step.
    pub(crate) fn damp(&mut self, by: f64) {
        for block in &mut self.diagonal {
            (0..3).for_each(|axis| block[axis][axis] += by);
        }
    }

    /// Solves it, and replaces its numbers. Returns a vector for each node; `None` if the matrix is not positive definite.
    pub(crate) fn solve(&mut self) -> Option<Vec<Vector>> {
        for place in 0..self.links.len() {
            self.eliminate(place)?;
        }
        for place in (0..self.links.len()).rev() {
            let mut vector = times(&self.diagonal[place], &self.right[place]);
            for (&link, block) in self.links[place].iter().zip(&self.blocks[place]) {
                let part = times(block, &self.right[link as usize]);
                (0..3).for_each(|axis| vector[axis] -= part[axis]);
            }
            self.right[place] = vector;
        }
        let of = |place: &u32| self.right[*place as usize];
        Some(self.places.iter().map(of).collect())
    }

    /// Takes a node out of the equations of those that it is linked to. Then its diagonal is its inverse, and its blocks
    /// are multiplied by that.
    fn eliminate(&mut self, place: usize) -> Option<()> {
        let inverse = invert(&self.diagonal[place])?;
        let (done, rest) = self.blocks.split_at_mut(place + 1);
        let blocks = &mut done[place];
        let links = &self.links[place];
        let right = self.right[place];
        for (number, &link) in links.iter().enumerate() {
            let (first, others) = (blocks[number], &blocks[number + 1..]);
            let scaled = product(&inverse, &first);
            add(
                &mut self.diagonal[link as usize],
                -1.0,
                &product_transposed(&first, &scaled),
            );
            let part = times_transposed(&scaled, &right);
            (0..3).for_each(|axis| self.right[link as usize][axis] -= part[axis]);
            // The links of a link include all later ones of this place.
            let to = &mut rest[link as usize - place - 1];
            let mut at = 0;
            for (&other, block) in links[number + 1..].iter().zip(others) {
                while self.links[link as usize][at] != other {
                    at += 1;
                }
                add(&mut to[at], -1.0, &product_transposed(&scaled, block));
            }
        }
        for block in blocks.iter_mut() {
            *block = product(&inverse, block);
        }
        self.diagonal[place] = inverse;
        Some(())
    }
}

/// The sorted union of two sorted lists without two numbers.
fn merge(a: &[u32], b: &[u32], without: [u32; 2]) -> Vec<u32> {
    let mut merged = Vec::with_capacity(a.len() + b.len());
    let (mut left, mut right) = (0, 0);
    while left < a.len() || right < b.len() {
        let next = match (a.get(left), b.get(right)) {
            (Some(&first), Some(&second)) => first.min(second),
            (Some(&only), None) | (None, Some(&only)) => only,
            (None, None) => break,
        };
        left += usize::from(a.get(left) == Some(&next));
        right += usize::from(b.get(right) == Some(&next));
        if !without.contains(&next) {
            merged.push(next);
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::matrix::diagonal;

    /// JᵀJ of random blocks, and what it gives for a known vector.
    fn check(nodes: usize, links: &[(usize, usize)], numbers: &[f64]) {
        let mut numbers = numbers.iter().copied().cycle();
        let mut next = || numbers.next().expect("they never end");
        let mut system = System::new(nodes, links.iter().copied());
        system.clear();
        let truth: Vec<Vector> = (0..nodes).map(|_| [next(), next(), next()]).collect();
        let apply = |system: &mut System, row: usize, block: &Matrix, column: usize| {
            system.add_right(row, &times(block, &truth[column]));
        };
        for node in 0..nodes {
            system.add_diagonal(node, &diagonal([0.5; 3]));
            apply(&mut system, node, &diagonal([0.5; 3]), node);
        }
        for &(a, b) in links.iter().filter(|(a, b)| a != b) {
            let mut block = || -> Matrix { core::array::from_fn(|_| core::array::from_fn(|_| next())) };
            let (left, right) = (block(), block());
            let cross = product_transposed(&left, &right);
            for (node, of) in [(a, &left), (b, &right)] {
                let square = product_transposed(of, of);
                system.add_diagonal(node, &square);
                apply(&mut system, node, &square, node);
            }
            system.add_link(a, b, &cross);
            apply(&mut system, a, &cross, b);
            apply(&mut system, b, &transpose(&cross), a);
        }
        let found = system.solve().expect("positive definite");
        for (found, truth) in found.iter().flatten().zip(truth.iter().flatten()) {
            assert!((found - truth).abs() < 1e-6, "{found} for {truth}");
        }
    }

    proptest! {
        #[test]
        fn the_vector_of_a_system_is_found(
            nodes in 1usize..40,
            links in proptest::collection::vec((0usize..40, 0usize..40), 0..80),
            numbers in proptest::collection::vec(-1.0..1.0f64, 97),
        ) {
            let links: Vec<_> = links.iter().map(|&(a, b)| (a % nodes, b % nodes)).collect();
            check(nodes, &links, &numbers);
        }
    }

    #[test]
    fn a_system_without_an_answer_has_none() {
        let mut system = System::new(2, [(0, 1)]);
        system.add_diagonal(0, &diagonal([1.0; 3]));
        assert_eq!(system.solve(), None);
    }
}
