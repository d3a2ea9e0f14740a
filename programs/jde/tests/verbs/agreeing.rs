//! What the parts of an application must agree on: `jde check` names those that do not, and none of the shipped ones.

use std::fs;

use crate::support::{jde_with_plugins, output_of, root};

/// Applications of which `jde check` says something that is so: one shows schemas with the periods of the paper, one has a head
/// that no guard judges.
const WARNED: [&str; 2] = ["colors", "family"];

/// Returns the warnings about an application.
fn warnings(path: &str) -> Vec<String> {
    let output = output_of(&mut jde_with_plugins(&["check", path]));
    assert_eq!(output.status, Some(0), "{output:?}");
    warnings_in(&output.err)
}

/// The lines that begin with the word.
fn warnings_in(output: &str) -> Vec<String> {
    let lines = output.lines().filter(|line| line.starts_with("warning: "));
    lines.map(str::to_owned).collect()
}

/// An application beside others: its text with paths of this machine.
fn shipped(name: &str) -> String {
    let text = fs::read_to_string(root().join(format!("apps/{name}.toml"))).expect("the application exists");
    text.replace("\"../worlds", &format!("\"{}/worlds", root().display()))
}

/// Returns the warnings about an application of this text.
fn warnings_of(text: &str) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("edited.toml");
    fs::write(&file, text).expect("the folder is writable");
    warnings(&file.display().to_string())
}

/// Returns the text with this value of a key of a schema.
fn edited(text: &str, name: &str, key: &str, value: &str) -> String {
    let begin = text
        .find(&format!("[schemas.{name}]"))
        .expect("the schema is there");
    let (before, section) = text.split_at(begin);
    let section: Vec<&str> = section.lines().collect();
    let end = section
        .iter()
        .position(|line| line.is_empty())
        .unwrap_or(section.len());
    let (own, after) = section.split_at(end);
    let others = own.iter().filter(|line| !line.starts_with(key));
    let own: Vec<&str> = others.copied().collect();
    format!(
        "{before}{}\n{key} = {value}\n{}",
        own.join("\n"),
        after.join("\n")
    )
}

#[test]
fn the_parts_of_shipped_applications_agree() {
    let mut checked = 0;
    for entry in fs::read_dir(root().join("apps")).expect("the folder is there") {
        let path = entry.expect("an entry").path();
        let output = output_of(&mut jde_with_plugins(&["check", &path.display().to_string()]));
        // The tests do not have all plugins.
        let is_warned = WARNED.iter().any(|name| path.ends_with(format!("{name}.toml")));
        let is_application = path.extension().is_some_and(|end| end == "toml") && !is_warned;
        if is_application && output.status == Some(0) {
            let found = warnings_in(&output.err);
            assert_eq!(found, [""; 0], "{}", path.display());
            checked += 1;
        }
    }
    assert!(checked > 13, "{checked}");
}

#[test]
fn r7_r12_r18_parts_that_do_not_agree_are_named_with_their_lines_and_what_to_do() {
    let text = shipped("navigate");
    for (name, key, value, words) in [
        (
            "guard",
            "mount",
            "{ x = 0.1 }",
            "say where the sensor of `robot.laser` is: state the same in both",
        ),
        (
            "guard",
            "footprint",
            "{ radius = 0.3 }",
            "are different outlines of the robot that `robot.velocity` moves",
        ),
        (
            "guard",
            "margin",
            "0.05",
            "`guard.margin` is 0.05 m, and `follow.margin` is 0.05 m in line",
        ),
        (
            "guard",
            "deceleration",
            "0.2",
            "`follow.ax_max` is 0.3 m/s2, and `guard.deceleration` is 0.2 m/s2 in line",
        ),
        (
            "robot",
            "velocity_limits",
            "{ linear = { x = 0.3 } }",
            "`follow.vx_max` is 0.4 m/s, and `robot.velocity_limits` is 0.3 m/s in line",
        ),
        (
            "robot",
            "velocity_limits",
            "{ linear = { x = 0.3 } }",
            "`explore.vx_max` is 0.4 m/s, and `robot.velocity_limits` is 0.3 m/s in line",
        ),
    ] {
        let found = warnings_of(&edited(&text, name, key, value));
        assert!(
            found.iter().any(|line| line.contains(words)),
            "`{words}` is not in {found:?}"
        );
    }
}

#[test]
fn what_agrees_in_another_form_is_no_contradiction() {
    let corners = "[[0.21, 0.155], [-0.21, 0.155], [-0.21, -0.155], [0.21, -0.155]]";
    let turned = "[[-0.21, 0.155], [-0.21, -0.155], [0.21, -0.155], [0.21, 0.155]]";
    let text = shipped("follow-person");
    assert_eq!(text.matches(corners).count(), 2);
    assert_eq!(warnings_of(&text.replacen(corners, turned, 1)), [""; 0]);
    // The guard iterates with each scan, whatever its period.
    let imports = r#"{ surroundings = { from = "guard.surroundings", stale = "10ms" }, pose = "robot.odometry", mission = "navigate.mission" }"#;
    let found = warnings_of(&edited(&shipped("navigate"), "recover", "imports", imports));
    assert_eq!(found, [""; 0]);
}
