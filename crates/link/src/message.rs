//! The messages of the link: JSON, for people who write clients in any language. Unknown fields are passed over, so that a
//! newer peer may say more. Data only; `docs/protocol.md` shows each.

use std::fmt;

use jde_abi::describe::Limits;
use jde_host::reload::Reloaded;
use jde_panel::Gesture;
use serde::{Deserialize, Serialize};

/// What an application is, and where: the answer to `about`, and the file by which it announces itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// How others call it.
    pub name: String,
    /// What tells it from others of its name: 16 hexadecimal digits, new for each run.
    pub id: String,
    /// The version of the link protocol that it speaks.
    pub protocol: u32,
    /// Its version of jde.
    pub version: String,
    /// The machine it runs on.
    pub host: String,
    /// The user it runs as.
    pub user: String,
    /// Its process.
    pub pid: u32,
    /// The name of the application.
    pub application: String,
    /// The file it was read from, on its own machine.
    pub file: String,
    /// When it started, ns since 1970.
    pub started_ns: u64,
    /// `threads`, `pool`, `lockstep` or `replay`.
    pub executor: String,
    /// Seconds of the application in a second of the machine.
    pub speed: f64,
    /// What clients from the network may do.
    pub network: Network,
}

/// What clients from the network may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Network {
    /// They do not get in.
    Closed,
    /// Look.
    Read,
    /// Look and operate.
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SchemaInfo {
    /// Its name in the application.
    pub name: String,
    /// Its type, `plugin/schema`.
    #[serde(rename = "type")]
    pub type_name: String,
    /// `perceptive`, `motor` or `driver`.
    pub kind: String,
    /// What it does.
    pub doc: String,
    /// Its father, if it has one.
    pub father: Option<String>,
    /// The group in which it competes, if it does.
    pub group: Option<String>,
    /// Its period at the start, s.
    pub period_s: f64,
    /// Longest iteration, s.
    pub budget_s: f64,
    /// Its children by role.
    pub children: Vec<ChildInfo>,
    /// Its inputs and outputs.
    pub ports: Vec<PortInfo>,
    /// Whether it has a panel of its own.
    #[serde(default)]
    pub panel: bool,
}

/// A child in its role.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChildInfo {
    /// The role.
    pub role: String,
    /// What it is for.
    pub doc: String,
    /// Who has it.
    pub schema: Option<String>,
}

/// An input or output of a schema.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PortInfo {
    /// Its name.
    pub name: String,
    /// `import`, `export`, `modulation`, `command`, `actuator` or `child-modulation`.
    pub role: String,
    /// The ROS 2 name of its type.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Unit of a plain number; empty for none.
    pub unit: String,
    /// What it means.
    pub doc: String,
    /// What it takes, of a plain number.
    pub range: Range,
    /// Taken on awakening, and kept until its schema sleeps.
    pub fixed: bool,
    /// The variable it reads or writes; none if left unbound.
    pub variable: Option<String>,
}

/// What is allowed of a plain number.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// Least.
    pub least: Option<f64>,
    /// Greatest.
    pub greatest: Option<f64>,
    /// Names of the numbers from 0 on, where it is one of several.
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
    /// Whether a number is within.
    #[must_use]
    pub fn holds(&self, number: f64) -> bool {
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
    /// Its father; none for the roots.
    pub father: Option<String>,
    /// Who competes, in the order of priority.
    pub members: Vec<String>,
    /// How collisions are settled.
    pub policy: String,
}

/// A shared variable: one of the answer to `variables`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VariableInfo {
    /// Its full name, `owner.variable`.
    pub name: String,
    /// The schema that has it; `peer:schema` for one imported from another application.
    pub owner: String,
    /// Its name there.
    pub variable: String,
    /// `export`, `modulation` or `command`.
    pub access: String,
    /// The ROS 2 name of its type.
    #[serde(rename = "type")]
    pub type_name: String,
    /// The type's definition, as `ros2msg` of MCAP.
    pub definition: String,
    /// Unit of a plain number; empty for none.
    pub unit: String,
    /// What it means.
    pub doc: String,
    /// What it takes, of a plain number.
    pub range: Range,
    /// Taken on awakening, and kept until its schema sleeps.
    pub fixed: bool,
    /// How it is doing; only where that was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub status: Option<Status>,
}

/// How a variable is doing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Number of the newest value; 0 before the first.
    pub sequence: u64,
    /// Age of the newest value, s; none before the first.
    pub age_s: Option<f64>,
    /// Values per second, estimated.
    pub rate_hz: f64,
    /// Whether the newest value was taken back.
    pub retracted: bool,
    /// Who wrote the newest value.
    pub last_writer: Option<String>,
    /// Who has it open for writing.
    pub writers: Vec<String>,
    /// Who has it open for reading.
    pub readers: Vec<String>,
    /// Values refused because their writer held no grant.
    pub refused: u64,
    /// Values refused because they held a NaN or an infinity.
    pub not_finite: u64,
}

/// What is asked of `operate`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Who acts: `ana@laptop`.
    pub by: String,
    /// What.
    #[serde(flatten)]
    pub action: Action,
    /// Undo it after so long unless it is renewed, ms; without one it stands until it is released.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lease_ms: Option<u64>,
}

/// What an operator can do (R14).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "action", rename_all = "kebab-case")]
pub enum Action {
    /// Wakes a schema as its father would.
    Play {
        /// Which.
        schema: String,
    },
    /// Puts a schema to sleep until it is released.
    Stop {
        /// Which.
        schema: String,
    },
    /// Makes a schema the winner of its group while it is awake.
    Force {
        /// Which.
        schema: String,
    },
    /// Undoes what operators did to a schema, whoever they are.
    Release {
        /// Which.
        schema: String,
    },
    /// Puts every root to sleep, and every command to its neutral value.
    StopAll,
    /// Lets the roots go on that were stopped with everything.
    ReleaseAll,
    /// Undoes what this operator did to a schema; what others did stays.
    LetGo {
        /// Which.
        schema: String,
    },
    /// Changes the period of a schema.
    Period {
        /// Of which.
        schema: String,
        /// The new one, s.
        period_s: f64,
    },
    /// Writes a modulation.
    Modulate {
        /// Of which schema.
        schema: String,
        /// Its name.
        variable: String,
        /// A number, text, list, or fields by name; what is left out stays.
        value: serde_json::Value,
    },
    /// Puts a schema to sleep and ends its instance; its variables stay.
    Unload {
        /// Which.
        schema: String,
    },
    /// Makes a fresh instance of an unloaded schema, and lets it go.
    Load {
        /// Which.
        schema: String,
    },
    /// Has the build that is now in its plugin's file take over between two iterations.
    Reload {
        /// Which; or a plugin, for all schemas of it.
        schema: String,
        /// How long it is on trial, s; none for the usual.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        probation_s: Option<f64>,
        /// It begins anew, whatever the build before remembers.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        fresh: bool,
    },
    /// Does something to a widget of a schema's panel.
    Touch {
        /// Whose panel.
        schema: String,
        /// What, and to which widget.
        gesture: Gesture,
    },
    /// Renews the lease on what this operator holds at a schema.
    Renew {
        /// Which.
        schema: String,
    },
}

/// The answer to `operate`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fine {
    /// True.
    pub ok: bool,
    /// What came of a reload.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reloaded: Option<Reloaded>,
    /// The roots that were stopped or released, by what is about everything.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub roots: Vec<String>,
}

/// Why a request was refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refusal {
    /// In words.
    pub error: String,
    /// The nearest name there is, if a name was not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nearest: Option<String>,
}

impl Action {
    /// The schema it is about; empty if that is all of them.
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
            Self::StopAll | Self::ReleaseAll => "",
        }
    }

    /// Whether it is about everything that an application does.
    #[must_use]
    pub fn is_about_everything(&self) -> bool {
        matches!(self, Self::StopAll | Self::ReleaseAll)
    }
}

impl Refusal {
    /// A refusal in words alone.
    pub(crate) fn new(error: impl Into<String>) -> Self {
        Self {
            error: error.into(),
            nearest: None,
        }
    }

    /// That what is about everything takes no lease.
    pub(crate) fn everything_stays() -> Self {
        Self::new("to stop everything is held by no lease: it must not end by itself")
    }

    /// That there is no such name.
    pub(crate) fn unknown<'a>(what: &str, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        Self {
            error: format!("there is no {what} `{name}`"),
            nearest: jde_board::nearest(name, known).map(str::to_owned),
        }
    }
}

impl VariableInfo {
    /// Its type, rebuilt from the definition.
    ///
    /// # Errors
    /// Why the definition cannot be read.
    pub fn value_type(&self) -> Result<jde_abi::describe::Type, jde_ros::definition::ReadError> {
        jde_ros::definition::read(&self.type_name, &self.definition)
    }
}
