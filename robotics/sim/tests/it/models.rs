//! Robot files: the shipped ones drive, and faults are reported with line and suggestion.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use jde_sim::{
    HeadConfig, Kinematics, LaserConfig, Pose2, RobotConfig, RobotModel, SonarConfig, Twist2, World,
};
use proptest::prelude::*;

const EMPTY: &str = "
    walls  = [{ name = 'wall', points = [[-5, -5], [5, -5], [5, 5], [-5, 5]], closed = true }]
    robots = { r = { start = { x = 0, y = 0 } } }";

const SMALL: &str = "
doc = 'A small robot.'
bumpers = true
[footprint]
radius = 0.1
[drive]
kinematics = 'differential'
max_speed = 0.5
acceleration = 1
max_turn_deg = 90
turn_acceleration_deg = 180
[odometry]
track = 0.2
ticks_per_mm = 10
[[lasers]]
beams = 10
view_deg = 90
range_max = 4
rate = 20
";

fn shipped() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let entries = fs::read_dir(folder).expect("the folder of robots can be read");
    let mut files: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    files
}

fn faults(text: &str) -> Vec<String> {
    match RobotModel::parse(text, "lab/r.toml") {
        Ok(_) => Vec::new(),
        Err(error) => error.faults().iter().map(ToString::to_string).collect(),
    }
}

/// Replaces a line of the small robot. Returns the only fault, without file and line, after it has checked
/// them.
#[track_caller]
fn fault(line: &str, by: &str) -> String {
    let text = SMALL.replace(line, by);
    assert_ne!(text, SMALL, "{line}");
    let faults = faults(&text);
    assert_eq!(faults.len(), 1, "{faults:#?}");
    let number = 1 + SMALL.lines().position(|known| known == line).expect("the line");
    let place = format!("lab/r.toml:{number}:");
    faults[0]
        .strip_prefix(&place)
        .unwrap_or_else(|| panic!("{} is not at {place}", faults[0]))
        .to_owned()
}

#[test]
fn the_pioneer_is_the_default_robot() {
    let path = shipped()
        .into_iter()
        .find(|path| path.ends_with("pioneer-3dx.toml"));
    let model = RobotModel::load(path.expect("it is shipped")).unwrap();
    assert_eq!(model.config, RobotConfig::default());
    assert_eq!(model.lasers[0].config, LaserConfig::default());
    assert_eq!(
        model.sonars.expect("it has sonars").config,
        SonarConfig::default()
    );
    assert_eq!(model.config.head, HeadConfig::default());
    assert!(model.bumpers && model.head && model.battery);
}

#[test]
fn every_shipped_robot_drives_a_metre_within_its_limits_and_senses() {
    let files = shipped();
    assert_eq!(files.len(), jde_sim::SHIPPED_ROBOTS.len());
    for path in files {
        let model = RobotModel::load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(
            Some(model.name.as_str()),
            path.file_stem().and_then(|stem| stem.to_str())
        );
        let config = model.config.clone();
        let mut world = World::parse(EMPTY, "open.toml", 3).unwrap();
        let robot = world.add_robot("r", config.clone()).unwrap();
        let mut before = Twist2::default();
        while world.truth(robot).pose.x < 1.0 {
            world.command(robot, Twist2::new(100.0, 0.0)).unwrap();
            world.advance_to(world.now() + 10_000_000);
            let twist = world.truth(robot).twist;
            assert!(twist.linear <= config.max_linear, "{}: {twist:?}", model.name);
            let gain = (twist.linear - before.linear) / 0.01;
            assert!(
                gain <= config.linear_acceleration * (1.0 + 1e-9),
                "{}: {gain} m/s²",
                model.name
            );
            before = twist;
            assert!(world.now() < 20_000_000_000, "{} does not get there", model.name);
        }
        let truth = world.truth(robot);
        assert!(
            truth.pose.y.abs() < 1e-9 && truth.collisions == 0,
            "{}: {truth:?}",
            model.name
        );
        let measured = world.odometry(robot).pose.distance(truth.pose);
        let [[x, ..], [_, y, _], _] = world.odometry_covariance(robot).pose;
        let expected = 0.01 + 4.0 * (x + y).sqrt();
        assert!(measured < expected, "{}: {measured} m of drift", model.name);
        for laser in &model.lasers {
            let mut ranges = vec![0.0; laser.config.beams];
            world.laser(robot, &laser.config, &mut ranges).unwrap();
            // One that reads 0 without a return does so in a hall beyond its range.
            assert!(ranges.iter().all(|range| *range >= 0.0), "{}", model.name);
        }
    }
}

#[test]
fn the_robot_of_the_documentation_is_valid() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/robots.md");
    let page = fs::read_to_string(page).expect("the page can be read");
    let text = page
        .split("```")
        .find_map(|block| {
            block
                .strip_prefix("toml\n")
                .filter(|text| text.contains("[footprint]"))
        })
        .expect("the page has a robot");
    let model = RobotModel::parse(text, "trolley.toml").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        (model.name.as_str(), model.config.footprint.extent()),
        ("trolley", [[-0.3, -0.2], [0.5, 0.2]])
    );
}

#[test]
fn a_small_robot_has_what_its_file_says_and_nothing_else() {
    let model = RobotModel::parse(SMALL, "lab/small.toml").unwrap();
    assert_eq!(
        (model.name.as_str(), model.doc.as_str()),
        ("small", "A small robot.")
    );
    assert!(model.bumpers && !model.head && !model.battery && model.sonars.is_none());
    assert_eq!(model.config.kinematics, Kinematics::Differential);
    assert_eq!(model.config.linear_deceleration, 1.0, "the acceleration");
    assert_eq!(model.lasers[0].name, "laser 1");
    assert_eq!(model.lasers[0].config.mount, Pose2::default());
    assert_eq!(model.lasers[0].period, Some(Duration::from_millis(50)));
}

const PHYSICS: &str = "
[physics]
mass = 3
height = 0.2
center = [0, 0, 0.1]
wheel_radius = 0.03
wheel_width = 0.02
wheels = [[0, 0.1], [0, -0.1]]
torque = 0.5
";

#[test]
fn masses_and_wheels_are_optional_and_have_defaults() {
    let small = RobotModel::parse(SMALL, "r.toml").expect("valid");
    assert_eq!(small.physics, None);
    let physics = RobotModel::parse(&format!("{SMALL}{PHYSICS}"), "r.toml").expect("valid");
    let physics = physics.physics.expect("it states them");
    assert_eq!(physics.wheels, [[0.0, 0.1], [0.0, -0.1]]);
    assert_eq!(physics.casters, <[[f64; 2]; 0]>::default());
    assert_eq!((physics.friction, physics.track_multiplier), (0.8, 1.0));
}

#[test]
fn wheels_on_one_side_and_missing_masses_are_faults() {
    let one_side = PHYSICS.replace("[0, -0.1]]", "[0, 0.2]]");
    let found = faults(&format!("{SMALL}{one_side}"));
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].contains("needs a wheel on either side"), "{}", found[0]);
    let massless = PHYSICS.replace("mass = 3\n", "");
    let found = faults(&format!("{SMALL}{massless}"));
    assert!(found.len() == 1 && found[0].contains("`mass`"), "{found:#?}");
}

#[test]
fn each_kind_of_fault_is_shown_at_its_place() {
    for (line, by, expected) in [
        (
            "bumpers = true",
            "bumper = true",
            "unknown key `bumper` in the robot\n   LINE | bumper = true\n      | ^^^^^^\n    help: did you mean `bumpers`?",
        ),
        (
            "radius = 0.1",
            "radius = '10 cm'",
            "`radius` of `footprint` of the robot must be a number, not a text\n   LINE | radius = '10 cm'\n      \
             |          ^^^^^^^",
        ),
        (
            "rate = 20",
            "rate = 0",
            "`rate` of laser 1 is 0: expected 0.01 to 100 Hz\n   LINE | rate = 0\n      |        ^",
        ),
        (
            "kinematics = 'differential'",
            "kinematics = 'diferential'",
            "`kinematics` of `drive` of the robot is `diferential`, which is not a kinematics\n   \
             LINE | kinematics = 'diferential'\n      |              ^^^^^^^^^^^^^\n    help: did you mean `differential`?",
        ),
    ] {
        let number = 1 + SMALL.lines().position(|known| known == line).expect("the line");
        let error = RobotModel::parse(&SMALL.replace(line, by), "r.toml").expect_err("a fault");
        let shown = format!("{error:#}");
        let (place, shown) = shown.split_once(": ").expect("a place");
        assert!(place.starts_with(&format!("r.toml:{number}:")), "{place}");
        assert_eq!(shown, expected.replace("LINE", &format!("{number:2}")), "{by}");
    }
}

#[test]
fn a_wrong_value_is_reported_at_its_line() {
    for (line, by, parts) in [
        (
            "radius = 0.1",
            "radius = 0",
            ["`radius` of `footprint` of the robot is 0", "0.01 to 10 m"],
        ),
        ("radius = 0.1", "radius = 'x'", ["must be a number", "not a text"]),
        (
            "radius = 0.1",
            "polygon = [[0, 0], [1, 0], [0, 1]]",
            ["`polygon`", "contain (0, 0)"],
        ),
        (
            "radius = 0.1",
            "polygon = [[1, 1], [-1, 0]]",
            ["`polygon`", "has 2 corners"],
        ),
        (
            "kinematics = 'differential'",
            "kinematics = 'diferential'",
            ["drive", "did you mean `differential`?"],
        ),
        (
            "max_speed = 0.5",
            "max_speed = nan",
            ["`drive` of the robot is NaN", "finite"],
        ),
        ("acceleration = 1", "acceleration = -1", ["is -1", "m/s²"]),
        (
            "max_turn_deg = 90",
            "max_turn_deg = inf",
            ["`max_turn_deg`", "finite"],
        ),
        ("track = 0.2", "track = 0", ["`track` of `odometry`", "is 0"]),
        ("beams = 10", "beams = 1.5", ["laser 1", "whole number"]),
        (
            "view_deg = 90",
            "view_deg = 400",
            ["laser 1", "0.1 to 360 degrees"],
        ),
        ("rate = 20", "rate = 0", ["`rate` of laser 1 is 0", "Hz"]),
        ("bumpers = true", "bumpers = 1", ["`bumpers`", "true or false"]),
        (
            "bumpers = true",
            "bumper = true",
            ["unknown key `bumper`", "did you mean `bumpers`?"],
        ),
        (
            "rate = 20",
            "turning = 'clockwise'",
            ["laser 1 turns", "no `rate` of 1 to 100 Hz"],
        ),
        (
            "rate = 20",
            "turning = 'clockwis'",
            ["`turning` of laser 1", "did you mean `clockwise`?"],
        ),
        (
            "rate = 20",
            "no_return = 'infinity'",
            ["`no_return` of laser 1", "not what a beam reads"],
        ),
        (
            "rate = 20",
            "dropped_beams = 2",
            ["`dropped_beams` of laser 1 is 2", "0 to 1"],
        ),
        (
            "rate = 20",
            "latency = -1",
            ["`latency` of laser 1 is -1", "0 to 10 s"],
        ),
        (
            "rate = 20",
            "jitter = 11",
            ["`jitter` of laser 1 is 11", "0 to 10 s"],
        ),
        (
            "rate = 20",
            "dropped = 1.1",
            ["`dropped` of laser 1 is 1.1", "0 to 1"],
        ),
        (
            "ticks_per_mm = 10",
            "latency = 'x'\nticks_per_mm = 10",
            ["`latency` of `odometry`", "must be a number"],
        ),
        (
            "acceleration = 1",
            "dead_band = 2\nacceleration = 1",
            ["`dead_band`", "0 to 1 m/s"],
        ),
        (
            "acceleration = 1",
            "skid = 1\nacceleration = 1",
            ["`skid`", "0 to 0.9"],
        ),
        (
            "acceleration = 1",
            "turn_dead_band_deg = -1\nacceleration = 1",
            ["`turn_dead_band_deg`", "0 to 500 degrees/s"],
        ),
    ] {
        let message = fault(line, by);
        for part in parts {
            assert!(message.contains(part), "`{part}` is not in: {message}");
        }
    }
}

#[test]
fn all_faults_are_reported_together() {
    let faults = faults(
        "nmae = 'x'\n[footprint]\nradius = 1\npolygon = []\n[drive]\nkinematics = 'car'\nmax_turn_deg = 3\n",
    );
    for part in [
        "r.toml:1:1: unknown key `nmae` in the robot\n    help: did you mean `name`?",
        "either a `radius` or a `polygon`",
        "`wheelbase` of `drive` of the robot is missing",
        "`max_speed` of `drive` of the robot is missing",
        "unknown key `max_turn_deg`",
        "`odometry` of the robot is missing",
    ] {
        assert!(
            faults.iter().any(|fault| fault.contains(part)),
            "`{part}` is not in: {faults:#?}"
        );
    }
}

#[test]
fn two_lasers_of_one_name_are_refused_and_others_have_noise_of_their_own() {
    let second = "[[lasers]]\nbeams = 5\nview_deg = 10\nrange_max = 2\n";
    let model = RobotModel::parse(&format!("{SMALL}{second}"), "r.toml").unwrap();
    assert_ne!(model.lasers[0].config.stream, model.lasers[1].config.stream);
    let twice = faults(&format!("{SMALL}{second}name = 'laser 1'\n"));
    assert!(twice.len() == 1 && twice[0].contains("its own name"), "{twice:?}");
}

#[test]
fn a_file_that_cannot_be_read_is_an_error() {
    let error = RobotModel::load("/nowhere/r.toml").unwrap_err().to_string();
    assert!(error.contains("r.toml: there is no such file"), "{error}");
}

/// Values of all kinds, and the limits of arithmetic.
fn value() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("nan".to_owned()),
        Just("-inf".to_owned()),
        Just("1e300".to_owned()),
        Just("[]".to_owned()),
        Just("{ x = 1e5, y = -1 }".to_owned()),
        Just("[[1, 0], [-1, 1], [-1, -1]]".to_owned()),
        Just("'car'".to_owned()),
        Just("'omnidirectional'".to_owned()),
        Just("true".to_owned()),
        (-10.0..10.0f64).prop_map(|value| value.to_string()),
        (1..2000u32).prop_map(|value| value.to_string()),
        "[ -~]{0,12}",
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn a_corrupted_file_is_refused_or_describes_a_robot_that_drives(
        file in 0..jde_sim::SHIPPED_ROBOTS.len(),
        changes in proptest::collection::vec((any::<prop::sample::Index>(), value()), 1..4),
        removed in proptest::option::of(any::<prop::sample::Index>()),
    ) {
        let text = fs::read_to_string(&shipped()[file]).unwrap();
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        for (line, value) in changes {
            let line = line.get(&lines).clone();
            if let Some((key, _)) = line.split_once('=') {
                let changed = format!("{key}= {value}");
                lines.iter_mut().filter(|known| **known == line).for_each(|known| known.clone_from(&changed));
            }
        }
        if let Some(index) = removed {
            lines.remove(index.index(lines.len()));
        }
        match RobotModel::parse(&lines.join("\n"), "r.toml") {
            Err(error) => prop_assert!(!error.faults().is_empty()),
            Ok(model) => {
                prop_assert!(model.config.check().is_ok(), "{:?}", model.config);
                let mut world = World::parse(EMPTY, "open.toml", 3).unwrap();
                if let Ok(robot) = world.add_robot("r", model.config) {
                    world.command(robot, Twist2 { linear: 1.0, lateral: 0.5, angular: 0.3 }).unwrap();
                    world.advance_to(1_000_000_000);
                    let truth = world.truth(robot);
                    prop_assert!(truth.pose.x.is_finite() && truth.pose.heading.is_finite() && truth.min_clearance >= 0.0);
                }
                for laser in model.lasers {
                    prop_assert!(laser.config.check().is_ok(), "{:?}", laser);
                }
            }
        }
    }
}

#[test]
fn a_model_is_a_shipped_robot_or_a_file() {
    for path in shipped() {
        let name = path.file_stem().and_then(|stem| stem.to_str()).expect("a name");
        let found = RobotModel::find(name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(Ok(found), RobotModel::load(&path));
        assert!(RobotModel::find(path.to_str().expect("a path in UTF-8")).is_ok());
    }
    let error = RobotModel::find("pioneer")
        .expect_err("it is not shipped")
        .to_string();
    assert!(
        error.contains("`pioneer.toml`, or one of `jackal`, `jackal-late`"),
        "{error}"
    );
}
