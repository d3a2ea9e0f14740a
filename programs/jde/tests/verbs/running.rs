//! `jde run`: its output, summaries, files, exit statuses, and signals.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::support::{app, jde_with_plugins, json, output_of, pair, plugins};
use jde_watchdog::Watchdog;
use serde_json::Value;
use sha2::{Digest, Sha256};

fn digest(file: &Path) -> String {
    let digest = Sha256::digest(std::fs::read(file).expect("the file exists"));
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn r15_a_run_prints_every_takeover_with_its_reason() {
    let run = output_of(&mut jde_with_plugins(&[
        "run",
        &app("room.toml"),
        "--lockstep",
        "--seed",
        "1",
    ]));
    assert_eq!(run.status, Some(0), "{}\n{}", run.out, run.err);
    for part in [
        "guide/base: nobody -> goon  the only one ready",
        "target 1 of 2 reached",
        "room: the mission is done; 2 of 2 targets",
        "no contact",
    ] {
        assert!(run.out.contains(part), "{part}: {}", run.out);
    }
    assert!(!run.out.contains('\u{1b}'), "no colours in a pipe");
}

#[test]
fn r16_the_same_seed_gives_the_same_decisions_and_another_seed_others() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("deep/decisions.jsonl");
    let run = |seed: &str| {
        let app = app("room.toml");
        let file = file.to_str().unwrap();
        let args = [
            "run",
            &app,
            "--lockstep",
            "--json",
            "--seed",
            seed,
            "--decisions",
            file,
        ];
        json(&output_of(&mut jde_with_plugins(&args)).out)
    };
    let first = run("1");
    assert_eq!(first["decisions_sha256"], digest(&file).as_str());
    let again = run("1");
    assert_eq!(first["decisions_sha256"], again["decisions_sha256"]);
    assert_eq!(first["takeovers"], again["takeovers"]);
    assert_ne!(first["decisions_sha256"], run("2")["decisions_sha256"]);
    let decisions = std::fs::read_to_string(&file).unwrap();
    for line in decisions.lines() {
        let decision: Value = serde_json::from_str(line).expect("every line is JSON");
        assert!(!decision["reason"].as_str().unwrap().is_empty(), "{line}");
    }
}

#[test]
fn with_json_only_the_summary_goes_to_standard_output() {
    let run = output_of(&mut jde_with_plugins(&[
        "run",
        &app("room.toml"),
        "--lockstep",
        "--json",
    ]));
    assert_eq!(run.out.lines().count(), 1, "{}", run.out);
    let summary = json(&run.out);
    assert_eq!(
        (&summary["outcome"], &summary["targets"], &summary["reached"]),
        (&"done".into(), &2.into(), &2.into())
    );
    assert_eq!(summary["collisions"], 0);
    assert!(summary["min_clearance_m"].as_f64().unwrap() > 0.0);
    let base = summary["groups"]
        .as_array()
        .unwrap()
        .iter()
        .find(|group| group["group"] == "guide/base")
        .unwrap();
    let won: f64 = base["winners"]
        .as_array()
        .unwrap()
        .iter()
        .map(|share| share["seconds"].as_f64().unwrap())
        .sum();
    let total = won + base["nobody_seconds"].as_f64().unwrap();
    let seconds = summary["sim_seconds"].as_f64().unwrap();
    assert!(
        (total - seconds).abs() < 0.1,
        "the groups cover {total} of {seconds} s"
    );
    assert!(run.err.contains("the mission is done"), "{}", run.err);
}

#[test]
fn an_unfinished_mission_fails_and_a_time_limit_without_a_mission_succeeds() {
    let run = output_of(&mut jde_with_plugins(&[
        "run",
        &app("room.toml"),
        "--lockstep",
        "--for",
        "1s",
    ]));
    assert_eq!(run.status, Some(1), "{}", run.err);
    assert!(
        run.out
            .contains("the time was up before the mission was done; 0 of 2 targets in 1.0 s"),
        "{}",
        run.out
    );
    let run = output_of(&mut jde_with_plugins(&[
        "run",
        &pair(),
        "--lockstep",
        "--for",
        "1s",
    ]));
    assert_eq!(run.status, Some(0), "{}", run.err);
    assert!(run.out.contains("the time is up in 1.0 s"), "{}", run.out);
}

#[test]
fn a_mission_without_a_target_is_not_done() {
    let args = ["run", &app("room.toml"), "--lockstep", "--for", "1s"];
    let run = |route| output_of(jde_with_plugins(&args).args(["--set", route]));
    let none = run("guide.route={ poses = [] }");
    assert_eq!(none.status, Some(1), "{}", none.err);
    let words = "the time was up before the mission was done; it had no target in 1.0 s";
    assert!(none.out.contains(words), "{}", none.out);
    let one = run("guide.route={ poses = [[4.0, 2.0, 0]] }");
    assert!(one.out.contains("; 0 of 1 target in 1.0 s"), "{}", one.out);
}

#[test]
fn picture_draws_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("way.png");
    let args = [
        "run",
        &app("room.toml"),
        "--lockstep",
        "--for",
        "3s",
        "--picture",
        file.to_str().unwrap(),
    ];
    output_of(&mut jde_with_plugins(&args));
    let picture = std::fs::read(&file).expect("the picture exists");
    assert!(picture.starts_with(b"\x89PNG") && picture.len() > 10_000);
}

#[test]
fn a_value_on_the_command_line_overrides_the_file() {
    let args = [
        "run",
        &app("room.toml"),
        "--lockstep",
        "--json",
        "--set",
        "guide.tolerance=4 m",
    ];
    let run = json(&output_of(&mut jde_with_plugins(&args)).out);
    assert!(
        run["sim_seconds"].as_f64().unwrap() < 2.0,
        "with this tolerance the targets are reached at once: {run}"
    );
}

#[test]
fn the_log_is_filtered_by_schema() {
    let run = |filter| {
        output_of(&mut jde_with_plugins(&[
            "run",
            &pair(),
            "--lockstep",
            "--for",
            "1s",
            "--log",
            filter,
        ]))
    };
    let listener = run("listener=info");
    assert!(listener.err.contains("listener: heard 1"), "{}", listener.err);
    assert!(!run("warn").err.contains("heard"));
    assert!(
        run("state=trace").err.contains("listener: from="),
        "{}",
        run("state=trace").err
    );
    let unknown = run("lisener=info");
    assert_eq!(unknown.status, Some(2));
    assert!(
        unknown.err.contains("did you mean `listener`?"),
        "{}",
        unknown.err
    );
}

#[test]
fn sigterm_ends_a_run_with_its_summary() {
    let _watchdog = Watchdog::for_test();
    let mut child = jde_with_plugins(&["run", &pair()])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut out = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    out.read_line(&mut line).unwrap();
    assert!(line.contains("-> listener"), "{line}");
    let kill = Command::new("kill")
        .args(["-TERM", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(kill.success());
    let mut rest = String::new();
    out.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{rest}");
    assert!(rest.contains("pair: stopped"), "{rest}");
}

#[test]
fn a_run_ignores_sighup_if_its_parent_does() {
    let _watchdog = Watchdog::for_test();
    let script = "trap '' HUP; exec \"$0\" run \"$1\" --for 2s";
    let mut child = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_jde"), &pair()])
        .env("JDE_PLUGIN_PATH", plugins())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut out = BufReader::new(child.stdout.take().unwrap());
    out.read_line(&mut String::new()).unwrap();
    let kill = Command::new("kill")
        .args(["-HUP", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(kill.success());
    let mut rest = String::new();
    out.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(rest.contains("pair: the time is up"), "{rest}");
}

#[test]
fn a_closed_pipe_ends_a_run_without_an_error() {
    let _watchdog = Watchdog::for_test();
    let mut command = jde_with_plugins(&["run", &pair()]);
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[test]
fn a_short_mission_is_completed_in_real_time() {
    let args = [
        "run",
        &app("room.toml"),
        "--json",
        "--speed",
        "4x",
        "--set",
        "guide.tolerance=1.8 m",
    ];
    let run = output_of(&mut jde_with_plugins(&args));
    let summary = json(&run.out);
    assert_eq!(
        (&summary["outcome"], &summary["reached"]),
        (&"done".into(), &2.into()),
        "{}",
        run.err
    );
}

#[test]
fn a_refused_run_overwrites_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let [picture, decisions, drive, other] =
        ["old.png", "old.jsonl", "old.mcap", "new.png"].map(|name| folder.path().join(name));
    for file in [&picture, &decisions, &drive] {
        std::fs::write(file, "old").unwrap();
    }
    let path = |file: &std::path::Path| file.to_str().unwrap().to_owned();
    for picture in [&picture, &other] {
        let mut run = jde_with_plugins(&["run", &pair(), "--lockstep", "--for", "1s"]);
        run.args(["--picture", &path(picture), "--decisions", &path(&decisions)]);
        // The file exists, and `--overwrite` is not given.
        let refused = output_of(run.args(["--record", &path(&drive)]));
        assert_eq!(refused.status, Some(2), "{refused:?}");
    }
    for file in [&picture, &decisions, &drive] {
        assert_eq!(std::fs::read(file).unwrap(), b"old", "{}", file.display());
    }
    assert!(!other.exists(), "the refused run created a file");
}

#[test]
fn r17_a_takeover_beyond_its_contract_is_a_fault_of_the_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("late.toml");
    let text = r#"
roots = ["sluggish", "other"]
[schemas.axis]
type = "fault/device"
[schemas.other]
type = "fault/motor"
actuators = { base = "axis.velocity" }
[schemas.sluggish]
type = "fault/motor"
actuators = { base = "axis.velocity" }
place = "check"
hang = "10s"
"#;
    std::fs::write(&file, text).expect("it is written");
    let recording = folder.path().join("late.mcap");
    let run = |options: &[&str]| {
        let mut command = jde_with_plugins(&["run", "--plain", "--set", "sluggish.trouble=dawdle"]);
        output_of(command.arg(&file).args(options))
    };
    let said = "longer than the contract allows";
    // In lockstep calls take no time.
    let punctual = run(&["--lockstep", "--for", "30ms"]);
    assert_eq!(punctual.status, Some(0), "{}", punctual.out);
    assert!(!punctual.out.contains(said), "{}", punctual.out);
    // Its checks take 0.9 s, for which nobody else waits.
    let late = run(&["--for", "3s", "--record", &recording.display().to_string()]);
    assert_eq!(late.status, Some(1), "{}\n{}", late.out, late.err);
    assert!(
        late.out.contains(said) && !late.out.contains("no faults"),
        "{}",
        late.out
    );
    let info = output_of(jde_with_plugins(&["info"]).arg(&recording)).out;
    assert!(
        info.contains("1 takeover longer than its contract allows"),
        "{info}"
    );
}
