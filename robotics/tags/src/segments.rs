//! Areas of dark and of bright pixels, and the edges between them: for each pair of a dark and a bright area that
//! touch, the points between their pixels. The edge of a tag is one of them.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use crate::threshold::Tone;

/// Fewest pixels of an area: smaller ones are noise.
const LEAST_PIXELS: u32 = 25;

/// A point halfway between a dark and a bright pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgePoint {
    /// Column and row, in half pixels from the middle of the first pixel.
    pub(crate) place: [i32; 2],
    /// From dark to bright.
    pub(crate) toward: [i8; 2],
}

/// Finds the edges of pictures, and keeps its buffers from one to the next.
#[derive(Debug, Default)]
pub(crate) struct Segments {
    /// The label of each pixel; 0 for a flat one.
    labels: Vec<u32>,
    /// For each label another one of the same area, or itself. It is never greater.
    parents: Vec<u32>,
    pixels: Vec<u32>,
    /// For each pair of areas the number of its edge.
    pairs: HashMap<u64, u32, BuildHasherDefault<PairHasher>>,
}

impl Segments {
    /// Returns the edges of a picture of so many columns.
    pub(crate) fn edges(&mut self, tones: &[Tone], width: usize) -> Vec<Vec<EdgePoint>> {
        self.label(tones, width);
        let mut edges: Vec<Vec<EdgePoint>> = Vec::new();
        self.pairs.clear();
        let mut last = (0, 0);
        let height = tones.len() / width.max(1);
        for row in 1..height.saturating_sub(1) {
            // The pixel before has an edge to the lower right, at the place of the edge to the lower left.
            let mut is_crossed = false;
            for column in 1..width - 1 {
                let here = row * width + column;
                let label = self.labels[here];
                let was_crossed = std::mem::take(&mut is_crossed);
                if label == 0 {
                    continue;
                }
                for step in [[1, 0], [0, 1], [-1, 1], [1, 1]] {
                    let there = (here + step[1] as usize * width).wrapping_add_signed(step[0] as isize);
                    let other = self.labels[there];
                    if other == 0 || tones[here] == tones[there] || (step == [-1, 1] && was_crossed) {
                        continue;
                    }
                    is_crossed = step == [1, 1];
                    let pair = u64::from(label.min(other)) << 32 | u64::from(label.max(other));
                    if last.0 != pair {
                        let next = edges.len() as u32;
                        last = (pair, *self.pairs.entry(pair).or_insert(next));
                        if last.1 == next {
                            edges.push(Vec::new());
                        }
                    }
                    let sign = if tones[here] == Tone::Dark { 1 } else { -1 };
                    edges[last.1 as usize].push(EdgePoint {
                        place: [
                            2 * column as i32 + i32::from(step[0]),
                            2 * row as i32 + i32::from(step[1]),
                        ],
                        toward: step.map(|part| sign * part),
                    });
                }
            }
        }
        edges
    }

    /// Gives the pixels of each area one label, and 0 to flat pixels and small areas. Dark pixels touch along a
    /// side, bright ones also at a corner: the dark border of a tag does not join dark things at its corners.
    fn label(&mut self, tones: &[Tone], width: usize) {
        self.labels.clear();
        self.labels.resize(tones.len(), 0);
        self.parents.clear();
        self.parents.push(0);
        for (here, &tone) in tones.iter().enumerate() {
            if tone == Tone::Flat {
                continue;
            }
            let column = here % width;
            let up = here.checked_sub(width);
            let is_bright = tone == Tone::Bright;
            let neighbours = [
                (column > 0).then(|| here - 1),
                up,
                up.filter(|_| is_bright && column > 0).map(|up| up - 1),
                up.filter(|_| is_bright && column + 1 < width).map(|up| up + 1),
            ];
            let mut label = 0;
            for there in neighbours
                .into_iter()
                .flatten()
                .filter(|&there| tones[there] == tone)
            {
                let other = self.labels[there];
                if label == 0 {
                    label = other;
                } else if label != other {
                    label = self.join(label, other);
                }
            }
            if label == 0 {
                label = self.parents.len() as u32;
                self.parents.push(label);
            }
            self.labels[here] = label;
        }
        self.pixels.clear();
        self.pixels.resize(self.parents.len(), 0);
        for label in 1..self.parents.len() {
            // The parent is smaller, so its own parent is already the root.
            self.parents[label] = self.parents[self.parents[label] as usize];
        }
        for label in &mut self.labels {
            *label = self.parents[*label as usize];
            self.pixels[*label as usize] += 1;
        }
        self.pixels[0] = 0;
        for label in &mut self.labels {
            if self.pixels[*label as usize] < LEAST_PIXELS {
                *label = 0;
            }
        }
    }

    /// Joins the areas of two labels, and returns the label of both.
    fn join(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (self.root(a), self.root(b));
        let (root, other) = (a.min(b), a.max(b));
        self.parents[other as usize] = root;
        root
    }

    /// Returns the root of a label. Shortens the chain on its way.
    fn root(&mut self, mut label: u32) -> u32 {
        while self.parents[label as usize] != label {
            let parent = self.parents[label as usize];
            self.parents[label as usize] = self.parents[parent as usize];
            label = parent;
        }
        label
    }
}

/// Hashes a pair of labels: faster than the default, which withstands chosen keys, and the same in every run.
#[derive(Debug, Default)]
struct PairHasher(u64);

impl Hasher for PairHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(u64::from(byte));
        }
    }

    fn write_u64(&mut self, pair: u64) {
        // Fibonacci hashing: the high bits, which the table uses too, depend on all of the pair.
        self.0 = (self.0 ^ pair ^ pair >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 ^= self.0 >> 32;
    }
}
