//! The delivered application, whose world an operator changes while it runs, on every clock.

use std::path::Path;
use std::time::Duration;

use jde_app::Application;
use jde_board::value::Value;
use jde_host::{Handle, Lockstep, Options, Running};
use jde_loader::Plugins;
use jde_types::{Scenery, Truth};
use jde_watchdog::{DEFAULT_LIMIT, Watchdog};

use crate::delivered::{self, ROOT, SECOND};

const CLOSED: &str = "[{ add = { name = 'door', center = [10, 3], size = [1, 0.1] } }, \
    { place = { x = 10, y = 4, heading_deg = 0 } }]";

fn application(plugins: &Plugins) -> Application {
    let file = Path::new(ROOT).join("apps/safe-navigation.toml");
    jde_app::load(&file, &[], plugins).unwrap_or_else(|faults| panic!("{faults}"))
}

fn edit(handle: &Handle, text: &str) {
    let pioneer = handle.application().instance("pioneer");
    let pioneer = pioneer.expect("it is in the application");
    let text = Value::Text(text.to_owned());
    let written = handle.operator("ana").modulate(pioneer, "edit", &text);
    written.expect("it is a modulation");
}

fn has_door(handle: &Handle) -> bool {
    let scenery: Option<Scenery> = handle.value("pioneer.scenery").expect("it is an export");
    scenery.is_some_and(|scenery| scenery.things.iter().any(|thing| thing.name.as_str() == "door"))
}

fn at(handle: &Handle) -> (f64, f64) {
    let truth: Option<Truth> = handle.value("pioneer.truth").expect("it is an export");
    let truth = truth.expect("it was published");
    (truth.pose.x, truth.pose.y)
}

#[test]
fn an_operator_changes_the_world_of_a_drive_in_lockstep() {
    let plugins = delivered::plugins();
    let mut running = Lockstep::start(application(&plugins), &plugins, Options::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let handle = running.handle();
    running.run_until(2 * SECOND);
    edit(&handle, CLOSED);
    running.run_until(2 * SECOND + SECOND / 20);
    assert!(has_door(&handle));
    assert_eq!(at(&handle), (10.0, 4.0));
    edit(&handle, "{ remove = 'door' }");
    running.run_until(3 * SECOND);
    assert!(!has_door(&handle));
}

#[test]
fn an_operator_changes_the_world_of_a_drive_in_real_time() {
    let _watchdog = Watchdog::new(DEFAULT_LIMIT, || String::from("waiting for the door"));
    let plugins = delivered::plugins();
    let running = Running::start(application(&plugins), &plugins, Options::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let handle = running.handle();
    let scenery = handle.board().get("pioneer.scenery").expect("it is an export");
    for (text, closed) in [(CLOSED, true), ("{ remove = 'door' }", false)] {
        edit(&handle, text);
        while has_door(&handle) != closed {
            scenery.wait_newer(scenery.newest(), Duration::from_millis(100));
        }
    }
}
