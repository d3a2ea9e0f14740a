//! What operators do (R14), and it in words.

use jde_core::{Nanos, Operator};
use jde_panel::Gesture;

use crate::build::BuildName;

/// What an operator can do.
#[derive(Clone, Debug, PartialEq)]
pub enum OperatorAction {
    /// Plays, stops, forces or releases a schema.
    Hierarchy(Operator),
    /// Ends the instance of a schema.
    Unload {
        /// Of which schema.
        schema: usize,
    },
    /// Lets a schema have a fresh instance.
    Load {
        /// Which.
        schema: usize,
    },
    /// Has another build take over.
    Reload {
        /// Of which schema.
        schema: usize,
        /// Which build.
        build: BuildName,
    },
    /// Changes a period, ns.
    Period {
        /// Of which schema.
        schema: usize,
        /// The new one.
        period: Nanos,
    },
    /// Writes a modulation.
    Modulate {
        /// Of which schema.
        schema: usize,
        /// Its name.
        variable: String,
        /// The value, in words.
        value: String,
    },
    /// Did something to a widget of a schema's panel.
    Touch {
        /// Whose panel.
        schema: usize,
        /// Counts the gestures of the run that were handed in, from 1.
        number: u64,
        /// What.
        gesture: Gesture,
    },
}

impl OperatorAction {
    /// The place of the schema it was done to.
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
            | Self::Touch { schema, .. } => *schema,
        }
    }

    /// What was done, given the schema's name: "played goon", "set vff.gain to 0.5".
    #[must_use]
    pub fn words(&self, name: &str) -> String {
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
            Self::Touch { gesture, .. } => gesture.words(name),
        }
    }
}
