//! Groups whose winner changes repeatedly (R4).

use jde_records::event::Event;

use crate::common::{Call, Executor, Rig, Stage, on_every_executor};

on_every_executor!(
    r4_a_group_that_chatters_is_told_of_once_and_when_it_has_calmed_down,
    r4_turns_are_no_chattering,
    r14_what_operators_do_is_no_chattering,
);

const TWO: &str = r#"
    roots = ["high", "low"]
    [schemas.high]
    type = "test/motor"
    [schemas.low]
    type = "test/motor"
"#;

fn ready(stage: &Stage, name: &str) {
    stage.play(name, |call, io| {
        if call == Call::Check {
            io.ready(true);
        }
        Ok(())
    });
}

fn chattering(event: &Event) -> bool {
    matches!(
        event,
        Event::ChatteringStarted { .. } | Event::ChatteringEnded { .. }
    )
}

fn r4_a_group_that_chatters_is_told_of_once_and_when_it_has_calmed_down(executor: Executor) {
    let stage = Stage::new();
    let mut looks = 0_u64;
    stage.play("high", move |call, io| {
        if call == Call::Check {
            looks += 1;
            // It changes at every third check, and then never again.
            io.ready(looks < 60 && looks % 6 < 3);
        }
        Ok(())
    });
    ready(&stage, "low");
    let mut rig = Rig::start(executor, &stage, TWO);
    rig.until(|rig| rig.group("roots").chatter.is_some());
    let (high, low) = (rig.place("high"), rig.place("low"));
    rig.until(|rig| rig.group("roots").chatter.is_none());
    let switch = |event: &Event| matches!(event, Event::Decided(record) if record.changed);
    let all = stage.count_events(switch) as u64;
    let told: Vec<_> = stage.events().into_iter().filter(chattering).collect();
    let [
        Event::ChatteringStarted {
            time: since,
            group: 0,
            between,
            switches: 5,
        },
        Event::ChatteringEnded {
            group: 0,
            since: same,
            switches,
            ..
        },
    ] = told.as_slice()
    else {
        panic!("{told:?}");
    };
    assert_eq!((*between, since), ([Some(high), Some(low)], same));
    assert_eq!(all, *switches + 5);
    rig.stop();
}

fn r4_turns_are_no_chattering(executor: Executor) {
    let stage = Stage::new();
    for name in ["high", "low"] {
        ready(&stage, name);
    }
    let body = TWO.replace(
        "[schemas.high]",
        "root = { policy = \"round-robin\", turn = \"20ms\" }\n[schemas.high]",
    );
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until(|rig| rig.group("roots").switches > 20);
    rig.stop();
    assert!(!stage.told(chattering));
}

fn r14_what_operators_do_is_no_chattering(executor: Executor) {
    let stage = Stage::new();
    for name in ["high", "low"] {
        ready(&stage, name);
    }
    let mut rig = Rig::start(executor, &stage, TWO);
    rig.until(|rig| rig.winner("roots").as_deref() == Some("high"));
    for name in ["low", "high"].repeat(10) {
        let place = rig.place(name);
        rig.operator().force(place).expect("it is awake");
        rig.until(|rig| rig.winner("roots").as_deref() == Some(name));
    }
    assert!(rig.group("roots").switches > 20);
    rig.stop();
    assert!(!stage.told(chattering));
}
