//! Changes of a running world: what the sensors then measure, what is refused, and what a text of edits holds.

use jde_sim::{
    EditQueue, Edits, LaserConfig, Outline, Pose2, RobotConfig, RobotId, Twist2, World, WorldError,
};

const SECOND: u64 = 1_000_000_000;
const ROOM: &str = "
    walls  = [{ name = 'wall', points = [[0, 0], [6, 0], [6, 4], [0, 4]], closed = true }]
    boxes  = [{ name = 'carton', center = [3, 3.5], size = [0.4, 0.4], movable = true }]
    movers = [{ name = 'cart', radius = 0.2, way = [[0.5, 0.5], [5.5, 0.5]], speed = 0.5 }]
    robots = { r = { start = { x = 1, y = 2 } }, other = { start = { x = 5, y = 3.5 } } }";
const DOOR: &str = "{ add = { name = 'door', center = [1.9, 2], size = [0.1, 1] } }";

fn room() -> (World, RobotId) {
    let mut world = World::parse(ROOM, "edits.toml", 3).unwrap();
    let robot = world.add_robot("r", RobotConfig::default()).unwrap();
    (world, robot)
}

fn edit(world: &mut World, robot: RobotId, text: &str) -> Result<(), WorldError> {
    let edits = Edits::parse(text).unwrap().edits;
    edits.iter().try_for_each(|edit| world.edit(robot, edit))
}

/// The range straight ahead, without noise.
fn ahead(world: &World, robot: RobotId) -> f32 {
    let laser = LaserConfig {
        beams: 181,
        sigma: 0.0,
        ..LaserConfig::default()
    };
    let mut ranges = [0.0; 181];
    world.laser(robot, &laser, &mut ranges).unwrap();
    ranges[90]
}

#[test]
fn a_box_that_is_added_is_measured_and_stops_the_robot_until_it_is_removed() {
    let (mut world, robot) = room();
    let free = ahead(&world, robot);
    edit(&mut world, robot, DOOR).unwrap();
    assert!((free - ahead(&world, robot) - 4.15).abs() < 1e-3);
    assert_eq!(world.changes(), 1);
    assert!(
        (world.truth(robot).clearance - 0.6).abs() < 1e-9,
        "at once, without a step"
    );
    world.command(robot, Twist2::new(0.5, 0.0)).unwrap();
    world.advance_to(20 * SECOND);
    let truth = world.truth(robot);
    assert!(truth.stalled && (truth.pose.x - 1.6).abs() < 0.002, "{truth:?}");
    edit(&mut world, robot, "{ remove = 'door' }").unwrap();
    assert_eq!(world.changes(), 2);
    world.advance_to(30 * SECOND);
    assert!(world.truth(robot).pose.x > 5.0);
}

#[test]
fn a_world_that_was_changed_and_changed_back_measures_as_before() {
    let (mut changed, robot) = room();
    let (untouched, same) = room();
    edit(&mut changed, robot, DOOR).unwrap();
    edit(&mut changed, robot, "{ remove = 'door' }").unwrap();
    for step in 0..72 {
        let angle = f64::from(step).to_radians() * 5.0;
        assert_eq!(
            changed.cast_ray([1.0, 2.0], angle, 50.0, Some(robot)),
            untouched.cast_ray([1.0, 2.0], angle, 50.0, Some(same)),
            "at {angle} rad"
        );
    }
}

#[test]
fn a_movable_box_that_is_added_can_be_pushed() {
    let (mut world, robot) = room();
    let carton = "{ add = { name = 'new', center = [2, 2], size = [0.3, 0.3], movable = true, mass = 1 } }";
    edit(&mut world, robot, carton).unwrap();
    assert_eq!(world.changes(), 0, "no standing thing has changed");
    world.command(robot, Twist2::new(0.5, 0.0)).unwrap();
    world.advance_to(4 * SECOND);
    let new = world.shapes().find(|shape| shape.name == "new").unwrap();
    let Outline::Box { center, .. } = new.outline else {
        panic!("a box, not {new:?}");
    };
    assert!(center[0] > 2.5, "{center:?}");
}

#[test]
fn movers_halt_and_continue_from_where_they_are() {
    let (mut world, robot) = room();
    let place = |world: &World| {
        let cart = world.shapes().find(|shape| shape.name == "cart").unwrap();
        cart.outline.placed().0.x
    };
    world.advance_to(2 * SECOND);
    edit(&mut world, robot, "{ halt = 'cart' }").unwrap();
    let halted = place(&world);
    world.advance_to(10 * SECOND);
    assert_eq!(place(&world), halted);
    edit(&mut world, robot, "{ resume = 'cart' }").unwrap();
    world.advance_to(11 * SECOND);
    assert!((place(&world) - halted - 0.5).abs() < 1e-6);
}

#[test]
fn an_edit_places_the_own_robot_or_a_named_one() {
    let (mut world, robot) = room();
    let other = world.add_robot("other", RobotConfig::default()).unwrap();
    edit(
        &mut world,
        robot,
        "{ place = { x = 2, y = 1.5, heading_deg = 90 } }",
    )
    .unwrap();
    edit(
        &mut world,
        robot,
        "{ place = { robot = 'other', x = 4, y = 1.5 } }",
    )
    .unwrap();
    assert_eq!(world.truth(robot).pose, Pose2::new(2.0, 1.5, 90f64.to_radians()));
    assert_eq!(world.truth(other).pose, Pose2::new(4.0, 1.5, 0.0));
}

#[test]
fn things_of_every_kind_are_removed_by_name() {
    let (mut world, robot) = room();
    edit(
        &mut world,
        robot,
        "[{ remove = 'carton' }, { remove = 'cart' }, { remove = 'wall' }]",
    )
    .unwrap();
    assert_eq!(world.shapes().count(), 0);
    assert!(ahead(&world, robot).is_infinite());
}

#[test]
fn a_refused_edit_says_why_and_changes_nothing() {
    let (mut world, robot) = room();
    let before: Vec<_> = world.shapes().map(|shape| shape.outline).collect();
    for (text, expected) in [
        ("{ place = { x = 5.9, y = 2 } }", "`wall` is there"),
        ("{ place = { x = 50, y = 2 } }", "within the world"),
        (
            "{ place = { robot = 'othr', x = 3, y = 2 } }",
            "no robot `othr` now; it has `r`",
        ),
        (
            "{ remove = 'dor' }",
            "no thing `dor` now; it has `cart`, `carton`, `wall`",
        ),
        ("{ remove = 'catron' }", "did you mean `carton`?"),
        ("{ remove = 'r' }", "no thing `r`"),
        (
            "{ halt = 'carton' }",
            "no mover `carton` now; did you mean `cart`?",
        ),
        ("{ resume = 'anna' }", "no mover `anna`"),
        ("{ raise = 'cart' }", "no person `cart`"),
        (
            "{ add = { name = 'wall', center = [2, 3], size = [0.1, 0.1] } }",
            "has a `wall`",
        ),
        (
            "{ add = { name = 'other', center = [2, 3], size = [0.1, 0.1] } }",
            "has a `other`",
        ),
        (
            "{ add = { name = 'a', center = [1.2, 2], size = [0.1, 0.1] } }",
            "`r` is there",
        ),
        (
            "{ add = { name = 'a', center = [3, 3], size = [0.9, 0.9] } }",
            "`carton` is there",
        ),
        (
            "{ add = { name = 'a', center = [0.5, 0.5], size = [0.1, 0.1] } }",
            "`cart` is there",
        ),
        (
            "{ add = { name = 'a', center = [0, 2], size = [0.1, 0.1], movable = true } }",
            "`wall` is there",
        ),
    ] {
        let error = edit(&mut world, robot, text).unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
    let after: Vec<_> = world.shapes().map(|shape| shape.outline).collect();
    assert_eq!((after, world.changes()), (before, 0));
}

#[test]
fn a_text_of_edits_reports_all_its_faults() {
    let faults = |text| match Edits::parse(text) {
        Ok(_) => panic!("`{text}` has no fault"),
        Err(error) => error.to_string(),
    };
    let all = faults("[{ remove = 7 }, { plce = 1 }, { place = { x = 1 } }]");
    for expected in [
        "`remove` of edit 1 must be a text, not a whole number",
        "did you mean `place`?",
        "`y` of `place` of edit 3 is missing",
    ] {
        assert!(all.contains(expected), "`{expected}` is not in: {all}");
    }
    for (text, expected) in [
        ("remove door", "edit"),
        ("7", "edit 1 must be a table, not a whole number"),
        (
            "{ remove = 'a', halt = 'b' }",
            "edit 1 must have one of `place`, `add`",
        ),
        (
            "{ place = 'a' }",
            "`place` of edit 1 must be a table of `robot`, `x`, `y` and `heading_deg`, not a text",
        ),
        (
            "{ add = { center = [1, 1], size = [1, 1] } }",
            "`name` of `add` of edit 1 is missing",
        ),
        (
            "{ number = -1, edits = [] }",
            "`number` of the text must be a whole number from 0",
        ),
    ] {
        let found = faults(text);
        assert!(found.contains(expected), "{text}: {found}");
    }
    assert!(Edits::parse("").unwrap().edits.is_empty());
}

#[test]
fn a_queue_repeats_earlier_edits_with_their_numbers() {
    let mut queue = EditQueue::default();
    let one = Edits::parse("{ remove = 'a' }").unwrap();
    let two = Edits::parse("[{ halt = 'b' }, { resume = \"b\" }]").unwrap();
    assert_eq!(
        queue.push(&one).unwrap(),
        "{ number = 1, edits = [{ remove = 'a' }] }"
    );
    let text = queue.push(&two).unwrap();
    assert_eq!(
        text,
        "{ number = 1, edits = [{ remove = 'a' }, { halt = 'b' }, { resume = \"b\" }] }"
    );
    assert_eq!(Edits::parse(&text).unwrap().number, Some(1));
    let mut last = String::new();
    for _ in 0..1000 {
        last = queue.push(&one).unwrap();
        assert!(last.len() <= 4096);
    }
    let edits = Edits::parse(&last).unwrap();
    assert_eq!(edits.number.unwrap() + edits.edits.len() as u64, 1004);
    let long = format!("{{ remove = '{}' }}", "a".repeat(5000));
    let error = queue.push(&Edits::parse(&long).unwrap()).unwrap_err();
    assert!(error.to_string().contains("5017 bytes"), "{error}");
    assert_eq!(
        Edits::parse(&queue.push(&one).unwrap()).unwrap().edits.len(),
        edits.edits.len()
    );
}

#[test]
fn a_robot_starts_at_another_pose_than_that_of_the_file() {
    let mut world = World::parse(ROOM, "edits.toml", 3).unwrap();
    let config = RobotConfig::default;
    for (x, expected) in [(5.9, "`wall` is there"), (50.0, "within the world")] {
        let error = world
            .add_robot_at("r", Pose2::new(x, 2.0, 0.0), config())
            .unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
    let robot = world
        .add_robot_at("r", Pose2::new(3.0, 2.0, 1.0), config())
        .unwrap();
    assert_eq!(world.truth(robot).pose, Pose2::new(3.0, 2.0, 1.0));
    assert!(
        world.add_robot("r", config()).is_err(),
        "it is in the world already"
    );
}

#[test]
fn a_robot_that_the_file_does_not_name_starts_where_it_is_added() {
    let mut world = World::parse(ROOM, "edits.toml", 3).unwrap();
    let config = RobotConfig::default;
    let known = world.robot_names().count();
    let named = world.add_robot("stranger", config()).unwrap_err();
    assert!(named.to_string().contains("no robot `stranger`"), "{named}");
    let pose = Pose2::new(3.0, 2.0, 1.0);
    assert!(
        world
            .add_robot_at("stranger", Pose2::new(50.0, 2.0, 0.0), config())
            .is_err(),
        "it is outside"
    );
    assert_eq!(
        world.robot_names().count(),
        known,
        "a robot that was refused leaves nothing"
    );
    let robot = world.add_robot_at("stranger", pose, config()).unwrap();
    assert_eq!(
        (world.robot_name(robot), world.truth(robot).pose),
        ("stranger", pose)
    );
    world.remove_robot(robot);
    assert_eq!(
        world.add_robot("stranger", config()),
        Ok(robot),
        "it has a start now"
    );
}
