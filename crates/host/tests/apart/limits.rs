//! The limits on a schema's process: each limit alone, and the reason that is reported when it is exceeded.

use jde_records::event::Outcome;
use landlock::{ABI, AccessFs, CompatLevel, Compatible, Ruleset, RulesetAttr};

use crate::common::{Executor, Stage, in_real_time};
use crate::odd;
use crate::stage::Play;

in_real_time!(
    who_takes_more_memory_than_allowed_is_ended,
    who_takes_more_processor_time_than_allowed_is_ended,
);

fn body(limits: &str) -> String {
    format!(
        r#"
        roots = ["high"]
        [schemas.high]
        type = "odd/odd"
        isolate = {limits}
        restart = "never"
        "#
    )
}

fn who_takes_more_memory_than_allowed_is_ended(executor: Executor) {
    let stage = Stage::new();
    let mut play = Play::start(executor, &stage, &body(r#"{ memory = "64 MB" }"#));
    play.rig.until(|rig| rig.see("high").iterations > 0);
    play.trouble(odd::EAT);
    let reason = play.until_failed(1);
    assert!(reason.ends_with("it may use 64.0 MB of memory"), "{reason}");
    assert_eq!(play.rig.stop(), Outcome::Stopped);
}

fn who_takes_more_processor_time_than_allowed_is_ended(executor: Executor) {
    let stage = Stage::new();
    // With this budget the schema counts as hung only after a quarter of an hour, so the processor limit
    // applies first.
    let limits = "{ cpu = \"1s\" }\nbudget = \"100s\"";
    let mut play = Play::start(executor, &stage, &body(limits));
    play.rig.until(|rig| rig.see("high").iterations > 0);
    play.trouble(odd::SPIN);
    let reason = play.until_failed(1);
    assert!(
        reason.starts_with("its process was killed by SIGXCPU"),
        "{reason}"
    );
    play.rig.stop();
}

/// Returns the exported result of an attempt under these limits: 1 if it succeeded, -1 if it was refused.
fn tried(limits: &str, trouble: u32) -> f64 {
    let stage = Stage::new();
    let mut play = Play::start(Executor::Lockstep, &stage, &body(limits));
    play.trouble(trouble);
    play.rig.until(|rig| {
        rig.handle
            .value::<f64>("high.tried")
            .is_ok_and(|tried| tried.is_some())
    });
    let tried = play.number("tried").expect("it was tried");
    play.rig.stop();
    tried
}

#[test]
fn without_network_there_are_no_sockets() {
    assert_eq!(tried("\"process\"", odd::SOCKET), 1.0);
    assert_eq!(tried("{ network = false }", odd::SOCKET), -1.0);
    assert_eq!(tried("{ network = false }", odd::WRITE), 1.0);
}

#[test]
fn files_that_are_read_only_cannot_be_written() {
    assert_eq!(tried("\"process\"", odd::WRITE), 1.0);
    // Where the kernel does not support the restriction, the log says so and nothing is refused.
    let rules = Ruleset::default()
        .set_compatibility(CompatLevel::HardRequirement)
        .handle_access(AccessFs::from_write(ABI::V3))
        .and_then(Ruleset::create);
    let refused = if rules.is_ok() { -1.0 } else { 1.0 };
    assert_eq!(tried("{ files = \"read-only\" }", odd::WRITE), refused);
    assert_eq!(tried("{ files = \"read-only\" }", odd::SOCKET), 1.0);
}
