//! The settings of an entry in the application file.

use jde_schema::prelude::*;

/// How a request is treated.
#[derive(Clone, Copy, Debug, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/RosRequest")]
pub(crate) struct Timed {
    /// How long it waits for its response.
    #[value(unit = "s")]
    pub(crate) timeout: f64,
}

/// An entry without settings.
#[derive(Clone, Copy, Debug, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/RosResponse")]
pub(crate) struct Plain {
    padding: Padding<1>,
}

impl Timed {
    /// As long as tools of ROS 2 usually wait.
    pub(crate) const DEFAULT: Self = Self { timeout: 5.0 };

    /// The time that a request waits for its response.
    pub(crate) fn timeout(&self) -> Duration {
        Duration::from_secs_f64(self.timeout)
    }

    /// Checks the settings.
    pub(crate) fn check(&self) -> Result<(), String> {
        match self.timeout {
            timeout if timeout > 0.0 && timeout <= 3600.0 => Ok(()),
            timeout => Err(format!(
                "`timeout` is {timeout} s; expected more than 0 s, and at most 3600 s"
            )),
        }
    }
}

impl Plain {
    pub(crate) const DEFAULT: Self = Self {
        padding: Padding::ZERO,
    };
}
