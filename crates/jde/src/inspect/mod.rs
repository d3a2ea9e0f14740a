//! Describes applications, plugins and plugin folders before anything runs, as text or JSON.

mod application;
mod link;
mod listing;
mod plugin;
mod plugin_data;
pub(crate) mod value;

pub(crate) use application::tell as application;
pub(crate) use listing::Listing;
pub(crate) use plugin::tell as plugin;
pub(crate) use plugin_data::PluginData;
