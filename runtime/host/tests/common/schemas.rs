//! The schemas of the tests. They have every kind of port and child, and behave as the scenario defines.

use std::cell::{Cell, RefCell};
use std::sync::Arc;

use jde_abi::raw;
use jde_schema::derived;
use jde_schema::prelude::*;

use super::in_rust::InRust;
use super::io::{Call, Io};
use super::scenario::Scenario;

thread_local! {
    /// Instances of the test plugin that this thread created and that have not ended.
    pub(crate) static LIVE: Cell<i64> = const { Cell::new(0) };
}

/// Counts the live instances.
struct Alive;

impl Default for Alive {
    fn default() -> Self {
        count_live(1);
        Self
    }
}

impl Drop for Alive {
    fn drop(&mut self) {
        count_live(-1);
    }
}

/// Adds to the number of live instances.
pub(super) fn count_live(change: i64) {
    // A thread that ends has no count any more.
    let _ = LIVE.try_with(|live| live.set(live.get() + change));
}

/// The state of every instance of the tests.
#[derive(Default)]
struct InstanceState {
    alive: Alive,
    scenario: Option<Arc<Scenario>>,
    name: String,
    calls: u64,
}

/// A value of a type of the tests' own.
#[derive(Clone, Copy, Default, Value)]
#[repr(C)]
#[value(name = "test_msgs/msg/Mark")]
pub(crate) struct Mark {
    /// Where it is.
    pub(crate) places: Seq<Pose2D, 4>,
    /// What it is.
    pub(crate) label: Text<12>,
}

/// A motor schema.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
pub(crate) struct Motor {
    /// The number of the scenario.
    #[modulation(default = 0, fixed)]
    scenario: Modulation<u32>,
    /// An input.
    #[import(optional)]
    pub(super) input: Import<f64>,
    /// Another input.
    #[import(optional)]
    pub(super) other: Import<f64>,
    /// A value of a type of the tests' own.
    #[import(optional)]
    pub(super) mark: Import<Mark>,
    /// A modulation for a father or an operator.
    #[modulation(default = 0.0)]
    pub(super) gain: Modulation<f64>,
    /// A modulation that is read at the awakening.
    #[modulation(default = 0.0, fixed)]
    pub(super) grip: Modulation<f64>,
    /// A command with a long validity.
    #[actuator(optional)]
    pub(super) base: Actuator<Twist>,
    /// A command with a short validity.
    #[actuator(optional)]
    pub(super) arm: Actuator<Twist>,
    /// The progress of the mission.
    #[export]
    mission: Export<Mission>,
    /// A child.
    #[child(group = "base", optional)]
    pub(super) a: Child,
    /// Another child.
    #[child(group = "base", optional)]
    pub(super) b: Child,
    /// A third child.
    #[child(group = "base", optional)]
    pub(super) c: Child,
    /// A perceptive child.
    #[child(perceptive, optional)]
    pub(super) helper: Child,
    /// The modulation of child a.
    #[modulates(child = "a", name = "gain", optional)]
    pub(super) gain_of_a: Modulates<f64>,
    /// The period of child a.
    #[modulates(child = "a", name = "period", optional)]
    pub(super) period_of_a: Modulates<f64>,
    state: InstanceState,
}

/// A perceptive schema.
#[derive(Describe)]
#[schema(perceptive, period = "10ms")]
pub(crate) struct Eye {
    /// The number of the scenario.
    #[modulation(default = 0, fixed)]
    scenario: Modulation<u32>,
    /// A modulation for an operator.
    #[modulation(default = 0.0)]
    gain: Modulation<f64>,
    /// An input.
    #[import(optional)]
    input: Import<f64>,
    /// The value that the test publishes.
    #[export]
    out: Export<f64>,
    /// A value of a type of the tests' own.
    #[export]
    mark: Export<Mark>,
    state: InstanceState,
}

/// A driver. It records each change of its commands.
#[derive(Describe)]
#[schema(driver, period = "10ms")]
pub(crate) struct Robot {
    /// The number of the scenario.
    #[modulation(default = 0, fixed)]
    scenario: Modulation<u32>,
    /// The limits of that command.
    #[modulation(default = Twist::ZERO, fixed)]
    velocity_limits: Modulation<Twist>,
    /// A command that is in force for long.
    #[command(neutral = Twist::ZERO, validity = "1000s")]
    velocity: Command<Twist>,
    /// A command that must be repeated.
    #[command(neutral = Twist::ZERO, validity = "50ms")]
    reach: Command<Twist>,
    last: [Option<f64>; 2],
    state: InstanceState,
}

/// Records each command of a robot that differs from the one before.
pub(super) fn record_commands(scenario: &Scenario, name: &str, before: [f64; 2], seen: [f64; 2]) {
    for ((what, before), seen) in ["velocity", "reach"].into_iter().zip(before).zip(seen) {
        if before != seen {
            scenario.record(|| format!("{name} {what} {seen}"));
        }
    }
}

/// A schema that cannot be created.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
pub(crate) struct FailsToCreate {
    /// The number of the scenario.
    #[modulation(default = 0, fixed)]
    scenario: Modulation<u32>,
    field: PanicsOnDefault,
}

struct PanicsOnDefault;

impl Default for PanicsOnDefault {
    fn default() -> Self {
        panic!("there is no such device")
    }
}

impl InstanceState {
    fn begin(&mut self, cx: &Context, scenario: u32) -> (Arc<Scenario>, u64) {
        if self.scenario.is_none() {
            self.scenario = Some(Scenario::of(scenario));
            self.name = cx.name().to_owned();
        }
        self.calls += 1;
        let scenario = self.scenario.as_ref().expect("it was set");
        (Arc::clone(scenario), self.calls - 1)
    }
}

impl Drop for InstanceState {
    fn drop(&mut self) {
        let Some(scenario) = self.scenario.take() else {
            return;
        };
        let mut io = Io::new(&scenario, &self.name, self.calls, None);
        // An error has no receiver; a panic propagates to the boundary.
        let _ = io.perform(Call::Drop);
    }
}

impl Motor {
    fn call(
        &mut self,
        cx: &Context,
        call: Call,
        level: Option<&Level>,
    ) -> Result<(Precondition, Option<Verdict>)> {
        let (scenario, memory) = self.state.begin(cx, self.scenario.get(cx));
        let motor = Some(&*self);
        let caller = InRust {
            motor,
            level,
            ..InRust::new(cx)
        };
        let mut io = Io::new(&scenario, &self.state.name, memory, Some(&caller));
        io.perform(call)?;
        let verdict = io.chosen.map(|role| {
            let reason = format!("{} chose {role}", self.state.name);
            Verdict::choose(self.child(&role), reason)
        });
        Ok((io.precondition, verdict))
    }

    /// A child by its role.
    pub(super) fn child(&self, role: &str) -> &Child {
        match role {
            "a" => &self.a,
            "b" => &self.b,
            "c" => &self.c,
            "helper" => &self.helper,
            other => panic!("there is no role {other}"),
        }
    }

    /// Writes the state of the mission.
    fn report(&mut self, cx: &Context, state: u8) {
        self.mission.write(
            cx,
            Mission {
                state,
                ..Mission::default()
            },
        );
    }
}

impl Schema for Motor {
    fn awake(&mut self, cx: &Context) -> Result {
        self.call(cx, Call::Awake, None).map(drop)
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        self.call(cx, Call::Check, None)
            .map(|(precondition, _)| precondition)
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.call(cx, Call::Iterate, None)?;
        // A gain of 100 or more sets the mission's state.
        let gain = self.gain.get(cx);
        if gain >= 100.0 {
            self.report(cx, (gain - 100.0) as u8);
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Err(error) = self.call(cx, Call::Sleep, None) {
            panic!("{error}");
        }
    }
}

impl Arbitrate for Motor {
    fn arbitrate(&mut self, cx: &Context, level: &Level) -> Result<Verdict> {
        let (_, verdict) = self.call(cx, Call::Arbitrate, Some(level))?;
        Ok(verdict.unwrap_or_else(|| Verdict::nobody("the scenario chose no child")))
    }
}

impl Panel for Motor {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let caller = InRust {
            motor: Some(self),
            pen: Some(RefCell::new(pen)),
            ..InRust::new(cx)
        };
        let scenario = Scenario::of(self.scenario.get(cx));
        if let Err(error) = Io::new(&scenario, cx.name(), self.state.calls, Some(&caller)).perform(Call::Draw)
        {
            panic!("{error}");
        }
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        let (scenario, memory) = self.state.begin(cx, self.scenario.get(cx));
        let caller = InRust {
            motor: Some(self),
            ..InRust::new(cx)
        };
        let mut io = Io::new(&scenario, &self.state.name, memory, Some(&caller));
        io.gesture = format!("{} {}", gesture.by(), gesture.words(cx.name()));
        io.perform(Call::Touch)
    }
}

impl Memory for Motor {
    fn save(&self, cx: &Context, saving: &mut Saving) {
        let caller = InRust {
            motor: Some(self),
            saving: Some(RefCell::new(saving)),
            ..InRust::new(cx)
        };
        let scenario = Scenario::of(self.scenario.get(cx));
        if let Err(error) = Io::new(&scenario, cx.name(), self.state.calls, Some(&caller)).perform(Call::Save)
        {
            panic!("{error}");
        }
    }

    fn restore(&mut self, cx: &Context, saved: &mut Saved) -> Result {
        let (scenario, memory) = self.state.begin(cx, self.scenario.get(cx));
        let caller = InRust {
            motor: Some(self),
            saved: saved.take().ok(),
            ..InRust::new(cx)
        };
        Io::new(&scenario, &self.state.name, memory, Some(&caller)).perform(Call::Restore)
    }
}

impl Eye {
    fn call(&mut self, cx: &Context, call: Call) -> Result {
        let (scenario, memory) = self.state.begin(cx, self.scenario.get(cx));
        let eye = Some(RefCell::new((&mut self.out, &mut self.mark)));
        let caller = InRust {
            eye,
            eye_input: Some(&self.input),
            ..InRust::new(cx)
        };
        Io::new(&scenario, &self.state.name, memory, Some(&caller)).perform(call)
    }
}

impl Schema for Eye {
    fn awake(&mut self, cx: &Context) -> Result {
        self.call(cx, Call::Awake)
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.call(cx, Call::Iterate)
    }

    fn sleep(&mut self, cx: &Context) {
        if let Err(error) = self.call(cx, Call::Sleep) {
            panic!("{error}");
        }
    }
}

/// Accepts commands up to its value, in m/s, and limits them to it if it is between 0.3 and 0.4. It panics at a NaN. If
/// it is less than -1, the judgement of a command above 0.2 m/s never returns.
impl Guard for Eye {
    type State = f64;
    type Command = Twist;
    const STATE_EXPORT: &'static str = "out";

    fn judge(limit: &f64, _age: Duration, command: &Twist) -> Result<(), String> {
        assert!(!limit.is_nan(), "a limit is a number");
        let speed = command.linear.x;
        if speed <= *limit {
            return Ok(());
        }
        if *limit < -1.0 && speed > 0.2 {
            loop {
                std::thread::park();
            }
        }
        Err(format!("{speed} m/s, and at most {limit} m/s are safe"))
    }

    fn limit(limit: &f64, _age: Duration, _command: &Twist) -> Option<Twist> {
        (*limit > 0.3 && *limit < 0.4).then(|| Twist::planar(*limit, 0.0))
    }
}

impl Robot {
    fn call(&mut self, cx: &Context, call: Call) -> Result {
        let (scenario, memory) = self.state.begin(cx, self.scenario.get(cx));
        Io::new(&scenario, &self.state.name, memory, Some(&InRust::new(cx))).perform(call)
    }
}

impl Schema for Robot {
    fn awake(&mut self, cx: &Context) -> Result {
        self.call(cx, Call::Awake)
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let velocity = self.velocity.get(cx);
        let reach = self.reach.get(cx);
        let seen = [velocity, reach].map(|command| command.in_force().then_some(command.linear.x));
        let scenario = Scenario::of(self.scenario.get(cx));
        let before = std::mem::replace(&mut self.last, seen);
        // A brake is no command (R9). The schemas of the tests command no zero.
        if seen.contains(&Some(0.0)) {
            return Err("a brake is read as a command in force".into());
        }
        let speeds = |seen: [Option<f64>; 2]| seen.map(|speed| speed.unwrap_or(0.0));
        record_commands(&scenario, cx.name(), speeds(before), speeds(seen));
        self.call(cx, Call::Iterate)?;
        let again = [self.velocity.get(cx), self.reach.get(cx)];
        if again.map(|command| command.in_force().then_some(command.linear.x)) != seen {
            scenario.record(|| format!("{} read another command", cx.name()));
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Err(error) = self.call(cx, Call::Sleep) {
            panic!("{error}");
        }
    }
}

impl Schema for FailsToCreate {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

/// The plugin of the tests in Rust.
pub(crate) static TEST: raw::Plugin = {
    const SCHEMAS: &[raw::Schema] = &[
        raw::Schema {
            ability: None,
            ..Motor::TABLE
        },
        raw::Schema {
            name: c"able-motor".as_ptr(),
            ..Motor::TABLE
        },
        Eye::TABLE,
        Robot::TABLE,
        FailsToCreate::TABLE,
    ];
    derived::plugin("test\0", "1\0", "Schemas of the tests.\0", false, SCHEMAS)
};
