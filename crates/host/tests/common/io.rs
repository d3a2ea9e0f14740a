//! What a test can do during a call of one of its schemas.

use std::sync::Arc;

use jde_schema::prelude::*;

use super::scenario::{Scenario, lock};
use super::schemas::Motor;

/// A call of a schema, as its behaviour receives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Call {
    Awake,
    Check,
    Iterate,
    Sleep,
    Arbitrate,
    Drop,
}

/// What a behaviour can do during a call.
pub(crate) struct Io<'a> {
    pub(crate) scenario: &'a Arc<Scenario>,
    pub(crate) name: &'a str,
    /// Calls of this instance before this one; 0 again in a new instance.
    pub(crate) memory: u64,
    /// `None` while the instance is dropped.
    inner: Option<Inner<'a>>,
    pub(super) precondition: Precondition,
    pub(super) verdict: Option<Verdict>,
    then: Option<Then>,
}

/// Runs after the behaviour has returned.
type Then = Box<dyn FnOnce(&mut Io<'_>)>;

pub(super) struct Inner<'a> {
    pub(super) cx: &'a Context<'a>,
    pub(super) motor: Option<&'a Motor>,
    pub(super) perceptive: Option<&'a mut Export<f64>>,
    pub(super) level: Option<&'a Level<'a>>,
}

impl<'a> Io<'a> {
    pub(super) fn new(
        scenario: &'a Arc<Scenario>,
        name: &'a str,
        memory: u64,
        inner: Option<Inner<'a>>,
    ) -> Self {
        Self {
            scenario,
            name,
            memory,
            inner,
            precondition: false.into(),
            verdict: None,
            then: None,
        }
    }

    pub(super) fn perform(&mut self, call: Call) -> Result {
        match call {
            Call::Awake | Call::Iterate | Call::Sleep | Call::Arbitrate => {
                self.record(format!("{call:?}").to_lowercase());
            }
            Call::Check | Call::Drop => {}
        }
        let (scenario, name) = (self.scenario, self.name);
        let result = match scenario.behaviour(name) {
            Some(behaviour) => scenario.track_call(name, call, || lock(&behaviour)(call, self)),
            None => Ok(()),
        };
        if let Some(then) = self.then.take() {
            then(self);
        }
        result
    }

    /// Does something more in this call, while other instances can run the behaviour. For calls that hang.
    pub(crate) fn then(&mut self, then: impl FnOnce(&mut Io<'_>) + 'static) {
        self.then = Some(Box::new(then));
    }

    fn inner(&self) -> &Inner<'a> {
        self.inner.as_ref().expect("a dropped instance has no context")
    }

    fn motor(&self) -> &'a Motor {
        self.inner().motor.expect("the instance is a motor schema")
    }

    /// The context of the current call.
    pub(crate) fn cx(&self) -> &'a Context<'a> {
        self.inner().cx
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
        self.verdict = Some(Verdict::choose(
            self.child(role),
            format!("{} chose {role}", self.name),
        ));
    }

    /// The level to arbitrate.
    pub(crate) fn level(&self) -> &'a Level<'a> {
        self.inner().level.expect("the call is an arbitration")
    }

    /// Time since the start, ns.
    pub(crate) fn now(&self) -> u64 {
        self.cx().now().as_nanos() as u64
    }

    /// Commands a speed of the base.
    pub(crate) fn command(&self, speed: f64) -> Outcome {
        self.motor().base.command(self.cx(), Twist::planar(speed, 0.0))
    }

    /// Commands a speed of the arm.
    pub(crate) fn reach(&self, speed: f64) -> Outcome {
        self.motor().arm.command(self.cx(), Twist::planar(speed, 0.0))
    }

    /// The input of a motor schema, with the sequence number of its value.
    pub(crate) fn input(&self) -> Option<(f64, u64)> {
        let sample = self.motor().input.get(self.cx())?;
        Some((*sample, sample.sequence()))
    }

    /// The other input.
    pub(crate) fn other(&self) -> Option<f64> {
        self.motor().other.get(self.cx()).map(|sample| *sample)
    }

    /// The value of the modulation.
    pub(crate) fn gain(&self) -> f64 {
        self.motor().gain.get(self.cx())
    }

    /// The value of the fixed modulation.
    pub(crate) fn grip(&self) -> f64 {
        self.motor().grip.get(self.cx())
    }

    /// A child by its role.
    pub(crate) fn child(&self, role: &str) -> &'a Child {
        let motor = self.motor();
        match role {
            "a" => &motor.a,
            "b" => &motor.b,
            "c" => &motor.c,
            "helper" => &motor.helper,
            other => panic!("there is no role {other}"),
        }
    }

    /// Wakes a child.
    pub(crate) fn wake(&self, role: &str) -> Outcome {
        self.child(role).wake(self.cx())
    }

    /// Writes the modulation of child `a`.
    pub(crate) fn modulate_a(&self, gain: f64) -> Outcome {
        self.motor().gain_of_a.set(self.cx(), gain)
    }

    /// Writes the period of child `a`, seconds.
    pub(crate) fn retime_a(&self, period: f64) -> Outcome {
        self.motor().period_of_a.set(self.cx(), period)
    }

    /// Publishes the export of an eye.
    pub(crate) fn publish(&mut self, value: f64) {
        let inner = self.inner.as_mut().expect("a dropped instance has no context");
        let out = inner.perceptive.as_mut().expect("the instance is perceptive");
        out.write(inner.cx, value);
    }

    /// Retracts the export of an eye.
    pub(crate) fn retract(&mut self) {
        let inner = self.inner.as_mut().expect("a dropped instance has no context");
        let out = inner.perceptive.as_mut().expect("the instance is perceptive");
        out.retract(inner.cx);
    }
}
