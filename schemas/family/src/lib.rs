//! The second toy of the paper: a father and two children with overlapping preconditions, each with a period
//! of 1 s.

use jde_schema::prelude::*;
use jde_schema::types::Echo;

/// Keeps two children awake. The arbitration prefers the child that it declares first.
#[derive(Describe)]
#[schema(motor, period = "1s", budget = "20ms")]
pub struct Padre {
    /// Drives fast while there is much room ahead.
    #[child(group = "base")]
    first: Child,
    /// Drives slowly while there is less room ahead.
    #[child(group = "base")]
    second: Child,
}

/// Drives ahead at 0.2 m/s while the room ahead is 4.5 to 8 m.
#[derive(Describe)]
#[schema(motor, period = "1s", budget = "20ms")]
pub struct Hijo1 {
    /// The scan of the laser.
    #[import]
    laser: Import<LaserScan>,
    /// Least room straight ahead for it to be ready.
    #[modulation(default = 4.5, unit = "m", min = 0.0)]
    from: Modulation<f64>,
    /// Most room straight ahead for it to be ready.
    #[modulation(default = 8.0, unit = "m", min = 0.0)]
    to: Modulation<f64>,
    /// Forward speed.
    #[modulation(default = 0.2, unit = "m/s", min = 0.0)]
    speed: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
}

/// Drives ahead at 0.1 m/s while the room ahead is 1 to 5 m. From 4.5 to 5 m both children are ready.
#[derive(Describe)]
#[schema(motor, period = "1s", budget = "20ms")]
pub struct Hijo2 {
    /// The scan of the laser.
    #[import]
    laser: Import<LaserScan>,
    /// Least room straight ahead for it to be ready.
    #[modulation(default = 1.0, unit = "m", min = 0.0)]
    from: Modulation<f64>,
    /// Most room straight ahead for it to be ready.
    #[modulation(default = 5.0, unit = "m", min = 0.0)]
    to: Modulation<f64>,
    /// Forward speed.
    #[modulation(default = 0.1, unit = "m/s", min = 0.0)]
    speed: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
}

impl Schema for Padre {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.first.wake(cx);
        self.second.wake(cx);
        Ok(())
    }
}

impl Schema for Hijo1 {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(has_room(self.laser.get(cx), self.from.get(cx), self.to.get(cx)))
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.base.command(cx, Twist::planar(self.speed.get(cx), 0.0));
        Ok(())
    }
}

impl Schema for Hijo2 {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(has_room(self.laser.get(cx), self.from.get(cx), self.to.get(cx)))
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.base.command(cx, Twist::planar(self.speed.get(cx), 0.0));
        Ok(())
    }
}

/// Whether the beam straight ahead measures between `from` and `to`. A beam without a return counts as the
/// scanner's maximum range; a beam without a measurement (NaN) counts as no room.
fn has_room(laser: Option<Sample<'_, LaserScan>>, from: f64, to: f64) -> Precondition {
    let Some(laser) = laser else { return false.into() };
    let ahead =
        (laser.echoes()).min_by(|(a, _), (b, _)| laser.angle(*a).abs().total_cmp(&laser.angle(*b).abs()));
    let room = match ahead.map(|(_, echo)| echo) {
        Some(Echo::Hit(range)) => range,
        Some(Echo::Free) => laser.range_max,
        Some(Echo::TooClose | Echo::Nothing) | None => return false.into(),
    };
    (from..=to).contains(&f64::from(room)).into()
}

jde_schema::export!(
    "family",
    "The paper's second toy: padre, hijo1 and hijo2.",
    [Padre, Hijo1, Hijo2]
);

#[cfg(test)]
mod tests;
