//! Worlds of other programs: they become world files with the same things in the same places.

use std::fs;
use std::path::{Path, PathBuf};

use jde_sim::{ImportedWorld, RobotConfig, World, WorldError};

/// Writes a file for one test, and converts it.
fn import(name: &str, text: &str) -> Result<Vec<ImportedWorld>, WorldError> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("imports");
    fs::create_dir_all(&folder).unwrap();
    let file = folder.join(name);
    fs::write(&file, text).unwrap();
    jde_sim::import(&file, &[], "lab")
}

fn faults(name: &str, text: &str) -> Vec<String> {
    let error = import(name, text).expect_err("the file has faults");
    let faults = error.faults().iter();
    faults
        .map(|fault| format!("{}: {}", fault.line().unwrap_or_default(), fault.message))
        .collect()
}

fn world(imported: &ImportedWorld) -> World {
    World::parse(&imported.text, PathBuf::from("imported.toml"), 1)
        .unwrap_or_else(|error| panic!("{error}\n{}", imported.text))
}

#[test]
fn each_line_of_a_list_is_a_world_in_which_the_robot_of_the_challenge_starts() {
    let list = "0 -4.5,3 -2.25,8\n\n12 -2.25,13\n";
    let worlds = import("barn.txt", list).unwrap();
    let names: Vec<_> = worlds.iter().map(|world| world.name.as_str()).collect();
    assert_eq!(names, ["000", "012"]);
    let mut first = world(&worlds[0]);
    assert_eq!(first.name(), "barn 0");
    assert_eq!(first.shapes().count(), 2);
    let robot = first.add_robot("robot", RobotConfig::default()).unwrap();
    let pose = first.truth(robot).pose;
    let ahead = first.cast_ray([pose.x, pose.y], pose.heading, 30.0, Some(robot));
    // The robot looks at the second cylinder, whose radius is 7.5 cm.
    assert!((ahead.unwrap() - 4.925).abs() < 1e-9, "{ahead:?}");
}

#[test]
fn every_fault_of_a_list_has_its_line() {
    assert_eq!(
        faults("faulty.txt", "0 1,2\nx 1,2\n1 1;2\n2\n3 1,nan\n0 3,4"),
        [
            "2: `x` is not a number of a world",
            "3: `1;2` is no centre: expected X,Y in metres",
            "4: has no cylinder: expected `NUMBER X,Y X,Y ...`",
            "5: `1,nan` is no centre: expected X,Y in metres",
            "6: world 0 is there twice",
        ]
    );
    assert_eq!(
        faults("empty.txt", "\n"),
        ["0: it is an empty file, and no world file: give a world"]
    );
}

#[test]
fn a_ros_map_becomes_a_world_with_a_copy_of_it() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("imports");
    fs::create_dir_all(&folder).unwrap();
    fs::write(
        folder.join("hall.ppm"),
        "P3 3 3 1 0 0 0 0 0 0 0 0 0 0 0 0 1 1 1 0 0 0 0 0 0 0 0 0 0 0 0",
    )
    .unwrap();
    let yaml = "\u{feff}image: hall.ppm\nresolution: '0.5'\norigin: [-1, 0, 0]\nfloor: 3\n";
    let world = &import("hall.yaml", yaml).unwrap()[0];
    let names: Vec<_> = world.files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        (world.name.as_str(), names),
        ("lab", vec!["lab-map.yaml", "lab-map.pgm"])
    );
    let report: Vec<_> = world.report().collect();
    assert_eq!(
        report,
        [
            "The robot starts at (-0.25, 0.75).",
            "the key `floor` is left out: no map server reads it (line 4)"
        ]
    );
    let converted = folder.join("hall");
    fs::create_dir_all(&converted).unwrap();
    for (name, contents) in &world.files {
        fs::write(converted.join(name), contents).unwrap();
    }
    let world = World::parse(&world.text, converted.join("lab.toml"), 1).unwrap();
    assert_eq!(world.cast_ray([-0.25, 0.75], 0.0, 9.0, None), Some(0.25));
}

#[test]
fn a_map_of_moving_ai_becomes_a_world_of_cells_of_a_metre() {
    let text = "type octile\nheight 3\nwidth 4\nmap\n@@@@\n@..T\n@@@@\n";
    let world = &import("arena.map", text).unwrap()[0];
    let notes = ["The robot starts at (1.50, 1.50).", "A cell is 1 m wide"];
    assert!(
        world
            .notes
            .iter()
            .zip(notes)
            .all(|(note, start)| note.starts_with(start)),
        "{:?}",
        world.notes
    );
    assert!(world.text.contains("map = \"lab-map.yaml\""), "{}", world.text);
}

#[test]
fn a_packed_file_is_converted_as_what_is_in_it() {
    use std::io::Write;
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("imports");
    fs::create_dir_all(&folder).unwrap();
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all("\u{feff}0 1,2\n1 3,4\n".as_bytes()).unwrap();
    let file = folder.join("list.gz");
    fs::write(&file, packed.finish().unwrap()).unwrap();
    assert_eq!(jde_sim::import(&file, &[], "lab").unwrap().len(), 2);
}

#[test]
fn a_file_that_cannot_be_converted_is_named_as_what_it_is() {
    for (text, expected) in [
        (
            "#VRML_SIM R2023b utf8\nWorldInfo {}\n",
            "it is a world of Webots, and no world file: its format is read by Webots",
        ),
        (
            "<robot name='r'/>",
            "it is a robot in URDF or Xacro, and no world file: a robot is described by a robot file",
        ),
        ("<COLLADA/>", "it is a mesh, and no world file: a world has walls"),
        ("solid a\nfacet normal 0 0 1\n", "it is a mesh"),
        ("  0\nSECTION\n  2\nENTITIES\n", "it is a drawing in DXF"),
        ("#usda 1.0\n", "it is a scene in USD"),
        (
            "P2 1 1 255 0\n",
            "it is a picture, and no world file: a picture states no lengths: write a YAML file",
        ),
        (
            "name = \"room\"\n",
            "it is a TOML file, such as a world, and no world file: name it in an application",
        ),
        ("\u{1}\0", "it is a binary file of an unknown kind"),
    ] {
        let faults = faults("other", text);
        assert!(faults.len() == 1 && faults[0].contains(expected), "{faults:?}");
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("imports/folder");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("hall.yaml"), "").unwrap();
    let error = jde_sim::import(&folder, &[], "lab").unwrap_err().to_string();
    assert!(
        error.contains("it is a folder: give a file in it, such as `"),
        "{error}"
    );
}

#[test]
fn of_many_faults_of_a_list_the_first_are_told() {
    let error = import("long.txt", &"0 x,1\n".repeat(10_000))
        .unwrap_err()
        .to_string();
    assert!(error.ends_with("\nand 9960 more"), "{error}");
    assert_eq!(error.lines().count(), 41, "{error}");
}
