//! Corrupted world files: each is either refused with an error, or gives the same result in two runs. The
//! files are mutants of the worlds of the project, the same ones in every run.

use std::fs;
use std::path::{Path, PathBuf};

use jde_sim::{LaserConfig, RobotConfig, Twist2, World, WorldError};

/// The number of mutants of each world. One mutant takes milliseconds.
const MUTANTS: u64 = 60;
/// The replacements of numbers: typing errors, and the limits of arithmetic.
const VALUES: [&str; 22] = [
    "0",
    "-0.0",
    "1e-320",
    "1e-13",
    "1e-9",
    "-1",
    "0.1",
    "3",
    "1e3",
    "99999.99999999",
    "1e5",
    "-1e5",
    "1e300",
    "nan",
    "inf",
    "9223372036854775807",
    "\"x\"",
    "true",
    "[]",
    "{}",
    "[1e5, 1e5]",
    "[[0, 0], [1e5, 0], [1e5, 1e-13]]",
];

/// A deterministic generator, so that every run gives the same mutants.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % limit
    }
}

fn worlds() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../worlds");
    let entries = fs::read_dir(folder).expect("the folder of worlds can be read");
    let mut files: Vec<_> = entries
        .map(|entry| entry.expect("the entry can be read").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    files.sort();
    files
}

/// Returns the ranges of the numbers in a text.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let is_part = |byte: u8| byte.is_ascii_digit() || byte == b'.' || byte == b'-';
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let length = bytes[at..].iter().take_while(|byte| is_part(**byte)).count();
        if length > 0 && bytes[at..at + length].iter().any(u8::is_ascii_digit) {
            found.push(at..at + length);
        }
        at += length.max(1);
    }
    found
}

fn mutant(text: &str, random: &mut Random) -> String {
    let mut text = text.to_owned();
    for _ in 0..=random.below(3) {
        match random.below(8) {
            0 => {
                let lines: Vec<_> = text.lines().collect();
                let removed = random.below(lines.len());
                text = [&lines[..removed], &lines[removed + 1..]].concat().join("\n");
            }
            1 => {
                let lines: Vec<_> = text.lines().collect();
                let repeated = random.below(lines.len());
                text = [&lines[..=repeated], &lines[repeated..]].concat().join("\n");
            }
            2 => {
                let at = random.below(text.len());
                if text.is_char_boundary(at) && text.is_char_boundary(at + 1) {
                    text.replace_range(at..=at, ["", "[", "]", "{", "\"", "=", ",", "#"][random.below(8)]);
                }
            }
            _ => {
                let numbers = numbers(&text);
                if !numbers.is_empty() {
                    let number = numbers[random.below(numbers.len())].clone();
                    text.replace_range(number, VALUES[random.below(VALUES.len())]);
                }
            }
        }
    }
    text
}

/// Runs a world with up to three robots. Returns the bits of all measurements, or `None` if the world is
/// refused.
fn run(text: &str, path: &Path) -> Option<Vec<u64>> {
    let mut world = match World::parse(text, path, 7) {
        Ok(world) => world,
        Err(error) => {
            let faults = error.faults();
            assert!(!faults.is_empty() && faults.iter().all(|fault| !fault.message.is_empty()));
            return None;
        }
    };
    let names: Vec<String> = world.robot_names().map(str::to_owned).collect();
    let mut robots = Vec::new();
    for name in names.iter().take(3) {
        match world.add_robot(name, RobotConfig::default()) {
            Ok(robot) => robots.push(robot),
            Err(WorldError::Faults(_)) => return None,
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
    let laser = LaserConfig::default();
    let mut ranges = vec![0.0; laser.beams];
    let mut measurements = Vec::new();
    for step in 1..=30_u64 {
        for robot in &robots {
            world
                .command(*robot, Twist2::new(0.3, 0.2))
                .expect("the command is valid");
        }
        world.advance_to(step * 20_000_000);
        for robot in &robots {
            let pose = world.truth(*robot).pose;
            assert!(
                pose.x.is_finite() && pose.y.is_finite() && pose.heading.is_finite(),
                "{pose:?}"
            );
            measurements.extend([pose.x.to_bits(), pose.y.to_bits()]);
            if step % 10 == 0 {
                world
                    .laser(*robot, &laser, &mut ranges)
                    .expect("the laser is valid");
                assert!(ranges.iter().all(|range| !range.is_nan()));
                measurements.extend(ranges.iter().map(|range| u64::from(range.to_bits())));
            }
        }
    }
    for shape in world.shapes() {
        assert!(!format!("{:?}", shape.outline).contains("NaN"), "{}", shape.name);
    }
    Some(measurements)
}

#[test]
fn a_corrupted_world_is_refused_or_gives_the_same_result_twice() {
    let (mut refused, mut completed) = (0, 0);
    for (number, path) in worlds().iter().enumerate() {
        let original = fs::read_to_string(path).expect("the world can be read");
        for seed in 0..MUTANTS {
            let text = mutant(&original, &mut Random(seed * 1_000 + number as u64));
            let result = std::panic::catch_unwind(|| (run(&text, path), run(&text, path)));
            let Ok((first, second)) = result else {
                panic!("mutant {seed} of {}:\n{text}", path.display());
            };
            assert_eq!(first, second, "mutant {seed} of {}:\n{text}", path.display());
            if first.is_some() {
                completed += 1
            } else {
                refused += 1
            }
        }
    }
    assert!(
        completed > 40 && refused > 40,
        "{completed} completed, {refused} refused"
    );
}

/// A way can be very long, and have legs whose length is rounded to 0.
#[test]
fn long_ways_are_checked_in_bounded_time_and_legs_of_length_0_are_refused() {
    let mover = |way: &str| format!("[[movers]]\nradius = 0.3\nspeed = 1.0\nway = {way}\n");
    let long: Vec<_> = (0..2_000)
        .map(|leg| if leg % 2 == 0 { "[-1e5, 0]" } else { "[1e5, 0]" })
        .collect();
    let world = World::parse(&mover(&format!("[{}]", long.join(", "))), "long.toml", 0);
    world.expect("the world is valid").advance_to(1_000_000_000);
    let near = World::parse(&mover("[[0, 0], [1e5, 0], [1e5, 1e-13]]"), "near.toml", 0);
    let error = near.err().expect("the leg is refused").to_string();
    assert!(error.contains("point 3"), "{error}");
}

/// The data of a device may never end.
#[test]
fn worlds_and_maps_must_be_regular_files() {
    let error = World::load("/dev/zero", 0)
        .err()
        .expect("a device is refused")
        .to_string();
    assert!(error.contains("not a regular file"), "{error}");
    let error = World::parse("map = \"/dev/zero\"\n", "w.toml", 0)
        .err()
        .expect("a device is refused")
        .to_string();
    assert!(error.contains("not a regular file"), "{error}");
}

/// Every second cell is a wall.
#[test]
fn a_map_with_too_many_walls_is_refused() {
    let folder = std::env::temp_dir().join(format!("jde-sim-walls-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    let (width, height) = (2_000_usize, 1_100_usize);
    let mut image = format!("P5 {width} {height} 255\n").into_bytes();
    image.extend((0..width * height).map(|at| {
        if (at % width + at / width) % 2 == 0 {
            0
        } else {
            255
        }
    }));
    fs::write(folder.join("walls.pgm"), image).expect("the folder is writable");
    let yaml = "image: walls.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n";
    fs::write(folder.join("walls.yaml"), yaml).expect("the folder is writable");
    let world = World::parse("map = \"walls.yaml\"\n", folder.join("w.toml"), 0);
    fs::remove_dir_all(&folder).expect("the folder is removed");
    let error = world.err().expect("the map is refused").to_string();
    assert!(error.contains("separate walls"), "{error}");
}
