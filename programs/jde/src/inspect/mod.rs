//! Describes applications, plugins and plugin folders before anything runs, as text or JSON.

mod application;
mod doc;
mod link;
mod listing;
mod plugin;
mod plugin_data;
pub(crate) mod value;
mod value_type;
mod warnings;

pub(crate) use application::{write as application, write_defaults as defaults};
pub(crate) use doc::first_paragraph;
pub(crate) use listing::PluginListing;
pub(crate) use plugin::write as plugin;
pub(crate) use plugin_data::PluginData;
pub(crate) use value_type::{ValueTypeData, names as value_type_names};
pub(crate) use warnings::warnings;
