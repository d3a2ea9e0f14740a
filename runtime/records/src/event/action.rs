//! The actions of operators (R14).

use jde_core::{Nanos, Operator, SchemaId};
use jde_panel::Gesture;
use serde::{Deserialize, Serialize};

use crate::reload::BuildName;

/// An action of an operator on a schema.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OperatorAction<N = SchemaId> {
    /// Requests that a schema is awake.
    Play {
        /// The schema.
        schema: N,
    },
    /// Puts a schema to sleep.
    Stop {
        /// The schema.
        schema: N,
    },
    /// Makes a schema the choice of its group.
    Force {
        /// The schema.
        schema: N,
    },
    /// Ends what a schema is held to.
    Release {
        /// The schema.
        schema: N,
    },
    /// Ends the instance of a schema.
    Unload {
        /// The schema.
        schema: N,
    },
    /// Permits a fresh instance of a schema.
    Load {
        /// The schema.
        schema: N,
    },
    /// Replaces the build of a schema by another one.
    Reload {
        /// The schema.
        schema: N,
        /// The build.
        build: BuildName,
    },
    /// Changes a period.
    Period {
        /// The schema.
        schema: N,
        /// The new period, ns.
        period: Nanos,
    },
    /// Writes a modulation.
    Modulate {
        /// The schema.
        schema: N,
        /// The modulation's name.
        variable: String,
        /// The value, as text.
        value: String,
    },
    /// Lets an export fail.
    Fail {
        /// The schema.
        schema: N,
        /// The export's name.
        export: String,
        /// How it fails: "frozen".
        fault: String,
    },
    /// Ends the failure of an export.
    Repair {
        /// The schema.
        schema: N,
        /// The export's name.
        export: String,
    },
    /// A gesture on a widget of a schema's panel.
    Touch {
        /// The schema.
        schema: N,
        /// The number of the gesture among those delivered in this run, from 1.
        number: u64,
        /// The gesture.
        #[serde(flatten)]
        gesture: Gesture,
    },
}

impl From<Operator> for OperatorAction {
    fn from(operator: Operator) -> Self {
        match operator {
            Operator::Play(schema) => Self::Play { schema },
            Operator::Stop(schema) => Self::Stop { schema },
            Operator::Force(schema) => Self::Force { schema },
            Operator::Release(schema) => Self::Release { schema },
        }
    }
}

impl<N> OperatorAction<N> {
    /// Returns the schema that the action concerns.
    #[must_use]
    pub fn schema(&self) -> &N {
        match self {
            Self::Play { schema }
            | Self::Stop { schema }
            | Self::Force { schema }
            | Self::Release { schema }
            | Self::Unload { schema }
            | Self::Load { schema }
            | Self::Reload { schema, .. }
            | Self::Period { schema, .. }
            | Self::Modulate { schema, .. }
            | Self::Fail { schema, .. }
            | Self::Repair { schema, .. }
            | Self::Touch { schema, .. } => schema,
        }
    }
}

impl<N> OperatorAction<N> {
    /// Whether it is a gesture of which more will follow: see [`Gesture::goes_on`].
    #[must_use]
    pub fn goes_on(&self) -> bool {
        matches!(self, Self::Touch { gesture, .. } if gesture.goes_on())
    }
}

impl OperatorAction<String> {
    /// Describes the action: "played goon", "set vff.gain to 0.5".
    #[must_use]
    pub fn description(&self) -> String {
        match self {
            Self::Play { schema } => format!("played {schema}"),
            Self::Stop { schema } => format!("stopped {schema}"),
            Self::Force { schema } => format!("forced {schema}"),
            Self::Release { schema } => format!("released {schema}"),
            Self::Unload { schema } => format!("unloaded {schema}"),
            Self::Load { schema } => format!("loaded {schema}"),
            Self::Reload { schema, build } => format!("reloads {schema}: {build}"),
            Self::Period { schema, period } => {
                format!("set the period of {schema} to {} s", *period as f64 / 1e9)
            }
            Self::Modulate {
                schema,
                variable,
                value,
            } => format!("set {schema}.{variable} to {value}"),
            Self::Fail {
                schema,
                export,
                fault,
            } => format!("lets {schema}.{export} fail: {fault}"),
            Self::Repair { schema, export } => format!("repaired {schema}.{export}"),
            Self::Touch { schema, gesture, .. } => gesture.words(schema),
        }
    }
}
