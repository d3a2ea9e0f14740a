//! The bodies that windows draw, of two robots in one application.

use egui_kittest::Harness;
use jde_types::Body;

use super::common::{Robot, plugins, until};
use crate::session::WindowSession;

/// A Jackal and a TurtleBot in one world, each with a schema that drives it.
const TWO: &str = r#"
name = "two"

[roots.left]
members = ["left-stop"]

[roots.right]
members = ["right-stop"]

[schemas.left]
type  = "sim/robot"
model = "jackal"
world = "../worlds/two-robots.toml"

[schemas.right]
type  = "sim/robot"
model = "turtlebot4"
world = "../worlds/two-robots.toml"

[schemas.left-stop]
type      = "stop"
imports   = { laser = "left.laser" }
actuators = { base = "left.velocity" }

[schemas.right-stop]
type      = "stop"
imports   = { laser = "right.laser" }
actuators = { base = "right.velocity" }
"#;

#[test]
fn each_robot_and_the_panels_of_its_schemas_have_its_own_body() {
    let robot = Robot::linked(TWO, plugins());
    let mut harness = Harness::builder().build_ui_state(
        |_, session: &mut WindowSession| session.begin_frame(),
        robot.session(),
    );
    fn bodies(harness: &Harness<'_, WindowSession>) -> [Option<Body>; 4] {
        ["left", "left-stop", "right", "right-stop"].map(|schema| harness.state().body(schema))
    }
    until(&mut harness, |harness| {
        bodies(harness).iter().all(Option::is_some)
    });
    let [left, left_stop, right, right_stop] = bodies(&harness).map(Option::unwrap);
    assert_eq!((left, right), (left_stop, right_stop));
    assert_eq!((left.footprint.points.len(), right.footprint.radius), (4, 0.171));
    assert_eq!((left.laser("laser").x, right.laser("laser").x), (-0.065, -0.04));
}
