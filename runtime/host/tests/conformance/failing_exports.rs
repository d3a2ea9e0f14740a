//! Exports that operators let fail: what readers then receive, and how it ends (R14).

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};

use jde_core::SchemaId;
use jde_host::SensorFault;
use jde_records::event::{OperatorAction, What};

use crate::common::{Call, Executor, Scenario, TestApp, on_every_executor};

on_every_executor!(
    r14_a_silent_export_has_no_value_until_it_is_repaired,
    r14_a_frozen_export_repeats_its_last_value_with_new_numbers,
    r14_a_noisy_export_is_near_the_true_value,
    r14_a_release_repairs_the_exports_of_a_schema,
    r14_the_end_of_a_lease_repairs_what_its_operator_let_fail,
    r14_the_failure_before_is_in_force_again_when_the_one_of_a_lease_ends,
    r14_an_export_fails_while_its_schema_is_replaced_by_a_fresh_instance,
    r14_failures_that_are_not_possible_are_refused_with_a_reason,
);

const APP: &str = r#"
    roots = ["motor"]
    [schemas.eye]
    type = "test/eye"
    [schemas.motor]
    type = "test/motor"
    imports = { input = "eye.out" }
"#;

/// What the motor schema reads.
#[derive(Default)]
struct Seen {
    value: AtomicU64,
    sequence: AtomicU64,
    absent: AtomicU64,
}

impl Seen {
    fn value(&self) -> f64 {
        f64::from_bits(self.value.load(SeqCst))
    }
}

/// Starts an application whose eye publishes 1, 2, 3 and so on.
fn start(executor: Executor) -> (TestApp, Arc<Seen>) {
    let scenario = Scenario::new();
    let mut published = 0.0;
    scenario.on_call("eye", move |call, io| {
        if call == Call::Iterate {
            published += 1.0;
            io.publish(published);
        }
        Ok(())
    });
    let seen = Arc::new(Seen::default());
    let reader = Arc::clone(&seen);
    scenario.on_call("motor", move |call, io| {
        if call == Call::Check {
            match io.input() {
                Some((value, sequence)) => {
                    reader.value.store(value.to_bits(), SeqCst);
                    reader.sequence.store(sequence, SeqCst);
                }
                None => drop(reader.absent.fetch_add(1, SeqCst)),
            }
        }
        Ok(())
    });
    let mut app = TestApp::start(executor, &scenario, APP);
    app.until(|_| seen.sequence.load(SeqCst) > 3);
    (app, seen)
}

fn fail(app: &TestApp, fault: SensorFault) -> SchemaId {
    let eye = app.index("eye");
    app.operator()
        .fail_export(eye, "out", fault)
        .expect("it is an export");
    eye
}

/// Waits until the motor schema has read values that were published later than now.
fn read_more(app: &mut TestApp, seen: &Seen) {
    let before = seen.sequence.load(SeqCst);
    app.until(|_| seen.sequence.load(SeqCst) > before + 3);
}

fn r14_a_silent_export_has_no_value_until_it_is_repaired(executor: Executor) {
    let (mut app, seen) = start(executor);
    let eye = fail(&app, SensorFault::Silent);
    let before = app.scenario.count("eye iterate");
    app.until(|app| app.scenario.count("eye iterate") > before + 3);
    let absent = seen.absent.load(SeqCst);
    app.until(|_| seen.absent.load(SeqCst) > absent + 3);
    let value = || app.handle.value::<f64>("eye.out").expect("it is an export");
    assert_eq!(value(), None);
    let view = app.schema("eye").operator.expect("it is held");
    assert_eq!((view.kind.word(), view.by.as_str()), ("failing", "ana@laptop"));
    app.operator().repair_export(eye, "out").expect("it fails");
    read_more(&mut app, &seen);
    let reported = |expected: &dyn Fn(&OperatorAction) -> bool| {
        app.scenario.has_event(|event| {
            matches!(event.what(), Some(What::Operator { by, action, .. }) if by == "ana@laptop" && expected(action))
        })
    };
    assert!(reported(
        &|action| matches!(action, OperatorAction::Fail { export, fault, .. } if export == "out" && fault == "silent")
    ));
    assert!(reported(
        &|action| matches!(action, OperatorAction::Repair { export, .. } if export == "out")
    ));
    app.stop();
}

fn r14_a_frozen_export_repeats_its_last_value_with_new_numbers(executor: Executor) {
    let (mut app, seen) = start(executor);
    let eye = fail(&app, SensorFault::Frozen);
    read_more(&mut app, &seen);
    let frozen = seen.value();
    read_more(&mut app, &seen);
    assert_eq!(seen.value(), frozen);
    app.operator().repair_export(eye, "out").expect("it fails");
    app.until(|_| seen.value() > frozen + 3.0);
    app.stop();
}

fn r14_a_noisy_export_is_near_the_true_value(executor: Executor) {
    let (mut app, seen) = start(executor);
    let eye = fail(&app, SensorFault::Noise { sigma: 0.01 });
    read_more(&mut app, &seen);
    for _ in 0..10 {
        read_more(&mut app, &seen);
        let error = seen.value() - seen.value().round();
        assert!(error != 0.0 && error.abs() < 0.1, "{error}");
    }
    app.operator().repair_export(eye, "out").expect("it fails");
    app.until(|_| seen.value() == seen.value().round());
    app.stop();
}

fn r14_a_release_repairs_the_exports_of_a_schema(executor: Executor) {
    let (mut app, seen) = start(executor);
    let eye = fail(&app, SensorFault::Silent);
    app.handle
        .operator("bert")
        .release(eye)
        .expect("it can be released");
    read_more(&mut app, &seen);
    assert_eq!(app.schema("eye").operator, None);
    app.stop();
}

fn r14_the_end_of_a_lease_repairs_what_its_operator_let_fail(executor: Executor) {
    let (mut app, seen) = start(executor);
    let eye = fail(&app, SensorFault::Frozen);
    read_more(&mut app, &seen);
    let frozen = seen.value();
    app.handle.operator("bert").release_own(eye).expect("a schema");
    read_more(&mut app, &seen);
    assert_eq!(seen.value(), frozen, "bert did not let it fail");
    app.operator().release_own(eye).expect("a schema");
    app.until(|_| seen.value() > frozen + 3.0);
    app.stop();
}

fn r14_the_failure_before_is_in_force_again_when_the_one_of_a_lease_ends(executor: Executor) {
    let (mut app, seen) = start(executor);
    let eye = fail(&app, SensorFault::Frozen);
    read_more(&mut app, &seen);
    let frozen = seen.value();
    let lease = app.handle.operator("bert").under_lease();
    lease
        .fail_export(eye, "out", SensorFault::Silent)
        .expect("it is an export");
    assert_eq!(app.handle.value::<f64>("eye.out"), Ok(None));
    lease.release_own(eye).expect("a schema");
    app.until(|app| app.handle.value::<f64>("eye.out") == Ok(Some(frozen)));
    app.stop();
}

fn r14_an_export_fails_while_its_schema_is_replaced_by_a_fresh_instance(executor: Executor) {
    let (mut app, seen) = start(executor);
    fail(&app, SensorFault::Frozen);
    read_more(&mut app, &seen);
    let frozen = seen.value();
    let motor = app.index("motor");
    let eye = app.index("eye");
    app.operator().hold_asleep(motor).expect("it can be stopped");
    app.operator().unload(eye).expect("it can be unloaded");
    app.until_line("eye drop");
    app.operator().load(eye).expect("it is unloaded");
    app.operator().release(motor).expect("it can be released");
    read_more(&mut app, &seen);
    assert_eq!(seen.value(), frozen);
    app.stop();
}

fn r14_failures_that_are_not_possible_are_refused_with_a_reason(executor: Executor) {
    let (app, _) = start(executor);
    let (operator, eye) = (app.operator(), app.index("eye"));
    let blocked = SensorFault::Blocked {
        first: 0,
        last: 1,
        range: 0.1,
    };
    for (result, expected) in [
        (
            operator.fail_export(eye, "in", SensorFault::Silent),
            "no export `in`; it has out",
        ),
        (
            operator.fail_export(eye, "gain", SensorFault::Silent),
            "no export `gain`",
        ),
        (operator.fail_export(eye, "out", blocked), "has no beams"),
        (
            operator.fail_export(SchemaId(99), "out", blocked),
            "no schema number 99",
        ),
        (operator.repair_export(eye, "out"), "`eye.out` does not fail"),
    ] {
        let reason = result.expect_err("it is refused");
        assert!(reason.contains(expected), "{reason}");
    }
    app.stop();
}
