//! Plugins: the search for their files, the checks of a file before any of its code runs, loading, and the
//! calls of a schema's functions in this process.
//!
//! A library is never unmapped: threads, thread-locals and panics may still need its code
//! (docs/decisions/07-private-copies.md).

mod aligned;
pub mod build;
mod copy;
mod elf;
mod forked;
mod inspector;
pub mod instance;
mod judge;
mod load;
pub mod location;
pub mod modules;
pub mod python;
mod search;
mod store;

pub use aligned::AlignedBytes;
pub use inspector::Inspect;
pub use judge::{Judge, Judgement};
pub use load::{LoadError, LoadedPlugin, SchemaFunctions};
pub use location::PluginLocation;
pub use search::{PluginFile, SearchPath};
pub use store::{DescribedPlugin, MAX_BUILDS, PluginError, Plugins, RefreshedPlugin};
