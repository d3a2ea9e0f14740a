//! Faults of world files: each is reported with its file, its line and what is expected, all of them
//! together.

use std::path::{Path, PathBuf};

use jde_sim::{RobotConfig, World, WorldError};

pub(crate) fn faults(text: &str) -> Vec<String> {
    match World::parse(text, "lab/w.toml", 0) {
        Ok(_) => panic!("the world has no fault"),
        Err(error) => error.faults().iter().map(ToString::to_string).collect(),
    }
}

/// Checks that there is one fault, on the line that ends with `# fault`, and that its message contains
/// `parts`.
fn check(text: &str, parts: &[&str]) {
    let line = 1 + text
        .lines()
        .position(|line| line.ends_with("# fault"))
        .expect("one line is marked");
    let faults = faults(text);
    assert_eq!(faults.len(), 1, "{faults:#?}");
    assert!(
        faults[0].starts_with(&format!("lab/w.toml:{line}:")),
        "{}",
        faults[0]
    );
    for part in parts {
        assert!(faults[0].contains(part), "`{part}` is not in: {}", faults[0]);
    }
}

#[test]
fn each_kind_of_fault_is_shown_at_its_place() {
    for (text, expected) in [
        (
            "[[boxs]]",
            "w.toml:1:3: unknown key `boxs` in the world\n    1 | [[boxs]]\n      |   ^^^^\n    help: did you mean `boxes`?",
        ),
        (
            "[[circles]]\ncenter = [0, 0]\nradius = true",
            "w.toml:3:10: `radius` of circle 1 must be a number, not true or false\n    3 | radius = true\n      |          ^^^^",
        ),
        (
            "[[circles]]\ncenter = [0, 0]\nradius = '30 cm'",
            "w.toml:3:10: `radius` of circle 1 must be a number, not a text\n    3 | radius = '30 cm'\n      |          ^^^^^^^",
        ),
        (
            "[[people]]\nname = 'eve'\nway = [[0, 0], [1, 0]]\nspeed = 200",
            "w.toml:4:9: `speed` of person `eve` is 200: expected at most 20 m/s\n    4 | speed = 200\n      |         ^^^",
        ),
        (
            "[[circles]]\ncenter = [0, 0]",
            "w.toml:1:1: `radius` of circle 1 is missing\n    1 | [[circles]]\n      | ^^^^^^^^^^^",
        ),
        (
            "name = 'a'\nname = 'b'",
            "w.toml:2:1: there is a key `name` already\n    2 | name = 'b'\n      | ^^^^\n    help: keep one of the two",
        ),
        (
            "robots = { r = { start = { x = 1, y = 2, heading = 90 } } }",
            "w.toml:1:42: unknown key `heading` in `start` of robot `r`\n    \
             1 | robots = { r = { start = { x = 1, y = 2, heading = 90 } } }\n      \
             |                                          ^^^^^^^\n    help: did you mean `heading_deg`?",
        ),
    ] {
        let error = World::parse(text, "w.toml", 0).err().expect("a fault");
        assert_eq!(format!("{error:#}"), expected, "{text}");
    }
}

#[test]
fn a_syntax_error_has_its_line() {
    check(
        "name = 'a'\nboxes = [{ center = [0, 0] size = [1, 1] }] # fault",
        &["expected"],
    );
}

#[test]
fn equal_circles_have_one_list_of_centers() {
    check(
        "[[circles]]\ncenter = [0, 0]\ncenters = [[1, 1]] # fault\nradius = 1",
        &["has `center` and `centers`: drop one"],
    );
    for wrong in ["[]", "[1, 1]", "[[1, 'x']]", "7"] {
        let text = format!("[[circles]]\ncenters = {wrong} # fault\nradius = 1");
        check(&text, &["`centers` of circle 1"]);
    }
    let text = "[[circles]]\ncenters = [[0, 0], [1, 1]]\nradius = 0.1";
    let world = World::parse(text, "w.toml", 0).unwrap();
    assert_eq!(world.shapes().count(), 2);
}

#[test]
fn an_unknown_key_is_reported_with_the_nearest_known_one() {
    check(
        "name = 'a'\n[[boxs]] # fault\ncenter = [0, 0]",
        &["unknown key `boxs`", "did you mean `boxes`?"],
    );
    check(
        "[[circles]]\nname = 'pillar'\ncenter = [0, 0]\nradius = 1\nxyz = 'red' # fault",
        &[
            "circle `pillar`",
            "unknown key `xyz`",
            "keys: `name`, `center`, `centers`, `radius`",
        ],
    );
    check(
        "[robots.r]\nstart = { x = 1, y = 2, heading = 90 } # fault",
        &["unknown key `heading`", "did you mean `heading_deg`?"],
    );
    check(
        "[robots.r]\nstrt = 1 # fault\nstart = { x = 1, y = 2 }",
        &["robot `r`", "did you mean `start`?"],
    );
    check(
        "[[movers]]\nradius = 1\nway = [[0, 0], [1, 0]]\nspeed = 1\npause = 2 # fault",
        &["unknown key `pause`", "keys: `name`"],
    );
}

#[test]
fn numbers_must_be_finite_and_in_range() {
    check(
        "[[circles]]\ncenter = [0, nan] # fault\nradius = 1",
        &["`center` of circle 1 is NaN", "finite"],
    );
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = inf # fault",
        &["`radius` of circle 1 is inf", "finite"],
    );
    check(
        "[[circles]]\ncenter = [1e9, 0] # fault\nradius = 1",
        &["out of range"],
    );
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = '1' # fault",
        &["`radius` of circle 1 must be a number, not a text"],
    );
}

#[test]
fn sizes_must_be_positive() {
    check(
        "[[boxes]]\nname = 'desk'\ncenter = [0, 0]\nsize = [1, 0] # fault",
        &["`size` of box `desk` is 0", "more than 0"],
    );
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = -0.5 # fault",
        &["`radius` of circle 1 is -0.5"],
    );
    check(
        "[[boxes]]\ncenter = [0, 0]\nsize = [1, 1, 1] # fault",
        &["has 3 values", "a size"],
    );
}

#[test]
fn walls_need_different_points() {
    check(
        "[[walls]]\npoints = [[0, 0]] # fault",
        &["has 1 points", "two or more"],
    );
    check(
        "[[walls]]\npoints = [\n  [0, 0],\n  [1, 0],\n  [1, 0], # fault\n]",
        &["point 3 on the one before"],
    );
    check(
        "[[walls]] # fault\npoints = [[0, 0], [1, 0]]\nclosed = true",
        &["closed", "three or more"],
    );
    check(
        "[[walls]] # fault\npoints = [[0, 0], [1, 0], [1, 1], [0, 0]]\nclosed = true",
        &["drop the last point"],
    );
    check(
        "[[walls]]\npoints = 3 # fault",
        &["not a whole number", "[[x, y], ...]"],
    );
}

#[test]
fn movers_need_a_body_a_way_and_a_speed() {
    check(
        "[[movers]] # fault\nname = 'anna'\nway = [[0, 0], [1, 0]]\nspeed = 1",
        &["mover `anna`", "`radius`", "`size`"],
    );
    check(
        "[[movers]] # fault\nradius = 1\nsize = [1, 1]\nway = [[0, 0], [1, 0]]\nspeed = 1",
        &["only one"],
    );
    check(
        "[[movers]]\nradius = 1\nway = [[0, 0]] # fault\nspeed = 1",
        &["`way` of mover 1 has 1 points"],
    );
    check(
        "[[movers]]\nradius = 1\nway = [[0, 0], [1, 0]]\nspeed = 0 # fault",
        &["`speed` of mover 1 is 0"],
    );
    check(
        "[[people]]\nway = [[0, 0], [1, 0]]\nspeed = 20.1 # fault",
        &["`speed` of person 1 is 20.1: expected at most 20 m/s"],
    );
    check(
        "[[movers]] # fault\nradius = 1\nway = [[0, 0], [1, 0]]",
        &["`speed` of mover 1 is missing"],
    );
    check(
        "[[movers]] # fault\nradius = 1\nway = [[0, 0], [1, 0], [0, 0]]\nspeed = 1\nloop = true",
        &["drop the last point"],
    );
}

#[test]
fn a_robot_cannot_start_inside_a_thing_or_outside_the_bounds() {
    check(
        "[[boxes]]\nname = 'desk'\ncenter = [0, 0]\nsize = [1, 1]\n[robots.r]\nstart = { x = 0.2, y = 0 } # fault",
        &["robot `r` starts inside `desk`"],
    );
    check(
        "bounds = { min = [0, 0], max = [4, 4] }\n[robots.r]\nstart = { x = 5, y = 1 } # fault",
        &["robot `r` starts outside the bounds"],
    );
    check("[robots.r] # fault\n", &["robot `r` has no `start`"]);
    check("robots = { r = 3 } # fault", &["robot `r` must be a table"]);
}

#[test]
fn bounds_need_a_minimum_below_the_maximum() {
    check(
        "bounds = { min = [0, 0], max = [0, 4] } # fault",
        &["`bounds` of the world have a `min` that is not less than `max`"],
    );
    check("bounds = 3 # fault", &["must be a table of `min` and `max`"]);
    check(
        "reference_length = 0 # fault",
        &["`reference_length` of the world is 0", "more than 0"],
    );
}

#[test]
fn a_value_of_the_wrong_type_is_reported() {
    check(
        "boxes = 3 # fault",
        &["`boxes` of the world must be a list of tables"],
    );
    check(
        "boxes = [\n  3, # fault\n]",
        &["box 1 must be a table, not a whole number"],
    );
    check(
        "name = 3 # fault",
        &["`name` of the world must be a text, not a whole number"],
    );
}

#[test]
fn all_faults_are_reported_in_the_order_of_the_lines() {
    let text = "nam = 'a'\nboxes = [{ center = [0, 0], size = [0, 1] }]\n[[movers]]\nradius = 1\nway = [[0, 0], [1, 0]]\nspeed = -1\n[robots.r]\nstart = { x = nan, y = 0 }";
    let found = faults(text);
    let lines: Vec<&str> = found
        .iter()
        .map(|fault| fault.split(':').nth(1).unwrap())
        .collect();
    assert_eq!(lines, ["1", "2", "6", "8"], "{found:#?}");
    let error = World::parse(text, "lab/w.toml", 0).err().unwrap().to_string();
    assert_eq!(
        error.lines().count(),
        5,
        "a line for each fault and one for help: {error}"
    );
}

#[test]
fn a_missing_world_file_is_reported() {
    let error = World::load("no/such/world.toml", 0).err().unwrap().to_string();
    assert!(
        error.starts_with("no/such/world.toml: there is no such file"),
        "{error}"
    );
}

#[test]
fn a_missing_map_is_reported_with_the_line_of_the_world() {
    check(
        "name = 'a'\nmap = 'none.yaml' # fault",
        &[
            "`map` of the world",
            "there is no such file",
            &Path::new("lab").join("none.yaml").display().to_string(),
        ],
    );
}

#[test]
fn a_world_without_walls_is_valid_with_a_warning() {
    let world = World::parse("robots = { r = { start = { x = 0, y = 0 } } }", "w.toml", 0).unwrap();
    let warnings = world.warnings();
    assert_eq!(warnings.len(), 1);
    assert!(
        warnings[0].to_string().starts_with("w.toml:1:1: no walls"),
        "{}",
        warnings[0]
    );
    let mut world = world;
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    assert_eq!(world.truth(robot).clearance, f64::INFINITY);
}

#[test]
fn a_mover_that_crosses_a_thing_gives_a_warning() {
    let text = "circles = [{ name = 'pillar', center = [1, 0.4], radius = 0.2 }]\n[[movers]]\nname = 'anna'\nradius = 0.25\nway = [[0, 0], [2, 0]]\nspeed = 1";
    let world = World::parse(text, "w.toml", 0).unwrap();
    let warnings: Vec<String> = world.warnings().iter().map(ToString::to_string).collect();
    assert_eq!(
        warnings,
        ["w.toml:2:1: the way of mover `anna` crosses `pillar`: the mover passes through"]
    );
}

#[test]
fn a_refused_robot_is_reported_with_a_hint() {
    let text = "circles = [{ name = 'pillar', center = [0.4, 0], radius = 0.2 }]\n[robots.pioneer]\nstart = { x = 0, y = 0 }\n[robots.other]\nstart = { x = -1, y = 0 }";
    let mut world = World::parse(text, "w.toml", 0).unwrap();
    let add_error = |world: &mut World, name: &str, config: RobotConfig| {
        world.add_robot(name, config).unwrap_err().to_string()
    };
    let error = add_error(&mut world, "pionear", RobotConfig::default());
    assert!(
        error.contains("no robot `pionear`") && error.contains("did you mean `pioneer`?"),
        "{error}"
    );
    let error = add_error(&mut world, "zzz", RobotConfig::default());
    assert!(error.contains("it has `pioneer`, `other`"), "{error}");
    let error = add_error(&mut world, "pioneer", RobotConfig::default());
    assert_eq!(
        error,
        "w.toml:3: robot `pioneer` of radius 0.25 m starts on `pillar`: move its start at least 0.050 m away from it"
    );
    let error = add_error(
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
fn every_prefix_of_a_world_file_gives_a_world_or_faults_with_lines() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../worlds/office.toml");
    let text = std::fs::read_to_string(path).unwrap();
    for end in (0..text.len())
        .step_by(7)
        .filter(|&end| text.is_char_boundary(end))
    {
        if let Err(error) = World::parse(&text[..end], "office.toml", 0) {
            assert!(!error.faults().is_empty());
            assert!(
                error.faults().iter().all(|fault| fault.line().is_some()),
                "{error}"
            );
        }
    }
}

#[test]
fn colours_are_hexadecimal_or_known_names() {
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = 1\ncolor = 'grean' # fault",
        &[
            "`color` of circle 1 is `grean`",
            "#rrggbb",
            "did you mean `green`?",
        ],
    );
    check(
        "floor = '#12345' # fault",
        &["`floor` of the world is `#12345`", "`orange`"],
    );
    check(
        "light = 3 # fault",
        &["`light` of the world must be a table of `from_deg`"],
    );
}

#[test]
fn movable_things_must_not_overlap_others() {
    check(
        "circles = [{ name = 'post', center = [0, 0], radius = 1 }]
         balls = [{ name = 'b', center = [1.05, 0], radius = 0.1 }] # fault",
        &["`b` lies in `post`"],
    );
    check(
        "boxes = [{ name = 'carton', center = [0.3, 0], size = [0.4, 0.4], movable = true }]
         balls = [{ name = 'b', center = [0, 0], radius = 0.101 }] # fault",
        &["`b` lies in `carton`"],
    );
    check(
        "people = [{ name = 'eve', way = [[0, 0], [3, 0]], speed = 1 }]\nballs = [{ center = [0.3, 0], radius = 0.1 }] # fault",
        &["`ball 1` lies in `eve`"],
    );
}

#[test]
fn a_reflectivity_is_that_of_something_fixed() {
    check(
        "[[boxes]]\ncenter = [0, 0]\nsize = [1, 1]\nmovable = true\nreflectivity = 3 # fault",
        &["box 1", "`movable`"],
    );
    check(
        "[[walls]]\npoints = [[0, 0], [1, 0]]\nreflectivity = -1 # fault",
        &["`reflectivity` of wall 1 is -1", "0 to 1000"],
    );
}

#[test]
fn a_surface_and_legs_are_those_of_something_fixed() {
    check(
        "[[walls]]\npoints = [[0, 0], [1, 0]]\nsurface = 'glas' # fault",
        &["`surface` of wall 1 is `glas`", "did you mean `glass`?"],
    );
    for key in ["surface = 'glass'", "legs = 0.03"] {
        check(
            &format!("[[boxes]]\ncenter = [0, 0]\nsize = [1, 1]\nmovable = true\n{key} # fault"),
            &["box 1 has `", "`movable`"],
        );
    }
    check(
        "[[boxes]]\ncenter = [0, 0]\nsize = [1, 0.1]\nlegs = 0.03 # fault",
        &["box 1 has `legs`", "thinner"],
    );
    check(
        "[[boxes]]\ncenter = [0, 0]\nsize = [1, 1]\nlegs = 0 # fault",
        &["`legs` of box 1 is 0", "more than 0"],
    );
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = 1\nsurface = 3 # fault",
        &["`surface` of circle 1", "must be a text"],
    );
}

#[test]
fn only_movable_things_have_a_mass() {
    check(
        "[[boxes]]\ncenter = [0, 0]\nsize = [1, 1]\nmass = 3 # fault",
        &["box 1", "not `movable`"],
    );
    check(
        "[[boxes]]\ncenter = [0, 0]\nsize = [1, 1]\nmovable = true\nmass = 0 # fault",
        &["`mass` of box 1 is 0", "more than 0"],
    );
    check(
        "[[people]]\nway = [[0, 0], [1, 0]]\nspeed = 1\npause = -1 # fault",
        &["`pause` of person 1 is -1"],
    );
    check(
        "[[people]]\nway = [[0, 0], [1, 0]]\nspeed = -1 # fault",
        &["`speed` of person 1 is -1"],
    );
    check(
        "[[people]]\nway = [[0, 0], [1, 0]]\nspeed = 1 # fault\nsits = true",
        &["person 1", "sits and walks"],
    );
    check(
        "[[people]]\nway = [[0, 0], [1, 0]]\nsits = 1 # fault",
        &["person 1", "`sits`"],
    );
}

#[test]
fn a_person_who_sits_wrongly_hides_no_other_fault() {
    for sits in ["speed = 1\nsits = true", "sits = 1"] {
        let faults = faults(&format!("[[people]]\n{sits}\nway = 3\npause = -1\ncolor = 5"));
        assert_eq!(faults.len(), 4, "{faults:#?}");
    }
}
