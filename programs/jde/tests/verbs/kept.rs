//! What earlier versions of jde wrote and what was written for them still works: each folder of `tests/kept` has the files of
//! one version, which nobody edits (docs/releases.md).

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::{jde, jde_with_plugins, json, output_of, plugins, root};

/// Returns the folder of each version.
fn versions() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/kept");
    let found: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    assert!(!found.is_empty());
    found
}

/// Copies the files of a version, and builds its plugins beside their applications with the present headers.
fn build(version: &Path) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let copied = Command::new("cp")
        .arg("-r")
        .arg(version.join("."))
        .arg(folder.path())
        .status();
    assert!(copied.unwrap().success());
    for (language, compiler, standard, source) in [
        ("c", "cc", "-std=c11", "schema.c"),
        ("cpp", "c++", "-std=c++17", "plugin.cpp"),
    ] {
        let output = Command::new(compiler)
            .args([standard, "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-I"])
            .arg(root().join("include"))
            .args(["-o", &format!("libcreep_{language}.so"), source, "-lm"])
            .current_dir(folder.path().join(language))
            .output()
            .expect("compilers named cc and c++ are installed");
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    folder
}

#[test]
fn kept_schemas_in_c_and_cplusplus_compile_and_their_applications_drive() {
    for version in versions() {
        let folder = build(&version);
        for language in ["c", "cpp"] {
            let mut command = jde_with_plugins(&["run", "app.toml", "--lockstep", "--for", "15s", "--json"]);
            let run = output_of(command.current_dir(folder.path().join(language)));
            assert_eq!(run.status, Some(0), "{version:?}: {}", run.err);
            assert!(
                run.err.contains(&format!("nobody -> creep-{language}")),
                "{}",
                run.err
            );
            let summary = json(&run.out);
            let clearance = summary["min_clearance_m"].as_f64().unwrap();
            assert!(summary["collisions"] == 0 && clearance < 0.6, "{summary}");
        }
    }
}

#[test]
fn kept_recordings_are_read() {
    for version in versions() {
        let file = version.join("drive.mcap");
        let file = file.to_str().unwrap();
        let read = |args: &[&str]| {
            let output = output_of(&mut jde(args));
            assert_eq!(output.status, Some(0), "{args:?}: {}", output.err);
            output.out
        };
        let info = read(&["info", file]);
        let name = version.file_name().unwrap().to_str().unwrap();
        assert!(info.contains(&format!("by jde {name}, with app.toml")), "{info}");
        let why = read(&["why", "did", "creep-c", "win", "--in", file]);
        assert!(
            why.contains("creep-c is ready") || why.contains("the only one ready"),
            "{why}"
        );
        let states = read(&["ps", "--in", file, "--at", "2s"]);
        assert!(states.contains("family/hijo2"), "{states}");
        let pose = read(&[
            "get",
            "pioneer.odometry.pose.pose.position.x",
            "--in",
            file,
            "--at",
            "2s",
        ]);
        assert!(pose.trim().ends_with(" m"), "{pose}");
        let page = tempfile::tempdir().unwrap();
        read(&[
            "report",
            file,
            "-o",
            page.path().join("page.html").to_str().unwrap(),
        ]);
    }
}

#[test]
fn results_have_the_names_of_kept_ones() {
    for version in versions() {
        let folder = build(&version);
        let out = folder.path().join("new");
        let path = std::env::join_paths([&folder.path().join("c"), plugins()]).unwrap();
        let mut command = jde(&["experiment", "experiment.toml", "--out", "new"]);
        let run = output_of(command.current_dir(folder.path()).env("JDE_PLUGIN_PATH", path));
        assert_eq!(run.status, Some(0), "{}", run.err);
        let first = |folder: &Path, file: &str| {
            let text = fs::read_to_string(folder.join(file)).unwrap();
            text.lines().next().unwrap().to_owned()
        };
        let kept = folder.path().join("results");
        assert_eq!(first(&kept, "results.csv"), first(&out, "results.csv"));
        let [kept, new] = [&kept, &out]
            .map(|folder| -> Value { serde_json::from_str(&first(folder, "results.jsonl")).unwrap() });
        for name in kept.as_object().unwrap().keys() {
            assert!(!new[name].is_null(), "{name} is missing: {new}");
        }
    }
}

#[test]
fn results_of_another_version_are_neither_continued_nor_joined_and_both_versions_are_named() {
    let folder = build(&versions()[0]);
    let state = folder.path().join("results/experiment.json");
    let text = fs::read_to_string(&state).unwrap();
    let mut stated: Value = serde_json::from_str(&text).unwrap();
    stated["file"] = folder.path().join("experiment.toml").to_str().unwrap().into();
    let path = std::env::join_paths([&folder.path().join("c"), plugins()]).unwrap();
    for (version, made_by) in [("0.0.9", "jde 0.0.9"), ("", "an earlier jde")] {
        stated["version"] = version.into();
        fs::write(&state, stated.to_string()).unwrap();
        let words = format!(
            "are those of {made_by}, and this is jde {}",
            env!("CARGO_PKG_VERSION")
        );
        for args in [
            &["experiment", "experiment.toml", "--out", "results", "--resume"][..],
            &["experiment", "merge", "results", "--out", "new"],
        ] {
            let output = output_of(jde(args).current_dir(folder.path()).env("JDE_PLUGIN_PATH", &path));
            assert_eq!(output.status, Some(2), "{args:?}: {}", output.err);
            assert!(output.err.contains(&words), "{}", output.err);
        }
    }
}
