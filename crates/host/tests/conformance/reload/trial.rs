//! Builds that fail: before they take over, on trial, and after the trial. The build before continues without
//! informing the level, or the level selects again as for any fault.

use jde_core::Health;
use jde_host::reload::ReloadOptions;
use jde_records::event::Event;

use super::walker::build;
use super::{level_heard, outcome, reload, start, undone};
use crate::common::{Executor, Rig, in_real_time, on_every_executor};

on_every_executor!(
    a_build_that_cannot_take_over_leaves_the_one_before_as_it_was,
    a_build_that_fails_on_trial_gives_way_to_the_one_before_and_is_no_fault,
    a_fault_after_the_trial_is_a_fault,
);

mod hanging {
    use super::*;

    in_real_time!(
        a_build_that_hangs_on_trial_is_given_up_for_the_one_before,
        a_build_that_hangs_while_it_takes_over_is_given_up_too,
        a_hang_after_the_trial_is_followed_by_the_build_that_runs,
        a_build_that_waits_behind_a_call_that_hangs_takes_over_after_it,
    );
}

fn a_build_that_cannot_take_over_leaves_the_one_before_as_it_was(executor: Executor) {
    let mut rig = start(executor);
    let before = rig.stage.events().len();
    for (number, reason) in [
        (4, "it refuses what was remembered: it knows better"),
        (5, "it cannot be made: panicked"),
        (7, "it does not get up"),
    ] {
        let refused = reload(&mut rig, number, ReloadOptions::default()).expect_err("it cannot");
        assert!(refused.starts_with(reason), "{refused}");
        let lines = rig.stage.lines().len();
        rig.until(|rig| {
            rig.stage.lines()[lines..]
                .iter()
                .any(|line| line.starts_with("walker 1 step"))
        });
        assert_eq!(undone(&rig).last(), Some(&refused));
        let view = rig.see("walker").reload.expect("it was tried");
        assert_eq!(
            (view.reloads, view.on_trial, view.undone),
            (0, false, Some(refused))
        );
    }
    assert_eq!(
        level_heard(&rig, before).len(),
        0,
        "{:#?}",
        level_heard(&rig, before)
    );
    assert!(!rig.stage.did("robot velocity 0"), "it never stopped");
    let walked = rig.stage.lines();
    let mut walked: Vec<u32> = walked
        .iter()
        .filter_map(|line| line.strip_prefix("walker 1 step ")?.parse().ok())
        .collect();
    let count = walked.len();
    walked.dedup();
    assert_eq!(walked, (1..=count as u32).collect::<Vec<_>>(), "it counts on");
    rig.stop();
}

fn a_build_that_fails_on_trial_gives_way_to_the_one_before_and_is_no_fault(executor: Executor) {
    for number in [3, 6] {
        let mut rig = start(executor);
        let before = rig.stage.events().len();
        // A failure in the build's first turn is reported as the result of the reload.
        let outcome = reload(&mut rig, number, ReloadOptions::default());
        assert_eq!(outcome.is_ok(), number == 3, "{outcome:?}");
        rig.until(|rig| !undone(rig).is_empty());
        let lines = rig.stage.lines().len();
        rig.until(|rig| {
            rig.stage.lines()[lines..]
                .iter()
                .any(|line| line.starts_with("walker 1 step"))
        });
        assert_eq!(
            level_heard(&rig, before).len(),
            0,
            "{:#?}",
            level_heard(&rig, before)
        );
        assert!(!rig.stage.did("robot velocity 0"), "it never stopped");
        assert_eq!(rig.see("walker").faults, 0);
        let view = rig.see("walker").reload.expect("it was tried");
        assert!(!view.on_trial && view.undone.is_some(), "{view:?}");
        assert!(rig.stage.did(&format!("walker {number} drop")));
        assert!(rig.stage.first("walker 1 sleep") < rig.stage.last("walker 1 awake"));
        rig.stop();
    }
}

fn a_fault_after_the_trial_is_a_fault(executor: Executor) {
    let mut rig = start(executor);
    let how = ReloadOptions {
        probation: 0,
        ..ReloadOptions::default()
    };
    let takeover = reload(&mut rig, 3, how).expect("it fits");
    assert_eq!(takeover.probation, 0);
    rig.until_did("walker 1 drop");
    let walker = rig.place("walker");
    rig.until(|rig| {
        rig.stage.told(|event| {
            matches!(event, Event::HealthChanged { schema, health: Health::Faulted(reason), .. }
                if *schema == walker && reason == "its third step is wrong")
        })
    });
    assert_eq!(undone(&rig), [""; 0]);
    // A restart uses the build in force.
    rig.until(|rig| rig.stage.count("walker 3 awake") > 1);
    rig.stop();
}

/// Runs until an instance of that build, created after the first `since` lines, walks.
fn until_walks(rig: &mut Rig, build: u32, since: usize) {
    rig.until(|rig| {
        let lines = rig.stage.lines().split_off(since);
        let made = lines
            .iter()
            .position(|line| *line == format!("walker {build} awake"));
        made.is_some_and(|made| {
            let step = format!("walker {build} step");
            lines[made..].iter().any(|line| line.starts_with(&step))
        })
    });
}

/// Releases the call that hangs, and waits for the end of its instance.
fn let_go(rig: &mut Rig, build: u32) {
    assert_eq!(rig.see("walker").left, 1);
    assert!(!rig.stage.did(&format!("walker {build} drop")));
    rig.stage.note(|| "let go".to_owned());
    rig.until(|rig| rig.see("walker").left == 0);
    rig.until_did(&format!("walker {build} drop"));
}

fn a_build_that_hangs_on_trial_is_given_up_for_the_one_before(executor: Executor) {
    let mut rig = start(executor);
    reload(&mut rig, 8, ReloadOptions::default()).expect("it fits");
    rig.until_did("walker 8 hangs");
    let walker = rig.place("walker");
    let since = rig.stage.lines().len();
    until_walks(&mut rig, 1, since);
    // Its level selected again, as after any fault.
    assert!(rig.stage.told(|event| {
        matches!(event, Event::HealthChanged { schema, health: Health::Faulted(_), .. } if *schema == walker)
    }));
    let reason = undone(&rig).pop().expect("it was undone");
    assert!(
        reason.starts_with("has not returned from a call for "),
        "{reason}"
    );
    let view = rig.see("walker").reload.expect("it was reloaded");
    assert!(!view.on_trial && view.undone.is_some(), "{view:?}");
    assert!(
        !rig.stage.did("walker 1 drop"),
        "the one that was kept is with the call"
    );
    let_go(&mut rig, 8);
    rig.until_did("walker 1 drop");
    // Another build may take over now.
    reload(&mut rig, 2, ReloadOptions::default()).expect("it fits");
    rig.until_did("walker 2 awake");
    rig.stop();
}

fn a_build_that_hangs_while_it_takes_over_is_given_up_too(executor: Executor) {
    for number in [15, 16] {
        let mut rig = start(executor);
        let since = rig.stage.lines().len();
        let refused = reload(&mut rig, number, ReloadOptions::default()).expect_err("it never has a turn");
        assert!(
            refused.starts_with("has not returned from a call for "),
            "{refused}"
        );
        assert!(rig.stage.did(&format!("walker {number} hangs")));
        until_walks(&mut rig, 1, since);
        assert_eq!(undone(&rig), [refused]);
        assert_eq!(rig.see("walker").faults, 1);
        let_go(&mut rig, number);
        reload(&mut rig, 2, ReloadOptions::default()).expect("it fits");
        rig.until_did("walker 2 awake");
        rig.stop();
    }
}

fn a_hang_after_the_trial_is_followed_by_the_build_that_runs(executor: Executor) {
    let mut rig = start(executor);
    let how = ReloadOptions {
        probation: 0,
        ..ReloadOptions::default()
    };
    reload(&mut rig, 8, how).expect("it fits");
    rig.until_did("walker 8 hangs");
    let since = rig.stage.lines().len();
    until_walks(&mut rig, 8, since);
    assert_eq!(undone(&rig), [""; 0]);
    rig.stage.note(|| "let go".to_owned());
    rig.stop();
}

fn a_build_that_waits_behind_a_call_that_hangs_takes_over_after_it(executor: Executor) {
    let mut rig = start(executor);
    let how = ReloadOptions {
        probation: 0,
        ..ReloadOptions::default()
    };
    reload(&mut rig, 17, how).expect("it fits");
    rig.until_did("walker 17 waits");
    // Both wait for the end of its iteration. It goes to sleep first, and hangs in that call.
    let walker = rig.place("walker");
    let operator = rig.operator();
    operator.hold_asleep(walker).expect("it can be stopped");
    let order = operator.replace(walker, &build(2), how).expect("it fits");
    rig.stage.note(|| "go".to_owned());
    rig.until_did("walker 17 hangs");
    outcome(&mut rig, &order).expect("whoever takes the next turn carries it out");
    operator.release(walker).expect("it was stopped");
    rig.until_did("walker 2 step 1");
    // Another build may take over now.
    reload(&mut rig, 1, how).expect("it fits");
    rig.stage.note(|| "let go".to_owned());
    rig.stop();
}
