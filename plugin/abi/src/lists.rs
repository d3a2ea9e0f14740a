//! The host's side of lists of ports: their tables, and the ports that an application puts in them.

#![allow(unsafe_code)]

use std::sync::{Arc, Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use crate::describe::{Type, shared};
use crate::{raw, table, write};

/// A port of a list, as an application states it. Its number in calls follows those of the type's own ports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ListedPort {
    /// The place of its list among the lists of the type.
    pub list: usize,
    /// The entry's key in the application file.
    pub label: String,
    /// The type of its value.
    #[serde(with = "shared")]
    pub value_type: Arc<Type>,
    /// Its settings, in the type of the list.
    pub settings: Vec<u8>,
}

/// Returns the table of a schema type's lists, if it has any.
///
/// # Errors
/// A message that states what is wrong with its table.
///
/// # Safety
/// `schema` follows the rules of [`raw`].
pub unsafe fn of(schema: &raw::Schema) -> Result<Option<raw::Lists>, String> {
    // SAFETY: the caller's.
    let lists = unsafe { table::ability::<raw::Lists>(schema, raw::ABILITY_LISTS) };
    match lists.map_err(|unreadable| unreadable.to_string())? {
        Some(raw::Lists { set: None, .. }) => Err(String::from("its `set` is null")),
        lists => Ok(lists),
    }
}

/// The ports whose tables were written, which stay until the process ends.
static WRITTEN: Mutex<Vec<(ListedPort, Written)>> = Mutex::new(Vec::new());

/// The table of a port, with the number 0.
#[derive(Clone, Copy)]
struct Written(raw::ListedPort);

// SAFETY: what the table points to is never changed or freed.
unsafe impl Send for Written {}

/// Returns the tables of listed ports, the first of which has the number `first`. What they point to is never freed, and
/// the same for the same ports.
#[must_use]
pub fn tables(ports: &[ListedPort], first: usize) -> Vec<raw::ListedPort> {
    let mut written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
    let ports = ports.iter().enumerate();
    ports
        .map(|(index, port)| raw::ListedPort {
            port: (first + index) as u32,
            ..table_of(&mut written, port)
        })
        .collect()
}

fn table_of(written: &mut Vec<(ListedPort, Written)>, port: &ListedPort) -> raw::ListedPort {
    if let Some((_, known)) = written.iter().find(|(known, _)| known == port) {
        return known.0;
    }
    let table = raw::ListedPort {
        size: size_of::<raw::ListedPort>() as u32,
        list: port.list as u32,
        port: 0,
        reserved: 0,
        label: write::text(&port.label),
        value_type: write::value_type(&port.value_type),
        settings: write::bytes(&port.settings),
    };
    written.push((port.clone(), Written(table)));
    table
}
