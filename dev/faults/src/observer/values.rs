//! Checks that a faulted schema's exports are retracted until it is restarted.

use jde_abi::describe::Role;
use jde_core::Nanos;
use jde_host::Handle;

use super::{ObserverState, Tamper};

impl ObserverState {
    /// Judges the exports of schemas that faulted and were not restarted.
    pub(super) fn judge_values(&mut self, handle: &Handle, now: Nanos) {
        let application = handle.application();
        let mut violations = Vec::new();
        for (id, instance) in application.instances.entries() {
            if !self.faulted.contains(&id) {
                continue;
            }
            let ports = instance.schema.ports.iter();
            for port in ports.filter(|port| matches!(port.role, Role::Export { .. })) {
                let name = format!("{}.{}", instance.name, port.name);
                let variable = handle.board().find(&name);
                let has_value = variable.is_some_and(|variable| variable.has_value(now))
                    || self.take_tamper(Tamper::Value);
                if has_value {
                    violations.push(format!(
                        "values: `{name}` still has a value although `{}` has faulted, at {:.6} s",
                        instance.name,
                        now as f64 / 1e9
                    ));
                }
            }
            if !violations.is_empty() {
                // One report for each fault.
                self.faulted.remove(&id);
                break;
            }
        }
        violations
            .into_iter()
            .for_each(|violation| self.report(violation));
    }
}
