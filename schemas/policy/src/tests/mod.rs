//! The schemas on the bench: when they are ready, what they command, and what is wrong before the start.

use std::fs;
use std::path::{Path as FilePath, PathBuf};

use jde_schema::Severity;
use jde_schema::bench::{Bench, Entry};
use jde_schema::prelude::*;

use crate::estimate::Scores;
use crate::{Chunks, Estimate, Onnx};

mod chunks;

fn file(name: &str) -> String {
    let folder = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../../robotics/policy/tests/data");
    folder.join(name).display().to_string()
}

fn entries() -> [Entry; 1] {
    [Entry::new::<Odometry>("inputs", "odometry")]
}

fn policy(name: &str) -> Bench<Onnx> {
    let mut bench = Bench::<Onnx>::with_lists(&entries());
    bench.set("file", Text::<1024>::new(&file(name)));
    bench.awake().expect("the policy is right");
    bench
}

/// An odometry with these speeds.
fn moving(ahead: f64, turn: f64) -> Odometry {
    let mut odometry = Odometry::default();
    odometry.pose.pose = Pose2D::ORIGIN.into();
    odometry.twist.twist = Twist::planar(ahead, turn);
    odometry
}

/// The precondition at a time, s, with these speeds.
fn check(bench: &mut Bench<Onnx>, at: f64, ahead: f64, turn: f64) -> Precondition {
    bench.set_now(Duration::from_secs_f64(at));
    bench.import("odometry", &moving(ahead, turn));
    bench.check().expect("a check is no fault")
}

#[test]
fn it_commands_what_the_network_decides() {
    let mut bench = policy("same.toml");
    assert!(check(&mut bench, 1.0, 0.5, 0.25).ready);
    bench.iterate().expect("an iteration is no fault");
    assert_eq!(bench.commanded::<Twist>("base"), Some(Twist::planar(0.5, 0.5)));
    assert_eq!(
        bench
            .exported::<Text<64>>("network")
            .expect("the hash is exported")
            .as_str()
            .len(),
        64
    );
    assert!(
        bench
            .log()
            .iter()
            .any(|(severity, text)| *severity == Severity::Info && text.contains("SHA-256"))
    );
}

#[test]
fn without_a_value_it_is_not_ready_and_stands() {
    let mut bench = policy("same.toml");
    assert!(check(&mut bench, 1.0, 0.5, 0.25).ready);
    bench.retract("odometry");
    bench.set_now(Duration::from_secs_f64(1.1));
    assert!(!bench.check().expect("a check is no fault").ready);
    bench.iterate().expect("an iteration is no fault");
    assert_eq!(bench.commanded::<Twist>("base"), Some(Twist::ZERO));
    assert!(
        bench
            .draw()
            .expect("it draws")
            .texts()
            .iter()
            .any(|text| text.contains("`odometry` has no value"))
    );
}

#[test]
fn nan_is_never_a_command() {
    let mut bench = policy("log.toml");
    assert!(check(&mut bench, 1.0, 1.5, 1.0).ready);
    assert!(!check(&mut bench, 1.1, -1.0, 1.0).ready);
    bench.iterate().expect("an iteration is no fault");
    assert_eq!(bench.commanded::<Twist>("base"), Some(Twist::ZERO));
    assert!(
        bench
            .log()
            .iter()
            .any(|(_, text)| text == "it does not decide: the network gave NaN in `action`"),
        "{:?}",
        bench.log()
    );
    assert!(check(&mut bench, 1.2, 1.5, 1.0).ready, "it decides again");
}

#[test]
fn a_network_that_chooses_commands_what_the_file_lists() {
    let mut bench = policy("choose.toml");
    assert!(check(&mut bench, 1.0, 0.5, 0.25).ready);
    bench.iterate().expect("an iteration is no fault");
    let twist = bench.commanded::<Twist>("base").expect("a command");
    let listed = [(0.0, 0.0), (0.4, 0.0), (0.2, 0.8), (0.2, -0.8)];
    let choice = listed
        .iter()
        .position(|speeds| *speeds == (twist.linear.x, twist.angular.z));
    let choice = choice.unwrap_or_else(|| panic!("{twist:?} is not listed"));
    let panel = bench.draw().expect("it draws");
    assert!(
        panel
            .texts()
            .contains(&format!("It chose command {choice}").as_str()),
        "{:?}",
        panel.texts()
    );
}

#[test]
fn doubt_is_readiness_with_two_thresholds() {
    let mut bench = policy("members.toml");
    // The doubt is 0.816 of the turn rate; the file is certain up to 0.1 and unsure from 0.5 on.
    let sure = check(&mut bench, 1.0, 0.5, 0.0);
    assert!(sure.ready && sure.urgency == 1.0);
    let between = check(&mut bench, 1.1, 0.5, 0.4);
    assert!(
        between.ready && between.urgency > 0.3 && between.urgency < 0.5,
        "{between:?}"
    );
    assert!(!check(&mut bench, 1.2, 0.5, 0.7).ready);
    assert!(!check(&mut bench, 1.3, 0.5, 0.4).ready, "it does not know yet");
    assert!(
        (bench.exported::<f64>("doubt").expect("the doubt is exported") - 0.4 * (2.0_f64 / 3.0).sqrt()).abs()
            < 1e-6
    );
    assert!(check(&mut bench, 1.4, 0.5, 0.05).ready);
}

#[test]
fn a_step_is_one_period_however_often_it_is_checked() {
    let mut bench = policy("sum.toml");
    for at in [1.0, 1.01, 1.02, 1.1, 1.11, 1.2] {
        check(&mut bench, at, 0.125, 0.0);
    }
    bench.iterate().expect("an iteration is no fault");
    let ahead = bench.commanded::<Twist>("base").expect("a command").linear.x;
    assert_eq!(ahead, 0.375, "three steps of 0.125");
    assert!(!bench.log().iter().any(|(_, text)| text.contains("a step took")));
    check(&mut bench, 1.6, 0.125, 0.0);
    assert!(
        bench
            .log()
            .iter()
            .any(|(_, text)| text == "a step took 0.400 s, and the policy's file states 0.1 s")
    );
}

#[test]
fn it_forgets_when_it_sleeps() {
    let mut bench = policy("sum.toml");
    check(&mut bench, 1.0, 0.25, 0.0);
    bench.sleep().expect("it sleeps");
    bench.awake().expect("it awakes");
    check(&mut bench, 1.1, 0.25, 0.0);
    bench.iterate().expect("an iteration is no fault");
    assert_eq!(
        bench.commanded::<Twist>("base").expect("a command").linear.x,
        0.25
    );
}

/// A folder with a policy that is called `own.toml`.
struct Folder(tempfile::TempDir);

impl Folder {
    fn with(name: &str) -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        folder.put(name);
        folder
    }

    /// Replaces the policy.
    fn put(&self, name: &str) {
        let network = format!("{name}.onnx");
        fs::copy(file(&network), self.0.path().join(&network)).expect("a copy");
        fs::copy(file(&format!("{name}.toml")), self.0.path().join("own.toml")).expect("a copy");
    }

    fn path(&self) -> PathBuf {
        self.0.path().join("own.toml")
    }

    /// Writes the modulation, as `jde set` does.
    fn set(&self, bench: &mut Bench<Onnx>) {
        bench.set("file", Text::<1024>::new(&self.path().display().to_string()));
    }
}

#[test]
fn a_write_of_the_file_replaces_the_policy_and_a_broken_one_changes_nothing() {
    let folder = Folder::with("same");
    let mut bench = Bench::<Onnx>::with_lists(&entries());
    folder.set(&mut bench);
    bench.awake().expect("the policy is right");
    let first = bench.exported::<Text<64>>("network");
    fs::write(folder.0.path().join("same.onnx"), b"no network").expect("the file is broken");
    folder.set(&mut bench);
    assert!(check(&mut bench, 1.0, 0.5, 0.25).ready);
    assert_eq!(bench.exported::<Text<64>>("network"), first);
    let said = |bench: &Bench<Onnx>, words: &str| bench.log().iter().any(|(_, text)| text.contains(words));
    assert!(
        said(&bench, "the policy before stays in force: "),
        "{:?}",
        bench.log()
    );
    assert!(said(&bench, "own.toml:2:11"));
    folder.put("sum");
    folder.set(&mut bench);
    for at in [1.1, 1.2] {
        assert!(check(&mut bench, at, 0.25, 0.25).ready);
    }
    bench.iterate().expect("an iteration is no fault");
    assert_eq!(
        bench.commanded::<Twist>("base").expect("a command").linear.x,
        0.5,
        "it adds up"
    );
    assert_ne!(bench.exported::<Text<64>>("network"), first);
}

#[test]
fn a_network_that_fails_on_trial_gives_way_to_the_one_before() {
    let folder = Folder::with("same");
    let mut bench = Bench::<Onnx>::with_lists(&entries());
    folder.set(&mut bench);
    bench.awake().expect("the policy is right");
    let first = bench.exported::<Text<64>>("network");
    folder.put("log");
    folder.set(&mut bench);
    assert!(check(&mut bench, 1.0, 0.5, 0.25).ready);
    assert_ne!(bench.exported::<Text<64>>("network"), first);
    assert!(
        check(&mut bench, 1.1, -0.25, 0.25).ready,
        "the one before decides where the new one gives NaN"
    );
    bench.iterate().expect("an iteration is no fault");
    assert_eq!(
        bench.commanded::<Twist>("base").expect("a command").linear.x,
        -0.25
    );
    assert_eq!(bench.exported::<Text<64>>("network"), first);
}

/// The problems of an application with this policy and these inputs.
fn problems(name: &str, entries: &[Entry]) -> Vec<String> {
    let mut bench = Bench::<Onnx>::with_lists(entries);
    bench.set("file", Text::<1024>::new(name));
    let problems = bench.inspect().expect("an inspection is no fault");
    problems
        .into_iter()
        .map(|problem| format!("{}: {}", problem.modulation, problem.words))
        .collect()
}

#[test]
fn what_does_not_fit_is_a_problem_before_the_start() {
    let cases: [(&str, Vec<Entry>, &str); 6] = [
        ("", entries().to_vec(), "file: `file` names no policy"),
        (
            "same.toml",
            vec![],
            "file: the policy sees `odometry`: state `inputs.odometry = \"schema.variable\"`",
        ),
        (
            "same.toml",
            vec![
                Entry::new::<Odometry>("inputs", "odometry"),
                Entry::new::<LaserScan>("inputs", "laser"),
            ],
            "laser: the policy sees no `laser`, but odometry",
        ),
        (
            "same.toml",
            vec![Entry::new::<LaserScan>("inputs", "odometry")],
            "odometry: a sensor_msgs/msg/LaserScan has no field `twist`",
        ),
        ("wide.toml", entries().to_vec(), "file: the policy sees `laser`"),
        ("make.py", entries().to_vec(), "there is no such file"),
    ];
    for (name, entries, expected) in cases {
        let path = if name.is_empty() {
            String::new()
        } else {
            file(name)
        };
        let found = problems(&path, &entries);
        assert!(
            found.iter().any(|words| words.contains(expected)),
            "{expected} is not in {found:?}"
        );
    }
    assert!(problems(&file("same.toml"), &entries()).is_empty());
    let found = problems(&file("faster.toml"), &entries());
    assert!(
        found[0].contains("policy/chunks makes chunks, and policy/steps drives by them"),
        "{found:?}"
    );
    let mut bench = Bench::<Chunks>::with_lists(&entries());
    bench.set("file", Text::<1024>::new(&file("same.toml")));
    let found = bench.inspect().expect("an inspection is no fault");
    assert!(
        found[0].words.contains("the policy has no [chunk]"),
        "{}",
        found[0].words
    );
}

#[test]
fn estimates_are_exported_while_they_are_finite() {
    let mut bench = Bench::<Estimate>::with_lists(&entries());
    bench.set("file", Text::<1024>::new(&file("members.toml")));
    bench.awake().expect("the policy is right");
    bench.import("odometry", &moving(0.5, 0.3));
    bench.iterate().expect("an iteration is no fault");
    assert_eq!(bench.exported::<Scores>("scores").expect("scores").data.len(), 6);
    assert_eq!(bench.exported::<f64>("value"), Some(0.5));
    assert!(bench.exported::<f64>("doubt").is_some());
    bench.retract("odometry");
    bench.set_now(Duration::from_secs_f64(1.0));
    bench.iterate().expect("an iteration is no fault");
    assert_eq!(bench.exported::<f64>("value"), None);
    assert!(bench.exported::<Scores>("scores").is_none());
}
