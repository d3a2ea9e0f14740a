//! Learned policies behind a guard, and policies that are broken.

use std::fs;
use std::path::{Path, PathBuf};

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

/// Copies an application of the tests to a folder, without its guard.
fn without_guard(application: &str, folder: &Path) -> String {
    let file = folder.join("bare.toml");
    let text = fs::read_to_string(app(application)).expect("the application is there");
    let bare = text.replace("root  = { guard = \"guard\", retry = \"100ms\" }\n", "");
    assert_ne!(bare, text, "the guard is gone");
    let here = root().display().to_string();
    fs::write(&file, bare.replace("../../../..", &here)).expect("the folder is writable");
    file.display().to_string()
}

#[test]
fn without_a_guard_the_policy_that_attacks_collides() {
    // Otherwise the test above would show nothing.
    let folder = tempfile::tempdir().expect("a folder");
    let result = drive(&without_guard("policy.toml", folder.path()), "attack", 1);
    assert!(result["collisions"].as_u64() > Some(0), "{result}");
}

/// Drives straight ahead by chunks, which see nothing but the speed of the base. Returns the result and the recording.
fn drive_ahead(application: &str, folder: &Path) -> (Value, String) {
    let file = folder.join("ahead.mcap").display().to_string();
    let run = [
        "run",
        application,
        "--lockstep",
        "--json",
        "--for",
        "20s",
        "--record",
        &file,
        "--overwrite",
    ];
    let output = output_of(&mut jde_with_plugins(&run));
    assert_eq!(output.status, Some(0), "{output:?}");
    (json(&output.out), file)
}

#[test]
fn r18_each_command_of_a_chunk_is_judged_when_it_comes_due() {
    let folder = tempfile::tempdir().expect("a folder");
    let (result, file) = drive_ahead(&app("chunks.toml"), folder.path());
    assert_eq!(result["collisions"], 0, "{result}");
    // The selection after the refusal says which command it was.
    let why = output_of(&mut jde_with_plugins(&[
        "why", "nobody", "at", "15s", "--in", &file,
    ]));
    assert!(
        why.out.contains("command refused by the guard `guard`"),
        "{why:?}"
    );
    assert!(
        why.out.contains(" of 16 of chunk ") && why.out.contains(" s before"),
        "{why:?}"
    );
    let why = output_of(&mut jde_with_plugins(&[
        "why", "policy", "at", "0s", "--json", "--in", &file,
    ]));
    let steps = json(&why.out)["steps"].clone();
    assert_eq!(
        (&steps[0]["step"], &steps[0]["steps"]),
        (&1.into(), &16.into()),
        "{steps}"
    );
    // A replay decides the same, and so does another run.
    let same = output_of(&mut jde_with_plugins(&["replay", "--decide", &file, "--json"]));
    assert_eq!(same.status, Some(0), "{same:?}");
    assert_eq!(json(&same.out)["values"]["different"], 0, "{same:?}");
    let (again, _) = drive_ahead(&app("chunks.toml"), folder.path());
    assert_eq!(again["decisions_sha256"], result["decisions_sha256"]);
    assert!(result["decisions_sha256"].is_string(), "{result}");
    // Without the guard the same chunks collide.
    let bare = without_guard("chunks.toml", folder.path());
    assert!(drive_ahead(&bare, folder.path()).0["collisions"].as_u64() > Some(0));
}

#[test]
fn r11_a_network_that_is_slower_than_its_budget_is_an_overrun_of_its_schema_alone() {
    let file = format!("mind.file={}", policies().join("slow.toml").display());
    let run = [
        "run",
        &app("chunks.toml"),
        "--json",
        "--for",
        "5s",
        "--set",
        &file,
    ];
    let output = output_of(&mut jde_with_plugins(&run));
    assert_eq!(output.status, Some(0), "{output:?}");
    let result = json(&output.out);
    let of = |name: &str| {
        let schemas = result["schemas"].as_array().expect("schemas");
        let schema = schemas.iter().find(|schema| schema["schema"] == name);
        schema.expect("it is a schema")
    };
    assert!(of("mind")["overruns"].as_u64() > Some(0), "{result}");
    assert_eq!(of("mind")["faults"], 0, "{result}");
    assert!(of("policy")["iterations"].as_u64() > Some(10), "{result}");
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
