//! Drives up to what is ahead and waits there.

use jde_schema::prelude::*;

/// Drives straight ahead, slower the nearer something is, and stands still at a distance from it.
#[derive(Describe)]
#[schema(motor, period = "100ms")]
pub struct __Name__ {
    /// What the laser sees ahead; a new scan is looked at as soon as it is there.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// Where to stop.
    #[modulation(default = 0.5, unit = "m", min = 0.0)]
    distance: Modulation<f64>,
    /// Speed far from everything.
    #[modulation(default = 0.4, unit = "m/s", min = 0.0)]
    speed: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
}

/// Half the width of the way that must be free: the robot's and a hand's breadth, m.
const HALF_WIDTH: f64 = 0.35;

impl Schema for __Name__ {
    /// It wants to act while it can see.
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.laser.get(cx).is_some().into())
    }

    /// One step; called every period while it is WINNER.
    fn iterate(&mut self, cx: &Context) -> Result {
        let room = match self.laser.require(cx)?.nearest_ahead(HALF_WIDTH) {
            Some(nearest) => nearest - self.distance.get(cx),
            None => f64::INFINITY,
        };
        // A metre to go is time enough to slow down from full speed.
        let speed = self.speed.get(cx) * room.clamp(0.0, 1.0);
        self.base.command(cx, Twist::planar(speed, 0.0));
        Ok(())
    }
}

/// What it shows to whoever looks; nothing here changes what it does.
impl Panel for __Name__ {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let distance = self.distance.get(cx);
        pen.value("distance", distance, "m");
        pen.canvas("ahead").forward_up().show(|ahead| {
            if let Some(laser) = self.laser.get(cx) {
                ahead.points(laser.points()).ink(Ink::Seen);
            }
            ahead.line([(distance, -HALF_WIDTH), (distance, HALF_WIDTH)]).ink(Ink::Goal);
            ahead.robot(&Pose2D::ORIGIN);
        });
    }
}

jde_schema::export!("__name__", "Drives up to what is ahead.", [__Name__]);

#[cfg(test)]
mod tests {
    use jde_schema::bench::Bench;

    use super::*;

    /// A laser that looks straight ahead with one beam.
    fn sees(range: f32) -> LaserScan {
        let ranges = Seq::from_slice(&[range]).unwrap();
        LaserScan { range_max: 8.0, ranges, ..LaserScan::default() }
    }

    fn speed_at(range: f32) -> f64 {
        let mut bench = Bench::<__Name__>::new();
        bench.import("laser", &sees(range));
        assert!(bench.check().unwrap().ready);
        bench.iterate().unwrap();
        bench.commanded::<Twist>("base").unwrap().linear.x
    }

    #[test]
    fn it_waits_until_it_can_see() {
        assert!(!Bench::<__Name__>::new().check().unwrap().ready);
    }

    #[test]
    fn it_drives_slower_the_nearer_something_is_and_stops_at_its_distance() {
        assert_eq!(speed_at(5.0), 0.4);
        assert!(speed_at(1.0) < 0.4);
        assert_eq!(speed_at(0.5), 0.0);
        assert_eq!(speed_at(0.2), 0.0);
    }

    #[test]
    fn its_panel_shows_where_it_stops() {
        let mut bench = Bench::<__Name__>::new();
        bench.set("distance", 0.8);
        assert_eq!(bench.draw().unwrap().value("distance"), 0.8);
    }
}
