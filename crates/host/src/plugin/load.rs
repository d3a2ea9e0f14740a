//! Loads a library from a private copy, checks its tables, and keeps it mapped for good.
//!
//! The copy is what makes rebuilding a plugin safe while an application runs: writing over a mapped file kills whoever runs it.

#![allow(unsafe_code)]

use std::fs::File;
use std::mem::offset_of;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_abi::{describe, raw, read};
use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};

use super::copy::PrivateCopy;
use super::{copy, elf};
use crate::apart;

/// A plugin whose tables were read and found right.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// What it says of itself.
    pub description: Arc<describe::Plugin>,
    /// The file it came from; `None` if it is linked in.
    pub path: Option<PathBuf>,
    table: &'static raw::Plugin,
    /// The file that is really mapped.
    copy: Option<Arc<PrivateCopy>>,
}

/// Why a file could not be loaded as a plugin.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file could not be read.
    #[error("cannot read it: {0}")]
    Io(#[from] std::io::Error),
    /// It could not be copied.
    #[error("cannot copy it to {}: {error}; make room there, or set TMPDIR to another folder", folder.display())]
    Copy {
        /// Where to.
        folder: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// The file is no library of ours.
    #[error("{0}")]
    Foreign(String),
    /// The file is a sound library that does not claim to be a plugin.
    #[error(
        "it is a shared library, but exports no symbol `{}`, so it is no jde plugin",
        raw::ENTRY_SYMBOL
    )]
    NoPlugin,
    /// The system's loader refused it.
    #[error(
        "the system cannot load it: {0}; if a symbol is undefined, link the library that defines it into the plugin"
    )]
    System(String),
    /// Its tables were refused.
    #[error("{0}")]
    Refused(#[from] read::Refusal),
}

impl Loaded {
    /// Takes a plugin that is linked into this program, through the same checks as one from a file.
    ///
    /// # Errors
    /// [`LoadError::Refused`].
    pub fn linked_in(table: &'static raw::Plugin) -> Result<Self, LoadError> {
        // SAFETY: a reference to a whole table, made by the SDK's export macro in this program.
        let description = unsafe { read::plugin(table) }?;
        Ok(Self {
            description: Arc::new(description),
            path: None,
            table,
            copy: None,
        })
    }

    /// Loads the library at `path`. No function of the plugin is called but `ability`; the system runs its constructors, if it has any.
    ///
    /// # Errors
    /// See [`LoadError`]; the process is as before, but for a refused library that stays mapped.
    pub fn open(path: &Path) -> Result<Self, LoadError> {
        if path.is_dir() {
            return Err(LoadError::Foreign(String::from(
                "it is a directory; name the library in it",
            )));
        }
        Self::of(path, copy::of(path)?)
    }

    /// Loads a copy of the library at `path`, as [`Self::open`].
    pub(super) fn of(path: &Path, copy: PrivateCopy) -> Result<Self, LoadError> {
        let loaded = Self::map(copy.path(), path)?;
        Ok(Self {
            copy: Some(Arc::new(copy)),
            ..loaded
        })
    }

    /// Loads a file that nobody writes to, as the copy of another process is, without a copy of its own.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub(crate) fn open_copy(path: &Path) -> Result<Self, LoadError> {
        Self::map(path, path)
    }

    /// Maps a library, of which people know the file `path`.
    fn map(file: &Path, path: &Path) -> Result<Self, LoadError> {
        let held = held(file)?;
        // SAFETY: the file is a whole library for this machine; running its constructors is what loading a plugin means.
        let library = unsafe { Library::open(Some(file), RTLD_NOW | RTLD_LOCAL) }
            .map_err(|error| LoadError::System(cause(&error, file, path)))?;
        // SAFETY: the symbol is there; its type is checked below before it is used as a table.
        let table = unsafe { library.get::<*const raw::Plugin>(raw::ENTRY_SYMBOL.as_bytes()) }
            .map_err(|error| LoadError::System(error.to_string()))?
            .into_raw()
            .cast::<raw::Plugin>()
            .cast_const();
        // Never unmapped: whatever came of it may have left threads, thread-locals or hooks behind.
        std::mem::forget(library);
        if held < offset_of!(raw::Plugin, size) as u64 || !table.is_aligned() {
            return Err(read::Refusal::NotAPlugin.into());
        }
        // SAFETY: the symbol has at least the bytes of the head; the version is looked at before anything behind it.
        let ours = unsafe {
            (&raw const (*table).magic).read() == raw::MAGIC
                && (&raw const (*table).abi_major).read() == raw::ABI_MAJOR
        };
        if ours && held < size_of::<raw::Plugin>() as u64 {
            return Err(LoadError::Foreign(format!(
                "its symbol `{}` has {held} bytes, and a plugin's has {}: declare it as the structure of jde.h",
                raw::ENTRY_SYMBOL,
                size_of::<raw::Plugin>()
            )));
        }
        // SAFETY: the symbol has the bytes of a table if it is of our version, else of its head; its library stays mapped.
        let (description, table) = unsafe { (read::plugin(table)?, &*table) };
        Ok(Self {
            description: Arc::new(description),
            path: Some(path.to_owned()),
            table,
            copy: None,
        })
    }

    /// Where another process finds the same code.
    pub(crate) fn code(&self) -> apart::Plugin {
        match self.copy.as_deref() {
            Some(copy) => apart::Plugin::File(copy.path().to_path_buf()),
            None => apart::Plugin::LinkedIn(self.description.name.clone()),
        }
    }

    /// Bytes of its file; 0 if it is linked in.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.copy.as_ref().map_or(0, |copy| copy.length)
    }

    /// Whether its file had exactly that content.
    pub(super) fn is(&self, copy: &PrivateCopy) -> bool {
        self.copy.as_deref().is_some_and(|loaded| loaded.is_like(copy))
    }

    /// Whether both are one library in memory.
    pub(crate) fn is_one_with(&self, other: &Self) -> bool {
        std::ptr::eq(self.table, other.table)
    }

    /// The table of one of its types, by its place in the description.
    #[must_use]
    pub(crate) fn schema(&self, index: usize) -> &'static raw::Schema {
        assert!(
            index < self.description.schemas.len(),
            "the description and the table have the same schemas"
        );
        // SAFETY: `read::plugin` walked this array with this stride and found `schemas.len()` tables.
        unsafe {
            let stride = (*self.table.schemas).size as usize;
            &*self
                .table
                .schemas
                .cast::<u8>()
                .add(index * stride)
                .cast::<raw::Schema>()
        }
    }
}

/// Bytes of the symbol that is a plugin's table, of a library for this machine.
fn held(file: &Path) -> Result<u64, LoadError> {
    let parts = elf::Parts::new(File::open(file)?);
    elf::check(&parts).map_err(LoadError::Foreign)?;
    elf::symbol_size(&parts, raw::ENTRY_SYMBOL).ok_or(LoadError::NoPlugin)
}

/// The system's words, with the name of the private copy replaced by the name the user knows.
fn cause(error: &libloading::Error, copy: &Path, path: &Path) -> String {
    let text = match std::error::Error::source(error) {
        Some(source) => source.to_string(),
        None => error.to_string(),
    };
    let text = text.replace(&copy.display().to_string(), &path.display().to_string());
    match copy.parent() {
        Some(folder) if text.contains("failed to map segment") => {
            format!(
                "{text} (its copy is in {}; if no program may run there, set TMPDIR to a folder where one may)",
                folder.display()
            )
        }
        _ => text,
    }
}
