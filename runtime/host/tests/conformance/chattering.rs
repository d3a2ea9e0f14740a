//! Groups whose winner changes repeatedly (R4).

use jde_core::GroupId;
use jde_records::event::{Event, Occurrence, What};

use crate::common::{Call, Executor, Scenario, TestApp, on_every_executor};

on_every_executor!(
    r4_chattering_is_reported_at_its_start_and_at_its_end,
    r4_round_robin_turns_are_not_chattering,
    r14_switches_by_operators_are_not_chattering,
);

const TWO: &str = r#"
    roots = ["high", "low"]
    [schemas.high]
    type = "test/motor"
    [schemas.low]
    type = "test/motor"
"#;

fn ready(scenario: &Scenario, name: &str) {
    scenario.on_call(name, |call, io| {
        if call == Call::Check {
            io.ready(true);
        }
        Ok(())
    });
}

fn chattering(event: &Event) -> bool {
    matches!(
        event.what(),
        Some(What::ChatteringStarted { .. } | What::ChatteringEnded { .. })
    )
}

fn r4_chattering_is_reported_at_its_start_and_at_its_end(executor: Executor) {
    let scenario = Scenario::new();
    let mut checks = 0_u64;
    scenario.on_call("high", move |call, io| {
        if call == Call::Check {
            checks += 1;
            // The precondition changes at every third check, and after 60 checks never again.
            io.ready(checks < 60 && checks % 6 < 3);
        }
        Ok(())
    });
    ready(&scenario, "low");
    let mut app = TestApp::start(executor, &scenario, TWO);
    app.until(|app| app.group("roots").chatter.is_some());
    let (high, low) = (app.index("high"), app.index("low"));
    app.until(|app| app.group("roots").chatter.is_none());
    let switch = |event: &Event| matches!(event, Event::Decision(record) if record.changed);
    let all = scenario.count_events(switch) as u64;
    let reported: Vec<_> = scenario.events().into_iter().filter(chattering).collect();
    let [
        Event::Other(Occurrence {
            what:
                What::ChatteringStarted {
                    group: GroupId(0),
                    between,
                    switches: 5,
                },
            time: since,
        }),
        Event::Other(Occurrence {
            what:
                What::ChatteringEnded {
                    group: GroupId(0),
                    since: started,
                    switches,
                    ..
                },
            ..
        }),
    ] = reported.as_slice()
    else {
        panic!("{reported:?}");
    };
    assert_eq!((*between, since), ([Some(high), Some(low)], started));
    assert_eq!(all, *switches + 5);
    app.stop();
}

fn r4_round_robin_turns_are_not_chattering(executor: Executor) {
    let scenario = Scenario::new();
    for name in ["high", "low"] {
        ready(&scenario, name);
    }
    let body = TWO.replace(
        "[schemas.high]",
        "root = { policy = \"round-robin\", turn = \"20ms\" }\n[schemas.high]",
    );
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until(|app| app.group("roots").switches > 20);
    app.stop();
    assert!(!scenario.has_event(chattering));
}

fn r14_switches_by_operators_are_not_chattering(executor: Executor) {
    let scenario = Scenario::new();
    for name in ["high", "low"] {
        ready(&scenario, name);
    }
    let mut app = TestApp::start(executor, &scenario, TWO);
    app.until(|app| app.winner("roots").as_deref() == Some("high"));
    for name in ["low", "high"].repeat(10) {
        let schema = app.index(name);
        app.operator().force(schema).expect("it is awake");
        app.until(|app| app.winner("roots").as_deref() == Some(name));
    }
    assert!(app.group("roots").switches > 20);
    app.stop();
    assert!(!scenario.has_event(chattering));
}
