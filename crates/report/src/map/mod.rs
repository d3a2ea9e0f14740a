//! A drive from above: the world the way coloured by who won, targets, takeovers and a legend.
//!
//! It draws what it is given, in metres and seconds; it refuses to run anything and to read a log or a world.

mod frame;
mod ground;
mod legend;
mod palette;
#[cfg(test)]
mod tests;
mod way;

use jde_sim::{Bounds, Outline, Shape};

use crate::drawing::Drawing;
use frame::Frame;
pub(crate) use palette::Palette;

/// All that a picture shows. Places are metres and headings radians of one frame: x to the right, y up.
#[derive(Clone, Debug, Default)]
pub struct Drive {
    /// What stands over the picture.
    pub title: String,
    /// What to show at least; `None` shows what the rest takes up.
    pub bounds: Option<Bounds>,
    /// The world as it was at the start.
    pub shapes: Vec<Thing>,
    /// Where laser beams ended, for a drive without a world.
    pub scans: Vec<(f64, f64)>,
    /// Where the robot was and who won, in the order of time.
    pub path: Vec<Moment>,
    /// Names of the schemas that [`Moment::winner`] and [`Takeover::to`] count.
    pub schema_names: Vec<String>,
    /// Where it should go, in that order.
    pub targets: Vec<Target>,
    /// Where the winner changed.
    pub takeovers: Vec<Takeover>,
    /// The robot's radius; 0 if nobody knows it.
    pub robot_radius: f64,
}

/// A thing of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thing {
    /// Where it is and how big.
    pub outline: Outline,
    /// Whether it moves on its own, so that this is only where it began.
    pub moving: bool,
}

/// The robot at one time. The winner stays the winner until the next moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Seconds since the start.
    pub time: f64,
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians.
    pub heading: f64,
    /// Who won, an index into [`Drive::schema_names`].
    pub winner: Option<usize>,
}

/// A place to go to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Whether the robot has been there.
    pub reached: bool,
}

/// A change of winner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Takeover {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Who won since, an index into [`Drive::schema_names`].
    pub to: usize,
}

impl From<Shape<'_>> for Thing {
    fn from(shape: Shape<'_>) -> Self {
        Self {
            outline: shape.outline,
            moving: shape.moving,
        }
    }
}

/// Draws a drive on a map of its own, 1600 units wide or less for a world that is higher than wide; with its title and numbers if
/// there is a `heading`. The same drive gives the same drawing.
///
/// What has no finite place is left out.
pub(crate) fn draw(drive: &Drive, heading: bool) -> Drawing {
    let drive = &finite(drive);
    let entries = legend::entries(drive, &Palette::of(drive));
    let frame = Frame::of(drive, &entries, heading);
    let mut drawing = Drawing::new(frame.width, frame.height);
    onto(&mut drawing, drive, &frame, &entries);
    if heading {
        legend::heading(&mut drawing, &frame, drive);
    }
    drawing
}

/// Draws a drive on a part of a drawing: so wide and high, from the upper left.
pub(crate) fn draw_within(drawing: &mut Drawing, drive: &Drive, width: f32, height: f32) {
    let drive = &finite(drive);
    let entries = legend::entries(drive, &Palette::of(drive));
    let frame = Frame::within(drive, &entries, width, height);
    onto(drawing, drive, &frame, &entries);
    legend::heading(drawing, &frame, drive);
}

fn onto(drawing: &mut Drawing, drive: &Drive, frame: &Frame, entries: &[legend::Entry]) {
    let palette = Palette::of(drive);
    ground::draw(drawing, frame, drive);
    way::draw(drawing, frame, drive, &palette);
    ground::edge(drawing, frame);
    legend::draw(drawing, frame, &palette, entries);
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
