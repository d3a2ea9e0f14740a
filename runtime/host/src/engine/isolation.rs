//! Schemas in processes of their own, as the rules see them: whether an instance runs in one, and what
//! follows from its death.

use jde_core::SchemaId;
use jde_isolation::{ProcessConfig, python};
use jde_records::turn::TurnKind;

use super::{Engine, Signal};

impl Engine {
    /// Gives up an instance whose process died or whose call hangs. The level selects again, and the next
    /// awakening creates a new instance of the build in force.
    pub(crate) fn report_death(&self, instance: SchemaId, reason: String) {
        let signals = &self.rules.signals;
        let mut posted = false;
        let moment = self.report_fault_with(instance, reason.clone(), || {
            posted = signals.post(instance, Signal::Replaced);
        });
        if posted {
            signals.notify(instance);
        }
        self.rules.record_turn(TurnKind::GivenUp, instance, moment);
        self.roll_back_build(instance, &reason);
    }

    /// Reports that a debugger holds a call of an instance, or lets it go on: whoever reads from it loses what it
    /// exported, as when an operator stops it.
    pub(crate) fn report_debugged(&self, instance: SchemaId, debugged: bool) {
        if debugged {
            let losses = self
                .rules
                .read(|rules| self.operators.losses(&rules.hierarchy, instance));
            let words = self.operators.words(&losses);
            tracing::warn!(schema = self.name(instance), "a debugger holds it: {words}");
            self.variables.retract_exports(instance);
        }
        self.rules.set_debugged(instance, debugged);
    }

    /// The program and the limits that run an instance in a process of its own; `None` if it runs in this
    /// process.
    pub(crate) fn process_config(&self, instance: SchemaId) -> Option<ProcessConfig> {
        let config = &self.application.instances[instance];
        let limits = config.isolate;
        let program = self.processes.program();
        if self.application.plugins[config.plugin].isolated {
            return Some(ProcessConfig {
                program: python::program(program.map(|program| &*program.path), config.debugged),
                limits: limits.unwrap_or_default(),
                debugged: config.debugged,
                is_python: true,
            });
        }
        Some(ProcessConfig {
            program: program?.clone(),
            limits: limits?,
            debugged: false,
            is_python: false,
        })
    }

    /// Logs each limit that could not be set on a process.
    pub(crate) fn warn_unset_limits(&self, instance: SchemaId, what: &[String]) {
        for what in what {
            tracing::warn!(schema = self.name(instance), "{what}");
        }
    }
}
