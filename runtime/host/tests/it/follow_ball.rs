//! The delivered application that finds a ball by camera and laser, in lockstep.

use jde_host::{Lockstep, Options};
use jde_records::event::Outcome;
use jde_types::{Mission, Truth};
use std::path::Path;

use crate::delivered::{self, ROOT, SECOND};

/// The centre of the ball in the hall, m.
const BALL: [f64; 2] = [4.9, 3.7];

#[test]
fn the_robot_finds_the_ball_behind_the_crate_and_stops_in_front_of_it() {
    let plugins = delivered::plugins();
    let file = Path::new(ROOT).join("apps/follow-ball.toml");
    let application = jde_app::load(&file, &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    let mut running =
        Lockstep::start(application, &plugins, Options::default()).unwrap_or_else(|error| panic!("{error}"));
    let handle = running.handle();
    let outcome = running.run_until(120 * SECOND).expect("it ends within its limit");
    drop(running);
    assert_eq!(outcome, Outcome::Done);
    let mission: Mission = handle
        .value("follower.mission")
        .expect("it is exported")
        .expect("it was written");
    assert_eq!((mission.state, mission.reached), (Mission::DONE, 1));
    let error = (mission.target.x - BALL[0]).hypot(mission.target.y - BALL[1]);
    assert!(error < 0.15, "the ball is {error} m from its reported position");
    let truth: Truth = handle
        .value("pioneer.truth")
        .expect("it is exported")
        .expect("it was written");
    let distance = (truth.pose.x - BALL[0]).hypot(truth.pose.y - BALL[1]);
    assert!((0.7..1.1).contains(&distance), "{distance} m");
    assert_eq!(truth.collisions, 0);
}
