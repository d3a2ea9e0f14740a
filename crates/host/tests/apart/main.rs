//! Schemas in processes of their own: they behave as in the host's process, and the failure of one process
//! affects no other schema.
//!
//! The child processes run this test program: see [`served`].

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

use jde_isolation::serve;
use jde_loader::{Plugins, SearchPath};

/// The entry point of the child processes, which select it by its exact name. It does nothing among the other
/// tests. Selected without a host, it checks that [`serve`] reports that.
#[test]
fn served() {
    if !std::env::args().any(|argument| argument == stage::BY_NAME) {
        return;
    }
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&odd::ODD).expect("the plugin is right");
    let served = serve(&plugins);
    if served.is_ok() {
        // Exit here: standard output belongs to the host, and the test harness must not write to it.
        std::process::exit(0);
    }
    assert!(served.is_err_and(|error| error.to_string().contains("no host")));
}

/// The entry point of the host that a test kills: see [`ends`].
#[test]
fn hosted() {
    ends::host();
}
