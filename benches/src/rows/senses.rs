//! The costs of the simulator's other sensors, and of its steps, in the worlds that it is delivered with.
//! There is no yardstick.

use std::fmt::Write as _;

use anyhow::Result;
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{consume, interleave};
use jde_sim::{CameraConfig, DepthConfig, RobotConfig, RobotId, SonarConfig, Twist2, World};

use crate::scope::Scope;

const SECOND: u64 = 1_000_000_000;

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let (office, robot) = world(scope, "office.toml")?;
    let ring = SonarConfig::default();
    let mut ranges = vec![0.0; ring.mounts.len()];
    let (mut turning, turning_robot) = world(scope, "office.toml")?;
    turning.command(turning_robot, Twist2::new(0.0, 0.5))?;
    let mut crowded = crowded()?;
    let [sonars, second, step] = interleave(
        scope.effort(),
        [
            &mut |times| (0..times).for_each(|_| consume(office.sonars(robot, &ring, &mut ranges))),
            &mut |times| (0..times).for_each(|_| turning.advance_to(turning.now() + SECOND)),
            &mut |times| (0..times).for_each(|_| crowded.advance_to(crowded.now() + jde_sim::STEP_NS)),
        ],
    );
    let line = |what: String, ns: f64| Line::new(what, Figure::Time(ns), Goal::ReportOnly);
    let mut lines = vec![
        line(String::from("sonar ring, 16 cones"), sonars.median()),
        line(
            String::from("one second of the office, without sensors"),
            second.median(),
        ),
        line(
            String::from("one step with 10 people and 10 balls"),
            step.median(),
        ),
    ];
    for name in ["office.toml", "hall.toml"] {
        let (world, robot) = world(scope, name)?;
        for (width, height) in [(320, 240), (640, 480)] {
            let camera = CameraConfig {
                width,
                height,
                ..CameraConfig::default()
            };
            let mut picture = vec![0; camera.bytes()];
            let (mut colors, mut depths) = (picture.clone(), vec![0.0; camera.pixels()]);
            let configs = (&camera, &DepthConfig::default());
            let [plain, with_depths] = interleave(
                scope.effort(),
                [
                    &mut |times| {
                        (0..times).for_each(|_| consume(world.picture(robot, &camera, &mut picture)));
                    },
                    &mut |times| {
                        (0..times).for_each(|_| {
                            consume(world.picture_with_depths(robot, configs, &mut colors, &mut depths));
                        });
                    },
                ],
            );
            let what = format!("picture, {width} x {height}, {name}");
            lines.push(line(format!("{what}, with depths"), with_depths.median()));
            lines.push(line(what, plain.median()));
        }
    }
    Ok(lines)
}

fn world(scope: &Scope, name: &str) -> Result<(World, RobotId)> {
    let mut world = World::load(scope.root.join("worlds").join(name), 1)?;
    let robot = world.add_robot("pioneer", RobotConfig::default())?;
    world.advance_to(3 * SECOND);
    Ok((world, robot))
}

/// A world with ten people who walk and ten balls that a patrolling robot pushes.
fn crowded() -> Result<World> {
    let mut text = String::from(
        "walls = [{ points = [[0, 0], [12, 0], [12, 12], [0, 12]], closed = true }]
         robots = { pioneer = { start = { x = 6, y = 6 } } }\n",
    );
    for index in 0..10 {
        let at = f64::from(index) + 1.0;
        let y = if index % 2 == 0 {
            4.6 + f64::from(index % 3)
        } else {
            7.4
        };
        let _ = writeln!(
            text,
            "[[people]]\nway = [[{at}, 1], [{at}, 11]]\nspeed = 0.{}\n[[balls]]\ncenter = [{}, {y}]\nradius = 0.11",
            index + 3,
            at + 0.6,
        );
    }
    let mut world = World::parse(&text, "busy.toml", 1)?;
    let robot = world.add_robot("pioneer", RobotConfig::default())?;
    world.command(robot, Twist2::new(0.6, 0.4))?;
    Ok(world)
}
