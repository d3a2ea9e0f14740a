//! Brakes while an obstacle is in a very close area ahead (the paper, section 5). It does not arbitrate: the
//! father chooses among several schemas that are READY.

use jde_schema::prelude::*;

/// Brakes the base while an obstacle is in a very close area ahead.
#[derive(Describe)]
#[schema(motor, period = "200ms", budget = "20ms")]
pub struct Stop {
    /// The scan of the laser.
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
        let ahead = self.ahead.get(cx);
        Ok(self.nearest(cx).is_some_and(|nearest| nearest <= ahead).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.base.command(cx, Twist::ZERO);
        Ok(())
    }
}

impl Stop {
    /// Distance ahead to the nearest obstacle in the robot's path, m.
    fn nearest(&self, cx: &Context) -> Option<f64> {
        self.laser.get(cx)?.nearest_ahead(self.half_width.get(cx))
    }
}

impl Panel for Stop {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let (side, ahead) = (self.half_width.get(cx), self.ahead.get(cx));
        let nearest = self.nearest(cx);
        let near = nearest.is_some_and(|nearest| nearest <= ahead);
        match nearest {
            Some(nearest) => pen.value("nearest ahead", nearest, "m"),
            None => pen.text("nothing ahead"),
        }
        let canvas = pen.canvas("area").forward_up();
        canvas.area((-0.5, -1.5), (2.5, 1.5)).show(|area| {
            area.rectangle((0.0, -side), (ahead, side))
                .ink(if near { Ink::Bad } else { Ink::Good })
                .width(2.0);
            if let Some(laser) = self.laser.get(cx) {
                area.points(laser.points()).ink(Ink::Seen).width(2.5);
            }
            if let Some(nearest) = nearest {
                area.line([(nearest, -side), (nearest, side)]).ink(Ink::Warn);
            }
            area.robot(&Pose2D::ORIGIN);
        });
    }
}

jde_schema::export!("stop", "Brakes before obstacles that are very close.", [Stop]);

#[cfg(test)]
mod tests;
