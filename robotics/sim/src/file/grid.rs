//! A grid of cells, and the rectangles that cover its occupied cells.
//!
//! This module handles cells only; `map` handles metres, rotations and files.

use jde_map_file::MapCell;

/// Cells by rows, from the lowest row.
#[derive(Debug)]
pub(crate) struct Grid {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) cells: Vec<MapCell>,
}

/// A block of cells: the columns `left..right` and the rows `bottom..top`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    pub(crate) left: usize,
    pub(crate) right: usize,
    pub(crate) bottom: usize,
    pub(crate) top: usize,
}

impl Grid {
    /// Covers every occupied cell exactly once: runs of a row, merged upward while the next row has an
    /// identical run. Returns `None` if that takes more than `most` blocks.
    pub(crate) fn blocks(&self, most: usize) -> Option<Vec<Block>> {
        let mut done = Vec::new();
        let mut open: Vec<Block> = Vec::new();
        for (row, cells) in self.cells.chunks_exact(self.width).enumerate() {
            // Both lists are ordered from left to right, so one pass pairs them.
            let mut below = std::mem::take(&mut open).into_iter().peekable();
            for (left, right) in runs(cells) {
                while let Some(block) = below.next_if(|block| block.left < left) {
                    done.push(block);
                }
                match below.next_if(|block| (block.left, block.right) == (left, right)) {
                    Some(block) => open.push(Block {
                        top: row + 1,
                        ..block
                    }),
                    None => open.push(Block {
                        left,
                        right,
                        bottom: row,
                        top: row + 1,
                    }),
                }
            }
            done.extend(below);
            if done.len() + open.len() > most {
                return None;
            }
        }
        done.extend(open);
        Some(done)
    }
}

fn runs(cells: &[MapCell]) -> impl Iterator<Item = (usize, usize)> {
    let mut next = 0;
    std::iter::from_fn(move || {
        let left = next + cells[next..].iter().position(|&cell| cell == MapCell::Occupied)?;
        let right = cells[left..]
            .iter()
            .position(|&cell| cell != MapCell::Occupied)
            .map_or(cells.len(), |run| left + run);
        next = right;
        Some((left, right))
    })
}

#[cfg(test)]
mod tests {
    use super::{Block, Grid, MapCell};
    use proptest::prelude::*;

    fn grid(rows: &[&str]) -> Grid {
        let cells = rows.iter().rev().flat_map(|row| row.chars());
        let cells = cells
            .map(|c| {
                if c == '#' {
                    MapCell::Occupied
                } else {
                    MapCell::Free
                }
            })
            .collect();
        Grid {
            width: rows[0].len(),
            height: rows.len(),
            cells,
        }
    }

    #[test]
    fn a_room_needs_one_block_a_side() {
        let room = grid(&["#####", "#...#", "#...#", "#####"]);
        assert_eq!(room.blocks(3), None);
        let blocks = room.blocks(4).expect("four blocks");
        let block = |left, right, bottom, top| Block {
            left,
            right,
            bottom,
            top,
        };
        assert_eq!(
            blocks,
            [
                block(0, 5, 0, 1),
                block(0, 1, 1, 3),
                block(4, 5, 1, 3),
                block(0, 5, 3, 4)
            ]
        );
    }

    proptest! {
        #[test]
        fn every_occupied_cell_is_covered_exactly_once(
            (width, cells) in (1usize..12).prop_flat_map(|width| {
                (Just(width), proptest::collection::vec(any::<bool>(), width * 9))
            })
        ) {
            let cells = cells.into_iter().map(|solid| if solid { MapCell::Occupied } else { MapCell::Free }).collect();
            let grid = Grid { width, height: 9, cells };
            let mut covered = vec![0; grid.cells.len()];
            for block in grid.blocks(usize::MAX).expect("any number") {
                for row in block.bottom..block.top {
                    for column in block.left..block.right {
                        covered[row * width + column] += 1;
                    }
                }
            }
            for (cell, times) in grid.cells.iter().zip(covered) {
                prop_assert_eq!(times, usize::from(*cell == MapCell::Occupied));
            }
        }
    }
}
