//! Schemas in processes of their own: they behave as in the host's process, and the failure of one process
//! affects no other schema.
//!
//! The child processes run this test program: see [`served`].

#[path = "../common/mod.rs"]
mod common;

mod builds;
mod crashes;
mod ends;
mod faulty;
mod in_time;
mod isolated_app;
mod limits;
mod same;

use jde_isolation::{load, serve};
use jde_loader::{Plugins, SearchPath};

/// The entry point of the child processes, which select it by its exact name. It does nothing running the other
/// tests. If it is selected without a host, it checks that [`serve`] reports this.
#[test]
fn served() {
    if !std::env::args().any(|argument| argument == isolated_app::BY_NAME) {
        return;
    }
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&faulty::FAULTY).expect("the plugin is valid");
    let served = serve(|plugin| load(&plugins, plugin));
    if served.is_ok() {
        // Exit here: standard output belongs to the host, and the test harness must not write to it.
        std::process::exit(0);
    }
    assert!(served.is_err_and(|error| error.to_string().contains("no host")));
}

/// The entry point of a child that breaks the protocol: see [`crashes`]. Without a host it does nothing.
#[test]
fn forged() {
    if std::env::args().any(|argument| argument == isolated_app::BY_NAME) {
        drop(crashes::forge());
        std::process::exit(0);
    }
}

/// The entry point of the host that a test kills: see [`ends`].
#[test]
fn hosted() {
    ends::host();
}
