//! Applications: their schemas, the bindings and the hierarchy, all checked before anything starts.
//!
//! [`load`] turns an application file into an [`Application`], in which every name is a number and every
//! value is encoded, or into the list of all its [`Faults`]. This crate opens no library (the
//! [`Catalogue`] does), starts no schema and prints nothing.
//!
//! ```toml
//! name     = "patrol"                 # the file's name if left out
//! doc      = "Patrols the corridor."
//! roots    = ["teleop", "patrol"]     # the top level (R13), in priority order; or [roots.NAME] with members
//! plugins  = ["../target/release"]    # more folders to look for plugins in
//! seed     = 7                        # 0 if left out
//! mission  = "patrol.mission"         # a jde_msgs/msg/Mission, which states when it is done; or { from, stalls }
//! executor = "threads"                # or "pool"
//! root     = { policy = "priority" }  # with the keys of a group below
//! link     = { listen = ["tls/0.0.0.0:7447"] } # see [`link`]; if left out, only the same user can connect
//!
//! [schemas.patrol]
//! type      = "walk/patrol"           # plugin/schema; the plugin alone if that is unambiguous
//! doc       = "From door to door."
//! period    = "75ms"                  # or "10 Hz", or seconds; the type's if left out
//! budget    = "5ms"                   # longest iteration; the type's if left out
//! hang      = "200ms"                 # a longer call is given up; ten budgets and at least 1 s if left out
//! imports   = { laser = "robot.laser" }       # exports and modulations of any instance
//! # or exports of another application: "robot2:pioneer.odometry", or with an age limit:
//! # { from = "robot2:pioneer.odometry", stale = "300ms" }
//! triggers  = ["laser"]               # R12; the type's if left out
//! actuators = { base = "robot.velocity" }     # commands of drivers
//! children  = { brake = "stop", cruise = "goon" } # this order is the priority order
//! restart   = { back-off = "500ms", limit = 5, within = "60s" } # the default; or "on-fault", or "never"
//! isolate   = "process"               # or with limits:
//! # { memory = "200 MB", cpu = "2s", network = false, files = "read-only" }
//! speed     = "30 cm/s"               # any other key is a modulation; a bare number is in the port's unit
//! # policy: "sticky" (dwell, hysteresis), and all others of `jde_core::POLICIES`;
//! # absence (R9): "brake", "hold" (hold), "fallback" (fallback, a role)
//! # also budget = "5ms", guard = "footprint" (R18; a schema) with retry = "500ms", and members (roles) if the
//! # type leaves the children to the file
//! groups.base = { policy = "sticky", dwell = "500ms", absence = "hold", hold = "300ms", patience = "5ms" }
//! ```

use std::path::PathBuf;
use std::sync::Arc;

use jde_abi::describe::{Plugin, Port, Schema};
use jde_abi::inspect::Problem;
use jde_abi::lists::ListedPort;
use jde_core::{Absence, GroupId, Policy, Restart, SchemaId, Table};

mod absent;
mod agreement;
mod children;
mod conflict;
mod cycle;
mod drafts;
mod group_settings;
mod groups;
mod guards;
mod hierarchy;
mod ids;
mod inspect;
mod interfaces;
mod isolation;
pub mod link;
mod lists;
pub mod literal;
mod load;
mod modulations;
mod needs;
mod numbers;
mod odometry;
mod option;
mod outline;
pub mod period;
mod recorded;
mod remote;
mod settings;
mod spec;
pub mod time;
mod trigger_loops;
pub mod tuning;
mod types;
pub mod units;
mod validity;
mod values;
mod variable;
mod variadic;
mod warnings;
mod web;
mod wiring;

pub use hierarchy::MAX_DEPTH;
pub use ids::{InstancePort, RoleId};
pub use inspect::Inspection;
pub use isolation::Isolation;
pub use jde_document::{Fault, FaultLocation, Faults};
pub use link::Link;
pub use load::{load, load_text, parse, read_text};
pub use modulations::warn_of_former_name;
pub use option::Override;
pub use outline::ignores_faults;
pub use remote::RemoteVariable;
pub use values::is_path;
pub use web::Web;

/// An application, complete and free of faults. Its instances are the schemas of the rules.
#[derive(Clone, Debug)]
pub struct Application {
    /// Its name.
    pub name: String,
    /// A description; may be empty.
    pub doc: String,
    /// The file it was read from, absolute.
    pub path: PathBuf,
    /// The seed of all its randomness.
    pub seed: u64,
    /// The executor in real time.
    pub executor: Executor,
    /// The perceptive schemas and drivers that every root needs (R6).
    pub awake: Vec<SchemaId>,
    /// The export of type `jde_msgs/msg/Mission` that states when it is done.
    pub mission: Option<InstancePort>,
    /// How long the distance to the mission's target may fail to decrease before this is an event, ns; never
    /// if `None`.
    pub mission_stalls_ns: Option<u64>,
    /// Whether a schema that faults is no failure of a run.
    pub ignores_faults: bool,
    /// The plugins that its instances come from.
    pub plugins: Vec<Arc<Plugin>>,
    /// Its instances, in the file's order.
    pub instances: Table<SchemaId, InstanceConfig>,
    /// Its groups: the roots first, then by father, in the file's order.
    pub groups: Table<GroupId, GroupConfig>,
    /// Access from other processes and machines.
    pub link: Link,
    /// The page for browsers, if it states one.
    pub web: Option<Web>,
    /// The variables of other applications that it imports.
    pub remotes: Vec<RemoteVariable>,
    /// Things named by modulations that the schemas find unavailable at present, or why a schema
    /// could not be inspected. Not a reason to refuse the start.
    pub concerns: Option<Faults>,
}

/// The executor of an application in real time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Executor {
    /// A thread for each schema that is awake.
    #[default]
    Threads,
    /// Few threads for all schemas: for thousands of light ones.
    Pool,
}

/// One schema of an application.
#[derive(Clone, Debug)]
pub struct InstanceConfig {
    /// Its name, unique in the application.
    pub name: String,
    /// Its purpose in this application; may be empty.
    pub doc: String,
    /// Its plugin's place in [`Application::plugins`].
    pub plugin: usize,
    /// Its type's place in that plugin.
    pub number: usize,
    /// Its type.
    pub schema: Arc<Schema>,
    /// Its period at the start, ns.
    pub period_ns: u64,
    /// The period that the file states, or else the type: that at the start without options.
    pub stated_period_ns: u64,
    /// Longest iteration, ns.
    pub budget_ns: u64,
    /// How long a call may take before it counts as hung, ns; ten budgets and at least a second if `None`.
    /// Real time only.
    pub hang_ns: Option<u64>,
    /// The response to a fault.
    pub restart: Restart,
    /// The process of its own in which it runs; `None` if it runs in the host.
    pub isolate: Option<Isolation>,
    /// Whether a debugger may hold its calls at the terminal of the host. No file says so.
    pub debugged: bool,
    /// The father in whose group it competes; `None` for roots, perceptive schemas and drivers.
    pub father: Option<SchemaId>,
    /// The instance in each role of [`Schema::children`].
    pub children: Table<RoleId, Option<SchemaId>>,
    /// The roles that are bound, in the order in which the application names them.
    pub child_order: Vec<RoleId>,
    /// What each port of [`Schema::ports`] is bound to.
    pub bindings: Vec<Binding>,
    /// The ports of the type's lists, which are the last of [`Schema::ports`].
    pub listed: Vec<ListedPort>,
    /// The group in which each role's child competes; `None` for perceptive children and unbound roles.
    pub child_groups: Table<RoleId, Option<GroupId>>,
    /// The group in which it competes itself; `None` for perceptive schemas and drivers.
    pub group: Option<GroupId>,
    /// The line of its definition in the file, from 1.
    pub line: usize,
    /// Its exports that never have a value, as its type has found before the start.
    pub absent: Vec<AbsentExport>,
}

/// An export that never has a value with the modulations of its instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AbsentExport {
    /// Its place in [`Schema::ports`].
    pub port: usize,
    /// Why, in the words of the type.
    pub words: String,
}

/// What a port is bound to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Binding {
    /// Reads a variable.
    Import {
        /// The source; `None` if unbound.
        source: Option<ImportSource>,
        /// A new value re-evaluates the precondition at once (R12).
        trigger: bool,
        /// The age from which it takes no value, ns, if it states one. That of a remote variable is in its
        /// [`RemoteVariable`].
        stale_ns: Option<jde_core::Nanos>,
    },
    /// Writes its own variable.
    Export,
    /// Is written by fathers and operators.
    Modulation {
        /// Value at the start, as large as the port's type.
        initial: Vec<u8>,
        /// What the file states, or else the default: the value at the start without options.
        stated: Vec<u8>,
        /// Whether the file or an option sets it, even to the default.
        set: bool,
    },
    /// Is written by the motor schemas that have authority.
    Command,
    /// Writes a command.
    Actuator {
        /// A driver's command; `None` if unbound.
        target: Option<InstancePort>,
    },
    /// Writes a modulation of a child.
    ChildModulation {
        /// `None` if the child or the child's modulation is optional and missing.
        target: Option<ChildTarget>,
    },
}

/// The source of an import.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImportSource {
    /// An export or a modulation of this application.
    Local(InstancePort),
    /// An export of another application: its place in [`Application::remotes`].
    Remote(usize),
}

/// The target of a father's write to a child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChildTarget {
    /// A modulation.
    Port(InstancePort),
    /// The period of an instance, which every schema has: `std_msgs/msg/Float64` in seconds.
    Period(SchemaId),
}

/// One competition among motor schemas: the roots or a part of them, or children of one father.
#[derive(Clone, Debug)]
pub struct GroupConfig {
    /// `roots`, or `roots/left`; or father and group: `example/base`.
    pub name: String,
    /// Its father; `None` for the roots.
    pub father: Option<SchemaId>,
    /// The competing instances, in the father's order, which is the priority order.
    pub members: Vec<SchemaId>,
    /// How collisions are settled.
    pub policy: Policy,
    /// What happens without a winner.
    pub absence: Absence,
    /// How long a loser may delay the new winner, ns.
    pub patience_ns: u64,
    /// Longest arbitration by the father's own function, ns.
    pub budget_ns: u64,
    /// The instance that judges the commands of the group and of everything below it (R18).
    pub guard: Option<SchemaId>,
    /// How long a member is not READY after a guard has refused a command of it, ns (R18).
    pub retry_ns: u64,
}

/// Why a plugin cannot be used.
#[derive(Clone, Debug)]
pub struct Unusable {
    /// Completes "plugin `x` cannot be used: ".
    pub reason: String,
    /// Whether there is no such plugin, whose name may be misspelt.
    pub is_missing: bool,
}

/// The available plugins: the plugin loader, or in tests a list.
pub trait Catalogue {
    /// Returns the plugin of that name, from the usual folders or `extra_dirs`.
    ///
    /// # Errors
    /// Why it cannot be used.
    fn plugin(&self, name: &str, extra_dirs: &[PathBuf]) -> Result<Arc<Plugin>, Unusable>;

    /// Requests an inspection of what the modulations of a schema type name, and returns the problems. Empty
    /// where no inspection is possible.
    ///
    /// # Errors
    /// Why the type could not be inspected, or that its result was invalid.
    fn inspect(&self, plugin: &Arc<Plugin>, inspection: &Inspection<'_>) -> Result<Vec<Problem>, String> {
        let _ = (plugin, inspection);
        Ok(Vec::new())
    }

    /// Returns names that an application may write as a `type`, to suggest one for a misspelt name.
    fn type_names(&self) -> Vec<String>;
}

impl InstanceConfig {
    /// Returns the ports of the type's lists.
    #[must_use]
    pub fn listed_ports(&self) -> &[Port] {
        &self.schema.ports[self.schema.ports.len() - self.listed.len()..]
    }
}

impl Application {
    /// Returns the instance of that name.
    #[must_use]
    pub fn instance(&self, name: &str) -> Option<SchemaId> {
        self.instances.find(|instance| instance.name == name)
    }

    /// Returns the schemas that have a panel.
    #[must_use]
    pub fn panels(&self) -> Vec<SchemaId> {
        let instances = self.instances.entries();
        instances
            .filter(|(_, instance)| instance.schema.panel)
            .map(|(id, _)| id)
            .collect()
    }

    /// Returns the full name, on the board, of the variable that an import reads.
    #[must_use]
    pub fn source_name(&self, source: ImportSource) -> String {
        match source {
            ImportSource::Local(port) => self.variable_name(port),
            ImportSource::Remote(remote) => self.remotes[remote].local.clone(),
        }
    }

    /// Returns the full name of the variable of a port: `pioneer.laser`.
    #[must_use]
    pub fn variable_name(&self, InstancePort { instance, port }: InstancePort) -> String {
        let instance = &self.instances[instance];
        format!("{}.{}", instance.name, instance.schema.ports[port].name)
    }

    /// Returns the full name of the variable that a father writes.
    #[must_use]
    pub fn target_name(&self, target: ChildTarget) -> String {
        match target {
            ChildTarget::Port(port) => self.variable_name(port),
            ChildTarget::Period(instance) => format!("{}.period", self.instances[instance].name),
        }
    }
}
