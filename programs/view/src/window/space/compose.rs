//! Composes the draw list from the scene data: sensors, routes and targets in the frame of the odometry.

use std::f32::consts::PI;

use eframe::egui::Color32;
use glam::{Affine3A, Vec3};
use jde_panel::{Ink, Item, List};
use jde_types::{LaserScan, Pose2D, RangeRing, Thing};

use super::draw_list::{DrawList, Picture};
use super::items::Items;
use super::models::{self, CUT, SONAR_HEIGHT};
use super::scene_data::{Camera, RobotData, RouteData, SceneData, frame};
use super::solids;
use crate::style::{Style, color_of};
use jde_timeline::outline;

/// Distance of a camera's image from the camera, in m.
const PICTURE_DISTANCE: f32 = 0.7;
/// Targets nearer to each other than this are merged, in m.
const MERGED_TARGETS: f64 = 0.05;
/// Radius within which a target counts as reached, in all applications that come with jde, in m.
const REACHED_RADIUS: f32 = 0.3;
/// Number of segments in the arc of a sonar's cone.
const ARC_SEGMENTS: usize = 8;

/// Draws all selected items. Returns messages about what cannot be shown.
pub(crate) fn all(draw_list: &mut DrawList, seen: &SceneData, items: &Items, style: &Style) -> Vec<String> {
    let mut troubles = seen.troubles.clone();
    if items.axes {
        axes(draw_list, Affine3A::IDENTITY, 1.0, style);
    }
    if items.walls {
        walls(draw_list, seen, items, style);
    }
    if items.movers {
        for thing in seen.movers() {
            models::thing(draw_list, seen.world.frame, thing, None, edge(style));
            name(draw_list, seen, thing, items, style);
        }
    }
    for robot in &seen.robots {
        show_robot(draw_list, robot, items, style);
    }
    if items.targets {
        targets(draw_list, seen, items, style);
    }
    if items.cameras {
        for camera in &seen.cameras {
            show_camera(draw_list, camera, &seen.robots, style);
        }
    }
    if items.panels {
        for (schema, list) in &seen.panels {
            show_scenes(draw_list, seen, schema, list, style, &mut troubles);
        }
    }
    troubles
}

/// Draws a frame's axes: x red, y green, z blue.
pub(crate) fn axes(draw_list: &mut DrawList, frame: Affine3A, length: f32, style: &Style) {
    for (axis, color) in Vec3::AXES.into_iter().zip(axis_colors(style)) {
        let from = frame.transform_point3(Vec3::Z * 0.012);
        let to = frame.transform_point3(axis * length + Vec3::Z * 0.012);
        draw_list.arrow(from, to, 0.025 * length, color);
    }
}

pub(crate) fn axis_colors(style: &Style) -> [Color32; 3] {
    if style.dark {
        [
            Color32::from_rgb(236, 84, 76),
            Color32::from_rgb(104, 196, 84),
            Color32::from_rgb(86, 142, 240),
        ]
    } else {
        [
            Color32::from_rgb(204, 44, 38),
            Color32::from_rgb(52, 142, 40),
            Color32::from_rgb(36, 92, 204),
        ]
    }
}

fn edge(style: &Style) -> Color32 {
    if style.dark {
        Color32::from_rgba_unmultiplied(255, 255, 255, 70)
    } else {
        Color32::from_rgba_unmultiplied(0, 0, 0, 90)
    }
}

fn walls(draw_list: &mut DrawList, seen: &SceneData, items: &Items, style: &Style) {
    let Some(scenery) = &seen.world.scenery else {
        return;
    };
    let cut = (!items.tall).then_some(CUT);
    for thing in &scenery.things {
        models::thing(draw_list, seen.world.frame, thing, cut, edge(style));
    }
}

/// Makes a thing clickable, and writes its name beside it.
fn name(draw_list: &mut DrawList, seen: &SceneData, thing: &Thing, items: &Items, style: &Style) {
    let place = seen.world.frame * frame(thing.pose);
    let middle = place.transform_point3(Vec3::Z * thing.height / 2.0);
    if middle.is_finite() && !thing.name.is_empty() {
        draw_list.thing(thing.name.as_str(), middle, thing.height.max(thing.length) / 2.0);
        if items.labels {
            let top = place.transform_point3(Vec3::Z * (thing.height + 0.12));
            draw_list.label(top, thing.name.as_str(), color_of(Ink::Faint, style));
        }
    }
}

fn show_robot(draw_list: &mut DrawList, robot: &RobotData, items: &Items, style: &Style) {
    if items.path {
        let color = color_of(Ink::Accent, style);
        let above = |at: [f64; 2]| Vec3::new(at[0] as f32, at[1] as f32, 0.005);
        for path in robot.trail.paths() {
            draw_list.lines(path.map(above), 2.5, color);
        }
    }
    let Some(place) = robot.place() else { return };
    if items.robot {
        models::robot(draw_list, place, &outline(robot.body.as_ref()), &robot.carries);
        let middle = place.transform_point3(Vec3::Z * 0.15);
        draw_list.thing(robot.name.as_str(), middle, 0.28);
        if items.labels {
            let above = place.transform_point3(Vec3::Z * 0.55);
            draw_list.label(above, robot.name.as_str(), color_of(Ink::Plain, style));
        }
    }
    if items.laser {
        for (_, scan) in &robot.lasers {
            if let Some(laser) = robot.laser(scan.header.frame_id.as_str()) {
                show_laser(draw_list, laser, scan, style);
            }
        }
    }
    if items.sonars {
        for (_, ring) in &robot.sonars {
            show_sonars(draw_list, place, ring, style);
        }
    }
}

fn show_laser(draw_list: &mut DrawList, laser: Affine3A, scan: &LaserScan, style: &Style) {
    let point = |angle: f64, range: f64| {
        let (sin, cos) = angle.sin_cos();
        laser.transform_point3(Vec3::new((range * cos) as f32, (range * sin) as f32, 0.0))
    };
    let seen = color_of(Ink::Seen, style);
    let fan = seen.gamma_multiply(if style.dark { 0.11 } else { 0.13 });
    let origin = laser.transform_point3(Vec3::ZERO);
    let mut previous: Option<Vec3> = None;
    for (beam, &range) in scan.ranges.iter().enumerate() {
        // The free length of the beam: to its hit, to the range limit, or none if nothing was measured.
        let length = if range == f32::INFINITY {
            scan.range_max
        } else if range == f32::NEG_INFINITY {
            scan.range_min
        } else {
            range
        };
        let is_valid = length.is_finite() && length >= 0.0;
        let end = is_valid.then(|| point(scan.angle(beam), f64::from(length)));
        if let (Some(from), Some(to)) = (previous, end) {
            draw_list.triangle([origin, from, to], fan);
        }
        previous = end;
    }
    for hit in scan.points() {
        draw_list.dot(point(hit.angle, hit.range), 4.5, seen);
    }
}

fn show_sonars(draw_list: &mut DrawList, place: Affine3A, ring: &RangeRing, style: &Style) {
    let color = color_of(Ink::Warn, style);
    let field = if ring.field_of_view.is_finite() {
        ring.field_of_view.clamp(0.02, PI)
    } else {
        return;
    };
    for echo in ring.echoes() {
        let pose = ring.poses[echo.sonar];
        let sonar = place * Affine3A::from_translation(Vec3::Z * SONAR_HEIGHT) * frame(pose);
        let range = echo.range as f32;
        let arc = |step: usize| {
            let (sin, cos) = ((step as f32 / ARC_SEGMENTS as f32 - 0.5) * field).sin_cos();
            sonar.transform_point3(Vec3::new(cos, sin, 0.0) * range)
        };
        let apex = sonar.transform_point3(Vec3::ZERO);
        for step in 0..ARC_SEGMENTS {
            draw_list.triangle([apex, arc(step), arc(step + 1)], color.gamma_multiply(0.13));
        }
        draw_list.lines((0..=ARC_SEGMENTS).map(arc), 2.0, color.gamma_multiply(0.9));
    }
}

fn targets(draw_list: &mut DrawList, seen: &SceneData, items: &Items, style: &Style) {
    let faint = color_of(Ink::Faint, style);
    let goal = color_of(Ink::Goal, style);
    for way in &seen.routes {
        show_route(draw_list, way, goal, faint, items);
    }
    let present = seen
        .missions
        .iter()
        .filter(|(_, mission)| mission.state == 0 && mission.total > 0);
    let set = seen
        .targets
        .iter()
        .filter_map(|(whose, target)| Some((whose, target.get()?)));
    let mut shown: Vec<Pose2D> = Vec::new();
    for (whose, pose) in present.map(|(whose, mission)| (whose, mission.target)).chain(set) {
        let known = shown
            .iter()
            .any(|other| other.distance_to(&pose) < MERGED_TARGETS);
        if known || !pose.x.is_finite() || !pose.y.is_finite() {
            continue;
        }
        shown.push(pose);
        let foot = Vec3::new(pose.x as f32, pose.y as f32, 0.01);
        draw_list.ring(foot, REACHED_RADIUS, 2.0, goal);
        let top = foot + Vec3::Z * 0.75;
        draw_list.line(foot, top, 2.0, goal);
        draw_list.form(
            super::draw_list::Mesh::Sphere,
            Affine3A::from_translation(top),
            Vec3::splat(0.14),
            goal,
        );
        draw_list.thing(format!("target of {whose}"), top, 0.15);
        if items.labels {
            let from = seen.robots.first().and_then(|robot| robot.pose);
            let text = match from {
                Some(robot) => format!("target, {}", style.units.show(robot.distance_to(&pose), "m")),
                None => "target".to_owned(),
            };
            draw_list.label(top + Vec3::Z * 0.14, text, goal);
        }
    }
}

fn show_route(draw_list: &mut DrawList, way: &RouteData, goal: Color32, faint: Color32, items: &Items) {
    let points = way
        .points
        .iter()
        .map(|pose| Vec3::new(pose.x as f32, pose.y as f32, 0.008));
    let points: Vec<Vec3> = points.filter(|point| point.is_finite()).collect();
    draw_list.lines(points.iter().copied(), 1.5, goal.gamma_multiply(0.45));
    for (number, &point) in points.iter().enumerate() {
        let color = if number < way.reached { faint } else { goal };
        draw_list.ring(point, 0.12, 2.0, color);
        draw_list.thing(format!("{} {}", way.name, number + 1), point, 0.15);
        if items.labels && points.len() > 1 {
            draw_list.label(point + Vec3::Z * 0.1, (number + 1).to_string(), color);
        }
    }
}

/// Draws the image in front of its camera, and the pyramid of the field of view.
fn show_camera(draw_list: &mut DrawList, camera: &Camera, robots: &[RobotData], style: &Style) {
    let Some(place) = camera.place(robots) else { return };
    let [width, height] = camera.pixels.picture.size.map(|size| size as f32);
    let aside = PICTURE_DISTANCE * (camera.field / 2.0).tan().min(1.5);
    let up = aside * height / width;
    let corner =
        |left: f32, high: f32| place.transform_point3(Vec3::new(PICTURE_DISTANCE, left * aside, high * up));
    let corners = [
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
    ];
    let eye = place.transform_point3(Vec3::ZERO);
    let edge = color_of(Ink::Accent, style);
    for (number, &at) in corners.iter().enumerate() {
        draw_list.line(eye, at, 1.0, edge.gamma_multiply(0.7));
        draw_list.line(at, corners[(number + 1) % 4], 1.5, edge);
    }
    draw_list.pictures.push(Picture {
        name: camera.name.clone(),
        pixels: std::sync::Arc::clone(&camera.pixels),
        corners,
    });
}

/// Adds the scenes of a schema's panel.
fn show_scenes(
    draw_list: &mut DrawList,
    seen: &SceneData,
    schema: &str,
    list: &List,
    style: &Style,
    troubles: &mut Vec<String>,
) {
    for item in list.walk() {
        let Item::Scene { frame, solids, .. } = item else {
            continue;
        };
        match seen.frame(frame) {
            Some(place) => solids
                .iter()
                .for_each(|solid| solids::add(draw_list, place, solid, style)),
            None => troubles.push(format!(
                "{schema} draws in the frame `{frame}`, whose place is not known here"
            )),
        }
    }
}
