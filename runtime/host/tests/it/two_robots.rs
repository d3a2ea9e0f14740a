//! The delivered application with two robots: each robot has a winner of its own, and one robot has no
//! father.

use jde_host::{Lockstep, Options};
use jde_records::event::Outcome;
use jde_types::Truth;
use std::path::Path;

use crate::delivered::{self, ROOT, SECOND};

#[test]
fn r13_two_robots_drive_at_once_and_neither_waits_for_the_other() {
    let plugins = delivered::plugins();
    let file = Path::new(ROOT).join("apps/two-robots.toml");
    let application = jde_app::load(&file, &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    assert_eq!(application.warnings(), [""; 0]);
    let mut running =
        Lockstep::start(application, &plugins, Options::default()).unwrap_or_else(|error| panic!("{error}"));
    let handle = running.handle();
    let truth = |robot: &str| -> Truth {
        let truth = handle.value(&format!("{robot}.truth")).expect("it is exported");
        truth.expect("it was written")
    };
    running.run_until(2 * SECOND);
    let (left, right) = (truth("left"), truth("right"));
    running.run_until(4 * SECOND);
    for (name, before) in [("left", left), ("right", right)] {
        let now = truth(name);
        let distance = (now.pose.x - before.pose.x).hypot(now.pose.y - before.pose.y);
        assert!(
            distance > 0.2,
            "the {name} robot drove {distance} m in two seconds"
        );
    }
    let snapshot = handle.snapshot();
    for group in ["roots/left", "roots/right", "guide/base", "crew/base"] {
        let group = snapshot
            .groups
            .iter()
            .find(|known| known.name == group)
            .expect("the group exists");
        assert!(group.winner.is_some(), "{} has no winner", group.name);
    }
    let outcome = running.run_until(90 * SECOND);
    assert_eq!(outcome, Some(Outcome::Done));
    assert_eq!((truth("left").collisions, truth("right").collisions), (0, 0));
}
