//! AprilTags in the pictures of a camera. The schema knows neither where the camera is on the robot nor where the tags
//! are in the world.

mod panel;

use jde_schema::prelude::*;
use jde_schema::types::{Point, Pose, Quaternion, TagDetection, TagDetections};
use jde_tags::{Detection, Detector, Gray, Pinhole};
use jde_vision::{CameraGeometry, CameraModel, CameraPorts, Pixels};

/// The families of tags.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
#[repr(u8)]
enum Family {
    /// 587 tags of 6 × 6 bits.
    Tag36h11,
    /// 35 tags of 5 × 5 bits.
    Tag25h9,
    /// 30 tags of 4 × 4 bits.
    Tag16h5,
}

/// Finds AprilTags in the pictures of a camera, and their poses in the frame of the camera.
///
/// A tag is found if its black border is in the picture, with some of the
/// white margin on each side, and a cell has about two pixels. A picture of 640 x 480 pixels takes about 10 ms, one
/// full of small edges several times as long. The panel shows the live picture with the tags.
#[derive(Describe)]
#[schema(perceptive, period = "33ms", budget = "33ms")]
pub struct Tags {
    /// The pictures, encoded as "rgb8", "bgr8" or "mono8".
    #[import]
    image: Import<Image>,
    #[ports]
    camera: CameraPorts,
    /// The family of the tags: `tag36h11`, `tag25h9` or `tag16h5`.
    #[modulation(default = Family::Tag36h11)]
    family: Modulation<Family>,
    /// Side of a tag, from one outer edge of its black border to the other.
    #[modulation(default = 0.16, unit = "m", min = 0.001, max = 100.0)]
    size: Modulation<f64>,
    /// Most bits of a tag that may be read wrongly. A larger number finds more tags, and more false ones.
    #[modulation(default = 1, max = 3)]
    hamming: Modulation<u32>,
    /// Least difference between the black and white cells of a tag, as the margin of a detection.
    #[modulation(default = 20.0, min = 0.0)]
    margin: Modulation<f64>,
    /// Distance between the columns and rows that are searched, in pixels. 2 takes a quarter of the time of 1, and
    /// misses small tags.
    #[modulation(default = 1, min = 1, max = 8)]
    step: Modulation<u32>,
    /// The tags. Retracted while there are no pictures or a bound `camera_info` has no value, and while it sleeps.
    #[export(validity = "1s")]
    tags: Export<TagDetections>,
    /// Sequence number of the last picture; `None` while nothing is exported.
    last: Option<u64>,
    /// The tags in the last picture.
    found: Vec<TagDetection>,
    detector: Detector,
    geometry: CameraGeometry,
    /// The brightness of the picture.
    pixels: Vec<u8>,
}

/// Most tags that are published.
const MAX_TAGS: usize = Seq::<TagDetection, 32>::CAPACITY;

impl Schema for Tags {
    fn awake(&mut self, cx: &Context) -> Result {
        self.geometry = self.camera.geometry(cx)?;
        // What was seen before a sleep is out of date.
        self.last = None;
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.tags.retract(cx);
        self.found.clear();
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(image) = self.image.get(cx).filter(|_| !self.camera.is_unknown(cx)) else {
            if self.last.take().is_some() {
                self.tags.retract(cx);
                self.found.clear();
            }
            return Ok(());
        };
        if self.last.replace(image.sequence()) == Some(image.sequence()) {
            return Ok(());
        }
        let size = self
            .read(&image)
            .map_err(|error| format!("import `image`: {error}"))?;
        self.detector.families = vec![self.family.get(cx).into()];
        self.detector.hamming = self.hamming.get(cx);
        self.detector.step = self.step.get(cx) as usize;
        let picture = Gray::new(size, &self.pixels).expect("a byte was read for each pixel");
        let (margin, side) = (self.margin.get(cx), self.size.get(cx));
        let camera = self.camera.model(cx, &self.geometry, size)?;
        let clear = self
            .detector
            .detect(&picture)
            .into_iter()
            .filter(|tag| tag.margin >= margin);
        self.found.clear();
        self.found
            .extend(clear.filter_map(|tag| placed(&tag, &camera, side)));
        let tags = TagDetections {
            header: image.header,
            left_out: self.found.len().saturating_sub(MAX_TAGS) as u32,
            tags: self.found.iter().take(MAX_TAGS).copied().collect(),
            ..TagDetections::default()
        };
        self.tags.write_at(cx, tags, image.time());
        Ok(())
    }
}

impl Inspect for Tags {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.camera.inspect(cx, problems);
    }
}

impl Tags {
    /// Reads the brightness of an image, and returns its columns and rows.
    fn read(&mut self, image: &Image) -> Result<[usize; 2], String> {
        let [width, height, step] = [image.width, image.height, image.step].map(|number| number as usize);
        self.pixels.clear();
        if image.encoding.as_str() == "mono8" {
            let bytes = image.data.as_slice();
            if step < width || step.checked_mul(height).is_none_or(|needed| bytes.len() < needed) {
                return Err(format!(
                    "the image states {width} x {height} pixels in rows of {step} bytes and has {} bytes",
                    bytes.len()
                ));
            }
            let rows = bytes.chunks(step.max(1)).take(height);
            self.pixels.extend(rows.flat_map(|row| &row[..width]));
            return Ok([width, height]);
        }
        let pixels = Pixels::of(image).map_err(|error| error.to_string())?;
        for row in 0..height {
            // The luma of BT.601, in parts of 256.
            let luma = |[r, g, b]: [u8; 3]| 77 * u32::from(r) + 150 * u32::from(g) + 29 * u32::from(b);
            self.pixels
                .extend((0..width).map(|column| (luma(pixels.at(row, column)) >> 8) as u8));
        }
        Ok([width, height])
    }
}

/// Returns a tag of a side in m with its pose; `None` if no pose has such corners.
fn placed(tag: &Detection, camera: &CameraModel, side: f64) -> Option<TagDetection> {
    let pinhole = Pinhole {
        focal: camera.focal(),
        middle: camera.middle(),
    };
    let mut seen = tag.corners;
    for corner in &mut seen {
        *corner = camera.undistorted(*corner)?;
    }
    let pose = pinhole.pose(&seen, side)?;
    let [x, y, z] = pose.position;
    let mut corners = [0.0; 8];
    corners.copy_from_slice(tag.corners.as_flattened());
    Some(TagDetection {
        family: Text::new(tag.family.name()),
        id: tag.id,
        hamming: tag.hamming,
        margin: tag.margin,
        corners,
        pose: Pose {
            position: Point { x, y, z },
            orientation: Quaternion::from_axes(pose.axes),
        },
        error: pose.error,
        ambiguity: pose.ambiguity,
    })
}

impl From<Family> for jde_tags::Family {
    fn from(family: Family) -> Self {
        match family {
            Family::Tag36h11 => Self::Tag36h11,
            Family::Tag25h9 => Self::Tag25h9,
            Family::Tag16h5 => Self::Tag16h5,
        }
    }
}

jde_schema::export!("tags", "Finds AprilTags in pictures, and where they are.", [Tags]);

#[cfg(test)]
mod tests;
