//! One test suite for every driver of a robot's base: the behaviour that an application may rely on with any
//! driver. It runs the driver's real plugin in a real application, in real time, and waits for conditions of
//! the robot or of the application's clock.
//!
//! The driver under test has a room of 5 x 4 m, a start at x 2.5, y 1.5 with heading along x, the sonars of a
//! P3-DX, and a laser. Give [`suite!`](crate::suite) a module name and a function that makes a [`RigConfig`];
//! each test gets its own setting.

mod build;
mod pilot;
mod rig;
mod tests;

pub use build::build;
pub use rig::{Rig, RigConfig, START};
pub use tests::{
    a_head_looks_where_it_is_told, a_positive_turn_is_to_the_left_and_on_the_spot,
    a_square_ends_where_it_began_and_walls_stay_where_they_are, a_wall_that_is_hit_is_felt,
    it_comes_up_drives_and_is_left_standing, it_drives_ahead_in_metres_and_tells_its_speed,
    it_tells_battery_and_wheels, nothing_commanded_is_nothing_driven, r7_who_falls_silent_is_braked_for,
    r7_who_has_no_authority_moves_nothing, sonars_hear_walls_where_they_are,
    what_it_senses_comes_at_a_steady_rate_with_times_that_grow,
};

/// A room with a robot at [`START`], as a world file of the simulator.
pub const ROOM: &str = r#"
name  = "room"
walls = [{ name = "wall", points = [[0, 0], [5, 0], [5, 4], [0, 4]], closed = true }]
[robots.pioneer]
start = { x = 2.5, y = 1.5 }
"#;

/// Defines a module of tests for a driver: `suite!(name, setting)`.
#[macro_export]
macro_rules! suite {
    ($name:ident, $setting:path) => {
        $crate::suite!(@ $name, $setting,
            it_comes_up_drives_and_is_left_standing,
            nothing_commanded_is_nothing_driven,
            it_drives_ahead_in_metres_and_tells_its_speed,
            a_positive_turn_is_to_the_left_and_on_the_spot,
            a_square_ends_where_it_began_and_walls_stay_where_they_are,
            sonars_hear_walls_where_they_are,
            what_it_senses_comes_at_a_steady_rate_with_times_that_grow,
            r7_who_has_no_authority_moves_nothing,
            r7_who_falls_silent_is_braked_for,
            it_tells_battery_and_wheels,
            a_head_looks_where_it_is_told,
            a_wall_that_is_hit_is_felt,
        );
    };
    (@ $name:ident, $setting:path, $($test:ident,)+) => {
        mod $name {
            $(#[test]
            fn $test() {
                $crate::$test($setting());
            })+
        }
    };
}
