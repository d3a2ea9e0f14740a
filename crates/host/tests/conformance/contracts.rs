//! Takeovers in an application whose calls take their whole budgets, at pseudo-random moments (R17). Time is
//! counted, so only calls take time, and a contract that is too small is exceeded.

use std::sync::{Arc, Mutex};

use jde_core::{GroupContract, Nanos, contract};
use jde_host::Options;
use jde_host::reload::ReloadOptions;
use jde_loader::LoadedPlugin;
use jde_records::event::Event;
use jde_schema::prelude::*;

use crate::common::{Call, Executor, Io, MS, Rig, Stage, TEST, in_real_time, on_every_executor};

in_real_time!(
    r17_no_takeover_by_a_check_takes_longer_than_its_contract,
    r17_no_takeover_by_a_trigger_takes_longer_than_its_contract,
    r17_no_takeover_that_a_father_decides_takes_longer_than_its_contract,
    r17_no_takeover_by_urgency_takes_longer_than_its_contract,
    r17_no_takeover_in_turns_takes_longer_than_its_contract,
    r17_no_takeover_takes_longer_for_many_others_that_are_inside_calls,
);

mod reloaded {
    use super::*;

    on_every_executor!(r17_a_build_that_gains_a_panel_is_in_the_contract);
}

/// The eye reads what a crowd of other schemas exports, if there is one.
const FAMILY: &str = r#"
    roots = ["father"]
    [schemas.eye]
    type = "test/eye"
    period = "EYE"
    CROWD
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
struct Chance(u64);

impl Chance {
    fn next(&mut self, below: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % below
    }
}

fn spend(io: &Io<'_>, time: Nanos) {
    if let Some(handle) = io.stage.handle() {
        handle.spend(time);
    }
}

/// A child that takes its whole budget, in its check or in its iteration. `ready` computes its precondition
/// from the value read.
fn child(stage: &Stage, name: &str, budget: Nanos, ready: fn(u64) -> Precondition) {
    let mut chance = Chance(budget);
    let mut left = 0;
    stage.play(name, move |call, io| {
        match call {
            Call::Check => {
                // It sees later values only at the next check.
                let seen = io.input().map_or(0.0, |(value, _)| value) as u64;
                let check = [0, budget / 2, budget][chance.next(3) as usize];
                spend(io, check);
                left = budget - check;
                io.ready(ready(seen));
            }
            Call::Iterate => spend(io, left),
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
}

/// Runs both children, their father and the eye that publishes situations. Returns the contract of the
/// children's group, and when situations occurred.
fn run(
    executor: Executor,
    rules: &str,
    trigger: &str,
    eye: &str,
    ready: [fn(u64) -> Precondition; 2],
) -> (Arc<Stage>, GroupContract, Vec<Nanos>) {
    run_among(0, executor, rules, trigger, eye, ready)
}

/// Like [`run`], with `crowd` other schemas that are inside calls nearly all the time.
fn run_among(
    crowd: usize,
    executor: Executor,
    rules: &str,
    trigger: &str,
    eye: &str,
    ready: [fn(u64) -> Precondition; 2],
) -> (Arc<Stage>, GroupContract, Vec<Nanos>) {
    let stage = Stage::new();
    child(&stage, "left", 5 * MS, ready[0]);
    child(&stage, "right", 8 * MS, ready[1]);
    stage.play("father", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.wake("a");
                io.wake("b");
                spend(io, 6 * MS);
            }
            Call::Arbitrate => {
                spend(io, ARBITRATION);
                let left = io.level().is_ready(io.child("a"));
                io.choose(if left { "a" } else { "b" });
            }
            Call::Awake | Call::Sleep | Call::Drop => {}
        }
        Ok(())
    });
    let came = Arc::new(Mutex::new(Vec::new()));
    let comes = Arc::clone(&came);
    let (mut chance, mut count) = (Chance(7), 0);
    stage.play("eye", move |call, io| {
        if call == Call::Iterate {
            count += 1;
            // Never at the same phase of any period.
            spend(io, chance.next(6000) * 1000);
            comes.lock().unwrap().push(io.now());
            io.publish(f64::from(count));
        }
        Ok(())
    });
    let sees = |number| match number {
        _ if number == crowd => String::new(),
        _ => format!("imports = {{ input = \"crowd-{number}.out\" }}\n"),
    };
    let mut body = FAMILY
        .replace("RULES", rules)
        .replace("EYE", eye)
        .replace("CROWD", &sees(0))
        .replace("TRIGGER", trigger);
    for number in 0..crowd {
        body += &format!("[schemas.crowd-{number}]\ntype = \"test/eye\"\nperiod = \"500ms\"\n");
        body += &sees(number + 1);
        stage.play(&format!("crowd-{number}"), |call, io| {
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
    let rig = Rig::start_with(executor, &stage, &body, options);
    let contracts = contract(&rig.handle.application().spec());
    rig.wait();
    let contract = contracts
        .into_iter()
        .find(|contract| contract.name == "father/base");
    let came = came.lock().unwrap().clone();
    (stage, contract.expect("it has members"), came)
}

/// Times and latencies of the takeovers in the children's group. Asserts that there are many and none is
/// late.
fn takeovers(stage: &Stage, contract: &GroupContract) -> Vec<(Nanos, Nanos)> {
    let took = stage.events().into_iter().filter_map(|event| match event {
        Event::TookOver {
            group: 1,
            time,
            latency,
            allowed,
            ..
        } => {
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
    let (stage, contract, _) = run(
        executor,
        "policy = \"priority\"",
        "",
        "61ms",
        [left_or_both, right_or_both],
    );
    takeovers(&stage, &contract);
}

fn r17_no_takeover_by_a_trigger_takes_longer_than_its_contract(executor: Executor) {
    let (stage, contract, _) = run(
        executor,
        "policy = \"priority\"",
        "\"input\"",
        "13ms",
        [left_or_both, right_or_both],
    );
    let worst = takeovers(&stage, &contract)
        .iter()
        .map(|(_, latency)| *latency)
        .max();
    assert!(
        worst > Some(8 * MS + 3 * MS),
        "one check and patience would be enough: {worst:?}"
    );
}

fn r17_no_takeover_that_a_father_decides_takes_longer_than_its_contract(executor: Executor) {
    let rules = "policy = \"father\", budget = \"4ms\"";
    let (stage, contract, _) = run(
        executor,
        rules,
        "\"input\"",
        "13ms",
        [left_or_both, right_or_both],
    );
    let worst = takeovers(&stage, &contract)
        .into_iter()
        .map(|(_, latency)| latency)
        .max();
    let once = 8 * MS + ARBITRATION + 3 * MS;
    assert!(worst > Some(once), "one arbitration would be enough: {worst:?}");
}

fn r17_no_takeover_by_urgency_takes_longer_than_its_contract(executor: Executor) {
    let left = |seen: u64| Precondition::from(true).urgency(if seen.is_multiple_of(2) { 1.0 } else { 3.0 });
    let right = |_| Precondition::from(true).urgency(2.0);
    let (stage, contract, came) = run(
        executor,
        "policy = \"urgency\"",
        "\"input\"",
        "211ms",
        [left, right],
    );
    let paced = contract
        .by_winner
        .as_ref()
        .expect("urgency alone selects nothing")
        .total();
    // The first takeovers may precede the first situation.
    let since_situation = |time| Some(time - came.iter().rfind(|came| **came <= time)?);
    let worst = takeovers(&stage, &contract)
        .into_iter()
        .filter_map(|(time, _)| since_situation(time))
        .max()
        .expect("situations cause takeovers");
    assert!(worst <= paced, "{worst} ns\n{contract}");
    assert!(
        worst > contract.allowed(),
        "the winner's period would not be needed: {worst}\n{contract}"
    );
}

fn r17_no_takeover_in_turns_takes_longer_than_its_contract(executor: Executor) {
    let rules = "policy = \"round-robin\", turn = \"50ms\"";
    let both = |_| true.into();
    let (stage, contract, _) = run(executor, rules, "", "61ms", [both, both]);
    takeovers(&stage, &contract);
}

fn r17_no_takeover_takes_longer_for_many_others_that_are_inside_calls(executor: Executor) {
    let (stage, contract, _) = run_among(
        12,
        executor,
        "policy = \"priority\"",
        "\"input\"",
        "13ms",
        [left_or_both, right_or_both],
    );
    takeovers(&stage, &contract);
}

/// A build of the test's motor schema that has a panel.
#[derive(Describe)]
#[schema(motor, period = "10ms", name = "motor")]
struct Shows {
    /// The number of its stage.
    #[modulation(default = 0, fixed)]
    stage: Modulation<u32>,
}

impl Schema for Shows {
    fn iterate(&mut self, cx: &Context) -> jde_schema::Result {
        Stage::of(self.stage.get(cx)).note(|| String::from("it iterates"));
        Ok(())
    }
}

impl Panel for Shows {
    fn draw(&self, _: &Context, _: &mut Pen) {}
}

static SHOWS: jde_schema::derived::raw::Plugin = jde_schema::plugin!("test", "Shows.", [Shows]);

fn r17_a_build_that_gains_a_panel_is_in_the_contract(executor: Executor) {
    let body = r#"
        roots = ["low"]
        [schemas.low]
        type = "test/motor"
        budget = "4ms"
    "#;
    let stage = Stage::new();
    let mut rig = Rig::start(executor, &stage, body);
    let low = rig.place("low");
    let allowed = |rig: &Rig| rig.handle.snapshot().groups[0].allowed;
    let before = allowed(&rig);
    // A drawing or a gesture may delay both the check and the takeover.
    for (build, panels) in [(&SHOWS, 4), (&TEST, 0)] {
        let build = LoadedPlugin::linked_in(build).expect("its tables are right");
        let how = ReloadOptions {
            probation: 0,
            fresh: true,
        };
        let order = rig.operator().replace(low, &build, how).expect("it fits");
        rig.until(|_| order.outcome().is_some());
        assert_eq!(allowed(&rig), before + panels * 4 * MS);
    }
    rig.stop();
}
