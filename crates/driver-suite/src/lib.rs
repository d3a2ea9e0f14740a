//! One test suite for every driver of a robot's base: the behaviour that an application may rely on with any
//! driver. It runs the driver's real plugin in a real application, in real time, and waits for conditions of
//! the robot or of the application's clock.
//!
//! The driver under test has a room of 5 x 4 m, a start at x 2.5, y 1.5 with heading along x, the sonars of a
//! P3-DX, and a laser. Give [`suite!`](crate::suite) a module name and a function that returns a
//! [`DriverConfig`]; each test calls it.

mod build;
mod fixture;
mod pilot;
mod tests;

pub use build::build;
pub use fixture::{DriverConfig, Fixture, START};
pub use tests::{
    a_collision_with_a_wall_is_detected, a_head_turns_to_the_commanded_angles,
    a_positive_turn_is_to_the_left_and_on_the_spot, a_robot_without_commands_does_not_move,
    a_square_ends_at_its_start_and_the_scans_agree_with_the_odometry,
    odometry_arrives_at_a_steady_rate_with_increasing_stamps, r7_a_schema_without_authority_moves_nothing,
    r7_the_robot_brakes_when_the_commands_stop, sonars_measure_the_distances_of_the_walls,
    the_driver_connects_drives_and_stops_the_robot_at_the_end, the_driver_exports_battery_and_wheels,
    the_robot_drives_ahead_in_metres_and_reports_its_speed,
};

/// A room with a robot at [`START`], as a world file of the simulator.
pub const ROOM: &str = r#"
name  = "room"
walls = [{ name = "wall", points = [[0, 0], [5, 0], [5, 4], [0, 4]], closed = true }]
[robots.pioneer]
start = { x = 2.5, y = 1.5 }
"#;

/// Defines a module of tests for a driver: `suite!(name, config)`.
#[macro_export]
macro_rules! suite {
    ($name:ident, $config:path) => {
        $crate::suite!(@ $name, $config,
            the_driver_connects_drives_and_stops_the_robot_at_the_end,
            a_robot_without_commands_does_not_move,
            the_robot_drives_ahead_in_metres_and_reports_its_speed,
            a_positive_turn_is_to_the_left_and_on_the_spot,
            a_square_ends_at_its_start_and_the_scans_agree_with_the_odometry,
            sonars_measure_the_distances_of_the_walls,
            odometry_arrives_at_a_steady_rate_with_increasing_stamps,
            r7_a_schema_without_authority_moves_nothing,
            r7_the_robot_brakes_when_the_commands_stop,
            the_driver_exports_battery_and_wheels,
            a_head_turns_to_the_commanded_angles,
            a_collision_with_a_wall_is_detected,
        );
    };
    (@ $name:ident, $config:path, $($test:ident,)+) => {
        mod $name {
            $(#[test]
            fn $test() {
                $crate::$test($config());
            })+
        }
    };
}
