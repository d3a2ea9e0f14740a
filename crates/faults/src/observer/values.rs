//! Checks that a faulted schema's exports are retracted until it is restarted.

use jde_abi::describe::Role;
use jde_core::Nanos;
use jde_host::Handle;

use super::{ObserverState, Tamper};

impl ObserverState {
    /// Judges the exports of schemas that faulted and were not restarted.
    pub(super) fn judge_values(&mut self, handle: &Handle, now: Nanos) {
        let application = handle.application();
        let mut broken = Vec::new();
        for (place, instance) in application.instances.iter().enumerate() {
            if !self.faulted.contains(&place) {
                continue;
            }
            let ports = instance.schema.ports.iter();
            for port in ports.filter(|port| matches!(port.role, Role::Export)) {
                let name = format!("{}.{}", instance.name, port.name);
                let variable = handle.board().find(&name);
                let stands = variable.is_some_and(|variable| {
                    let status = variable.status(now);
                    status.sequence > 0 && !status.retracted
                }) || self.take_tamper(Tamper::Value);
                if stands {
                    broken.push(format!(
                        "values: `{name}` still stands although `{}` has faulted, at {:.6} s",
                        instance.name,
                        now as f64 / 1e9
                    ));
                }
            }
            if !broken.is_empty() {
                // Once for each fault.
                self.faulted.remove(&place);
                break;
            }
        }
        broken.into_iter().for_each(|broken| self.report(broken));
    }
}
