//! The API for authors of schemas: ports, traits, the derive and export macros, and a test bench.
//!
//! It requires no `unsafe` code of an author, and runs an author's code only inside the calls that the host
//! makes.
//!
//! ```
//! //! Brakes while something stands in a very close area ahead.
//! use jde_schema::prelude::*;
//!
//! /// Brakes the base while an obstacle stands in a very close area ahead.
//! #[derive(Describe)]
//! #[schema(motor, period = "200ms")]
//! pub struct Stop {
//!     /// What the laser ahead sees.
//!     #[import(trigger)]
//!     laser: Import<LaserScan>,
//!     /// How far ahead the watched area reaches.
//!     #[modulation(default = 0.6, unit = "m", min = 0.0)]
//!     ahead: Modulation<f64>,
//!     /// Half the width of the watched area.
//!     #[modulation(default = 0.3, unit = "m", min = 0.0)]
//!     half_width: Modulation<f64>,
//!     /// Speeds of the base.
//!     #[actuator]
//!     base: Actuator<Twist>,
//! }
//!
//! impl Schema for Stop {
//!     fn check(&mut self, cx: &Context) -> Result<Precondition> {
//!         let Some(laser) = self.laser.get(cx) else {
//!             return Ok(false.into());
//!         };
//!         let nearest = laser.nearest_ahead(self.half_width.get(cx));
//!         Ok(nearest.is_some_and(|x| x <= self.ahead.get(cx)).into())
//!     }
//!
//!     fn iterate(&mut self, cx: &Context) -> Result {
//!         self.base.command(cx, Twist::ZERO);
//!         Ok(())
//!     }
//! }
//!
//! jde_schema::export!("stop", "Brakes before obstacles.", [Stop]);
//! ```

extern crate self as jde_schema;

pub mod bench;
mod boundary;
mod bundle;
mod child;
mod context;
mod error;
mod guard;
mod hysteresis;
mod input;
mod inspect;
mod level;
mod lists;
mod log;
pub mod memory;
mod output;
pub mod panel;
mod schema;
mod slot;
mod turns;

pub use bundle::PortBundle;
pub use child::{Child, Children, State, Status};
pub use context::{Context, Severity};
pub use error::{Error, NoValue, Result};
pub use guard::Guard;
pub use hysteresis::Hysteresis;
pub use input::{Command, Import, Modulation, Sample};
pub use inspect::{Inspect, Inspected, Problems};
pub use jde_abi::describe;
pub use jde_core::Policy;
pub use jde_macros::{AuthorsChoice as Choice, AuthorsValue as Value, Describe, PortBundle};
pub use jde_types as types;
pub use jde_types::derived::{Modulated, Value};
pub use level::{Candidate, Case, Level, Verdict};
pub use lists::{Commands, Exports, Imports, ListedCommand, ListedExport, ListedImport};
pub use memory::{Memory, Saved, Saving};
pub use output::{Actuator, Export, Loan, Modulates, Outcome};
pub use panel::{Gesture, Panel, Pen};
pub use schema::{Arbitrate, Describe, Precondition, Schema};
pub use turns::TurnRequester;

/// The names that a schema usually needs: `use jde_schema::prelude::*;`.
pub mod prelude {
    pub use core::time::Duration;

    pub use crate::panel::Ink;
    pub use crate::types::{
        BatteryState, Bumpers, Connection, Flag, Frame, Header, Image, Imu, LaserPoint, LaserScan,
        LineSensor, MapMetaData, Mission, OccupancyGrid, Odometry, Padding, PanTilt, Path, Point, Pose,
        Pose2D, PoseStamped, PoseWithCovariance, PositionFix, Quaternion, Range, RangeRing, Route, Seq,
        SonarEcho, Target, Text, Time, Truth, Twist, TwistWithCovariance, Vector3, WheelEncoders,
        normalize_angle,
    };
    pub use crate::{
        Actuator, Arbitrate, Candidate, Case, Child, Children, Choice, Command, Commands, Context, Describe,
        Error, Export, Exports, Gesture, Guard, Hysteresis, Import, Imports, Inspect, Level, Loan, Memory,
        Modulates, Modulation, Outcome, Panel, Pen, Policy, PortBundle, Precondition, Problems, Result,
        Sample, Saved, Saving, Schema, State, Status, Value, Verdict,
    };
    pub use crate::{debug, error, info, trace, warn};
}

/// The names that macro-generated code uses. Not a public API.
#[doc(hidden)]
pub mod derived {
    pub use crate::boundary::bundles::{join, ports};
    pub use crate::boundary::lists::{list, lists};
    pub use crate::boundary::table::{
        About, Own, Without, actuator, child, child_modulation, command, export, import, modulation, plugin,
        schema, with_flags,
    };
    pub use crate::bundle::PortBundle;
    pub use crate::schema::Describe;
    pub use jde_abi::raw;
    pub use jde_types::{Modulated, wire};
}

/// Exports a plugin: its name, one sentence about it, and its types of schema. Use it once in a library.
///
/// The library is a `cdylib`. The plugin's version is the version of its crate.
#[macro_export]
macro_rules! export {
    ($name:literal, $doc:literal, [$($schema:ty),+ $(,)?]) => {
        /// The plugin table that the host reads.
        #[unsafe(no_mangle)]
        #[allow(non_upper_case_globals)]
        pub static jde_plugin: $crate::derived::raw::Plugin = $crate::plugin!($name, $doc, [$($schema),+]);
    };
}

/// Returns the table that [`export!`] exports, to link a plugin into a program: a constant of type
/// `jde_abi::raw::Plugin`.
#[macro_export]
macro_rules! plugin {
    ($name:literal, $doc:literal, [$($schema:ty),+ $(,)?]) => {{
        const SCHEMAS: &[$crate::derived::raw::Schema] =
            &[$(<$schema as $crate::derived::Describe>::TABLE),+];
        $crate::derived::plugin(
            ::core::concat!($name, "\0"),
            ::core::concat!(::core::env!("CARGO_PKG_VERSION"), "\0"),
            ::core::concat!($doc, "\0"),
            ::core::cfg!(panic = "abort"),
            SCHEMAS,
        )
    }};
}
