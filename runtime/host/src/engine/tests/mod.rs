//! The effects of transactions as executors, writers of variables and observers see them.

mod decisions;

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock, Weak, mpsc};

use jde_app::{InstancePort, RoleId, parse};
use jde_board::Variable;
use jde_core::{Check, GroupId, Health, Nanos, SchemaId};
use jde_loader::{Plugins, SearchPath};
use jde_records::event::{Event, Observer, Occurrence, What};
use jde_schema::derived::raw;
use jde_schema::prelude::*;
use jde_watchdog::Watchdog;

use super::{Engine, Notifier, Signal};
use crate::clock::Clock;
use crate::inbox::Inbox;
use crate::prepare::original_build;
use crate::runner::Runner;

/// A motor schema that does nothing. The tests report its checks.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Act {}

impl Schema for Act {
    fn iterate(&mut self, _: &Context) -> jde_schema::Result {
        Ok(())
    }
}

/// Reports the progress of its mission.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Report {
    /// The progress.
    #[export]
    mission: Export<Mission>,
}

impl Schema for Report {
    fn check(&mut self, cx: &Context) -> jde_schema::Result<Precondition> {
        self.mission.write(cx, Mission::default());
        Ok(true.into())
    }

    fn iterate(&mut self, _: &Context) -> jde_schema::Result {
        Ok(())
    }
}

/// Arbitrates between two children.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Lead {
    #[child(group = "base")]
    first: Child,
    #[child(group = "base")]
    second: Child,
}

impl Schema for Lead {
    fn iterate(&mut self, cx: &Context) -> jde_schema::Result {
        self.first.wake(cx);
        self.second.wake(cx);
        Ok(())
    }
}

impl Arbitrate for Lead {
    fn arbitrate(&mut self, _: &Context, _: &Level) -> jde_schema::Result<Verdict> {
        Ok(Verdict::choose(&self.second, "as ever"))
    }
}

/// Has a command.
#[derive(Describe)]
#[schema(driver, period = "10ms")]
struct Base {
    /// The speed.
    #[command(neutral = Twist::ZERO, validity = "1000s")]
    #[expect(dead_code, reason = "the test writes it")]
    velocity: Command<Twist>,
}

impl Schema for Base {
    fn iterate(&mut self, _: &Context) -> jde_schema::Result {
        Ok(())
    }
}

/// Commands a base.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Drive {
    /// The base.
    #[actuator]
    #[expect(dead_code, reason = "the test writes it")]
    base: Actuator<Twist>,
}

impl Schema for Drive {
    fn iterate(&mut self, _: &Context) -> jde_schema::Result {
        Ok(())
    }
}

static PLUGIN: raw::Plugin = jde_schema::plugin!(
    "engine-tests",
    "Two that compete, one that reports, a father, a base and one that drives it.",
    [Act, Base, Drive, Lead, Report]
);

const TWO: &str = r#"
    roots = ["first", "second"]
    [schemas.first]
    type = "engine-tests/act"
    [schemas.second]
    type = "engine-tests/act"
"#;

/// The first instance of each application.
const FIRST: SchemaId = SchemaId(0);

/// Records all notifications, and checks at each whether the rules are unlocked.
#[derive(Default)]
struct CountingNotifier {
    engine: OnceLock<Weak<Engine>>,
    posted: AtomicUsize,
    called: AtomicUsize,
    alarms: AtomicUsize,
}

impl CountingNotifier {
    fn note(&self, count: &AtomicUsize) {
        let engine = self.engine.get().and_then(Weak::upgrade).unwrap();
        assert!(engine.rules.is_unlocked(), "called under the rules' lock");
        count.fetch_add(1, Ordering::Relaxed);
    }
}

impl Notifier for CountingNotifier {
    fn post(&self, _: SchemaId, signal: Signal) -> bool {
        let engine = self.engine.get().and_then(Weak::upgrade).unwrap();
        let is_alone = matches!(signal, Signal::Replaced) && engine.rules.is_unlocked();
        assert!(!is_alone, "another transaction may come between a fault and this");
        self.posted.fetch_add(1, Ordering::Relaxed);
        true
    }

    fn notify(&self, _: SchemaId) {
        self.note(&self.called);
    }

    fn set_timer(&self, _: Option<Nanos>) -> bool {
        true
    }

    fn notify_timer(&self) {
        self.note(&self.alarms);
    }
}

/// An engine of that application. Its clock stands still.
fn engine(text: &str, observers: Vec<Box<dyn Observer>>) -> (Arc<Engine>, Arc<CountingNotifier>) {
    let (engine, notifier, _) = engine_and_runner(text, observers);
    (engine, notifier)
}

/// The same, with the runner of the first instance.
fn engine_and_runner(
    text: &str,
    observers: Vec<Box<dyn Observer>>,
) -> (Arc<Engine>, Arc<CountingNotifier>, Runner) {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&PLUGIN).unwrap();
    let application = parse(text, Path::new("test.toml"), &[], &plugins).unwrap();
    let (engine, ports) = Engine::new(
        application,
        Clock::new_virtual(),
        observers,
        None,
        None,
        None,
        Default::default(),
    )
    .unwrap();
    let counting = Arc::new(CountingNotifier::default());
    counting.engine.set(Arc::downgrade(&engine)).unwrap();
    let notifier: Arc<dyn Notifier> = Arc::clone(&counting) as _;
    engine.attach(&notifier);
    let build = original_build(
        &engine.application,
        &plugins,
        &engine.application.instances[FIRST],
    )
    .unwrap();
    let first = ports.into_iter().next().unwrap();
    let runner = Runner::new(&engine, FIRST, build, first);
    (engine, counting, runner)
}

#[test]
fn threads_are_notified_after_the_rules_are_unlocked() {
    let (engine, notifier) = engine(TWO, vec![]);
    let mut before = [0; 2];
    // The number of notifications and alarms since the last call.
    let mut since = || {
        let [posted, called, alarms] =
            [&notifier.posted, &notifier.called, &notifier.alarms].map(|count| count.load(Ordering::Relaxed));
        assert_eq!(posted, called, "each instance with a signal is notified");
        let now = [called, alarms];
        let grown = [0, 1].map(|place| now[place] - before[place]);
        before = now;
        grown
    };
    let report_ready = |instance| {
        let check = Check {
            ready: true,
            urgency: 0.0,
            cause: 0,
        };
        engine.rules.report_check(instance, check);
    };

    engine.rules.start();
    assert_eq!(since()[0], 2, "both are awake");
    report_ready(SchemaId(1));
    assert_eq!(since()[0], 1, "it is the only one that wants");
    let (may, _) = engine.rules.request_iteration(SchemaId(1));
    assert!(may);
    report_ready(FIRST);
    assert_eq!(since(), [0, 1], "it has to wait, but not for ever");
    engine.rules.report_iteration_end(SchemaId(1));
    assert_eq!(since()[0], 1, "it wins");
    engine.report_fault(FIRST, String::from("it broke"));
    assert!(since()[1] > 0, "it is to be restarted");
    engine.clock.advance_to(3_600_000_000_000);
    engine.tick();
    assert!(since()[0] > 0, "it is");
}

#[test]
fn r4_a_father_that_had_no_chance_to_begin_is_overruled_and_not_blamed() {
    const FAMILY: &str = r#"
        roots = ["father"]
        [schemas.father]
        type = "engine-tests/lead"
        children = { first = "left", second = "right" }
        [schemas.left]
        type = "engine-tests/act"
        [schemas.right]
        type = "engine-tests/act"
    "#;
    const MS: Nanos = 1_000_000;
    // When the father was called to answer, whether that call has returned, and whether the father is
    // expected to be blamed.
    let rows = [
        (None, false, false),
        (Some(0), false, true),
        (Some(0), true, true),
        (Some(2 * MS), false, true),
        (Some(3 * MS), false, false),
        (Some(3 * MS), true, false),
    ];
    for (begun, returned, expected) in rows {
        let (engine, _notifier) = engine(FAMILY, vec![]);
        let check = Check {
            ready: true,
            urgency: 0.0,
            cause: 0,
        };
        engine.rules.start();
        engine.rules.report_check(FIRST, check);
        for role in [0, 1].map(RoleId) {
            engine.request_child(FIRST, role, true);
        }
        engine.rules.report_check(SchemaId(1), check);
        engine.rules.report_check(SchemaId(2), check);
        if let Some(begun) = begun {
            engine.clock.advance_to(begun);
            let ticket = engine
                .rules
                .read(|rules| rules.hierarchy.pending_arbitration(GroupId(1)));
            engine.metrics[FIRST].begin_arbitration(ticket.unwrap(), begun);
            engine.metrics[FIRST].begin_call(begun);
        }
        if returned {
            // The call has returned, but the answer is not reported yet.
            engine.metrics[FIRST].end_call();
        }
        engine.clock.advance_to(5 * MS);
        engine.tick();
        let decided = engine.rules.read(|rules| rules.hierarchy.winner(GroupId(1)));
        assert_eq!(decided, Some(SchemaId(1)), "the priority order decides");
        let blamed = engine
            .rules
            .read(|rules| matches!(rules.hierarchy.health(FIRST), Health::ArbitrationFailed(_)));
        assert_eq!(blamed, expected, "begun at {begun:?}, returned: {returned}");
    }
}

#[test]
fn r7_a_father_that_a_debugger_holds_leaves_no_child_driving() {
    const DRIVING: &str = r#"
        roots = ["father"]
        [schemas.base]
        type = "engine-tests/base"
        [schemas.father]
        type = "engine-tests/lead"
        children = { first = "left", second = "right" }
        groups.base = { policy = "priority" }
        [schemas.left]
        type = "engine-tests/drive"
        actuators = { base = "base.velocity" }
        [schemas.right]
        type = "engine-tests/act"
    "#;
    let (engine, _notifier) = engine(DRIVING, vec![]);
    let [base, father, left] = [0, 1, 2].map(SchemaId);
    let velocity = engine.variables.of(InstancePort::new(base, 0)).unwrap();
    let speed = || {
        velocity
            .reader("test")
            .latch(0)
            .and_then(|last| Twist::from_bytes(last.bytes))
    };
    let ahead = Twist::planar(0.3, 0.0);
    let mut writer = velocity.writer(left.0, "left").unwrap();
    let mut command = || {
        writer.loan().copy_from_slice(ahead.as_bytes());
        writer.publish(0, 0)
    };
    let check = Check {
        ready: true,
        urgency: 0.0,
        cause: 0,
    };
    engine.rules.start();
    engine.rules.report_check(father, check);
    engine.request_child(father, RoleId(0), true);
    engine.rules.report_check(left, check);
    command().expect("it has authority");
    assert_eq!(speed(), Some(ahead));

    engine.report_debugged(father, true);
    assert_eq!(speed(), Some(Twist::ZERO));
    command().expect_err("its father is held");
    assert_eq!(speed(), Some(Twist::ZERO));

    engine.report_debugged(father, false);
    assert_eq!(speed(), Some(Twist::ZERO));
    command().expect("it has authority again");
    assert_eq!(speed(), Some(ahead));
}

#[test]
fn r2_an_awakening_of_before_a_death_brings_no_instance_back() {
    const REPORTS: &str = "roots = [\"report\"]\n[schemas.report]\ntype = \"engine-tests/report\"\n";
    let (engine, _notifier, mut runner) = engine_and_runner(REPORTS, vec![]);
    let mut turn = |signal| {
        let mut inbox = Inbox::default();
        inbox.push(signal);
        runner.take_turn(Some(inbox))
    };
    let mission = engine.variables.of(InstancePort::new(FIRST, 0)).unwrap();
    engine.rules.start();
    turn(Signal::Awake(0));
    assert!(mission.has_value(engine.clock.now()), "it has a value");
    engine.report_death(FIRST, String::from("its process died"));
    for signal in [Signal::Replaced, Signal::Awake(0), Signal::Asleep] {
        turn(signal);
    }
    assert!(!mission.has_value(engine.clock.now()));
    engine.clock.advance_to(3_600_000_000_000);
    engine.tick();
    turn(Signal::Awake(3_600_000_000_000));
    assert!(mission.has_value(engine.clock.now()), "its successor has one");
}

#[test]
fn r19_a_call_that_is_given_up_leaves_no_value_when_its_fault_and_its_end_are_reported() {
    const REPORTS: &str = "roots = [\"report\"]\n[schemas.report]\ntype = \"engine-tests/report\"\n";
    for has_faulted_before in [false, true] {
        let mission: Arc<OnceLock<Arc<Variable>>> = Arc::default();
        let (sender, reported) = mpsc::channel();
        let exported = Arc::clone(&mission);
        let observer = move |event: &Event| {
            let name = match event.what() {
                Some(What::HealthChanged { .. }) => "fault",
                Some(What::CallAbandoned { .. }) => "given up",
                _ => return,
            };
            let has_value = exported.get().is_some_and(|variable| variable.has_value(0));
            sender.send((name, has_value)).unwrap();
        };
        let (engine, _notifier) = engine(REPORTS, vec![Box::new(observer)]);
        let variable = Arc::clone(engine.variables.of(InstancePort::new(FIRST, 0)).unwrap());
        assert!(mission.set(Arc::clone(&variable)).is_ok());
        engine.rules.start();
        let mut writer = variable.writer(0, "report").unwrap();
        let mut publish = || {
            writer.loan().copy_from_slice(Mission::default().as_bytes());
            writer.publish(0, 0).unwrap();
        };
        engine.variables.open_exports(FIRST);
        publish();
        assert!(variable.has_value(0));
        if has_faulted_before {
            // It could not be given up then, and has published since.
            engine.report_hung_call(FIRST, String::from("it hangs"));
            publish();
        }
        engine.report_abandoned_call(FIRST, 0, String::from("it hangs"), 0);
        let reported: Vec<_> = reported.try_iter().collect();
        assert_eq!(reported, [("fault", false), ("given up", false)]);
        // The next instance awakes.
        engine.variables.open_exports(FIRST);
        assert!(!variable.has_value(0));
    }
}

/// Records the missions that stall.
struct Stalls(mpsc::Sender<Nanos>);

impl Observer for Stalls {
    fn on_event(&mut self, event: &Event) {
        if let Event::Other(Occurrence {
            time,
            what: What::Stalled { .. },
        }) = event
        {
            self.0.send(*time).unwrap();
        }
    }
}

#[test]
fn a_mission_is_published_while_the_rules_are_locked() {
    const REPORTS: &str = r#"
        roots = ["report"]
        mission = { from = "report.mission", stalls = "10s" }
        [schemas.report]
        type = "engine-tests/report"
    "#;
    const SECOND: Nanos = 1_000_000_000;
    let _watchdog = Watchdog::for_test();
    let (sender, stalls) = mpsc::channel();
    let (engine, _notifier) = engine(REPORTS, vec![Box::new(Stalls(sender))]);
    crate::mission::watch_mission(&engine);
    engine.rules.start();
    let mut writer = engine
        .variables
        .of(InstancePort::new(FIRST, 0))
        .unwrap()
        .writer(0, "report")
        .unwrap();
    let mut publish = || {
        let now = engine.clock.now();
        let far = Mission {
            distance: 5.0,
            ..Mission::default()
        };
        writer.loan().copy_from_slice(far.as_bytes());
        writer.publish(now, now).unwrap();
    };
    publish();
    engine.clock.advance_to(20 * SECOND);
    engine
        .rules
        .read(|_| std::thread::scope(|scope| scope.spawn(publish).join().unwrap()));
    engine.tick();
    assert_eq!(
        stalls.try_recv(),
        Ok(20 * SECOND),
        "the event is reported nevertheless"
    );
}
