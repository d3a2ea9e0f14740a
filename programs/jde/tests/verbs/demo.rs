//! `jde demo` as a script runs it.

use crate::support::{jde_with_plugins, json, output_of};

#[test]
fn the_demonstration_reaches_its_targets_and_writes_a_picture_and_its_decisions() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["demo", "--headless", "--lockstep", "--seed", "1", "--json"];
    let demo = output_of(jde_with_plugins(&args).current_dir(&folder));
    assert_eq!(demo.status, Some(0), "{}", demo.err);
    let summary = json(&demo.out);
    assert!(summary["targets"].as_u64().unwrap() >= 4, "{summary}");
    assert_eq!(summary["targets"], summary["reached"]);
    assert_eq!(summary["collisions"], 0);
    for key in [
        "min_clearance_m",
        "takeovers",
        "worst_takeover_us",
        "sim_seconds",
        "wall_seconds",
    ] {
        assert!(summary[key].is_number(), "{key}: {summary}");
    }
    let decisions = std::fs::read(folder.path().join("target/demo/decisions.jsonl")).unwrap();
    assert!(decisions.ends_with(b"}\n"));
    let picture = std::fs::read(folder.path().join("target/demo/path.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    assert_eq!(demo.out.lines().count(), 1);
    let digest = format!(
        "decisions_sha256: {}\n",
        summary["decisions_sha256"].as_str().unwrap()
    );
    assert!(
        demo.err.contains(&digest) && demo.err.contains("target 1 of"),
        "{}",
        demo.err
    );
    assert!(!demo.err.contains('\u{1b}'), "no colours in a pipe");
}

#[test]
fn an_output_folder_that_cannot_be_written_is_reported_before_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let demo = output_of(&mut jde_with_plugins(&[
        "demo",
        "--headless",
        "--out",
        file.to_str().unwrap(),
    ]));
    assert_eq!(demo.status, Some(1), "{}", demo.out);
    assert!(
        demo.err.starts_with("error: ") && demo.err.contains("is a file, where a folder is needed"),
        "{}",
        demo.err
    );
    assert!(!demo.out.contains("target 1"), "{}", demo.out);
}
