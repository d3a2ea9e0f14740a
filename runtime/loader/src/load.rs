//! Loads a library from a private copy, checks its tables, and keeps it mapped permanently.
//!
//! The copy makes it safe to rebuild a plugin while an application runs: a write to a mapped file can crash
//! every process that executes it.

#![allow(unsafe_code)]

use std::fmt;
use std::fs::File;
use std::mem::offset_of;
use std::ops::Deref;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_abi::table::{self, Table as _};
use jde_abi::{describe, raw, read, write};
use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};

use super::copy::PrivateCopy;
use super::{PluginLocation, copy, elf, python};

/// A plugin whose tables have been read and are valid.
#[derive(Clone, Debug)]
pub struct LoadedPlugin {
    /// Its description of itself.
    pub description: Arc<describe::Plugin>,
    /// The file from which it was loaded; `None` if it is linked in.
    pub path: Option<PathBuf>,
    table: *const raw::Plugin,
    schemas: Arc<[SchemaFunctions]>,
    /// The file that is mapped.
    copy: Option<Arc<PrivateCopy>>,
}

/// The table of a schema type in the layout of this ABI version, and the address of the plugin's own table.
#[derive(Clone, Copy)]
pub struct SchemaFunctions {
    pub(crate) own: *const raw::Schema,
    table: raw::Schema,
}

// SAFETY: a plugin's tables are immutable, live until the process ends, and are bound to no thread.
unsafe impl Send for LoadedPlugin {}
// SAFETY: as above.
unsafe impl Sync for LoadedPlugin {}
// SAFETY: as above.
unsafe impl Send for SchemaFunctions {}
// SAFETY: as above.
unsafe impl Sync for SchemaFunctions {}

/// Why a file could not be loaded as a plugin.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file could not be read.
    #[error("cannot read it: {0}")]
    Io(#[from] std::io::Error),
    /// It could not be copied.
    #[error("cannot copy it to {}: {error}; free space there, or set TMPDIR to another folder", folder.display())]
    Copy {
        /// The destination folder.
        folder: PathBuf,
        /// The reason.
        error: std::io::Error,
    },
    /// The file is not a usable plugin library, for this reason.
    #[error("{0}")]
    Invalid(String),
    /// The file is a valid library that does not export a plugin.
    #[error(
        "it is a shared library, but exports no symbol `{}`, so it is not a jde plugin",
        raw::ENTRY_SYMBOL
    )]
    NotAPlugin,
    /// The system's loader refused it.
    #[error(
        "the system cannot load it: {0}; if a symbol is undefined, link the library that defines it into the plugin"
    )]
    System(String),
    /// Its tables are invalid.
    #[error("{0}")]
    InvalidTables(#[from] read::Refusal),
    /// A process of Python cannot describe it, for this reason.
    #[error("{0}")]
    Python(String),
    /// The process that inspected it did not finish in time.
    #[error("it cannot be loaded: {0}")]
    InspectionSlow(String),
    /// The process that inspected it died.
    #[error(
        "it cannot be loaded: {0}; the file is damaged, or its constructors are wrong: build or copy it again"
    )]
    InspectionFailed(String),
    /// No process could be started to inspect it.
    #[error("no process can be started to inspect it: {0}")]
    InspectorUnavailable(#[source] std::io::Error),
}

impl LoadedPlugin {
    /// Reads a plugin that is linked into this program, with the same checks as a plugin from a file.
    ///
    /// # Errors
    /// [`LoadError::InvalidTables`].
    pub fn linked_in(table: &'static raw::Plugin) -> Result<Self, LoadError> {
        // SAFETY: a reference to a whole table, made by the SDK's export macro in this program.
        unsafe { Self::read(table, None) }
    }

    /// Loads the library at `path`. The system runs its constructors, if it has any; of the plugin's
    /// functions only `ability` is called.
    ///
    /// # Errors
    /// See [`LoadError`]. The process is then as before, except that a refused library stays mapped.
    pub fn open(path: &Path) -> Result<Self, LoadError> {
        Self::from_copy(path, copy::create(path)?)
    }

    /// Loads a copy of the library at `path`, as [`Self::open`].
    pub(super) fn from_copy(path: &Path, copy: PrivateCopy) -> Result<Self, LoadError> {
        let loaded = Self::open_copy(copy.path(), path)?;
        Ok(Self {
            copy: Some(Arc::new(copy)),
            ..loaded
        })
    }

    /// Returns the plugin of Python that an inspector found in a copy of the file `path`. Its functions run in
    /// processes of their own.
    pub(super) fn from_python(
        path: &Path,
        copy: PrivateCopy,
        description: &describe::Plugin,
    ) -> Result<Self, LoadError> {
        let table = write::plugin::<python::Elsewhere>(description);
        // SAFETY: a table that was just written, which is never freed.
        let mut loaded = unsafe { Self::read(table, Some(path.to_owned())) }?;
        if let Some(description) = Arc::get_mut(&mut loaded.description) {
            description.isolated = true;
        }
        Ok(Self {
            copy: Some(Arc::new(copy)),
            ..loaded
        })
    }

    /// Loads `file` without copying it; errors name it by `path`, the file that the user knows. No process
    /// may write to it: it is the private copy of another process.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_copy(file: &Path, path: &Path) -> Result<Self, LoadError> {
        let symbol_size = table_symbol_size(file)?;
        crate::forked::watch();
        // SAFETY: the file is a complete library for this machine; loading it includes its constructors.
        let library = crate::forked::call(|| unsafe { Library::open(Some(file), RTLD_NOW | RTLD_LOCAL) })
            .map_err(|error| LoadError::System(loader_message(&error, file, path)))?;
        // SAFETY: the symbol is there; its type is checked below before it is used as a table.
        let table = unsafe { library.get::<*const raw::Plugin>(raw::ENTRY_SYMBOL.as_bytes()) }
            .map_err(|error| LoadError::System(error.to_string()))?
            .into_raw()
            .cast::<raw::Plugin>()
            .cast_const();
        // Never unmapped: even a refused library may have created threads, thread-locals or hooks.
        std::mem::forget(library);
        if symbol_size < offset_of!(raw::Plugin, size) as u64 || !table.is_aligned() {
            return Err(read::Refusal::NotAPlugin.into());
        }
        // SAFETY: the symbol has at least the bytes of the head; no byte after it is read before the version.
        let is_own_version = unsafe {
            (&raw const (*table).magic).read() == raw::MAGIC
                && (&raw const (*table).abi_major).read() == raw::ABI_MAJOR
        };
        let mut needed = raw::Plugin::LEAST;
        if is_own_version && symbol_size >= needed as u64 {
            // SAFETY: the symbol has the bytes that every table of this version has.
            let stated = unsafe { (&raw const (*table).size).read() } as usize;
            needed = stated.clamp(needed, size_of::<raw::Plugin>());
        }
        if is_own_version && symbol_size < needed as u64 {
            return Err(LoadError::Invalid(format!(
                "its symbol `{}` has {symbol_size} bytes, and a plugin's has {needed}: declare it as the structure of jde.h",
                raw::ENTRY_SYMBOL,
            )));
        }
        // SAFETY: the symbol has the bytes of a table if it is of this version, otherwise those of its head;
        // its library stays mapped.
        let mut loaded = unsafe { Self::read(table, Some(path.to_owned())) }?;
        // SAFETY: as above, and it was read.
        let catches = unsafe { (&raw const (*table).flags).read() } & raw::PLUGIN_CATCHES != 0;
        if let Some(description) = Arc::get_mut(&mut loaded.description) {
            description.throws = !catches && elf::is_cpp(&elf::ElfFile::new(File::open(file)?));
        }
        Ok(loaded)
    }

    /// # Safety
    /// As [`read::plugin`].
    unsafe fn read(own: *const raw::Plugin, path: Option<PathBuf>) -> Result<Self, LoadError> {
        // SAFETY: by the caller's contract.
        let description = unsafe { read::plugin(own) }?;
        // SAFETY: as above, and `read::plugin` has validated these tables.
        let schemas = unsafe {
            let first = table::read(own).map_err(invalid_table)?.schemas;
            let stride = first.cast::<u32>().read() as usize;
            let functions = |index| {
                let own = first.byte_add(index * stride);
                let table = table::read(own).map_err(invalid_table)?;
                Ok(SchemaFunctions { own, table })
            };
            (0..description.schemas.len())
                .map(functions)
                .collect::<Result<_, LoadError>>()?
        };
        Ok(Self {
            description: Arc::new(description),
            path,
            table: own,
            schemas,
            copy: None,
        })
    }

    /// Returns where another process finds the same code.
    pub fn location(&self) -> PluginLocation {
        match (self.copy.as_deref(), &self.path) {
            (Some(copy), Some(path)) if self.description.isolated => PluginLocation::Python {
                copy: copy.path().to_path_buf(),
                path: path.clone(),
            },
            (Some(copy), _) => PluginLocation::File(copy.path().to_path_buf()),
            (None, _) => PluginLocation::LinkedIn(self.description.name.clone()),
        }
    }

    /// Returns its copy as a file of its own, for another process; `None` if it is linked in.
    ///
    /// # Errors
    /// The process has no descriptor left.
    pub fn held_copy(&self) -> std::io::Result<Option<OwnedFd>> {
        self.copy.as_deref().map(PrivateCopy::held).transpose()
    }

    /// Returns the size of its file in bytes; 0 if it is linked in.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.copy.as_ref().map_or(0, |copy| copy.length)
    }

    /// Whether its file had exactly the content of `copy`.
    pub(super) fn has_content_of(&self, copy: &PrivateCopy) -> bool {
        self.copy
            .as_deref()
            .is_some_and(|loaded| loaded.has_same_content(copy))
    }

    /// Whether both are the same library in memory.
    pub fn is_same_library(&self, other: &Self) -> bool {
        self.table == other.table
    }

    /// Returns the functions of a type, by its index in the description.
    #[must_use]
    pub fn schema(&self, index: usize) -> SchemaFunctions {
        self.schemas[index]
    }
}

impl Deref for SchemaFunctions {
    type Target = raw::Schema;

    fn deref(&self) -> &raw::Schema {
        &self.table
    }
}

impl fmt::Debug for SchemaFunctions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "functions at {:p}", self.own)
    }
}

fn invalid_table(error: table::Unreadable) -> LoadError {
    LoadError::InvalidTables(read::Refusal::Table {
        place: String::from("the plugin"),
        wrong: error.to_string(),
    })
}

/// Returns the size in bytes of a plugin's table symbol. Fails unless the file is a library for this machine
/// that exports a plugin of this version. No code of the file runs.
pub(super) fn table_symbol_size(file: &Path) -> Result<u64, LoadError> {
    let parts = elf::ElfFile::new(File::open(file)?);
    elf::check(&parts).map_err(LoadError::Invalid)?;
    let symbol = elf::symbol(&parts, raw::ENTRY_SYMBOL).ok_or(LoadError::NotAPlugin)?;
    let head = symbol.head.unwrap_or_default();
    let number = |offset: usize| {
        u32::from_ne_bytes([head[offset], head[offset + 1], head[offset + 2], head[offset + 3]])
    };
    if !head.starts_with(&raw::MAGIC.to_ne_bytes()) {
        return Err(read::Refusal::NotAPlugin.into());
    }
    let (plugin, host) = ((number(8), number(12)), (raw::ABI_MAJOR, raw::ABI_MINOR));
    if plugin.0 != host.0 {
        return Err(read::Refusal::Version { plugin, host }.into());
    }
    Ok(symbol.size)
}

/// Returns the system's error message, with the name of the private copy replaced by the name that the user
/// knows.
fn loader_message(error: &libloading::Error, copy: &Path, path: &Path) -> String {
    let text = match std::error::Error::source(error) {
        Some(source) => source.to_string(),
        None => error.to_string(),
    };
    let text = text.replace(&copy.display().to_string(), &path.display().to_string());
    match copy.parent() {
        Some(folder) if text.contains("failed to map segment") => {
            format!(
                "{text} (its copy is in {}; if programs may not run there, set TMPDIR to a folder where they may)",
                folder.display()
            )
        }
        _ => text,
    }
}
