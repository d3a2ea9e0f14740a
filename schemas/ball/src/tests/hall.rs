//! The finder on pictures of the simulated hall: it finds the ball at its position, and nothing else.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_sim::{CameraConfig, HeadCommand, Pose2, RobotConfig, RobotId, World};

use crate::Finder;
use crate::ball::Ball;
use crate::tests::{assert_near, with_large_stack};

const HALL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../worlds/hall.toml");
/// The position of the hall's orange ball, and that of the camera on a Pioneer: ahead of the robot's middle,
/// and above the floor.
const BALL: [f64; 2] = [4.9, 3.7];
const CAMERA_AHEAD: f64 = 0.05;
const HEIGHT: f64 = 0.35;

struct Hall {
    world: World,
    robot: RobotId,
    finder: Bench<Finder>,
}

impl Hall {
    fn new() -> Self {
        let mut world = World::load(HALL, 1).expect("the world loads");
        let robot = world
            .add_robot("second", RobotConfig::default())
            .expect("the robot fits");
        let mut finder = Bench::new();
        finder.unbind("camera_info");
        Self { world, robot, finder }
    }

    /// Returns the ball that the finder publishes for a robot at this pose with this head position.
    fn observe(&mut self, pose: Pose2, pan: f64, tilt: f64) -> Ball {
        self.world.place(self.robot, pose).expect("the pose is free");
        let head = HeadCommand {
            pan,
            tilt,
            pan_speed: 10.0,
            tilt_speed: 10.0,
        };
        self.world
            .command_head(self.robot, head)
            .expect("the command is finite");
        self.world.advance_to(self.world.now() + 3_000_000_000);
        let camera = CameraConfig::default();
        let mut image = Box::new(Image::default());
        (image.width, image.height) = (camera.width as u32, camera.height as u32);
        image.step = 3 * image.width;
        image.encoding = Text::new("rgb8");
        let data = image.data.resize(camera.bytes());
        self.world
            .picture(self.robot, &camera, data)
            .expect("the picture fits");
        let head = PanTilt {
            pan,
            tilt,
            ..PanTilt::default()
        };
        self.finder.import("pan_tilt", &head);
        self.finder.import("image", &*image);
        self.finder.iterate().expect("the iteration succeeds");
        self.finder.exported("ball").expect("the ball is exported")
    }
}

#[test]
fn the_ball_of_the_hall_is_found_at_its_position() {
    with_large_stack(|| {
        let mut hall = Hall::new();
        let positions = [
            (1.5, 5.6),
            (3.0, 4.3),
            (4.9, 2.8),
            (4.2, 2.6),
            (5.6, 5.4),
            (4.0, 4.2),
        ];
        for (x, y) in positions {
            for (offset, pan) in [(0.0, 0.0), (0.25, -0.1), (-0.3, 0.5), (0.9, -0.8)] {
                let heading = f64::atan2(BALL[1] - y, BALL[0] - x) + offset;
                let ball = hall.observe(Pose2 { x, y, heading }, pan, 0.15);
                let (sin, cos) = heading.sin_cos();
                let camera_position = [x + CAMERA_AHEAD * cos, y + CAMERA_AHEAD * sin];
                let (dx, dy) = (BALL[0] - camera_position[0], BALL[1] - camera_position[1]);
                let (ahead, height) = (dx.hypot(dy), 0.11 - HEIGHT);
                assert!(ball.seen.get(), "from {x}, {y} offset by {offset}");
                assert_near(ball.bearing, normalize_angle(dy.atan2(dx) - heading), 0.01);
                assert_near(ball.elevation, height.atan2(ahead), 0.01);
                let distance = ahead.hypot(height);
                assert_near(ball.distance, distance, 0.05 * distance);
            }
        }
    });
}

#[test]
fn no_other_object_of_the_hall_is_found() {
    with_large_stack(|| {
        let mut hall = Hall::new();
        // From around the ball, in all directions except toward it, while people walk.
        for position in [[5.8, 5.0], [7.3, 3.2], [3.2, 2.0]] {
            let toward = f64::atan2(BALL[1] - position[1], BALL[0] - position[0]);
            for step in 1..12 {
                let heading = toward + 0.5 * f64::from(step) + 0.1;
                let [x, y] = position;
                let ball = hall.observe(Pose2 { x, y, heading }, 0.0, 0.1);
                assert!(!ball.seen.get(), "from {x}, {y} to {heading}: {ball:?}");
            }
        }
    });
}
