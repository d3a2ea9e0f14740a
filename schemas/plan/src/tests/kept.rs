//! What a path keeps of its target, and a planner over a reload.

use super::*;

#[test]
fn a_path_ends_with_the_heading_of_a_target_that_has_one() {
    let mut bench = bench(&map(&ROOM), LEFT_POINT, RIGHT_POINT);
    let end = |bench: &mut Bench<Plan>, target: Target| {
        bench.set("target", target);
        state(bench);
        poses(bench)
            .and_then(|poses| poses.last().copied())
            .expect("a path")
    };
    let goal = Pose2D::new(RIGHT_POINT.0, RIGHT_POINT.1, 2.0);
    let facing = end(&mut bench, Target::facing(goal));
    assert!((facing.theta - 2.0).abs() < 1e-9 && facing.distance_to(&goal) < 1e-9);
    let along = end(&mut bench, Target::at(goal));
    assert!(
        (-1.6..-0.5).contains(&along.theta),
        "down from the gap: {along:?}"
    );
}

#[test]
fn a_reload_keeps_the_obstacles_that_were_seen() {
    let empty = map(&["...................."; 10]);
    let mut first = bench(&empty, LEFT_POINT, RIGHT_POINT);
    let straight = state(&mut first);
    see(&mut first, &ROOM);
    let around = state(&mut first);
    assert_ne!(around, straight);
    let saved = first.save().expect("it saves");
    let mut second = bench(&empty, LEFT_POINT, RIGHT_POINT);
    second.restore(&saved).expect("it restores");
    assert_eq!(state(&mut second), around, "out of sight");
}
