//! What awake schemas lose when an operator stops or unloads what they read from: said, and not refused.
//!
//! It ends no value itself.

use jde_app::{Binding, ImportSource};
use jde_core::{Hierarchy, SchemaId, Transaction};
use jde_records::event::Loss;

use super::Operators;

impl Operators {
    /// Changes the hierarchy, and returns what awake schemas lost by it if it stopped the instance.
    pub(super) fn with_losses<R>(
        &self,
        transaction: &mut Transaction,
        instance: SchemaId,
        change: impl FnOnce(&mut Transaction) -> R,
    ) -> (R, Vec<Loss>) {
        let was_awake = transaction.is_awake(instance);
        let result = change(transaction);
        let is_lost = was_awake && transaction.is_stopped(instance);
        let losses = if is_lost {
            self.losses(transaction, instance)
        } else {
            Vec::new()
        };
        (result, losses)
    }

    /// Returns the imports from an instance of all schemas that are awake and not below it.
    pub(crate) fn losses(&self, hierarchy: &Hierarchy, instance: SchemaId) -> Vec<Loss> {
        let below = hierarchy.subtree(instance);
        let instances = self.application.instances.entries();
        let readers = instances.filter(|(reader, _)| {
            *reader != instance && hierarchy.is_awake(*reader) && !below.contains(reader)
        });
        let imports = readers.flat_map(|(reader, config)| {
            let bound = config.schema.ports.iter().zip(&config.bindings);
            let from_instance = bound.filter(|(_, binding)| match binding {
                Binding::Import {
                    source: Some(ImportSource::Local(provider)),
                    ..
                } => provider.instance == instance,
                Binding::Import { .. }
                | Binding::Export
                | Binding::Modulation { .. }
                | Binding::Command
                | Binding::Actuator { .. }
                | Binding::ChildModulation { .. } => false,
            });
            from_instance.map(move |(port, _)| Loss {
                reader,
                import: port.name.clone(),
            })
        });
        imports.collect()
    }

    /// Returns losses in words: "goon loses its laser".
    pub(crate) fn words(&self, losses: &[Loss]) -> String {
        let words = losses
            .iter()
            .map(|loss| format!("{} loses its {}", self.name(loss.reader), loss.import));
        words.collect::<Vec<_>>().join(", ")
    }
}
