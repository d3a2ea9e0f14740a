//! Builds whose ports have other numbers or other names.

use jde_board::value::Value;
use jde_host::reload::ReloadOptions;

use super::{reload, start};
use crate::common::{Executor, on_every_executor};

on_every_executor!(
    ports_are_matched_by_name_when_a_build_numbers_them_otherwise,
    a_modulation_that_a_build_renames_keeps_its_value_and_its_name_for_operators,
);

fn ports_are_matched_by_name_when_a_build_numbers_them_otherwise(executor: Executor) {
    let mut app = start(executor);
    let takeover = reload(&mut app, 13, ReloadOptions::default()).expect("it fits");
    assert_eq!(
        takeover.notes,
        [
            "the child `leg` is new: no schema has its role until the application restarts",
            "the export `steps` is new: no schema reads it until the application restarts",
            "the modulation `speed` has a new default; the running value is kept (`jde set` changes it)",
            "the modulation `more` is new: it has its default until the application restarts",
            "the import `nothing` is new: it stays unbound until the application restarts",
        ]
    );
    app.until_line("counter 13 reads (2.0, 7.0, false, Some(4.0), false)");
    app.until_line("robot velocity 0.25");
    let counter = app.index("counter");
    let operator = app.operator();
    operator
        .modulate(counter, "speed", &Value::Float(6.0))
        .expect("a modulation");
    app.until_line("counter 13 reads (6.0, 7.0, false, Some(4.0), false)");
    assert!(app.handle.board().find("counter.steps").is_none());
    app.stop();
}

fn a_modulation_that_a_build_renames_keeps_its_value_and_its_name_for_operators(executor: Executor) {
    let mut app = start(executor);
    let counter = app.index("counter");
    reload(&mut app, 18, ReloadOptions::default()).expect("it fits");
    app.until_line("counter 18 paces 2");
    app.operator()
        .modulate(counter, "speed", &Value::Float(3.0))
        .expect("the application has started with this name");
    app.until_line("counter 18 paces 3");
    app.stop();
}
