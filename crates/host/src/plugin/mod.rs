//! Plugins: where they are found, how a file is checked before anything of it runs, and what is loaded.
//!
//! A library is never unmapped: threads, thread-locals and panics may still need its code (docs/decisions/07-private-copies.md).

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
