//! Drives up to the obstacle ahead and stops in front of it.

use jde_schema::prelude::*;

/// Drives straight ahead, slows down near an obstacle, and stops at a distance from it.
#[derive(Describe)]
#[schema(motor, period = "100ms")]
pub struct __Name__ {
    /// The scan of the laser. A new scan triggers a check.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// Distance to the obstacle at which the robot stops.
    #[modulation(default = 0.5, unit = "m", min = 0.0)]
    distance: Modulation<f64>,
    /// Speed far from all obstacles.
    #[modulation(default = 0.4, unit = "m/s", min = 0.0)]
    speed: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
}

/// Half the width of the area that must be free: that of the robot and a margin, m.
const HALF_WIDTH: f64 = 0.35;

impl Schema for __Name__ {
    /// The precondition: it can act while there is a scan.
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.laser.get(cx).is_some().into())
    }

    /// One iteration; called every period while it is WINNER.
    fn iterate(&mut self, cx: &Context) -> Result {
        let room = match self.laser.require(cx)?.nearest_ahead(HALF_WIDTH) {
            Some(nearest) => nearest - self.distance.get(cx),
            None => f64::INFINITY,
        };
        // One metre is enough to slow down from full speed.
        let speed = self.speed.get(cx) * room.clamp(0.0, 1.0);
        self.base.command(cx, Twist::planar(speed, 0.0));
        Ok(())
    }
}

/// Its panel, which is drawn while a window or `jde panel` shows it.
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

jde_schema::export!("__name__", "Drives up to the obstacle ahead.", [__Name__]);

#[cfg(test)]
mod tests {
    use jde_schema::bench::Bench;

    use super::*;

    /// A scan with one beam, straight ahead.
    fn scan(range: f32) -> LaserScan {
        let ranges = Seq::from_slice(&[range]).unwrap();
        LaserScan { range_max: 8.0, ranges, ..LaserScan::default() }
    }

    fn speed_at(range: f32) -> f64 {
        let mut bench = Bench::<__Name__>::new();
        bench.import("laser", &scan(range));
        assert!(bench.check().unwrap().ready);
        bench.iterate().unwrap();
        bench.commanded::<Twist>("base").unwrap().linear.x
    }

    #[test]
    fn it_is_not_ready_without_a_scan() {
        assert!(!Bench::<__Name__>::new().check().unwrap().ready);
    }

    #[test]
    fn it_slows_down_near_an_obstacle_and_stops_at_a_distance() {
        assert_eq!(speed_at(5.0), 0.4);
        assert!(speed_at(1.0) < 0.4);
        assert_eq!(speed_at(0.5), 0.0);
        assert_eq!(speed_at(0.2), 0.0);
    }

    #[test]
    fn its_panel_shows_the_distance_at_which_it_stops() {
        let mut bench = Bench::<__Name__>::new();
        bench.set("distance", 0.8);
        assert_eq!(bench.draw().unwrap().value("distance"), 0.8);
    }
}
