//! A perceptive schema that forwards a scan, and misbehaves on request.

use jde_schema::prelude::*;

use crate::request::{Call, FaultKind, RequestText, requested};
use crate::trouble::cause;

/// Scans that one iteration publishes under "flood".
const FLOOD: u32 = 200;

/// Forwards the scans of a laser, and misbehaves on request.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "10ms")]
pub struct Eye {
    /// The fault to cause for as long as it is set, such as "panic", "hang" or "nan"; empty for none.
    #[modulation(default = "")]
    trouble: Modulation<Text<16>>,
    /// The call that causes it: "awake", "iterate" or "sleep".
    #[modulation(default = "iterate")]
    place: Modulation<Text<16>>,
    /// The scans of a laser.
    #[import]
    input: Import<LaserScan>,
    /// The same scans.
    #[export]
    laser: Export<LaserScan>,
    /// Iterations of this instance so far.
    #[export]
    beats: Export<u64>,
    /// Faults of this instance so far.
    #[export(lasting)]
    misdeeds: Export<u64>,
    iterations: u64,
    faults: u64,
}

impl Schema for Eye {
    fn awake(&mut self, cx: &Context) -> Result {
        self.misbehave(cx, Call::Awake).map(drop)
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.iterations += 1;
        self.beats.write(cx, self.iterations);
        let fault = self.misbehave(cx, Call::Iterate)?;
        if fault == Some(FaultKind::Silence) {
            return Ok(());
        }
        let Some(input) = self.input.get(cx) else {
            self.laser.retract(cx);
            return Ok(());
        };
        for _ in 0..if fault == Some(FaultKind::Flood) { FLOOD } else { 1 } {
            let mut laser = self.laser.loan(cx);
            *laser = *input;
            if fault == Some(FaultKind::Nan) {
                laser.range_max = f32::NAN;
                laser.ranges.resize(0);
            }
            laser.publish_at(input.time());
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Err(error) = self.misbehave(cx, Call::Sleep) {
            warn!(cx, "{error}");
        }
    }
}

impl Eye {
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
