//! What a test can do during a call of one of its schemas.

use std::sync::Arc;

use jde_schema::prelude::*;

use super::scenario::Scenario;

/// A call of a schema, as its behaviour receives it. A schema in another language gives the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Call {
    Awake,
    Check,
    Iterate,
    Sleep,
    Arbitrate,
    Drop,
    Draw,
    Touch,
    Save,
    Restore,
}

/// What a behaviour can do during a call.
pub(crate) struct Io<'a> {
    pub(crate) scenario: &'a Arc<Scenario>,
    pub(crate) name: &'a str,
    /// Calls of this instance before this one; 0 again in a new instance.
    pub(crate) memory: u64,
    /// `None` while the instance is dropped.
    caller: Option<&'a dyn Caller>,
    pub(super) precondition: Precondition,
    /// The role of the child that an arbitration chooses.
    pub(super) chosen: Option<String>,
    /// The gesture that the schema handles, in words.
    pub(crate) gesture: String,
    then: Option<Then>,
}

/// Runs after the behaviour has returned.
type Then = Box<dyn FnOnce(&mut Io<'_>)>;

/// What a behaviour requests of its schema. A schema in another language receives the numbers.
#[derive(Clone, Copy, Debug)]
#[repr(u32)]
pub(super) enum Request {
    Input,
    Other,
    Gain,
    Grip,
    Command,
    Reach,
    Wake,
    Sleep,
    ModulateA,
    RetimeA,
    Publish,
    Retract,
    Seed,
    Now,
    RealTime,
    IsReady,
    Collides,
    Urgency,
    State,
    SetPolicy,
    Mark,
    PublishMark,
    Log,
    Text,
    Value,
    Button,
    Save,
    Restore,
}

/// What a request results in: whether it succeeds or is accepted, a number, and a whole number.
pub(super) type Answer = (Outcome, f64, u64);

/// The schema in whose call a behaviour runs, in any language.
pub(super) trait Caller {
    /// Performs a request. `text` is the role of a child, or a text of a widget, a log message or a value.
    fn request(&self, request: Request, text: &str, number: f64) -> Answer;
    /// The group to arbitrate.
    fn group(&self) -> String;
}

impl<'a> Io<'a> {
    pub(super) fn new(
        scenario: &'a Arc<Scenario>,
        name: &'a str,
        memory: u64,
        caller: Option<&'a dyn Caller>,
    ) -> Self {
        Self {
            scenario,
            name,
            memory,
            caller,
            precondition: false.into(),
            chosen: None,
            gesture: String::new(),
            then: None,
        }
    }

    pub(super) fn perform(&mut self, call: Call) -> Result {
        let (scenario, name) = (self.scenario, self.name);
        match call {
            Call::Check => {}
            Call::Touch => scenario.record(|| self.gesture.clone()),
            _ => self.record(format!("{call:?}").to_lowercase()),
        }
        let result = match scenario.behaviour(name) {
            _ if call == Call::Draw => {
                if let Some(draw) = scenario.draw_fn(name) {
                    draw(self);
                }
                Ok(())
            }
            Some(behaviour) => scenario.track_call(name, call, || behaviour.lock()(call, self)),
            None => self.perform_by_default(call),
        };
        if let Some(then) = self.then.take() {
            then(self);
        }
        result
    }

    /// The behaviour of an instance for which the scenario defines none: its precondition is a positive gain, and it
    /// fails at gestures on the widgets `fail` and `panic`.
    fn perform_by_default(&mut self, call: Call) -> Result {
        match call {
            Call::Check => self.ready(self.gain() > 0.0),
            Call::Touch if self.gesture.contains("`fail`") => return Err(self.gesture.as_str().into()),
            Call::Touch => assert!(!self.gesture.contains("`panic`"), "{}", self.gesture),
            _ => {}
        }
        Ok(())
    }

    /// Does something more in this call, while other instances can run the behaviour. For calls that hang.
    pub(crate) fn then(&mut self, then: impl FnOnce(&mut Io<'_>) + 'static) {
        self.then = Some(Box::new(then));
    }

    fn request(&self, request: Request, text: &str, number: f64) -> Answer {
        let caller = self.caller.expect("a dropped instance has no context");
        caller.request(request, text, number)
    }

    fn get(&self, request: Request) -> Option<Answer> {
        let answer = self.request(request, "", 0.0);
        answer.0.accepted().then_some(answer)
    }

    /// Records what the instance does.
    pub(crate) fn record(&self, what: impl AsRef<str>) {
        self.scenario
            .record(|| format!("{} {}", self.name, what.as_ref()));
    }

    /// Sets the result of a check.
    pub(crate) fn ready(&mut self, ready: impl Into<Precondition>) {
        self.precondition = ready.into();
    }

    /// Sets the result of an arbitration.
    pub(crate) fn choose(&mut self, role: &str) {
        self.chosen = Some(role.to_owned());
    }

    /// The group to arbitrate.
    pub(crate) fn group(&self) -> String {
        let caller = self.caller.expect("a dropped instance has no context");
        caller.group()
    }

    /// Whether several children of the group to arbitrate are ready.
    pub(crate) fn collides(&self) -> bool {
        self.get(Request::Collides).is_some()
    }

    /// Whether a child of the group to arbitrate is ready.
    pub(crate) fn is_ready(&self, role: &str) -> bool {
        self.request(Request::IsReady, role, 0.0).0.accepted()
    }

    /// The seed of the instance.
    pub(crate) fn seed(&self) -> u64 {
        self.request(Request::Seed, "", 0.0).2
    }

    /// Whether the application runs in real time.
    pub(crate) fn is_real_time(&self) -> bool {
        self.get(Request::RealTime).is_some()
    }

    /// Time since the start, ns.
    pub(crate) fn now(&self) -> u64 {
        self.request(Request::Now, "", 0.0).2
    }

    /// Commands a speed of the base.
    pub(crate) fn command(&self, speed: f64) -> Outcome {
        self.request(Request::Command, "", speed).0
    }

    /// Commands a speed of the arm.
    pub(crate) fn reach(&self, speed: f64) -> Outcome {
        self.request(Request::Reach, "", speed).0
    }

    /// The input of a motor schema, with the sequence number of its value.
    pub(crate) fn input(&self) -> Option<(f64, u64)> {
        self.get(Request::Input)
            .map(|(_, value, sequence)| (value, sequence))
    }

    /// The other input.
    pub(crate) fn other(&self) -> Option<f64> {
        self.get(Request::Other).map(|(_, value, _)| value)
    }

    /// The value of the modulation.
    pub(crate) fn gain(&self) -> f64 {
        self.request(Request::Gain, "", 0.0).1
    }

    /// The value of the fixed modulation.
    pub(crate) fn grip(&self) -> f64 {
        self.request(Request::Grip, "", 0.0).1
    }

    /// Wakes a child.
    pub(crate) fn wake(&self, role: &str) -> Outcome {
        self.request(Request::Wake, role, 0.0).0
    }

    /// Puts a child to sleep.
    pub(crate) fn sleep(&self, role: &str) -> Outcome {
        self.request(Request::Sleep, role, 0.0).0
    }

    /// Writes the modulation of child `a`.
    pub(crate) fn modulate_a(&self, gain: f64) -> Outcome {
        self.request(Request::ModulateA, "", gain).0
    }

    /// Writes the period of child `a`, seconds.
    pub(crate) fn retime_a(&self, period: f64) -> Outcome {
        self.request(Request::RetimeA, "", period).0
    }

    /// Publishes the export of an eye.
    pub(crate) fn publish(&self, value: f64) {
        self.request(Request::Publish, "", value);
    }

    /// Retracts the export of an eye.
    pub(crate) fn retract(&self) {
        self.request(Request::Retract, "", 0.0);
    }

    /// The urgency of a child of the group to arbitrate.
    pub(crate) fn urgency(&self, role: &str) -> f64 {
        self.request(Request::Urgency, role, 0.0).1
    }

    /// The state of a child, as the number in the ABI, and whether it is Faulted.
    pub(crate) fn state(&self, role: &str) -> (u64, bool) {
        let (_, faulted, state) = self.request(Request::State, role, 0.0);
        (state, faulted != 0.0)
    }

    /// Lets the most urgent child win in the group of a child.
    pub(crate) fn urgency_decides(&self, role: &str) -> Outcome {
        self.request(Request::SetPolicy, role, 0.0).0
    }

    /// The imported mark, if its label is this one: the x of its last place, and the number of its places.
    pub(crate) fn mark(&self, label: &str) -> Option<(f64, u64)> {
        let (outcome, x, places) = self.request(Request::Mark, label, 0.0);
        outcome.accepted().then_some((x, places))
    }

    /// Publishes a mark of an eye: a label, and one place.
    pub(crate) fn publish_mark(&self, label: &str, x: f64) {
        self.request(Request::PublishMark, label, x);
    }

    /// Writes a log message of the level `info`.
    pub(crate) fn log(&self, text: &str) {
        self.request(Request::Log, text, 0.0);
    }

    /// Draws a text.
    pub(crate) fn text(&self, text: impl AsRef<str>) {
        self.request(Request::Text, text.as_ref(), 0.0);
    }

    /// Draws a number with its name, in m.
    pub(crate) fn value(&self, label: &str, value: f64) {
        self.request(Request::Value, label, value);
    }

    /// Draws a button, with its id as its text.
    pub(crate) fn button(&self, id: &str) {
        self.request(Request::Button, id, 0.0);
    }

    /// Saves a number.
    pub(crate) fn save(&self, number: f64) {
        self.request(Request::Save, "", number);
    }

    /// Takes a number from the saved memory; `None` if that failed.
    pub(crate) fn restore(&self) -> Option<f64> {
        self.get(Request::Restore).map(|(_, number, _)| number)
    }
}
