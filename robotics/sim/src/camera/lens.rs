//! The lens of a camera: the place of its axis, and the distortion of Brown's model, which OpenCV and ROS call plumb bob.
//!
//! A picture through a lens is taken from that of a pinhole, which is larger where the lens sees more.

use super::CameraConfig;

/// The lens of a camera. By default there is none: the axis is in the middle, and straight lines are straight.
///
/// The radial and tangential distortion of a point (x, y) at depth 1 (Brown, "Decentering distortion of lenses", 1966), with
/// r² = x² + y²: x · (1 + k1·r² + k2·r⁴ + k3·r⁶) + 2·p1·x·y + p2·(r² + 2·x²), and the same of y with p1 and p2 exchanged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lens {
    /// The place of the optical axis, to the right of the middle of the picture and below it, in pixels.
    pub principal: [f64; 2],
    /// k1, k2, p1, p2 and k3.
    pub distortion: [f64; 5],
}

/// The most steps of the inversion of a distortion. A lens that needs more folds its picture.
const STEPS: usize = 50;
/// When the inversion is accurate enough: far less than a pixel, at depth 1.
const ACCURACY: f64 = 1e-6;
/// How many times as wide or high as the picture that of the pinhole may be.
const MOST: f64 = 3.0;

impl Lens {
    pub(super) fn distorts(&self) -> bool {
        self.distortion != [0.0; 5]
    }

    /// Returns the factor and the shift of a point.
    fn distortion_at(&self, [x, y]: [f64; 2]) -> (f64, [f64; 2]) {
        let [k1, k2, p1, p2, k3] = self.distortion;
        let square = x * x + y * y;
        let radial = 1.0 + square * (k1 + square * (k2 + square * k3));
        let tangential = [
            2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
            p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
        ];
        (radial, tangential)
    }

    /// Returns the point that the lens shows at another one, by a fixed-point iteration from a guess.
    fn undistorted(&self, shown: [f64; 2], mut point: [f64; 2]) -> Option<[f64; 2]> {
        for _ in 0..STEPS {
            let (radial, shift) = self.distortion_at(point);
            if radial <= 0.0 {
                return None;
            }
            let next = [0, 1].map(|axis| (shown[axis] - shift[axis]) / radial);
            let change = (next[0] - point[0]).abs().max((next[1] - point[1]).abs());
            point = next;
            if change < ACCURACY {
                return Some(point);
            }
        }
        None
    }
}

/// The picture of a pinhole that has all that a lens shows.
pub(crate) struct Warp<'a> {
    config: &'a CameraConfig,
    /// Columns and rows.
    pub(super) size: [usize; 2],
    /// The place of the optical axis in it, in pixels.
    pub(super) center: [f64; 2],
}

impl<'a> Warp<'a> {
    /// Returns the picture that a lens needs; `None` if the lens folds its picture, or shows far more than a pinhole would.
    pub(super) fn new(config: &'a CameraConfig) -> Option<Self> {
        let (right, bottom) = (config.width - 1, config.height - 1);
        let rows = (0..=bottom).flat_map(|row| [[0, row], [right, row]]);
        let columns = (0..=right).flat_map(|column| [[column, 0], [column, bottom]]);
        let (mut low, mut high) = ([0.0f64; 2], [0.0f64; 2]);
        for pixel in rows.chain(columns) {
            let shown = config.at_depth_one(pixel);
            let point = config.lens.undistorted(shown, shown)?;
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let focal = config.focal_length();
        let (mut size, mut center) = ([0; 2], [0.0; 2]);
        for (axis, pixels) in [config.width, config.height].into_iter().enumerate() {
            // A pixel more on each side, for the neighbours of the outermost ones.
            let length = libm::ceil((high[axis] - low[axis]) * focal) + 2.0;
            if length > MOST * pixels as f64 + 2.0 {
                return None;
            }
            size[axis] = length as usize;
            center[axis] = 1.0 - low[axis] * focal;
        }
        Some(Self { config, size, center })
    }

    /// Returns the bytes of the pinhole's picture.
    pub(crate) fn bytes(&self) -> usize {
        3 * self.size[0] * self.size[1]
    }

    /// Fills the picture of the lens from that of the pinhole, and returns the inverses of its depths. Colours are
    /// interpolated between four pixels, depths are those of the nearest one.
    pub(crate) fn apply(&self, pinhole: &[u8], near: &[f32], picture: &mut [u8]) -> Vec<f32> {
        let (width, focal) = (self.config.width, self.config.focal_length());
        let (pixels, _) = picture.as_chunks_mut::<3>();
        let mut depths = Vec::with_capacity(pixels.len());
        let mut offset = [0.0; 2];
        for (index, pixel) in pixels.iter_mut().enumerate() {
            let shown = self.config.at_depth_one([index % width, index / width]);
            // A neighbour is distorted almost the same.
            let guess = [shown[0] + offset[0], shown[1] + offset[1]];
            let point = self.config.lens.undistorted(shown, guess).unwrap_or(shown);
            offset = [point[0] - shown[0], point[1] - shown[1]];
            let place = [0, 1].map(|axis| {
                let last = (self.size[axis] - 1) as f64;
                (self.center[axis] + focal * point[axis] - 0.5).clamp(0.0, last)
            });
            *pixel = self.color(pinhole, place);
            let [column, row] = place.map(|place| libm::rint(place) as usize);
            depths.push(near[row * self.size[0] + column]);
        }
        depths
    }

    fn color(&self, pinhole: &[u8], [u, v]: [f64; 2]) -> [u8; 3] {
        let (left, top) = (u as usize, v as usize);
        let (right, bottom) = ((left + 1).min(self.size[0] - 1), (top + 1).min(self.size[1] - 1));
        let (across, down) = (u - left as f64, v - top as f64);
        let at = |column: usize, row: usize, part: usize| {
            f64::from(pinhole[3 * (row * self.size[0] + column) + part])
        };
        [0, 1, 2].map(|part| {
            let upper = at(left, top, part) * (1.0 - across) + at(right, top, part) * across;
            let lower = at(left, bottom, part) * (1.0 - across) + at(right, bottom, part) * across;
            (upper * (1.0 - down) + lower * down + 0.5) as u8
        })
    }
}

impl CameraConfig {
    /// Returns where the middle of a pixel is at depth 1.
    fn at_depth_one(&self, pixel: [usize; 2]) -> [f64; 2] {
        let (center, focal) = (self.center(), self.focal_length());
        [0, 1].map(|axis| (pixel[axis] as f64 + 0.5 - center[axis]) / focal)
    }
}
