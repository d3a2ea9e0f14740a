//! The inspection of a schema's modulations, on the bench.

#![allow(unsafe_code)]

use jde_abi::describe::Role;
use jde_abi::{inspect, raw};

use super::{Bench, Failure};

/// A problem that an inspection reported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The name of the modulation, or of the port of a list.
    pub modulation: String,
    /// Whether the schema would start nevertheless, and wait for what is missing.
    pub unavailable: bool,
    /// What is wrong and what to do.
    pub words: String,
}

impl<S> Bench<S> {
    /// Inspects what the modulations name, as `jde check` does. Exports that are absent are no problems.
    ///
    /// # Errors
    /// If the schema fails or panics, tries to write, or reports a problem of something that is not a
    /// modulation.
    ///
    /// # Panics
    /// If the schema has no inspection.
    pub fn inspect(&mut self) -> Result<Vec<Problem>, Failure> {
        // SAFETY: the bench has read and validated this table.
        let table = unsafe { inspect::of(&self.table) }.unwrap_or_default();
        let Some(inspect) = table.and_then(|table| table.inspect) else {
            panic!(
                "`{}` has no inspection; write `impl Inspect` for it",
                self.description.name
            )
        };
        self.state.drawing = Some(Vec::new());
        // SAFETY: the table's own function, instance and context, and a list that lives until it returns.
        let (done, found) =
            inspect::lend(|problems| self.call(|instance, cx| unsafe { inspect(instance, cx, problems) }));
        self.refuse_writes("inspect")?;
        done?;
        let failure = |reason| Failure {
            code: raw::BAD_ARGUMENT,
            reason,
        };
        let with_name = |problem: inspect::Problem| {
            let port = self.description.modulation(problem.port);
            let listed = self.description.ports.get(problem.port as usize);
            let port = port.or_else(|| listed.filter(|_| problem.port as usize >= self.own_ports));
            let port = port.ok_or_else(|| failure(format!("it has no modulation {}", problem.port)))?;
            Ok(Problem {
                modulation: port.name.clone(),
                unavailable: problem.unavailable,
                words: problem.words,
            })
        };
        let is_absent = |problem: &inspect::Problem| {
            let port = self.description.ports.get(problem.port as usize);
            let own = port.filter(|_| (problem.port as usize) < self.own_ports);
            own.is_some_and(|port| matches!(port.role, Role::Export { .. }))
        };
        let mut found = found.map_err(failure)?;
        found.retain(|problem| !is_absent(problem));
        found.into_iter().map(with_name).collect()
    }
}
