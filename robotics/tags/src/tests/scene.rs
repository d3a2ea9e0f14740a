//! Draws tags before a camera: exact up to the mean of sixteen rays a pixel.

use crate::{Family, Gray, Pinhole};

/// The side of a tag, m.
pub(super) const SIZE: f64 = 0.16;
/// Columns and rows of a picture.
pub(super) const PICTURE: [usize; 2] = [320, 240];

/// A tag before a camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) family: Family,
    pub(super) id: u32,
    /// The middle of the tag in the frame of the camera, m.
    pub(super) position: [f64; 3],
    /// The rotations about its z axis, then about the camera's x axis, then about its y axis, rad.
    pub(super) turns: [f64; 3],
}

/// A picture that owns its pixels.
pub(super) struct Picture(pub(super) Vec<u8>);

impl Picture {
    pub(super) fn gray(&self) -> Gray<'_> {
        Gray::new(PICTURE, &self.0).expect("the sizes agree")
    }
}

pub(super) fn camera() -> Pinhole {
    Pinhole::new(PICTURE, 60_f64.to_radians())
}

impl Placed {
    /// Returns the axes of the tag.
    pub(super) fn axes(&self) -> [[f64; 3]; 3] {
        let [z, x, y] = self.turns.map(f64::sin_cos);
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|[a, b, c]: [f64; 3]| {
            let [a, b] = [z.1 * a - z.0 * b, z.0 * a + z.1 * b];
            let [b, c] = [x.1 * b - x.0 * c, x.0 * b + x.1 * c];
            [y.1 * a + y.0 * c, b, y.1 * c - y.0 * a]
        })
    }

    /// Returns where a point of the tag's plane, m, is in the picture, px.
    pub(super) fn shown(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let axes = self.axes();
        let at = [0, 1, 2].map(|index| self.position[index] + axes[0][index] * x + axes[1][index] * y);
        let camera = camera();
        [0, 1].map(|axis| camera.middle[axis] + camera.focal[axis] * at[axis] / at[2])
    }

    /// Returns its corners in the picture, in the order of a detection.
    pub(super) fn corners(&self) -> [[f64; 2]; 4] {
        let half = SIZE / 2.0;
        [[-half, half], [half, half], [half, -half], [-half, -half]].map(|corner| self.shown(corner))
    }

    /// Returns the brightness of the tag, 0 to 1, in a direction; `None` beside it.
    fn brightness(&self, cells: &[bool], ray: [f64; 3]) -> Option<f64> {
        let [x, y, z] = self.axes();
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let depth = dot(z, self.position) / dot(z, ray);
        let away = [0, 1, 2].map(|index| depth * ray[index] - self.position[index]);
        let width = self.family.width();
        let [column, row] = [x, y].map(|axis| (dot(axis, away) / SIZE + 0.5) * width as f64 + 1.0);
        let side = width + 2;
        let inside = |place: f64| (0.0..side as f64).contains(&place);
        (depth > 0.0 && inside(column) && inside(row))
            .then(|| f64::from(u8::from(cells[row as usize * side + column as usize])))
    }
}

/// The brightness around the tags.
const AROUND: f64 = 120.0;

/// Draws tags, white as 200 and black as 30, plus `light` at each pixel.
pub(super) fn draw(tags: &[Placed], light: impl Fn(usize, usize) -> f64) -> Picture {
    let camera = camera();
    let cells: Vec<Vec<bool>> = tags
        .iter()
        .map(|tag| tag.family.cells(tag.id).expect("the tag exists"))
        .collect();
    let value = |place: [f64; 2]| {
        let [x, y] = [0, 1].map(|axis| (place[axis] - camera.middle[axis]) / camera.focal[axis]);
        let seen = tags
            .iter()
            .zip(&cells)
            .find_map(|(tag, cells)| tag.brightness(cells, [x, y, 1.0]));
        seen.map_or(AROUND, |brightness| 30.0 + 170.0 * brightness)
    };
    // A tag with its margin is within its corners, seen from its middle, half as far again.
    let near = |place: [f64; 2]| {
        tags.iter().any(|tag| {
            let (middle, corners) = (tag.shown([0.0; 2]), tag.corners());
            (0..2).all(|axis| {
                let reach = corners.map(|corner| (corner[axis] - middle[axis]).abs());
                (place[axis] - middle[axis]).abs() <= 1.5 * reach.into_iter().fold(1.0, f64::max)
            })
        })
    };
    let pixel = |index: usize| {
        let place = [index % PICTURE[0], index / PICTURE[0]];
        let [column, row] = place.map(|part| part as f64);
        let parts = (0..16).map(|part| {
            let offset = [part % 4, part / 4].map(|step| (f64::from(step) + 0.5) / 4.0);
            value([column + offset[0], row + offset[1]])
        });
        let mean = if near([column, row]) {
            parts.sum::<f64>() / 16.0
        } else {
            AROUND
        };
        (mean + light(place[0], place[1])) as u8
    };
    Picture((0..PICTURE[0] * PICTURE[1]).map(pixel).collect())
}
