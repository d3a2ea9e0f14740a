//! A father of two children: it wakes them, gives one of them its targets, and decides between them.

use jde_schema::prelude::*;

/// Sends its children from one place to another and back.
#[derive(Describe)]
#[schema(motor, period = "100ms")]
pub struct __Name__ {
    /// Where the robot is.
    #[import]
    pose: Import<Odometry>,
    /// One place, in the frame of the odometry.
    #[modulation(default = Pose2D::new(1.5, 1.5, 0.0))]
    first: Modulation<Pose2D>,
    /// The other.
    #[modulation(default = Pose2D::new(4.5, 1.5, 0.0))]
    second: Modulation<Pose2D>,
    /// How near to a place is there.
    #[modulation(default = 0.3, unit = "m", min = 0.0)]
    tolerance: Modulation<f64>,
    /// Stops before what is very close.
    #[child(group = "base")]
    brake: Child,
    /// Drives to its target.
    #[child(group = "base")]
    cruise: Child,
    /// Where `cruise` is to go.
    #[modulates(child = "cruise")]
    target: Modulates<Target>,
    returning: bool,
}

impl Schema for __Name__ {
    /// One step; called every period while it is WINNER. Without a check it is always ready.
    fn iterate(&mut self, cx: &Context) -> Result {
        self.brake.wake(cx);
        self.cruise.wake(cx);
        let place = self.place(cx);
        if let Some(pose) = self.pose.get(cx)
            && pose.pose2d().distance_to(&place) < self.tolerance.get(cx)
        {
            self.returning = !self.returning;
            info!(cx, "is at {:.2}, {:.2}", place.x, place.y);
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

/// Decides when both children are ready, or none is. Without it, the first that is ready wins.
impl Arbitrate for __Name__ {
    fn arbitrate(&mut self, _: &Context, level: &Level) -> Result<Verdict> {
        if level.is_ready(&self.brake) {
            return Ok(Verdict::choose(&self.brake, "something is too close to drive on"));
        }
        Ok(Verdict::nobody("there is nothing to do"))
    }
}

jde_schema::export!("__name__", "Sends a robot back and forth.", [__Name__]);

#[cfg(test)]
mod tests {
    use jde_schema::bench::Bench;

    use super::*;

    #[test]
    fn it_sends_its_children_back_and_forth() {
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
    fn the_brake_wins_where_both_are_ready() {
        let mut bench = Bench::<__Name__>::new();
        bench.set_child("brake", State::Ready);
        bench.set_child("cruise", State::Winner);
        assert_eq!(bench.arbitrate("base").unwrap().child.as_deref(), Some("brake"));
        bench.set_child("brake", State::Checking);
        bench.set_child("cruise", State::Checking);
        assert_eq!(bench.arbitrate("base").unwrap().child, None);
    }
}
