//! The painted floor: what cameras see of it, the geometry of bends and tiles, and faults.

use std::f64::consts::PI;

use jde_sim::{CameraConfig, CameraMount, Outline, RobotConfig, World};

/// A camera of 320 x 240 pixels on a robot at the origin, level and 0.4 m above the floor. Its focal length is
/// 160 pixels, so that it shows the point (x, y) of the floor at column 160 - 160 y/x and row 120 + 64/x.
struct Picture(Vec<u8>);

impl Picture {
    fn of(floor: &str) -> Self {
        let text = format!("{floor}\n[robots.r]\nstart = {{ x = 0, y = 0 }}");
        let mut world = World::parse(&text, "floors.toml", 0).unwrap_or_else(|error| panic!("{error}"));
        let robot = world.add_robot("r", RobotConfig::default()).unwrap();
        let camera = CameraConfig {
            field_of_view: PI / 2.0,
            mount: CameraMount::Body,
            place: [0.0, 0.0, 0.4],
            ..CameraConfig::default()
        };
        let mut bytes = vec![0; camera.bytes()];
        world.picture(robot, &camera, &mut bytes).unwrap();
        Self(bytes)
    }

    fn at(&self, x: f64, y: f64) -> [u8; 3] {
        self.pixel((160.0 - 160.0 * y / x) as usize, (120.0 + 64.0 / x) as usize)
    }

    fn pixel(&self, column: usize, row: usize) -> [u8; 3] {
        let first = 3 * (row * 320 + column);
        self.0[first..first + 3].try_into().unwrap()
    }
}

fn is_red([r, g, b]: [u8; 3]) -> bool {
    r > 150 && g < 40 && b < 40
}

fn is_green([r, g, b]: [u8; 3]) -> bool {
    g > 150 && r < 40 && b < 40
}

fn paint(text: &str) -> Vec<Outline> {
    let world = World::parse(text, "floors.toml", 0).unwrap_or_else(|error| panic!("{error}"));
    world.paint().map(|shape| shape.outline).collect()
}

#[test]
fn a_line_has_its_width_its_ends_and_its_colour() {
    let picture =
        Picture::of("[[floor_lines]]\npoints = [[0.8, 0.1], [0.8, -0.3]]\nwidth = 0.1\ncolor = '#ff0000'");
    for (x, y, inside) in [
        (0.80, 0.0, true),
        (0.84, 0.0, true),
        (0.76, 0.0, true),
        (0.87, 0.0, false),
        (0.73, 0.0, false),
        (0.80, 0.13, true),
        (0.80, 0.17, false),
        (0.80, -0.33, true),
        (0.80, -0.37, false),
        (0.835, 0.145, false),
    ] {
        assert_eq!(is_red(picture.at(x, y)), inside, "({x}, {y})");
    }
}

#[test]
fn lines_lie_over_areas_and_the_later_over_the_earlier() {
    let picture = Picture::of(
        "[[floor_lines]]
         points = [[0.5, 0], [3, 0]]
         width  = 0.1
         color  = '#ff0000'
         [[floor_areas]]
         center = [1.0, 0]
         size   = [1.0, 0.6]
         color  = '#0000ff'
         [[floor_areas]]
         center    = [1.0, 0.2]
         size      = [0.4, 0.2]
         angle_deg = 90
         color     = '#00ff00'",
    );
    assert!(is_red(picture.at(0.8, 0.0)));
    assert!(is_green(picture.at(1.05, 0.2)) && is_green(picture.at(0.95, 0.35)));
    let blue = picture.at(0.8, 0.2);
    assert!(blue[2] > 150 && blue[0] < 40, "{blue:?}");
    let bare = picture.at(0.8, 0.4);
    assert!(bare.iter().all(|part| (100..200).contains(part)), "{bare:?}");
}

#[test]
fn tiles_alternate_from_the_corner_and_merge_in_the_distance() {
    let tiles = |side: f64, length: f64| {
        Picture::of(&format!(
            "[[floor_areas]]\ncenter = [{}, 0]\nsize = [{length}, 0.8]\ncolor = '#ff0000'\ntile = {side}\n\
             tile_color = '#00ff00'",
            0.6 + length / 2.0
        ))
    };
    let picture = tiles(0.2, 0.8);
    for column in 0..4 {
        for row in 0..4 {
            let (x, y) = (0.7 + 0.2 * f64::from(column), -0.3 + 0.2 * f64::from(row));
            let found = picture.at(x, y);
            assert_eq!(is_red(found), (column + row) % 2 == 0, "({x}, {y}): {found:?}");
            assert_eq!(is_green(found), (column + row) % 2 == 1, "({x}, {y}): {found:?}");
        }
    }
    // Tiles much smaller than a pixel show the mean of their colours.
    let [r, g, b] = tiles(0.02, 3.9).at(4.0, 0.0);
    assert!(
        (118..138).contains(&r) && (118..138).contains(&g) && b < 5,
        "{r} {g} {b}"
    );
}

#[test]
fn a_distant_line_fades_and_does_not_flicker() {
    let row = |x: f64| {
        let text = format!(
            "floor = '#000000'\n[[floor_lines]]\npoints = [[{x}, -9], [{x}, 9]]\nwidth = 0.1\ncolor = '#ff0000'"
        );
        let picture = Picture::of(&text);
        // The red of the column, as metres of the floor: a row of pixels shows 0.4 · 160 / row² m of it.
        (122..240)
            .map(|row| {
                let below = row as f64 + 0.5 - 120.0;
                let metres = 64.0 / (below * below);
                f64::from(picture.pixel(160, row)[0]) / 255.0 * metres
            })
            .sum::<f64>()
    };
    for step in 0..30 {
        let seen = row(5.0 + 0.1 * f64::from(step));
        assert!((0.06..0.15).contains(&seen), "{seen} m of 0.1 m in step {step}");
    }
}

#[test]
fn a_bend_is_an_arc_that_touches_both_legs() {
    let corner = "points = [[0, 0], [2, 0], [2, 2]]\nbend = 0.5";
    let legs = paint(&format!("[[floor_lines]]\n{corner}"));
    let mut length = 0.0;
    for leg in &legs {
        let (middle, [along, width]) = leg.placed();
        assert_eq!(width, 0.02);
        length += along;
        let (x, y) = (middle.x - 1.5, middle.y - 0.5);
        let off = if x > 0.0 && y < 0.0 {
            (x.hypot(y) - 0.5).abs()
        } else {
            middle.y.abs().min((middle.x - 2.0).abs())
        };
        assert!(off < 0.0006, "{middle:?} is {off} m off");
    }
    assert!((length - (1.5 + 1.5 + PI / 4.0)).abs() < 0.001, "{length} m");
    // A closed line bends at its first point, too: four quarters of a circle.
    let closed = "points = [[0, 0], [1, 0], [1, 1], [0, 1]]\nclosed = true\nbend = 0.5";
    let legs = paint(&format!("[[floor_lines]]\n{closed}"));
    let length: f64 = legs.iter().map(|leg| leg.placed().1[0]).sum();
    assert!((length - PI).abs() < 0.002, "{length} m");
    for leg in &legs {
        let (middle, _) = leg.placed();
        let radius = (middle.x - 0.5).hypot(middle.y - 0.5);
        assert!((radius - 0.5).abs() < 0.001, "{radius} m");
    }
}

#[test]
fn paint_widens_the_bounds_and_is_no_thing() {
    let text = "[[floor_areas]]\ncenter = [0, 0]\nsize = [4, 2]\nangle_deg = 90\ntile = 0.7\n\
                [[floor_lines]]\npoints = [[0, 0], [0, 3]]\n[robots.r]\nstart = { x = 0, y = 0 }";
    let mut world = World::parse(text, "floors.toml", 0).unwrap();
    let bounds = world.bounds();
    for (found, expected) in [(bounds.min, [-1.0, -2.0]), (bounds.max, [1.0, 3.0])] {
        assert!(
            (0..2).all(|axis| (found[axis] - expected[axis]).abs() < 1e-9),
            "{bounds:?}"
        );
    }
    assert_eq!(world.shapes().count(), 0);
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    assert_eq!(world.truth(robot).clearance, f64::INFINITY);
    // One area, half of its 6 x 3 tiles, one leg of a line; the tiles are cut at the edge.
    assert_eq!(world.paint().count(), 1 + 9 + 1);
    let tiles: f64 = world
        .paint()
        .skip(1)
        .take(9)
        .map(|tile| tile.outline.placed().1)
        .map(|[a, b]| a * b)
        .sum();
    assert!((3.0..5.0).contains(&tiles), "{tiles} m² of 8 m²");
}

#[test]
fn faults_of_paint_are_all_reported_with_their_lines() {
    let text = "[[floor_lines]]
points = [[0, 0]]
[[floor_lines]]
name   = 'ring'
points = [[0, 0], [1, 0], [1, 1]]
closed = true
bend   = 0.6
[[floor_lines]]
points = [[0, 0], [1, 0]]
widht  = 0.1
[[floor_areas]]
center     = [0, 0]
size       = [1, 1]
tile_color = 'white'
[[floor_areas]]
center = [0, 0]
size   = [1000, 1]
tile   = 0.01
color  = 'grey'
[[floor_line]]
points = [[0, 0], [1, 0]]
";
    let Err(error) = World::parse(text, "w.toml", 0) else {
        panic!("the world has no fault")
    };
    let faults: Vec<String> = error.faults().iter().map(ToString::to_string).collect();
    let expected = [
        ("w.toml:2:", "has 1 points: expected two or more"),
        ("w.toml:3:", "floor line `ring` has a `bend` that needs"),
        ("w.toml:10:", "did you mean `width`?"),
        ("w.toml:14:", "has a `tile_color` and no `tile`"),
        ("w.toml:15:", "has 10000000 tiles: expected at most 10000"),
        ("w.toml:19:", "did you mean `gray`?"),
        ("w.toml:20:", "did you mean `floor_lines`?"),
    ];
    assert_eq!(faults.len(), expected.len(), "{faults:#?}");
    for (fault, (place, part)) in faults.iter().zip(expected) {
        assert!(fault.starts_with(place) && fault.contains(part), "{fault}");
    }
}
