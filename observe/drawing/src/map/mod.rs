//! A drive from above: the world, the path in the colours of the winners, targets, takeovers and a legend.
//!
//! Draws the given data, in metres and seconds. It runs nothing and reads neither a recording nor a world.

mod failures;
mod frame;
mod ground;
mod legend;
mod of_timeline;
mod palette;
mod path;
#[cfg(test)]
mod tests;

use jde_sim::{Bounds, Footprint, Outline, Shape, World};

use crate::Drawing;
pub use failures::{FailurePlace, draw_failures};
use frame::Frame;
use jde_timeline::is_placed;
pub use jde_timeline::{PathPoint, Takeover, Target};
pub use palette::Palette;

/// The content of a map. Places are in metres and headings in radians, in one frame with x to the right and y
/// up.
#[derive(Clone, Debug, Default)]
pub struct DriveMap {
    /// The title.
    pub title: String,
    /// The area to show at least; `None` shows what the other data take up.
    pub bounds: Option<Bounds>,
    /// The world at the start.
    pub shapes: Vec<Obstacle>,
    /// What is painted on the floor of the world, the later over the earlier.
    pub paint: Vec<Paint>,
    /// The ends of laser beams, for a drive without a world.
    pub scans: Vec<(f64, f64)>,
    /// The paths of the robots.
    pub paths: Vec<RobotPath>,
    /// Names of the schemas that [`PathPoint::winner`], [`Takeover::to`] and [`DriveMap::winners`] refer to. Without any,
    /// nothing is said of winners.
    pub schema_names: Vec<String>,
    /// Schemas that won for any time, also while no pose was known. Winners that occur in the paths or the
    /// takeovers may be missing.
    pub winners: Vec<usize>,
    /// The targets, in their order.
    pub targets: Vec<Target>,
    /// The places where the winner changed.
    pub takeovers: Vec<Takeover>,
    /// The number of takeovers; more than [`DriveMap::takeovers`] holds if some were left out.
    pub takeover_count: u64,
}

/// The path of one robot.
#[derive(Clone, Debug, Default)]
pub struct RobotPath {
    /// Its name, which distinguishes it from other robots.
    pub robot: String,
    /// Its body, if it is known.
    pub body: Option<Footprint>,
    /// Poses and winners, in order of time.
    pub points: Vec<PathPoint>,
    /// The driven distance, metres. [`RobotPath::points`] may be shorter, since some may be left out.
    pub distance: f64,
}

/// A thing of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// Its position and size.
    pub outline: Outline,
    /// Whether it moves; then this is only its initial position.
    pub moving: bool,
}

/// A painted part of the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paint {
    /// Its position and size.
    pub outline: Outline,
    /// From 0 for white to 1 for black.
    pub darkness: f32,
}

impl DriveMap {
    /// Draws on a world, as it is at the start.
    pub fn set_world(&mut self, world: &World) {
        self.bounds = Some(world.bounds());
        self.shapes = world.shapes().map(Obstacle::from).collect();
        self.paint = world.paint().map(Paint::from).collect();
    }

    /// Whether the pose of any robot is known.
    #[must_use]
    pub fn has_path(&self) -> bool {
        self.places().next().is_some()
    }

    /// All points of all robots.
    fn places(&self) -> impl Iterator<Item = &PathPoint> {
        self.paths.iter().flat_map(|path| &path.points)
    }

    /// The winners in the paths and the takeovers, with repetitions.
    fn drawn_winners(&self) -> impl Iterator<Item = usize> {
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

impl From<Shape<'_>> for Paint {
    fn from(shape: Shape<'_>) -> Self {
        Self {
            outline: shape.outline,
            darkness: (1.0 - shape.color.luminance()) as f32,
        }
    }
}

/// Draws a drive on a map of its own, 1600 units wide; narrower for a world that is higher than wide. With
/// `heading`, adds its title and numbers. The same drive gives the same drawing.
///
/// Anything without a finite position is left out.
#[must_use]
pub fn draw(drive: &DriveMap, heading: bool) -> Drawing {
    let drive = &finite(drive);
    let entries = legend::entries(drive, &Palette::of(drive));
    let frame = Frame::of(drive, &entries, heading);
    let mut drawing = Drawing::new(frame.width, frame.height);
    draw_on(&mut drawing, drive, &frame, &entries);
    if heading {
        legend::heading(&mut drawing, &frame, drive);
    }
    drawing
}

/// Draws a drive without its title on a map of its own of at most `width` by `height` units, for a part of a
/// page.
#[must_use]
pub fn draw_within_page(drive: &DriveMap, width: f32, height: f32) -> Drawing {
    let drive = &finite(drive);
    let entries = legend::entries(drive, &Palette::of(drive));
    let frame = Frame::within(drive, &entries, false, width, height);
    let mut drawing = Drawing::new(frame.width, frame.height);
    draw_on(&mut drawing, drive, &frame, &entries);
    drawing
}

/// Draws a drive on the upper left part of a drawing.
pub fn draw_within(drawing: &mut Drawing, drive: &DriveMap, width: f32, height: f32) {
    let drive = &finite(drive);
    let entries = legend::entries(drive, &Palette::of(drive));
    let frame = Frame::within(drive, &entries, true, width, height);
    draw_on(drawing, drive, &frame, &entries);
    legend::heading(drawing, &frame, drive);
}

fn draw_on(drawing: &mut Drawing, drive: &DriveMap, frame: &Frame, entries: &[legend::LegendEntry]) {
    let palette = Palette::of(drive);
    ground::draw(drawing, frame, drive);
    path::draw(drawing, frame, drive, &palette);
    ground::edge(drawing, frame);
    legend::draw(drawing, frame, &palette, entries);
}

/// Removes everything without a valid position, since a lost pose must not prevent drawing the rest.
fn finite(drive: &DriveMap) -> DriveMap {
    let mut drive = drive.clone();
    drive.bounds = drive.bounds.filter(|bounds| {
        is_placed(&[bounds.min, bounds.max].concat())
            && bounds.min[0] <= bounds.max[0]
            && bounds.min[1] <= bounds.max[1]
    });
    let is_valid = |outline: &Outline| match *outline {
        Outline::Segment { from, to } => is_placed(&[from, to].concat()),
        Outline::Box { center, size, angle } => is_placed(&[center, size].concat()) && angle.is_finite(),
        Outline::Circle { center, radius } => is_placed(&center) && is_placed(&[radius]),
    };
    drive.shapes.retain(|thing| is_valid(&thing.outline));
    drive.paint.retain(|paint| is_valid(&paint.outline));
    drive.scans.retain(|(x, y)| is_placed(&[*x, *y]));
    for path in &mut drive.paths {
        path.points
            .retain(|at| is_placed(&[at.x, at.y]) && at.time.is_finite() && at.heading.is_finite());
    }
    drive.targets.retain(|target| is_placed(&[target.x, target.y]));
    drive
        .takeovers
        .retain(|takeover| is_placed(&[takeover.x, takeover.y]));
    drive
}
