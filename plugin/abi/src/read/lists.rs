//! Reads the lists of ports of a type of schema.

#![allow(unsafe_code)]

use std::sync::Arc;

use super::place::Place;
use super::{RESERVED, Refusal, types};
use crate::describe::{Kind, ListKind, Port, PortList, Role, Validity};
use crate::{lists, raw};

/// The most lists of a type.
const MOST: u32 = 16;

/// The keys of an entry that are no settings.
pub const ENTRY_KEYS: &[&str] = &["from", "as", "type", "capacity"];

/// Returns the lists of ports of a type with these ports of its own.
///
/// # Safety
/// `table` follows the rules of [`raw`].
pub(super) unsafe fn read(
    place: &Place,
    table: &raw::Schema,
    (kind, ports): (Kind, &[Port]),
) -> Result<Vec<PortList>, Refusal> {
    // SAFETY: the caller's.
    let lists = match unsafe { lists::of(table) } {
        Err(wrong) => return place.wrong(format!("of its ability `{}`: {wrong}", raw::ABILITY_LISTS)),
        Ok(None) => return Ok(Vec::new()),
        Ok(Some(lists)) => lists,
    };
    if lists.count == 0 || lists.count > MOST {
        return place.wrong(format!(
            "it has {} lists of ports; 1 to {MOST} are possible",
            lists.count
        ));
    }
    if ports.is_empty() {
        return place.wrong("it has lists of ports and no port besides");
    }
    // SAFETY: the plugin's table follows the rules of `raw`.
    let lists = unsafe { place.array("lists", lists.lists, lists.count)? };
    let lists = lists
        .into_iter()
        // SAFETY: as above.
        .map(|list| unsafe { self::list(place, kind, &list) })
        .collect::<Result<Vec<_>, _>>()?;
    place.distinct("lists", lists.iter().map(|list| list.name.clone()))?;
    let is_modulation = |port: &&Port| matches!(port.role, Role::Modulation { .. });
    for list in &lists {
        if RESERVED.contains(&&*list.name)
            || ports
                .iter()
                .filter(is_modulation)
                .any(|port| port.name == list.name)
        {
            return place.wrong(format!(
                "the list of ports `{}` has the name of another key of an application file",
                list.name
            ));
        }
    }
    Ok(lists)
}

unsafe fn list(outer: &Place, owner: Kind, table: &raw::PortList) -> Result<PortList, Refusal> {
    // SAFETY: the caller's table follows the rules of `raw`.
    unsafe {
        let name = outer.name("a list's name", table.name)?;
        let place = outer.inner("list", &name);
        let kind = match table.kind {
            raw::IMPORT => ListKind::Imports,
            raw::EXPORT => ListKind::Exports {
                validity: Validity::from_ns(table.validity_ns),
            },
            raw::COMMAND if owner != Kind::Driver => {
                return place.wrong("only drivers have lists of commands");
            }
            raw::COMMAND if table.validity_ns == 0 => {
                return place.wrong("validity_ns is 0; a command is in force for at least 1 ns");
            }
            raw::COMMAND => ListKind::Commands {
                validity_ns: table.validity_ns,
            },
            other => {
                return place.wrong(format!(
                    "kind is {other}; a list has imports (0), exports (1) or commands (3)"
                ));
            }
        };
        let settings = Arc::new(types::value_type(&place, table.settings, 0)?);
        if let Some(field) = settings
            .fields
            .iter()
            .find(|field| ENTRY_KEYS.contains(&&*field.name))
        {
            return place.wrong(format!(
                "its setting `{}` has the name of another key of an entry",
                field.name
            ));
        }
        if table.initial.is_null() {
            return place.wrong("its settings need a default, and `initial` is null");
        }
        let initial = core::slice::from_raw_parts(table.initial.cast::<u8>(), settings.bytes).to_vec();
        Ok(PortList {
            doc: place.text("doc", table.doc)?,
            name,
            kind,
            settings,
            initial,
        })
    }
}
