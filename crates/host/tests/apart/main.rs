//! Schemas in a process of their own: they do what they do anywhere, and whatever becomes of their process, nobody else is hurt.
//!
//! The program that the children run is this one: see [`served`].

#[path = "../common/mod.rs"]
mod common;

mod builds;
mod crashes;
mod ends;
mod in_time;
mod limits;
mod odd;
mod same;
mod stage;

use jde_host::apart::serve;
use jde_host::plugin::{Plugins, SearchPath};

/// What the children of the other tests run. It is called by its name then, and has nothing to do among the others; without a
/// host it says so.
#[test]
fn served() {
    if !std::env::args().any(|argument| argument == stage::BY_NAME) {
        return;
    }
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
fn hosted() {
    ends::host();
}
