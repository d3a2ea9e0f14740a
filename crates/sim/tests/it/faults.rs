//! Every fault of a world file has its file and line and states what was expected. All are reported together.

use std::path::{Path, PathBuf};

use jde_sim::{RobotConfig, World, WorldError};

fn faults(text: &str) -> Vec<String> {
    match World::parse(text, "lab/w.toml", 0) {
        Ok(_) => panic!("a fault was expected"),
        Err(error) => error.faults().iter().map(ToString::to_string).collect(),
    }
}

/// Checks that there is one fault, on the line that ends with `# here`, and that it contains all of `words`.
fn check(text: &str, words: &[&str]) {
    let line = 1 + text
        .lines()
        .position(|line| line.ends_with("# here"))
        .expect("a line is marked");
    let faults = faults(text);
    assert_eq!(faults.len(), 1, "{faults:#?}");
    assert!(
        faults[0].starts_with(&format!("lab/w.toml:{line}: ")),
        "{}",
        faults[0]
    );
    for word in words {
        assert!(faults[0].contains(word), "`{word}` is not in: {}", faults[0]);
    }
}

#[test]
fn broken_syntax_is_located() {
    check(
        "name = 'a'\nboxes = [{ center = [0, 0] size = [1, 1] }] # here",
        &["expected"],
    );
}

#[test]
fn unknown_keys_get_the_nearest_known_one() {
    check(
        "name = 'a'\n[[boxs]] # here\ncenter = [0, 0]",
        &["unknown key `boxs`", "did you mean `boxes`?"],
    );
    check(
        "[[circles]]\nname = 'pillar'\ncenter = [0, 0]\nradius = 1\nxyz = 'red' # here",
        &[
            "circle `pillar`",
            "unknown key `xyz`",
            "`name`, `center`, `radius`",
        ],
    );
    check(
        "[robots.r]\nstart = { x = 1, y = 2, heading = 90 } # here",
        &["did you mean `heading_deg`?"],
    );
    check(
        "[robots.r]\nstrt = 1 # here\nstart = { x = 1, y = 2 }",
        &["robot `r`", "did you mean `start`?"],
    );
    check(
        "[[movers]]\nradius = 1\nway = [[0, 0], [1, 0]]\nspeed = 1\npause = 2 # here",
        &["unknown key `pause`; expected one of `name`"],
    );
}

#[test]
fn numbers_must_be_finite_and_of_this_world() {
    check(
        "[[circles]]\ncenter = [0, nan] # here\nradius = 1",
        &["circle 1", "`center` is NaN", "finite"],
    );
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = inf # here",
        &["`radius` is inf", "finite"],
    );
    check(
        "[[circles]]\ncenter = [1e9, 0] # here\nradius = 1",
        &["out of range"],
    );
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = '1' # here",
        &["`radius` is a string", "expected a number"],
    );
}

#[test]
fn sizes_must_be_more_than_nothing() {
    check(
        "[[boxes]]\nname = 'desk'\ncenter = [0, 0]\nsize = [1, 0] # here",
        &["box `desk`", "`size` is 0", "more than 0"],
    );
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = -0.5 # here",
        &["`radius` is -0.5"],
    );
    check(
        "[[boxes]]\ncenter = [0, 0]\nsize = [1, 1, 1] # here",
        &["has 3 values", "a size"],
    );
}

#[test]
fn walls_need_points_that_differ() {
    check(
        "[[walls]]\npoints = [[0, 0]] # here",
        &["has 1 points", "two or more"],
    );
    check(
        "[[walls]]\npoints = [\n  [0, 0],\n  [1, 0],\n  [1, 0], # here\n]",
        &["point 3 on the one before"],
    );
    check(
        "[[walls]] # here\npoints = [[0, 0], [1, 0]]\nclosed = true",
        &["closed", "three or more"],
    );
    check(
        "[[walls]] # here\npoints = [[0, 0], [1, 0], [1, 1], [0, 0]]\nclosed = true",
        &["drop the last point"],
    );
    check(
        "[[walls]]\npoints = 3 # here",
        &["is an integer", "[[x, y], ...]"],
    );
}

#[test]
fn movers_need_a_body_a_way_and_a_speed() {
    check(
        "[[movers]] # here\nname = 'anna'\nway = [[0, 0], [1, 0]]\nspeed = 1",
        &["mover `anna`", "`radius`", "`size`"],
    );
    check(
        "[[movers]] # here\nradius = 1\nsize = [1, 1]\nway = [[0, 0], [1, 0]]\nspeed = 1",
        &["only one"],
    );
    check(
        "[[movers]]\nradius = 1\nway = [[0, 0]] # here\nspeed = 1",
        &["`way` has 1 points"],
    );
    check(
        "[[movers]]\nradius = 1\nway = [[0, 0], [1, 0]]\nspeed = 0 # here",
        &["`speed` is 0"],
    );
    check(
        "[[people]]\nway = [[0, 0], [1, 0]]\nspeed = 20.1 # here",
        &["`speed` is 20.1: expected at most 20 m/s"],
    );
    check(
        "[[movers]] # here\nradius = 1\nway = [[0, 0], [1, 0]]",
        &["`speed` is missing"],
    );
    check(
        "[[movers]] # here\nradius = 1\nway = [[0, 0], [1, 0], [0, 0]]\nspeed = 1\nloop = true",
        &["drop the last point"],
    );
}

#[test]
fn a_robot_cannot_start_in_a_thing_or_outside() {
    check(
        "[[boxes]]\nname = 'desk'\ncenter = [0, 0]\nsize = [1, 1]\n[robots.r]\nstart = { x = 0.2, y = 0 } # here",
        &["robot `r` starts inside `desk`"],
    );
    check(
        "bounds = { min = [0, 0], max = [4, 4] }\n[robots.r]\nstart = { x = 5, y = 1 } # here",
        &["robot `r` starts outside the bounds"],
    );
    check("[robots.r] # here\n", &["`start` is missing"]);
    check("robots = { r = 3 } # here", &["robot `r`", "expected a table"]);
}

#[test]
fn bounds_must_be_the_right_way_round() {
    check(
        "bounds = { min = [0, 0], max = [0, 4] } # here",
        &["bounds", "`min`", "`max`"],
    );
    check("bounds = 3 # here", &["expected { min"]);
}

#[test]
fn a_wrong_kind_of_value_is_named() {
    check("boxes = 3 # here", &["`boxes` is an integer", "array of tables"]);
    check(
        "boxes = [\n  3, # here\n]",
        &["box 1 is an integer", "expected a table"],
    );
    check("name = 3 # here", &["`name` is an integer", "text"]);
}

#[test]
fn all_faults_come_together_in_the_order_of_the_lines() {
    let text = "nam = 'a'\nboxes = [{ center = [0, 0], size = [0, 1] }]\n[[movers]]\nradius = 1\nway = [[0, 0], [1, 0]]\nspeed = -1\n[robots.r]\nstart = { x = nan, y = 0 }";
    let found = faults(text);
    let lines: Vec<&str> = found
        .iter()
        .map(|fault| fault.split(':').nth(1).unwrap())
        .collect();
    assert_eq!(lines, ["1", "2", "6", "8"], "{found:#?}");
    let error = World::parse(text, "lab/w.toml", 0).err().unwrap().to_string();
    assert_eq!(error.lines().count(), 4, "one line a fault: {error}");
}

#[test]
fn a_missing_world_is_named() {
    let error = World::load("no/such/world.toml", 0).err().unwrap().to_string();
    assert!(
        error.starts_with("no/such/world.toml: cannot read the world"),
        "{error}"
    );
}

#[test]
fn a_missing_map_is_located_in_the_world() {
    check(
        "name = 'a'\nmap = 'none.yaml' # here",
        &[
            "cannot read the map",
            &Path::new("lab").join("none.yaml").display().to_string(),
        ],
    );
}

#[test]
fn a_world_without_walls_is_legal_but_warned_of() {
    let world = World::parse("robots = { r = { start = { x = 0, y = 0 } } }", "w.toml", 0).unwrap();
    let warnings = world.warnings();
    assert_eq!(warnings.len(), 1);
    assert!(
        warnings[0].to_string().starts_with("w.toml:1: no walls"),
        "{}",
        warnings[0]
    );
    let mut world = world;
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    assert_eq!(world.truth(robot).clearance, f64::INFINITY);
}

#[test]
fn a_mover_that_goes_through_a_thing_is_warned_of() {
    let text = "circles = [{ name = 'pillar', center = [1, 0.4], radius = 0.2 }]\n[[movers]]\nname = 'anna'\nradius = 0.25\nway = [[0, 0], [2, 0]]\nspeed = 1";
    let world = World::parse(text, "w.toml", 0).unwrap();
    let warnings: Vec<String> = world.warnings().iter().map(ToString::to_string).collect();
    assert_eq!(
        warnings,
        ["w.toml:2: the way of mover `anna` crosses `pillar`: it goes through"]
    );
}

#[test]
fn robots_are_refused_with_what_would_do() {
    let text = "circles = [{ name = 'pillar', center = [0.4, 0], radius = 0.2 }]\n[robots.pioneer]\nstart = { x = 0, y = 0 }\n[robots.other]\nstart = { x = -1, y = 0 }";
    let mut world = World::parse(text, "w.toml", 0).unwrap();
    let refusal = |world: &mut World, name: &str, config: RobotConfig| {
        world.add_robot(name, config).unwrap_err().to_string()
    };
    let error = refusal(&mut world, "pionear", RobotConfig::default());
    assert!(
        error.contains("no robot `pionear`") && error.contains("did you mean `pioneer`?"),
        "{error}"
    );
    let error = refusal(&mut world, "zzz", RobotConfig::default());
    assert!(error.contains("it has `pioneer`, `other`"), "{error}");
    let error = refusal(&mut world, "pioneer", RobotConfig::default());
    assert_eq!(
        error,
        "w.toml:3: robot `pioneer` of radius 0.25 m starts on `pillar`: move its start at least 0.050 m away from it"
    );
    let error = refusal(
        &mut world,
        "pioneer",
        RobotConfig {
            max_linear: -1.0,
            ..RobotConfig::default()
        },
    );
    assert!(
        error.contains("max_linear is -1") && error.contains("m/s"),
        "{error}"
    );
    world.add_robot("other", RobotConfig::default()).unwrap();
    assert_eq!(
        world.add_robot("other", RobotConfig::default()),
        Err(WorldError::AlreadyAdded {
            robot: "other".into()
        })
    );
}

#[test]
fn any_text_gives_a_world_or_faults_with_lines() {
    // Every prefix of a valid file: no panic, and no fault without its place.
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../worlds/office.toml");
    let text = std::fs::read_to_string(path).unwrap();
    for end in (0..text.len())
        .step_by(7)
        .filter(|&end| text.is_char_boundary(end))
    {
        if let Err(error) = World::parse(&text[..end], "office.toml", 0) {
            assert!(!error.faults().is_empty());
            assert!(error.faults().iter().all(|fault| fault.line.is_some()), "{error}");
        }
    }
}

#[test]
fn colours_are_digits_or_known_names() {
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = 1\ncolor = 'grean' # here",
        &[
            "circle 1",
            "`color` is `grean`",
            "#rrggbb",
            "did you mean `green`?",
        ],
    );
    check("floor = '#12345' # here", &["`floor` is `#12345`", "`orange`"]);
    check("light = 3 # here", &["`light` is not a table", "from_deg"]);
}

#[test]
fn loose_things_need_room() {
    check(
        "circles = [{ name = 'post', center = [0, 0], radius = 1 }]
         balls = [{ name = 'b', center = [1.05, 0], radius = 0.1 }] # here",
        &["`b` lies in `post`"],
    );
    check(
        "boxes = [{ name = 'carton', center = [0.3, 0], size = [0.4, 0.4], movable = true }]
         balls = [{ name = 'b', center = [0, 0], radius = 0.101 }] # here",
        &["`b` lies in `carton`"],
    );
    check(
        "people = [{ name = 'eve', way = [[0, 0], [3, 0]], speed = 1 }]\nballs = [{ center = [0.3, 0], radius = 0.1 }] # here",
        &["`ball 1` lies in `eve`"],
    );
}

#[test]
fn only_what_is_movable_has_a_mass() {
    check(
        "[[boxes]]\ncenter = [0, 0]\nsize = [1, 1]\nmass = 3 # here",
        &["box 1", "not `movable`"],
    );
    check(
        "[[boxes]]\ncenter = [0, 0]\nsize = [1, 1]\nmovable = true\nmass = 0 # here",
        &["box 1", "`mass` is 0", "more than 0"],
    );
    check(
        "[[people]]\nway = [[0, 0], [1, 0]]\nspeed = 1\npause = -1 # here",
        &["person 1", "`pause` is -1"],
    );
}
