//! ROS maps: their conversion to shapes, and the faults of invalid maps.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use jde_sim::{LaserConfig, RobotConfig, World};

/// Creates an empty folder for one test.
fn folder(test: &str) -> PathBuf {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    // Tests run in parallel, and some of them create several worlds.
    let name = format!("{test}-{}", NEXT.fetch_add(1, Ordering::Relaxed));
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("maps").join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

const YAML: &str = "image: m.pgm\nresolution: 0.5\norigin: [0, 0, 0]\n";
/// Four by three cells: the upper right one is a wall, the lower left one is unknown.
const PLAIN: &str = "P2\n# by hand\n4 3 # wide, high\n255\n254 254 254 0\n254 254 254 254\n205 254 254 254\n";

fn world(test: &str, yaml: &str, image: &[u8]) -> Result<World, String> {
    world_with_robots(test, yaml, image, "[robots.r]\nstart = { x = 1, y = 1 }")
}

fn world_with_robots(test: &str, yaml: &str, image: &[u8], robots: &str) -> Result<World, String> {
    let folder = folder(test);
    fs::write(folder.join("m.yaml"), yaml).unwrap();
    fs::write(folder.join("m.pgm"), image).unwrap();
    let text = format!("map = 'm.yaml'\n{robots}");
    World::parse(&text, folder.join("w.toml"), 0)
        .map_err(|error| error.to_string().replace(folder.to_str().unwrap(), ""))
}

fn assert_walls(world: &World) {
    let distance = |origin: [f64; 2], degrees: f64| world.cast_ray(origin, degrees.to_radians(), 50.0, None);
    // The wall is the cell from (1.5, 1.0) to (2.0, 1.5).
    assert!((distance([0.2, 1.2], 0.0).unwrap() - 1.3).abs() < 1e-9);
    assert!((distance([1.7, 0.2], 90.0).unwrap() - 0.8).abs() < 1e-9);
    assert_eq!(distance([0.2, 0.7], 0.0), None);
    assert_eq!(world.shapes().count(), 1);
    assert_eq!((world.bounds().min, world.bounds().max), ([0.0, 0.0], [2.0, 1.5]));
}

#[test]
fn a_plain_graymap_gives_walls() {
    assert_walls(&world("plain", YAML, PLAIN.as_bytes()).unwrap());
}

#[test]
fn a_raw_graymap_gives_walls_even_if_its_first_pixel_is_white_space() {
    let mut raw = b"P5 4 3\n# deep\n255\n".to_vec();
    raw.extend([254, 254, 254, 0, 254, 254, 254, 254, 205, 254, 254, 254]);
    assert_walls(&world("raw", YAML, &raw).unwrap());
    // The first pixel is 10, which is a line feed and nearly black: the cell is a wall.
    let mut white_space = b"P5 2 1 255\n".to_vec();
    white_space.extend([10, 254]);
    let world = world_with_robots("white_space", YAML, &white_space, "").unwrap();
    assert!(
        (world
            .cast_ray([0.9, 0.2], 180f64.to_radians(), 9.0, None)
            .unwrap()
            - 0.4)
            .abs()
            < 1e-9
    );
}

#[test]
fn a_raw_graymap_can_have_sixteen_bits() {
    let mut raw = b"P5 4 3 65535\n".to_vec();
    for shade in [
        65000u16, 65000, 65000, 100, 65000, 65000, 65000, 65000, 52000, 65000, 65000, 65000,
    ] {
        raw.extend(shade.to_be_bytes());
    }
    assert_walls(&world("deep", YAML, &raw).unwrap());
}

#[test]
fn a_png_is_recognized_by_its_first_bytes() {
    for color in [png::ColorType::Grayscale, png::ColorType::Rgba] {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 4, 3);
        encoder.set_color(color);
        let shades = [254, 254, 254, 0, 254, 254, 254, 254, 205, 254, 254, 254u8];
        let pixels: Vec<u8> = match color {
            png::ColorType::Rgba => shades
                .iter()
                .flat_map(|&shade| [shade, shade, shade, 255])
                .collect(),
            _ => shades.to_vec(),
        };
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&pixels).unwrap();
        writer.finish().unwrap();
        assert_walls(&world("png", YAML, &bytes).unwrap());
    }
}

#[test]
fn a_negated_map_has_white_walls() {
    let negated = "P2 4 3 255\n0 0 0 255\n0 0 0 0\n50 0 0 0\n";
    for negate in ["1", "true"] {
        assert_walls(
            &world(
                "negated",
                &format!("{YAML}negate: {negate}\n"),
                negated.as_bytes(),
            )
            .unwrap(),
        );
    }
}

#[test]
fn the_thresholds_determine_the_walls() {
    let image = "P2 2 1 100\n60 100\n";
    let distance = |yaml: String| {
        world_with_robots("thresholds", &yaml, image.as_bytes(), "")
            .unwrap()
            .cast_ray([0.9, 0.2], std::f64::consts::PI, 9.0, None)
    };
    // A shade of 60 % means that the cell is occupied with a probability of 40 %.
    assert_eq!(distance(YAML.to_owned()), None);
    assert!(distance(format!("{YAML}occupied_thresh: 0.39\nfree_thresh: 0.1\n")).is_some());
}

#[test]
fn the_origin_moves_and_turns_the_map() {
    let yaml = "image: m.pgm\nresolution: 0.5\norigin: [3.0, 4.0, 1.5707963267948966]\nmode: trinary\n";
    let world = world_with_robots(
        "turned",
        yaml,
        PLAIN.as_bytes(),
        "[robots.r]\nstart = { x = 2.25, y = 4.75 }",
    )
    .unwrap();
    // Columns extend up and rows to the left: the wall's cell is from (1.5, 5.5) to (2.0, 6.0).
    assert!((world.cast_ray([1.7, 4.2], 90f64.to_radians(), 9.0, None).unwrap() - 1.3).abs() < 1e-9);
    assert!(
        (world
            .cast_ray([2.9, 5.7], 180f64.to_radians(), 9.0, None)
            .unwrap()
            - 0.9)
            .abs()
            < 1e-9
    );
}

#[test]
fn a_robot_can_only_start_on_free_ground_of_the_map() {
    for (x, y, reason) in [
        (0.2, 0.2, "on unknown ground of `m.yaml`"),
        (1.7, 1.2, "inside `m.yaml`"),
        (2.1, 0.7, "outside the map `m.yaml`"),
    ] {
        let error = world_with_robots(
            "starts",
            YAML,
            PLAIN.as_bytes(),
            &format!("[robots.r]\nstart = {{ x = {x}, y = {y} }}"),
        );
        let error = error.err().unwrap();
        assert!(
            error.starts_with("/w.toml:3:9: robot `r` starts") && error.contains(reason),
            "{error}"
        );
    }
}

#[test]
fn a_large_map_gives_few_shapes() {
    let side = 1000;
    let mut raw = format!("P5 {side} {side} 255\n").into_bytes();
    // Rooms of 50 cells behind walls of 2 cells.
    raw.extend((0..side * side).map(|i| {
        if i % side % 50 < 2 || i / side % 50 < 2 {
            0
        } else {
            254
        }
    }));
    let yaml = "image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n";
    let mut world =
        world_with_robots("large", yaml, &raw, "[robots.r]\nstart = { x = 1.3, y = 1.3 }").unwrap();
    assert_eq!(world.shapes().count(), 20 + 20 * 20);
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    let laser = LaserConfig {
        sigma: 0.0,
        ..LaserConfig::default()
    };
    let mut ranges = vec![0.0; laser.beams];
    world.laser(robot, &laser, &mut ranges).unwrap();
    assert!((ranges[90] - (2.5 - 1.318)).abs() < 1e-5, "{}", ranges[90]);
}

#[test]
fn a_map_of_noise_is_refused_before_its_walls_are_made() {
    let side = 1100;
    let mut raw = format!("P5 {side} {side} 255\n").into_bytes();
    raw.extend((0..side * side).map(|index| {
        if (index % side + index / side) % 2 == 0 {
            0
        } else {
            254
        }
    }));
    let error = world("chess", YAML, &raw).err().unwrap();
    assert!(error.contains("more than 500000 separate walls"), "{error}");
}

#[test]
fn a_probability_is_taken_for_what_robots_take_it_for() {
    // 10 %, 50 % and 90 %, as their numbers.
    let raw = b"P5 3 1 255\n\x0a\x32\x5a";
    let yaml = format!("{YAML}mode: raw\nfloor: 2\n");
    let start = |x| format!("[robots.r]\nstart = {{ x = {x}, y = 0.25 }}");
    let world = world_with_robots("raw", &yaml, raw, &start(0.25)).unwrap();
    assert_eq!(world.shapes().count(), 1);
    let [warning] = world.warnings() else {
        panic!("{:?}", world.warnings());
    };
    assert_eq!(
        warning.message,
        "the key `floor` is left out: no map server reads it (line 5)"
    );
    for (x, reason) in [(0.75, "on unknown ground"), (1.25, "inside `m.yaml`")] {
        let error = world_with_robots("raw", &yaml, raw, &start(x)).err().unwrap();
        assert!(error.contains(reason), "{error}");
    }
}

/// Checks that there is one fault of the map, at `location`, and that its message contains `parts`.
fn check(yaml: &str, image: &[u8], location: &str, parts: &[&str]) {
    let error = world("faults", yaml, image).err().expect("the map has a fault");
    assert!(error.starts_with(location), "{error}");
    for part in parts {
        assert!(error.contains(part), "`{part}` is not in: {error}");
    }
}

#[test]
fn faults_of_the_yaml_are_reported_with_their_line() {
    let with = |line: &str| format!("{YAML}{line}\n");
    let image = PLAIN.as_bytes();
    check(
        "image: m.pgm\nresolution: -1\norigin: [0, 0, 0]",
        image,
        "/m.yaml:2:",
        &["`resolution` is -1", "more than 0"],
    );
    check(
        "image: m.pgm\nresolution: .nan\norigin: [0, 0, 0]",
        image,
        "/m.yaml:2:",
        &["`resolution` is not a number"],
    );
    check(
        "image: m.pgm\nresolution: 1\norigin: [0, 0]",
        image,
        "/m.yaml:3:",
        &["`origin`", "[x, y, yaw]"],
    );
    check(
        "image: m.pgm\nresoluton: 1\norigin: [0, 0, 0]",
        image,
        "/w.toml:1:7: `map` of the world: /m.yaml: ",
        &["`resolution` is missing", "is `resoluton` meant for it?"],
    );
    check(
        &with("negate: perhaps"),
        image,
        "/m.yaml:4:",
        &["`negate` is no flag", "yes or no"],
    );
    check(
        &with("mode: colour"),
        image,
        "/m.yaml:4:",
        &["`mode` is none of `trinary`"],
    );
    check(
        &with("free_thresh: 0.9"),
        image,
        "/m.yaml:4:",
        &["`free_thresh` is 0.9", "0.65"],
    );
    check(
        &with("occupied_thresh: 7"),
        image,
        "/m.yaml:4:",
        &["`occupied_thresh` is 7", "0 to 1"],
    );
    check(
        "just words",
        image,
        "/w.toml:1:7: `map` of the world: /m.yaml: ",
        &["it is not the YAML file of a map"],
    );
    check(
        "image: m.pgm\norigin: [0, 0\nresolution: 1",
        image,
        "/m.yaml:3:",
        &["this is not YAML"],
    );
    check(
        "image: gone.pgm\nresolution: 1\norigin: [0, 0, 0]",
        image,
        "/gone.pgm: ",
        &["cannot read the image"],
    );
}

#[test]
fn a_world_that_names_the_image_of_a_map_is_told_so() {
    let folder = folder("image");
    fs::write(folder.join("m.pgm"), b"P5 1 1 255\n\xff").unwrap();
    let error = World::parse("map = 'm.pgm'", folder.join("w.toml"), 0)
        .err()
        .unwrap()
        .to_string();
    assert!(
        error.contains("m.pgm: it is a picture, and no ROS map: a picture states no lengths"),
        "{error}"
    );
}

#[test]
fn faults_of_a_graymap_are_reported_with_their_line() {
    check(YAML, b"P7\n4 3\n255\n", "/m.pgm: ", &["no known kind", "PGM"]);
    check(YAML, b"", "/m.pgm: ", &["no known kind"]);
    check(YAML, b"P2\n# c\nfour 3\n255\n", "/m.pgm:3: ", &["width missing"]);
    check(YAML, b"P2\n4 0\n255\n", "/m.pgm:2: ", &["height 0"]);
    check(
        YAML,
        b"P2\n4 3\n70000\n",
        "/m.pgm:3: ",
        &["greatest value 70000", "65535"],
    );
    check(
        YAML,
        b"P2\n4 3\n255\n1 2 3\n",
        "/m.pgm:3: ",
        &["ends early", "12 values"],
    );
    check(
        YAML,
        b"P2\n2 1\n100\n7\n101\n",
        "/m.pgm:5: ",
        &["pixel 101", "0 to 100"],
    );
    check(YAML, b"P5\n4 3\n255\n\x01\x02", "/m.pgm:4: ", &["2 of 12 bytes"]);
    check(YAML, b"P5 2 1 100\n\x01\x65", "/m.pgm:2: ", &["brighter", "100"]);
    check(
        YAML,
        b"P5\n1000000 1000000\n255\n",
        "/m.pgm:3: ",
        &["at most 100000000"],
    );
    check(YAML, b"\x89PNG\r\n\x1a\nrubbish", "/m.pgm: ", &["no valid PNG"]);
}
