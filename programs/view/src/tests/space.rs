//! The 3D view of a simulated robot.

use egui_kittest::Harness;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use glam::Vec2;

use super::common::{Robot, until};
use crate::session::WindowSession;
use crate::style::{Style, Units};
use crate::window::Window;
use crate::window::space::{Eye, Quality, Space, offer};

struct Shown {
    session: WindowSession,
    space: Space,
}

fn harness(robot: &Robot) -> Harness<'static, Shown> {
    let state = create_render_state(
        default_wgpu_setup(),
        eframe::egui_wgpu::RendererOptions::PREDICTABLE,
    );
    let card = state.clone();
    // Hides all other red items. The camera of the view is near and does not move.
    let saved = serde_json::json!({
        "orbit": { "distance": 3.0, "pitch": 1.0 },
        "items": { "axes": false, "walls": false, "movers": false, "labels": false },
    });
    let shown = Shown {
        session: robot.session(),
        space: Space::open(&saved),
    };
    Harness::builder()
        .with_size([600.0, 420.0])
        .with_render_cursor(false)
        .with_context_setup(move |ctx| offer(ctx, &card, Quality::Fine))
        .renderer(WgpuTestRenderer::from_render_state(state))
        .build_ui_state(
            |ui, Shown { session, space }: &mut Shown| {
                session.begin_frame();
                let style = Style::of(ui.ctx(), Units::default());
                space.show(ui, session, &style);
            },
            shown,
        )
}

#[test]
fn a_driving_robot_moves_in_the_picture() {
    let robot = Robot::of("safe-navigation");
    let mut harness = harness(&robot);
    until(&mut harness, |harness| {
        let seen = harness.state().space.seen();
        seen.robots
            .first()
            .is_some_and(|robot| !robot.lasers.is_empty() && robot.pose.is_some())
    });
    harness.state_mut().space.stay();
    harness.step();
    let from = robot_on_screen(&harness);
    let first = harness.render().expect("the window renders");
    until(&mut harness, |harness| {
        robot_on_screen(harness).distance(from) > 120.0
    });
    let second = harness.render().expect("the window renders");
    assert!(first != second);
    // The red body is at the reported position, within its radius.
    let (at, mean_red_position) = (
        robot_on_screen(&harness),
        mean_red_position(second.enumerate_pixels().map(|(x, y, pixel)| (x, y, pixel.0))),
    );
    let reach = 0.25 * eye(&harness).0.scale(harness.state().space.orbit().target);
    assert!(
        mean_red_position.distance(at) < reach,
        "the shell is at {mean_red_position}, and not at {at}"
    );
    assert!(
        mean_red_position.distance(from) > reach,
        "the shell is still where the robot was"
    );
}

#[test]
fn the_walls_are_where_the_laser_measures_them() {
    let robot = Robot::of("safe-navigation");
    let mut harness = harness(&robot);
    harness.state_mut().space.want(|items| items.walls = true);
    until(&mut harness, |harness| {
        let seen = harness.state().space.seen();
        let robot = seen.robots.first();
        seen.world.scenery.is_some()
            && robot.is_some_and(|robot| !robot.lasers.is_empty() && robot.pose.is_some())
    });
    let seen = harness.state().space.seen();
    let robot = &seen.robots[0];
    let (laser, scan) = (
        robot.laser("laser").expect("the laser has a pose"),
        &robot.lasers[0].1,
    );
    let scenery = seen.world.scenery.as_ref().expect("the scenery was received");
    let mut at_a_wall = 0;
    for point in scan.points() {
        let at = laser.transform_point3(glam::Vec3::new(point.x as f32, point.y as f32, 0.0));
        let gap = scenery.things.iter().map(|thing| {
            let frame = seen.world.frame * crate::window::space::frame(thing.pose);
            let local = frame.inverse().transform_point3(at);
            let out = Vec2::new(local.x, local.y).abs() - Vec2::new(thing.length, thing.width) / 2.0;
            out.max(Vec2::ZERO).length()
        });
        // Moving things are not part of the scenery.
        at_a_wall += usize::from(gap.fold(f32::INFINITY, f32::min) < 0.12);
    }
    let all = scan.points().count();
    assert!(
        all > 50 && 10 * at_a_wall > 8 * all,
        "{at_a_wall} of {all} points are at a wall"
    );
}

/// The position of the robot's middle in the picture.
fn robot_on_screen(harness: &Harness<'_, Shown>) -> Vec2 {
    let space = &harness.state().space;
    let robot = space.seen().robots[0].place().expect("the robot has a pose");
    let at = robot.transform_point3(glam::Vec3::Z * 0.15);
    let (eye, corner) = eye(harness);
    eye.project(at).expect("the robot is in front of the eye") + corner
}

/// The eye, and the upper left corner of its picture.
fn eye(harness: &Harness<'_, Shown>) -> (Eye, Vec2) {
    let area = harness.ctx.content_rect().shrink(8.0);
    let eye = harness
        .state()
        .space
        .orbit()
        .eye(Vec2::new(area.width(), area.height()));
    (eye, Vec2::new(area.left(), area.top()))
}

/// The mean position of all red pixels.
fn mean_red_position(pixels: impl Iterator<Item = (u32, u32, [u8; 4])>) -> Vec2 {
    let red = pixels.filter(|(_, _, [red, green, blue, _])| *red > 90 && *green < red / 3 && *blue < red / 3);
    let (sum, count) = red.fold((Vec2::ZERO, 0.0), |(sum, count), (x, y, _)| {
        (sum + Vec2::new(x as f32, y as f32), count + 1.0)
    });
    assert!(count > 20.0, "the picture has no red pixels");
    sum / count
}
