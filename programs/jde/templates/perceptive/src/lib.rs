//! A perceptive schema that finds the nearest obstacle, and a motor schema that turns to it.

use jde_schema::prelude::*;

/// Finds the nearest obstacle in a laser scan.
#[derive(Describe)]
#[schema(perceptive, period = "100ms")]
pub struct __Name__ {
    /// The scan of the laser. A new scan triggers an iteration.
    #[import(trigger)]
    laser: Import<LaserScan>,
    /// Obstacles at a greater distance are ignored.
    #[modulation(default = 5.0, unit = "m", min = 0.0)]
    farthest: Modulation<f64>,
    /// Position of the nearest obstacle in the frame of the laser. It has no value while there is none.
    #[export]
    nearest: Export<Pose2D>,
}

impl Schema for __Name__ {
    /// One iteration; called every period while an awake schema imports its export.
    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(laser) = self.laser.get(cx) else { return Ok(()) };
        match nearest(&laser, self.farthest.get(cx)) {
            // The export is as old as the scan that it results from.
            Some(place) => self.nearest.write_at(cx, place, laser.time()),
            None => self.nearest.retract(cx),
        }
        Ok(())
    }
}

fn nearest(laser: &LaserScan, farthest: f64) -> Option<Pose2D> {
    let near = laser.points().filter(|point| point.range <= farthest);
    let point = near.min_by(|one, other| one.range.total_cmp(&other.range))?;
    Some(Pose2D::new(point.x, point.y, 0.0))
}

/// Its panel, which is drawn while a window or `jde panel` shows it.
impl Panel for __Name__ {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let Some(laser) = self.laser.get(cx) else { return };
        let nearest = nearest(&laser, self.farthest.get(cx));
        let distance = nearest.map_or(f64::INFINITY, |place| place.distance_to(&Pose2D::ORIGIN));
        pen.value("distance", distance, "m");
        pen.canvas("around").forward_up().show(|around| {
            around.points(laser.points()).ink(Ink::Seen);
            if let Some(place) = nearest {
                around.line([Pose2D::ORIGIN, place]).ink(Ink::Goal);
            }
            around.robot(&Pose2D::ORIGIN);
        });
    }
}

/// Turns to the nearest obstacle, which the other schema finds.
#[derive(Describe)]
#[schema(motor, period = "100ms")]
pub struct Face {
    /// Position of the nearest obstacle.
    #[import(trigger)]
    nearest: Import<Pose2D>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
}

impl Schema for Face {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.nearest.get(cx).is_some().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let bearing = Pose2D::ORIGIN.bearing_to(&*self.nearest.require(cx)?);
        self.base.command(cx, Twist::planar(0.0, bearing.clamp(-0.5, 0.5)));
        Ok(())
    }
}

jde_schema::export!("__name__", "Finds the nearest obstacle.", [__Name__, Face]);

#[cfg(test)]
mod tests {
    use jde_schema::bench::Bench;

    use super::*;

    /// A scan with three beams: to the right, straight ahead and to the left.
    fn scan(ranges: [f32; 3]) -> LaserScan {
        let right = -core::f32::consts::FRAC_PI_2;
        let ranges = Seq::from_slice(&ranges).unwrap();
        LaserScan { angle_min: right, angle_max: -right, angle_increment: -right, range_max: 8.0, ranges, ..LaserScan::default() }
    }

    #[test]
    fn it_finds_the_nearest_obstacle() {
        let mut bench = Bench::<__Name__>::new();
        bench.import("laser", &scan([3.0, 2.0, 1.0]));
        bench.iterate().unwrap();
        let nearest = bench.exported::<Pose2D>("nearest").unwrap();
        assert!(nearest.distance_to(&Pose2D::new(0.0, 1.0, 0.0)) < 1e-3, "expected on the left, got {nearest:?}");
        assert!((bench.draw().unwrap().value("distance") - 1.0).abs() < 1e-3);
    }

    #[test]
    fn it_retracts_its_export_when_there_is_no_obstacle() {
        let mut bench = Bench::<__Name__>::new();
        for (range, found) in [(4.0, true), (6.0, false)] {
            bench.import("laser", &scan([range; 3]));
            bench.iterate().unwrap();
            assert_eq!(bench.exported::<Pose2D>("nearest").is_some(), found, "{range} m");
        }
    }

    #[test]
    fn the_robot_turns_to_the_nearest_obstacle() {
        let mut bench = Bench::<Face>::new();
        assert!(!bench.check().unwrap().ready, "there is no obstacle");
        bench.import("nearest", &Pose2D::new(0.0, 1.0, 0.0));
        assert!(bench.check().unwrap().ready);
        bench.iterate().unwrap();
        assert_eq!(bench.commanded("base"), Some(Twist::planar(0.0, 0.5)));
    }
}
