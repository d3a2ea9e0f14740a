//! A driver without a device: it simulates an axis, and misbehaves on request.

use jde_schema::prelude::*;

use crate::request::{Call, FaultKind, RequestText, requested};
use crate::trouble::cause;

/// An axis that reaches the commanded speed at once, and misbehaves on request.
#[derive(Describe)]
#[schema(driver, period = "20ms", budget = "10ms")]
pub struct Device {
    /// The fault to cause for as long as it is set, such as "panic", "hang" or "silence"; empty for none.
    #[modulation(default = "")]
    trouble: Modulation<Text<16>>,
    /// The call that causes it: "awake", "iterate" or "sleep".
    #[modulation(default = "iterate")]
    place: Modulation<Text<16>>,
    /// Speed of the axis.
    #[command(neutral = Twist::ZERO, validity = "200ms")]
    velocity: Command<Twist>,
    /// The present speed of the axis.
    #[export(unit = "m/s")]
    moves: Export<f64>,
    /// Iterations of this instance so far.
    #[export]
    beats: Export<u64>,
    /// Faults of this instance so far.
    #[export(lasting)]
    misdeeds: Export<u64>,
    iterations: u64,
    faults: u64,
}

impl Schema for Device {
    fn awake(&mut self, cx: &Context) -> Result {
        self.misbehave(cx, Call::Awake).map(drop)
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.iterations += 1;
        self.beats.write(cx, self.iterations);
        match self.misbehave(cx, Call::Iterate)? {
            Some(FaultKind::Silence) => self.moves.retract(cx),
            Some(FaultKind::Nan) => self.moves.write(cx, f64::NAN),
            _ => self.moves.write(cx, self.velocity.get(cx).linear.x),
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.moves.write(cx, 0.0);
        if let Err(error) = self.misbehave(cx, Call::Sleep) {
            warn!(cx, "{error}");
        }
    }
}

impl Device {
    fn misbehave(&mut self, cx: &Context, call: Call) -> Result<Option<FaultKind>> {
        let (fault, requested_call): (RequestText, RequestText) = (self.trouble.get(cx), self.place.get(cx));
        let due = requested(&fault, &requested_call, call);
        if let Some(fault) = due {
            self.faults += 1;
            self.misdeeds.write(cx, self.faults);
            cause(fault)?;
        }
        Ok(due)
    }
}
