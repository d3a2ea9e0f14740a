//! A perceptive schema that passes a scan on, and does so wrong when it is told to.

use jde_schema::prelude::*;

use crate::orders::{Place, Trouble, Word, due};
use crate::trouble::make;

/// Scans that one iteration publishes when it floods.
const FLOOD: u32 = 200;

/// Passes a laser's scans on, and misbehaves as it is told.
#[derive(Describe)]
#[schema(perceptive, period = "50ms", budget = "10ms")]
pub struct Eye {
    /// What to do wrong for as long as it says so: "panic", "hang", "nan"; nothing if it is empty.
    #[modulation(default = "")]
    trouble: Modulation<Text<16>>,
    /// The call in which to do it: "awake", "iterate" or "sleep".
    #[modulation(default = "iterate")]
    place: Modulation<Text<16>>,
    /// What a laser sees.
    #[import]
    input: Import<LaserScan>,
    /// The same.
    #[export]
    laser: Export<LaserScan>,
    /// Iterations so far, of this instance.
    #[export]
    beats: Export<u64>,
    /// Misdeeds so far, of this instance.
    #[export]
    misdeeds: Export<u64>,
    looks: u64,
    bad: u64,
}

impl Schema for Eye {
    fn awake(&mut self, cx: &Context) -> Result {
        self.misbehave(cx, Place::Awake).map(drop)
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.looks += 1;
        self.beats.write(cx, self.looks);
        let habit = self.misbehave(cx, Place::Iterate)?;
        if habit == Some(Trouble::Silence) {
            return Ok(());
        }
        let Some(input) = self.input.get(cx) else {
            self.laser.retract(cx);
            return Ok(());
        };
        for _ in 0..if habit == Some(Trouble::Flood) { FLOOD } else { 1 } {
            let mut laser = self.laser.loan(cx);
            *laser = *input;
            if habit == Some(Trouble::Nan) {
                laser.range_max = f32::NAN;
                laser.ranges.resize(0);
            }
            laser.publish_at(input.time());
        }
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Err(error) = self.misbehave(cx, Place::Sleep) {
            warn!(cx, "{error}");
        }
    }
}

impl Eye {
    fn misbehave(&mut self, cx: &Context, here: Place) -> Result<Option<Trouble>> {
        let (trouble, place): (Word, Word) = (self.trouble.get(cx), self.place.get(cx));
        let due = due(&trouble, &place, here);
        if let Some(trouble) = due {
            self.bad += 1;
            self.misdeeds.write(cx, self.bad);
            make(trouble)?;
        }
        Ok(due)
    }
}
