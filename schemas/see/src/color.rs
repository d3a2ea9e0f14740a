//! The perceptive schema that finds areas of colour. Its panel calibrates the colours.

use core::cmp::Reverse;

use jde_schema::prelude::*;
use jde_schema::types::{ColorBlob, ColorBlobs};
use jde_vision::{
    Blobs, CameraGeometry, CameraModel, CameraMount, CameraPorts, ColorRange, Component, Observation, Pixels,
};

use crate::colors::{ColorLimits, Colors};

/// Finds the connected areas of some colours in the pictures of a camera, and their places on the floor.
///
/// The place of an area is where its lowest row meets the floor: it is right for a thing on the floor, and too far
/// for a thing above it. An area that reaches the lower edge of the picture has no place. A picture of 640 x 480
/// pixels with one colour takes about 3 ms. The panel shows the live picture: a click on it sets the range of the
/// chosen colour, and the panel shows the line for the application file.
#[derive(Describe)]
#[schema(perceptive, period = "33ms", budget = "33ms")]
pub struct Color {
    /// The pictures, encoded as "rgb8" or "bgr8".
    #[import]
    pub(crate) image: Import<Image>,
    #[ports]
    camera: CameraPorts,
    /// The measured position of the head that carries the camera. If it is not bound, the camera looks
    /// straight ahead.
    #[import(optional)]
    pan_tilt: Import<PanTilt>,
    /// The colours to find, each with limits of hue, saturation and value; orange if there is none.
    #[modulation(default = Colors { ranges: Seq::new() })]
    colors: Modulation<Colors>,
    /// Fewest pixels of an area.
    #[modulation(default = 20, unit = "px", min = 1)]
    pixels: Modulation<u32>,
    /// Height of the camera above the floor; 0 if it is unknown.
    #[modulation(default = 0.0, unit = "m", min = 0.0)]
    height: Modulation<f64>,
    /// How far the camera is ahead of the base.
    #[modulation(default = 0.0, unit = "m")]
    ahead: Modulation<f64>,
    /// How far the camera is to the left of the base.
    #[modulation(default = 0.0, unit = "m")]
    left: Modulation<f64>,
    /// How far the camera looks down while its head looks straight ahead.
    #[modulation(default = 0.0, unit = "rad")]
    tilt: Modulation<f64>,
    /// The areas, the largest first. Retracted while there are no pictures, or while the position of the head or
    /// a bound `camera_info` is unknown.
    #[export(validity = "1s")]
    blobs: Export<ColorBlobs>,
    /// Sequence number of the last picture; `None` while nothing is exported.
    last: Option<u64>,
    finder: Blobs,
    geometry: CameraGeometry,
    pub(crate) tuning: Tuning,
}

/// The state of the panel.
#[derive(Debug, Default)]
pub(crate) struct Tuning {
    /// The colours in place of those of the modulation.
    pub(crate) colors: Option<Colors>,
    /// The number of the colour that clicks set.
    pub(crate) chosen: usize,
    /// Whether a click adds to the samples before it.
    pub(crate) extends: bool,
    /// The pixels that the range of the chosen colour was made from.
    pub(crate) samples: Vec<[u8; 3]>,
}

/// Most areas that are published.
const MAX_BLOBS: usize = Seq::<ColorBlob, 32>::CAPACITY;

/// An area that was found.
struct FoundArea {
    color: usize,
    component: Component,
    observation: Observation,
}

impl Schema for Color {
    fn awake(&mut self, cx: &Context) -> Result {
        self.geometry = self.camera.geometry(cx)?;
        // What was seen before a sleep is out of date.
        self.last = None;
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let image = self.image.get(cx).filter(|_| !self.camera.is_unknown(cx));
        let (Some(image), Some(mount)) = (image, self.mount(cx)) else {
            if self.last.take().is_some() {
                self.blobs.retract(cx);
            }
            return Ok(());
        };
        if self.last.replace(image.sequence()) == Some(image.sequence()) {
            return Ok(());
        }
        let pixels = Pixels::of(&image).map_err(|error| format!("import `image`: {error}"))?;
        let camera = self.camera.model(cx, &self.geometry, pixels.size())?;
        let found = self.find(cx, &pixels, &camera);
        let blobs = ColorBlobs {
            header: Header::new(image.time(), "base_link"),
            left_out: found.len().saturating_sub(MAX_BLOBS) as u32,
            blobs: found
                .iter()
                .map(|found| found.blob(&camera, &mount, pixels.size()[1]))
                .collect(),
            ..ColorBlobs::default()
        };
        self.blobs.write_at(cx, blobs, image.time());
        Ok(())
    }
}

impl Inspect for Color {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        self.camera.inspect(cx, problems);
    }
}

impl Color {
    /// Returns the calibrated colours, else those of the modulation: one at least.
    pub(crate) fn current_colors(&self, cx: &Context) -> Colors {
        let colors = self.tuning.colors.unwrap_or_else(|| self.colors.get(cx));
        if colors.ranges.is_empty() {
            Colors::orange()
        } else {
            colors
        }
    }

    /// Returns where the camera is; `None` while a bound head has no value.
    fn mount(&self, cx: &Context) -> Option<CameraMount> {
        let [pan, tilt] = if self.pan_tilt.is_bound(cx) {
            self.pan_tilt.get(cx).map(|head| [head.pan, head.tilt])?
        } else {
            [0.0; 2]
        };
        Some(CameraMount {
            position: [self.ahead.get(cx), self.left.get(cx), self.height.get(cx)],
            pan,
            tilt: tilt + self.tilt.get(cx),
        })
    }

    /// Returns the areas of all colours, the largest first. Those that are not published are not measured.
    fn find(&mut self, cx: &Context, pixels: &Pixels<'_>, camera: &CameraModel) -> Vec<FoundArea> {
        let least = self.pixels.get(cx) as usize;
        let ranges: Vec<ColorRange> = self
            .current_colors(cx)
            .ranges
            .iter()
            .map(ColorLimits::range)
            .collect();
        let mut found = Vec::new();
        for (color, range) in ranges.iter().enumerate() {
            self.finder.find(pixels.size(), |row, column| {
                range.contains(pixels.at(row, column))
            });
            let components = self.finder.components();
            let mut large: Vec<_> = components
                .filter(|(_, component)| component.count >= least)
                .collect();
            large.sort_by_key(|(_, component)| Reverse(component.count));
            found.extend(
                large
                    .into_iter()
                    .enumerate()
                    .map(|(place, (number, component))| FoundArea {
                        color,
                        component: *component,
                        observation: if place < MAX_BLOBS {
                            camera.observe(self.finder.runs(number))
                        } else {
                            Observation::default()
                        },
                    }),
            );
        }
        // A stable sort: equal areas keep the order of their colours.
        found.sort_by_key(|found| Reverse(found.component.count));
        found
    }
}

impl FoundArea {
    fn blob(&self, camera: &CameraModel, mount: &CameraMount, height: usize) -> ColorBlob {
        let Component { count, columns, rows } = self.component;
        let [bearing, elevation] = self.observation.angles(mount.pan, mount.tilt);
        let [column, row] = camera.pixel(self.observation.direction).unwrap_or_default();
        // What continues below the picture stands nearer than its lowest row shows.
        let foot = (rows[1] < height)
            .then(|| mount.floor(camera.ray([column, rows[1] as f64])?))
            .flatten();
        let [x, y] = foot.unwrap_or_default();
        ColorBlob {
            color: self.color as u32,
            count: count as u32,
            left: columns[0] as u16,
            top: rows[0] as u16,
            width: (columns[1] - columns[0]) as u16,
            height: (rows[1] - rows[0]) as u16,
            column: column as f32,
            row: row as f32,
            bearing,
            elevation,
            x,
            y,
            on_floor: foot.is_some().into(),
            padding: Padding::ZERO,
        }
    }
}
