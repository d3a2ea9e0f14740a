//! A world of robots and sensors, which its caller steps.
//!
//! A [`World`] is read from a file, and its robots may be. Time passes only in [`World::advance_to`]: the
//! crate never sleeps, starts no thread, opens no window and prints nothing. One seed gives one history,
//! identical to the bit. The history does not depend on how the caller divides the time, or on which sensors
//! it reads in between. Units are metres, radians and seconds; axes follow ROS REP-103.
//!
//! ```
//! use jde_sim::{LaserConfig, RobotConfig, Twist2, World};
//!
//! let text = r#"
//!     walls  = [{ name = "room", points = [[0, 0], [6, 0], [6, 4], [0, 4]], closed = true }]
//!     robots = { pioneer = { start = { x = 1, y = 2 } } }
//! "#;
//! let mut world = World::parse(text, "room.toml", 42)?;
//! let robot = world.add_robot("pioneer", RobotConfig::default())?;
//! world.command(robot, Twist2::new(0.3, 0.0))?;
//! world.advance_to(2_000_000_000);
//!
//! let laser = LaserConfig::default();
//! let mut ranges = vec![0.0; laser.beams];
//! world.laser(robot, &laser, &mut ranges)?;
//! assert!(world.truth(robot).pose.x > 1.3);
//! # Ok::<(), jde_sim::WorldError>(())
//! ```
//!
//! # World files
//!
//! TOML, in metres and degrees, x to the right and y up. Every key is optional, except those that define a
//! shape.
//!
//! ```toml
//! name   = "shed"                           # default: the name of the file
//! bounds = { min = [0, 0], max = [6, 4] }   # no robot starts outside; pictures show this part
//! map    = "rooms.yaml"                     # a ROS map, beside this file
//!
//! # For cameras: what is visible where there is no thing, and the direction of the light. Colours are
//! # "#rrggbb" or names: white, silver, gray, black, red, orange, yellow, green, teal, blue, purple, pink,
//! # brown, beige.
//! floor = "#96908a"
//! sky   = "#c4d6e8"
//! light = { from_deg = 140, height_deg = 50 }
//!
//! # Paint on the floor, for cameras and line sensors: areas, of one colour or of square tiles of two, and
//! # lines over them. A `bend` rounds the corners of a line by arcs of that radius.
//! floor_areas = [{ name = "stage", center = [5, 1], size = [1, 1], color = "white", tile = 0.25, tile_color = "red" }]
//! floor_lines = [{ name = "track", points = [[1, 2], [5, 2], [5, 3], [1, 3]], closed = true, bend = 0.3, width = 0.03 }]
//!
//! # Every thing has a `color`. Every thing except a ball has a `height`: 2.5 m for walls, 0.75 m for boxes
//! # and circles, 1 m for movers, 1.72 m for people. A laser with a `height` passes over
//! # lower walls, boxes and circles; sonars and bumpers meet all.
//! walls   = [{ name = "shell", points = [[0, 0], [6, 0], [6, 4], [0, 4]], closed = true, color = "beige" }]
//! boxes   = [
//!   { name = "desk", center = [1.2, 3.2], size = [1.6, 0.8], angle_deg = 10 },
//!   # It slides when a robot pushes it, without turning. Its `mass` in kilograms slows the robot.
//!   { name = "carton", center = [2.2, 2.6], size = [0.4, 0.4], movable = true, mass = 2 },
//! ]
//! circles = [{ name = "post", center = [4, 0.5], radius = 0.1, height = 2.5 }]
//! # A ball rolls away when it is pushed, slows down, and bounces softly off what it meets.
//! balls   = [{ name = "ball", center = [2.2, 1], radius = 0.11, color = "orange", mass = 0.43 }]
//!
//! # Round with a `radius`, or a box with a `size` whose x axis lies along its `way`. A mover returns the
//! # same way, or circulates in a `loop`. It halts `clearance` metres from a robot, or before a loose thing,
//! # and turns back after it has waited `wait` seconds.
//! [[movers]]
//! name      = "cart"
//! size      = [0.8, 0.5]
//! way       = [[1, 2], [5, 2], [5, 1.2]]
//! speed     = 0.4
//! loop      = false
//! clearance = 0.5
//! wait      = 3
//!
//! # A mover on two legs, which alternate while it walks. A laser measures the legs, a sonar the body. It
//! # rests `pause` seconds at every way-point. With a `speed` of 0 it stands, and with `sits = true` it sits at
//! # the first one, and faces the second. The `color` is that of the clothing.
//! [[people]]
//! name  = "anna"
//! way   = [[5.5, 0.6], [5.5, 3.4]]
//! speed = 0.6
//! pause = 2
//!
//! # An AprilTag, which cameras see from its front: its middle, the direction in which it faces, and the side of
//! # its black border.
//! [[tags]]
//! id         = 5
//! place      = [6, 2, 1.2]
//! facing_deg = 180
//! size       = 0.16
//! family     = "tag36h11"
//!
//! # A place where a robot charges while its middle is within `radius`, by `current` amperes.
//! [[chargers]]
//! place   = [5.5, 2]
//! radius  = 0.1
//! current = 3
//!
//! [robots.pioneer]
//! start = { x = 1, y = 1, heading_deg = 90 }
//! ```
//!
//! # Robot files
//!
//! A [`RobotModel`] is read from a file, too: the `robots/` of the project have fifteen, and `docs/robots.md` all
//! keys.

mod battery;
mod camera;
mod charger;
mod color;
mod cone;
mod config;
mod drift;
mod drive;
mod edit;
mod error;
mod file;
mod floor;
mod footprint;
mod geometry;
mod head;
mod import;
mod loose;
mod model;
mod mover;
mod odometer;
mod person;
mod probe;
mod random;
mod robot;
mod scene;
mod sensor;
mod shape;
mod shipped;
mod solid;
mod sweep;
mod tag;
mod trail;
mod world;

pub use battery::{BATTERY_CAPACITY, Battery};
pub use camera::{CameraConfig, CameraMount, Lens};
pub use color::Color;
pub use config::{OdometryOrigin, RobotConfig};
pub use drift::Covariance;
pub use drive::Kinematics;
pub use edit::{Edit, EditQueue, Edits};
pub use error::{Fault, Faults, WorldError};
pub use footprint::{Footprint, Polygon};
pub use geometry::{Bounds, Pose2, Twist2, wrap_angle};
pub use head::{Head, HeadCommand, HeadConfig};
pub use import::{ImportedWorld, import};
pub use model::{LaserModel, Physics, RobotModel, SampledSensor};
pub use odometer::{Encoders, Odometry, OdometryCovariance};
pub use robot::Truth;
pub use sensor::{
    BUMPER_HEADINGS, Bumpers, Delivery, DepthConfig, ImuConfig, ImuReading, LaserConfig, LaserTurn,
    LineSensorConfig, NoReturn, PositionConfig, SonarConfig,
};
pub use shape::{Figure, Outline, Shape};
pub use shipped::SHIPPED_ROBOTS;
pub use world::{RobotId, STEP_NS, World};
