//! What there is before anything runs, in words or as JSON: applications, plugins, and where plugins are found.

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
