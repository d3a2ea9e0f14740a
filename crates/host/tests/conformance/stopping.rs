//! Stopping everything by an operator, and releasing it (R14).

use std::sync::{Arc, Mutex, OnceLock, mpsc};
use std::time::Duration;

use jde_core::{SchemaId, State};
use jde_host::transaction_observer::{Transaction, TransactionObserver};
use jde_host::{Handle, Options};
use jde_records::snapshot::HoldKind;
use jde_types::Twist;

use crate::common::{Call, Executor, Rig, Stage, in_real_time, on_every_executor};

on_every_executor!(
    r14_everything_is_stopped_at_once_and_nobody_takes_over_on_the_way,
    r14_a_lease_that_ends_lets_nothing_go_on_that_was_stopped_with_everything,
    r14_to_let_everything_go_on_leaves_what_was_stopped_or_unloaded_by_itself,
);

mod hanging {
    use super::*;

    in_real_time!(
        r14_who_is_inside_an_iteration_commands_nothing_more_when_everything_is_stopped,
        r14_who_is_let_go_on_inside_an_iteration_commands_again_in_the_next,
        r14_who_stays_stopped_inside_an_iteration_commands_nothing_when_another_is_let_go_on,
        r14_operators_who_stop_and_release_against_each_other_leave_the_board_as_the_rules_have_it,
    );
}

fn r14_a_lease_that_ends_lets_nothing_go_on_that_was_stopped_with_everything(executor: Executor) {
    let stage = Stage::new();
    stage.drives("high", &Arc::new(true.into()), 0.3);
    let body = r#"
        roots = ["high"]
        [schemas.robot]
        type = "test/robot"
        [schemas.high]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
    "#;
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("robot velocity 0.3");
    let high = rig.place("high");
    let operator = rig.operator();
    operator.force(high).expect("it is awake");
    operator.stop_all().expect("nothing keeps it from that");
    // The end of the lease of `force` does the same.
    operator.release_own(high).expect("nothing keeps it from that");
    rig.until_did("robot sleep");
    let hold = rig.see("high").operator.map(|hold| hold.kind);
    assert_eq!(
        (rig.see("high").state, hold),
        (State::Slept, Some(HoldKind::Stopped))
    );
    // Nor does the end of the lease of an operator that stopped it individually.
    operator.hold_asleep(high).expect("nothing keeps it from that");
    operator.release_own(high).expect("nothing keeps it from that");
    assert_eq!(rig.see("high").state, State::Slept);
    let before = stage.count("high iterate");
    operator.release_all().expect("nothing keeps it from that");
    rig.until(|rig| rig.stage.count("high iterate") > before);
    rig.stop();
}

fn r14_to_let_everything_go_on_leaves_what_was_stopped_or_unloaded_by_itself(executor: Executor) {
    let stage = Stage::new();
    let body = r#"
        roots = ["before", "since", "gone", "free"]
        [schemas.before]
        type = "test/motor"
        [schemas.since]
        type = "test/motor"
        [schemas.gone]
        type = "test/motor"
        [schemas.free]
        type = "test/motor"
    "#;
    stage.drives("free", &Arc::new(true.into()), 0.0);
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("free iterate");
    let [before, since, gone] = ["before", "since", "gone"].map(|name| rig.place(name));
    let (ana, ben) = (rig.operator(), rig.handle.operator("ben@base"));
    ana.hold_asleep(before).expect("nothing keeps it from that");
    ana.unload(gone).expect("nobody needs it");
    rig.until_did("gone drop");
    ben.stop_all().expect("nothing keeps it from that");
    ana.hold_asleep(since).expect("nothing keeps it from that");
    rig.until_did("free sleep");
    let holds = |rig: &Rig| {
        ["before", "since", "gone", "free"].map(|name| {
            let hold = rig.see(name).operator;
            hold.map(|hold| (hold.kind, hold.by, hold.with_everything))
        })
    };
    let by = |who: &str, with_everything| Some((HoldKind::Stopped, who.to_owned(), with_everything));
    let unloaded = Some((HoldKind::Unloaded, "ana@laptop".to_owned(), true));
    let all = by("ben@base", true);
    assert_eq!(holds(&rig), [all.clone(), all.clone(), unloaded, all]);

    let iterated = stage.count("free iterate");
    ben.release_all().expect("nothing keeps it from that");
    rig.until(|rig| rig.stage.count("free iterate") > iterated);
    let unloaded = Some((HoldKind::Unloaded, "ana@laptop".to_owned(), false));
    let ana_s = by("ana@laptop", false);
    assert_eq!(holds(&rig), [ana_s.clone(), ana_s, unloaded, None]);
    for name in ["before", "since", "gone"] {
        assert_eq!(rig.see(name).state, State::Slept, "{name}");
    }

    // A schema that is loaded while everything is stopped stays stopped until everything is released.
    ben.stop_all().expect("nothing keeps it from that");
    rig.until_did("free sleep");
    ana.load(gone).expect("it was unloaded");
    ana.release_own(before).expect("it was stopped");
    assert_eq!(
        ["before", "gone"].map(|name| rig.see(name).state),
        [State::Slept; 2]
    );
    ben.release_all().expect("nothing keeps it from that");
    for name in ["before", "gone"] {
        assert_ne!(rig.see(name).state, State::Slept, "{name}");
    }
    rig.stop();
}

fn r14_everything_is_stopped_at_once_and_nobody_takes_over_on_the_way(executor: Executor) {
    let stage = Stage::new();
    stage.drives("high", &Arc::new(true.into()), 0.3);
    stage.drives("father", &Arc::new(true.into()), 0.2);
    // Even where the last command would be held (R9).
    let body = r#"
        roots = ["high", "father"]
        root = { absence = "hold", hold = "1000s" }
        [schemas.robot]
        type = "test/robot"
        [schemas.high]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
        [schemas.father]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
    "#;
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("robot velocity 0.3");
    let father = stage.count("father iterate");
    rig.operator().stop_all().expect("nothing keeps it from that");
    rig.until(|rig| rig.winner("roots").is_none());
    assert_eq!(velocity(&rig), Some(Twist::ZERO));
    rig.until_did("robot sleep");
    for root in ["high", "father"] {
        let view = rig.see(root);
        let hold = view.operator.expect("it is held");
        assert_eq!(
            (view.state, hold.kind, hold.by.as_str()),
            (State::Slept, HoldKind::Stopped, "ana@laptop")
        );
    }
    assert_eq!(
        stage.count("father iterate"),
        father,
        "nobody takes over on the way"
    );
    let before = stage.count("high iterate");
    rig.operator().release_all().expect("nothing keeps it from that");
    rig.until(|rig| rig.stage.count("high iterate") > before);
    assert_eq!(rig.see("father").operator, None);
    rig.stop();
}

/// A winner that stays inside its first iteration until the sender is dropped, and then commands once more.
/// The patience is so long that neither does the call count as hung, nor does R1 take the authority away.
fn slow(executor: Executor) -> (Rig, mpsc::Sender<()>) {
    let stage = Stage::new();
    let (release, held) = mpsc::channel::<()>();
    stage.play("high", move |call, io| {
        match call {
            Call::Check => io.ready(true),
            Call::Iterate => {
                io.command(0.3);
                // An error means that the sender was dropped.
                let _ = held.recv();
                let outcome = io.command(0.4);
                io.say(format!("then {outcome:?}"));
            }
            Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
        }
        Ok(())
    });
    // By R9 the last command would be in force for 1000 s.
    let body = r#"
        roots = ["high", "low"]
        root = { absence = "hold", hold = "1000s", patience = "1000s" }
        [schemas.robot]
        type = "test/robot"
        [schemas.high]
        type = "test/motor"
        budget = "1000s"
        actuators = { base = "robot.velocity" }
        [schemas.low]
        type = "test/motor"
        actuators = { base = "robot.velocity" }
    "#;
    let mut rig = Rig::start(executor, &stage, body);
    rig.until_did("robot velocity 0.3");
    (rig, release)
}

fn velocity(rig: &Rig) -> Option<Twist> {
    rig.handle.value("robot.velocity").expect("it is one")
}

fn r14_who_is_inside_an_iteration_commands_nothing_more_when_everything_is_stopped(executor: Executor) {
    let (mut rig, release) = slow(executor);
    rig.operator().stop_all().expect("nothing keeps it from that");
    assert_eq!(velocity(&rig), Some(Twist::ZERO));
    drop(release);
    rig.until_did("high then Refused");
    rig.until_did("high sleep");
    rig.until_did("robot sleep");
    assert_eq!(velocity(&rig), Some(Twist::ZERO));
    assert_eq!(rig.winner("roots"), None);
    rig.stop();
}

fn r14_who_is_let_go_on_inside_an_iteration_commands_again_in_the_next(executor: Executor) {
    let (mut rig, release) = slow(executor);
    rig.operator().stop_all().expect("nothing keeps it from that");
    rig.operator().release_all().expect("nothing keeps it from that");
    drop(release);
    rig.until_did("high then Refused");
    rig.until_did("high then Accepted");
    assert!(rig.stage.first("high then Refused") < rig.stage.first("high then Accepted"));
    rig.until_did("robot velocity 0.4");
    rig.stop();
}

fn r14_who_stays_stopped_inside_an_iteration_commands_nothing_when_another_is_let_go_on(executor: Executor) {
    let (mut rig, release) = slow(executor);
    rig.operator().stop_all().expect("nothing keeps it from that");
    let low = rig.place("low");
    rig.operator().release(low).expect("it was stopped");
    drop(release);
    rig.until_did("high then Refused");
    rig.until_did("high sleep");
    assert_eq!(velocity(&rig), Some(Twist::ZERO));
    rig.stop();
}

/// Compares the authority by the rules with that on the board, after each transaction.
struct Agreement {
    handle: Arc<OnceLock<Handle>>,
    broken: Arc<Mutex<Option<String>>>,
}

impl TransactionObserver for Agreement {
    fn on_transaction(&mut self, seen: &Transaction<'_>) {
        let Some(handle) = self.handle.get() else { return };
        let command = handle.board().get("robot.velocity").expect("a command");
        for name in ["high", "low"] {
            let place = handle.application().instance(name).expect("it is there") as u32;
            let rules = seen.hierarchy.has_authority(SchemaId(place));
            if rules != command.has_grant(place) {
                let broken = format!("{name}: {rules} by the rules alone, after {:?}", seen.effects);
                self.broken.lock().unwrap().get_or_insert(broken);
            }
        }
    }
}

fn r14_operators_who_stop_and_release_against_each_other_leave_the_board_as_the_rules_have_it(
    executor: Executor,
) {
    /// Orders of each operator, enough that they interleave in every way.
    const ORDERS: usize = 300;
    let stage = Stage::quiet();
    stage.drives("high", &Arc::new(true.into()), 0.3);
    stage.drives("low", &Arc::new(true.into()), 0.2);
    let (handle, broken) = (Arc::new(OnceLock::new()), Arc::new(Mutex::new(None)));
    let options = Options {
        transaction_observer: Some(Box::new(Agreement {
            handle: Arc::clone(&handle),
            broken: Arc::clone(&broken),
        })),
        ..Options::default()
    };
    let body = r#"
        roots = ["high", "low"]
        root = { absence = "hold", hold = "1000s" }
        [schemas.robot]
        type = "test/robot"
        [schemas.high]
        type = "test/motor"
        period = "1ms"
        actuators = { base = "robot.velocity" }
        [schemas.low]
        type = "test/motor"
        period = "1ms"
        actuators = { base = "robot.velocity" }
    "#;
    let rig = Rig::start_with(executor, &stage, body, options);
    assert!(handle.set(rig.handle.clone()).is_ok());
    let [high, low] = ["high", "low"].map(|name| rig.place(name));
    std::thread::scope(|scope| {
        for act in 0..4 {
            let operator = rig.handle.operator(&format!("operator {act}"));
            scope.spawn(move || {
                for _ in 0..ORDERS {
                    let done = match act {
                        0 => operator.stop_all(),
                        1 => operator.release_all(),
                        2 => operator.play(high),
                        _ => operator.release(low),
                    };
                    done.expect("nothing keeps it from that");
                }
            });
        }
    });
    assert_eq!(*broken.lock().unwrap(), None);
    // Whatever order was last, the application can be released, and then commands.
    rig.operator().release_all().expect("nothing keeps it from that");
    let command = rig.handle.board().get("robot.velocity").expect("a command");
    while rig.winner("roots").as_deref() != Some("high") || command.status(0).last_writer != Some(high as u32)
    {
        command.wait_newer(command.newest(), Duration::from_millis(10));
    }
    assert_eq!(*broken.lock().unwrap(), None);
    rig.stop();
}
