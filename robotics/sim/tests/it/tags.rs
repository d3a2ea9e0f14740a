//! Tags on walls: where pictures show them, what hides them, and faults of the file.

use jde_sim::{CameraConfig, CameraMount, RobotConfig, World};
use jde_tags::{Detection, Detector, Family, Gray, Pinhole};

/// A picture of 640 x 480 pixels of a robot at the origin that looks along x, 0.4 m above the floor. The focal length
/// is 320 pixels.
fn detect(world: &str, family: Family) -> Vec<Detection> {
    let text = format!("{world}\n[robots.r]\nstart = {{ x = 0, y = 0 }}");
    let mut world = World::parse(&text, "tags.toml", 0).unwrap_or_else(|error| panic!("{error}"));
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    let camera = CameraConfig {
        width: 640,
        height: 480,
        field_of_view: 90_f64.to_radians(),
        mount: CameraMount::Body,
        place: [0.0, 0.0, 0.4],
        ..CameraConfig::default()
    };
    let mut bytes = vec![0; camera.bytes()];
    world.picture(robot, &camera, &mut bytes).unwrap();
    let green: Vec<u8> = bytes.chunks(3).map(|pixel| pixel[1]).collect();
    Detector::new(vec![family]).detect(&Gray::new([640, 480], &green).unwrap())
}

fn wall(tag: &str) -> String {
    format!("walls = [{{ points = [[2, -3], [2, 3]] }}]\n[[tags]]\n{tag}")
}

#[test]
fn a_tag_on_a_wall_is_where_the_file_puts_it() {
    for (id, y, z) in [(0, 0.0, 0.4), (586, 0.8, 0.3), (77, -1.1, 0.9)] {
        let tags = detect(
            &wall(&format!("id = {id}\nplace = [2, {y}, {z}]\nfacing_deg = 180")),
            Family::Tag36h11,
        );
        assert_eq!(tags.len(), 1, "{id}");
        assert_eq!((tags[0].id, tags[0].hamming), (id, 0));
        let camera = Pinhole::new([640, 480], 90_f64.to_radians());
        let pose = camera.pose(&tags[0].corners, 0.16).expect("it has a pose");
        for (found, is) in pose.position.into_iter().zip([-y, 0.4 - z, 2.0]) {
            assert!((found - is).abs() < 0.03, "{pose:?}");
        }
        let lower_left = [320.0 - 160.0 * (y + 0.08), 240.0 + 160.0 * (0.4 - z + 0.08)];
        for (found, is) in tags[0].corners[0].into_iter().zip(lower_left) {
            assert!(
                (found - is).abs() < 0.5,
                "{:?} is not {lower_left:?}",
                tags[0].corners[0]
            );
        }
    }
}

#[test]
fn a_tag_is_seen_from_its_front_and_behind_nothing() {
    let count = |things: &str, angle: u32| {
        let tag = format!("[[tags]]\nid = 5\nplace = [2, 0, 0.4]\nfacing_deg = {angle}");
        detect(&format!("{things}\n{tag}"), Family::Tag36h11).len()
    };
    assert_eq!(
        [180, 135, 270, 0].map(|angle| count("floor = 'gray'", angle)),
        [1, 1, 0, 0],
        "in the air"
    );
    for (things, seen) in [
        ("walls = [{ points = [[1.9, -3], [1.9, 3]] }]", 0),
        ("circles = [{ center = [1, 0], radius = 0.1 }]", 0),
        ("walls = [{ points = [[2, -3], [2, 3]] }]", 1),
        ("boxes = [{ center = [2.2, 0], size = [0.4, 1] }]", 1),
    ] {
        assert_eq!(count(things, 180), seen, "{things}");
    }
}

#[test]
fn every_family_is_drawn_at_its_size() {
    for family in Family::ALL {
        let name = family.name();
        let tag = format!("id = 3\nfamily = '{name}'\nsize = 0.4\nplace = [2, 0, 0.4]\nfacing_deg = 180");
        let tags = detect(&wall(&tag), family);
        let found = tags.iter().find(|tag| tag.id == 3).expect(name);
        let width = found.corners[1][0] - found.corners[0][0];
        assert!((width - 64.0).abs() < 0.5, "{name}: {width} px");
    }
}

#[test]
fn faults_of_tags_name_their_lines() {
    let fault = |tag: &str| match World::parse(&format!("[[tags]]\n{tag}"), "tags.toml", 0) {
        Ok(_) => panic!("`{tag}` is accepted"),
        Err(error) => error.to_string(),
    };
    for (tag, expected) in [
        ("place = [0, 0, 1]", "tags.toml:1:1: `id` of tag 1 is missing"),
        ("id = 1", "`place` of tag 1 is missing"),
        (
            "id = 587\nplace = [0, 0, 1]",
            "tag 1 is tag 587 of tag36h11, which has 0 to 586",
        ),
        (
            "id = 1.5\nplace = [0, 0, 1]",
            "tags.toml:2:6: `id` of tag 1 is 1.5",
        ),
        (
            "id = 1\nplace = [0, 0, 1]\nsize = 0",
            "tags.toml:4:8: `size` of tag 1 is 0",
        ),
        (
            "id = 1\nplace = [0, 0, 1]\nfamily = 'tag36h12'",
            "tags.toml:4:10: `family` of tag 1 is `tag36h12`",
        ),
        ("id = 1\nplace = [0, 0]", "expected a place [x, y, z]"),
        ("id = 1\nplace = [0, 0, 1]\nheight = 2", "unknown key `height`"),
    ] {
        let message = fault(tag);
        assert!(message.contains(expected), "`{tag}`: {message}");
    }
}
