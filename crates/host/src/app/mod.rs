//! Applications: which schemas there are, how they are bound, who is whose father, all checked before anything starts.
//!
//! [`load`] turns an application file into an [`Application`], in which every name is a number and every value has been
//! encoded, or into the list of all its [`Faults`]. Nothing here opens a library (that is the [`Catalogue`]'s business),
//! starts a schema or prints.
//!
//! ```toml
//! name     = "patrol"                 # the file's name if left out
//! doc      = "Walks its round."
//! roots    = ["teleop", "patrol"]     # the top level (R13); the first wins a collision. Several levels: [roots.NAME] with members
//! plugins  = ["../target/release"]    # more folders to look for plugins in
//! seed     = 7                        # 0 if left out
//! mission  = "patrol.mission"         # an export of type jde_msgs/msg/Mission that says when it is done; or { from, stalls = "60s" }
//! executor = "threads"                # or "pool"
//! root     = { policy = "priority" }  # as a group below
//! link     = { listen = ["tls/0.0.0.0:7447"] } # see [`link`]; without it nobody but its own user reaches it
//!
//! [schemas.patrol]
//! type      = "walk/patrol"           # plugin/schema; just the plugin if that leaves no doubt
//! doc       = "From door to door."
//! period    = "75ms"                  # or "10 Hz", or seconds; the type's if left out
//! budget    = "5ms"                   # longest iteration; the type's if left out
//! hang      = "200ms"                 # a call that takes longer is given up; ten budgets and at least 1 s if left out
//! imports   = { laser = "robot.laser" }       # exports and modulations of any instance
//! # or exports of another application: "robot2:pioneer.odometry", { from = "robot2:pioneer.odometry", stale = "300ms" }
//! triggers  = ["laser"]               # R12; the type's if left out
//! actuators = { base = "robot.velocity" }     # commands of drivers
//! children  = { brake = "stop", cruise = "goon" } # this order is the priority order
//! restart   = { back-off = "500ms", limit = 5, within = "60s" } # the default; or "on-fault", or "never"
//! isolate   = "process"               # or with limits: { memory = "200 MB", cpu = "2s", network = false, files = "read-only" }
//! speed     = "30 cm/s"               # any other key is a modulation; a bare number is in the port's unit
//! # policy: "priority", "urgency", "sticky" (dwell, hysteresis), "round-robin" (turn), "father";
//! # absence (R9): "brake", "hold" (hold), "fallback" (fallback, a role)
//! # and members (roles), where the type leaves the children to the file
//! groups.base = { policy = "sticky", dwell = "500ms", absence = "hold", hold = "300ms", patience = "5ms", budget = "5ms" }
//! ```

use std::path::PathBuf;
use std::sync::Arc;

use jde_abi::describe::{Plugin, Schema};
use jde_abi::inspect::Problem;
use jde_core::{Absence, Policy, Restart};

mod children;
mod conflict;
mod cycle;
mod document;
mod drafts;
mod family;
mod fault;
mod file;
pub mod given;
mod groups;
mod inspect;
mod isolation;
pub mod link;
mod load;
mod many;
mod modulations;
mod needs;
mod numbers;
mod option;
mod outline;
mod remote;
mod report;
mod roots;
mod rules;
mod settings;
mod spec;
mod suggest;
mod syntax;
mod time;
mod types;
mod units;
mod values;
mod variable;
mod wiring;

pub use fault::{Fault, Faults, Place};
pub use inspect::Inspection;
pub use isolation::Isolation;
pub use link::Link;
pub use load::{load, parse};
pub use option::Override;
pub use remote::Remote;
pub use values::is_path;

/// An application, complete and free of faults; instances and groups are named by their places in the lists.
#[derive(Clone, Debug)]
pub struct Application {
    /// Its name.
    pub name: String,
    /// What it does; may be empty.
    pub doc: String,
    /// The file it was read from, absolute.
    pub path: PathBuf,
    /// What all of its randomness starts from.
    pub seed: u64,
    /// How it runs in real time.
    pub executor: Executor,
    /// The export of type `jde_msgs/msg/Mission` that says when it is done: instance and port.
    pub mission: Option<(usize, usize)>,
    /// How long its mission may not come nearer to its target before that is an event, ns; never if nobody says.
    pub mission_stalls_ns: Option<u64>,
    /// The plugins that its instances come from.
    pub plugins: Vec<Arc<Plugin>>,
    /// Its instances, in the file's order.
    pub instances: Vec<Instance>,
    /// Its groups: the roots first, then by father, in the file's order.
    pub groups: Vec<Group>,
    /// Whom it lets in from other processes and machines.
    pub link: Link,
    /// The variables of other applications that it imports.
    pub remotes: Vec<Remote>,
    /// What its schemas find missing at present in what their modulations name, or why one could not be asked: no reason not to
    /// start.
    pub concerns: Option<Faults>,
}

/// How an application runs in real time.
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
pub struct Instance {
    /// Its name, unique in the application.
    pub name: String,
    /// What it is for, in the application's words; may be empty.
    pub doc: String,
    /// Its plugin's place in [`Application::plugins`].
    pub plugin: usize,
    /// Its type's place in that plugin.
    pub number: usize,
    /// Its type.
    pub schema: Arc<Schema>,
    /// Its period at the start, ns.
    pub period_ns: u64,
    /// Longest iteration, ns.
    pub budget_ns: u64,
    /// How long a call may take before it counts as hung, ns; ten budgets and at least a second if left out. Real time only.
    pub hang_ns: Option<u64>,
    /// What follows a fault.
    pub restart: Restart,
    /// The process of its own in which it runs, if it does.
    pub isolate: Option<Isolation>,
    /// The father in whose group it competes; none for roots, perceptive schemas and drivers.
    pub father: Option<usize>,
    /// The instance in each role of [`Schema::children`].
    pub children: Vec<Option<usize>>,
    /// The roles that are bound, in the order in which the application names them.
    pub child_order: Vec<usize>,
    /// What each port of [`Schema::ports`] is bound to.
    pub bindings: Vec<Binding>,
    /// The group in which each role's child competes; none for perceptive children and roles left unbound.
    pub child_groups: Vec<Option<usize>>,
    /// The group in which it competes itself; none for perceptive schemas and drivers.
    pub group: Option<usize>,
    /// Where the file defines it, from 1.
    pub line: usize,
}

/// What a port is bound to. Pairs are an instance and its port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Binding {
    /// Reads a variable.
    Import {
        /// Where it comes from; none if left unbound.
        source: Option<Source>,
        /// A new value re-evaluates the precondition at once (R12).
        trigger: bool,
    },
    /// Writes its own variable.
    Export,
    /// Is written by fathers and operators.
    Modulation {
        /// Value at the start, as large as the port's type.
        initial: Vec<u8>,
        /// The file or an option gives it, be it the default.
        set: bool,
    },
    /// Is written by the motor schemas that have authority.
    Command,
    /// Writes a command.
    Actuator {
        /// A driver's command; none if left unbound.
        target: Option<(usize, usize)>,
    },
    /// Writes a modulation of a child.
    ChildModulation {
        /// None if the child, or the child's modulation, may be missing and is.
        target: Option<ChildTarget>,
    },
}

/// Where an import comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// An export or a modulation of this application: instance and port.
    Here(usize, usize),
    /// An export of another: its place in [`Application::remotes`].
    Elsewhere(usize),
}

/// What a father's write to a child changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChildTarget {
    /// A modulation: instance and port.
    Port(usize, usize),
    /// The period of an instance, `std_msgs/msg/Float64` in seconds; every schema has it.
    Period(usize),
}

/// One competition among motor schemas: of the roots, or of some children of one father.
#[derive(Clone, Debug)]
pub struct Group {
    /// `roots`, or `roots/left`; or father and group: `example/base`.
    pub name: String,
    /// Its father; none for the roots.
    pub father: Option<usize>,
    /// Who competes, in the father's order, which is the priority order.
    pub members: Vec<usize>,
    /// How collisions are settled.
    pub policy: Policy,
    /// What happens when nobody wins.
    pub absence: Absence,
    /// How long a loser may hold up the new winner, ns.
    pub patience_ns: u64,
    /// Longest arbitration by the father's own function, ns.
    pub budget_ns: u64,
}

/// What may be loaded: the plugin loader, or in tests a list.
pub trait Catalogue {
    /// The plugin of that name, from the usual folders or these.
    ///
    /// # Errors
    /// Why it cannot be used, in words that complete "plugin `x` cannot be used: ".
    fn plugin(&self, name: &str, extra_dirs: &[PathBuf]) -> Result<Arc<Plugin>, String>;

    /// What a type of schema of that plugin finds wrong with what its modulations name. Nothing where nobody can be asked.
    ///
    /// # Errors
    /// Why it could not be asked, or answered nonsense.
    fn inspect(&self, plugin: &Arc<Plugin>, asked: &Inspection<'_>) -> Result<Vec<Problem>, String> {
        let _ = (plugin, asked);
        Ok(Vec::new())
    }

    /// Names that an application may write as a `type`, to suggest one that is near a slip.
    fn known(&self) -> Vec<String>;
}

impl Application {
    /// The place of an instance.
    #[must_use]
    pub fn instance(&self, name: &str) -> Option<usize> {
        self.instances.iter().position(|instance| instance.name == name)
    }

    /// The schemas that have a panel of their own, by their places.
    #[must_use]
    pub fn panels(&self) -> Vec<usize> {
        let instances = self.instances.iter().enumerate();
        instances
            .filter(|(_, instance)| instance.schema.panel)
            .map(|(place, _)| place)
            .collect()
    }

    /// The full name, on the board, of what an import reads.
    #[must_use]
    pub fn source_name(&self, source: Source) -> String {
        match source {
            Source::Here(instance, port) => {
                let instance = &self.instances[instance];
                format!("{}.{}", instance.name, instance.schema.ports[port].name)
            }
            Source::Elsewhere(remote) => self.remotes[remote].local.clone(),
        }
    }
}
