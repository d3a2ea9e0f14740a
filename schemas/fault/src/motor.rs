//! A motor schema that is READY periodically, wakes its children and commands a speed. It misbehaves on
//! request.

use jde_schema::prelude::*;

use crate::request::{Call, FaultKind, RequestText, requested};
use crate::trouble::cause;

/// Times that one iteration repeats its command, export and message under "flood".
const FLOOD: u32 = 300;
/// A speed that no base can drive, m/s.
const EXCESSIVE_SPEED: f64 = 1e9;
/// The speed that is commanded without authority, m/s.
const UNAUTHORIZED_SPEED: f64 = 0.9;

/// Iterations for which a reckless command stays the same: at 20 ms, long enough to drive somewhere.
const RECKLESS_ITERATIONS: u64 = 50;

/// Drives, and wakes its children, for a part of each cycle; misbehaves on request.
#[derive(Describe)]
#[schema(motor, period = "20ms", budget = "10ms")]
pub struct Motor {
    /// The fault to cause for as long as it is set, such as "panic", "hang" or "nan"; empty for none.
    #[modulation(default = "")]
    trouble: Modulation<Text<16>>,
    /// The call that causes it: "awake", "check", "iterate", "sleep", "arbitrate", "save", "restore" or
    /// "end".
    #[modulation(default = "iterate")]
    place: Modulation<Text<16>>,
    /// Time in each cycle during which it is ready.
    #[modulation(default = 1.0, unit = "s", min = 0.0)]
    on: Modulation<f64>,
    /// Time in each cycle during which it is not ready; 0 to be ready always.
    #[modulation(default = 0.0, unit = "s", min = 0.0)]
    off: Modulation<f64>,
    /// Offset into the cycle at time 0.
    #[modulation(default = 0.0, unit = "s", min = 0.0)]
    phase: Modulation<f64>,
    /// Its urgency.
    #[modulation(default = 0.0)]
    urge: Modulation<f64>,
    /// Forward speed.
    #[modulation(default = 0.0, unit = "m/s")]
    speed: Modulation<f64>,
    /// Turn rate.
    #[modulation(default = 0.0, unit = "rad/s")]
    turn: Modulation<f64>,
    /// Target of the first child.
    #[modulation(default = Target::NONE)]
    target: Modulation<Target>,
    /// Any scan. If it is bound, the schema is not ready without a value.
    #[import(optional)]
    needs: Import<LaserScan>,
    /// Checks of this instance so far.
    #[export]
    beats: Export<u64>,
    /// Faults of this instance so far.
    #[export(lasting)]
    misdeeds: Export<u64>,
    /// Speeds of the base.
    #[actuator(optional)]
    base: Actuator<Twist>,
    /// The first child.
    #[child(group = "base", optional)]
    a: Child,
    /// Another child.
    #[child(group = "base", optional)]
    b: Child,
    /// Another child.
    #[child(group = "base", optional)]
    c: Child,
    /// Another child.
    #[child(group = "base", optional)]
    d: Child,
    /// A child of another group.
    #[child(group = "arm", optional)]
    e: Child,
    /// Another child of that group.
    #[child(group = "arm", optional)]
    f: Child,
    /// Target of the first child.
    #[modulates(child = "a", name = "target", optional)]
    target_of_a: Modulates<Target>,
    checks: u64,
    faults: u64,
    /// The fault to cause when the instance is dropped, as requested at the last check.
    end: Option<FaultKind>,
}

impl Schema for Motor {
    fn awake(&mut self, cx: &Context) -> Result {
        self.misbehave(cx, Call::Awake).map(drop)
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        self.checks += 1;
        self.beats.write(cx, self.checks);
        self.end = self.due(cx, Call::End);
        let fault = self.misbehave(cx, Call::Check)?;
        if fault == Some(FaultKind::Trespass) {
            self.base.command(cx, Twist::planar(UNAUTHORIZED_SPEED, 0.0));
            self.wake_all(cx);
        }
        let ready = match fault {
            Some(FaultKind::Chatter) => self.checks.is_multiple_of(2),
            _ => self.is_in_ready_phase(cx) && (!self.needs.is_bound(cx) || self.needs.get(cx).is_some()),
        };
        Ok(Precondition::from(ready).urgency(self.urge.get(cx)))
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let fault = self.misbehave(cx, Call::Iterate)?;
        if fault == Some(FaultKind::Meddle) {
            self.meddle(cx);
        } else {
            self.wake_all(cx);
        }
        self.target_of_a.set(cx, self.target.get(cx));
        let command = Twist::planar(self.speed.get(cx), self.turn.get(cx));
        let twist = match fault {
            Some(FaultKind::Silence) => return Ok(()),
            Some(FaultKind::Nan) => Twist::planar(f64::NAN, 0.0),
            Some(FaultKind::Infinity) => Twist::planar(0.0, f64::INFINITY),
            Some(FaultKind::Beyond) => Twist::planar(EXCESSIVE_SPEED, -EXCESSIVE_SPEED),
            Some(FaultKind::Reckless) => self.reckless(cx, &command),
            _ => command,
        };
        if fault == Some(FaultKind::Flood) {
            for _ in 0..FLOOD {
                self.base.command(cx, command);
                self.beats.write(cx, self.checks);
                debug!(cx, "flood");
            }
        }
        self.base.command(cx, twist);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Err(error) = self.misbehave(cx, Call::Sleep) {
            warn!(cx, "{error}");
        }
    }
}

impl Arbitrate for Motor {
    fn arbitrate(&mut self, cx: &Context, level: &Level) -> Result<Verdict> {
        self.misbehave(cx, Call::Arbitrate)?;
        let candidates = level.candidates().iter().filter(|candidate| candidate.ready);
        let best = candidates.max_by(|a, b| a.urgency.total_cmp(&b.urgency));
        let child = best.and_then(|best| self.children().find(|child| best.is(child)));
        Ok(match child {
            Some(child) => Verdict::choose(child, "it is the most urgent"),
            None => Verdict::nobody("nobody is ready"),
        })
    }
}

impl Memory for Motor {
    fn save(&self, cx: &Context, saving: &mut Saving) {
        if let Some(fault) = self.due(cx, Call::Save)
            && let Err(error) = cause(fault)
        {
            panic!("{error}");
        }
        saving.put(&self.checks);
    }

    fn restore(&mut self, cx: &Context, saved: &mut Saved) -> Result {
        if let Some(fault) = self.due(cx, Call::Restore) {
            cause(fault)?;
        }
        self.checks = saved.take()?;
        Ok(())
    }
}

impl Drop for Motor {
    fn drop(&mut self) {
        if let Some(fault) = self.end.take()
            && !std::thread::panicking()
            && let Err(error) = cause(fault)
        {
            panic!("{error}");
        }
    }
}

impl Motor {
    /// Causes the fault that is due in this call, and returns it.
    fn misbehave(&mut self, cx: &Context, call: Call) -> Result<Option<FaultKind>> {
        let due = self.due(cx, call);
        if let Some(fault) = due {
            self.faults += 1;
            self.misdeeds.write(cx, self.faults);
            cause(fault)?;
        }
        Ok(due)
    }

    fn due(&self, cx: &Context, call: Call) -> Option<FaultKind> {
        let (fault, requested_call): (RequestText, RequestText) = (self.trouble.get(cx), self.place.get(cx));
        requested(&fault, &requested_call, call)
    }

    fn is_in_ready_phase(&self, cx: &Context) -> bool {
        let (on, off) = (self.on.get(cx), self.off.get(cx));
        let now = cx.now().as_secs_f64() + self.phase.get(cx);
        off <= 0.0 || now.rem_euclid(on + off) < on
    }

    /// Wakes all children. A refusal needs no handling, because the next iteration tries again.
    fn wake_all(&self, cx: &Context) {
        for child in self.children() {
            child.wake(cx);
        }
    }

    /// Random parts of a command, ahead and back, each for some iterations.
    fn reckless(&self, cx: &Context, full: &Twist) -> Twist {
        let mut random = fastrand::Rng::with_seed(cx.seed() ^ (self.faults / RECKLESS_ITERATIONS));
        let mut part = || random.f64() * 2.0 - 1.0;
        Twist::planar(full.linear.x * part(), full.angular.z * part())
    }

    fn meddle(&self, cx: &Context) {
        for (number, child) in (0_u64..).zip(self.children()) {
            match (self.faults + number) % 4 {
                0 | 1 => child.wake(cx),
                2 => child.sleep(cx),
                _ => child.set_policy(cx, Policy::URGENCY),
            };
        }
    }

    fn children(&self) -> impl Iterator<Item = &Child> {
        [&self.a, &self.b, &self.c, &self.d, &self.e, &self.f].into_iter()
    }
}
