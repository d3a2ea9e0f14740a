//! What a recording says of the robot's body and of its world.

use jde_types::{Body, Footprint, Point2D, Text};

use super::*;

#[test]
fn the_outline_of_the_robot_and_the_walls_of_its_world_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let (file, world) = (folder.path().join("room.mcap"), folder.path().join("room.toml"));
    std::fs::write(&world, "walls = [{ points = [[0, 0], [4, 0]] }]").unwrap();
    let recorder = recorder(&file, None);
    let text = Text::<1024>::new(world.to_str().unwrap());
    let about = [
        ("variable", "robot.world"),
        ("access", "modulation"),
        ("unit", "file"),
    ];
    let about = about.map(|(key, value)| (key.to_owned(), value.to_owned()));
    let topic = recorder.topic("/robot/world", Arc::new(Text::<1024>::describe()), about.into());
    topic.put(text.as_bytes(), at(0, 1));
    let corners = [[0.3, 0.2], [-0.1, 0.2], [-0.1, -0.2], [0.3, -0.2]];
    let body = Body {
        footprint: Footprint {
            radius: 0.4,
            points: corners.iter().map(|&[x, y]| Point2D { x, y }).collect(),
        },
        ..Body::default()
    };
    export::<Body>(&recorder, "body").put(body.as_bytes(), at(0, 1));
    let truth = export::<Truth>(&recorder, "truth");
    for second in 1..3 {
        truth.put(Truth::default().as_bytes(), at(second * SECOND, second));
    }
    recorder.finish();
    let drive = read(&Recording::open(&file).unwrap(), columns(600)).ending.drive;
    let outline = drive.paths[0].body.as_ref().unwrap();
    assert_eq!(outline.corners().count(), 4);
    assert_eq!(outline.extent(), [[-0.1, -0.2], [0.3, 0.2]]);
    assert_eq!(drive.shapes.len(), 1);
}
