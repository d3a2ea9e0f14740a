//! One iteration of a schema from a loaded library in lockstep, all told: the executor, the rules, the call, the variables.

use std::fmt::Write as _;
use std::hint::black_box;

use anyhow::Result;
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{interleave, see};
use jde_paths::Periods;

use crate::loaded;
use crate::scope::Scope;

/// Schemas in the row that hands a value on.
const ROW: usize = 17;
/// What copper-rs 0.9 takes for its example of such a row, compiled in: 0.64 to 0.82 us.
const CATERPILLAR: f64 = 730.0;

/// A schema that perceives, kept awake by one that looks once in an hour.
const PERCEPTIVE: &str = r#"
    roots = ["hub"]
    [schemas.hub]
    type = "bench-000/act"
    period = "3600s"
    imports = { input = "idle.out" }
    [schemas.idle]
    type = "bench-000/idle"
"#;

/// A schema that competes, wins, iterates, and competes again.
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
    let bare: extern "C" fn(*mut u8) -> i32 = black_box(nothing);
    let mut state = 0;
    let [perceives, acts, hands_on, call] = interleave(
        scope.effort(),
        [
            &mut |times| perceptive.pass(times),
            &mut |times| motor.pass(times),
            &mut |times| row.pass(times),
            &mut |times| (0..times).for_each(|_| see(black_box(bare)(&raw mut state))),
        ],
    );
    let above = |what: &str, ours: &jde_measure::pairs::Rounds| {
        Line::beside(
            what,
            Figure::Time(ours.median()),
            "empty C function through a pointer",
            Figure::Time(call.median()),
            Goal::Above(Figure::Time(100.0)),
        )
    };
    Ok(vec![
        above("iteration of a perceptive schema", &perceives),
        above("check, iteration and selection of a motor schema", &acts),
        Line::given(
            format!("{ROW} schemas hand a value on"),
            Figure::Time(hands_on.median()),
            "copper-rs, compiled in",
            Figure::Time(CATERPILLAR),
            Goal::Told,
        ),
    ])
}

/// What a bare call is.
extern "C" fn nothing(_: *mut u8) -> i32 {
    0
}

/// A row of schemas, each of which says what the one before it says.
fn row() -> String {
    let last = ROW - 1;
    let mut text = format!(
        "roots = [\"hub\"]\n[schemas.hub]\ntype = \"bench-000/act\"\nperiod = \"3600s\"\nimports = {{ input = \"s{last}.out\" }}\n\
         [schemas.s0]\ntype = \"bench-000/head\"\n"
    );
    for number in 1..ROW {
        let before = number - 1;
        let _ = writeln!(
            text,
            "[schemas.s{number}]\ntype = \"bench-000/segment\"\nimports = {{ input = \"s{before}.out\" }}"
        );
    }
    text
}
