//! The bitmaps of models, drawn into one map of the world. Stage stretches the dark pixels of a bitmap, not
//! the whole picture, over the size of its model.

use std::path::Path;

use jde_map_file::{Cell, MapFile};

use crate::import::pose::Pose;

/// The map that reads a bitmap: a pixel that is darker than half is a wall.
const HEADER: &str =
    "resolution: 1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.5\nfree_thresh: 0.499\n";
/// Most cells of a map.
const MAX_CELLS: f64 = 2.5e7;
/// What a robot has around its start, m.
const AROUND: f64 = 1.0;
/// Grey values of free cells and of walls.
const FREE: u8 = 254;
const WALL: u8 = 0;

/// A bitmap on the floor.
#[derive(Debug)]
pub(super) struct Bitmap {
    picture: MapFile,
    /// The first column and row with a dark pixel, and the numbers of columns and rows up to the last one.
    first: [usize; 2],
    count: [usize; 2],
    /// The middle of the dark pixels.
    pose: Pose,
    size: [f64; 2],
}

/// The map of all bitmaps.
#[derive(Debug)]
pub(super) struct Raster {
    /// Length of a cell's side, m.
    pub(super) resolution: f64,
    /// The lower left corner, m.
    pub(super) origin: [f64; 2],
    /// The picture as a PGM file.
    pub(super) pgm: Vec<u8>,
}

impl Bitmap {
    /// Reads a bitmap, a PNG or PGM file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(super) fn load(path: &Path, pose: Pose, size: [f64; 2]) -> Result<Self, String> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let text = format!("image: {name:?}\n{HEADER}");
        let picture = MapFile::parse(&path.with_extension("yaml"), &text).map_err(|faults| {
            faults
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join("; ")
        })?;
        let is_dark = |index: &usize| picture.cells[*index] == Cell::Occupied;
        let dark: Vec<usize> = (0..picture.cells.len()).filter(is_dark).collect();
        let (columns, rows) = (
            dark.iter().map(|index| index % picture.width),
            dark.iter().map(|index| index / picture.width),
        );
        let (Some(left), Some(right)) = (columns.clone().min(), columns.max()) else {
            return Err(format!("the bitmap {name:?} has no dark pixel"));
        };
        let (bottom, top) = (
            rows.clone().min().unwrap_or_default(),
            rows.max().unwrap_or_default(),
        );
        Ok(Self {
            first: [left, bottom],
            count: [right - left + 1, top - bottom + 1],
            picture,
            pose,
            size,
        })
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
            is_inside.then(|| self.first[axis] + index as usize)
        });
        let [Some(column), Some(row)] = cell else {
            return false;
        };
        self.picture.cells[row * self.picture.width + column] == Cell::Occupied
    }
}

impl Raster {
    /// Draws bitmaps with cells as large as the smallest pixel side; `None` without bitmaps. The map also has
    /// free cells around the starts of robots, because none may start outside.
    ///
    /// # Errors
    /// If the map would be too large.
    pub(super) fn draw(bitmaps: &[Bitmap], starts: &[[f64; 2]]) -> Result<Option<Self>, String> {
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
        let mut pgm = format!("P5\n{width} {height}\n255\n").into_bytes();
        let center = |start: f64, index: usize| start + (index as f64 + 0.5) * resolution;
        for row in (0..height as usize).rev() {
            for column in 0..width as usize {
                let place = [center(left, column), center(bottom, row)];
                let is_dark = bitmaps.iter().any(|bitmap| bitmap.is_dark(place));
                pgm.push(if is_dark { WALL } else { FREE });
            }
        }
        Ok(Some(Self {
            resolution,
            origin: [left, bottom],
            pgm,
        }))
    }

    /// Returns the text of the map's YAML file, which names the picture.
    pub(super) fn yaml(&self, picture: &str) -> String {
        let [x, y] = self.origin;
        format!(
            "image: {picture:?}\nresolution: {}\norigin: [{x}, {y}, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
            self.resolution
        )
    }
}
