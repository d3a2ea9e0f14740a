//! What operators can do to a running application (R14), each under a name. Leases are the business of whoever serves them.

use std::sync::Arc;

use jde_board::value::Value;
use jde_core::{Nanos, Operator, SchemaId};

use crate::engine::Engine;
use crate::plugin::Loaded;
use crate::reload::{How, Reload};

/// Longest name of an operator, in characters.
const LONGEST_NAME: usize = 64;

/// An operator of a running application: acts as a father would. What it does is told and shown with its name, and stands until
/// it is undone. Usable from any thread; dropping it undoes nothing.
#[derive(Clone)]
pub struct Operating {
    engine: Arc<Engine>,
    by: String,
}

impl Operating {
    pub(crate) fn new(engine: &Arc<Engine>, by: &str) -> Self {
        Self {
            engine: Arc::clone(engine),
            by: shown(by),
        }
    }

    /// Wakes a schema as its father would.
    ///
    /// # Errors
    /// Why it was refused, in words; so for the others below.
    pub fn play(&self, schema: usize) -> Result<(), String> {
        self.hierarchy(schema, Operator::Play)
    }

    /// Puts a schema to sleep until it is released.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn hold_asleep(&self, schema: usize) -> Result<(), String> {
        self.hierarchy(schema, Operator::Stop)
    }

    /// Ends the instance of a schema, which holds it asleep: its memory goes, its device is let go of, and what it exported is
    /// taken back; its modulations and its period stay. It ends between two iterations, soon after this has returned.
    ///
    /// # Errors
    /// When it is a perceptive schema or a driver that somebody awake needs.
    pub fn unload(&self, schema: usize) -> Result<(), String> {
        self.engine.unload(&self.by, schema)
    }

    /// Lets go of a schema that was unloaded, and has one that faulted try again, with all restarts that its policy grants: it gets a
    /// fresh instance when it wakes up, at once if anybody wants it awake.
    ///
    /// # Errors
    /// When it is neither unloaded nor faulted, or has not come to rest since.
    pub fn load(&self, schema: usize) -> Result<(), String> {
        self.engine.load(&self.by, schema)
    }

    /// Has another build of a schema's type take over, between two of its iterations: it keeps its state in the hierarchy, its
    /// authority and its variables, and what it remembers if both builds hand that on. What goes wrong leaves the build before.
    ///
    /// # Errors
    /// Everything that keeps the build from its place; nothing was touched then.
    pub fn replace(&self, schema: usize, with: &Loaded, how: How) -> Result<Reload, Vec<String>> {
        self.engine.replace(&self.by, schema, with, how)
    }

    /// Whether a build could take over as [`Self::replace`] has it; answers with what of it would not be in force.
    ///
    /// # Errors
    /// Everything that keeps it from that.
    pub fn fits(&self, schema: usize, build: &Loaded) -> Result<Vec<String>, Vec<String>> {
        self.engine.fitting(schema, build).map(|(_, notes)| notes)
    }

    /// Whether a schema runs exactly this build.
    pub(crate) fn runs(&self, schema: usize, build: &Loaded) -> bool {
        self.engine.runs(schema, build)
    }

    /// Whether a schema faulted and was not restarted since.
    pub(crate) fn is_faulted(&self, schema: usize) -> bool {
        self.engine.is_faulted(schema)
    }

    /// Makes a schema the winner of its group while it is awake.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn force(&self, schema: usize) -> Result<(), String> {
        self.hierarchy(schema, Operator::Force)
    }

    /// Undoes what operators did to a schema, whoever they are.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn release(&self, schema: usize) -> Result<(), String> {
        self.hierarchy(schema, Operator::Release)
    }

    /// Stops everything at once: every root sleeps, and with it all that acts, and every command is neutral. Whoever is inside an
    /// iteration commands nothing more in it, whatever is released meanwhile. It stands until [`Self::release_all`], or until
    /// somebody plays or releases the roots one by one.
    ///
    /// # Errors
    /// The application has not started, or is over.
    pub fn stop_all(&self) -> Result<(), String> {
        self.engine.stop_all(&self.by)
    }

    /// Lets everything go on that was stopped at once, whoever did that. What operators stopped or unloaded by itself, or did otherwise,
    /// stays.
    ///
    /// # Errors
    /// The application has not started, or is over.
    pub fn release_all(&self) -> Result<(), String> {
        self.engine.release_all(&self.by)
    }

    /// Undoes what this operator did to a schema and no other has done anew since: the end of a lease. What others hold stays.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn let_go(&self, schema: usize) -> Result<(), String> {
        self.engine.let_go(&self.by, schema)
    }

    /// Changes the period of a schema, ns.
    ///
    /// # Errors
    /// When it is too short.
    pub fn set_period(&self, schema: usize, period: Nanos) -> Result<(), String> {
        self.engine.retime(&self.by, schema, period)
    }

    /// Writes a modulation of a schema by name.
    ///
    /// # Errors
    /// When there is none of that name, or the value does not fit.
    pub fn modulate(&self, schema: usize, name: &str, value: &Value) -> Result<(), String> {
        self.engine.modulate(&self.by, schema, name, value)
    }

    fn hierarchy(&self, schema: usize, act: impl FnOnce(SchemaId) -> Operator) -> Result<(), String> {
        self.engine.known(schema)?;
        self.engine.operate(&self.by, act(SchemaId(schema as u32)))
    }
}

/// A name as terminals and recordings can bear it, wherever it came from.
pub(crate) fn shown(by: &str) -> String {
    let printable = |c: char| if c.is_control() { '?' } else { c };
    let name: String = by.trim().chars().take(LONGEST_NAME).map(printable).collect();
    if name.is_empty() {
        String::from("somebody")
    } else {
        name
    }
}

#[cfg(test)]
mod tests {
    use super::shown;

    #[test]
    fn r14_an_operator_has_a_name_that_a_terminal_can_bear() {
        assert_eq!(shown(" ana@laptop "), "ana@laptop");
        assert_eq!(shown("\u{1b}[2Jana\n"), "?[2Jana");
        assert_eq!(shown(""), "somebody");
        assert_eq!(shown(&"a".repeat(1000)).len(), 64);
    }
}
