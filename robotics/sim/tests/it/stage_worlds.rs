//! Worlds of Stage: they become world files with the same things in the same places.

use std::fs;
use std::path::{Path, PathBuf};

use jde_sim::{ImportedWorld, RobotConfig, World, WorldError};
use proptest::prelude::*;

/// Definitions, as a file that others include.
const THINGS: &str = r#"
define floor model ( boundary 1 )
define crate model ( color "red" origin [ 0.5 0 0 0 ] )   # a comment
define prism model
(
  size [ 2 2 1 ]
  block ( points 3 point[0] [ 0 0 ] point[1] [ 10 0 ] point[2] [ 0 10 ] z [ 0 5 ] )
)
define goal model ( obstacle_return 0 ranger_return -1 )
define lamp model ( size [ 0.2 0.2 0.2 ] model ( name "shade" size [ 1 1 0.1 ] pose [ 0 0 0.5 0 ] ) camera ( ) )
define rover position ( size [ 0.4 0.4 0.4 ] ranger ( sensor ( fov 180 ) ) )
"#;

const WORLD: &str = r#"# A world
include "things.inc"
speedup 2
window ( size [ 600 400 ] center [ 0 0 ] )
floor ( name "house" bitmap "house.pgm" size [ 4 2 1 ] pose [ 10 5 0 90 ] )
crate ( name "chest" pose [ 1 2 0 90 ] size [ 2 1 0.5 ] )
prism ( pose [ -3 0 0 0 ] )
goal ( )
lamp ( name "lamp" pose [ 20 20 0 0 ] )
rover ( name "r0" pose [ 3 4 0 45 ] )
rover ( pose [ 5 4 0 -90 ] )
rover ( pose [ 6 4 0 0 ] )
"#;

/// Two rows of four pixels, the lower one with a gap, in a white margin.
const HOUSE: &str = "P2\n6 4\n255\n\
    255 255 255 255 255 255\n255 0 0 0 0 255\n255 0 200 200 0 255\n255 255 255 255 255 255\n";

/// Returns a folder with the files above, for one test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("stage").join(name);
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("things.inc"), THINGS).unwrap();
    fs::write(folder.join("house.pgm"), HOUSE).unwrap();
    folder
}

/// Writes a world into a folder, and converts it.
fn import(folder: &Path, text: &str) -> Result<ImportedWorld, WorldError> {
    let file = folder.join("lab.world");
    fs::write(&file, text).unwrap();
    let [world] = <[_; 1]>::try_from(jde_sim::import(&file, &[], "lab")?).expect("a file is one world");
    Ok(world)
}

/// Writes the converted world and its files beside each other, and loads it.
fn load(folder: &Path, imported: &ImportedWorld) -> Result<World, WorldError> {
    let converted = folder.join("converted");
    fs::create_dir_all(&converted).unwrap();
    for (name, contents) in &imported.files {
        fs::write(converted.join(name), contents).unwrap();
    }
    let file = converted.join("lab.toml");
    fs::write(&file, &imported.text).unwrap();
    World::load(&file, 1)
}

fn faults(name: &str, text: &str) -> Vec<String> {
    let folder = folder(name);
    let error = import(&folder, text).expect_err("the file has faults");
    let faults = error.faults().iter().map(|fault| {
        let file = fault.location.file().expect("a fault of a file");
        let file = file.strip_prefix(&folder).expect("a file of the world");
        format!(
            "{}:{}: {}",
            file.display(),
            fault.line().unwrap_or_default(),
            fault.message
        )
    });
    faults.collect()
}

#[test]
fn models_stand_where_stage_puts_them() {
    let folder = folder("models");
    let imported = import(&folder, WORLD).unwrap();
    assert_eq!((imported.name.as_str(), imported.files.len()), ("lab", 2));
    let world = load(&folder, &imported).unwrap();
    let free =
        |x: f64, y: f64, degrees: f64| world.cast_ray([x, y], degrees.to_radians(), 30.0, None).unwrap();
    let rays = [
        // The chest, whose origin is half a metre behind its centre.
        ((1.0, 8.0, -90.0), 4.5),
        ((3.0, 2.5, 180.0), 1.5),
        // The prism, stretched over its size, and its slope.
        ((-3.0, -5.0, 90.0), 4.0),
        ((-2.0, 0.5, 180.0), 1.5),
        // Inside the house, whose bitmap is turned, and its boundary.
        ((10.5, 5.0, 0.0), 0.5),
        ((10.5, 5.0, 180.0), 0.5),
        ((10.5, 5.0, 90.0), 1.0),
        ((10.5, 5.0, -90.0), 1.0),
        ((10.0, 12.0, -90.0), 5.0),
        // The lamp's foot.
        ((20.0, 22.0, -90.0), 1.9),
    ];
    for ((x, y, degrees), expected) in rays {
        let range = free(x, y, degrees);
        assert!(
            (range - expected).abs() < 1e-6,
            "{range} m from {x}, {y} at {degrees}°"
        );
    }
    let report = [
        "3 robots: their starts are kept, their bodies and sensors are left out.",
        "`goal` is left out: it is a mark, which no laser sees and which stops no robot (lab.world:8)",
        "`lamp.camera`, a camera, is left out: the robot of an application has the sensors (things.inc:10)",
        "`lamp.shade` is left out: it is 0.70 m above the floor (things.inc:10)",
    ];
    assert_eq!(imported.report().collect::<Vec<_>>(), report);
}

#[test]
fn robots_start_where_they_stand() {
    let folder = folder("robots");
    let mut world = load(&folder, &import(&folder, WORLD).unwrap()).unwrap();
    for (name, x, degrees) in [
        ("r0", 3.0, 45.0_f64),
        ("rover", 5.0, -90.0),
        ("rover 2", 6.0, 0.0),
    ] {
        let robot = world.add_robot(name, RobotConfig::default()).unwrap();
        let pose = world.truth(robot).pose;
        assert!((pose.x - x).abs() < 1e-9 && (pose.y - 4.0).abs() < 1e-9);
        assert!(
            (pose.heading - degrees.to_radians()).abs() < 1e-9,
            "{name}: {pose:?}"
        );
    }
}

#[test]
fn every_fault_names_its_file_and_line() {
    let one = |name: &str, text: &str, expected: &str| assert_eq!(faults(name, text), [expected]);
    one(
        "unknown",
        "model ( )\ntable ( )",
        "lab.world:2: `table` is no model: define it, or include the file that does",
    );
    one(
        "pose",
        "model ( pose [ 1 2 ] )",
        "lab.world:1: `pose` is wrong: expected 4 numbers",
    );
    one(
        "size",
        "model (\n size [ 1 0 1 ] )",
        "lab.world:1: the size of `model` is wrong: expected lengths above 0",
    );
    one(
        "flat",
        "model ( size [ 1 x ] )",
        "lab.world:1: `size` is wrong: expected 3 numbers",
    );
    one(
        "open",
        "model (\nname \"a\"",
        "lab.world:1: has no `)` at its end",
    );
    one(
        "close",
        "model ( )\n)",
        "lab.world:2: `)` is not expected here: a word is",
    );
    one(
        "tuple",
        "model ( pose [ 1 2 3 4 )",
        "lab.world:1: `pose` has no `]` at its end",
    );
    one(
        "text",
        "model ( name \"a )",
        "lab.world:1: a text has no `\"` at its end on this line",
    );
    one(
        "number",
        "model ( mass 1.2.3 )",
        "lab.world:1: `1.2.3` is not a number",
    );
    one("letter", "model ( mass ? )", "lab.world:1: `?` is not a number");
    one(
        "define",
        "define a (\n",
        "lab.world:1: `define` needs a new name, a known one and `(`",
    );
    one(
        "name",
        "include things.inc",
        "lab.world:1: `include` needs the name of a file in quotes",
    );
    one(
        "empty",
        "speedup 1",
        "lab.world:1: has no model that stands on the floor",
    );
    one(
        "unit",
        "unit_angle \"gon\"\nmodel ( )",
        "lab.world:1: `unit_angle` is \"gon\": expected one of \"degrees\", \"radians\"",
    );
    let block = "a block needs `points`, 3 or more, and `point[0] [x y]` and so on";
    one(
        "block",
        "model (\nblock ( points 3 point[0] [ 0 0 ] ) )",
        &format!("lab.world:2: {block}"),
    );
    let missing = faults("missing", "\ninclude \"none.inc\"");
    assert!(
        missing[0].starts_with("lab.world:2: cannot read `") && missing[0].contains("none.inc"),
        "{missing:?}"
    );
    let picture = faults("picture", "model ( )\nmodel ( bitmap \"things.inc\" )");
    assert!(
        picture[0].starts_with("lab.world:2: ") && picture[0].contains("things.inc"),
        "{picture:?}"
    );
    assert_eq!(
        faults("two", "table ( )\nmodel ( pose [ ] )").len(),
        1,
        "a property without numbers is none"
    );
}

#[test]
fn endless_worlds_are_refused() {
    let itself = faults("itself", "include \"lab.world\"");
    assert_eq!(itself, ["lab.world:1: more than 64 files include each other"]);
    let deep = faults("deep", &"model ( ".repeat(1000));
    assert_eq!(
        deep,
        ["lab.world:1: has more than 64 levels of entities or definitions"]
    );
    let doubled = |level: u32| format!("define m{} model ( m{level} ( ) m{level} ( ) )\n", level + 1);
    let many: String = (1..20).map(doubled).collect();
    let many = faults("many", &format!("define m1 model ( )\n{many}m20 ( )\n"));
    assert!(many[0].contains("too large with its definitions"), "{many:?}");
    let nested: String = (1..2000)
        .map(|level| format!("define m{} model ( m{level} ( ) )\n", level + 1))
        .collect();
    let nested = faults("nested", &format!("define m1 model ( )\n{nested}m1999 ( )\n"));
    assert!(
        nested[0].ends_with("more than 64 levels of entities or definitions"),
        "{nested:?}"
    );
    let folder = folder("included");
    for level in 0..30 {
        let twice = format!("include \"{}.inc\"\n", level + 1).repeat(2);
        fs::write(folder.join(format!("{level}.inc")), twice).unwrap();
    }
    fs::write(folder.join("30.inc"), "speedup 1\n".repeat(100)).unwrap();
    let included = faults("included", "include \"0.inc\"");
    assert!(
        included[0].contains("too large with its definitions"),
        "{included:?}"
    );
    let wide = "model ( bitmap \"house.pgm\" size [ 1e9 1 1 ] )";
    assert!(faults("wide", wide)[0].contains("expected at most"));
}

/// One world with a bitmap of these pixels over 2 x 1 m, in colours.
fn bitmap(name: &str, pixels: &[[u8; 3]]) -> Result<World, WorldError> {
    let folder = folder(name);
    let header = format!("P6 {} 1 255\n", pixels.len()).into_bytes();
    fs::write(folder.join("lines.ppm"), [header, pixels.concat()].concat()).unwrap();
    let text = format!("model ( bitmap \"lines.ppm\" size [ {} 1 1 ] )", pixels.len());
    load(&folder, &import(&folder, &text)?)
}

#[test]
fn a_pixel_is_a_wall_if_its_red_is_dark() {
    let (black, red, blue, white) = ([0; 3], [255, 0, 0], [0, 0, 255], [255; 3]);
    let world = bitmap("red", &[black, red, white, blue]).unwrap();
    // The pixels are a metre wide, and the second and the third are free.
    let range = |world: &World, heading| world.cast_ray([0.0, 0.0], heading, 9.0, None).unwrap();
    assert!((range(&world, 0.0) - 1.0).abs() < 1e-6);
    assert!((range(&world, std::f64::consts::PI) - 1.0).abs() < 1e-6);
    let gray = bitmap("gray", &[[127; 3], [128; 3], [127; 3]]).unwrap();
    assert!((range(&gray, 0.0) - 0.5).abs() < 1e-6);
    assert!(bitmap("white", &[white]).is_err(), "nothing stands there");
}

#[test]
fn names_of_older_versions_mean_what_they_meant() {
    let folder = folder("older");
    let text = "unit_length \"cm\"\nunit_angle \"radians\"\n\
        model ( size3 [ 200 100 50 ] pose4 [ 300 0 0 1.5707963267948966 ] laser ( ) range_max 8 )\n\
        model ( size [ 100 100 ] pose [ -300 0 0 ] laser_return 0 )\n";
    let imported = import(&folder, text).unwrap();
    let report: Vec<_> = imported.report().collect();
    assert_eq!(
        report,
        [
            "`model.laser`, a laser, is left out: the robot of an application has the sensors (lab.world:3)",
            "`ranger_return` of `model` is left out: what stops robots is seen by lasers in a world, and what is seen stops \
             them (lab.world:4)",
            "the property `range_max` is left out: a world has no such thing (lab.world:3)",
        ]
    );
    let world = load(&folder, &imported).unwrap();
    let range = |degrees: f64| {
        world
            .cast_ray([0.0, 0.0], degrees.to_radians(), 9.0, None)
            .unwrap()
    };
    assert!((range(0.0) - 2.5).abs() < 1e-6 && (range(180.0) - 2.5).abs() < 1e-6);
}

#[test]
fn definitions_and_files_are_found_as_stage_finds_them() {
    let folder = folder("found");
    let inner = folder.join("inner");
    fs::create_dir_all(&inner).unwrap();
    // The file in the inner folder names others beside the world, and beside itself.
    fs::write(
        inner.join("a.inc"),
        "include \"things.inc\"\rinclude \"b.inc\"\rdefine later crate ( size [ 2 1 1 ] )\r",
    )
    .unwrap();
    fs::write(inner.join("b.inc"), b"# M\xfcller\nlater ( name \"first\" )").unwrap();
    let text = "include \"inner/a.inc\"\ndefine later model ( )\nlater ( pose [ 0 5 0 0 ] )";
    let late = faults("found", text);
    assert_eq!(
        late,
        ["inner/b.inc:2: `later` is no model: define it, or include the file that does"]
    );
    fs::write(inner.join("b.inc"), "").unwrap();
    let imported = import(&folder, text).unwrap();
    let report: Vec<_> = imported.report().collect();
    assert_eq!(
        report,
        ["the second definition of `later` is left out: the first one counts, as in Stage (lab.world:2)"]
    );
    // A crate of 2 m, whose origin is half a metre behind its centre.
    let world = load(&folder, &imported).unwrap();
    let range = world.cast_ray([-5.0, 5.0], 0.0, 9.0, None).unwrap();
    assert!((range - 4.5).abs() < 1e-6, "{range}");
}

#[test]
fn the_files_of_a_world_have_its_name() {
    let folder = folder("named");
    let imported = import(&folder, WORLD).unwrap();
    let names: Vec<_> = imported.files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["lab-map.yaml", "lab-map.pgm"]);
}

proptest! {
    #[test]
    fn cut_and_changed_worlds_are_refused_or_converted(
        cut in 0..WORLD.len(),
        end in 0..WORLD.len(),
        letters in "[ -~\n]{0,12}",
    ) {
        let folder = folder("changed");
        let (head, tail) = (&WORLD[..cut.min(end)], &WORLD[cut.max(end)..]);
        match import(&folder, &format!("#{head}{letters}{tail}")) {
            // Stage lets a robot start where another thing stands.
            Ok(imported) => if let Err(error) = load(&folder, &imported) {
                for fault in error.faults() {
                    prop_assert!(fault.message.ends_with("move it to free ground"), "{error}\n{}", imported.text);
                }
            },
            Err(error) => prop_assert!(!error.faults().is_empty()),
        }
    }
}
