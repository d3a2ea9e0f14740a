//! Draws shapes given in metres. Shapes out of view are skipped, and detail below the screen's resolution is
//! merged.

use std::collections::HashSet;
use std::f64::consts::TAU;

use eframe::egui::epaint::{Mesh, PathShape, PathStroke};
use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape as Drawn, Stroke, pos2, vec2};
use jde_panel::{Area, Ink, Shape};

use super::clip::{self, Bounds};
use super::view::Transform;
use crate::style::{self, Style};

/// Points nearer to each other than this are merged, in points of the screen.
const MERGE_DISTANCE: f64 = 0.5;
/// More points than this are drawn as squares in one mesh.
const MANY_POINTS: usize = 1500;
/// Minimum length of a drawn robot, in points of the screen.
const MIN_ROBOT_LENGTH: f64 = 14.0;
const FONT_SIZE: f32 = 12.0;

/// Draws on a plane, in metres.
pub(crate) struct Draw2d<'a> {
    painter: Painter,
    transform: Transform,
    style: &'a Style,
    bounds: Bounds,
}

impl<'a> Draw2d<'a> {
    pub(super) fn new(painter: Painter, transform: Transform, style: &'a Style) -> Self {
        // Larger than the visible area, so that the ends of clipped lines are hidden.
        let rect = painter.clip_rect().expand(48.0);
        let bounds = [
            [f64::from(rect.left()), f64::from(rect.top())],
            [f64::from(rect.right()), f64::from(rect.bottom())],
        ];
        Self {
            painter,
            transform,
            style,
            bounds,
        }
    }

    /// The transform from metres to the screen.
    pub(crate) fn transform(&self) -> &Transform {
        &self.transform
    }

    /// The painter, for shapes that this type does not draw.
    pub(crate) fn painter(&self) -> &Painter {
        &self.painter
    }

    /// Draws a shape of a panel. A robot has the given outline, in its own frame.
    pub(crate) fn shape(&self, shape: &Shape, outline: &[[f64; 2]]) {
        let color_of = |color| style::exact(color, self.style);
        match shape {
            Shape::Line {
                points,
                closed,
                stroke,
            } => self.line(points, *closed, stroke.width, color_of(stroke.color)),
            Shape::Points { points, stroke } => self.points(points, stroke.width, color_of(stroke.color)),
            Shape::Circle {
                center,
                radius,
                filled: true,
                stroke,
            } => self.disc(*center, *radius, color_of(stroke.color)),
            Shape::Circle {
                center,
                radius,
                filled: false,
                stroke,
            } => self.circle(*center, *radius, stroke.width, color_of(stroke.color)),
            Shape::Polygon { points, color } => self.polygon(points, color_of(*color)),
            Shape::Arrow { from, to, stroke } => self.arrow(*from, *to, stroke.width, color_of(stroke.color)),
            Shape::Label { at, text, color } => self.label(*at, text, color_of(*color)),
            Shape::Robot { pose } => self.robot(*pose, outline),
        }
    }

    /// Draws a line through points. Its width is in points of the screen.
    pub(crate) fn line(&self, points: &[[f64; 2]], closed: bool, width: f32, color: Color32) {
        let screen = points.iter().map(|point| self.place(*point));
        self.path(screen, closed, Stroke::new(width, color));
    }

    /// Draws single points. Their width is in points of the screen.
    pub(crate) fn points(&self, points: &[[f64; 2]], width: f32, color: Color32) {
        let cell = f64::from(width / 2.0).max(MERGE_DISTANCE);
        let mut occupied = HashSet::new();
        let visible: Vec<Pos2> = points
            .iter()
            .map(|point| self.place(*point))
            .filter(|at| clip::overlaps(*at, *at, self.bounds))
            .filter(|at| {
                points.len() < 256 || occupied.insert(((at[0] / cell) as i32, (at[1] / cell) as i32))
            })
            .map(round)
            .collect();
        if visible.len() <= MANY_POINTS {
            let dots = visible
                .into_iter()
                .map(|at| Drawn::circle_filled(at, width / 2.0, color));
            self.painter.extend(dots);
            return;
        }
        let mut mesh = Mesh::default();
        for at in visible {
            mesh.add_colored_rect(Rect::from_center_size(at, vec2(width, width)), color);
        }
        self.painter.add(mesh);
    }

    /// Draws a circle. Its radius is in m, the width of its line in points of the screen.
    pub(crate) fn circle(&self, center: [f64; 2], radius: f64, width: f32, color: Color32) {
        if let Some(round) = self.round(center, radius) {
            self.path(round.into_iter(), true, Stroke::new(width, color));
        }
    }

    /// Draws a filled circle. Its radius is in m.
    pub(crate) fn disc(&self, center: [f64; 2], radius: f64, color: Color32) {
        if let Some(round) = self.round(center, radius) {
            self.fill(round, color);
        }
    }

    /// Draws a filled convex polygon.
    pub(crate) fn polygon(&self, points: &[[f64; 2]], color: Color32) {
        let screen = points.iter().map(|point| self.place(*point)).collect();
        self.fill(screen, color);
    }

    /// Draws a line with an arrow head at `to`. Its width is in points of the screen.
    pub(crate) fn arrow(&self, from: [f64; 2], to: [f64; 2], width: f32, color: Color32) {
        let (tail, tip) = (self.place(from), self.place(to));
        let direction = [tip[0] - tail[0], tip[1] - tail[1]];
        let length = direction[0].hypot(direction[1]);
        if length < MERGE_DISTANCE {
            return;
        }
        let ahead = [direction[0] / length, direction[1] / length];
        let head = (6.0 + 2.5 * f64::from(width)).min(0.6 * length);
        let neck = [tip[0] - head * ahead[0], tip[1] - head * ahead[1]];
        let half_width = 0.42 * head;
        self.path([tail, neck].into_iter(), false, Stroke::new(width, color));
        let corners = vec![
            tip,
            [neck[0] - half_width * ahead[1], neck[1] + half_width * ahead[0]],
            [neck[0] + half_width * ahead[1], neck[1] - half_width * ahead[0]],
        ];
        self.fill(corners, color);
    }

    /// Draws a text of constant size with its lower left corner at a position.
    pub(crate) fn label(&self, at: [f64; 2], text: &str, color: Color32) {
        let at = self.place(at);
        let label_bounds = [
            [self.bounds[0][0] - 2000.0, self.bounds[0][1]],
            [self.bounds[1][0], self.bounds[1][1] + 2000.0],
        ];
        if !clip::overlaps(at, at, label_bounds) {
            return;
        }
        let font = FontId::proportional(FONT_SIZE);
        let galley = self.painter.layout_no_wrap(text.to_owned(), font, color);
        let rect = Align2::LEFT_BOTTOM.anchor_size(round(at), galley.size());
        let ground = if self.style.dark {
            Color32::BLACK
        } else {
            Color32::WHITE
        };
        self.painter
            .rect_filled(rect.expand2(vec2(2.0, 0.0)), 2.0, ground.gamma_multiply(0.8));
        self.painter.galley(rect.min, galley, color);
    }

    /// Draws the outline of a robot at x, y and heading, enlarged where it would be too small to see. The
    /// outline is in the robot's own frame, in m.
    pub(crate) fn robot(&self, [x, y, heading]: [f64; 3], outline: &[[f64; 2]]) {
        let (sin, cos) = heading.sin_cos();
        let longest = outline.iter().map(|[x, y]| 2.0 * x.hypot(*y)).fold(0.0, f64::max);
        let larger = (MIN_ROBOT_LENGTH / (longest * self.transform.scale())).max(1.0);
        let placed = |[ahead, left]: [f64; 2]| {
            let (ahead, left) = (ahead * larger, left * larger);
            [x + ahead * cos - left * sin, y + ahead * sin + left * cos]
        };
        let body: Vec<_> = outline.iter().map(|corner| placed(*corner)).collect();
        let color = style::color_of(Ink::Plain, self.style);
        self.polygon(&body, color.gamma_multiply(0.18));
        self.line(&body, true, 1.5, color);
        self.polygon(
            &nose(outline).map(placed),
            style::color_of(Ink::Accent, self.style),
        );
    }

    /// The position on the screen of a position on the plane, in double precision.
    fn place(&self, at: [f64; 2]) -> [f64; 2] {
        let middle = self.transform.rect().center();
        let (across, up) = self.transform.offset(at);
        [f64::from(middle.x) + across, f64::from(middle.y) - up]
    }

    /// The corners of a circle on the screen, enough of them to look round. `None` if the circle is out of
    /// view.
    fn round(&self, center: [f64; 2], radius: f64) -> Option<Vec<[f64; 2]>> {
        let (middle, radius) = (self.place(center), radius.abs() * self.transform.scale());
        let low = [middle[0] - radius, middle[1] - radius];
        let high = [middle[0] + radius, middle[1] + radius];
        if !clip::overlaps(low, high, self.bounds) {
            return None;
        }
        // The middle of each chord is at most 0.2 points from the circle, up to the limit of corners.
        let corners = (TAU / 2.0 * (radius / 0.4).sqrt()).ceil().clamp(12.0, 4096.0);
        let corner = |number: u32| {
            let (sin, cos) = (TAU * f64::from(number) / corners).sin_cos();
            [middle[0] + radius * cos, middle[1] + radius * sin]
        };
        Some((0..corners as u32).map(corner).collect())
    }

    fn path(&self, points: impl Iterator<Item = [f64; 2]>, closed: bool, stroke: Stroke) {
        let mut points = points.peekable();
        let Some(first) = points.next() else { return };
        let mut run = Vec::new();
        let mut last = first;
        let mut is_clipped = false;
        let back = closed.then_some(first);
        let mut rest = points.chain(back).peekable();
        while let Some(point) = rest.next() {
            if (point[0] - last[0]).hypot(point[1] - last[1]) < MERGE_DISTANCE && rest.peek().is_some() {
                continue;
            }
            match clip::segment(last, point, self.bounds) {
                Some([from, to]) => {
                    if run.is_empty() || from != last {
                        is_clipped |= from != first;
                        self.stroke(&mut run, stroke);
                        run.push(round(from));
                    }
                    run.push(round(to));
                    is_clipped |= to != point;
                }
                None => {
                    is_clipped = true;
                    self.stroke(&mut run, stroke);
                }
            }
            last = point;
        }
        if closed && !is_clipped && run.len() > 2 {
            run.pop();
            self.painter.add(Drawn::closed_line(run, stroke));
        } else {
            self.stroke(&mut run, stroke);
        }
    }

    fn stroke(&self, run: &mut Vec<Pos2>, stroke: Stroke) {
        if run.len() > 1 {
            self.painter.line(std::mem::take(run), stroke);
        }
        run.clear();
    }

    fn fill(&self, corners: Vec<[f64; 2]>, color: Color32) {
        let mut visible = clip::polygon(corners, self.bounds);
        visible.dedup_by(|a, b| (a[0] - b[0]).hypot(a[1] - b[1]) < 0.05);
        if visible.len() > 2 {
            let path =
                PathShape::convex_polygon(visible.into_iter().map(round).collect(), color, PathStroke::NONE);
            self.painter.add(path);
        }
    }
}

/// The triangle on a robot that shows its heading, in the robot's own frame.
pub(crate) fn nose(outline: &[[f64; 2]]) -> [[f64; 2]; 3] {
    let reach = |axis: usize| outline.iter().map(|corner| corner[axis]).fold(0.0, f64::max);
    let (front, size) = (reach(0), reach(0).min(reach(1)));
    let back = front - 0.75 * size;
    [[back, 0.4 * size], [front - 0.1 * size, 0.0], [back, -0.4 * size]]
}

/// The bounding box of shapes, at least 1 m wide and high. Labels count as points. `None` if there are no
/// shapes.
pub(crate) fn bounds(shapes: &[Shape]) -> Option<Area> {
    let mut area: Option<Area> = None;
    let mut take = |point: [f64; 2], radius: f64| {
        let area = area.get_or_insert(Area {
            least: point,
            greatest: point,
        });
        for (axis, at) in point.into_iter().enumerate() {
            area.least[axis] = area.least[axis].min(at - radius);
            area.greatest[axis] = area.greatest[axis].max(at + radius);
        }
    };
    for shape in shapes {
        match shape {
            Shape::Line { points, .. } | Shape::Points { points, .. } | Shape::Polygon { points, .. } => {
                points.iter().for_each(|point| take(*point, 0.0));
            }
            Shape::Circle { center, radius, .. } => take(*center, radius.abs()),
            Shape::Arrow { from, to, .. } => {
                take(*from, 0.0);
                take(*to, 0.0);
            }
            Shape::Label { at, .. } => take(*at, 0.0),
            Shape::Robot { pose: [x, y, _] } => take([*x, *y], 0.3),
        }
    }
    area.map(|mut area| {
        for axis in 0..2 {
            let missing = 1.0 - (area.greatest[axis] - area.least[axis]);
            if missing > 0.0 {
                area.least[axis] -= missing / 2.0;
                area.greatest[axis] += missing / 2.0;
            }
        }
        area
    })
}

fn round([x, y]: [f64; 2]) -> Pos2 {
    pos2(x as f32, y as f32)
}
