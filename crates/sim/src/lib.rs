//! A world of robots and sensors, stepped by its caller.
//!
//! A [`World`] is read from a file, and moves only when [`World::advance_to`] is called: it never sleeps, starts no
//! thread, draws nothing and prints nothing. One seed gives one history, to the bit, however the caller slices the time
//! and whichever sensors are read in between. Metres, radians, seconds, and the axes of ROS REP-103.
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

mod config;
mod error;
mod file;
mod geometry;
mod mover;
mod odometer;
mod random;
mod robot;
mod scene;
mod sensor;
mod shape;
mod solid;
mod world;

pub use config::{OdometryOrigin, RobotConfig};
pub use error::{Fault, WorldError};
pub use geometry::{Bounds, Pose2, Twist2, wrap_angle};
pub use odometer::{Encoders, Odometry};
pub use robot::Truth;
pub use sensor::{BUMPER_HEADINGS, Bumpers, LaserConfig, SonarConfig};
pub use shape::{Outline, Shape};
pub use world::{RobotId, STEP_NS, World};
