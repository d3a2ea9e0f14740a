//! Exports the body of the robot and the objects of the world, for windows. The exports have names of their
//! own, so that no schema steers by them inadvertently.

use core::time::Duration;

use jde_schema::prelude::*;
use jde_schema::types::{Body, Footprint, Mount, Point2D, Thing};
use jde_sim::{Color, Figure, Outline, Pose2, RobotId, RobotModel, Shape, World};

use crate::Robot;
use crate::sense::pose;

/// Period of the moving objects: smooth for viewers, and small in a recording.
pub(crate) const PUBLISH_PERIOD: Duration = Duration::from_millis(100);

/// Half the robot's usual period. In real time iterations start slightly early or late; within this tolerance
/// an iteration counts as the one that is due.
const SLACK: Duration = Duration::from_millis(25);

/// The world's frame by REP-105. The frame of the odometry starts in it.
const FRAME: &str = "map";
/// Colour and height of a robot: the red shell of a Pioneer, and m.
const SHELL: Color = Color::new(200, 34, 30);
const ROBOT_HEIGHT: f32 = 0.4;

impl Robot {
    /// Publishes the outline, of at most as many corners as fit, and where the lasers are. The frame of the
    /// first one is that of the export `laser`.
    pub(crate) fn publish_body(&mut self, cx: &Context, model: &RobotModel) {
        let corners: Vec<[f64; 2]> = model.config.footprint.corners().collect();
        let step = corners.len().div_ceil(Seq::<Point2D, 32>::CAPACITY).max(1);
        let frames = core::iter::once("laser").chain(model.lasers.iter().skip(1).map(|laser| &*laser.name));
        let mounts = frames.zip(&model.lasers).map(|(frame, laser)| Mount {
            frame: Text::truncated(frame),
            pose: pose(laser.config.mount),
        });
        let body = Body {
            header: Header::new(cx.now(), "base_link"),
            footprint: Footprint {
                radius: model.config.footprint.radius(),
                points: corners
                    .iter()
                    .step_by(step)
                    .map(|&[x, y]| Point2D { x, y })
                    .collect(),
            },
            lasers: mounts.collect(),
        };
        self.body.write(cx, body);
    }

    /// Publishes the static objects, then the paint of the floor.
    pub(crate) fn publish_scenery(&mut self, cx: &Context, world: &World) {
        let mut scenery = self.scenery.loan(cx);
        scenery.header = Header::new(cx.now(), FRAME);
        scenery.padding = Padding::ZERO;
        scenery.left_out = 0;
        scenery.things.clear();
        let still = world.shapes().filter(|shape| !shape.moving);
        let paint = world.paint().map(|shape| Thing {
            form: Thing::PAINT,
            ..to_thing(&shape)
        });
        for thing in still.map(|shape| to_thing(&shape)).chain(paint) {
            if scenery.things.push(thing).is_err() {
                scenery.left_out += 1;
            }
        }
        scenery.publish();
    }

    /// Publishes the moving objects except the robot itself.
    pub(crate) fn publish_movers(&mut self, cx: &Context, world: &World, itself: RobotId) {
        let mut movers = self.movers.loan(cx);
        movers.header = Header::new(cx.now(), FRAME);
        movers.padding = Padding::ZERO;
        movers.left_out = 0;
        movers.things.clear();
        let moving = world.shapes().filter(|shape| shape.moving);
        let others = world.robots().filter(|(robot, _)| *robot != itself);
        let robots = others.map(|(robot, name)| {
            let [low, high] = world.config(robot).footprint.extent();
            let middle = Pose2::new((low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0, 0.0);
            let pose = world.truth(robot).pose.compose(middle);
            Thing {
                name: Text::truncated(name),
                pose: Pose2D::new(pose.x, pose.y, pose.heading),
                length: (high[0] - low[0]) as f32,
                width: (high[1] - low[1]) as f32,
                height: ROBOT_HEIGHT,
                form: Thing::ROBOT,
                red: SHELL.r,
                green: SHELL.g,
                blue: SHELL.b,
            }
        });
        for thing in moving.map(|shape| to_thing(&shape)).chain(robots) {
            if movers.things.push(thing).is_err() {
                movers.left_out += 1;
            }
        }
        movers.publish();
    }
}

/// Returns whether what is published at a period is due now, and if so updates `due`.
pub(crate) fn is_time(due: &mut Option<Duration>, now: Duration, period: Duration) -> bool {
    let expected = due.unwrap_or(now);
    if now + SLACK < expected {
        return false;
    }
    let start = if now <= expected + SLACK { expected } else { now };
    *due = Some(start + period);
    true
}

fn to_thing(shape: &Shape<'_>) -> Thing {
    let (place, [length, width]) = shape.outline.placed();
    let (form, heading) = match (shape.outline, shape.figure) {
        (Outline::Segment { .. } | Outline::Box { .. }, _) => (Thing::BOX, place.heading),
        (Outline::Circle { .. }, Figure::Upright) => (Thing::CYLINDER, place.heading),
        (Outline::Circle { .. }, Figure::Ball) => (Thing::BALL, place.heading),
        (Outline::Circle { .. }, Figure::Person { heading }) => (Thing::PERSON, heading),
    };
    Thing {
        name: Text::truncated(shape.name),
        pose: Pose2D::new(place.x, place.y, heading),
        length: length as f32,
        width: width as f32,
        height: shape.height as f32,
        form,
        red: shape.color.r,
        green: shape.color.g,
        blue: shape.color.b,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use jde_schema::types::{Movers, Scenery, Thing};
    use jde_sim::World;

    use super::*;
    use crate::tests::{Robot, file};

    const ROOM: &str = r##"
walls   = [{ name = "room", points = [[0, 0], [6, 0], [6, 5], [0, 5]], closed = true, height = 2.2 }]
boxes   = [{ name = "desk", center = [1, 4], size = [1.2, 0.6], angle_deg = 90, color = "#102030" }]
balls   = [{ name = "ball", center = [4, 1], radius = 0.1 }]
people  = [{ name = "eva", way = [[5, 4], [5, 2]], speed = 0.5 }]

[robots.bench]
start = { x = 2, y = 3 }

[robots.other]
start = { x = 4, y = 4, heading_deg = 180 }
"##;

    fn named<'a>(things: &'a [Thing], name: &str) -> &'a Thing {
        let found = things.iter().find(|thing| thing.name.as_str() == name);
        found.unwrap_or_else(|| panic!("there is no {name}"))
    }

    #[test]
    fn static_objects_are_published_once_with_pose_size_and_color() {
        let (_folder, path) = file(ROOM);
        let mut robot = Robot::awake(&path, "bench");
        robot.idle(1.0);
        let time = robot.bench.exported_at("scenery").expect("it is exported");
        assert_eq!(
            time,
            Duration::from_millis(50),
            "published only when the robot enters the world"
        );
        let scenery: &Scenery = robot.bench.exported_in_place("scenery").expect("it is exported");
        assert_eq!((scenery.things.len(), scenery.left_out), (5, 0));
        let walls = scenery
            .things
            .iter()
            .filter(|thing| thing.name.as_str() == "room");
        let (count, around) = walls.fold((0, 0.0), |(count, sum), wall| {
            assert_eq!((wall.form, wall.width, wall.height), (Thing::BOX, 0.0, 2.2));
            (count + 1, sum + wall.length)
        });
        assert_eq!((count, around), (4, 22.0));
        let desk = named(&scenery.things, "desk");
        assert_eq!((desk.length, desk.width, desk.height), (1.2, 0.6, 0.75));
        assert_eq!([desk.red, desk.green, desk.blue], [0x10, 0x20, 0x30]);
        assert!((desk.pose.theta - core::f64::consts::FRAC_PI_2).abs() < 1e-9);
    }

    #[test]
    fn paint_is_published_in_layers_after_the_static_objects() {
        let paint = "
            [[floor_areas]]\nname = 'zone'\ncenter = [3, 3]\nsize = [1, 1]\ncolor = '#ffffff'\ntile = 0.5
            [[floor_lines]]\nname = 'track'\npoints = [[1, 2], [3, 2]]\nwidth = 0.05\ncolor = '#102030'\n";
        let (_folder, path) = file(&format!("{ROOM}{paint}"));
        let mut robot = Robot::awake(&path, "bench");
        robot.idle(0.05);
        let scenery: &Scenery = robot.bench.exported_in_place("scenery").expect("it is exported");
        let names: Vec<_> = scenery.things.iter().map(|thing| thing.name.as_str()).collect();
        assert_eq!(names[4..], ["desk", "zone", "zone", "zone", "track"]);
        let track = named(&scenery.things, "track");
        assert_eq!((track.form, track.length, track.width), (Thing::PAINT, 2.0, 0.05));
        assert_eq!([track.red, track.green, track.blue], [0x10, 0x20, 0x30]);
        let layers: Vec<_> = scenery.things[5..].iter().map(|thing| thing.height).collect();
        assert!(
            layers.is_sorted() && layers[0] < layers[1] && layers[2] < layers[3],
            "{layers:?}"
        );
    }

    #[test]
    fn moving_objects_without_the_robot_are_published_ten_times_a_second() {
        let (_folder, path) = file(ROOM);
        let mut robot = Robot::awake(&path, "bench");
        let mut times = BTreeSet::new();
        let mut positions = Vec::new();
        for _ in 0..40 {
            robot.idle(0.05);
            times.insert(robot.bench.exported_at("movers").expect("it is exported"));
            let movers: &Movers = robot.bench.exported_in_place("movers").expect("it is exported");
            let names: Vec<_> = movers.things.iter().map(|thing| thing.name.as_str()).collect();
            assert_eq!(
                names,
                ["eva", "ball"],
                "without robots that have not entered the world"
            );
            positions.push(named(&movers.things, "eva").pose.y);
        }
        assert_eq!(times.len(), 20);
        let walked = positions[0] - positions[positions.len() - 1];
        assert!((walked - 0.95).abs() < 0.06, "eva walked {walked} m in 1.9 s");
        let other = Robot::awake(&path, "other");
        robot.idle(0.1);
        let movers: &Movers = robot.bench.exported_in_place("movers").expect("it is exported");
        let seen = named(&movers.things, "other");
        assert_eq!((seen.form, seen.pose.x, seen.pose.y), (Thing::ROBOT, 4.0, 4.0));
        drop(other);
    }

    #[test]
    fn objects_beyond_the_capacity_are_counted() {
        let posts: String = (0..1100)
            .map(|post| {
                let (x, y) = (post % 40, post / 40);
                format!("  {{ name = \"post\", center = [{x}, {y}], radius = 0.1 }},\n")
            })
            .collect();
        let world =
            format!("circles = [\n{posts}]\nrobots = {{ bench = {{ start = {{ x = 0.5, y = 0.5 }} }} }}");
        let (_folder, path) = file(&world);
        assert_eq!(World::load(&path, 0).expect("a world").shapes().count(), 1100);
        let mut robot = Robot::awake(&path, "bench");
        robot.idle(0.05);
        let scenery: &Scenery = robot.bench.exported_in_place("scenery").expect("it is exported");
        assert_eq!((scenery.things.len(), scenery.left_out), (1024, 76));
    }

    #[test]
    fn moving_objects_are_published_ten_times_a_second_with_an_uneven_clock() {
        let (_folder, path) = file(ROOM);
        let mut robot = Robot::awake(&path, "bench");
        let mut times = BTreeSet::new();
        for step in 1..=200_u64 {
            // One millisecond early, on time and late in turn, so that some intervals are shorter than the
            // period.
            let early = step % 3;
            robot
                .bench
                .set_now(Duration::from_micros(50_000 * step + 1000 - 1000 * early));
            robot.bench.iterate().expect("it drives and senses");
            times.insert(robot.bench.exported_at("movers").expect("it is exported"));
        }
        assert_eq!(times.len(), 100);
    }
}
