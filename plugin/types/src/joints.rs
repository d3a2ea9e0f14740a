//! The joints of a robot, by name.

use crate::{Header, Seq, Text, Value};

/// A text in a list: a list of these is a `string[]` of ROS 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Name")]
pub struct Name {
    /// The text.
    pub data: Text<60>,
}

/// The state of up to 64 joints. Each list has an element for each joint, in the order of the names, or is empty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/JointState")]
pub struct JointState {
    /// Time.
    pub header: Header,
    /// The names of the joints.
    pub name: Seq<Name, 64>,
    /// Angle, rad; of a joint that slides the distance, m.
    pub position: Seq<f64, 64>,
    /// Velocity, rad/s or m/s.
    pub velocity: Seq<f64, 64>,
    /// Torque, N·m, or force, N.
    pub effort: Seq<f64, 64>,
}

impl From<&str> for Name {
    /// A text that does not fit is cut.
    fn from(text: &str) -> Self {
        Self {
            data: Text::truncated(text),
        }
    }
}

impl JointState {
    /// Returns the place of a joint in the lists.
    #[must_use]
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.name.iter().position(|joint| joint.data == name)
    }

    /// Checks the lengths of the lists.
    ///
    /// # Errors
    /// If a list is neither empty nor as long as the names.
    pub fn check(&self) -> Result<(), &'static str> {
        let joints = self.name.len();
        let of_each = |list: &Seq<f64, 64>| list.is_empty() || list.len() == joints;
        if [&self.position, &self.velocity, &self.effort]
            .into_iter()
            .all(of_each)
        {
            Ok(())
        } else {
            Err("a list has neither an element for each name nor none")
        }
    }
}
