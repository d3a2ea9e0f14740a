//! Commands of a list have the authority of whoever gives them, and let their driver iterate at once.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use jde_abi::raw;
use jde_app::parse;
use jde_board::Watch;
use jde_core::State;
use jde_host::Options;
use jde_schema::prelude::*;

use crate::common::{Executor, Scenario, TestApp, on_every_executor, plugins};

on_every_executor!(
    r7_a_listed_command_is_in_force_only_for_the_winner,
    r12_a_listed_command_lets_its_driver_iterate_at_once,
);

/// No settings.
#[derive(Clone, Copy, Debug, Default, Value)]
#[repr(C)]
#[value(name = "test_msgs/msg/Nothing")]
struct Nothing {
    padding: Padding<1>,
}

macro_rules! driver {
    ($plugin:ident, $name:ident, $period:literal) => {
        /// Exports the speed of the command in force, and -1 while there is none.
        #[derive(Describe)]
        #[schema(driver, period = $period, name = "arms")]
        struct $name {
            /// What it takes.
            #[commands(default = Nothing { padding: Padding::ZERO }, validity = "1000s")]
            take: Commands<Nothing>,
            /// The speeds.
            #[export]
            speed: Export<f64>,
        }

        impl Schema for $name {
            fn iterate(&mut self, cx: &Context) -> Result {
                let command = self.take[0].get(cx);
                let speed =
                    command.map(|value| f64::from_ne_bytes(value.first_chunk().copied().unwrap_or_default()));
                self.speed.write(cx, speed.unwrap_or(-1.0));
                Ok(())
            }
        }

        static $plugin: raw::Plugin = jde_schema::plugin!("arms", "Takes any commands.", [$name]);
    };
}

driver!(OFTEN, Often, "10ms");
driver!(RARELY, Rarely, "3600s");

const APP: &str = r#"
    roots = ["high", "low"]
    [schemas.arms]
    type = "arms/arms"
    take."/reach" = "reach"
    [schemas.high]
    type = "test/motor"
    actuators = { base = "arms.reach" }
    [schemas.low]
    type = "test/motor"
    actuators = { base = "arms.reach" }
"#;

/// `high` commands 0.3 while it is READY, and `low` 0.1 always.
fn start(executor: Executor, plugin: &'static raw::Plugin, high: &Arc<AtomicBool>) -> TestApp {
    let scenario = Scenario::new();
    scenario.drives("high", high, 0.3);
    scenario.drives("low", &Arc::new(true.into()), 0.1);
    let mut plugins = plugins();
    plugins.link(plugin).expect("its tables are valid");
    let text = crate::common::text(executor, &scenario, APP);
    let application =
        parse(&text, Path::new("apps/test.toml"), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    match TestApp::run(executor, &scenario, application, &plugins, Options::default()) {
        Ok(app) => app,
        Err(error) => panic!("{error}"),
    }
}

/// Lets conditions of `until` be evaluated at each value of the driver: its calls are no entries of the scenario.
fn watch(app: &TestApp) -> Watch {
    let scenario = Arc::clone(&app.scenario);
    let speed = app.handle.board().find("arms.speed").expect("it is exported");
    speed.watch(move || scenario.notify())
}

fn speed(app: &TestApp) -> Option<f64> {
    app.handle.value("arms.speed").expect("it is one")
}

fn r7_a_listed_command_is_in_force_only_for_the_winner(executor: Executor) {
    let high = Arc::new(AtomicBool::new(false));
    let mut app = start(executor, &OFTEN, &high);
    let _watch = watch(&app);
    app.until(|app| speed(app) == Some(0.1));
    high.store(true, Ordering::SeqCst);
    app.until(|app| speed(app) == Some(0.3));
    assert_eq!(app.schema("high").state, State::Winner);
    high.store(false, Ordering::SeqCst);
    app.until(|app| speed(app) == Some(0.1));
    // Nobody is left to command: it is no longer in force, long before its validity ends.
    let (low, operator) = (app.index("low"), app.operator());
    operator.hold_asleep(low).expect("the operator may");
    app.until(|app| speed(app) == Some(-1.0));
    app.stop();
}

fn r12_a_listed_command_lets_its_driver_iterate_at_once(executor: Executor) {
    let high = Arc::new(AtomicBool::new(false));
    let mut app = start(executor, &RARELY, &high);
    let _watch = watch(&app);
    app.until(|app| speed(app) == Some(0.1));
    high.store(true, Ordering::SeqCst);
    app.until(|app| speed(app) == Some(0.3));
    app.stop();
}
