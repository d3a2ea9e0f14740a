//! The messages of the link, in JSON, for clients in any language. Unknown fields are ignored, so that a
//! newer peer may send more. Data only; `docs/protocol.md` shows each message.

use std::fmt;

use jde_abi::describe::Limits;
use jde_panel::Gesture;
use jde_records::reload::ReloadReport;
use serde::{Deserialize, Serialize};

/// An application's identity and location: the answer to `about`, and the content of its announcement file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// The name by which others address it.
    pub name: String,
    /// The id that distinguishes it from others of the same name: 16 hexadecimal digits, new for each run.
    pub id: String,
    /// The version of the link protocol that it implements.
    pub protocol: u32,
    /// The version of jde that it runs.
    pub version: String,
    /// The machine on which it runs.
    pub host: String,
    /// The user as which it runs.
    pub user: String,
    /// Its process id.
    pub pid: u32,
    /// The name of the application.
    pub application: String,
    /// The file that it was loaded from, on its own machine.
    pub file: String,
    /// When it started, ns since 1970.
    pub started_ns: u64,
    /// `threads`, `pool`, `lockstep` or `replay`.
    pub executor: String,
    /// Seconds of application time per second of real time.
    pub speed: f64,
    /// What clients on the network may do.
    pub network: Network,
}

/// What clients on the network may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Network {
    /// They cannot connect.
    Closed,
    /// They may read.
    Read,
    /// They may read and operate.
    Operate,
}

/// The answer to `schemas`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Schemas {
    /// Every schema, in the application's order.
    pub schemas: Vec<SchemaInfo>,
    /// Every group.
    pub groups: Vec<GroupInfo>,
}

/// A schema of an application.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SchemaInfo {
    /// Its name in the application.
    pub name: String,
    /// Its type, `plugin/schema`.
    #[serde(rename = "type")]
    pub type_name: String,
    /// `perceptive`, `motor` or `driver`.
    pub kind: String,
    /// The purpose of its type.
    pub doc: String,
    /// Its father, if any.
    pub father: Option<String>,
    /// The group in which it competes, if any.
    pub group: Option<String>,
    /// Its period at the start, s.
    pub period_s: f64,
    /// The longest allowed iteration, s.
    pub budget_s: f64,
    /// Its children by role.
    pub children: Vec<ChildInfo>,
    /// Its inputs and outputs.
    pub ports: Vec<PortInfo>,
    /// Whether it has a panel.
    #[serde(default)]
    pub panel: bool,
}

/// A role of a father, and the child that fills it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChildInfo {
    /// The role.
    pub role: String,
    /// The purpose of the role.
    pub doc: String,
    /// The schema in this role, if any.
    pub schema: Option<String>,
}

/// An input or output of a schema.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PortInfo {
    /// Its name.
    pub name: String,
    /// The name that it had before, if it was renamed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub former_name: Option<String>,
    /// `import`, `export`, `modulation`, `command`, `actuator` or `child-modulation`.
    pub role: String,
    /// The ROS 2 name of its type.
    #[serde(rename = "type")]
    pub type_name: String,
    /// The unit of a plain number; empty if there is none.
    pub unit: String,
    /// The meaning.
    pub doc: String,
    /// The allowed values of a plain number.
    pub range: Range,
    /// Read when the schema awakens, and constant until it sleeps.
    pub fixed: bool,
    /// The variable that it reads or writes; none if the port is unbound.
    pub variable: Option<String>,
}

/// The allowed values of a plain number.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// The least.
    pub least: Option<f64>,
    /// The greatest.
    pub greatest: Option<f64>,
    /// For an enumeration: the names of the numbers, from 0 on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<String>,
}

impl From<&Limits> for Range {
    fn from(limits: &Limits) -> Self {
        Self {
            least: limits.least,
            greatest: limits.greatest,
            choices: limits.choices.clone(),
        }
    }
}

impl Range {
    /// Whether a number is within the range.
    #[must_use]
    pub fn contains(&self, number: f64) -> bool {
        self.least.is_none_or(|least| number >= least)
            && self.greatest.is_none_or(|greatest| number <= greatest)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.choices.is_empty() {
            return write!(f, "one of {}", self.choices.join(", "));
        }
        match (self.least, self.greatest) {
            (Some(least), Some(greatest)) => write!(f, "{least} to {greatest}"),
            (Some(least), None) => write!(f, "{least} or more"),
            (None, Some(greatest)) => write!(f, "{greatest} or less"),
            (None, None) => f.write_str("any number"),
        }
    }
}

/// A group of an application.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroupInfo {
    /// Its name.
    pub name: String,
    /// Its father; none for the group of the roots.
    pub father: Option<String>,
    /// Its members, in order of priority.
    pub members: Vec<String>,
    /// The policy that settles collisions.
    pub policy: String,
}

/// A shared variable: one element of the answer to `variables`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct VariableInfo {
    /// Its full name, `owner.variable`.
    pub name: String,
    /// The schema that owns it; `peer:schema` for one imported from another application.
    pub owner: String,
    /// Its name within the owner.
    pub variable: String,
    /// `export`, `modulation` or `command`.
    pub access: String,
    /// The ROS 2 name of its type.
    #[serde(rename = "type")]
    pub type_name: String,
    /// The definition of the type, in MCAP's `ros2msg` form.
    pub definition: String,
    /// The unit of a plain number; empty if there is none.
    pub unit: String,
    /// The meaning.
    pub doc: String,
    /// The allowed values of a plain number.
    pub range: Range,
    /// Read when its schema awakens, and constant until it sleeps.
    pub fixed: bool,
    /// Of a modulation: what the application's file states, or else the default of the type.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stated: Option<serde_json::Value>,
    /// Its status; only if the client requested it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub status: Option<Status>,
}

/// The status of a variable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// The sequence number of the newest value; 0 before the first.
    pub sequence: u64,
    /// Age of the newest value, s; none before the first.
    pub age_s: Option<f64>,
    /// Values per second, estimated.
    pub rate_hz: f64,
    /// Whether the newest value has ended (R19): readers have none.
    pub retracted: bool,
    /// The writer of the newest value.
    pub last_writer: Option<String>,
    /// The names under which it is open for writing.
    pub writers: Vec<String>,
    /// The names under which it is open for reading.
    pub readers: Vec<String>,
    /// Values refused because their writer held no grant.
    pub refused: u64,
    /// Values refused because they held a NaN or an infinity.
    pub not_finite: u64,
}

/// A request to `operate`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// The operator: `ana@laptop`.
    pub by: String,
    /// The action.
    #[serde(flatten)]
    pub action: Action,
    /// The action is undone after this time unless it is renewed, ms. Without a lease it lasts until it is
    /// released. What an operator does with and without a lease are separate holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lease_ms: Option<u64>,
}

/// An action of an operator (R14).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "action", rename_all = "kebab-case")]
pub enum Action {
    /// Wakes a schema as its father would.
    Play {
        /// The schema.
        schema: String,
    },
    /// Puts a schema to sleep until it is released.
    Stop {
        /// The schema.
        schema: String,
    },
    /// Makes a schema the winner of its group while it is awake.
    Force {
        /// The schema.
        schema: String,
    },
    /// Undoes what any operator did to a schema.
    Release {
        /// The schema.
        schema: String,
    },
    /// Puts every root to sleep and sets every command to its neutral value.
    StopAll,
    /// Lets the roots that `StopAll` stopped run again.
    ReleaseAll,
    /// Lets the time of an application that stands still pass again.
    Continue,
    /// Lets a little time pass of an application that stands still.
    Step,
    /// Undoes what this operator did to a schema, or with a lease only what was done under one; actions of other
    /// operators remain.
    LetGo {
        /// The schema.
        schema: String,
    },
    /// Changes the period of a schema.
    Period {
        /// The schema.
        schema: String,
        /// The new period, s.
        period_s: f64,
    },
    /// Writes a modulation.
    Modulate {
        /// The schema.
        schema: String,
        /// Its name.
        variable: String,
        /// The new value: a number, text, list, or fields by name. Omitted fields keep their values.
        value: serde_json::Value,
    },
    /// Puts a schema to sleep and destroys its instance. Its variables remain.
    Unload {
        /// The schema.
        schema: String,
    },
    /// Creates a fresh instance of an unloaded schema and lets it run.
    Load {
        /// The schema.
        schema: String,
    },
    /// Replaces the running build by the one that is now in the plugin's file, between two iterations.
    Reload {
        /// The schema; or a plugin, for all its schemas.
        schema: String,
        /// The length of its probation, s; none for the default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        probation_s: Option<f64>,
        /// The new instance starts afresh and ignores the state of the previous one.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        fresh: bool,
    },
    /// Performs a gesture on a widget of a schema's panel.
    Touch {
        /// The schema.
        schema: String,
        /// The gesture and its widget.
        gesture: Gesture,
    },
    /// Renews the lease on what this operator holds of a schema.
    Renew {
        /// The schema.
        schema: String,
    },
}

/// The answer to `operate`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OperateReply {
    /// Always true: a refusal is an error reply.
    pub ok: bool,
    /// The outcome of a reload.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reloaded: Option<ReloadReport>,
    /// The roots that a request to all schemas stopped or released; those that were not stopped are not released.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub roots: Vec<String>,
    /// What awake schemas lose by a stop or an unload: "goon loses its laser".
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub losses: String,
}

/// The reason why a request was refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refusal {
    /// The reason as text.
    pub error: String,
    /// The most similar name that exists, if a name was unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nearest: Option<String>,
}

impl Action {
    /// The schema that the action applies to; empty if it applies to all.
    #[must_use]
    pub fn schema(&self) -> &str {
        match self {
            Self::Play { schema }
            | Self::Stop { schema }
            | Self::Force { schema }
            | Self::Release { schema }
            | Self::LetGo { schema }
            | Self::Period { schema, .. }
            | Self::Modulate { schema, .. }
            | Self::Unload { schema }
            | Self::Load { schema }
            | Self::Reload { schema, .. }
            | Self::Touch { schema, .. }
            | Self::Renew { schema } => schema,
            Self::StopAll | Self::ReleaseAll | Self::Continue | Self::Step => "",
        }
    }

    /// Whether the action applies to the whole application.
    #[must_use]
    pub fn is_global(&self) -> bool {
        matches!(
            self,
            Self::StopAll | Self::ReleaseAll | Self::Continue | Self::Step
        )
    }
}

impl Refusal {
    /// A refusal without a suggestion.
    #[must_use]
    pub fn new(error: impl Into<String>) -> Self {
        Self {
            error: error.into(),
            nearest: None,
        }
    }

    /// Refuses a lease for an action on the whole application.
    pub(crate) fn lease_on_global() -> Self {
        Self::new("a stop or release of everything can have no lease: it must not end by itself")
    }

    /// Refuses an unknown name and suggests the most similar one.
    #[must_use]
    pub fn unknown<'a>(what: &str, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        Self {
            error: format!("there is no {what} `{name}`"),
            nearest: jde_nearest::nearest(name, known).map(str::to_owned),
        }
    }
}

impl VariableInfo {
    /// The type, rebuilt from its definition.
    ///
    /// # Errors
    /// The definition cannot be read.
    pub fn value_type(&self) -> Result<jde_abi::describe::Type, jde_ros::definition::ReadError> {
        jde_ros::definition::read(&self.type_name, &self.definition)
    }
}
