//! Iterations of perceptive schemas. They take no lock of the rules unless somebody witnesses the transactions, and all
//! else is the same in both cases.

use std::sync::Arc;

use jde_core::{Health, State};
use jde_host::Options;
use jde_host::reload::ReloadOptions;
use jde_host::transaction_observer::{ObservedTransaction, TransactionObserver};
use jde_loader::LoadedPlugin;

use super::hangs::blocker;
use crate::common::{Call, Executor, Scenario, TEST, TestApp, on_every_executor};

on_every_executor!(
    a_perceptive_schema_that_an_operator_stops_does_not_iterate_until_its_release,
    a_perceptive_schema_iterates_in_another_build_after_its_reload,
);

mod real_time {
    use super::a_perceptive_schema_that_hangs_iterates_in_a_fresh_instance;

    crate::common::in_real_time!(a_perceptive_schema_that_hangs_iterates_in_a_fresh_instance);
}

const APP: &str = r#"
    roots = ["low"]
    [schemas.eye]
    type = "test/eye"
    restart = { back-off = "5ms", limit = 5 }
    hang = "250ms"
    [schemas.low]
    type = "test/motor"
    imports = { input = "eye.out" }
"#;

/// Sees every transaction, and does nothing.
struct Witness;

impl TransactionObserver for Witness {
    fn on_transaction(&mut self, _: &ObservedTransaction<'_>) {}
}

fn start(executor: Executor, scenario: &Arc<Scenario>, witnessed: bool) -> TestApp {
    let options = Options {
        transaction_observer: witnessed.then(|| Box::new(Witness) as _),
        ..Options::default()
    };
    TestApp::start_with(executor, scenario, APP, options)
}

/// An eye that publishes in each iteration.
fn publishing() -> Arc<Scenario> {
    let scenario = Scenario::new();
    scenario.on_call("eye", |call, io| {
        if call == Call::Iterate {
            io.publish(1.0);
        }
        Ok(())
    });
    scenario.on_call("low", |call, io| {
        if call == Call::Check {
            io.record("check");
        }
        Ok(())
    });
    scenario
}

fn until_more_iterations(app: &mut TestApp) {
    let before = app.scenario.count("eye iterate");
    app.until(|app| app.scenario.count("eye iterate") > before + 3);
}

fn a_perceptive_schema_that_an_operator_stops_does_not_iterate_until_its_release(executor: Executor) {
    for witnessed in [false, true] {
        let mut app = start(executor, &publishing(), witnessed);
        let eye = app.index("eye");
        until_more_iterations(&mut app);
        app.operator().hold_asleep(eye).expect("it can be stopped");
        app.until_line("eye sleep");
        assert_eq!(app.schema("eye").state, State::Slept);
        // The motor schema checks five more times meanwhile.
        let checks = app.scenario.count("low check");
        app.until(|app| app.scenario.count("low check") > checks + 5);
        assert!(app.scenario.last("eye iterate") < app.scenario.last("eye sleep"));
        app.operator().release(eye).expect("it was stopped");
        until_more_iterations(&mut app);
        app.stop();
    }
}

fn a_perceptive_schema_iterates_in_another_build_after_its_reload(executor: Executor) {
    for witnessed in [false, true] {
        let mut app = start(executor, &publishing(), witnessed);
        let eye = app.index("eye");
        until_more_iterations(&mut app);
        let build = LoadedPlugin::linked_in(&TEST).expect("its tables are valid");
        let reload = app.operator().replace(eye, &build, ReloadOptions::default());
        let reload = reload.unwrap_or_else(|reasons| panic!("{reasons:#?}"));
        app.until_reloaded(&reload).expect("it takes over");
        until_more_iterations(&mut app);
        let view = app.schema("eye");
        assert_eq!((view.state, view.health), (State::Winner, Health::Ok));
        assert_eq!(view.reload.map(|reload| reload.reloads), Some(1));
        app.stop();
    }
}

fn a_perceptive_schema_that_hangs_iterates_in_a_fresh_instance(executor: Executor) {
    for witnessed in [false, true] {
        let scenario = Scenario::new();
        let (release, hang) = blocker();
        let mut hang = Some(hang);
        scenario.on_call("eye", move |call, io| {
            if call == Call::Iterate
                && let Some(hang) = hang.take()
            {
                io.then(move |_| hang());
            }
            Ok(())
        });
        let mut app = start(executor, &scenario, witnessed);
        app.until(|app| {
            let view = app.schema("eye");
            (view.faults, view.left, view.health) == (1, 1, Health::Ok)
        });
        until_more_iterations(&mut app);
        release.send(()).expect("the call hangs");
        app.until(|app| app.schema("eye").left == 0 && app.scenario.has_line("eye drop"));
        // The end of the abandoned iteration is not that of its successor's.
        until_more_iterations(&mut app);
        assert_eq!(app.schema("eye").state, State::Winner);
        app.stop();
    }
}
