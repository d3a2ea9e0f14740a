//! What happens to a command that a father took over (R7, R9): its children take it over, or it becomes
//! neutral.

use std::sync::atomic::Ordering::SeqCst;

use super::*;

on_every_executor!(
    r7_r9_what_a_father_took_over_is_neutral_when_its_children_do_not_want_to_act,
    r7_what_a_father_took_over_is_neutral_when_a_child_wins_that_commands_something_else,
    r9_who_has_no_authority_does_not_brake_what_another_took_over,
    r7_what_a_father_took_over_is_neutral_when_it_wakes_nobody_who_may_act,
    r7_what_a_father_took_over_is_neutral_when_nobody_awake_below_it_wants_to_act,
);

mod hanging {
    use super::*;

    in_real_time!(r7_what_a_father_took_over_stands_for_the_drivers_validity_alone);
}

fn r7_r9_what_a_father_took_over_is_neutral_when_its_children_do_not_want_to_act(executor: Executor) {
    let stage = Stage::new();
    let first = switch(true);
    stage.drives("first", &first, 0.3);
    leads(&stage, "father", &switch(true));
    let mut rig = Rig::start(executor, &stage, FAMILY);
    rig.until_did("robot velocity 0.3");
    first.store(false, SeqCst);
    rig.until_did("robot velocity 0");
    assert_eq!(rig.winner("roots").as_deref(), Some("father"));
    rig.stop();
}

fn r7_what_a_father_took_over_stands_for_the_drivers_validity_alone(executor: Executor) {
    let stage = Stage::new();
    stage.play("first", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.reach(0.3);
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    // The father has not ended its first iteration.
    let won = switch(false);
    let wins = Arc::clone(&won);
    stage.play("father", move |call, io| {
        match call {
            Call::Check => io.ready(wins.load(SeqCst)),
            Call::Iterate => io.stage.wait_until(|| io.stage.did("robot reach 0")),
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    // A command of a schema with a period of one hour is in force for two; the driver's validity is 50 ms.
    let body = FAMILY.replace(
        "actuators = { base = \"robot.velocity\" }\n    [schemas.father]",
        "period = \"3600s\"\n actuators = { arm = \"robot.reach\" }\n    [schemas.father]\n budget = \"1000s\"",
    );
    let mut rig = Rig::start(executor, &stage, &body);
    rig.until_did("robot reach 0.3");
    won.store(true, SeqCst);
    let robot = rig.place("robot");
    rig.operator().play(robot).expect("it can be played");
    let father = rig.place("father");
    rig.operator().force(father).expect("it can be forced");
    rig.until_did("robot reach 0");
    rig.stop();
}

fn r7_what_a_father_took_over_is_neutral_when_a_child_wins_that_commands_something_else(executor: Executor) {
    let stage = Stage::new();
    let first = switch(true);
    stage.drives("first", &first, 0.3);
    leads(&stage, "father", &switch(true));
    let found = finds(&stage, "right", &switch(true));
    let mut rig = Rig::start(executor, &stage, FAMILY);
    rig.until_did("robot velocity 0.3");
    found.lock().unwrap().clear();
    first.store(false, SeqCst);
    rig.until(|_| !found.lock().unwrap().is_empty());
    assert_eq!(found.lock().unwrap()[0], 0.0);
    rig.stop();
}

fn r9_who_has_no_authority_does_not_brake_what_another_took_over(executor: Executor) {
    let stage = Stage::new();
    let first = switch(true);
    stage.drives("first", &first, 0.3);
    let found = Arc::new(Mutex::new(Vec::new()));
    let (finds, loses) = (Arc::clone(&found), Arc::clone(&first));
    stage.play("father", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            // The father may be the first to win at the start.
            Call::Iterate if !loses.load(SeqCst) => {
                let handle = io.stage.handle().expect("it was opened before");
                let velocity = || {
                    let found: Option<Twist> = handle.value("robot.velocity").expect("it is one");
                    found.map_or(0.0, |twist| twist.linear.x)
                };
                let before = velocity();
                let right = handle.application().instance("right").expect("it is there");
                let operator = handle.operator("ana@laptop");
                // After this the father's group has no winner, and brakes.
                operator.play(right)?;
                operator.hold_asleep(right)?;
                finds.lock().unwrap().push([before, velocity()]);
                io.stage.stir();
            }
            Call::Iterate | Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    let body = FAMILY
        .replace("[\"first\", \"father\"]", "[\"first\", \"father\", \"other\"]")
        .replace(
            "children = { a = \"left\", b = \"right\" }",
            "children = { a = \"left\" }",
        )
        .replace("robot.reach", "robot.velocity")
        .replace("{ arm =", "{ base =");
    let other = r#"
        [schemas.other]
        type = "test/motor"
        children = { a = "right" }
        groups.base = { policy = "priority" }
    "#;
    let mut rig = Rig::start(executor, &stage, &(body + other));
    rig.until_did("robot velocity 0.3");
    first.store(false, SeqCst);
    rig.until(|_| !found.lock().unwrap().is_empty());
    rig.stop();
    assert_eq!(found.lock().unwrap()[0], [0.3, 0.3]);
}

fn r7_what_a_father_took_over_is_neutral_when_it_wakes_nobody_who_may_act(executor: Executor) {
    let stage = Stage::new();
    let first = switch(true);
    stage.drives("first", &first, 0.3);
    let found = finds(&stage, "father", &switch(true));
    let mut rig = Rig::start(executor, &stage, FAMILY);
    rig.until_did("robot velocity 0.3");
    found.lock().unwrap().clear();
    first.store(false, SeqCst);
    rig.until(|_| found.lock().unwrap().len() > 1);
    assert_eq!(found.lock().unwrap()[..2], [0.3, 0.0]);
    rig.until_did("robot velocity 0");
    rig.stop();
}

fn r7_what_a_father_took_over_is_neutral_when_nobody_awake_below_it_wants_to_act(executor: Executor) {
    let stage = Stage::new();
    let first = switch(true);
    stage.drives("first", &first, 0.3);
    // The father's group has braked before the father wins.
    stage.play("left", |call, io| {
        if call == Call::Check {
            io.say("check");
        }
        Ok(())
    });
    let found = finds(&stage, "father", &switch(true));
    let mut rig = Rig::start(executor, &stage, FAMILY);
    rig.until_did("robot velocity 0.3");
    let left = rig.place("left");
    rig.operator().play(left).expect("it can be played");
    rig.until_did("left check");
    found.lock().unwrap().clear();
    first.store(false, SeqCst);
    rig.until(|_| found.lock().unwrap().len() > 1);
    assert_eq!(found.lock().unwrap()[..2], [0.3, 0.0]);
    rig.stop();
}
