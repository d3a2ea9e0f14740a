//! The robots' paths in the colours of the winners, with takeovers, targets, starts and ends.

use jde_sim::Footprint;

use super::frame::Frame;
use super::palette::Palette;
use super::{DriveMap, PathPoint};
use crate::{Align, ColorRole, Drawing, DrawnShape, LineStyle};

/// Width of the path's line, and of the white on either side that separates it from lines below, pixels.
const PATH_WIDTH: f32 = 3.0;
const OUTLINE_WIDTH: f32 = 2.0;
/// Distance between two arrows on the path, pixels.
const ARROW_DISTANCE: f32 = 170.0;
/// Least distance between an arrow and the mark of a takeover, pixels.
const ARROW_CLEARANCE: f32 = 16.0;
/// Least radius of a robot, also if its body is unknown, pixels.
const LEAST_ROBOT: f32 = 9.0;
/// Pixels from the centre of a target's cross to its ends, the radius of its badge, and the badge's offset in
/// each direction.
const CROSS_ARM: f32 = 5.0;
const BADGE_RADIUS: f32 = 13.0;
const BADGE_OFFSET: f32 = 19.0;
/// Text size of a robot's name, shown if there are several.
const NAME_SIZE: f32 = 16.0;
/// Points closer than this are merged, pixels.
const MERGE_DISTANCE: f32 = 0.5;

/// The end of the path at which a robot is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathEnd {
    Start,
    End,
}

/// The body of a robot in pixels, ahead and to the left of its centre.
pub(super) struct RobotOutline {
    /// Its corners; none for a disc.
    corners: Vec<(f32, f32)>,
    /// The radius of the disc around it.
    radius: f32,
    /// How far it reaches to each side at least.
    inner: f32,
}

impl RobotOutline {
    /// A disc.
    pub(super) fn disc(radius: f32) -> Self {
        Self {
            corners: Vec::new(),
            radius,
            inner: radius,
        }
    }

    /// The body on a map, larger than it is if nobody could see it otherwise.
    fn of(frame: &Frame, body: Option<&Footprint>) -> Self {
        let Some(body) = body else {
            return Self::disc(LEAST_ROBOT);
        };
        let radius = frame.pixels(body.radius()).max(LEAST_ROBOT);
        let scale = f64::from(radius) / body.radius();
        let pixels = |metres: f64| (metres * scale) as f32;
        let [[back, right], [ahead, left]] = body.extent();
        Self {
            corners: body.corners().map(|[x, y]| (pixels(x), pixels(y))).collect(),
            radius,
            inner: pixels(ahead.min(left).min(-back).min(-right)).max(LEAST_ROBOT / 2.0),
        }
    }
}

/// Draws the whole drive.
pub(super) fn draw(drawing: &mut Drawing, frame: &Frame, drive: &DriveMap, palette: &Palette) {
    let paths: Vec<Vec<Run>> = drive.paths.iter().map(|path| runs(frame, &path.points)).collect();
    let runs: Vec<&Run> = paths.iter().flatten().collect();
    for (_, points) in &runs {
        drawing.polyline(
            points,
            LineStyle::new(ColorRole::Paper.faded(0.85), PATH_WIDTH + 2.0 * OUTLINE_WIDTH),
        );
    }
    for (winner, points) in &runs {
        drawing.polyline(points, line(palette, *winner));
    }
    let takeovers: Vec<(f32, f32)> = drive.takeovers.iter().map(|at| frame.at(at.x, at.y)).collect();
    for path in &paths {
        arrows(drawing, path, &takeovers, palette);
    }
    for (at, place) in drive.takeovers.iter().zip(takeovers) {
        takeover(drawing, place, palette.tone(Some(at.to)));
    }
    // The robot covers the cross of a target below it; nothing covers the robot's heading.
    for at in &drive.targets {
        cross(drawing, frame.at(at.x, at.y));
    }
    let mut robots = Vec::new();
    for path in &drive.paths {
        let body = RobotOutline::of(frame, path.body.as_ref());
        let radius = body.radius;
        let ends = path.points.first().zip(path.points.last());
        for (at, which) in ends
            .iter()
            .flat_map(|(first, last)| [(first, PathEnd::Start), (last, PathEnd::End)])
        {
            let place = frame.at(at.x, at.y);
            robot(drawing, place, &body, at.heading, which);
            robots.push((place, radius));
            if drive.paths.len() > 1 && which == PathEnd::End {
                let name_place = (place.0 + radius + NAME_SIZE / 3.0, place.1);
                drawing.label(&path.robot, NAME_SIZE, name_place, Align::Left, ColorRole::Ink);
            }
        }
    }
    for at in &drive.targets {
        let place = badge_place(frame.at(at.x, at.y), &runs, &robots);
        badge(drawing, place, &at.number.to_string(), at.reached);
    }
}

/// The style of the path while a schema won.
pub(super) fn line(palette: &Palette, winner: Option<usize>) -> LineStyle {
    let line = LineStyle::new(palette.tone(winner), PATH_WIDTH);
    if palette.is_dashed(winner) {
        line.dashed(8.0, 5.0)
    } else {
        line
    }
}

/// Draws the mark of a takeover in the colour of the new winner.
pub(super) fn takeover(drawing: &mut Drawing, at: (f32, f32), tone: ColorRole) {
    drawing.disc(at, 5.0, tone);
    drawing.disc(at, 2.8, ColorRole::Paper);
}

/// Draws the number of a target: in a filled disc if it was reached, in a dashed ring if not.
pub(super) fn badge(drawing: &mut Drawing, (x, y): (f32, f32), number: &str, reached: bool) {
    let size = if number.len() > 2 { 12.0 } else { 15.0 };
    drawing.disc((x, y), BADGE_RADIUS + 2.0, ColorRole::Paper);
    if reached {
        drawing.disc((x, y), BADGE_RADIUS, ColorRole::Ink);
        drawing.label(number, size, (x, y), Align::Middle, ColorRole::Paper);
    } else {
        drawing.ring(
            (x, y),
            BADGE_RADIUS - 0.9,
            LineStyle::new(ColorRole::Ink, 1.8).dashed(4.0, 3.0),
        );
        drawing.label(number, size, (x, y), Align::Middle, ColorRole::Ink);
    }
}

/// Draws a robot from above, with a wedge in its heading; the one at the start is faded.
pub(super) fn robot(
    drawing: &mut Drawing,
    (x, y): (f32, f32),
    body: &RobotOutline,
    heading: f64,
    which: PathEnd,
) {
    let (sin, cos) = (heading.sin() as f32, heading.cos() as f32);
    // Pixels count downwards, headings counter-clockwise.
    let place = |(ahead, left): (f32, f32)| (x + cos * ahead - sin * left, y - sin * ahead - cos * left);
    let shape = if body.corners.is_empty() {
        DrawnShape::Disc((x, y), body.radius)
    } else {
        DrawnShape::Area(body.corners.iter().copied().map(place).collect())
    };
    let wedge = [(0.82, 0.0), (-0.457, 0.419), (-0.457, -0.419)]
        .map(|(ahead, left)| place((body.inner * ahead, body.inner * left)));
    let (opacity, line, ink) = match which {
        PathEnd::Start => (
            0.75,
            LineStyle::new(ColorRole::Ink, 1.5).dashed(4.0, 3.0),
            ColorRole::Edge,
        ),
        PathEnd::End => (0.9, LineStyle::new(ColorRole::Ink, 2.0), ColorRole::Ink),
    };
    drawing.fill(shape.clone(), ColorRole::Paper.faded(opacity));
    drawing.stroke(shape, line);
    drawing.polygon(&wedge, ink);
}

fn cross(drawing: &mut Drawing, (x, y): (f32, f32)) {
    for line in [
        LineStyle::new(ColorRole::Paper, 5.0),
        LineStyle::new(ColorRole::Ink, 2.0),
    ] {
        drawing.polyline(
            &[(x - CROSS_ARM, y - CROSS_ARM), (x + CROSS_ARM, y + CROSS_ARM)],
            line,
        );
        drawing.polyline(
            &[(x - CROSS_ARM, y + CROSS_ARM), (x + CROSS_ARM, y - CROSS_ARM)],
            line,
        );
    }
}

/// The diagonal of a target on which its badge hides no robot and the least of the path.
fn badge_place((x, y): (f32, f32), runs: &[&Run], robots: &[((f32, f32), f32)]) -> (f32, f32) {
    let candidates = [(1.0, -1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(right, down)| (x + right * BADGE_OFFSET, y + down * BADGE_OFFSET));
    let hidden_count = |(x, y): (f32, f32)| {
        let within = |distance: f32| move |(to_x, to_y): &&(f32, f32)| (to_x - x).hypot(to_y - y) < distance;
        let covered = runs
            .iter()
            .flat_map(|(_, points)| points)
            .filter(within(BADGE_RADIUS + PATH_WIDTH))
            .count();
        let is_hidden = |&&(place, radius): &&((f32, f32), f32)| within(BADGE_RADIUS + radius)(&&place);
        (robots.iter().filter(is_hidden).count(), covered)
    };
    candidates
        .into_iter()
        .min_by_key(|place| hidden_count(*place))
        .unwrap_or(candidates[0])
}

type Run = (Option<usize>, Vec<(f32, f32)>);

/// Splits the path where the winner changes. Each piece ends where the next begins.
fn runs(frame: &Frame, path: &[PathPoint]) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for at in path {
        let point = frame.at(at.x, at.y);
        match runs.last_mut() {
            Some((winner, points)) => {
                let last = *points.last().unwrap_or(&point);
                let changes = *winner != at.winner;
                if changes || (point.0 - last.0).hypot(point.1 - last.1) >= MERGE_DISTANCE {
                    points.push(point);
                }
                if changes {
                    runs.push((at.winner, vec![point]));
                }
            }
            None => runs.push((at.winner, vec![point])),
        }
    }
    runs
}

/// Draws arrow heads in the direction of the path, evenly spaced and away from the takeovers.
fn arrows(drawing: &mut Drawing, runs: &[Run], takeovers: &[(f32, f32)], palette: &Palette) {
    let mut next = ARROW_DISTANCE / 2.0;
    for (winner, points) in runs {
        for pair in points.windows(2) {
            let ((x, y), (to_x, to_y)) = (pair[0], pair[1]);
            let length = (to_x - x).hypot(to_y - y);
            let (right, down) = ((to_x - x) / length, (to_y - y) / length);
            while next <= length {
                let at = |ahead: f32, sideways: f32| {
                    let forward = next + ahead;
                    (
                        x + right * forward - down * sideways,
                        y + down * forward + right * sideways,
                    )
                };
                let middle = at(0.0, 0.0);
                if takeovers
                    .iter()
                    .any(|(x, y)| (x - middle.0).hypot(y - middle.1) < ARROW_CLEARANCE)
                {
                    next += ARROW_CLEARANCE;
                    continue;
                }
                let head = [at(8.0, 0.0), at(-5.0, 6.0), at(-2.5, 0.0), at(-5.0, -6.0)];
                drawing.polygon(&head, palette.tone(*winner));
                next += ARROW_DISTANCE;
            }
            next -= length;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::RobotPath;

    #[test]
    fn a_robot_is_as_long_and_as_wide_as_its_body_unless_nobody_could_see_it() {
        let corners = [[0.6, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.6, -0.2]];
        let body = Footprint::polygon(&corners).expect("a convex polygon");
        let at = |x: f64| PathPoint {
            time: x,
            x,
            y: 0.0,
            heading: 0.0,
            winner: None,
        };
        let of = |length: f64| {
            let drive = DriveMap {
                paths: vec![RobotPath {
                    points: vec![at(0.0), at(length)],
                    body: Some(body.clone()),
                    ..RobotPath::default()
                }],
                ..DriveMap::default()
            };
            let frame = Frame::within(&drive, &[], false, 800.0, 600.0);
            (RobotOutline::of(&frame, Some(&body)), frame.pixels(1.0))
        };
        let (body, metre) = of(4.0);
        let ahead = body.corners.iter().map(|corner| corner.0).fold(0.0, f32::max);
        let left = body.corners.iter().map(|corner| corner.1).fold(0.0, f32::max);
        assert!((ahead - 0.6 * metre).abs() < 0.01 && (left - 0.2 * metre).abs() < 0.01);
        let (small, metre) = of(4000.0);
        assert!(
            0.6 * metre < 1.0 && (small.radius - LEAST_ROBOT).abs() < 0.01,
            "{}",
            small.radius
        );
        assert_eq!(small.corners.len(), 4);
    }
}
