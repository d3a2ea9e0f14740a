//! A bench for tests of a schema. It uses the same tables as the host, without plugins, threads or a clock of
//! its own.
//!
//! It selects nothing: the test decides whether a motor schema is WINNER and what its children do.
//!
//! long because every way in which a host meets a schema has its function.

#![allow(unsafe_code)]

mod bytes;
mod failure;
mod foreign;
mod host;
mod inspect;
mod lists;
mod memory;
mod names;
mod panel;
mod state;

use core::ffi::{CStr, c_void};
use core::marker::PhantomData;
use core::ptr;
use core::time::Duration;

use jde_abi::{describe, raw, read, table};
use jde_core::Policy;
use jde_types::{Modulated, Value, wire};

use crate::child::State;
use crate::context::Severity;
use crate::level::Case;
use crate::schema::{Precondition, Schema};
pub use failure::Failure;
pub use inspect::Problem;
pub use lists::Entry;
pub use memory::Remembered;
use names::Kind;
pub use panel::Drawn;
use state::BenchState;

/// A schema under test. At first it is asleep, at time 0, with authority over its actuators and children.
///
/// Unknown names of ports and children, and values of another type, panic with a message, because they are
/// mistakes of the test.
///
/// ```
/// use jde_schema::bench::Bench;
/// use jde_schema::prelude::*;
///
/// /// Doubles what it reads.
/// #[derive(Describe)]
/// #[schema(perceptive, period = "10ms")]
/// struct Double {
///     #[import]
///     half: Import<f64>,
///     #[export]
///     whole: Export<f64>,
/// }
///
/// impl Schema for Double {
///     fn iterate(&mut self, cx: &Context) -> Result {
///         let half = *self.half.require(cx)?;
///         self.whole.write(cx, 2.0 * half);
///         Ok(())
///     }
/// }
///
/// let mut bench = Bench::<Double>::new();
/// assert_eq!(bench.iterate().unwrap_err().reason, "import `half` has no value");
/// bench.import("half", &21.0);
/// bench.iterate().unwrap();
/// assert_eq!(bench.exported::<f64>("whole"), Some(42.0));
/// ```
pub struct Bench<S = Foreign> {
    table: raw::Schema,
    description: describe::Schema,
    state: Box<BenchState>,
    instance: *mut c_void,
    schema: PhantomData<S>,
    /// The number of the type's own ports; those of its lists follow.
    own_ports: usize,
}

/// A schema that is written in another language.
#[derive(Debug)]
pub enum Foreign {}

/// The choice of a father's own arbitration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decision {
    /// The role of the chosen child; `None` if it chose no child.
    pub child: Option<String>,
    /// The reason for the choice.
    pub reason: String,
}

impl<S: Schema> Bench<S> {
    /// Creates an instance.
    ///
    /// # Panics
    /// If the creation fails.
    #[must_use]
    pub fn new() -> Self {
        match Self::try_new() {
            Ok(bench) => bench,
            Err(failure) => panic!("{failure}"),
        }
    }

    /// Creates an instance.
    ///
    /// # Errors
    /// If the creation fails.
    pub fn try_new() -> Result<Self, Failure> {
        // SAFETY: generated code builds tables that keep the rules, and a constant lives for ever.
        unsafe { Self::of(const { &S::TABLE }, &[]) }
    }

    /// Returns the instance, to examine its memory.
    #[must_use]
    pub fn schema(&self) -> &S {
        // SAFETY: the table is that of `S`, so `create` made an instance of it. No call of it runs.
        unsafe { crate::boundary::schema_of(self.instance) }
    }
}

/// Life cycle: the calls that the host makes.
impl<S> Bench<S> {
    /// Calls `awake`.
    ///
    /// # Errors
    /// If the schema fails or panics.
    pub fn awake(&mut self) -> Result<(), Failure> {
        let Some(awake) = self.table.awake else {
            return Ok(());
        };
        // SAFETY: the table's own function, instance and context.
        self.call(|instance, cx| unsafe { awake(instance, cx) })
    }

    /// Calls `check`. A schema without one is always ready.
    ///
    /// # Errors
    /// If the schema fails or panics.
    pub fn check(&mut self) -> Result<Precondition, Failure> {
        let Some(check) = self.table.check else {
            return Ok(true.into());
        };
        let mut answer = raw::Precondition {
            size: size_of::<raw::Precondition>() as u32,
            ready: 0,
            urgency: 0.0,
        };
        // SAFETY: the table's own function, instance and context, and room for the answer.
        let called = self.call(|instance, cx| unsafe { check(instance, cx, &raw mut answer) });
        let lacks_value = called.as_ref().is_err_and(Failure::lacks_value);
        if !lacks_value {
            called?;
        }
        Ok(Precondition {
            ready: answer.ready != 0 && !lacks_value,
            urgency: answer.urgency,
        })
    }

    /// Calls `iterate`, after it has cleared what [`Self::commanded`] returns.
    ///
    /// # Errors
    /// If the schema fails or panics, or says that an import has no value, which [`Failure::lacks_value`] tells: that is no
    /// fault (R19).
    pub fn iterate(&mut self) -> Result<(), Failure> {
        self.state.forget_commands();
        let Some(iterate) = self.table.iterate else {
            return Ok(());
        };
        // SAFETY: the table's own function, instance and context.
        self.call(|instance, cx| unsafe { iterate(instance, cx) })
    }

    /// Calls `sleep`.
    ///
    /// # Errors
    /// If the schema panics.
    pub fn sleep(&mut self) -> Result<(), Failure> {
        let Some(sleep) = self.table.sleep else {
            return Ok(());
        };
        self.call(|instance, cx| {
            // SAFETY: the table's own function, instance and context.
            unsafe { sleep(instance, cx) };
            raw::OK
        })
    }

    /// Calls `arbitrate` for a group. Its awake children are in the states that [`Self::set_child`] has set.
    ///
    /// # Errors
    /// If the schema fails or panics.
    ///
    /// # Panics
    /// If the schema has no arbitration, or if exactly one child is ready: the host would not arbitrate then.
    pub fn arbitrate(&mut self, group: &str) -> Result<Decision, Failure> {
        let Some(arbitrate) = self.table.arbitrate else {
            panic!(
                "`{}` has no arbitration; write `impl Arbitrate` for it",
                self.description.name
            )
        };
        let snapshot = self.state.snapshot(&self.description, group);
        let name = std::ffi::CString::new(group).unwrap_or_default();
        let level = raw::Level {
            size: size_of::<raw::Level>() as u32,
            case: match snapshot.case {
                Case::Collision => raw::COLLISION,
                Case::Absence => raw::ABSENCE,
            },
            group: name.as_ptr(),
            candidates: snapshot.candidates.as_ptr(),
            candidate_count: snapshot.candidates.len() as u32,
            winner: snapshot.winner,
        };
        let mut answer = raw::Verdict {
            size: size_of::<raw::Verdict>() as u32,
            child: -1,
            reason: [0; 128],
        };
        // SAFETY: the table's own function, instance and context, and tables that live until it returns.
        self.call(|instance, cx| unsafe { arbitrate(instance, cx, &raw const level, &raw mut answer) })?;
        answer.reason[127] = 0;
        // SAFETY: its last byte is a NUL.
        let reason = unsafe { CStr::from_ptr(answer.reason.as_ptr()) };
        Ok(Decision {
            child: usize::try_from(answer.child)
                .ok()
                .map(|child| self.description.children[child].name.clone()),
            reason: reason.to_string_lossy().into_owned(),
        })
    }
}

/// The inputs of the schema.
impl<S> Bench<S> {
    /// Publishes a value of an import, measured now. What is no measurement is no value, as in an application, and a
    /// warning in [`Self::log`] says why.
    pub fn import<T: Value>(&mut self, name: &str, value: &T) {
        let port = self.port::<T>(Kind::Import, name);
        self.state.put(port, value.as_bytes());
    }

    /// Retracts the newest value of an import, as its writer would.
    pub fn retract(&mut self, name: &str) {
        let port = names::port(&self.description, Kind::Import, name);
        self.state.ports[port].newest = None;
    }

    /// Writes a modulation, as its father would.
    ///
    /// # Panics
    /// If the value is not finite or is outside the modulation's limits. Every host refuses such a value.
    #[track_caller]
    pub fn set<T: Modulated>(&mut self, name: &str, value: T) {
        let port = self.port::<T::Wire>(Kind::Modulation, name);
        self.put_checked(name, port, wire(value).as_bytes());
    }

    #[track_caller]
    fn put_checked(&mut self, name: &str, port: usize, value: &[u8]) {
        if let Err(wrong) = self.state.check_value(port, value) {
            panic!("`{name}` {wrong}");
        }
        self.state.put(port, value);
    }

    /// Commands a driver. The command is in force until its validity ends.
    ///
    /// # Panics
    /// If the value is not finite. Every host refuses such a value.
    #[track_caller]
    pub fn command<T: Value>(&mut self, name: &str, value: &T) {
        let port = self.port::<T>(Kind::Command, name);
        self.put_checked(name, port, value.as_bytes());
    }

    /// Leaves an optional import, actuator or child unbound, as an application may.
    ///
    /// # Panics
    /// If it is not optional.
    pub fn unbind(&mut self, name: &str) {
        let named =
            |port: &&describe::Port| port.name == name && !matches!(port.role, describe::Role::Export { .. });
        let port = self.description.ports.iter().position(|port| named(&port));
        let optional = if let Some(port) = port {
            self.state.unbind(port);
            self.description.ports[port].has(raw::OPTIONAL)
        } else {
            let child = self.child(name);
            self.state.unbind_child(child);
            self.description.children[child].optional
        };
        assert!(
            optional,
            "`{name}` is not optional, so every application binds it"
        );
    }

    /// Sets the clock, as a time since the application's start.
    pub fn set_now(&mut self, now: Duration) {
        self.state.now = now;
    }

    /// Sets whether the application runs in real time, as it does on a new bench, or in lockstep.
    pub fn set_real_time(&mut self, real_time: bool) {
        self.state.real_time = real_time;
    }

    /// Gives the schema authority over actuators and children, or withdraws it (R7).
    pub fn set_authority(&mut self, authority: bool) {
        self.state.authority = authority;
    }

    /// Names the children of a role that any number of children may have, each with its group, as an
    /// application does. All children are then asleep. Without this call there is one child, with the name of
    /// the role.
    pub fn name_children(&mut self, named: &[(&str, &str)]) {
        self.description = self.description.with_children(named.iter().copied());
        self.state.children = state::BenchState::sleeping_children(&self.description);
    }

    /// Sets the state of a child. Its precondition then holds if the state is READY or WINNER.
    pub fn set_child(&mut self, role: &str, state: State) {
        let child = self.child(role);
        self.state.set_child(child, state);
    }

    /// Sets the precondition that a child returned at its last check, in any state.
    pub fn set_precondition(&mut self, role: &str, precondition: impl Into<Precondition>) {
        let child = self.child(role);
        self.state.children[child].precondition = precondition.into();
    }

    /// Sets whether a child is Faulted.
    pub fn set_faulted(&mut self, role: &str, faulted: bool) {
        let child = self.child(role);
        self.state.children[child].faulted = faulted;
    }
}

/// The outputs of the schema.
impl<S> Bench<S> {
    /// Returns the last command since the last `iterate` began. `None` if there was none, or if it was
    /// refused.
    #[must_use]
    pub fn commanded<T: Value>(&self, name: &str) -> Option<T> {
        self.state.written(self.port::<T>(Kind::Actuator, name))
    }

    /// Returns the newest value of an export. `None` if there is none, or if it was retracted.
    #[must_use]
    pub fn exported<T: Value>(&self, name: &str) -> Option<T> {
        self.state.written(self.port::<T>(Kind::Export, name))
    }

    /// Returns the newest value of an export in place, for values too large to copy, such as an image. `None`
    /// if there is none, or if it was retracted.
    #[must_use]
    pub fn exported_in_place<T: Value>(&self, name: &str) -> Option<&T> {
        self.state.written_in_place(self.port::<T>(Kind::Export, name))
    }

    /// Returns the time of measurement of the newest value of an export.
    #[must_use]
    pub fn exported_at(&self, name: &str) -> Option<Duration> {
        let port = names::port(&self.description, Kind::Export, name);
        self.state.written_at(port)
    }

    /// Returns the newest value written to a modulation of a child.
    #[must_use]
    pub fn modulated<T: Modulated>(&self, child: &str, name: &str) -> Option<T> {
        let port = self.port::<T::Wire>(Kind::ChildModulation(self.child(child)), name);
        T::of(&self.state.written(port)?)
    }

    /// Returns the children that are awake, in the order of their roles.
    #[must_use]
    pub fn awake_children(&self) -> Vec<&str> {
        let children = self.description.children.iter().zip(&self.state.children);
        children
            .filter(|(_, child)| child.state != State::Slept)
            .map(|(role, _)| &*role.name)
            .collect()
    }

    /// Returns the policy that the schema set through this child, if it did.
    #[must_use]
    pub fn policy(&self, child: &str) -> Option<Policy> {
        self.state.children[self.child(child)].policy
    }

    /// Returns the log messages since the creation of the bench.
    #[must_use]
    pub fn log(&self) -> &[(Severity, String)] {
        &self.state.log
    }

    /// Returns the description of the schema.
    #[must_use]
    pub fn description(&self) -> &describe::Schema {
        &self.description
    }
}

impl<S> Bench<S> {
    /// # Safety
    /// The table, all it points to, and its functions follow the rules of `raw`.
    unsafe fn of(own: &'static raw::Schema, entries: &[Entry]) -> Result<Self, Failure> {
        let plugin = raw::Plugin {
            magic: raw::MAGIC,
            abi_major: raw::ABI_MAJOR,
            abi_minor: raw::ABI_MINOR,
            size: size_of::<raw::Plugin>() as u32,
            flags: 0,
            name: c"bench".as_ptr(),
            version: ptr::null(),
            doc: ptr::null(),
            schemas: own,
            schema_count: 1,
            reserved: 0,
        };
        // SAFETY: the table of a plugin that contains only the caller's.
        let about = match unsafe { read::plugin(&raw const plugin) } {
            Ok(plugin) => plugin.schemas.into_iter().next(),
            Err(refusal) => panic!("{refusal}"),
        };
        // SAFETY: the caller's table.
        let table = unsafe { table::read(own) }.expect("the table was validated above");
        let (Some(about), Some(create)) = (about, table.create) else {
            panic!("a table without `create`")
        };
        let own_ports = about.ports.len();
        let (ports, listed): (Vec<_>, Vec<_>) = entries.iter().map(|entry| entry.port(&about)).unzip();
        let about = about.with_ports(ports);
        let mut bench = Self {
            table,
            state: Box::new(BenchState::new(&about)),
            description: about,
            instance: ptr::null_mut(),
            schema: PhantomData,
            own_ports,
        };
        let cx = ptr::from_mut(&mut *bench.state).cast();
        // SAFETY: the table's own function, our host and context.
        bench.instance = unsafe { create(own, &raw const host::HOST, cx) };
        if bench.instance.is_null() {
            return Err(Failure {
                code: raw::FAILED,
                reason: bench.state.reason.take().unwrap_or_default(),
            });
        }
        bench.set_lists(&listed)?;
        Ok(bench)
    }

    fn call(&mut self, function: impl FnOnce(*mut c_void, *mut raw::Context) -> i32) -> Result<(), Failure> {
        self.state.reason = None;
        let code = function(self.instance, ptr::from_mut(&mut *self.state).cast());
        self.state.drop_loans();
        let reason = self.state.reason.take();
        if code == raw::OK && reason.is_none() {
            return Ok(());
        }
        Err(Failure {
            code,
            reason: reason.unwrap_or_default(),
        })
    }

    fn port<T: Value>(&self, kind: Kind, name: &str) -> usize {
        let index = names::port(&self.description, kind, name);
        let (requested, actual) = (T::describe(), &self.description.ports[index].value_type);
        assert!(
            requested.same_as(actual),
            "`{name}` is a {}, not a {}",
            actual.name,
            requested.name
        );
        index
    }

    fn child(&self, role: &str) -> usize {
        names::child(&self.description, role)
    }
}

impl<S: Schema> Default for Bench<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S> Drop for Bench<S> {
    fn drop(&mut self) {
        if let (Some(destroy), false) = (self.table.destroy, self.instance.is_null()) {
            // SAFETY: what `create` returned, passed back once, after every other call.
            unsafe { destroy(self.instance) };
        }
    }
}
