//! The limits on a schema's process: each limit alone, and the reason that is reported when it is exceeded.

use jde_records::event::Outcome;
use landlock::{ABI, AccessFs, CompatLevel, Compatible, Ruleset, RulesetAttr};

use crate::common::{Executor, Scenario, in_real_time};
use crate::faulty;
use crate::isolated_app::IsolatedApp;

in_real_time!(
    a_process_that_exceeds_its_memory_limit_is_ended,
    a_process_that_exceeds_its_processor_time_limit_is_ended,
);

fn body(limits: &str) -> String {
    format!(
        r#"
        roots = ["high"]
        [schemas.high]
        type = "faulty/faulty"
        isolate = {limits}
        restart = "never"
        "#
    )
}

fn a_process_that_exceeds_its_memory_limit_is_ended(executor: Executor) {
    let scenario = Scenario::new();
    let mut isolated = IsolatedApp::start(executor, &scenario, &body(r#"{ memory = "64 MB" }"#));
    isolated.app.until(|app| app.schema("high").iterations > 0);
    isolated.trouble(faulty::ALLOCATE);
    let reason = isolated.until_failed(1);
    assert!(reason.ends_with("it may use 64.0 MB of memory"), "{reason}");
    assert_eq!(isolated.app.stop(), Outcome::Stopped);
}

fn a_process_that_exceeds_its_processor_time_limit_is_ended(executor: Executor) {
    let scenario = Scenario::new();
    // With this budget the schema counts as hung only after a quarter of an hour, so the processor limit
    // applies first.
    let limits = "{ cpu = \"1s\" }\nbudget = \"100s\"";
    let mut isolated = IsolatedApp::start(executor, &scenario, &body(limits));
    isolated.app.until(|app| app.schema("high").iterations > 0);
    isolated.trouble(faulty::SPIN);
    let reason = isolated.until_failed(1);
    assert!(
        reason.starts_with("its process was killed by SIGXCPU"),
        "{reason}"
    );
    isolated.app.stop();
}

/// Returns the exported result of an attempt under these limits: 1 if it succeeded, -1 if it was refused.
fn tried(limits: &str, trouble: u32) -> f64 {
    let scenario = Scenario::new();
    let mut isolated = IsolatedApp::start(Executor::Lockstep, &scenario, &body(limits));
    isolated.trouble(trouble);
    isolated.app.until(|app| {
        app.handle
            .value::<f64>("high.tried")
            .is_ok_and(|tried| tried.is_some())
    });
    let tried = isolated.number("tried").expect("it was tried");
    isolated.app.stop();
    tried
}

#[test]
fn without_network_there_are_no_sockets() {
    assert_eq!(tried("\"process\"", faulty::SOCKET), 1.0);
    assert_eq!(tried("{ network = false }", faulty::SOCKET), -1.0);
    assert_eq!(tried("{ network = false }", faulty::WRITE), 1.0);
}

#[test]
fn files_that_are_read_only_cannot_be_written() {
    assert_eq!(tried("\"process\"", faulty::WRITE), 1.0);
    // If the kernel does not support the restriction, a log message says so and nothing is refused.
    let rules = Ruleset::default()
        .set_compatibility(CompatLevel::HardRequirement)
        .handle_access(AccessFs::from_write(ABI::V3))
        .and_then(Ruleset::create);
    let refused = if rules.is_ok() { -1.0 } else { 1.0 };
    assert_eq!(tried("{ files = \"read-only\" }", faulty::WRITE), refused);
    assert_eq!(tried("{ files = \"read-only\" }", faulty::SOCKET), 1.0);
}
