//! Exports that operators let fail, and their repair (R14). A schema that publishes such an export does not
//! notice.

use std::sync::Arc;

use jde_abi::describe::Role;
use jde_app::InstancePort;
use jde_board::Variable;
use jde_core::{Nanos, SchemaId};
use jde_records::event::OperatorAction;
use jde_records::turn::{Moment, Operation, Turn, TurnKind};

use super::Operators;
use super::holds::Actor;
use crate::engine::services::seed_of;
use crate::sensor_fault::SensorFault;

impl Operators {
    /// Lets an export fail until it is repaired or its schema is released.
    pub(crate) fn fail_export(
        &self,
        by: &Actor,
        instance: SchemaId,
        export: &str,
        fault: SensorFault,
    ) -> Result<(), String> {
        let (port, variable) = self.export(instance, export)?;
        let value_type = &variable.describe().value_type;
        let name = self.name(instance);
        fault
            .check(value_type)
            .map_err(|reason| format!("`{name}.{export}` cannot fail so: {reason}"))?;
        let mut held = self.holds();
        let failures = held.failing.entry(InstancePort::new(instance, port)).or_default();
        failures.retain(|(actor, _)| actor != by);
        failures.push((by.clone(), fault));
        drop(held);
        self.begin_fault(instance, port, fault);
        self.rules.report_operation(
            &by.name,
            OperatorAction::Fail {
                schema: instance,
                export: export.to_owned(),
                fault: fault.to_string(),
            },
        );
        Ok(())
    }

    /// Ends the failure of an export, whoever caused it.
    pub(crate) fn repair_export(&self, by: &Actor, instance: SchemaId, export: &str) -> Result<(), String> {
        let (port, _) = self.export(instance, export)?;
        if self
            .holds()
            .failing
            .remove(&InstancePort::new(instance, port))
            .is_none()
        {
            return Err(format!("`{}.{export}` does not fail", self.name(instance)));
        }
        self.end_fault(instance, port);
        let (schema, export) = (instance, export.to_owned());
        self.rules
            .report_operation(&by.name, OperatorAction::Repair { schema, export });
        Ok(())
    }

    /// Ends what the actors selected by `whose` let fail of an instance. Of several failures of an export, the newest
    /// that is left is in force again. Returns whether there were any.
    pub(super) fn repair_exports(&self, instance: SchemaId, whose: impl Fn(&Actor) -> bool) -> bool {
        let mut changed = Vec::new();
        let mut held = self.holds();
        let port = |port| InstancePort::new(instance, port);
        for (export, failures) in held.failing.range_mut(port(0)..=port(usize::MAX)) {
            let is_newest = failures.last().is_some_and(|(actor, _)| whose(actor));
            failures.retain(|(actor, _)| !whose(actor));
            if is_newest {
                changed.push((export.port, failures.last().map(|(_, fault)| *fault)));
            }
        }
        held.failing.retain(|_, failures| !failures.is_empty());
        drop(held);
        for (port, fault) in &changed {
            match fault {
                Some(fault) => self.begin_fault(instance, *port, *fault),
                None => self.end_fault(instance, *port),
            }
        }
        !changed.is_empty()
    }

    /// Repeats a failure or a repair, in a replay. Values of drivers come from the recording, and have failed
    /// already.
    pub(crate) fn repeat_export(
        &self,
        instance: SchemaId,
        port: usize,
        fault: Option<SensorFault>,
        time: Nanos,
    ) {
        match fault {
            Some(fault) => self.set_fault(instance, port, fault, time),
            None => self.variables.faults(instance).repair(port),
        }
    }

    fn set_fault(&self, instance: SchemaId, port: usize, fault: SensorFault, time: Nanos) {
        let Some(variable) = self.variables.of(InstancePort::new(instance, port)) else {
            return;
        };
        let seed = seed_of(&self.application, instance) ^ time.rotate_left(32) ^ port as u64;
        self.variables.faults(instance).fail(port, variable, fault, seed);
        if fault == SensorFault::Silent {
            variable.retract();
        }
    }

    fn begin_fault(&self, instance: SchemaId, port: usize, fault: SensorFault) {
        let failed = Operation::FailedExport { port: port as u64 };
        let time = self.record_export(instance, failed, &fault.words());
        self.set_fault(instance, port, fault, time);
    }

    fn end_fault(&self, instance: SchemaId, port: usize) {
        self.record_export(instance, Operation::RepairedExport { port: port as u64 }, &[]);
        self.variables.faults(instance).repair(port);
    }

    /// Records a failure or a repair as a turn, before it takes effect. Returns its time.
    fn record_export(&self, instance: SchemaId, operation: Operation, words: &[u32]) -> Nanos {
        let time = self.clock.now();
        if let Some(journal) = &self.journal {
            let order = journal.next();
            let mut turn = Turn::new(TurnKind::Operated(operation), instance);
            turn.checked = Moment { order, time };
            turn.inputs.resize(words.len()).copy_from_slice(words);
            journal.forward(&turn);
        }
        time
    }

    fn export(&self, instance: SchemaId, name: &str) -> Result<(usize, &Arc<Variable>), String> {
        self.check_schema(instance)?;
        let ports = &self.application.instances[instance].schema.ports;
        let exports = || {
            ports
                .iter()
                .filter(|port| matches!(port.role, Role::Export { .. }))
        };
        let port = ports
            .iter()
            .position(|port| port.name == name && matches!(port.role, Role::Export { .. }));
        port.and_then(|port| Some((port, self.variables.of(InstancePort::new(instance, port))?)))
            .ok_or_else(|| {
                let known: Vec<_> = exports().map(|port| port.name.as_str()).collect();
                format!(
                    "`{}` has no export `{name}`; it has {}",
                    self.name(instance),
                    known.join(", ")
                )
            })
    }
}
