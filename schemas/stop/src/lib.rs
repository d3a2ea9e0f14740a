//! Brakes while something stands in a very close area ahead (the paper, section 5). It decides nothing else: who wins when
//! others are ready too is the father's business.

use jde_schema::prelude::*;

/// Brakes the base while an obstacle stands in a very close area ahead.
#[derive(Describe)]
#[schema(motor, period = "200ms", budget = "20ms")]
pub struct Stop {
    /// What the laser sees ahead.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// Half the width of the watched area.
    #[modulation(default = 0.3, unit = "m", min = 0.0)]
    half_width: Modulation<f64>,
    /// How far ahead of the laser the watched area reaches.
    #[modulation(default = 0.6, unit = "m", min = 0.0)]
    ahead: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
}

impl Schema for Stop {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let Some(laser) = self.laser.get(cx) else {
            return Ok(false.into());
        };
        let nearest = laser.nearest_ahead(self.half_width.get(cx));
        Ok(nearest.is_some_and(|ahead| ahead <= self.ahead.get(cx)).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.base.command(cx, Twist::ZERO);
        Ok(())
    }
}

jde_schema::export!("stop", "Brakes before obstacles that are very close.", [Stop]);

#[cfg(test)]
mod tests;
