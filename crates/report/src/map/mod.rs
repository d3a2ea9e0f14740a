//! A drive from above: the world the way coloured by who won, targets, takeovers and a legend.
//!
//! It draws what it is given, in metres and seconds; it refuses to run anything and to read a log or a world.

mod frame;
mod ground;
mod legend;
mod palette;
mod path;
#[cfg(test)]
mod tests;

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
    pub shapes: Vec<Obstacle>,
    /// Where laser beams ended, for a drive without a world.
    pub scans: Vec<(f64, f64)>,
    /// Where its robots went.
    pub paths: Vec<RobotPath>,
    /// Names of the schemas that [`Moment::winner`], [`Takeover::to`] and [`Drive::winners`] count.
    pub schema_names: Vec<String>,
    /// Who won for any time, if only where nobody knows where the robot was; the others of the path and of the takeovers may be
    /// missing.
    pub winners: Vec<usize>,
    /// Where it should go, in that order.
    pub targets: Vec<Target>,
    /// Where the winner changed.
    pub takeovers: Vec<Takeover>,
    /// How often it changed: at least as often as there are [`Drive::takeovers`], of which some may be left out.
    pub takeover_count: u64,
    /// The robot's radius; 0 if nobody knows it.
    pub robot_radius: f64,
}

/// Where one robot went.
#[derive(Clone, Debug, Default)]
pub struct RobotPath {
    /// Its name, to tell it from others.
    pub robot: String,
    /// Where it was and who won, in the order of time.
    pub points: Vec<PathPoint>,
    /// How far it drove, metres: at least as far as along [`Way::path`], of which some may be left out.
    pub distance: f64,
}

/// A thing of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// Where it is and how big.
    pub outline: Outline,
    /// Whether it moves on its own, so that this is only where it began.
    pub moving: bool,
}

/// The robot at one time. The winner stays the winner until the next moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
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
    /// Which of all targets it is, from 1.
    pub number: usize,
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

impl Drive {
    /// Whether it is known where any robot was.
    #[must_use]
    pub fn has_way(&self) -> bool {
        self.places().next().is_some()
    }

    /// Gives all places of all robots.
    fn places(&self) -> impl Iterator<Item = &PathPoint> {
        self.paths.iter().flat_map(|way| &way.points)
    }

    /// Gives those who won where the robot is known to have been, each as often as that is known.
    fn seen(&self) -> impl Iterator<Item = usize> {
        let path = self.places().filter_map(|at| at.winner);
        path.chain(self.takeovers.iter().map(|takeover| takeover.to))
    }
}

impl From<Shape<'_>> for Obstacle {
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
    path::draw(drawing, frame, drive, &palette);
    ground::edge(drawing, frame);
    legend::draw(drawing, frame, &palette, entries);
}

/// Places further out than 1000 km are errors of whoever measured them, and no pixel tells them apart.
const FARTHEST: f64 = 1e6;

/// Whether these can be coordinates of a place.
pub(crate) fn is_placed(numbers: &[f64]) -> bool {
    numbers.iter().all(|number| number.abs() <= FARTHEST)
}

/// Leaves out what has no place: a lost pose must not cost the picture of the rest.
fn finite(drive: &Drive) -> Drive {
    let mut drive = drive.clone();
    drive.bounds = drive.bounds.filter(|bounds| {
        is_placed(&[bounds.min, bounds.max].concat())
            && bounds.min[0] <= bounds.max[0]
            && bounds.min[1] <= bounds.max[1]
    });
    drive.shapes.retain(|thing| match thing.outline {
        Outline::Segment { from, to } => is_placed(&[from, to].concat()),
        Outline::Box { center, size, angle } => is_placed(&[center, size].concat()) && angle.is_finite(),
        Outline::Circle { center, radius } => is_placed(&center) && is_placed(&[radius]),
    });
    drive.scans.retain(|(x, y)| is_placed(&[*x, *y]));
    for way in &mut drive.paths {
        way.points
            .retain(|at| is_placed(&[at.x, at.y]) && at.time.is_finite() && at.heading.is_finite());
    }
    drive.targets.retain(|target| is_placed(&[target.x, target.y]));
    drive
        .takeovers
        .retain(|takeover| is_placed(&[takeover.x, takeover.y]));
    drive.robot_radius = if is_placed(&[drive.robot_radius]) {
        drive.robot_radius.max(0.0)
    } else {
        0.0
    };
    drive
}
