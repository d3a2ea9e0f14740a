//! The environment of the robot: the grid, walls, furniture and laser points.

use jde_sim::Outline;

use super::frame::{Frame, box_corners};
use super::{DriveMap, Obstacle};
use crate::{Align, ColorRole, Drawing, DrawnShape, LineStyle};

/// Drawn thickness of a wall of the world, which has none, metres.
const WALL_THICKNESS: f64 = 0.08;
/// A box no thicker than this is a wall, metres.
const MAX_WALL_THICKNESS: f64 = 0.2;
/// Side of a laser point, pixels.
const POINT_SIDE: usize = 2;
/// A point gets a shade darker when its number of beams doubles, up to this number of shades.
const POINT_SHADES: u32 = 5;
/// The part of its darkness that paint keeps, so that paths and walls stand out from it.
const PAINT_DARKNESS: f32 = 0.5;
/// Text size of the labels, pixels.
const LABEL_SIZE: f32 = 16.0;
/// Largest length of the scale bar: share of the map's width, and pixels.
const SCALE_BAR: (f64, f64) = (0.5, 200.0);

/// Draws the paint and the grid, and the laser points and obstacles on them.
pub(super) fn draw(drawing: &mut Drawing, frame: &Frame, drive: &DriveMap) {
    drawing.clip(Some(frame.map));
    for paint in &drive.paint {
        if let Some(area) = area(frame, &paint.outline) {
            // What the paint covers is not seen through it.
            drawing.fill(area.clone(), ColorRole::Paper);
            drawing.fill(area, ColorRole::Ink.faded(PAINT_DARKNESS * paint.darkness));
        }
    }
    grid(drawing, frame);
    scans(drawing, frame, &drive.scans);
    let (moving, still): (Vec<Obstacle>, Vec<Obstacle>) =
        drive.shapes.iter().partition(|obstacle| obstacle.moving);
    let (walls, furniture): (Vec<Obstacle>, Vec<Obstacle>) = still.into_iter().partition(is_wall);

    // All edges, then all areas, so that touching things merge, such as the blocks of an occupancy map.
    let areas: Vec<DrawnShape> = furniture
        .iter()
        .filter_map(|obstacle| area(frame, &obstacle.outline))
        .collect();
    areas
        .iter()
        .for_each(|area| drawing.stroke(area.clone(), LineStyle::new(ColorRole::Edge, 2.5)));
    areas
        .into_iter()
        .for_each(|area| drawing.fill(area, ColorRole::Furniture));
    moving
        .iter()
        .filter_map(|obstacle| area(frame, &obstacle.outline))
        .for_each(|area| draw_moving(drawing, area));
    for wall in walls {
        match wall.outline {
            Outline::Segment { from, to } => {
                let line = LineStyle::new(ColorRole::Ink, frame.pixels(WALL_THICKNESS).clamp(2.0, 7.0));
                drawing.polyline(&[frame.at(from[0], from[1]), frame.at(to[0], to[1])], line);
            }
            Outline::Box { .. } | Outline::Circle { .. } => {
                if let Some(area) = area(frame, &wall.outline) {
                    drawing.fill(area.clone(), ColorRole::Ink);
                    // A wall thinner than a pixel must be visible.
                    drawing.stroke(area, LineStyle::new(ColorRole::Ink, 1.0));
                }
            }
        }
    }
    drawing.clip(None);
}

/// Draws the edge of the map, the labels of the grid and the scale bar.
pub(super) fn edge(drawing: &mut Drawing, frame: &Frame) {
    let map = frame.map;
    drawing.stroke(DrawnShape::Box(map), LineStyle::new(ColorRole::Edge, 1.0));
    for (x, text) in labels(frame, 0) {
        let position = (frame.at(x, 0.0).0, map.bottom() + 18.0);
        drawing.label(&text, LABEL_SIZE, position, Align::Middle, ColorRole::Soft);
    }
    for (y, text) in labels(frame, 1) {
        let position = (map.left() - 10.0, frame.at(0.0, y).1);
        drawing.label(&text, LABEL_SIZE, position, Align::Right, ColorRole::Soft);
    }
    scale_bar(drawing, frame);
}

/// Draws a disc in the style of moving things.
pub(super) fn moving_disc(drawing: &mut Drawing, (x, y): (f32, f32), radius: f32) {
    draw_moving(drawing, DrawnShape::Disc((x, y), radius));
}

fn grid(drawing: &mut Drawing, frame: &Frame) {
    let map = frame.map;
    let line = LineStyle::new(ColorRole::Grid, 1.0);
    for x in frame.grid_lines(0) {
        let position = crisp(frame.at(x, 0.0).0);
        drawing.polyline(&[(position, map.top()), (position, map.bottom())], line);
    }
    for y in frame.grid_lines(1) {
        let position = crisp(frame.at(0.0, y).1);
        drawing.polyline(&[(map.left(), position), (map.right(), position)], line);
    }
}

/// The numbers on an axis, the last of them with its unit.
fn labels(frame: &Frame, axis: usize) -> Vec<(f64, String)> {
    let mut labels: Vec<_> = frame
        .grid_lines(axis)
        .map(|position| (position, metres(position, frame.grid)))
        .collect();
    if let Some((_, last)) = labels.last_mut() {
        last.push_str(" m");
    }
    labels
}

/// Draws the ends of the beams. More beams are darker, which distinguishes static things from passing ones.
fn scans(drawing: &mut Drawing, frame: &Frame, points: &[(f64, f64)]) {
    let columns = frame.map.width() as usize / POINT_SIDE + 1;
    let rows = frame.map.height() as usize / POINT_SIDE + 1;
    let mut hits = vec![0u32; columns * rows];
    for &(x, y) in points {
        let (x, y) = frame.at(x, y);
        let (right, down) = (x - frame.map.left(), y - frame.map.top());
        let (column, row) = (right as usize / POINT_SIDE, down as usize / POINT_SIDE);
        if right >= 0.0 && down >= 0.0 && column < columns && row < rows {
            hits[row * columns + column] += 1;
        }
    }
    // From light to dark, so that points of one shade are drawn together.
    for shade in 0..=POINT_SHADES {
        let ink = ColorRole::Ink.faded(0.45 + 0.1 * shade as f32);
        let has_shade = |hits: u32| hits > 0 && hits.ilog2().min(POINT_SHADES) == shade;
        for (place, _) in hits.iter().enumerate().filter(|(_, hits)| has_shade(**hits)) {
            let left = frame.map.left() + (place % columns * POINT_SIDE) as f32;
            let top = frame.map.top() + (place / columns * POINT_SIDE) as f32;
            drawing.bar((left, top), POINT_SIDE as f32, POINT_SIDE as f32, ink);
        }
    }
}

fn scale_bar(drawing: &mut Drawing, frame: &Frame) {
    let longest = (f64::from(frame.map.width()) * SCALE_BAR.0).min(SCALE_BAR.1) / frame.scale;
    let power = 10f64.powf(longest.log10().floor());
    let length = [5.0, 2.0, 1.0]
        .map(|digit| digit * power)
        .into_iter()
        .find(|length| *length <= longest);
    let length = length.unwrap_or(power);
    let (left, y) = (frame.map.left(), frame.map.bottom() + 48.0);
    let right = left + frame.pixels(length);
    let line = LineStyle::new(ColorRole::Ink, 2.0);
    drawing.polyline(&[(left, y), (right, y)], line);
    for end in [left, right] {
        drawing.polyline(&[(end, y - 5.0), (end, y + 5.0)], line);
    }
    drawing.label(
        &format!("{} m", metres(length, length)),
        LABEL_SIZE,
        (right + 10.0, y),
        Align::Left,
        ColorRole::Ink,
    );
}

fn draw_moving(drawing: &mut Drawing, area: DrawnShape) {
    drawing.fill(area.clone(), ColorRole::Furniture.faded(0.45));
    drawing.stroke(area, LineStyle::new(ColorRole::Edge, 1.5).dashed(4.0, 4.0));
}

fn is_wall(obstacle: &Obstacle) -> bool {
    match obstacle.outline {
        Outline::Segment { .. } => true,
        Outline::Box { size, .. } => size[0].abs().min(size[1].abs()) <= MAX_WALL_THICKNESS,
        Outline::Circle { .. } => false,
    }
}

fn area(frame: &Frame, outline: &Outline) -> Option<DrawnShape> {
    match *outline {
        Outline::Segment { .. } => None,
        Outline::Box { center, size, angle } => {
            let corners = box_corners(center, size, angle);
            Some(DrawnShape::Area(corners.map(|[x, y]| frame.at(x, y)).to_vec()))
        }
        Outline::Circle {
            center: [x, y],
            radius,
        } => {
            let middle = frame.at(x, y);
            Some(DrawnShape::Disc(middle, frame.pixels(radius)))
        }
    }
}

/// A length with the digits that its step needs.
fn metres(length: f64, step: f64) -> String {
    let digits = (-step.log10().floor()).max(0.0) as usize;
    // Adding zero turns "-0" into "0".
    format!("{:.digits$}", length + 0.0)
}

/// The middle of the pixel, where a line of one pixel has sharp edges.
fn crisp(position: f32) -> f32 {
    position.floor() + 0.5
}
