//! The finder on pictures of the simulated hall: it finds the ball at its position, and nothing else.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_sim::{CameraConfig, HeadCommand, Pose2, RobotConfig, RobotId, World};

use crate::Finder;
use crate::ball::Ball;
use crate::tests::{near, with_large_stack};

const HALL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../worlds/hall.toml");
/// The position of the hall's orange ball, and that of the camera on a Pioneer: ahead of the robot's middle,
/// and above the floor.
const BALL: [f64; 2] = [4.9, 3.7];
const AHEAD: f64 = 0.05;
const HEIGHT: f64 = 0.35;

struct Hall {
    world: World,
    robot: RobotId,
    finder: Bench<Finder>,
}

impl Hall {
    fn new() -> Self {
        let mut world = World::load(HALL, 1).expect("a valid world");
        let robot = world
            .add_robot("second", RobotConfig::default())
            .expect("a free position");
        Self {
            world,
            robot,
            finder: Bench::new(),
        }
    }

    /// Returns the ball that the finder publishes for a robot at this pose with this head position.
    fn find(&mut self, pose: Pose2, pan: f64, tilt: f64) -> Ball {
        self.world.place(self.robot, pose).expect("there is room");
        let head = HeadCommand {
            pan,
            tilt,
            pan_speed: 10.0,
            tilt_speed: 10.0,
        };
        self.world
            .command_head(self.robot, head)
            .expect("a finite command");
        self.world.advance_to(self.world.now() + 3_000_000_000);
        let camera = CameraConfig::default();
        let mut image = Box::new(Image::default());
        (image.width, image.height) = (camera.width as u32, camera.height as u32);
        image.step = 3 * image.width;
        image.encoding = Text::new("rgb8");
        let data = image.data.resize(camera.bytes());
        self.world
            .picture(self.robot, &camera, data)
            .expect("a free position");
        let position = PanTilt {
            pan,
            tilt,
            ..PanTilt::default()
        };
        self.finder.import("pan_tilt", &position);
        self.finder.import("image", &*image);
        self.finder.iterate().expect("no fault");
        self.finder.exported("ball").expect("a ball")
    }
}

#[test]
fn the_ball_of_the_hall_is_found_at_its_position() {
    with_large_stack(|| {
        let mut hall = Hall::new();
        let places = [
            (1.5, 5.6),
            (3.0, 4.3),
            (4.9, 2.8),
            (4.2, 2.6),
            (5.6, 5.4),
            (4.0, 4.2),
        ];
        for (x, y) in places {
            for (turned, pan) in [(0.0, 0.0), (0.25, -0.1), (-0.3, 0.5), (0.9, -0.8)] {
                let heading = f64::atan2(BALL[1] - y, BALL[0] - x) + turned;
                let ball = hall.find(Pose2 { x, y, heading }, pan, 0.15);
                let (sin, cos) = heading.sin_cos();
                let eye = [x + AHEAD * cos, y + AHEAD * sin];
                let (dx, dy) = (BALL[0] - eye[0], BALL[1] - eye[1]);
                let (ahead, fall) = (dx.hypot(dy), 0.11 - HEIGHT);
                assert!(ball.seen.get(), "from {x}, {y} turned by {turned}");
                near(ball.bearing, normalize_angle(dy.atan2(dx) - heading), 0.01);
                near(ball.elevation, fall.atan2(ahead), 0.01);
                let distance = ahead.hypot(fall);
                near(ball.distance, distance, 0.05 * distance);
            }
        }
    });
}

#[test]
fn no_other_object_of_the_hall_is_taken_for_the_ball() {
    with_large_stack(|| {
        let mut hall = Hall::new();
        // From around the ball, in all directions but toward it, while people walk.
        for place in [[5.8, 5.0], [7.3, 3.2], [3.2, 2.0]] {
            let toward = f64::atan2(BALL[1] - place[1], BALL[0] - place[0]);
            for step in 1..12 {
                let heading = toward + 0.5 * f64::from(step) + 0.1;
                let [x, y] = place;
                let ball = hall.find(Pose2 { x, y, heading }, 0.0, 0.1);
                assert!(!ball.seen.get(), "from {x}, {y} to {heading}: {ball:?}");
            }
        }
    });
}
