//! What happens to a command that a father took over (R7, R9): its children take it over, or it becomes
//! neutral.

use std::sync::atomic::Ordering::SeqCst;

use super::*;

on_every_executor!(
    r7_r9_a_command_that_a_father_took_over_is_neutral_when_no_child_is_ready,
    r7_a_command_that_a_father_took_over_is_neutral_when_its_child_commands_another_actuator,
    r9_a_group_without_authority_does_not_brake_a_command_that_another_schema_took_over,
    r7_a_command_that_a_father_took_over_is_neutral_when_it_wakes_no_child,
    r7_a_command_that_a_father_took_over_is_neutral_when_no_awake_child_is_ready,
);

mod hanging {
    use super::*;

    in_real_time!(r7_a_command_that_a_father_took_over_expires_with_the_drivers_validity);
}

fn r7_r9_a_command_that_a_father_took_over_is_neutral_when_no_child_is_ready(executor: Executor) {
    let scenario = Scenario::new();
    let (first, father) = (switch(true), switch(false));
    scenario.drives("first", &first, 0.3);
    wakes_children(&scenario, "father", &father);
    let mut app = TestApp::start(executor, &scenario, FAMILY);
    app.until_line("robot velocity 0.3");
    father.store(true, SeqCst);
    app.until(|app| app.schema("father").state == State::Ready);
    first.store(false, SeqCst);
    app.until_line("robot velocity 0");
    assert_eq!(app.winner("roots").as_deref(), Some("father"));
    app.stop();
}

fn r7_a_command_that_a_father_took_over_expires_with_the_drivers_validity(executor: Executor) {
    let scenario = Scenario::new();
    scenario.on_call("first", |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.reach(0.3);
            }
            _ => {}
        }
        Ok(())
    });
    // The father is still inside its first iteration when the command expires.
    let ready = switch(false);
    let is_ready = Arc::clone(&ready);
    scenario.on_call("father", move |call, io| {
        match call {
            Call::Check => io.ready(is_ready.load(SeqCst)),
            Call::Iterate => io.scenario.wait_until(|| io.scenario.has_line("robot reach 0")),
            _ => {}
        }
        Ok(())
    });
    // A command of a schema with a period of one hour is in force for two; the driver's validity is 50 ms.
    let body = FAMILY.replace(
        "actuators = { base = \"robot.velocity\" }\n    [schemas.father]",
        "period = \"3600s\"\n actuators = { arm = \"robot.reach\" }\n    [schemas.father]\n budget = \"1000s\"",
    );
    let mut app = TestApp::start(executor, &scenario, &body);
    app.until_line("robot reach 0.3");
    ready.store(true, SeqCst);
    let robot = app.index("robot");
    app.operator().play(robot).expect("it can be played");
    let father = app.index("father");
    app.operator().force(father).expect("it can be forced");
    app.until_line("robot reach 0");
    app.stop();
}

fn r7_a_command_that_a_father_took_over_is_neutral_when_its_child_commands_another_actuator(
    executor: Executor,
) {
    let scenario = Scenario::new();
    let (first, father) = (switch(true), switch(false));
    scenario.drives("first", &first, 0.3);
    wakes_children(&scenario, "father", &father);
    let velocities = record_velocity(&scenario, "right", &switch(true));
    let mut app = TestApp::start(executor, &scenario, FAMILY);
    app.until_line("robot velocity 0.3");
    father.store(true, SeqCst);
    app.until(|app| app.schema("father").state == State::Ready);
    first.store(false, SeqCst);
    app.until(|_| !velocities.lock().is_empty());
    assert_eq!(velocities.lock()[0], 0.0);
    app.stop();
}

fn r9_a_group_without_authority_does_not_brake_a_command_that_another_schema_took_over(executor: Executor) {
    let scenario = Scenario::new();
    let (first, father) = (switch(true), switch(false));
    scenario.drives("first", &first, 0.3);
    let velocities = Arc::new(Mutex::new(Vec::new()));
    let (recorder, ready) = (Arc::clone(&velocities), Arc::clone(&father));
    scenario.on_call("father", move |call, io| {
        match call {
            Call::Check => io.ready(ready.load(SeqCst)),
            Call::Iterate => {
                let handle = io.scenario.handle().expect("the application has started");
                let velocity = || {
                    let command: Option<Twist> = handle.value("robot.velocity").expect("it is a command");
                    command.map_or(0.0, |twist| twist.linear.x)
                };
                let before = velocity();
                let right = handle
                    .application()
                    .instance("right")
                    .expect("the instance exists");
                let operator = handle.operator("ana@laptop");
                // After this, the father's group has no winner and brakes.
                operator.play(right)?;
                operator.hold_asleep(right)?;
                recorder.lock().push([before, velocity()]);
                io.scenario.notify();
            }
            _ => {}
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
    let mut app = TestApp::start(executor, &scenario, &(body + other));
    app.until_line("robot velocity 0.3");
    father.store(true, SeqCst);
    app.until(|app| app.schema("father").state == State::Ready);
    first.store(false, SeqCst);
    app.until(|_| !velocities.lock().is_empty());
    app.stop();
    assert_eq!(velocities.lock()[0], [0.3, 0.3]);
}

fn r7_a_command_that_a_father_took_over_is_neutral_when_it_wakes_no_child(executor: Executor) {
    let scenario = Scenario::new();
    let (first, father) = (switch(true), switch(false));
    scenario.drives("first", &first, 0.3);
    let velocities = record_velocity(&scenario, "father", &father);
    let mut app = TestApp::start(executor, &scenario, FAMILY);
    app.until_line("robot velocity 0.3");
    father.store(true, SeqCst);
    app.until(|app| app.schema("father").state == State::Ready);
    first.store(false, SeqCst);
    app.until(|_| velocities.lock().len() > 1);
    assert_eq!(velocities.lock()[..2], [0.3, 0.0]);
    app.until_line("robot velocity 0");
    app.stop();
}

fn r7_a_command_that_a_father_took_over_is_neutral_when_no_awake_child_is_ready(executor: Executor) {
    let scenario = Scenario::new();
    let (first, father) = (switch(true), switch(false));
    scenario.drives("first", &first, 0.3);
    // The father's group has braked before the father wins.
    scenario.on_call("left", |call, io| {
        if call == Call::Check {
            io.record("check");
        }
        Ok(())
    });
    let velocities = record_velocity(&scenario, "father", &father);
    let mut app = TestApp::start(executor, &scenario, FAMILY);
    app.until_line("robot velocity 0.3");
    let left = app.index("left");
    app.operator().play(left).expect("it can be played");
    app.until_line("left check");
    father.store(true, SeqCst);
    app.until(|app| app.schema("father").state == State::Ready);
    first.store(false, SeqCst);
    app.until(|_| velocities.lock().len() > 1);
    assert_eq!(velocities.lock()[..2], [0.3, 0.0]);
    app.stop();
}
