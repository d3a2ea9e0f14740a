//! A drive as a picture: the world from above, the way coloured by who won, targets, takeovers and a legend.
//!
//! It draws what it is given, in metres and seconds; it refuses to run anything and to read a log or a world.

mod canvas;
mod font;
mod frame;
mod ground;
mod legend;
mod palette;
#[cfg(test)]
mod tests;
mod way;

use std::path::{Path, PathBuf};
use std::{fs, io};

use jde_sim::{Bounds, Outline, Shape};
use tiny_skia::Pixmap;

use canvas::Canvas;
use frame::Frame;
use palette::Palette;

/// All that a picture shows. Places are metres and headings radians of one frame: x to the right, y up.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drive {
    /// What stands over the picture.
    pub(crate) title: String,
    /// What to show at least; `None` shows what the rest takes up.
    pub(crate) bounds: Option<Bounds>,
    /// The world as it was at the start.
    pub(crate) shapes: Vec<Thing>,
    /// Where laser beams ended, for a drive without a world.
    pub(crate) scans: Vec<(f64, f64)>,
    /// Where the robot was and who won, in the order of time.
    pub(crate) path: Vec<Moment>,
    /// Names of the schemas that [`Moment::winner`] and [`Takeover::to`] count.
    pub(crate) schema_names: Vec<String>,
    /// Where it should go, in that order.
    pub(crate) targets: Vec<Target>,
    /// Where the winner changed.
    pub(crate) takeovers: Vec<Takeover>,
    /// The robot's radius; 0 if nobody knows it.
    pub(crate) robot_radius: f64,
}

/// A thing of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Thing {
    /// Where it is and how big.
    pub(crate) outline: Outline,
    /// Whether it moves on its own, so that this is only where it began.
    pub(crate) moving: bool,
}

/// The robot at one time. The winner stays the winner until the next moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moment {
    /// Seconds since the start.
    pub(crate) time: f64,
    /// Metres.
    pub(crate) x: f64,
    /// Metres.
    pub(crate) y: f64,
    /// Radians.
    pub(crate) heading: f64,
    /// Who won, an index into [`Drive::schema_names`].
    pub(crate) winner: Option<usize>,
}

/// A place to go to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Target {
    /// Metres.
    pub(crate) x: f64,
    /// Metres.
    pub(crate) y: f64,
    /// Whether the robot has been there.
    pub(crate) reached: bool,
}

/// A change of winner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Takeover {
    /// Metres.
    pub(crate) x: f64,
    /// Metres.
    pub(crate) y: f64,
    /// Who won since, an index into [`Drive::schema_names`].
    pub(crate) to: usize,
}

/// Why a picture could not be saved.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PictureError {
    /// The file or its folder cannot be written.
    #[error("cannot write the picture `{}`: {error}; name a file in a folder that can be written", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        error: io::Error,
    },
    /// The picture cannot become a PNG.
    #[error("cannot encode the picture `{}` as PNG: {reason}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What the encoder said.
        reason: String,
    },
}

impl From<Shape<'_>> for Thing {
    fn from(shape: Shape<'_>) -> Self {
        Self {
            outline: shape.outline,
            moving: shape.moving,
        }
    }
}

/// Draws a drive, 1600 pixels wide or less for a world that is higher than wide. The same drive gives the same picture.
///
/// What has no finite place is left out.
pub(crate) fn draw(drive: &Drive) -> Pixmap {
    let drive = &finite(drive);
    let palette = Palette::of(drive);
    let entries = legend::entries(drive, &palette);
    let frame = Frame::of(drive, &entries);
    let mut canvas = Canvas::new(frame.width, frame.height);
    ground::draw(&mut canvas, &frame, drive);
    way::draw(&mut canvas, &frame, drive, &palette);
    ground::edge(&mut canvas, &frame);
    legend::draw(&mut canvas, &frame, drive, &palette, &entries);
    canvas.into_pixmap()
}

/// Draws a drive into a PNG file, and makes its folder if there is none.
///
/// Errors: the file cannot be written.
pub(crate) fn save(drive: &Drive, path: &Path) -> Result<(), PictureError> {
    let encoded = draw(drive).encode_png().map_err(|error| PictureError::Encode {
        path: path.to_owned(),
        reason: error.to_string(),
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(path, encoded))
        .map_err(|error| PictureError::Write {
            path: path.to_owned(),
            error,
        })
}

/// Places further out than 1000 km are errors of whoever measured them, and no pixel tells them apart.
const FARTHEST: f64 = 1e6;

/// Leaves out what has no place: a lost pose must not cost the picture of the rest.
fn finite(drive: &Drive) -> Drive {
    let placed = |numbers: &[f64]| numbers.iter().all(|number| number.abs() <= FARTHEST);
    let mut drive = drive.clone();
    drive.bounds = drive.bounds.filter(|bounds| {
        placed(&[bounds.min, bounds.max].concat())
            && bounds.min[0] <= bounds.max[0]
            && bounds.min[1] <= bounds.max[1]
    });
    drive.shapes.retain(|thing| match thing.outline {
        Outline::Segment { from, to } => placed(&[from, to].concat()),
        Outline::Box { center, size, angle } => placed(&[center, size].concat()) && angle.is_finite(),
        Outline::Circle { center, radius } => placed(&center) && placed(&[radius]),
    });
    drive.scans.retain(|(x, y)| placed(&[*x, *y]));
    drive
        .path
        .retain(|at| placed(&[at.x, at.y]) && at.time.is_finite() && at.heading.is_finite());
    drive.targets.retain(|target| placed(&[target.x, target.y]));
    drive
        .takeovers
        .retain(|takeover| placed(&[takeover.x, takeover.y]));
    drive.robot_radius = if placed(&[drive.robot_radius]) {
        drive.robot_radius.max(0.0)
    } else {
        0.0
    };
    drive
}
