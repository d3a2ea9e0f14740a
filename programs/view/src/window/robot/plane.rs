//! The plane around the robot: its sensor data, its path and its speeds, in metres. It draws only the data
//! given to it.

use std::f64::consts::{FRAC_PI_2, PI};

use eframe::egui::{Color32, Mesh, Shape, Ui};
use jde_panel::{Area, Ink};
use jde_types::{Bumpers, LaserScan, LineSensor, Pose2D, PositionFix, RangeRing, Twist};
use serde::{Deserialize, Serialize};

use super::super::trail::Trail;
use super::sensors::Sensors;
use crate::canvas::{Canvas, Draw2d, View};
use crate::style::{self, Style};

/// The area shown around a robot at first, in m: more ahead than behind.
const AROUND: Area = Area {
    least: [-1.5, -2.5],
    greatest: [3.5, 2.5],
};
/// Margin around a path, in m.
const PATH_MARGIN: f64 = 2.0;
/// Opacity of stale data.
const STALE_OPACITY: f32 = 0.3;
/// Number of corners with which an ellipse is drawn.
const ELLIPSE_CORNERS: u32 = 32;
/// A speed is drawn as the distance covered in this time, in s.
const ARROW_SECONDS: f64 = 1.5;
/// A slower robot stands still, in m/s and rad/s.
const STANDSTILL_SPEED: f64 = 0.005;

/// The user's choice of what the plane shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Plane {
    view: View,
    /// The robot stays in the middle with its heading up. Otherwise the floor stays fixed.
    pub(super) ahead_up: bool,
    /// On a fixed floor: the view follows the robot.
    pub(super) follow: bool,
    pub(super) laser: bool,
    pub(super) sonars: bool,
    pub(super) path: bool,
    pub(super) speeds: bool,
}

impl Default for Plane {
    fn default() -> Self {
        Self {
            view: View::default(),
            ahead_up: true,
            follow: true,
            laser: true,
            sonars: true,
            path: true,
            speeds: true,
        }
    }
}

impl Plane {
    /// Shows the plane in all available space.
    pub(super) fn show(&mut self, ui: &mut Ui, senses: &Sensors, style: &Style) {
        let pose = senses.pose();
        // The poses of the robot and of the odometry's frame on the plane.
        let (robot, floor) = if self.ahead_up {
            (Pose2D::ORIGIN, pose.localize(&Pose2D::ORIGIN))
        } else {
            (pose, Pose2D::ORIGIN)
        };
        let home = if self.ahead_up {
            AROUND
        } else {
            around(&senses.trail, pose)
        };
        if !self.ahead_up && self.follow {
            self.view.follow([pose.x, pose.y]);
        }
        let canvas = Canvas::new("around the robot", home).forward_up(self.ahead_up);
        let mut view = std::mem::take(&mut self.view);
        canvas.show(ui, style, &mut view, |draw| {
            let mut drawing = PlaneDrawing {
                draw,
                style,
                robot,
                floor,
            };
            drawing.all(self, senses);
        });
        self.view = view;
    }

    /// Resets pan and zoom.
    pub(super) fn fit(&mut self) {
        self.view.fit();
    }
}

/// The bounding box of the path and the robot, with a margin.
fn around(trail: &Trail, pose: Pose2D) -> Area {
    let mut area = Area {
        least: [pose.x, pose.y],
        greatest: [pose.x, pose.y],
    };
    for point in trail.paths().flatten() {
        for (axis, at) in point.iter().enumerate() {
            area.least[axis] = area.least[axis].min(*at);
            area.greatest[axis] = area.greatest[axis].max(*at);
        }
    }
    Area {
        least: area.least.map(|at| at - PATH_MARGIN),
        greatest: area.greatest.map(|at| at + PATH_MARGIN),
    }
}

struct PlaneDrawing<'a, 'p> {
    draw: &'a mut Draw2d<'p>,
    style: &'a Style,
    /// The robot's pose on the plane.
    robot: Pose2D,
    /// The pose of the odometry's frame on the plane.
    floor: Pose2D,
}

impl PlaneDrawing<'_, '_> {
    fn all(&mut self, plane: &Plane, senses: &Sensors) {
        if plane.laser
            && let Some(laser) = senses.laser.value()
        {
            let color = self.color_of(Ink::Seen, senses.laser.is_fresh());
            self.fan(&self.robot.transform(&senses.mount), laser, color);
        }
        if plane.sonars
            && let Some(sonars) = senses.sonars.value()
        {
            self.cones(sonars, self.color_of(Ink::Warn, senses.sonars.is_fresh()));
        }
        if plane.path {
            let color = self.color_of(Ink::Accent, true).gamma_multiply(0.7);
            for path in senses.trail.paths() {
                let path: Vec<_> = path.map(|point| on(&self.floor, point)).collect();
                self.draw.line(&path, false, 1.5, color);
            }
        }
        if let Some(target) = senses.target {
            self.target(on(&self.floor, [target.x, target.y]));
        }
        let Pose2D { x, y, theta } = self.robot;
        self.draw.robot([x, y, theta], &senses.outline);
        if let Some(bumpers) = senses.bumpers.value() {
            self.bumpers(bumpers, &senses.outline, senses.bumpers.is_fresh());
        }
        if let Some(line) = senses.line.value() {
            self.cells(line, senses.line.is_fresh());
        }
        if let Some(fix) = senses.position.value() {
            self.position(fix, self.color_of(Ink::Goal, senses.position.is_fresh()));
        }
        if plane.laser
            && let Some(laser) = senses.laser.value()
        {
            let at = self.robot.transform(&senses.mount);
            let hits: Vec<_> = laser.points().map(|point| on(&at, [point.x, point.y])).collect();
            self.draw
                .points(&hits, 3.0, self.color_of(Ink::Seen, senses.laser.is_fresh()));
        }
        if plane.speeds {
            if let Some(odometry) = senses.odometry.value() {
                let color = self.color_of(Ink::Good, senses.odometry.is_fresh());
                self.speed(&odometry.twist.twist, 4.0, color);
            }
            if let Some(twist) = senses.commanded.value() {
                self.speed(twist, 1.5, self.color_of(Ink::Accent, true));
            }
        }
    }

    fn color_of(&self, color: Ink, fresh: bool) -> Color32 {
        let color = style::color_of(color, self.style);
        if fresh {
            color
        } else {
            color.gamma_multiply(STALE_OPACITY)
        }
    }

    /// Draws the area that a laser at a pose found free, and its rays, faintly.
    fn fan(&self, at: &Pose2D, laser: &LaserScan, color: Color32) {
        let mut mesh = Mesh::default();
        let ground = color.gamma_multiply(0.09);
        let transform = *self.draw.transform();
        let vertex = |mesh: &mut Mesh, at: [f64; 2]| mesh.colored_vertex(transform.screen(at), ground);
        vertex(&mut mesh, [at.x, at.y]);
        let mut last = None;
        for (beam, range) in laser.ranges.iter().enumerate() {
            let range = match *range {
                range if range.is_nan() => {
                    last = None;
                    continue;
                }
                range if range == f32::INFINITY => laser.range_max,
                range if range < 0.0 => laser.range_min,
                range => range,
            };
            let (sin, cos) = laser.angle(beam).sin_cos();
            let range = f64::from(range);
            let number = mesh.vertices.len() as u32;
            vertex(&mut mesh, on(at, [range * cos, range * sin]));
            if let Some(before) = last.replace(number) {
                mesh.add_triangle(0, before, number);
            }
        }
        self.draw.painter().add(Shape::mesh(mesh));
        let faint = color.gamma_multiply(0.12);
        for point in laser.points() {
            let ray = [[at.x, at.y], on(at, [point.x, point.y])];
            self.draw.line(&ray, false, 1.0, faint);
        }
    }

    fn cones(&self, ring: &RangeRing, color: Color32) {
        let half = f64::from(ring.field_of_view) / 2.0;
        let echoes: Vec<usize> = ring.echoes().map(|echo| echo.sonar).collect();
        for sonar in echoes {
            let (Some(mount), Some(range)) = (ring.poses.get(sonar), ring.ranges.get(sonar)) else {
                continue;
            };
            let range = f64::from(range.clamp(ring.min_range, ring.max_range));
            let at = self.robot.transform(mount);
            let rim = (0..=6).map(|step| {
                let angle = half * (f64::from(step) / 3.0 - 1.0);
                let (sin, cos) = angle.sin_cos();
                on(&at, [range * cos, range * sin])
            });
            let rim: Vec<_> = rim.collect();
            let mut cone = vec![[at.x, at.y]];
            cone.extend(&rim);
            self.draw.polygon(&cone, color.gamma_multiply(0.1));
            self.draw.line(&rim, false, 2.0, color);
        }
    }

    fn target(&self, at: [f64; 2]) {
        let color = self.color_of(Ink::Goal, true);
        self.draw.circle(at, 0.3, 1.5, color);
        self.draw.disc(at, 0.06, color);
    }

    /// Draws a measured position, as if its frame were that of the odometry, with the ellipse in which the
    /// true one is with a probability of 86 %: two standard deviations.
    fn position(&self, fix: &PositionFix, color: Color32) {
        let [a, b, _, c] = fix.covariance;
        let (mean, half) = ((a + c) / 2.0, ((a - c) / 2.0).hypot(b));
        let axes = [mean + half, mean - half].map(|variance| 2.0 * variance.max(0.0).sqrt());
        let frame = Pose2D::new(fix.x, fix.y, 0.5 * (2.0 * b).atan2(a - c));
        let at = self.floor.transform(&frame);
        let ellipse = (0..ELLIPSE_CORNERS).map(|corner| {
            let (sin, cos) = (2.0 * PI * f64::from(corner) / f64::from(ELLIPSE_CORNERS)).sin_cos();
            on(&at, [axes[0] * cos, axes[1] * sin])
        });
        self.draw.line(&ellipse.collect::<Vec<_>>(), true, 1.5, color);
        self.draw.points(&[[at.x, at.y]], 6.0, color);
    }

    /// Draws the cells of a line sensor in the grey of what they see, faintly if that is stale.
    fn cells(&self, line: &LineSensor, fresh: bool) {
        let opacity = if fresh { 1.0 } else { STALE_OPACITY };
        for (cell, brightness) in line.cells.iter().zip(&line.brightness) {
            let at = on(&self.robot, [cell.x, cell.y]);
            let grey = Color32::from_gray((255.0 * brightness.clamp(0.0, 1.0)) as u8);
            self.draw.points(&[at], 8.0, self.color_of(Ink::Faint, fresh));
            self.draw.points(&[at], 6.0, grey.gamma_multiply(opacity));
        }
    }

    /// Draws the bumpers as arcs in front and at the rear, in their order. Pressed ones are highlighted.
    fn bumpers(&self, bumpers: &Bumpers, outline: &[[f64; 2]], fresh: bool) {
        let radius_of_arc = outline.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max) + 0.05;
        // Both in front and at the rear from left to right.
        for (side, from, direction) in [
            (&bumpers.front, FRAC_PI_2 * 0.8, -1.0),
            (&bumpers.rear, PI - FRAC_PI_2 * 0.8, 1.0),
        ] {
            let width = FRAC_PI_2 * 1.6 / side.len().max(1) as f64;
            for (place, pressed) in side.iter().enumerate() {
                let arc: Vec<_> = (0..=4)
                    .map(|step| {
                        let share = place as f64 + 0.08 + 0.84 * f64::from(step) / 4.0;
                        let (sin, cos) = (from + direction * width * share).sin_cos();
                        on(&self.robot, [radius_of_arc * cos, radius_of_arc * sin])
                    })
                    .collect();
                if pressed.get() {
                    self.draw.line(&arc, false, 5.0, self.color_of(Ink::Bad, fresh));
                } else {
                    self.draw.line(&arc, false, 1.5, self.color_of(Ink::Faint, fresh));
                }
            }
        }
    }

    /// Draws a speed: an arrow for the distance of [`ARROW_SECONDS`], and an arc for the turn.
    fn speed(&self, twist: &Twist, width: f32, color: Color32) {
        let (x, y, turn) = (twist.linear.x, twist.linear.y, twist.angular.z);
        if x.hypot(y) > STANDSTILL_SPEED {
            let tip = on(&self.robot, [x * ARROW_SECONDS, y * ARROW_SECONDS]);
            self.draw.arrow([self.robot.x, self.robot.y], tip, width, color);
        }
        if turn.abs() > STANDSTILL_SPEED {
            let end = (turn * ARROW_SECONDS).clamp(-1.9 * PI, 1.9 * PI);
            let radius = 0.42;
            let arc: Vec<_> = (0..=16)
                .map(|step| {
                    let (sin, cos) = (end * f64::from(step) / 16.0).sin_cos();
                    on(&self.robot, [radius * cos, radius * sin])
                })
                .collect();
            self.draw.line(&arc[..16], false, width, color);
            self.draw.arrow(arc[14], arc[16], width, color);
        }
    }
}

/// Converts a position in a frame to the frame in which that frame is given.
fn on(frame: &Pose2D, [x, y]: [f64; 2]) -> [f64; 2] {
    let at = frame.transform(&Pose2D::new(x, y, 0.0));
    [at.x, at.y]
}
