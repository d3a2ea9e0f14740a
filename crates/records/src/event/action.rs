//! The actions of operators (R14), and their descriptions.

use jde_core::{Nanos, Operator};
use jde_panel::Gesture;

use crate::reload::BuildName;

/// An action of an operator.
#[derive(Clone, Debug, PartialEq)]
pub enum OperatorAction {
    /// Plays, stops, forces or releases a schema.
    Hierarchy(Operator),
    /// Ends the instance of a schema.
    Unload {
        /// The schema.
        schema: usize,
    },
    /// Permits a fresh instance of a schema.
    Load {
        /// The schema.
        schema: usize,
    },
    /// Replaces the build of a schema by another one.
    Reload {
        /// The schema.
        schema: usize,
        /// The build.
        build: BuildName,
    },
    /// Changes a period.
    Period {
        /// The schema.
        schema: usize,
        /// The new period, ns.
        period: Nanos,
    },
    /// Writes a modulation.
    Modulate {
        /// The schema.
        schema: usize,
        /// The modulation's name.
        variable: String,
        /// The value, as text.
        value: String,
    },
    /// Lets an export fail.
    Fail {
        /// The schema.
        schema: usize,
        /// The export's name.
        export: String,
        /// How it fails: "frozen".
        fault: String,
    },
    /// Ends the failure of an export.
    Repair {
        /// The schema.
        schema: usize,
        /// The export's name.
        export: String,
    },
    /// A gesture on a widget of a schema's panel.
    Touch {
        /// The schema.
        schema: usize,
        /// The number of the gesture among those delivered in this run, from 1.
        number: u64,
        /// The gesture.
        gesture: Gesture,
    },
}

impl OperatorAction {
    /// Returns the place of the schema that the action concerns.
    #[must_use]
    pub fn schema(&self) -> usize {
        match self {
            Self::Hierarchy(
                Operator::Play(id) | Operator::Stop(id) | Operator::Force(id) | Operator::Release(id),
            ) => id.index(),
            Self::Unload { schema }
            | Self::Load { schema }
            | Self::Reload { schema, .. }
            | Self::Period { schema, .. }
            | Self::Modulate { schema, .. }
            | Self::Fail { schema, .. }
            | Self::Repair { schema, .. }
            | Self::Touch { schema, .. } => *schema,
        }
    }

    /// Describes the action, given the schema's name: "played goon", "set vff.gain to 0.5".
    #[must_use]
    pub fn description(&self, name: &str) -> String {
        match self {
            Self::Hierarchy(Operator::Play(_)) => format!("played {name}"),
            Self::Hierarchy(Operator::Stop(_)) => format!("stopped {name}"),
            Self::Hierarchy(Operator::Force(_)) => format!("forced {name}"),
            Self::Hierarchy(Operator::Release(_)) => format!("released {name}"),
            Self::Unload { .. } => format!("unloaded {name}"),
            Self::Load { .. } => format!("loaded {name}"),
            Self::Reload { build, .. } => format!("reloads {name}: {build}"),
            Self::Period { period, .. } => format!("set the period of {name} to {} s", *period as f64 / 1e9),
            Self::Modulate { variable, value, .. } => format!("set {name}.{variable} to {value}"),
            Self::Fail { export, fault, .. } => format!("lets {name}.{export} fail: {fault}"),
            Self::Repair { export, .. } => format!("repaired {name}.{export}"),
            Self::Touch { gesture, .. } => gesture.words(name),
        }
    }
}
