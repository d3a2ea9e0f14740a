//! The cost of every sense: lasers, the ring of sonars, pictures, and the steps of a busy world.
//!
//! Run with `cargo bench -p jde-sim`.

use std::fmt::Write;
use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use jde_sim::{CameraConfig, LaserConfig, RobotConfig, RobotId, SonarConfig, Twist2, World};

fn world(name: &str) -> (World, RobotId) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../worlds")
        .join(name);
    let mut world = World::load(path, 1).expect("the world is sound");
    let robot = world
        .add_robot("pioneer", RobotConfig::default())
        .expect("it has a start for the pioneer");
    world.advance_to(3_000_000_000);
    (world, robot)
}

/// Ten people who walk and ten balls that a robot on its rounds pushes about.
fn busy() -> (World, RobotId) {
    let mut text = String::from(
        "walls = [{ points = [[0, 0], [12, 0], [12, 12], [0, 12]], closed = true }]
         robots = { pioneer = { start = { x = 6, y = 6 } } }\n",
    );
    for index in 0..10 {
        let at = f64::from(index) + 1.0;
        let (even, odd) = (4.6 + f64::from(index % 3), 7.4);
        writeln!(
            text,
            "[[people]]\nway = [[{at}, 1], [{at}, 11]]\nspeed = 0.{}\n[[balls]]\ncenter = [{}, {}]\nradius = 0.11",
            index + 3,
            at + 0.6,
            if index % 2 == 0 { even } else { odd }
        )
        .expect("a text grows");
    }
    let mut world = World::parse(&text, "busy.toml", 1).expect("the world is sound");
    let robot = world
        .add_robot("pioneer", RobotConfig::default())
        .expect("its start is free");
    world
        .command(robot, Twist2::new(0.6, 0.4))
        .expect("a finite command");
    (world, robot)
}

fn lasers(criterion: &mut Criterion) {
    let (world, robot) = world("office.toml");
    for (name, beams, field_of_view, sigma) in [
        ("laser, 180 beams", 180, 180f64, 0.005),
        ("laser, 180 beams, no noise", 180, 180.0, 0.0),
        ("laser, 360 beams", 360, 360.0, 0.005),
    ] {
        let laser = LaserConfig {
            beams,
            field_of_view: field_of_view.to_radians(),
            sigma,
            ..LaserConfig::default()
        };
        let mut ranges = vec![0.0; beams];
        criterion.bench_function(name, |bench| {
            bench.iter(|| world.laser(robot, black_box(&laser), &mut ranges));
        });
    }
    let ring = SonarConfig::default();
    let mut echoes = vec![0.0; ring.mounts.len()];
    criterion.bench_function("sonars, 16 cones of 7 rays", |bench| {
        bench.iter(|| world.sonars(robot, black_box(&ring), &mut echoes));
    });
}

fn cameras(criterion: &mut Criterion) {
    for name in ["office.toml", "hall.toml"] {
        let (world, robot) = world(name);
        for (width, height) in [(320, 240), (640, 480)] {
            let camera = CameraConfig {
                width,
                height,
                ..CameraConfig::default()
            };
            let mut picture = vec![0; camera.bytes()];
            criterion.bench_function(&format!("camera, {width} x {height}, {name}"), |bench| {
                bench.iter(|| world.picture(robot, black_box(&camera), &mut picture));
            });
        }
    }
}

fn steps(criterion: &mut Criterion) {
    let (mut world, robot) = world("office.toml");
    world
        .command(robot, Twist2::new(0.0, 0.5))
        .expect("a finite command");
    criterion.bench_function("one second of the office", |bench| {
        bench.iter(|| world.advance_to(world.now() + 1_000_000_000));
    });
    let (mut world, _) = busy();
    criterion.bench_function("a step with 10 people and 10 balls", |bench| {
        bench.iter(|| world.advance_to(world.now() + 10_000_000));
    });
}

criterion_group!(benches, lasers, cameras, steps);
criterion_main!(benches);
