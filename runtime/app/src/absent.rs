//! Imports of what is never written: a type has found before the start that one of its exports never has a value.

use jde_abi::describe::Port;

use super::{AbsentExport, Application, Binding, ImportSource};

impl Application {
    /// Returns a warning for each import of an export that never has a value, with its line.
    pub fn absent_imports(&self) -> impl Iterator<Item = String> {
        self.instances.iter().flat_map(move |instance| {
            let bindings = instance.schema.ports.iter().zip(&instance.bindings);
            bindings.filter_map(move |(port, binding)| {
                let (source, absent) = self.absent_source(binding)?;
                let Port { name, .. } = port;
                Some(format!(
                    "line {}: `{name}` of schema `{}` never has a value: `{source}` is never written, because {}",
                    instance.line, instance.name, absent.words,
                ))
            })
        })
    }

    /// Returns the name of the export that an import reads, and why it has no value, if it never has one.
    fn absent_source(&self, binding: &Binding) -> Option<(String, &AbsentExport)> {
        let Binding::Import {
            source: Some(ImportSource::Local(provider)),
            ..
        } = binding
        else {
            return None;
        };
        let mut absent = self.instances[provider.instance].absent.iter();
        let found = absent.find(|absent| absent.port == provider.port)?;
        Some((self.variable_name(*provider), found))
    }
}
