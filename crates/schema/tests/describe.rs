//! What `#[derive(Describe)]` says is what the host reads.

#![forbid(unsafe_code)]

use jde_schema::prelude::*;

/// Brakes while something is near.
#[derive(Describe)]
#[schema(motor, period = "200ms")]
pub struct StopNow {
    /// The laser ahead.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// Half the width.
    #[modulation(default = 0.3, unit = "m", min = 0.0)]
    half_width: Modulation<f64>,
    /// A map.
    #[modulation(default = "worlds/x", unit = "path", fixed)]
    path: Modulation<Text<256>>,
    /// Speeds.
    #[actuator]
    base: Actuator<Twist>,
    count: u32,
}

impl Schema for StopNow {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.count += 1;
        let _ = (self.laser.get(cx), self.half_width.get(cx), self.path.get(cx));
        self.base.command(cx, Twist::ZERO);
        Ok(())
    }
}

jde_schema::export!("stop", "One sentence.", [StopNow]);
