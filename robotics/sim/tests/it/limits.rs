//! Limits of world files, and files of other kinds: each is refused in words, and few of them.

use std::path::Path;

use jde_sim::World;

use crate::faults::faults;

#[test]
fn of_many_faults_the_first_are_told_and_the_others_counted() {
    let keys: String = (0..5_000).map(|key| format!("k{key} = 1\n")).collect();
    let error = World::parse(&keys, "lab/w.toml", 0).err().unwrap().to_string();
    assert!(
        error.starts_with("lab/w.toml:1:1: unknown key `k0` in the world\n    help: keys: `name`"),
        "{error}"
    );
    assert!(error.contains("\nlab/w.toml:40:1: "), "{error}");
    assert!(error.ends_with("\nand 4960 more"), "{error}");
    let error = faults(&(0..50_000).map(|key| format!("k{key} = 1\n")).collect::<String>());
    assert_eq!(
        error,
        ["lab/w.toml:1:1: the file has 50000 entries, and one table may have 10000"]
    );
}

#[test]
fn more_things_that_move_than_a_computer_can_compare_are_refused() {
    let balls = "{ center = [0, 0], radius = 0.1 },".repeat(2001);
    let balls = faults(&format!("balls = [{balls}]"));
    assert_eq!(
        balls,
        ["lab/w.toml:1:1: the world has 2001 balls and movable boxes: expected at most 2000"]
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
            "lab/w.toml: it is the YAML file of a ROS map, and no world file: `jde new world NAME --from lab/w.toml` makes a \
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
