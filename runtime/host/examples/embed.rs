//! Runs an application from a program of one's own, without the executable: loads it, runs it in lockstep, looks at its
//! variables, and says who won how often.
//!
//! ```text
//! cargo build && cargo run -p jde-host --example embed
//! ```
//!
//! prints the targets as they are reached, and ends with something like
//!
//! ```text
//! ended after 214.3 s: Done
//! base: 61 switches, worst takeover 75.0 ms of 100.0 ms allowed
//! ```

use std::path::Path;

use jde_host::{Lockstep, Options};
use jde_loader::{Plugins, SearchPath};
use jde_types::Mission;

const ONE_SECOND: u64 = 1_000_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../apps/safe-navigation.toml"
    ));
    // Examples are built into a folder of their own, beside the plugins'.
    let mut path = SearchPath::usual(Some(file));
    path.push(
        std::env::current_exe()?.with_file_name(".."),
        "beside the examples",
    );
    let plugins = Plugins::new(path);
    let application = jde_app::load(file, &[], &plugins)?;

    let mut running = Lockstep::start(
        application,
        &plugins,
        Options {
            limit: Some(600 * ONE_SECOND),
            ..Options::default()
        },
    )?;
    let handle = running.handle();
    let mut reached = 0;
    let outcome = loop {
        let outcome = running.run_until(handle.now() + ONE_SECOND);
        let mission = handle.value::<Mission>("example.mission")?;
        if let Some(mission) = mission.filter(|mission| mission.reached != reached) {
            reached = mission.reached;
            println!(
                "{:6.1} s: {reached} of {} targets",
                handle.now() as f64 / 1e9,
                mission.total
            );
        }
        if let Some(outcome) = outcome {
            break outcome;
        }
    };
    println!("ended after {:.1} s: {outcome:?}", handle.now() as f64 / 1e9);
    for group in handle.snapshot().groups {
        println!(
            "{}: {} switches, worst takeover {:.1} ms of {:.1} ms allowed",
            group.name,
            group.switches,
            group.worst as f64 / 1e6,
            group.allowed as f64 / 1e6
        );
    }
    Ok(())
}
