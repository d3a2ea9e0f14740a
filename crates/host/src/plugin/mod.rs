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
pub(crate) use load::Functions;
pub use load::{LoadError, Loaded};
pub use search::{Found, SearchPath};
pub use store::{Builds, Described, MOST_BUILDS, PluginError, Plugins, Renewed};
