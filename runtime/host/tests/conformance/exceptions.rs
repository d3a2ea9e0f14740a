//! What is no `std::exception`, in each call, and destructors that throw.

use std::path::Path;

use jde_app::parse;
use jde_core::Health;
use jde_host::Options;
use jde_loader::SearchPath;
use jde_records::event::{Event, Outcome, What};

use crate::common::{Executor, Scenario, TestApp, c, on_every_executor, plugins_with, text};

on_every_executor!(what_is_no_exception_is_a_fault_in_each_call);

fn what_is_no_exception_is_a_fault_in_each_call(executor: Executor) {
    let folder = tempfile::tempdir().expect("a folder");
    c::build("../cpp/faulty.cpp", &[], &folder.path().join("libfaulty.so"));
    for (number, call) in (1..).zip(["awake", "check", "iterate", "sleep"]) {
        let mut path = SearchPath::default();
        path.push(folder.path(), "of this test");
        let plugins = plugins_with(path);
        let scenario = Scenario::new();
        let body = format!(
            "roots = [\"faulty\"]\n[schemas.faulty]\ntype = \"faulty/faulty\"\ncall = {number}\nrestart = \"never\"\n"
        );
        let body = text(executor, &scenario, &body);
        let application = parse(&body, Path::new("apps/test.toml"), &[], &plugins)
            .unwrap_or_else(|faults| panic!("{faults}"));
        let app = TestApp::run(executor, &scenario, application, &plugins, Options::default());
        let mut app = app.unwrap_or_else(|error| panic!("{error}"));
        if call == "sleep" {
            app.until(|app| app.winner("roots").is_some());
            let faulty = app.index("faulty");
            app.operator().hold_asleep(faulty).expect("it can be stopped");
        }
        // A call that returns nothing has no code that tells a panic.
        let panicked = if call == "sleep" {
            String::new()
        } else {
            format!("panicked in {call}: ")
        };
        let expected = panicked + "it threw something that is not a std::exception";
        let is_fault = |event: &Event| matches!(event.what(), Some(What::HealthChanged { health: Health::Faulted(reason), .. }) if *reason == expected);
        app.until(|app| app.scenario.has_event(is_fault));
        // The destructor throws too.
        assert_eq!(app.stop(), Outcome::Stopped);
    }
}
