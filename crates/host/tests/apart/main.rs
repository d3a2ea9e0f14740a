//! Schemas in a process of their own: they do what they do anywhere, and whatever becomes of their process, nobody else is hurt.
//!
//! The program that the children run is this one: see [`served`].

#[path = "../common/mod.rs"]
mod common;

mod crashes;
mod ends;
mod in_time;
mod limits;
mod odd;
mod same;
mod stage;

use jde_host::apart::serve;
use jde_host::plugin::{Plugins, SearchPath};

/// What the children of the other tests run; by itself it has no host, and says so.
#[test]
#[ignore = "it is called by the other tests"]
fn served() {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&odd::ODD).expect("the plugin is right");
    let served = serve(&plugins);
    if served.is_ok() {
        // The test harness has nothing to add, and standard output is the host's.
        std::process::exit(0);
    }
    assert!(served.is_err_and(|error| error.to_string().contains("no host")));
}

/// The host that a test kills: see [`ends`].
#[test]
#[ignore = "it is called by another test"]
fn hosted() {
    ends::host();
}
