//! Converts a plugin's tables to owned descriptions. Reads each table within the size that it states, and
//! refuses invalid contents with a message. The only function of the plugin that it calls is `ability`, which
//! returns the tables of optional abilities.
//!
//! No check can detect a dangling pointer: a plugin is native code and must be trusted.

#![allow(unsafe_code)]

use std::fmt;
use std::sync::Arc;

use crate::describe::{Attributes, Child, Guard, Kind, Limits, Plugin, Port, Role, Schema, Type, Validity};
use crate::{guard, inspect, raw, state, table, unit};

mod lists;
mod place;
mod types;

pub use lists::ENTRY_KEYS;
use place::Place;

/// The keys of a schema that have a fixed meaning in an application file.
pub const RESERVED: &[&str] = &[
    "type",
    "period",
    "budget",
    "hang",
    "imports",
    "actuators",
    "children",
    "groups",
    "triggers",
    "restart",
    "isolate",
    "doc",
];

/// The variable that every schema has.
pub const PERIOD: &str = "period";

/// The largest number of choices of a modulation: more than a person can choose from.
const MOST_CHOICES: u32 = 256;

/// Why a plugin's tables were refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The symbol exists, but is not a plugin table.
    NotAPlugin,
    /// Built for another version of the ABI.
    Version {
        /// The plugin's.
        plugin: (u32, u32),
        /// The host's.
        host: (u32, u32),
    },
    /// Built so that a panic ends the process.
    Aborts,
    /// The contents of a table are invalid.
    Table {
        /// The table, from the plugin inward: "schema `goon`, port `laser`".
        place: String,
        /// What is wrong with it.
        wrong: String,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAPlugin => write!(
                f,
                "its symbol `{}` does not begin with the mark of a jde plugin; export it with `jde_schema::export!` or JDE_PLUGIN of jde.h",
                raw::ENTRY_SYMBOL
            ),
            Self::Version { plugin, host } => {
                let older = if plugin < host { "older" } else { "newer" };
                write!(
                    f,
                    "it was built for ABI {}.{}, {older} than this host's {}.{}; build it again with this host's SDK{}",
                    plugin.0,
                    plugin.1,
                    host.0,
                    host.1,
                    if plugin > host {
                        ", or use a newer host"
                    } else {
                        ""
                    }
                )
            }
            Self::Aborts => write!(
                f,
                "it was built with panic = \"abort\", so one panic would end the whole application; build it with panic = \"unwind\""
            ),
            Self::Table { place, wrong } => write!(f, "its description is wrong at {place}: {wrong}"),
        }
    }
}

impl std::error::Error for Refusal {}

/// Reads and checks the tables of a plugin.
///
/// # Errors
/// The first error. The version is checked before everything else.
///
/// # Safety
/// `plugin` points to at least the bytes of a [`raw::Plugin`] up to and including `abi_minor`. If magic and
/// version are right, it and all it points to follow the rules at the head of [`raw`].
pub unsafe fn plugin(plugin: *const raw::Plugin) -> Result<Plugin, Refusal> {
    // SAFETY: the caller guarantees these first fields.
    let (magic, major, minor) = unsafe {
        (
            (&raw const (*plugin).magic).read(),
            (&raw const (*plugin).abi_major).read(),
            (&raw const (*plugin).abi_minor).read(),
        )
    };
    if magic != raw::MAGIC {
        return Err(Refusal::NotAPlugin);
    }
    let host = (raw::ABI_MAJOR, raw::ABI_MINOR);
    if major != host.0 {
        return Err(Refusal::Version {
            plugin: (major, minor),
            host,
        });
    }
    let place = Place::new("the plugin");
    // SAFETY: the version is that of this host, so the table follows the rules of `raw`.
    let table = unsafe { place.table(plugin)? };
    if table.flags & raw::PLUGIN_ABORTS != 0 {
        return Err(Refusal::Aborts);
    }
    // SAFETY: as above, for the rest of this function.
    unsafe {
        let name = place.name("name", table.name)?;
        let place = Place::new(format!("plugin `{name}`"));
        let schemas = place.array("schemas", table.schemas, table.schema_count)?;
        if schemas.is_empty() {
            return place.wrong("it holds no schema");
        }
        let schemas = schemas
            .into_iter()
            .map(|schema| self::schema(&place, &schema))
            .collect::<Result<Vec<_>, _>>()?;
        place.distinct("schemas", schemas.iter().map(|schema| schema.name.clone()))?;
        Ok(Plugin {
            name,
            version: place.text("version", table.version)?,
            doc: place.text("doc", table.doc)?,
            abi: (major, minor),
            throws: false,
            isolated: false,
            schemas,
        })
    }
}

/// Reads and checks a type of value.
///
/// # Errors
/// The first error.
///
/// # Safety
/// `table` and all it points to follow the rules at the head of [`raw`].
pub unsafe fn value_type(table: *const raw::Type) -> Result<Type, Refusal> {
    // SAFETY: the caller's.
    unsafe { types::value_type(&Place::new("the type"), table, 0) }
}

unsafe fn schema(outer: &Place, table: &raw::Schema) -> Result<Schema, Refusal> {
    // SAFETY: the caller's table follows the rules of `raw`, and so does all it points to.
    unsafe {
        let place = outer.inner("schema", outer.name("a schema's name", table.name)?.as_str());
        let kind = match table.kind {
            raw::PERCEPTIVE => Kind::Perceptive,
            raw::MOTOR => Kind::Motor,
            raw::DRIVER => Kind::Driver,
            other => return place.wrong(format!("kind is {other}, and only 0 to 2 exist")),
        };
        if table.period_ns == 0 {
            return place.wrong("period_ns is 0; a schema iterates periodically, so give at least 1");
        }
        if table.create.is_none() || table.iterate.is_none() {
            return place.wrong("create or iterate is null; both are required");
        }
        let children = place.array("children", table.children, table.child_count)?;
        let children = children
            .into_iter()
            .map(|child| self::child(&place, &child))
            .collect::<Result<Vec<_>, _>>()?;
        place.distinct("children", children.iter().map(|child| child.name.clone()))?;
        let ports = place.array("ports", table.ports, table.port_count)?;
        let ports = ports
            .into_iter()
            .map(|port| self::port(&place, &port, kind, children.len()))
            .collect::<Result<Vec<_>, _>>()?;
        let names = ports.iter().map(|port| match port.role {
            Role::ChildModulation { child } => format!("{}.{}", children[child].name, port.name),
            Role::Import => format!("import {}", port.name),
            Role::Actuator => format!("actuator {}", port.name),
            Role::Export { .. } | Role::Modulation { .. } | Role::Command { .. } => port.name.clone(),
        });
        let former = ports.iter().filter_map(|port| port.former_name.clone());
        place.distinct("ports", names.chain(former))?;
        let many = children.iter().position(|child| child.many);
        if let Some(many) = many {
            let is_modulation_of_many = |port: &Port| port.role == Role::ChildModulation { child: many };
            if many + 1 != children.len() || !children[many].motor || ports.iter().any(is_modulation_of_many)
            {
                return place.wrong(
                    "a role that any number of children have is the last one, of motor schemas, and without modulations",
                );
            }
        }
        if kind != Kind::Motor && children.iter().any(|child| child.motor) {
            return place.wrong("only a motor schema may have motor children");
        }
        let guard = guard(&place, table, kind, &ports)?;
        let panel = panel(&place, table)?;
        let lists = lists::read(&place, table, (kind, &ports))?;
        Ok(Schema {
            name: place.name("name", table.name)?,
            doc: place.text("doc", table.doc)?,
            kind,
            period_ns: table.period_ns,
            budget_ns: (table.budget_ns > 0).then_some(table.budget_ns),
            ports,
            children,
            arbitrates: table.arbitrate.is_some(),
            panel: panel.is_some(),
            touch: panel.is_some_and(|panel| panel.touch.is_some()),
            memory: matches!(state::of(table), Ok(Some(_))),
            inspects: inspects(&place, table)?,
            guard,
            lists,
        })
    }
}

/// Returns the panel of the type, if it has one. A panel without `draw` is refused.
unsafe fn panel(place: &Place, table: &raw::Schema) -> Result<Option<raw::Panel>, Refusal> {
    // SAFETY: the caller's.
    let panel = unsafe { table::ability::<raw::Panel>(table, raw::ABILITY_PANEL) };
    match panel {
        Err(unreadable) => place.wrong(format!("of its panel {unreadable}")),
        Ok(Some(raw::Panel { draw: None, .. })) => {
            place.wrong("its panel's draw is null; a panel is drawn, or is none")
        }
        Ok(panel) => Ok(panel),
    }
}

/// Returns whether the type has an inspection. An inspection without its function is refused.
unsafe fn inspects(place: &Place, table: &raw::Schema) -> Result<bool, Refusal> {
    // SAFETY: the caller's.
    match unsafe { inspect::of(table) } {
        Err(wrong) => place.wrong(format!("of its ability `{}`: {wrong}", raw::ABILITY_INSPECT)),
        Ok(inspect) => Ok(inspect.is_some()),
    }
}

/// Returns what the type judges, if it is a guard.
unsafe fn guard(
    place: &Place,
    table: &raw::Schema,
    kind: Kind,
    ports: &[Port],
) -> Result<Option<Guard>, Refusal> {
    // SAFETY: the caller's.
    let guard = match unsafe { guard::of(table) } {
        Err(wrong) => return place.wrong(format!("of its ability `{}`: {wrong}", raw::ABILITY_GUARD)),
        Ok(None) => return Ok(None),
        Ok(Some(guard)) => guard,
    };
    let state = guard.state as usize;
    if kind != Kind::Perceptive {
        return place.wrong("only a perceptive schema can be a guard");
    }
    if !matches!(ports.get(state).map(|port| &port.role), Some(Role::Export { .. })) {
        return place.wrong(format!(
            "its guard's state is port {state}, which is not an export"
        ));
    }
    // SAFETY: the plugin's table follows the rules of `raw`.
    let command = unsafe { types::value_type(&place.inner("guard", "command"), guard.command, 0)? };
    Ok(Some(Guard {
        state,
        command: Arc::new(command),
    }))
}

unsafe fn port(outer: &Place, table: &raw::Port, kind: Kind, children: usize) -> Result<Port, Refusal> {
    // SAFETY: the caller's table follows the rules of `raw`, and so does all it points to.
    unsafe {
        let name = outer.name("a port's name", table.name)?;
        let place = outer.inner("port", &name);
        let value_type = Arc::new(types::value_type(&place, table.value_type, 0)?);
        let initial = || -> Result<Vec<u8>, Refusal> {
            if table.initial.is_null() {
                return place.wrong(
                    "a modulation needs a default and a command a neutral value, and `initial` is null",
                );
            }
            Ok(core::slice::from_raw_parts(table.initial.cast::<u8>(), value_type.bytes).to_vec())
        };
        let unit = place.text("unit", table.unit)?;
        if let Err(wrong) = unit::check(&unit) {
            return place.wrong(wrong);
        }
        // The host gives every schema a variable of that name, and a file has a key of that name.
        let reserved = match table.kind {
            raw::MODULATION => RESERVED.contains(&name.as_str()),
            raw::EXPORT | raw::COMMAND => name == PERIOD,
            _ => false,
        };
        if reserved {
            return place.wrong("every schema has this name with a meaning of its own; choose another");
        }
        let role = match table.kind {
            raw::IMPORT => Role::Import,
            raw::EXPORT => Role::Export {
                validity: Validity::from_ns(table.validity_ns),
            },
            raw::MODULATION => {
                let default = initial()?;
                Role::Modulation {
                    limits: limits(&place, table, (&value_type, &unit), &default)?,
                    default,
                }
            }
            raw::COMMAND if kind != Kind::Driver => return place.wrong("only a driver takes commands"),
            raw::COMMAND if table.validity_ns == 0 => {
                return place
                    .wrong("validity_ns is 0; say how long a command is in force without being repeated");
            }
            raw::COMMAND => Role::Command {
                neutral: initial()?,
                validity_ns: table.validity_ns,
            },
            raw::ACTUATOR if kind != Kind::Motor => {
                return place.wrong("only a motor schema commands actuators");
            }
            raw::ACTUATOR => Role::Actuator,
            raw::CHILD_MODULATION if table.child as usize >= children => {
                return place.wrong(format!("it names child {} of {children}", table.child));
            }
            raw::CHILD_MODULATION => Role::ChildModulation {
                child: table.child as usize,
            },
            other => return place.wrong(format!("kind is {other}, and only 0 to 5 exist")),
        };
        Ok(Port {
            name,
            doc: place.text("doc", table.doc)?,
            unit,
            value_type,
            role,
            attributes: Attributes::of(table.kind, table.flags),
            former_name: match table.former_name.is_null() {
                true => None,
                false if table.kind == raw::MODULATION => {
                    Some(outer.name("a port's former name", table.former_name)?)
                }
                false => return outer.wrong("only a modulation has a former name"),
            },
        })
    }
}

/// Returns the limits of a modulation, which its default must meet.
unsafe fn limits(
    place: &Place,
    table: &raw::Port,
    (ty, unit): (&Type, &str),
    default: &[u8],
) -> Result<Limits, Refusal> {
    let bound = |number: f64| (!number.is_nan()).then_some(number);
    let mut choices = Vec::new();
    if table.choice_count > 0 {
        if table.choice_count > MOST_CHOICES || table.choices.is_null() || !table.choices.is_aligned() {
            return place.wrong(format!(
                "{} choices, of which at most {MOST_CHOICES} are believed, or the pointer to them is null or not aligned",
                table.choice_count
            ));
        }
        for index in 0..table.choice_count as usize {
            // SAFETY: the caller's table points to that many texts.
            choices.push(unsafe { place.name("a choice", *table.choices.add(index))? });
        }
        place.distinct("choices", choices.iter().cloned())?;
    }
    let limits = Limits {
        least: bound(table.min),
        greatest: bound(table.max),
        choices,
    };
    let is_number = ty.number_of(default).is_some();
    if !is_number && (!limits.is_none() || !limits.choices.is_empty()) {
        return place.wrong(format!(
            "it limits a {}, and only plain numbers have limits",
            ty.name
        ));
    }
    if let (Some(least), Some(greatest)) = (limits.least, limits.greatest)
        && least > greatest
    {
        return place.wrong(format!(
            "min is {least} and max {greatest}, between which nothing is"
        ));
    }
    if !limits.choices.is_empty()
        && (bound(table.min), bound(table.max)) != (Some(0.0), Some(limits.choices.len() as f64 - 1.0))
    {
        return place.wrong(format!(
            "of {} choices min is 0 and max the last one's number",
            limits.choices.len()
        ));
    }
    match limits.check(ty, default) {
        Ok(()) => Ok(limits),
        Err(not_allowed) => place.wrong(format!("its default {}", not_allowed.words(unit))),
    }
}

unsafe fn child(outer: &Place, table: &raw::Child) -> Result<Child, Refusal> {
    // SAFETY: the caller's table follows the rules of `raw`, and so does all it points to.
    unsafe {
        let name = outer.name("a child's name", table.name)?;
        let place = outer.inner("child", &name);
        let motor = match table.kind {
            raw::PERCEPTIVE => false,
            raw::MOTOR => true,
            other => return place.wrong(format!("kind is {other}; a child is perceptive (0) or motor (1)")),
        };
        let group = place.text("group", table.group)?;
        if motor && group.is_empty() {
            return place.wrong("a motor child competes in a group, and `group` is empty");
        }
        Ok(Child {
            name,
            doc: place.text("doc", table.doc)?,
            motor,
            group,
            optional: table.flags & raw::OPTIONAL != 0,
            many: table.flags & raw::MANY != 0,
        })
    }
}
