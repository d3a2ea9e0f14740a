//! Plugins: the search for their files, the checks of a file before any of its code runs, and loading.
//!
//! A library is never unmapped: threads, thread-locals and panics may still need its code
//! (docs/decisions/07-private-copies.md).

mod copy;
mod elf;
mod inspect;
mod load;
mod search;
mod store;

pub use inspect::serve as serve_inspections;
pub(crate) use load::SchemaFunctions;
pub use load::{LoadError, LoadedPlugin};
pub use search::{PluginFile, SearchPath};
pub use store::{DescribedPlugin, MAX_BUILDS, PluginError, Plugins, RefreshedPlugin};
