//! Learned policies behind a guard, and policies that are broken.

use std::fs;
use std::path::PathBuf;

use serde_json::Value;

use crate::support::{app, jde_with_plugins, json, output_of, root};

/// The folder of policies that were made for tests.
fn policies() -> PathBuf {
    root().join("robotics/policy/tests/data")
}

/// Drives with a policy for a minute, and returns the result.
fn drive(application: &str, policy: &str, seed: u32) -> Value {
    let file = format!(
        "policy.file={}",
        policies().join(policy).with_extension("toml").display()
    );
    let mut command = jde_with_plugins(&["run", application, "--lockstep", "--json", "--for", "60s"]);
    let output = output_of(command.args(["--set", &file, "--seed", &seed.to_string()]));
    assert_eq!(output.status, Some(0), "{output:?}");
    json(&output.out)
}

#[test]
fn behind_a_guard_no_weights_touch_anything() {
    for policy in ["attack", "random-1", "random-2"] {
        for seed in [1, 2] {
            let result = drive(&app("policy.toml"), policy, seed);
            assert_eq!(result["collisions"], 0, "{policy}, seed {seed}: {result}");
        }
    }
}

#[test]
fn without_a_guard_the_policy_that_attacks_collides() {
    // Otherwise the test above would show nothing.
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("bare.toml");
    let text = fs::read_to_string(app("policy.toml")).expect("the application is there");
    let bare = text.replace("root  = { guard = \"guard\", retry = \"100ms\" }\n", "");
    assert_ne!(bare, text, "the guard is gone");
    let here = root().display().to_string();
    fs::write(&file, bare.replace("../../../..", &here)).expect("the folder is writable");
    let result = drive(file.to_str().expect("the path is UTF-8"), "attack", 1);
    assert!(result["collisions"].as_u64() > Some(0), "{result}");
}

#[test]
fn a_broken_policy_does_not_start_and_its_line_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(policies().join("attack.toml")).expect("the policy is there");
    fs::write(folder.path().join("own.toml"), text).expect("the folder is writable");
    fs::write(folder.path().join("attack.onnx"), b"no network").expect("the folder is writable");
    let file = format!("policy.file={}", folder.path().join("own.toml").display());
    for verb in ["check", "run"] {
        let mut command = jde_with_plugins(&[verb, &app("policy.toml"), "--set", &file]);
        let output = output_of(&mut command);
        assert_eq!(output.status, Some(2), "{output:?}");
        assert!(output.err.contains("own.toml:2:11"), "{output:?}");
    }
}
