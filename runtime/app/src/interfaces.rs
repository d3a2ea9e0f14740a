//! Types by name: those of the plugins in use, the standard ones, and those that files define, as ROS 2 installs them:
//! `PACKAGE/msg/NAME.msg`, `PACKAGE/srv/NAME.srv` and `PACKAGE/action/NAME.action` in the folders that the application states,
//! and in `share` of each `AMENT_PREFIX_PATH`. Recordings that it states come before them.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_abi::describe::{Plugin, Type};
use jde_document::quote;
use jde_ros::definition::{UNBOUNDED_CAPACITY, action_result, gather, read_interface};

/// The largest file of a definition, bytes: as much as is read of a whole one.
const MOST_BYTES: u64 = 1 << 20;

/// Where types are found.
#[derive(Clone, Copy)]
pub(super) struct Types<'s> {
    pub(super) plugins: &'s [Arc<Plugin>],
    /// The texts of the messages that the stated recordings define.
    pub(super) recorded: &'s BTreeMap<String, String>,
    /// The folders that the application states.
    pub(super) folders: &'s [PathBuf],
}

/// The most elements or bytes of the fields without a bound.
pub(super) enum Capacities {
    /// Of each.
    All(usize),
    /// Of these; others have the usual one.
    Some(Vec<(String, usize)>),
}

impl Capacities {
    fn of(&self, field: &str) -> usize {
        match self {
            Self::All(capacity) => *capacity,
            Self::Some(stated) => {
                let own = stated.iter().find(|(name, _)| name == field);
                own.map_or(UNBOUNDED_CAPACITY, |(_, capacity)| *capacity)
            }
        }
    }

    /// Refuses stated ones of a type that has its own.
    ///
    /// # Errors
    /// If some are stated; `whose` says where the type is from.
    pub(super) fn refuse_all(&self, whose: &str) -> Result<(), String> {
        match self {
            Self::Some(stated) if stated.is_empty() => Ok(()),
            _ => Err(format!(
                "`capacity` is of a type that a file defines, and this is that of {whose}, which has its own"
            )),
        }
    }

    /// Refuses a stated field that is none of those without a bound.
    fn refuse_others(&self, unbounded: &BTreeSet<String>) -> Result<(), String> {
        let Self::Some(stated) = self else {
            return Ok(());
        };
        match stated.iter().find(|(field, _)| !unbounded.contains(field)) {
            None => Ok(()),
            Some((field, _)) => {
                let fields: Vec<_> = unbounded.iter().map(|field| quote(field)).collect();
                let other = quote(field);
                Err(format!(
                    "`capacity` states {other}, and the fields without a bound are {}",
                    fields.join(", ")
                ))
            }
        }
    }
}

impl Types<'_> {
    /// Returns the type of that name; `None` if nothing defines it.
    ///
    /// # Errors
    /// Why its definition does not give a type that can be shared.
    pub(super) fn find(&self, name: &str, capacities: &Capacities) -> Result<Option<Arc<Type>>, String> {
        let schemas = self.plugins.iter().flat_map(|plugin| &plugin.schemas);
        let mut ports = schemas.flat_map(|schema| &schema.ports);
        if let Some(port) = ports.find(|port| port.value_type.name == name) {
            capacities.refuse_all("a plugin")?;
            return Ok(Some(Arc::clone(&port.value_type)));
        }
        let standard = jde_types::standard();
        let own = |name: &str| standard.iter().find(|ty| ty.name == name);
        if let Some(found) = own(name) {
            capacities.refuse_all("a standard interface")?;
            return Ok(Some(Arc::new(found.clone())));
        }
        let Some(text) = self.text_of(name)? else {
            return Ok(None);
        };
        let find = |inner: &str| match inner == name {
            true => Ok(Some(text.clone())),
            false => self.text_of(inner),
        };
        let gathered = gather(name, find, |inner| own(inner).is_some()).map_err(|error| error.to_string())?;
        let unbounded = RefCell::new(BTreeSet::new());
        let capacity = |field: &str| {
            unbounded.borrow_mut().insert(field.to_owned());
            capacities.of(field)
        };
        let known = |inner: &str| own(inner).cloned().map(Arc::new);
        let found = read_interface(name, &gathered, capacity, known).map_err(|error| error.to_string())?;
        capacities.refuse_others(&unbounded.borrow())?;
        Ok(Some(Arc::new(found)))
    }

    /// Returns the text that defines a message.
    ///
    /// # Errors
    /// The file that defines it cannot be read, or has not the parts of its kind.
    fn text_of(&self, name: &str) -> Result<Option<String>, String> {
        match self.recorded.get(name) {
            Some(text) => Ok(Some(text.clone())),
            None => self.file(name),
        }
    }

    /// Returns the text of the file that defines a message, or of the part of the file of a service or an action that does.
    fn file(&self, name: &str) -> Result<Option<String>, String> {
        if let Some((package, short)) = name.split_once("/msg/") {
            return Ok(text(&self.folders(), [package, "msg", short])?.map(|(_, text)| text));
        }
        if let Some((package, short)) = name.split_once("/action/") {
            if let Some(action) = short.strip_suffix("_GetResult_Response") {
                let file = text(&self.folders(), [package, "action", action])?;
                return Ok(file.map(|_| action_result(&format!("{package}/{action}"))));
            }
            return self.part(package, "action", short, &["Goal", "Result", "Feedback"]);
        }
        match name.split_once("/srv/") {
            Some((package, short)) => self.part(package, "srv", short, &["Request", "Response"]),
            None => Ok(None),
        }
    }

    /// Returns one part of a file, by the name of the whole and the part's own.
    fn part(&self, package: &str, kind: &str, short: &str, parts: &[&str]) -> Result<Option<String>, String> {
        let of_part = || {
            let (whole, part) = short.rsplit_once('_')?;
            Some((whole, parts.iter().position(|known| *known == part)?))
        };
        let Some((whole, place)) = of_part() else {
            return Ok(None);
        };
        let Some((file, text)) = text(&self.folders(), [package, kind, whole])? else {
            return Ok(None);
        };
        let lines: Vec<_> = text.lines().collect();
        let found: Vec<_> = lines.split(|line| line.trim() == "---").collect();
        if found.len() != parts.len() {
            return Err(format!(
                "{} has {} lines `---`, and {} are between its parts: {}",
                file.display(),
                found.len() - 1,
                parts.len() - 1,
                parts.join(", ")
            ));
        }
        Ok(Some(found[place].join("\n")))
    }

    /// The folders of packages.
    fn folders(&self) -> Vec<PathBuf> {
        let prefixes = std::env::var_os("AMENT_PREFIX_PATH").unwrap_or_default();
        let installed = std::env::split_paths(&prefixes).map(|prefix| prefix.join("share"));
        self.folders.iter().cloned().chain(installed).collect()
    }
}

/// Returns the file that defines an interface of a package, by its kind and name, and its text.
fn text(folders: &[PathBuf], [package, kind, name]: [&str; 3]) -> Result<Option<(PathBuf, String)>, String> {
    let is_name =
        |part: &str| !part.is_empty() && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !is_name(package) || !is_name(name) {
        return Ok(None);
    }
    let find = |ending: &str| {
        let file = Path::new(package).join(kind).join(format!("{name}.{ending}"));
        let mut files = folders.iter().map(|folder| folder.join(&file));
        files.find(|file| file.exists())
    };
    let Some(file) = find(kind) else {
        return find("idl").map_or(Ok(None), |file| {
            Err(format!(
                "{} is in IDL, which is not read: write its fields into {name}.{kind}",
                file.display()
            ))
        });
    };
    let bytes = jde_files::read(&file, MOST_BYTES).map_err(|error| format!("{}: {error}", file.display()))?;
    // A comment may be in any encoding.
    let text = String::from_utf8_lossy(&bytes).into_owned();
    Ok(Some((file, text)))
}
