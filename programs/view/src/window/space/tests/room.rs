//! A constant scene.

use std::sync::Arc;

use glam::Vec3;
use jde_panel::{Color, Ink, Item, List, Place, Solid, Wants};
use jde_types::{
    Header, LaserScan, Mission, Movers, Pose2D, RangeRing, Route, Scenery, Target, Text, Thing, Time,
};

use super::super::draw_list::Pixels;
use super::super::models::Payload;
use super::super::scene_data::{Camera, RobotData, RouteData, SceneData};

fn thing(
    name: &str,
    form: u8,
    [x, y, theta]: [f64; 3],
    [length, width, height]: [f32; 3],
    rgb: [u8; 3],
) -> Thing {
    Thing {
        name: Text::truncated(name),
        pose: Pose2D::new(x, y, theta),
        length,
        width,
        height,
        form,
        red: rgb[0],
        green: rgb[1],
        blue: rgb[2],
    }
}

/// A room of 8 x 6 m with a table, a ball, a person, and a robot that faces them.
pub(super) fn room() -> SceneData {
    let quarter = std::f64::consts::FRAC_PI_2;
    let wall = [207, 199, 180];
    let mut scenery = Box::<Scenery>::default();
    for still in [
        thing("wall", Thing::BOX, [3.0, -3.0, 0.0], [8.0, 0.0, 2.5], wall),
        thing("wall", Thing::BOX, [3.0, 3.0, 0.0], [8.0, 0.0, 2.5], wall),
        thing("wall", Thing::BOX, [7.0, 0.0, quarter], [6.0, 0.0, 2.5], wall),
        thing("wall", Thing::BOX, [-1.0, 0.0, quarter], [6.0, 0.0, 2.5], wall),
        thing(
            "table",
            Thing::BOX,
            [4.5, 1.6, 0.3],
            [1.6, 0.8, 0.75],
            [138, 95, 60],
        ),
        thing(
            "pillar",
            Thing::CYLINDER,
            [4.6, -1.4, 0.0],
            [0.4, 0.4, 2.5],
            [190, 192, 196],
        ),
    ] {
        scenery.things.push(still).unwrap();
    }
    let mut movers = Box::<Movers>::default();
    for mover in [
        thing(
            "orange ball",
            Thing::BALL,
            [2.6, -0.6, 0.0],
            [0.22, 0.22, 0.22],
            [240, 124, 24],
        ),
        thing(
            "anna",
            Thing::PERSON,
            [3.4, 0.6, 2.6],
            [0.5, 0.5, 1.72],
            [47, 127, 107],
        ),
    ] {
        movers.things.push(mover).unwrap();
    }
    let mut scan = Box::new(LaserScan {
        header: Header::new(Time::default(), "laser"),
        angle_min: -std::f32::consts::FRAC_PI_2,
        angle_max: 1.553_343,
        angle_increment: 0.017453292,
        range_max: 8.0,
        ..LaserScan::default()
    });
    for beam in 0..180_usize {
        // The legs of a person, and a door without an echo.
        let range = match beam {
            88..=91 => 2.2,
            94..=97 => 2.25,
            120..=134 => f32::INFINITY,
            _ => 3.0 + 0.8 * (beam as f32 * 0.05).sin(),
        };
        scan.ranges.push(range).unwrap();
    }
    let mut ring = Box::new(RangeRing {
        field_of_view: std::f32::consts::FRAC_PI_6,
        max_range: 5.0,
        ..RangeRing::default()
    });
    for (theta, range) in [
        (0.87_f64, 1.4_f32),
        (0.17, 2.1),
        (-0.17, 2.0),
        (-0.87, f32::INFINITY),
    ] {
        let at = Pose2D::new(0.05 + 0.125 * theta.cos(), 0.138 * theta.sin(), theta);
        ring.poses.push(at).unwrap();
        ring.ranges.push(range).unwrap();
    }
    let mut robot = RobotData {
        name: "pioneer".to_owned(),
        pose: Some(Pose2D::new(1.0, 0.0, 0.15)),
        lasers: vec![("pioneer.laser".to_owned(), scan)],
        sonars: vec![("pioneer.sonars".to_owned(), ring)],
        carries: Payload {
            lasers: vec![Pose2D::new(0.018, 0.0, 0.0)],
            head: Some([0.3, 0.05]),
        },
        ..RobotData::default()
    };
    for step in 0..60_u64 {
        let part = step as f64 / 59.0;
        let pose = Pose2D::new(part, -0.8 * (1.0 - part) * (part * 4.0).cos(), 0.0);
        robot.trail.add(step, [pose.x, pose.y]);
    }
    let mut route = Route::EMPTY;
    for (x, y) in [(1.6, -1.8), (5.6, -0.6), (5.8, 2.2)] {
        route.poses.push(Pose2D::new(x, y, 0.0)).unwrap();
    }
    let mission = Mission {
        total: 3,
        reached: 1,
        target: Pose2D::new(5.6, -0.6, 0.0),
        ..Mission::default()
    };
    let solids = vec![
        Solid::Box {
            place: Place {
                at: [2.0, 1.8, 0.2],
                turned: [0.0, 0.0, 0.5],
            },
            size: [0.4, 0.4, 0.4],
            color: Color::Ink(Ink::Good),
        },
        Solid::Arrow {
            from: [1.0, 0.0, 0.6],
            to: [1.9, 0.7, 0.6],
            color: Color::Ink(Ink::Bad),
        },
        Solid::Sphere {
            center: [2.0, 1.8, 0.65],
            radius: 0.2,
            color: Color::Exact([90, 160, 240, 120]),
        },
        Solid::Label {
            at: [2.0, 1.8, 0.95],
            text: "a panel's own".to_owned(),
            color: Color::Ink(Ink::Good),
        },
    ];
    let scene = Item::Scene {
        id: "field".to_owned(),
        frame: "odom".to_owned(),
        solids,
        wants: Wants::default(),
    };
    let lost = Item::Scene {
        id: "lost".to_owned(),
        frame: "gripper".to_owned(),
        solids: Vec::new(),
        wants: Wants::default(),
    };
    let list = List {
        time: 0,
        items: vec![scene, lost],
    };
    let mut seen = SceneData {
        robots: vec![robot],
        cameras: vec![Camera {
            name: "camera.image".to_owned(),
            robot: 0,
            on_head: true,
            at: Vec3::ZERO,
            yaw: 0.0,
            field: 0.83,
            pixels: Arc::new(stripes()),
        }],
        targets: vec![("goon".to_owned(), Target::at(mission.target))],
        missions: vec![("example".to_owned(), mission)],
        routes: vec![RouteData::route("example.route", &route, 1)],
        panels: vec![("vff".to_owned(), Arc::new(list))],
        ..SceneData::default()
    };
    seen.world.scenery = Some(scenery);
    seen.world.movers = Some(movers);
    seen
}

fn stripes() -> Pixels {
    let (width, height) = (32_u32, 24_u32);
    let pixel = |at: u32| {
        let (x, y) = (at % width, at / width);
        [
            (x * 8) as u8,
            (y * 10) as u8,
            if (x / 4 + y / 4) % 2 == 0 { 60 } else { 190 },
            255,
        ]
    };
    Pixels {
        picture: crate::picture::Picture {
            size: [width, height].map(|side| side as usize),
            rgba: (0..width * height).flat_map(pixel).collect(),
        },
        stamp: 1,
    }
}
