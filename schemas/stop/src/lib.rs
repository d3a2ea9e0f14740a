//! Brakes while an obstacle is in a very close area ahead (the paper, section 5), or nobody knows whether one is. It does
//! not arbitrate: the father chooses among several schemas that are READY.

use jde_schema::prelude::*;
use jde_schema::types::Ahead;

/// Brakes the base while an obstacle is in a very close area ahead, and while it does not see that area: without a
/// scan, and while no beam measures anything in the area. So it goes on braking when the laser fails.
#[derive(Describe)]
#[schema(motor, period = "200ms", budget = "20ms")]
pub struct Stop {
    /// The scan of the laser.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// Half the width of the watched area.
    #[modulation(default = 0.3, unit = "m", min = 0.0, max = 5.0)]
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
        Ok((self.look(cx) != Ahead::Free).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.base.command(cx, Twist::ZERO);
        Ok(())
    }
}

impl Stop {
    /// What is in the watched area.
    fn look(&self, cx: &Context) -> Ahead {
        let (side, ahead) = (self.half_width.get(cx), self.ahead.get(cx));
        let laser = self.laser.get(cx);
        laser.map_or(Ahead::Unseen, |laser| laser.ahead(side, ahead))
    }
}

impl Panel for Stop {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let (side, ahead) = (self.half_width.get(cx), self.ahead.get(cx));
        let seen = self.look(cx);
        match seen {
            Ahead::Hit(nearest) => pen.value("nearest ahead", nearest, "m"),
            Ahead::Free => pen.text("nothing in the area"),
            Ahead::Unseen => pen.text("the laser does not see the area"),
        }
        let canvas = pen.canvas("area").forward_up();
        canvas.area((-0.5, -1.5), (2.5, 1.5)).show(|area| {
            area.rectangle((0.0, -side), (ahead, side))
                .ink(if seen == Ahead::Free { Ink::Good } else { Ink::Bad })
                .width(2.0);
            if let Some(laser) = self.laser.get(cx) {
                area.points(laser.points()).ink(Ink::Seen).width(2.5);
            }
            if let Ahead::Hit(nearest) = seen {
                area.line([(nearest, -side), (nearest, side)]).ink(Ink::Warn);
            }
            area.robot(&Pose2D::ORIGIN);
        });
    }
}

jde_schema::export!("stop", "Brakes before obstacles that are very close.", [Stop]);

#[cfg(test)]
mod tests;
