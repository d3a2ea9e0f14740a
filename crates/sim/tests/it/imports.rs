//! Worlds of other programs: they become world files with the same things in the same places.

use std::fs;
use std::path::{Path, PathBuf};

use jde_sim::{ImportedWorld, RobotConfig, World, WorldError};
use proptest::prelude::*;

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
        .map(|fault| format!("{}: {}", fault.line.unwrap_or_default(), fault.message))
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
            "2: `x` is no number of a world",
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
    let faults = faults("long.txt", &"0 x,1\n".repeat(10_000));
    assert_eq!(
        (faults.len(), faults[50].as_str()),
        (51, "0: and 9950 more faults; correct these first")
    );
}

const SDF: &str = r#"<?xml version="1.0"?>
<sdf version="1.6">
  <world name="lab">
    <include><uri>model://sun</uri></include>
    <model name="floor"><link name="l"><collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
    <model name="shelf">
      <pose>1 2 0 0 0 1.5707963267948966</pose>
      <link name="l">
        <pose>1 0 0.5 0 0 0</pose>
        <collision name="c"><geometry><box><size>2 1 1</size></box></geometry></collision>
      </link>
    </model>
    <model name="pillar">
      <pose>9 9 0.5 0 0 0</pose>
      <link name="l"><collision name="c"><geometry><cylinder><radius>0.2</radius><length>1</length></cylinder></geometry></collision></link>
    </model>
    <model name="lamp">
      <pose>0 0 2 0 0 0</pose>
      <link name="l"><collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link>
    </model>
    <model name="ramp">
      <link name="l"><collision name="c"><pose>0 0 0 0 0.3 0</pose><geometry><box><size>1 1 1</size></box></geometry></collision></link>
    </model>
    <model name="chair">
      <link name="l"><collision name="c"><geometry><mesh><uri>chair.dae</uri></mesh></geometry></collision></link>
    </model>
    <state world_name="lab"><model name="pillar"><pose>5 0 0.5 0 0 0</pose></model></state>
  </world>
</sdf>"#;

#[test]
fn the_upright_things_of_an_sdf_world_stand_where_it_puts_them() {
    let worlds = import("lab.sdf", SDF).unwrap();
    assert_eq!(
        worlds[0].notes,
        [
            "model://sun is another file and is left out.",
            "a sphere of `lamp` is 1.90 m above the floor and is left out.",
            "`ramp` is tilted and is left out.",
            "`chair` has a mesh, which is left out.",
        ]
    );
    let world = world(&worlds[0]);
    assert_eq!((world.name(), world.shapes().count()), ("lab", 2));
    // The pillar stands where the saved state has it.
    let pillar = world.cast_ray([3.0, 0.0], 0.0, 10.0, None);
    assert!((pillar.unwrap() - 1.8).abs() < 1e-9, "{pillar:?}");
    // The shelf is turned to the left: its centre is one metre to the left of its model, its long side along y.
    let (side, end) = (
        world.cast_ray([-2.0, 3.0], 0.0, 10.0, None),
        world.cast_ray([1.0, 0.0], std::f64::consts::FRAC_PI_2, 10.0, None),
    );
    assert!((side.unwrap() - 2.5).abs() < 1e-6, "{side:?}");
    assert!((end.unwrap() - 2.0).abs() < 1e-6, "{end:?}");
}

#[test]
fn faults_of_an_sdf_world_have_their_lines() {
    let model = |inside: &str| format!("<sdf>\n<model name='m'>\n{inside}\n</model>\n</sdf>");
    let link = |shape: &str| {
        model(&format!(
            "<link><collision><geometry>{shape}</geometry></collision></link>"
        ))
    };
    let text = faults("pose.sdf", &model("<pose>1 2 3</pose>"));
    assert_eq!(
        text,
        ["3: the pose of `m` is wrong: expected x y z roll pitch yaw"]
    );
    let text = faults("size.sdf", &link("<box><size>1 -1 1</size></box>"));
    assert_eq!(
        text,
        ["3: the size of `m` is wrong: expected 3 above 0, in metres"]
    );
    let text = faults("missing.sdf", &link("<cylinder><radius>1</radius></cylinder>"));
    assert_eq!(text, ["3: the cylinder of `m` has no size"]);
    let text = faults("nothing.sdf", "<sdf>\n<world name='w'/></sdf>");
    assert_eq!(
        text,
        ["2: has no box, cylinder or sphere that stands on the floor"]
    );
    assert_eq!(
        faults("page.sdf", "<html/>"),
        ["1: `html` is no SDF: expected <sdf>"]
    );
    assert_eq!(faults("cut.sdf", "<sdf>\n<world>").len(), 1);
    let absent = jde_sim::import(Path::new("absent.sdf"), &[], "lab").expect_err("there is no such file");
    assert!(absent.to_string().contains("absent.sdf"), "{absent}");
}

proptest! {
    #[test]
    fn no_name_of_an_sdf_world_spoils_the_text(name in "[^<&\\x00-\\x1f]{0,12}") {
        let name = name.replace('\'', "&apos;");
        let text = SDF.replace("'lab'", "x").replace("\"shelf\"", &format!("'{name}'"));
        if let Ok(worlds) = import("named.sdf", &text) {
            world(&worlds[0]);
        }
    }

    #[test]
    fn cut_files_are_refused_or_converted(end in 0usize..SDF.len()) {
        prop_assume!(SDF.is_char_boundary(end));
        let _ = import("part.sdf", &SDF[..end]);
    }
}
