//! The judgement of other schemas' commands before they take effect (R18).
//!
//! ```
//! use jde_schema::prelude::*;
//!
//! /// Keeps the base slow near obstacles.
//! #[derive(Describe)]
//! #[schema(perceptive, period = "50ms")]
//! struct Slow {
//!     /// What the laser ahead sees.
//!     #[import]
//!     laser: Import<LaserScan>,
//!     /// The distance to the nearest obstacle.
//!     #[export(unit = "m")]
//!     nearest: Export<f64>,
//! }
//!
//! impl Schema for Slow {
//!     fn iterate(&mut self, cx: &Context) -> Result {
//!         match self.laser.get(cx).and_then(|laser| laser.nearest_ahead(0.5)) {
//!             Some(nearest) => self.nearest.write(cx, nearest),
//!             None => self.nearest.retract(cx),
//!         }
//!         Ok(())
//!     }
//! }
//!
//! impl Guard for Slow {
//!     type State = f64;
//!     type Command = Twist;
//!     const STATE_EXPORT: &'static str = "nearest";
//!
//!     fn judge(nearest: &f64, _age: Duration, command: &Twist) -> Result<(), String> {
//!         let greatest = nearest / 2.0;
//!         if command.linear.x <= greatest {
//!             return Ok(());
//!         }
//!         Err(format!("something is {nearest:.2} m ahead: at most {greatest:.2} m/s"))
//!     }
//! }
//!
//! assert!(Slow::judge(&1.0, Duration::ZERO, &Twist::planar(0.4, 0.0)).is_ok());
//! assert!(Slow::judge(&1.0, Duration::ZERO, &Twist::planar(0.6, 0.0)).is_err());
//! ```
//!
//! The export must exist, and hold a state:
//!
//! ```compile_fail,E0080
//! use jde_schema::prelude::*;
//!
//! #[derive(Describe)]
//! #[schema(perceptive, period = "50ms")]
//! struct Wrong {
//!     /// The distance to the nearest obstacle.
//!     #[export]
//!     nearest: Export<f64>,
//! }
//!
//! impl Schema for Wrong {
//!     fn iterate(&mut self, _: &Context) -> Result {
//!         Ok(())
//!     }
//! }
//!
//! impl Guard for Wrong {
//!     type State = Twist;
//!     type Command = Twist;
//!     const STATE_EXPORT: &'static str = "nearest";
//!
//!     fn judge(_: &Twist, _: Duration, _: &Twist) -> Result<(), String> {
//!         Ok(())
//!     }
//! }
//! ```

use core::time::Duration;

use jde_types::Value;

use crate::schema::Schema;

/// A perceptive schema that judges the commands of the groups that name it as their guard (R18).
pub trait Guard: Schema {
    /// The type of the export [`STATE_EXPORT`](Self::STATE_EXPORT).
    type State: Value;
    /// The type of the commands that it judges.
    type Command: Value;
    /// The name of the export by whose newest value it judges. That value is as old as the oldest value that the
    /// iteration read. While there is none, while the newest is older than three periods, and when what it was made
    /// of is no longer valid, the host refuses every command.
    const STATE_EXPORT: &'static str;

    /// Judges a command by the newest state and its age.
    ///
    /// The host calls it in the thread of the schema that commands, and in the guard's own thread for a command that is
    /// in force, any number of times at once and under no lock. The result depends on the arguments alone. It must
    /// return within microseconds and wait for nothing; one that does not return is a hang of the guard.
    ///
    /// # Errors
    /// Why the command must not take effect, in at most 127 bytes. A panic refuses the command too.
    fn judge(state: &Self::State, age: Duration, command: &Self::Command) -> Result<(), String>;

    /// Returns a lesser command that may take effect instead of one that [`judge`](Self::judge) refuses, if there is
    /// one: the command is then *limited*, and its schema stays READY. It takes effect only if `judge` accepts it.
    /// Like `judge`, it depends on its arguments alone.
    fn limit(_state: &Self::State, _age: Duration, _command: &Self::Command) -> Option<Self::Command> {
        None
    }
}
