//! What the names of a run denote: variables and parts of them, ports of mocks, schemas.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_abi::describe::Type;
use jde_board::Variable;
use jde_core::SchemaId;
use jde_host::{Handle, LiveValue};

use crate::Error;

/// A port of a mock, which the program writes.
#[derive(Clone, Debug)]
pub struct LivePort {
    /// The type of its value.
    pub value_type: Arc<Type>,
    /// The value.
    pub value: LiveValue,
}

/// Splits a name into the longest front that is known, and the path after it: `pioneer.truth` and `pose.x`.
pub fn split_name<'n, T>(name: &'n str, find: impl Fn(&'n str) -> Option<T>) -> Option<(T, &'n str)> {
    let ends = name.match_indices(['.', '[']).map(|(end, _)| end);
    let known = ends
        .chain([name.len()])
        .filter_map(|end| Some((find(&name[..end])?, name[end..].trim_start_matches('.'))));
    known.last()
}

/// Returns the port of a mock at the front of a name, its full name, and the path after it.
pub(crate) fn find_live<'n, 'p>(
    live: &'p BTreeMap<String, LivePort>,
    name: &'n str,
) -> Result<(&'n str, &'n str, &'p LivePort), Error> {
    let found = split_name(name, |port| Some((port, live.get(port)?)));
    let found = found.map(|((port, live), path)| (port, path, live));
    found.ok_or_else(|| {
        let known: Vec<_> = live.keys().map(String::as_str).collect();
        Error::unknown(format!(
            "no mock writes `{name}`; mocks write {}",
            known.join(", ")
        ))
    })
}

/// Returns the variable at the front of a name, and the path after it.
pub(crate) fn find_variable<'n>(handle: &Handle, name: &'n str) -> Result<(Arc<Variable>, &'n str), Error> {
    let board = handle.board();
    match board.find(name) {
        Some(variable) => Ok((variable, "")),
        None => split_name(name, |front| board.find(front)).map_or_else(
            // The error names the most similar variable.
            || {
                let named = board.get(name).map(|variable| (variable, ""));
                named.map_err(Error::unknown)
            },
            Ok,
        ),
    }
}

/// Returns the schema of that name.
pub(crate) fn find_schema(handle: &Handle, name: &str) -> Result<SchemaId, Error> {
    let application = handle.application();
    application.instance(name).ok_or_else(|| {
        let known: Vec<_> = application
            .instances
            .iter()
            .map(|instance| instance.name.as_str())
            .collect();
        Error::unknown(format!(
            "no schema is called `{name}`; there are {}",
            known.join(", ")
        ))
    })
}
