//! Takeovers in an application whose calls take their whole budgets, at pseudo-random moments (R17). Time is
//! counted, so only calls take time, and a contract that is too small is exceeded.

use std::sync::Arc;

use jde_core::{GroupContract, GroupId, Nanos, contract};
use jde_host::Options;
use jde_host::reload::ReloadOptions;
use jde_loader::LoadedPlugin;
use jde_records::event::{Event, Occurrence, What};
use jde_schema::prelude::*;
use parking_lot::Mutex;

use crate::common::{Call, Executor, Io, MS, Scenario, TEST, TestApp, in_real_time, on_every_executor};

in_real_time!(
    r17_no_takeover_by_a_check_takes_longer_than_its_contract,
    r17_no_takeover_by_a_trigger_takes_longer_than_its_contract,
    r17_no_takeover_that_a_father_decides_takes_longer_than_its_contract,
    r17_no_takeover_by_urgency_takes_longer_than_its_contract,
    r17_no_takeover_in_turns_takes_longer_than_its_contract,
    r17_many_other_schemas_inside_calls_do_not_delay_a_takeover,
);

mod reloaded {
    use super::*;

    on_every_executor!(r17_the_contract_includes_the_panel_of_a_new_build);
}

/// The eye reads the exports of extra schemas, if there are any.
const FAMILY: &str = r#"
    roots = ["father"]
    [schemas.eye]
    type = "test/eye"
    period = "EYE"
    EXTRA
    [schemas.father]
    type = "test/motor"
    period = "30ms"
    budget = "6ms"
    children = { a = "left", b = "right" }
    groups.base = { RULES, patience = "3ms" }
    [schemas.left]
    type = "test/motor"
    period = "20ms"
    budget = "5ms"
    imports = { input = "eye.out" }
    triggers = [TRIGGER]
    [schemas.right]
    type = "test/motor"
    period = "35ms"
    budget = "8ms"
    imports = { input = "eye.out" }
    triggers = [TRIGGER]
"#;

/// How long a call of the father's own arbitration may take in the files of these tests.
const ARBITRATION: Nanos = 4 * MS;

/// Pseudo-random numbers, the same in every run (Knuth's MMIX generator).
struct Random(u64);

impl Random {
    fn next(&mut self, below: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % below
    }
}

fn spend(io: &Io<'_>, time: Nanos) {
    if let Some(handle) = io.scenario.handle() {
        handle.spend(time);
    }
}

/// A child that takes its whole budget, in its check or in its iteration. `ready` computes its precondition
/// from the value read.
fn child(scenario: &Scenario, name: &str, budget: Nanos, ready: fn(u64) -> Precondition) {
    let mut random = Random(budget);
    let mut remaining = 0;
    scenario.on_call(name, move |call, io| {
        match call {
            Call::Check => {
                // The child reads later values only at the next check.
                let seen = io.input().map_or(0.0, |(value, _)| value) as u64;
                let check = [0, budget / 2, budget][random.next(3) as usize];
                spend(io, check);
                remaining = budget - check;
                io.ready(ready(seen));
            }
            Call::Iterate => spend(io, remaining),
            _ => {}
        }
        Ok(())
    });
}

/// Runs both children, their father, and the eye, whose values change the preconditions. Returns the contract
/// of the children's group and the times at which the eye published.
fn run(
    executor: Executor,
    rules: &str,
    trigger: &str,
    eye: &str,
    ready: [fn(u64) -> Precondition; 2],
) -> (Arc<Scenario>, GroupContract, Vec<Nanos>) {
    run_with_extra(0, executor, rules, trigger, eye, ready)
}

/// Like [`run`], with `extra` schemas that are inside calls nearly all the time.
fn run_with_extra(
    extra: usize,
    executor: Executor,
    rules: &str,
    trigger: &str,
    eye: &str,
    ready: [fn(u64) -> Precondition; 2],
) -> (Arc<Scenario>, GroupContract, Vec<Nanos>) {
    let scenario = Scenario::new();
    child(&scenario, "left", 5 * MS, ready[0]);
    child(&scenario, "right", 8 * MS, ready[1]);
    scenario.on_call("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.wake("a");
                io.wake("b");
                spend(io, 6 * MS);
            }
            Call::Arbitrate => {
                spend(io, ARBITRATION);
                let left = io.is_ready("a");
                io.choose(if left { "a" } else { "b" });
            }
            _ => {}
        }
        Ok(())
    });
    let published = Arc::new(Mutex::new(Vec::new()));
    let publishes = Arc::clone(&published);
    let (mut random, mut count) = (Random(7), 0);
    scenario.on_call("eye", move |call, io| {
        if call == Call::Iterate {
            count += 1;
            // The phase differs from that of every period.
            spend(io, random.next(6000) * 1000);
            publishes.lock().push(io.now());
            io.publish(f64::from(count));
        }
        Ok(())
    });
    let import = |number| match number {
        _ if number == extra => String::new(),
        _ => format!("imports = {{ input = \"extra-{number}.out\" }}\n"),
    };
    let mut body = FAMILY
        .replace("RULES", rules)
        .replace("EYE", eye)
        .replace("EXTRA", &import(0))
        .replace("TRIGGER", trigger);
    for number in 0..extra {
        body += &format!("[schemas.extra-{number}]\ntype = \"test/eye\"\nperiod = \"500ms\"\n");
        body += &import(number + 1);
        scenario.on_call(&format!("extra-{number}"), |call, io| {
            if call == Call::Iterate {
                spend(io, 450 * MS);
            }
            Ok(())
        });
    }
    let options = Options {
        counted: true,
        limit: Some(8_000 * MS),
        ..Options::default()
    };
    let app = TestApp::start_with(executor, &scenario, &body, options);
    let contracts = contract(&app.handle.application().spec());
    app.wait();
    let contract = contracts
        .into_iter()
        .find(|contract| contract.name == "father/base");
    let published = published.lock().clone();
    (scenario, contract.expect("it has members"), published)
}

/// Times and latencies of the takeovers in the children's group. Asserts that there are many and none is
/// late.
fn takeovers(scenario: &Scenario, contract: &GroupContract) -> Vec<(Nanos, Nanos)> {
    let took = scenario.events().into_iter().filter_map(|event| match event {
        Event::Other(Occurrence {
            time,
            what:
                What::TookOver {
                    group: GroupId(1),
                    latency,
                    allowed,
                    ..
                },
        }) => {
            assert_eq!(allowed, contract.allowed());
            Some((time, latency))
        }
        _ => None,
    });
    let took: Vec<_> = took.collect();
    assert!(took.len() > 20, "only {} takeovers", took.len());
    let worst = took.iter().map(|(_, latency)| *latency).max().unwrap_or_default();
    assert!(worst <= contract.allowed(), "{worst} ns\n{contract}");
    took
}

fn left_or_both(seen: u64) -> Precondition {
    (!seen.is_multiple_of(3)).into()
}

fn right_or_both(seen: u64) -> Precondition {
    (seen % 3 != 1).into()
}

fn r17_no_takeover_by_a_check_takes_longer_than_its_contract(executor: Executor) {
    let (scenario, contract, _) = run(
        executor,
        "policy = \"priority\"",
        "",
        "61ms",
        [left_or_both, right_or_both],
    );
    takeovers(&scenario, &contract);
}

fn r17_no_takeover_by_a_trigger_takes_longer_than_its_contract(executor: Executor) {
    let (scenario, contract, _) = run(
        executor,
        "policy = \"priority\"",
        "\"input\"",
        "13ms",
        [left_or_both, right_or_both],
    );
    let worst = takeovers(&scenario, &contract)
        .iter()
        .map(|(_, latency)| *latency)
        .max();
    assert!(
        worst > Some(8 * MS + 3 * MS),
        "one check and the patience suffice: {worst:?}"
    );
}

fn r17_no_takeover_that_a_father_decides_takes_longer_than_its_contract(executor: Executor) {
    let rules = "policy = \"father\", budget = \"4ms\"";
    let (scenario, contract, _) = run(
        executor,
        rules,
        "\"input\"",
        "13ms",
        [left_or_both, right_or_both],
    );
    let worst = takeovers(&scenario, &contract)
        .into_iter()
        .map(|(_, latency)| latency)
        .max();
    let once = 8 * MS + ARBITRATION + 3 * MS;
    assert!(worst > Some(once), "one arbitration suffices: {worst:?}");
}

fn r17_no_takeover_by_urgency_takes_longer_than_its_contract(executor: Executor) {
    let left = |seen: u64| Precondition::from(true).urgency(if seen.is_multiple_of(2) { 1.0 } else { 3.0 });
    let right = |_| Precondition::from(true).urgency(2.0);
    let (scenario, contract, published) = run(
        executor,
        "policy = \"urgency\"",
        "\"input\"",
        "211ms",
        [left, right],
    );
    let by_winner = contract
        .by_winner
        .as_ref()
        .expect("urgency is evaluated in the winner's period")
        .total();
    // The first takeovers may precede the first value.
    let since_published = |time| Some(time - published.iter().rfind(|published| **published <= time)?);
    let worst = takeovers(&scenario, &contract)
        .into_iter()
        .filter_map(|(time, _)| since_published(time))
        .max()
        .expect("values cause takeovers");
    assert!(worst <= by_winner, "{worst} ns\n{contract}");
    assert!(
        worst > contract.allowed(),
        "the winner's period is not needed: {worst}\n{contract}"
    );
}

fn r17_no_takeover_in_turns_takes_longer_than_its_contract(executor: Executor) {
    let rules = "policy = \"round-robin\", turn = \"50ms\"";
    let both = |_| true.into();
    let (scenario, contract, _) = run(executor, rules, "", "61ms", [both, both]);
    takeovers(&scenario, &contract);
}

fn r17_many_other_schemas_inside_calls_do_not_delay_a_takeover(executor: Executor) {
    let (scenario, contract, _) = run_with_extra(
        12,
        executor,
        "policy = \"priority\"",
        "\"input\"",
        "13ms",
        [left_or_both, right_or_both],
    );
    takeovers(&scenario, &contract);
}

/// A build of the test's motor schema that has a panel.
#[derive(Describe)]
#[schema(motor, period = "10ms", name = "motor")]
struct WithPanel {
    /// The number of the scenario.
    #[modulation(default = 0, fixed)]
    scenario: Modulation<u32>,
}

impl Schema for WithPanel {
    fn iterate(&mut self, cx: &Context) -> jde_schema::Result {
        Scenario::of(self.scenario.get(cx)).record(|| String::from("iterates"));
        Ok(())
    }
}

impl Panel for WithPanel {
    fn draw(&self, _: &Context, _: &mut Pen) {}
}

static WITH_PANEL: jde_schema::derived::raw::Plugin =
    jde_schema::plugin!("test", "The motor schema with a panel.", [WithPanel]);

fn r17_the_contract_includes_the_panel_of_a_new_build(executor: Executor) {
    let body = r#"
        roots = ["low"]
        [schemas.low]
        type = "test/motor"
        budget = "4ms"
    "#;
    let scenario = Scenario::new();
    let mut app = TestApp::start(executor, &scenario, body);
    let low = app.index("low");
    let allowed = |app: &TestApp| app.handle.snapshot().groups[0].allowed;
    let before = allowed(&app);
    // A drawing or a gesture may delay both the check and the takeover.
    for (build, panels) in [(&WITH_PANEL, 4), (&TEST, 0)] {
        let build = LoadedPlugin::linked_in(build).expect("its tables are valid");
        let options = ReloadOptions {
            probation: 0,
            fresh: true,
        };
        let reload = app.operator().replace(low, &build, options).expect("it fits");
        app.until_reloaded(&reload).expect("it takes over");
        assert_eq!(allowed(&app), before + panels * 4 * MS);
    }
    app.stop();
}
