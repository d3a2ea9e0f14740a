//! A father with two children: it wakes them, sets the target of one, and arbitrates between them.

use jde_schema::prelude::*;

/// Drives back and forth between two places, by its children.
#[derive(Describe)]
#[schema(motor, period = "100ms")]
pub struct __Name__ {
    /// Pose of the robot.
    #[import]
    pose: Import<Odometry>,
    /// The first place, in the frame of the odometry.
    #[modulation(default = Pose2D::new(1.5, 1.5, 0.0))]
    first: Modulation<Pose2D>,
    /// The second place, in the same frame.
    #[modulation(default = Pose2D::new(4.5, 1.5, 0.0))]
    second: Modulation<Pose2D>,
    /// The robot has reached a place at this distance from it.
    #[modulation(default = 0.3, unit = "m", min = 0.0)]
    tolerance: Modulation<f64>,
    /// Stops in front of a close obstacle.
    #[child(group = "base")]
    brake: Child,
    /// Drives to its target.
    #[child(group = "base")]
    cruise: Child,
    /// The target of `cruise`.
    #[modulates(child = "cruise")]
    target: Modulates<Target>,
    returning: bool,
}

impl Schema for __Name__ {
    /// One iteration; called every period while it is WINNER. Without a `check` it is always ready.
    fn iterate(&mut self, cx: &Context) -> Result {
        self.brake.wake(cx);
        self.cruise.wake(cx);
        let place = self.place(cx);
        if let Some(pose) = self.pose.get(cx)
            && pose.pose2d().distance_to(&place) < self.tolerance.get(cx)
        {
            self.returning = !self.returning;
            info!(cx, "reached {:.2}, {:.2}", place.x, place.y);
        }
        self.target.set(cx, Target::at(self.place(cx)));
        Ok(())
    }
}

impl __Name__ {
    fn place(&self, cx: &Context) -> Pose2D {
        if self.returning { self.first.get(cx) } else { self.second.get(cx) }
    }
}

/// Arbitrates when both children are ready, or none is. Without it, the first child that is ready wins.
impl Arbitrate for __Name__ {
    fn arbitrate(&mut self, _: &Context, level: &Level) -> Result<Verdict> {
        if level.is_ready(&self.brake) {
            return Ok(Verdict::choose(&self.brake, "an obstacle is too close"));
        }
        Ok(Verdict::nobody("no child is ready"))
    }
}

jde_schema::export!("__name__", "Drives back and forth between two places.", [__Name__]);

#[cfg(test)]
mod tests {
    use jde_schema::bench::Bench;

    use super::*;

    #[test]
    fn it_drives_back_and_forth() {
        let mut bench = Bench::<__Name__>::new();
        let (first, second) = (Pose2D::new(1.5, 1.5, 0.0), Pose2D::new(4.5, 1.5, 0.0));
        for (at, to) in [(first, second), (second, first), (second, first), (first, second)] {
            bench.import("pose", &Odometry::planar(Time::default(), at, Twist::ZERO));
            bench.iterate().unwrap();
            assert_eq!(bench.modulated("cruise", "target"), Some(Target::at(to)));
        }
        assert_eq!(bench.awake_children(), ["brake", "cruise"]);
    }

    #[test]
    fn the_brake_wins_when_both_children_are_ready() {
        let mut bench = Bench::<__Name__>::new();
        bench.set_child("brake", State::Ready);
        bench.set_child("cruise", State::Winner);
        assert_eq!(bench.arbitrate("base").unwrap().child.as_deref(), Some("brake"));
        bench.set_child("brake", State::Checking);
        bench.set_child("cruise", State::Checking);
        assert_eq!(bench.arbitrate("base").unwrap().child, None);
    }
}
