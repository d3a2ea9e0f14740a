//! Sparse symmetric systems of equations with blocks of 3 × 3, by Cholesky's method (LDLᵀ) in an order of least degree.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::matrix::{
    Matrix, Vector, ZERO, add, invert, product, subtract_product, times, times_transposed, transpose,
};

/// The place of a node that is not ordered yet.
const NONE: u32 = u32::MAX;

/// A system of equations over nodes; each pair of linked nodes has a block.
#[derive(Clone, Debug)]
pub(crate) struct System {
    /// What each node that is not ordered yet is linked with, and these nodes, of least degree first.
    near: Vec<Vec<u32>>,
    due: BinaryHeap<Reverse<(usize, usize)>>,
    /// The place of each node in the order in which they are eliminated.
    places: Vec<u32>,
    /// By place: the places of those that are linked when it is eliminated, all of them later.
    links: Vec<Vec<u32>>,
    diagonal: Vec<Matrix>,
    /// By place and link: the block with its row in `place` and its column in the link.
    blocks: Vec<Vec<Matrix>>,
    right: Vec<Vector>,
    /// The place that is eliminated next.
    next: usize,
}

/// A matrix is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotPositive;

impl System {
    /// The system of so many nodes with links, all of its numbers zero.
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
        Self {
            due: (0..nodes).map(|node| Reverse((near[node].len(), node))).collect(),
            near,
            places: vec![NONE; nodes],
            links: Vec::with_capacity(nodes),
            diagonal: vec![ZERO; nodes],
            blocks: Vec::new(),
            right: vec![[0.0; 3]; nodes],
            next: 0,
        }
    }

    /// Orders nodes, by about `most` steps. Returns whether all are ordered; only then it takes numbers.
    pub(crate) fn order(&mut self, most: usize) -> bool {
        let mut done = 0;
        while let Some(Reverse((degree, node))) = self.due.pop() {
            // Its degree may have changed since.
            if self.places[node] != NONE || degree != self.near[node].len() {
                continue;
            }
            self.places[node] = self.links.len() as u32;
            let linked = core::mem::take(&mut self.near[node]);
            for &other in &linked {
                let near = &mut self.near[other as usize];
                *near = merge(near, &linked, [node as u32, other]);
                done += near.len();
                self.due.push(Reverse((near.len(), other as usize)));
            }
            self.links.push(linked);
            if done > most {
                return false;
            }
        }
        if self.blocks.is_empty() {
            for links in &mut self.links {
                links
                    .iter_mut()
                    .for_each(|node| *node = self.places[*node as usize]);
                links.sort_unstable();
            }
            self.blocks = self.links.iter().map(|links| vec![ZERO; links.len()]).collect();
        }
        true
    }

    /// Sets all numbers to zero again; the order stays.
    pub(crate) fn clear(&mut self) {
        self.next = 0;
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

    /// Eliminates nodes, about `most` products of blocks; the numbers of the system are replaced. Returns the vector of each
    /// node when all are eliminated.
    ///
    /// # Errors
    /// If the matrix is not positive definite.
    pub(crate) fn solve(&mut self, most: usize) -> Result<Option<Vec<Vector>>, NotPositive> {
        let mut done = 0;
        while self.next < self.links.len() {
            if done > most {
                return Ok(None);
            }
            let links = self.links[self.next].len();
            done += 1 + links * (links + 3) / 2;
            self.eliminate(self.next)?;
            self.next += 1;
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
        Ok(Some(self.places.iter().map(of).collect()))
    }

    /// Takes a node out of the equations of those that it is linked to. Then its diagonal is its inverse, and its blocks
    /// are multiplied by that.
    fn eliminate(&mut self, place: usize) -> Result<(), NotPositive> {
        let inverse = invert(&self.diagonal[place]).ok_or(NotPositive)?;
        let (done, rest) = self.blocks.split_at_mut(place + 1);
        let blocks = &mut done[place];
        let links = &self.links[place];
        let right = self.right[place];
        for (number, &link) in links.iter().enumerate() {
            let (first, others) = (blocks[number], &blocks[number + 1..]);
            let scaled = product(&inverse, &first);
            subtract_product(&mut self.diagonal[link as usize], &first, &scaled);
            let part = times_transposed(&scaled, &right);
            (0..3).for_each(|axis| self.right[link as usize][axis] -= part[axis]);
            // The links of a link include all later ones of this place.
            let to = self.links[link as usize]
                .iter()
                .zip(&mut rest[link as usize - place - 1]);
            let mut others = links[number + 1..].iter().zip(others);
            let mut next = others.next();
            for (other, to) in to {
                let Some((due, block)) = next else { break };
                if due == other {
                    subtract_product(to, &scaled, block);
                    next = others.next();
                }
            }
        }
        for block in blocks.iter_mut() {
            *block = product(&inverse, block);
        }
        self.diagonal[place] = inverse;
        Ok(())
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
    use crate::matrix::{diagonal, product_transposed};

    /// JᵀJ of random blocks, and what it gives for a known vector.
    fn check(nodes: usize, links: &[(usize, usize)], numbers: &[f64], most: usize) {
        let mut numbers = numbers.iter().copied().cycle();
        let mut next = || numbers.next().expect("they never end");
        let mut system = System::new(nodes, links.iter().copied());
        while !system.order(most) {}
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
        let found = loop {
            if let Some(found) = system.solve(most).expect("positive definite") {
                break found;
            }
        };
        for (found, truth) in found.iter().flatten().zip(truth.iter().flatten()) {
            assert!((found - truth).abs() < 1e-6, "{found} for {truth}");
        }
    }

    proptest! {
        #[test]
        fn the_vector_of_a_system_is_found_in_parts(
            nodes in 1usize..40,
            links in proptest::collection::vec((0usize..40, 0usize..40), 0..80),
            numbers in proptest::collection::vec(-1.0..1.0f64, 97),
            most in 0usize..100,
        ) {
            let links: Vec<_> = links.iter().map(|&(a, b)| (a % nodes, b % nodes)).collect();
            check(nodes, &links, &numbers, most);
        }
    }

    #[test]
    fn a_system_without_an_answer_has_none() {
        let mut system = System::new(2, [(0, 1)]);
        assert!(system.order(usize::MAX));
        system.add_diagonal(0, &diagonal([1.0; 3]));
        assert_eq!(system.solve(usize::MAX), Err(NotPositive));
    }
}
