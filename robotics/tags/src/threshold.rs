//! Which pixels are dark and which are bright, compared with the pixels near them.

use crate::Gray;

/// The side of a tile of the picture, px: smaller than a tag that can be read.
const TILE: usize = 4;
/// The least contrast around a pixel that tells dark from bright: above a camera's noise.
const CONTRAST: u8 = 5;

/// How bright a pixel is, compared with the pixels near it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tone {
    /// Everything near it is alike.
    Flat,
    Dark,
    Bright,
}

/// Compares each pixel with the mean of the darkest and the brightest one in its tile and the eight tiles around,
/// and fills `tones` by rows. Columns and rows beyond the last whole tile belong to that one. A picture smaller than
/// a tile is flat.
pub(crate) fn tones(picture: &Gray<'_>, tones: &mut Vec<Tone>) {
    tones.clear();
    tones.resize(picture.width * picture.height, Tone::Flat);
    let (columns, rows) = (picture.width / TILE, picture.height / TILE);
    if columns == 0 || rows == 0 {
        return;
    }
    let tiles = extremes(picture, [columns, rows]);
    for row in 0..picture.height {
        let tile_row = (row / TILE).min(rows - 1);
        let line = &tiles[tile_row * columns..][..columns];
        let out = &mut tones[row * picture.width..][..picture.width];
        for (column, (tone, &value)) in out.iter_mut().zip(picture.row(row)).enumerate() {
            let (least, greatest) = line[(column / TILE).min(columns - 1)];
            *tone = if greatest - least < CONTRAST {
                Tone::Flat
            } else if value > least + (greatest - least) / 2 {
                Tone::Bright
            } else {
                Tone::Dark
            };
        }
    }
}

/// Returns the least and the greatest value in each tile and the eight around it.
fn extremes(picture: &Gray<'_>, [columns, rows]: [usize; 2]) -> Vec<(u8, u8)> {
    let join = |a: (u8, u8), b: (u8, u8)| (a.0.min(b.0), a.1.max(b.1));
    let mut tiles = vec![(u8::MAX, 0); columns * rows];
    for row in 0..rows * TILE {
        let line = &mut tiles[row / TILE * columns..][..columns];
        for (tile, pixels) in line.iter_mut().zip(picture.row(row).as_chunks::<TILE>().0) {
            *tile = pixels
                .iter()
                .fold(*tile, |tile, &value| join(tile, (value, value)));
        }
    }
    let near = |index: usize, count: usize| index.saturating_sub(1)..(index + 2).min(count);
    let place = |index: usize| [index / columns, index % columns];
    let beside = |index: usize| {
        let [row, column] = place(index);
        let line = &tiles[row * columns..][..columns];
        line[near(column, columns)]
            .iter()
            .copied()
            .fold((u8::MAX, 0), join)
    };
    let wide: Vec<(u8, u8)> = (0..tiles.len()).map(beside).collect();
    let around = |index: usize| {
        let [row, column] = place(index);
        let lines = near(row, rows).map(|row| wide[row * columns + column]);
        lines.fold((u8::MAX, 0), join)
    };
    (0..tiles.len()).map(around).collect()
}
