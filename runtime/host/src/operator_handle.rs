//! The actions of an operator on a running application (R14), each under the operator's name. It keeps no
//! leases.

use std::sync::Arc;

use jde_board::value::Value;
use jde_core::{Nanos, Operator, SchemaId};
use jde_loader::LoadedPlugin;
use jde_records::event::Loss;

use crate::engine::{Actor, Engine};
use crate::reload::{PendingReload, ReloadOptions};
use crate::sensor_fault::SensorFault;

/// The longest name of an operator, in characters.
const MAX_NAME_LENGTH: usize = 64;

/// An operator of a running application, who acts as a father would. Each action is reported and shown under
/// the operator's name, and stays in force until it is undone. Usable from any thread; dropping it undoes
/// nothing.
#[derive(Clone)]
pub struct OperatorHandle {
    pub(crate) engine: Arc<Engine>,
    pub(crate) by: Actor,
}

impl OperatorHandle {
    pub(crate) fn new(engine: &Arc<Engine>, by: &str) -> Self {
        Self {
            engine: Arc::clone(engine),
            by: Actor::lasting(&printable_name(by)),
        }
    }

    /// Returns the operator's name, as it is reported.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.by.name
    }

    /// Returns a handle for what the same operator does under a lease. What it holds of a schema is ended by its
    /// [`Self::release_own`] alone, and it ends no stop of others.
    #[must_use]
    pub fn under_lease(&self) -> Self {
        let mut leased = self.clone();
        leased.by.leased = true;
        leased
    }

    /// Wakes a schema as its father would.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn play(&self, schema: SchemaId) -> Result<(), String> {
        self.operate(schema, Operator::Play).map(drop)
    }

    /// Puts a schema to sleep until it is released. Schemas that read from it lose what it exported.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn hold_asleep(&self, schema: SchemaId) -> Result<(), String> {
        self.operate(schema, Operator::Stop).map(drop)
    }

    /// [`Self::hold_asleep`], or [`Self::unload`]. Returns in words what awake schemas lose by it, such as "goon loses
    /// its laser"; empty if nothing.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn stop(&self, schema: SchemaId, unload: bool) -> Result<String, String> {
        let operators = &self.engine.operators;
        let losses = if unload {
            operators.unload(&self.by, schema)?
        } else {
            self.operate(schema, Operator::Stop)?
        };
        Ok(operators.words(&losses))
    }

    /// Ends the instance of a schema and keeps the schema asleep. Its memory is lost, its device is released,
    /// and its exported values are retracted; its modulations and its period stay. The instance ends between
    /// two iterations, soon after this function has returned.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn unload(&self, schema: SchemaId) -> Result<(), String> {
        self.engine.operators.unload(&self.by, schema).map(drop)
    }

    /// Releases a schema that was unloaded, or permits one that faulted to start again, with all restarts
    /// that its restart policy grants. It gets a fresh instance when it wakes: at once if another component
    /// requires it awake.
    ///
    /// # Errors
    /// It is neither unloaded nor faulted, or has not come to rest since.
    pub fn load(&self, schema: SchemaId) -> Result<(), String> {
        self.engine.operators.load(&self.by, schema)
    }

    /// Replaces the build of a schema by another of its type, between two iterations. The schema keeps its
    /// state in the hierarchy, its authority and its variables; it keeps its memory if both builds support
    /// that. If the takeover fails, the previous build stays.
    ///
    /// # Errors
    /// Every reason why the build cannot take over; the schema is then unchanged.
    pub fn replace(
        &self,
        schema: SchemaId,
        build: &LoadedPlugin,
        options: ReloadOptions,
    ) -> Result<PendingReload, Vec<String>> {
        self.engine.replace(&self.by.name, schema, build, options)
    }

    /// Checks whether a build could take over by [`Self::replace`]. Returns the parts of it that would not be
    /// in force.
    ///
    /// # Errors
    /// Every reason why it cannot take over.
    pub fn check_build(&self, schema: SchemaId, build: &LoadedPlugin) -> Result<Vec<String>, Vec<String>> {
        self.engine.check_build(schema, build).map(|(_, notes)| notes)
    }

    /// Whether a schema runs exactly this build.
    pub(crate) fn is_running_build(&self, schema: SchemaId, build: &LoadedPlugin) -> bool {
        self.engine.is_running_build(schema, build)
    }

    /// Whether a schema has faulted and has not been restarted since.
    pub(crate) fn is_faulted(&self, schema: SchemaId) -> bool {
        self.engine.rules.is_faulted(schema)
    }

    /// Makes a schema the winner of its group while it is awake.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn force(&self, schema: SchemaId) -> Result<(), String> {
        self.operate(schema, Operator::Force).map(drop)
    }

    /// Ends what anybody holds a schema to.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn release(&self, schema: SchemaId) -> Result<(), String> {
        self.operate(schema, Operator::Release).map(drop)
    }

    /// Stops all schemas at once: every root sleeps with everything below it, and every command is neutral. A
    /// schema inside an iteration can send no more commands in it, even if it is released meanwhile. The stop
    /// lasts until [`Self::release_all`], or until operators have played or released the roots one by one. Before
    /// the start, it keeps the roots from waking at the start.
    ///
    /// # Errors
    /// The application has ended.
    pub fn stop_all(&self) -> Result<(), String> {
        self.engine.operators.stop_all(&self.by)
    }

    /// Undoes [`Self::stop_all`], whoever called it. Other actions on single schemas, such as a stop or an
    /// unload, stay in force.
    ///
    /// # Errors
    /// The application has not started, or has ended.
    pub fn release_all(&self) -> Result<(), String> {
        self.engine.operators.release_all(&self.by)
    }

    /// Ends what this operator holds of a schema: under the lease, for a handle [under one](Self::under_lease); else
    /// all of it. What others hold stays in force, and so does a stop of everything.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn release_own(&self, schema: SchemaId) -> Result<(), String> {
        self.engine.operators.release_own(&self.by, schema)
    }

    /// Changes the period of a schema, ns.
    ///
    /// # Errors
    /// The period is out of [range](jde_app::period::RANGE).
    pub fn set_period(&self, schema: SchemaId, period: Nanos) -> Result<(), String> {
        self.engine.operators.retime(&self.by, schema, period)
    }

    /// Writes a modulation of a schema by name.
    ///
    /// # Errors
    /// There is no modulation of that name, or the value does not fit.
    pub fn modulate(&self, schema: SchemaId, name: &str, value: &Value) -> Result<(), String> {
        self.engine.operators.modulate(&self.by, schema, name, value)
    }

    /// Lets an export of a schema fail: from now on readers and recordings receive what `fault` leaves of it. The
    /// schema itself does not notice. It fails until it is repaired, or until the schema is released.
    ///
    /// # Errors
    /// There is no export of that name, or it cannot fail so.
    pub fn fail_export(&self, schema: SchemaId, export: &str, fault: SensorFault) -> Result<(), String> {
        self.engine.operators.fail_export(&self.by, schema, export, fault)
    }

    /// Undoes [`Self::fail_export`], whoever called it. The next publication is the schema's own again.
    ///
    /// # Errors
    /// There is no export of that name, or it does not fail.
    pub fn repair_export(&self, schema: SchemaId, export: &str) -> Result<(), String> {
        self.engine.operators.repair_export(&self.by, schema, export)
    }

    fn operate(&self, schema: SchemaId, act: impl FnOnce(SchemaId) -> Operator) -> Result<Vec<Loss>, String> {
        self.engine.operators.check_schema(schema)?;
        self.engine.operators.operate(&self.by, act(schema))
    }
}

/// Returns a name that is safe to show on terminals and in recordings: trimmed, of limited length, without
/// control characters.
pub(crate) fn printable_name(by: &str) -> String {
    let printable = |c: char| if c.is_control() { '?' } else { c };
    let name: String = by.trim().chars().take(MAX_NAME_LENGTH).map(printable).collect();
    if name.is_empty() {
        String::from("somebody")
    } else {
        name
    }
}

#[cfg(test)]
mod tests {
    use super::printable_name;

    #[test]
    fn r14_the_name_of_an_operator_is_printable() {
        assert_eq!(printable_name(" ana@laptop "), "ana@laptop");
        assert_eq!(printable_name("\u{1b}[2Jana\n"), "?[2Jana");
        assert_eq!(printable_name(""), "somebody");
        assert_eq!(printable_name(&"a".repeat(1000)).len(), 64);
    }
}
