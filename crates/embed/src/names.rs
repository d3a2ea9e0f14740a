//! What the names of a run denote: variables and parts of them, ports of mocks, schemas.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_abi::describe::Type;
use jde_board::Variable;
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

/// Returns the port of a mock at the front of a name, its full name, and the path after it.
pub(crate) fn find_live<'n, 'p>(
    live: &'p BTreeMap<String, LivePort>,
    name: &'n str,
) -> Result<(&'n str, &'n str, &'p LivePort), Error> {
    let found = split(name).filter_map(|(front, path)| Some((front, path, live.get(front)?)));
    found.last().ok_or_else(|| {
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
    if let Some(variable) = board.find(name) {
        return Ok((variable, ""));
    }
    let found = split(name).filter_map(|(front, path)| Some((board.find(front)?, path)));
    match found.last() {
        Some(found) => Ok(found),
        // The error names the most similar variable.
        None => board
            .get(name)
            .map(|variable| (variable, ""))
            .map_err(Error::unknown),
    }
}

/// Returns the number of a schema.
pub(crate) fn find_schema(handle: &Handle, name: &str) -> Result<usize, Error> {
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

/// Returns every division of a name into a front and the path of a part, the longest front last.
fn split(name: &str) -> impl Iterator<Item = (&str, &str)> {
    let ends = name.match_indices(['.', '[']).map(|(end, _)| end);
    ends.chain([name.len()])
        .map(|end| (&name[..end], name[end..].trim_start_matches('.')))
}
