//! The sticks and buttons of a gamepad: a value that drivers publish and teleoperation reads. The crate defines no schema and
//! reads no device.

use jde_types::{Header, Seq, Value};

/// The state of a gamepad or a joystick: `sensor_msgs/Joy`.
///
/// The numbers of axes and buttons depend on its driver. Those of `gamepad` are the numbers of ROS's `game_controller_node`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/Joy")]
pub struct Joy {
    /// Time at which the device was read.
    pub header: Header,
    /// Positions, from -1 to 1: of a stick positive to the left and ahead, of a trigger 0 while it is released.
    pub axes: Seq<f32, 16>,
    /// Each button: 1 while it is pressed, else 0.
    pub buttons: Seq<i32, 32>,
}

impl Joy {
    /// Returns the position of an axis. `None` if there is no axis of this number, or if its position is not finite.
    #[must_use]
    pub fn axis(&self, number: i32) -> Option<f64> {
        let position = *self.axes.get(usize::try_from(number).ok()?)?;
        position.is_finite().then_some(f64::from(position))
    }

    /// Returns whether a button is pressed. `None` if there is no button of this number.
    #[must_use]
    pub fn is_pressed(&self, number: i32) -> Option<bool> {
        let state = self.buttons.get(usize::try_from(number).ok()?)?;
        Some(*state != 0)
    }
}
