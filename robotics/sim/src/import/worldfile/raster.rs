//! The bitmaps of models, drawn into one map of the world. Stage stretches the dark pixels of a bitmap, not
//! the whole picture, over the size of its model.

use std::path::Path;
use std::rc::Rc;

use jde_files::{Budget, Exceeded, LeftOut};
use jde_map_file::{MapCell, MapFile, Picture, Shade};

use crate::import::pose::Pose;

/// The brightest wall. Stage looks at the first channel of a pixel alone, so that red lines are as white as the paper, and
/// at no transparency.
const DARK: u8 = 127;
/// Pixels that are visited in the time of a step.
const PER_STEP: usize = 16;
/// Most cells of a map.
const MAX_CELLS: f64 = 2.5e7;
/// What a robot has around its start, m.
const AROUND: f64 = 1.0;

/// A bitmap on the floor.
#[derive(Debug)]
pub(super) struct Bitmap {
    picture: Rc<Picture>,
    /// The first column and row from the top with a dark pixel, and the numbers of columns and rows up to the last one.
    first: [usize; 2],
    count: [usize; 2],
    /// The middle of the dark pixels.
    pose: Pose,
    size: [f64; 2],
}

impl Bitmap {
    /// Reads the picture of a bitmap.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(super) fn picture(path: &Path) -> Result<Picture, String> {
        Picture::load(path, Shade::Red).map_err(|fault| fault.to_string())
    }

    /// Puts a picture into the world; `None` if it has no dark pixel.
    ///
    /// # Errors
    /// Too much is read already.
    pub(super) fn new(
        picture: Rc<Picture>,
        pose: Pose,
        size: [f64; 2],
        budget: &mut Budget,
    ) -> Result<Option<Self>, Exceeded> {
        let pixels = picture.shades.len();
        budget.work(pixels / PER_STEP)?;
        let (mut first, mut last) = ([usize::MAX; 2], [0; 2]);
        for (row, shades) in picture.shades.chunks_exact(picture.width).enumerate() {
            let is_dark = |shade: &u8| *shade <= DARK;
            let ends = shades
                .iter()
                .position(is_dark)
                .zip(shades.iter().rposition(is_dark));
            if let Some((left, right)) = ends {
                first = [first[0].min(left), first[1].min(row)];
                last = [last[0].max(right), row];
            }
        }
        if first[0] > last[0] {
            return Ok(None);
        }
        Ok(Some(Self {
            count: [0, 1].map(|axis| last[axis] - first[axis] + 1),
            first,
            picture,
            pose,
            size,
        }))
    }

    fn pixel_sizes(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.size[axis] / self.count[axis] as f64)
    }

    fn corners(&self) -> [[f64; 2]; 4] {
        let [x, y] = self.size.map(|length| length / 2.0);
        [[-x, -y], [x, -y], [x, y], [-x, y]].map(|corner| self.pose.point(corner))
    }

    /// Returns whether a place in the world is dark.
    fn is_dark(&self, place: [f64; 2]) -> bool {
        let local = self.pose.local(place);
        let cell = [0, 1].map(|axis| {
            let part = local[axis] / self.size[axis] + 0.5;
            let index = (part * self.count[axis] as f64).floor();
            let is_inside = index >= 0.0 && index < self.count[axis] as f64;
            is_inside.then_some(index as usize)
        });
        let [Some(column), Some(row)] = cell else {
            return false;
        };
        // The rows of a picture begin at its top.
        let row = self.first[1] + self.count[1] - 1 - row;
        self.picture.shades[row * self.picture.width + self.first[0] + column] <= DARK
    }
}

/// Draws bitmaps into a map with cells as large as the smallest pixel side; `None` without bitmaps. The map also has
/// free cells around the starts of robots, because none may start outside.
///
/// # Errors
/// The map would be too large, or too many bitmaps lie upon each other.
pub(super) fn draw(
    bitmaps: &[Bitmap],
    starts: &[[f64; 2]],
    budget: &mut Budget,
) -> Result<Option<MapFile>, String> {
    let corners: Vec<_> = bitmaps.iter().flat_map(Bitmap::corners).collect();
    let sizes = bitmaps.iter().flat_map(Bitmap::pixel_sizes);
    let Some(resolution) = sizes.reduce(f64::min) else {
        return Ok(None);
    };
    // The lower end of an axis, and the number of cells along it. The corner of the bitmaps is that of a
    // cell.
    let span = |axis: usize| {
        let along = corners.iter().map(|corner| corner[axis]);
        let starts = starts.iter().map(|start| start[axis]);
        let lower = along.clone().fold(f64::INFINITY, f64::min);
        let upper = along
            .chain(starts.clone().map(|start| start + AROUND))
            .fold(lower, f64::max);
        let below = starts
            .map(|start| (lower - (start - AROUND)) / resolution)
            .fold(0.0, f64::max)
            .ceil();
        // The rounding of a side that is a whole number of cells adds none.
        let cells = ((upper - lower) / resolution - 1e-6).ceil().max(1.0);
        (lower - below * resolution, cells + below)
    };
    let ((left, width), (bottom, height)) = (span(0), span(1));
    let cells: f64 = width * height;
    if !cells.is_finite() || cells > MAX_CELLS {
        return Err(format!(
            "the bitmaps need {width} x {height} cells: expected at most {MAX_CELLS} in all"
        ));
    }
    let (columns, rows) = (width as usize, height as usize);
    let mut cells = vec![MapCell::Free; columns * rows];
    let center = |start: f64, index: usize| start + (index as f64 + 0.5) * resolution;
    for bitmap in bitmaps {
        let corners = bitmap.corners();
        // The cells around the bitmap along an axis.
        let around = |axis: usize, start: f64, count: usize| {
            let along = corners.iter().map(|corner| (corner[axis] - start) / resolution);
            let lower = along.clone().fold(f64::INFINITY, f64::min).floor().max(0.0);
            let upper = along.fold(0.0, f64::max).ceil();
            lower as usize..(upper as usize).min(count)
        };
        let (columns_around, rows_around) = (around(0, left, columns), around(1, bottom, rows));
        let visited = columns_around.len() * rows_around.len();
        let counted = budget.work(visited);
        counted.map_err(|exceeded| format!("the bitmaps are too large: {exceeded}"))?;
        for row in rows_around {
            let cells = &mut cells[row * columns..][..columns];
            for column in columns_around.clone() {
                if bitmap.is_dark([center(left, column), center(bottom, row)]) {
                    cells[column] = MapCell::Occupied;
                }
            }
        }
    }
    Ok(Some(MapFile {
        width: columns,
        height: rows,
        resolution,
        origin: [left, bottom, 0.0],
        cells,
        left_out: LeftOut::default(),
    }))
}
