//! Policies as people write them: what they see and command, and what is wrong with a file.

use std::fs;
use std::path::{Path as FilePath, PathBuf};

use jde_types::{Header, Image, LaserScan, Odometry, Path, Pose2D, Seq, Text, Twist, Value};

use super::*;

mod choices;
mod chunks;

fn data(name: &str) -> PathBuf {
    FilePath::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name)
}

fn text(name: &str) -> String {
    fs::read_to_string(data(name)).expect("the file is there")
}

/// Loads a changed file of the tests beside its network.
fn load(text: &str) -> Result<(Policy, Runner), String> {
    let folder = tempfile::tempdir().expect("a folder");
    let files = |folder: &str| fs::read_dir(data(folder)).expect("the folder is there").flatten();
    let exported = files("../../../onnx/tests/data")
        .filter(|entry| entry.file_name().to_string_lossy().starts_with("sb3-"));
    for entry in files("").chain(exported) {
        fs::copy(entry.path(), folder.path().join(entry.file_name())).expect("a copy");
    }
    let file = folder.path().join("policy.toml");
    fs::write(&file, text).expect("the file is written");
    let name = format!("{}/", folder.path().display());
    Policy::load(&file).map_err(|faults| faults.to_string().replace(&name, ""))
}

fn faults(text: &str) -> String {
    load(text).map(drop).expect_err("the file has a fault")
}

/// A value of any type.
trait Sense {
    fn bytes(&self) -> &[u8];
}

impl<T: Value> Sense for T {
    fn bytes(&self) -> &[u8] {
        self.as_bytes()
    }
}

/// The values of a test, by the roles of a policy.
struct Sensed(Vec<Option<Box<dyn Sense>>>, Option<Pose2D>);

impl Values for Sensed {
    fn role(&self, role: usize) -> Option<&[u8]> {
        self.0[role].as_deref().map(Sense::bytes)
    }

    fn target(&self) -> Option<Pose2D> {
        self.1
    }
}

/// An odometry with these speeds at the origin.
fn moving(ahead: f64, turn: f64) -> Sensed {
    let mut odometry = Odometry::default();
    odometry.pose.pose = Pose2D::ORIGIN.into();
    odometry.twist.twist = Twist::planar(ahead, turn);
    Sensed(vec![Some(Box::new(odometry))], None)
}

fn observer(policy: &Policy, of: &[jde_abi::describe::Type]) -> Observer {
    policy
        .observer(&of.iter().collect::<Vec<_>>())
        .expect("the types fit")
}

fn ready(name: &str) -> (Policy, Runner, Observer) {
    let (policy, runner) = load(&text(name)).expect("the file is right");
    let observer = observer(&policy, &[Odometry::describe()]);
    (policy, runner, observer)
}

#[test]
fn a_command_is_unscaled_and_clipped() {
    let (policy, mut runner, mut observer) = ready("same.toml");
    assert_eq!(policy.roles().collect::<Vec<_>>(), ["odometry"]);
    let mut decide = |ahead, turn| {
        let seen = observer.observe(&moving(ahead, turn)).expect("all is there");
        runner.step(seen).expect("the numbers are finite").command
    };
    assert_eq!(decide(0.25, 0.5), [0.25, 0.0, 1.0]);
    assert_eq!(decide(7.0, -3.0), [1.0, 0.0, -2.0]);
    assert_eq!(policy.command(&[0.25, 0.5]), [0.25, 0.0, 1.0]);
    assert_eq!(policy.action([0.25, 0.0, 1.0]), [0.25, 0.5]);
    assert_eq!(policy.action_bounds(), [(-0.5, 1.0), (-1.0, 1.0)]);
}

#[test]
fn a_number_that_is_not_finite_is_no_decision_and_no_memory() {
    let (_, mut runner, mut observer) = ready("log.toml");
    let seen = observer.observe(&moving(-1.0, 1.0)).expect("all is there");
    let words = runner.step(seen).expect_err("there is no logarithm");
    assert_eq!(words, "the network gave NaN in `action`");
    let words = observer
        .observe(&moving(f64::NAN, 1.0))
        .expect_err("the odometry is none");
    assert_eq!(words, "`odometry`: a number of it is NaN");

    let (_, mut runner, _) = ready("sum.toml");
    runner.step(&[1e38, 0.0]).expect("the numbers are finite");
    runner.step(&[3e38, 0.0]).expect_err("the sum is infinite");
    assert_eq!(
        runner.step(&[0.5, 0.0]).expect("the memory is gone").command[0],
        0.5
    );
}

#[test]
fn a_network_remembers_until_it_is_reset() {
    let (_, mut runner, _) = ready("sum.toml");
    let mut sum = || runner.step(&[0.2, 0.0]).expect("the numbers are finite").command[0];
    let sums = [sum(), sum(), sum()];
    assert!(
        sums.iter()
            .zip([0.2, 0.4, 0.6])
            .all(|(given, sum)| (given - sum).abs() < 1e-6),
        "{sums:?}"
    );
    runner.reset();
    assert!((runner.step(&[0.2, 0.0]).expect("it runs").command[0] - 0.2).abs() < 1e-6);
}

#[test]
fn members_that_differ_are_doubt() {
    let (_, mut runner, _) = ready("members.toml");
    let mut at = |turn: f32| runner.step(&[0.3, turn]).expect("the numbers are finite");
    let sure = at(0.0);
    assert_eq!((sure.doubt, sure.certainty), (Some(0.0), 1.0));
    // The members give -0.3, 0 and 0.3: a deviation of 0.245.
    let between = at(0.3);
    assert!((between.doubt.expect("a doubt") - 0.3 * (2.0_f64 / 3.0).sqrt()).abs() < 1e-6);
    assert!((between.certainty - (0.5 - 0.3 * (2.0_f64 / 3.0).sqrt()) / 0.4).abs() < 1e-6);
    assert_eq!(at(2.0).certainty, 0.0);
    assert!(between.value.is_some_and(|value| (value - 0.3).abs() < 1e-6));
    assert_eq!(runner.scores().len(), 6);
}

/// What `wide.toml` sees: walls of 1, 2, 3 and 9 m, a path ahead, and a target to the left.
fn wide(scan: LaserScan) -> Sensed {
    let mut odometry = Odometry::default();
    odometry.pose.pose = Pose2D::new(1.0, 1.0, core::f64::consts::FRAC_PI_2).into();
    let path = Path::through(
        Header::default(),
        &[(1.0, 0.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0), (0.0, 9.0)],
    );
    let target = Pose2D::new(-2.0, 1.0, 0.0);
    Sensed(
        vec![
            Some(Box::new(scan)),
            Some(Box::new(path)),
            Some(Box::new(odometry)),
        ],
        Some(target),
    )
}

fn scan(ranges: &[f32]) -> LaserScan {
    let step = core::f32::consts::TAU / ranges.len() as f32;
    LaserScan {
        angle_min: step / 2.0 - core::f32::consts::PI,
        angle_max: core::f32::consts::PI - step / 2.0,
        angle_increment: step,
        range_max: 9.0,
        ranges: Seq::from_slice(ranges).expect("they fit"),
        ..LaserScan::default()
    }
}

fn wide_observer() -> (Policy, Observer) {
    let (policy, _) = load(&text("wide.toml")).expect("the file is right");
    let types = [LaserScan::describe(), Path::describe(), Odometry::describe()];
    let observer = observer(&policy, &types);
    (policy, observer)
}

#[test]
fn rays_a_path_and_a_target_are_numbers_in_the_order_of_the_file() {
    let (policy, mut observer) = wide_observer();
    assert_eq!(policy.roles().collect::<Vec<_>>(), ["laser", "path", "odometry"]);
    assert!(policy.sees_target());
    let first = wide(scan(&[
        1.0,
        5.0,
        2.0,
        2.5,
        f32::INFINITY,
        3.0,
        f32::INFINITY,
        f32::NAN,
    ]));
    let seen = observer.observe(&first).expect("all is there").to_vec();
    // Four sectors of two beams, twice: their own, and as those before.
    assert_eq!(seen[..8], [-0.5, 0.0, 0.5, 1.0, -0.5, 0.0, 0.5, 1.0]);
    // 1 m up and 0.5 m to the left of the base, which faces up.
    assert!(
        (seen[8] - 1.0).abs() < 1e-6 && (seen[9] - 0.5).abs() < 1e-6,
        "{seen:?}"
    );
    // 1 m to the left: (0 - 0.5) / 0.5, and (1 - 0) / 0.5 clipped.
    assert!(
        (seen[10] + 1.0).abs() < 1e-6 && (seen[11] - 1.0).abs() < 1e-6,
        "{seen:?}"
    );
    let second = wide(scan(&[4.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0]));
    let seen = observer.observe(&second).expect("all is there");
    assert_eq!(seen[..8], [-0.5, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0, 1.0]);
    let bounds = observer.bounds();
    assert_eq!((bounds[0], bounds[11]), ((-1.0, 1.0), (-1.0, 1.0)));
    observer.reset();
    let seen = observer.observe(&second).expect("all is there");
    assert_eq!(seen[..8], [1.0; 8]);
}

/// A camera's picture of one colour.
struct Seen(Box<Image>);

impl Sense for Seen {
    fn bytes(&self) -> &[u8] {
        self.0.as_bytes()
    }
}

fn camera(colour: [u8; 3], encoding: &str) -> Sensed {
    let mut image = Image::boxed();
    (image.width, image.height, image.step) = (16, 8, 48);
    image.encoding = Text::new(encoding);
    image.data.resize(16 * 8 * 3);
    image.data.as_mut_slice().as_chunks_mut::<3>().0.fill(colour);
    Sensed(vec![Some(Box::new(Seen(image)))], None)
}

#[test]
fn a_picture_is_resampled_and_each_channel_scaled() {
    let (policy, mut runner) = load(&text("picture.toml")).expect("the file is right");
    assert_eq!(policy.roles().collect::<Vec<_>>(), ["camera"]);
    let mut observer = observer(&policy, &[Image::describe()]);
    assert_eq!(observer.bounds()[0], (f32::NEG_INFINITY, f32::INFINITY));
    let seen = observer
        .observe(&camera([255, 51, 0], "rgb8"))
        .expect("it is a picture");
    assert_eq!(seen.len(), 24);
    for (channel, expected) in [1.0, 0.2, -1.0].into_iter().enumerate() {
        let numbers = &seen[channel * 8..][..8];
        assert!(
            numbers.iter().all(|number| (number - expected).abs() < 1e-6),
            "{numbers:?}"
        );
    }
    let command = runner.step(seen).expect("the numbers are finite").command;
    assert!(
        (command[0] - 1.0).abs() < 1e-6 && (command[2] - 0.2).abs() < 1e-6,
        "{command:?}"
    );
    let words = observer
        .observe(&camera([0; 3], "yuv422"))
        .expect_err("it is none of those");
    assert_eq!(
        words,
        "`camera`: its encoding is `yuv422`, not rgb8, bgr8 or mono8"
    );
    let odometry = Odometry::describe();
    let wrong = policy
        .observer(&[&odometry])
        .expect_err("an odometry is no picture");
    assert!(
        wrong[0].1.starts_with("it must be a sensor_msgs/msg/Image"),
        "{}",
        wrong[0].1
    );

    let grey = text("picture.toml").replace("colours = \"rgb\"", "colours = \"grey\"\nstack   = 3");
    let grey = grey.replace("mean    = [0.5, 0.0, 0.25]\nstd     = [0.5, 1.0, 0.25]\n", "");
    let (policy, _) = load(&grey).expect("three grey pictures are three channels");
    let mut observer = super::tests::observer(&policy, &[Image::describe()]);
    assert_eq!(observer.bounds()[0], (0.0, 1.0));
    observer
        .observe(&camera([0; 3], "rgb8"))
        .expect("it is a picture");
    let seen = observer
        .observe(&camera([255; 3], "rgb8"))
        .expect("it is a picture");
    assert!(seen[..16].iter().all(|number| *number == 0.0), "{seen:?}");
    assert!(
        seen[16..].iter().all(|number| (number - 1.0).abs() < 1e-6),
        "the newest is the last"
    );
}

#[test]
fn what_is_missing_is_said_and_nothing_is_kept() {
    let (_, mut observer) = wide_observer();
    let mut lacks = |change: &dyn Fn(&mut Sensed)| {
        let mut sensed = wide(scan(&[4.0; 8]));
        change(&mut sensed);
        observer.observe(&sensed).expect_err("something is missing")
    };
    assert_eq!(lacks(&|sensed| sensed.0[0] = None), "`laser` has no value");
    assert_eq!(lacks(&|sensed| sensed.1 = None), "there is no target");
    assert_eq!(
        lacks(&|sensed| sensed.0[1] = Some(Box::new(Path::default()))),
        "`path`: it is empty"
    );
    let blind = scan(&[4.0, 4.0, 4.0, 4.0, f32::NAN, f32::NAN, 4.0, 4.0]);
    let words = lacks(&|sensed| sensed.0[0] = Some(Box::new(blind)));
    assert_eq!(words, "`laser`: no beam measures anything around 45 degrees");
    let seen = observer.observe(&wide(scan(&[2.0; 8]))).expect("all is there");
    assert_eq!(
        seen[..8],
        [0.0; 8],
        "nothing was kept of the steps without a value"
    );
}

#[test]
fn a_role_of_another_type_is_refused() {
    let (policy, _) = load(&text("wide.toml")).expect("the file is right");
    let (odometry, path) = (Odometry::describe(), Path::describe());
    let wrong = policy
        .observer(&[&odometry, &path, &odometry])
        .expect_err("an odometry is no scan");
    assert_eq!(wrong[0].0, "laser");
    assert!(
        wrong[0].1.starts_with("it must be a sensor_msgs/msg/LaserScan"),
        "{}",
        wrong[0].1
    );
    let (policy, _) =
        load(&text("same.toml").replace("twist.linear.x", "twist.linear.up")).expect("the file is right");
    let wrong = policy.observer(&[&odometry]).expect_err("there is no such field");
    assert!(
        wrong[0].1.contains("has no field `up`, but x, y, z"),
        "{}",
        wrong[0].1
    );
}

#[test]
fn all_faults_of_a_file_are_reported_at_once_with_their_lines() {
    let broken = text("same.toml")
        .replace("period  = 0.1", "period  = -3\nperiode = 1")
        .replace("scale   = \"none\"", "scale   = \"bound\"")
        .replace("bounds  = [-2.0, 2.0]", "bounds  = [2.0, -2.0]")
        .replacen("[[input]]", "[[input]]\nrays = \"laser\"", 1);
    let words = faults(&broken);
    for expected in [
        "policy.toml:3:11: `period` of the policy is -3: expected the time of a step in seconds, 0.0001 to 60",
        "policy.toml:4:1: unknown key `periode` in the policy\n    help: did you mean `period`?",
        "input 1 has `field` and `rays`",
        "`scale` of output 1 is `bound`, which is not a scale\n    help: did you mean `bounds`?",
        "`bounds` of output 2 must be the lower and then the higher number",
    ] {
        assert!(words.contains(expected), "{expected} is not in:\n{words}");
    }
}

#[test]
fn what_the_network_has_is_checked_against_the_file() {
    let same = text("same.toml");
    let cases = [
        (
            same.replace("same.onnx", "absent.onnx"),
            "absent.onnx: it cannot be read",
        ),
        (
            same.replace("same.onnx", "wide.onnx"),
            "the network takes 12 numbers in `obs`, of the shape [1, 12], and the file gives 2",
        ),
        (
            same.replace("index   = 1", "index   = 2"),
            "the network's `action` has 2 numbers, and none at 2",
        ),
        (
            same.replace("index   = 1", "of = \"actoin\""),
            "the network has no output `actoin`\n    help: did you mean `action`?",
        ),
        (
            same.replacen(
                "[[output]]\ncommand = \"linear.x\"",
                "[[output]]\ncommand = \"angular.z\"",
                1,
            ),
            "commands a number that another one commands",
        ),
        (
            text("members.toml").replace("of      = \"action\"", ""),
            "the network has 3 outputs, so `of` must name one: `members`, `action` and `value`",
        ),
        (
            text("members.toml").replace("of      = \"members\"", "of = \"value\""),
            "`value` has the shape [1]: expected a row for each of several members",
        ),
        (
            text("sum.toml").replace("input  = \"sum\"", "input = \"some\""),
            "the network has no input `some`",
        ),
        (
            text("picture.toml").replace("width   = 4\nheight  = 2", "width = 2\nheight = 4"),
            "the network takes `obs`, of the shape [1, 3, 2, 4], and the file gives [3, 4, 2]: channels, height, width",
        ),
        (
            text("picture.toml").replace("white   = 1\n", ""),
            "`white` of input 1 is missing",
        ),
        (
            text("picture.toml").replace("\"rgb\"", "\"gray\""),
            "`colours` of input 1 is `gray`, which is not a kind of colours",
        ),
    ];
    for (text, expected) in cases {
        let words = faults(&text);
        assert!(words.contains(expected), "{expected} is not in:\n{words}");
    }
}

#[test]
fn no_text_makes_the_reader_panic() {
    let mut random = fastrand::Rng::with_seed(3);
    let texts = [
        "same.toml",
        "members.toml",
        "sum.toml",
        "wide.toml",
        "picture.toml",
        "faster.toml",
        "choose.toml",
    ]
    .map(text);
    let words: Vec<&str> = texts.iter().flat_map(|text| text.split_whitespace()).collect();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("policy.toml");
    for round in 0..600 {
        let mut lines: Vec<String> = texts[round % texts.len()].lines().map(str::to_owned).collect();
        for _ in 0..random.usize(1..4) {
            let at = random.usize(..lines.len());
            match random.u8(..4) {
                0 => drop(lines.remove(at)),
                1 => lines.insert(at, lines[random.usize(..lines.len())].clone()),
                2 => {
                    let (old, new) = (
                        words[random.usize(..words.len())],
                        words[random.usize(..words.len())],
                    );
                    lines[at] = lines[at].replace(old, new);
                }
                _ => lines[at].push_str(words[random.usize(..words.len())]),
            }
            if lines.is_empty() {
                lines.push(String::new());
            }
        }
        fs::write(&file, lines.join("\n")).expect("the file is written");
        match Policy::load_text(&file) {
            Ok(policy) => assert!(policy.period() > 0.0),
            Err(faults) => assert!(faults.count() > 0),
        }
    }
}
