//! The cost of the office: one scan of 180 beams, one ring of 16 sonars, one second of simulated time.
//!
//! Run with `cargo bench -p jde-sim`.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use jde_sim::{LaserConfig, RobotConfig, RobotId, SonarConfig, Twist2, World};

fn office() -> (World, RobotId) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../worlds/office.toml");
    let mut world = World::load(path, 1).expect("the office is a sound world");
    let robot = world
        .add_robot("pioneer", RobotConfig::default())
        .expect("the office has a start for the pioneer");
    (world, robot)
}

fn costs(criterion: &mut Criterion) {
    let (mut world, robot) = office();
    let laser = LaserConfig::default();
    let exact = LaserConfig {
        sigma: 0.0,
        ..LaserConfig::default()
    };
    let mut ranges = vec![0.0; laser.beams];
    criterion.bench_function("laser, 180 beams", |bench| {
        bench.iter(|| world.laser(robot, black_box(&laser), &mut ranges));
    });
    criterion.bench_function("laser, 180 beams, no noise", |bench| {
        bench.iter(|| world.laser(robot, black_box(&exact), &mut ranges));
    });
    let ring = SonarConfig::default();
    let mut echoes = vec![0.0; ring.mounts.len()];
    criterion.bench_function("sonars, 16 cones of 7 rays", |bench| {
        bench.iter(|| world.sonars(robot, black_box(&ring), &mut echoes));
    });
    world.command(robot, Twist2::new(0.0, 0.5)).expect("finite");
    criterion.bench_function("one second of the office", |bench| {
        bench.iter(|| world.advance_to(world.now() + 1_000_000_000));
    });
}

criterion_group!(benches, costs);
criterion_main!(benches);
