//! `jde ready`: it says yes only of applications of which it knows that nothing acts.

use crate::attached::{Sandbox, navigation};
use crate::support::app;

#[test]
fn a_machine_without_applications_is_ready() {
    let sandbox = Sandbox::new();
    assert!(sandbox.run_ok(&["ready"]).contains("no application runs"));
    let other = sandbox.run(&["ready", "--app", "robot9"]);
    assert_eq!(other.status, Some(1), "{other:?}");
    assert!(
        other.out.contains("no application is called `robot9`"),
        "{other:?}"
    );
    let process = sandbox.folder().join("4194305");
    std::fs::create_dir(&process).expect("the folder is writable");
    std::fs::write(process.join("cmdline"), "jde\0run\0robot.toml\0").expect("the folder is writable");
    let silent = sandbox.run(&["ready"]);
    assert_eq!(silent.status, Some(1), "{silent:?}");
    assert!(
        silent.out.contains("process 4194305 runs `jde run`"),
        "{silent:?}"
    );
}

#[test]
fn an_application_that_acts_is_not_ready_nor_one_whose_mission_is_under_way_though_it_stands() {
    let sandbox = Sandbox::new();
    let running = navigation(&sandbox);
    let acting = sandbox.run(&["ready"]);
    assert_eq!(acting.status, Some(1), "{acting:?}");
    assert!(acting.out.contains(" acts"), "{acting:?}");
    sandbox.run_ok(&["stop", "--all"]);
    let stopped = sandbox.run(&["ready", "--json"]);
    assert_eq!(stopped.status, Some(1), "{stopped:?}");
    let answer = crate::support::json(&stopped.out);
    assert_eq!(answer["ready"], false);
    let reasons = answer["applications"][0]["reasons"].to_string();
    assert!(reasons.contains("is under way: "), "{reasons}");
    assert!(!reasons.contains(" acts"), "{reasons}");
    running.signal("STOP");
    let silent = sandbox.run(&["ready", "--wait", "1ms"]);
    assert_eq!(silent.status, Some(1), "no answer is no yes: {silent:?}");
}

#[test]
fn an_application_with_nothing_to_do_is_ready_if_its_conditions_are_true() {
    let sandbox = Sandbox::new();
    // Its only motor schema brakes before obstacles, and none is near.
    let text = format!(
        "name = \"robot\"\nroots = [\"stop\"]\n[schemas.pioneer]\ntype = \"sim/robot\"\nworld = {:?}\n\
         [schemas.stop]\ntype = \"stop\"\nimports = {{ laser = \"pioneer.laser\" }}\n\
         actuators = {{ base = \"pioneer.velocity\" }}\n",
        app("room-world.toml")
    );
    let file = sandbox.folder().join("robot.toml");
    std::fs::write(&file, text).expect("the folder is writable");
    let _running = sandbox.start(file.to_str().expect("UTF-8"), &[]);
    sandbox.run_ok(&["ready", "--wait"]);
    sandbox.run_ok(&["ready", "--also", "pioneer.odometry.pose.pose.position.x < 2.0"]);
    let other = sandbox.run(&["ready", "--also", "pioneer.odometry.pose.pose.position.x > 2.0"]);
    assert_eq!(other.status, Some(1), "{other:?}");
    assert!(other.out.contains(" is not true"), "{other:?}");
    let unknown = sandbox.run(&["ready", "--also", "gripper.holding"]);
    assert_eq!(unknown.status, Some(2), "{unknown:?}");
    for (condition, named) in [("faults == 0.0", "`faults` is"), ("fault", "`fault` is")] {
        let past = sandbox.run(&["ready", "--also", condition]);
        assert_eq!(past.status, Some(2), "nobody counted them: {past:?}");
        assert!(past.err.contains(named), "{past:?}");
    }
}
