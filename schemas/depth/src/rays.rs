//! The direction of each pixel, which is the same from picture to picture.

use jde_depth::Level;
use jde_vision::CameraModel;

/// Directions in the level frame for a depth of 1 m; none where the lens shows nothing.
#[derive(Debug)]
pub(crate) struct Rays {
    of: (CameraModel, Level, [usize; 2]),
    directions: Vec<Option<[f64; 3]>>,
}

impl Rays {
    /// Returns those of a camera, and whether they are new: those that are kept stay if they are of it.
    pub(crate) fn kept(
        kept: &mut Option<Self>,
        camera: CameraModel,
        level: Level,
        size: [usize; 2],
    ) -> (&Self, bool) {
        let of = (camera, level, size);
        let is_new = kept.as_ref().is_none_or(|kept| kept.of != of);
        if is_new {
            *kept = None;
        }
        let rays = kept.get_or_insert_with(|| {
            let [columns, rows] = size;
            let ray = |row: usize, column: usize| {
                let ray = camera.ray([column as f64 + 0.5, row as f64 + 0.5])?;
                let [x, y, z] = level.optical(ray);
                Some([x, y, z - level.height])
            };
            let directions = (0..rows).flat_map(|row| (0..columns).map(move |column| ray(row, column)));
            Self {
                of,
                directions: directions.collect(),
            }
        });
        (rays, is_new)
    }

    /// Returns the direction of each pixel, row by row.
    pub(crate) fn directions(&self) -> impl Iterator<Item = Option<[f64; 3]>> + '_ {
        self.directions.iter().copied()
    }
}
