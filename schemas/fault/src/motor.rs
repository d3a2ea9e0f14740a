//! A motor schema that is READY periodically, wakes its children and commands a speed. It misbehaves on
//! request.

use jde_schema::prelude::*;

use crate::request::{Place, Trouble, Word, requested};
use crate::trouble::cause;

/// Times that one iteration repeats its command, export and message under "flood".
const FLOOD: u32 = 300;
/// A speed that no base can drive, m/s.
const BEYOND: f64 = 1e9;
/// The speed that is commanded without authority, m/s.
const TRESPASS: f64 = 0.9;

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
    #[export]
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
    end: Option<Trouble>,
}

impl Schema for Motor {
    fn awake(&mut self, cx: &Context) -> Result {
        self.misbehave(cx, Place::Awake).map(drop)
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        self.checks += 1;
        self.beats.write(cx, self.checks);
        self.end = self.due(cx, Place::End);
        let trouble = self.misbehave(cx, Place::Check)?;
        if trouble == Some(Trouble::Trespass) {
            self.base.command(cx, Twist::planar(TRESPASS, 0.0));
            self.wake_all(cx);
        }
        let ready = match trouble {
            Some(Trouble::Chatter) => self.checks.is_multiple_of(2),
            _ => self.is_its_turn(cx) && (!self.needs.is_bound(cx) || self.needs.get(cx).is_some()),
        };
        Ok(Precondition::from(ready).urgency(self.urge.get(cx)))
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let trouble = self.misbehave(cx, Place::Iterate)?;
        if trouble == Some(Trouble::Meddle) {
            self.meddle(cx);
        } else {
            self.wake_all(cx);
        }
        self.target_of_a.set(cx, self.target.get(cx));
        let command = Twist::planar(self.speed.get(cx), self.turn.get(cx));
        let twist = match trouble {
            Some(Trouble::Silence) => return Ok(()),
            Some(Trouble::Nan) => Twist::planar(f64::NAN, 0.0),
            Some(Trouble::Infinity) => Twist::planar(0.0, f64::INFINITY),
            Some(Trouble::Beyond) => Twist::planar(BEYOND, -BEYOND),
            _ => command,
        };
        if trouble == Some(Trouble::Flood) {
            for _ in 0..FLOOD {
                self.base.command(cx, command);
                self.beats.write(cx, self.checks);
                debug!(cx, "and on, and on");
            }
        }
        self.base.command(cx, twist);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Err(error) = self.misbehave(cx, Place::Sleep) {
            warn!(cx, "{error}");
        }
    }
}

impl Arbitrate for Motor {
    fn arbitrate(&mut self, cx: &Context, level: &Level) -> Result<Verdict> {
        self.misbehave(cx, Place::Arbitrate)?;
        let urgent = level.candidates().iter().filter(|candidate| candidate.ready);
        let best = urgent.max_by(|one, other| one.urgency.total_cmp(&other.urgency));
        let child = best.and_then(|best| self.children().find(|child| best.is(child)));
        Ok(match child {
            Some(child) => Verdict::choose(child, "it is the most urgent"),
            None => Verdict::nobody("nobody is ready"),
        })
    }
}

impl Memory for Motor {
    fn save(&self, cx: &Context, saving: &mut Saving) {
        if let Some(trouble) = self.due(cx, Place::Save)
            && let Err(error) = cause(trouble)
        {
            panic!("{error}");
        }
        saving.put(&self.checks);
    }

    fn restore(&mut self, cx: &Context, saved: &mut Saved) -> Result {
        if let Some(trouble) = self.due(cx, Place::Restore) {
            cause(trouble)?;
        }
        self.checks = saved.take()?;
        Ok(())
    }
}

impl Drop for Motor {
    fn drop(&mut self) {
        if let Some(trouble) = self.end.take()
            && !std::thread::panicking()
            && let Err(error) = cause(trouble)
        {
            panic!("{error}");
        }
    }
}

impl Motor {
    /// Causes the fault that is requested for this call, and returns it.
    fn misbehave(&mut self, cx: &Context, call: Place) -> Result<Option<Trouble>> {
        let due = self.due(cx, call);
        if let Some(trouble) = due {
            self.faults += 1;
            self.misdeeds.write(cx, self.faults);
            cause(trouble)?;
        }
        Ok(due)
    }

    fn due(&self, cx: &Context, call: Place) -> Option<Trouble> {
        let (trouble, place): (Word, Word) = (self.trouble.get(cx), self.place.get(cx));
        requested(&trouble, &place, call)
    }

    fn is_its_turn(&self, cx: &Context) -> bool {
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
