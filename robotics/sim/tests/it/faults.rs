//! Faults of world files: each is reported with its file, its line and what is expected, all of them
//! together.

use std::path::{Path, PathBuf};

use jde_sim::{RobotConfig, World, WorldError};

fn faults(text: &str) -> Vec<String> {
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
        faults[0].starts_with(&format!("lab/w.toml:{line}: ")),
        "{}",
        faults[0]
    );
    for part in parts {
        assert!(faults[0].contains(part), "`{part}` is not in: {}", faults[0]);
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
        check(&text, &["circle 1: `centers`"]);
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
            "`name`, `center`, `centers`, `radius`",
        ],
    );
    check(
        "[robots.r]\nstart = { x = 1, y = 2, heading = 90 } # fault",
        &["did you mean `heading_deg`?"],
    );
    check(
        "[robots.r]\nstrt = 1 # fault\nstart = { x = 1, y = 2 }",
        &["robot `r`", "did you mean `start`?"],
    );
    check(
        "[[movers]]\nradius = 1\nway = [[0, 0], [1, 0]]\nspeed = 1\npause = 2 # fault",
        &["unknown key `pause`; expected one of `name`"],
    );
}

#[test]
fn numbers_must_be_finite_and_in_range() {
    check(
        "[[circles]]\ncenter = [0, nan] # fault\nradius = 1",
        &["circle 1", "`center` is NaN", "finite"],
    );
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = inf # fault",
        &["`radius` is inf", "finite"],
    );
    check(
        "[[circles]]\ncenter = [1e9, 0] # fault\nradius = 1",
        &["out of range"],
    );
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = '1' # fault",
        &["`radius` is a string", "expected a number"],
    );
}

#[test]
fn sizes_must_be_positive() {
    check(
        "[[boxes]]\nname = 'desk'\ncenter = [0, 0]\nsize = [1, 0] # fault",
        &["box `desk`", "`size` is 0", "more than 0"],
    );
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = -0.5 # fault",
        &["`radius` is -0.5"],
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
        &["is an integer", "[[x, y], ...]"],
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
        &["`way` has 1 points"],
    );
    check(
        "[[movers]]\nradius = 1\nway = [[0, 0], [1, 0]]\nspeed = 0 # fault",
        &["`speed` is 0"],
    );
    check(
        "[[people]]\nway = [[0, 0], [1, 0]]\nspeed = 20.1 # fault",
        &["`speed` is 20.1: expected at most 20 m/s"],
    );
    check(
        "[[movers]] # fault\nradius = 1\nway = [[0, 0], [1, 0]]",
        &["`speed` is missing"],
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
    check("[robots.r] # fault\n", &["`start` is missing"]);
    check("robots = { r = 3 } # fault", &["robot `r`", "expected a table"]);
}

#[test]
fn bounds_need_a_minimum_below_the_maximum() {
    check(
        "bounds = { min = [0, 0], max = [0, 4] } # fault",
        &["bounds", "`min`", "`max`"],
    );
    check("bounds = 3 # fault", &["expected { min"]);
    check(
        "reference_length = 0 # fault",
        &["`reference_length` is 0", "more than 0"],
    );
}

#[test]
fn a_value_of_the_wrong_type_is_reported() {
    check("boxes = 3 # fault", &["`boxes` is an integer", "array of tables"]);
    check(
        "boxes = [\n  3, # fault\n]",
        &["box 1 is an integer", "expected a table"],
    );
    check("name = 3 # fault", &["`name` is an integer", "text"]);
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
    assert_eq!(error.lines().count(), 4, "one line for each fault: {error}");
}

#[test]
fn a_missing_world_file_is_reported() {
    let error = World::load("no/such/world.toml", 0).err().unwrap().to_string();
    assert!(
        error.starts_with("no/such/world.toml: cannot read the world"),
        "{error}"
    );
}

#[test]
fn a_missing_map_is_reported_with_the_line_of_the_world() {
    check(
        "name = 'a'\nmap = 'none.yaml' # fault",
        &[
            "cannot read the map",
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
        warnings[0].to_string().starts_with("w.toml:1: no walls"),
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
        ["w.toml:2: the way of mover `anna` crosses `pillar`: the mover passes through"]
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
            assert!(error.faults().iter().all(|fault| fault.line.is_some()), "{error}");
        }
    }
}

#[test]
fn colours_are_hexadecimal_or_known_names() {
    check(
        "[[circles]]\ncenter = [0, 0]\nradius = 1\ncolor = 'grean' # fault",
        &[
            "circle 1",
            "`color` is `grean`",
            "#rrggbb",
            "did you mean `green`?",
        ],
    );
    check("floor = '#12345' # fault", &["`floor` is `#12345`", "`orange`"]);
    check("light = 3 # fault", &["`light` is not a table", "from_deg"]);
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
        &["wall 1", "`reflectivity` is -1", "0 to 1000"],
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
        &["box 1", "`mass` is 0", "more than 0"],
    );
    check(
        "[[people]]\nway = [[0, 0], [1, 0]]\nspeed = 1\npause = -1 # fault",
        &["person 1", "`pause` is -1"],
    );
    check(
        "[[people]]\nway = [[0, 0], [1, 0]]\nspeed = -1 # fault",
        &["person 1", "`speed` is -1"],
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

#[test]
fn of_many_faults_the_first_are_told_and_the_others_counted() {
    let keys: String = (0..50_000).map(|key| format!("k{key} = 1\n")).collect();
    let faults = faults(&keys);
    assert_eq!(faults.len(), 51);
    assert!(
        faults[0].starts_with("lab/w.toml:1: world: unknown key `k0`; expected one of `name`"),
        "{}",
        faults[0]
    );
    assert!(faults[49].starts_with("lab/w.toml:50: "), "{}", faults[49]);
    assert_eq!(
        faults[50],
        "lab/w.toml: and 49950 more faults; correct these first"
    );
}

#[test]
fn more_things_that_move_than_a_computer_can_compare_are_refused() {
    let balls = "{ center = [0, 0], radius = 0.1 },".repeat(2001);
    let balls = faults(&format!("balls = [{balls}]"));
    assert_eq!(
        balls,
        ["lab/w.toml:1: world: 2001 balls and movable boxes: expected at most 2000"]
    );
    let way = "{ way = [[0, 0], [1000, 0]], speed = 1, radius = 0.1 },".repeat(150);
    let ways = faults(&format!("movers = [{way}]"));
    assert!(
        ways[0].contains("the ways of all movers have more than 50 km"),
        "{ways:?}"
    );
}

#[test]
fn a_file_of_another_kind_is_named_as_what_it_is() {
    let map = faults("image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n");
    assert_eq!(
        map,
        [
            "lab/w.toml:1: it is the YAML file of a ROS map, and no world file: `jde new world NAME --from lab/w.toml` makes a \
          world of it"
        ]
    );
    for (text, expected) in [
        (
            "<sdf version='1.6'/>",
            "it is a world or a model in SDF, and no world file: `jde new world",
        ),
        (
            "#VRML_SIM R2023b utf8\nWorldInfo {\n}\n",
            "it is a world of Webots",
        ),
        ("define floor model ( )\nfloor ( )\n", "it is a world of Stage"),
    ] {
        let faults = faults(text);
        assert!(faults.len() == 1 && faults[0].contains(expected), "{faults:?}");
    }
    let picture = Path::new(env!("CARGO_TARGET_TMPDIR")).join("picture.toml");
    std::fs::write(&picture, b"P5 1 1 255\n\xff").unwrap();
    let error = World::load(&picture, 0).err().unwrap().to_string();
    assert!(error.contains("it is a picture, and no world file"), "{error}");
    let error = jde_sim::RobotModel::load(&picture).err().unwrap().to_string();
    assert!(
        error.contains("and no robot file: `jde new robot NAME`"),
        "{error}"
    );
}
