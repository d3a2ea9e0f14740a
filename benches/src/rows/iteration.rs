//! One iteration of a schema from a loaded library in lockstep: the executor, the rules, the call and the
//! variables together.

use std::fmt::Write as _;
use std::hint::black_box;

use anyhow::{Result, ensure};
use jde_bench_copper::{Clock, caterpillar};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{Rounds, interleave, see};
use jde_paths::Periods;

use crate::loaded;
use crate::scope::Scope;

/// The number of schemas in the chain that forwards a value.
const CHAIN: usize = 17;

/// A perceptive schema. Another schema with a period of one hour imports from it and so keeps it awake.
const PERCEPTIVE: &str = r#"
    roots = ["hub"]
    [schemas.hub]
    type = "bench-000/act"
    period = "3600s"
    imports = { input = "idle.out" }
    [schemas.idle]
    type = "bench-000/idle"
"#;

/// A motor schema that competes, wins, iterates, and competes again.
const MOTOR: &str = r#"
    roots = ["act"]
    [schemas.act]
    type = "bench-000/act"
"#;

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let plugins = loaded::plugins(&scope.built);
    let mut perceptive = Periods::of(PERCEPTIVE, &plugins)?;
    let mut motor = Periods::of(MOTOR, &plugins)?;
    let mut row = Periods::of(&row(), &plugins)?;
    forwards(&mut row)?;
    let mut running = caterpillar(Clock::Running)?;
    let mut held = caterpillar(Clock::Held)?;
    let bare: extern "C" fn(*mut u8) -> i32 = black_box(nothing);
    let mut state = 0;
    let [perceives, acts, forwards, running, held, call] = interleave(
        scope.effort(),
        [
            &mut |times| perceptive.pass(times),
            &mut |times| motor.pass(times),
            &mut |times| row.pass(times),
            &mut running,
            &mut held,
            &mut |times| (0..times).for_each(|_| see(black_box(bare)(&raw mut state))),
        ],
    );
    let beside = |what: &str, ours: &Rounds, name: &str, theirs: &Rounds, goal| {
        let line = Line::beside(
            what,
            Figure::Time(ours.median()),
            name,
            Figure::Time(theirs.median()),
            goal,
        );
        line.paired(ours.by(theirs))
    };
    let above = |what, ours| {
        let name = "empty C function through a pointer";
        beside(what, ours, name, &call, Goal::Above(Figure::Time(100.0)))
    };
    let what = format!("{CHAIN} schemas hand a value on");
    Ok(vec![
        above("iteration of a perceptive schema", &perceives),
        above("check, iteration and selection of a motor schema", &acts),
        beside(
            &what,
            &forwards,
            "copper-rs, compiled in",
            &running,
            Goal::Reported,
        ),
        beside(
            &what,
            &forwards,
            "copper-rs, its clock held",
            &held,
            Goal::Reported,
        ),
    ])
}

/// Checks that the last schema's value is the first one's, since the figures would be worthless otherwise.
/// copper-rs checks this in each pass.
fn forwards(row: &mut Periods) -> Result<()> {
    let last = format!("s{}.out", CHAIN - 1);
    let mut before = None;
    for _ in 0..10 {
        row.pass(1);
        let first_value = row.value("s0.out")?;
        let last_value = row.value(&last)?;
        ensure!(
            first_value.is_some() && first_value != before && last_value == first_value,
            "the first exports {first_value:?} after {before:?}, and the last {last_value:?}"
        );
        before = first_value;
    }
    Ok(())
}

/// The empty function that a bare call calls.
extern "C" fn nothing(_: *mut u8) -> i32 {
    0
}

/// An application with a chain of schemas. Each exports the value of the one before.
fn row() -> String {
    let last = CHAIN - 1;
    let mut text = format!(
        "roots = [\"hub\"]\n[schemas.hub]\ntype = \"bench-000/act\"\nperiod = \"3600s\"\nimports = {{ input = \"s{last}.out\" }}\n\
         [schemas.s0]\ntype = \"bench-000/head\"\n"
    );
    for number in 1..CHAIN {
        let before = number - 1;
        let _ = writeln!(
            text,
            "[schemas.s{number}]\ntype = \"bench-000/segment\"\nimports = {{ input = \"s{before}.out\" }}"
        );
    }
    text
}
