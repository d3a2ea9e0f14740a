//! A driver for a gripper, and a schema that moves it. Replace the simulated jaws by your hardware.

use jde_schema::prelude::*;

/// A gripper with two simulated jaws.
#[derive(Describe)]
#[schema(driver, period = "20ms")]
pub struct __Name__ {
    /// Greatest opening of the jaws.
    #[modulation(default = 0.1, unit = "m", min = 0.0, fixed)]
    widest: Modulation<f64>,
    /// Speed of the jaws; positive opens them. Without a command they do not move.
    #[command(neutral = 0.0, validity = "200ms", unit = "m/s")]
    speed: Command<f64>,
    /// Opening of the jaws.
    #[export(unit = "m")]
    opening: Export<f64>,
    jaws: Jaws,
}

/// Simulated hardware.
#[derive(Default)]
struct Jaws {
    opening: f64,
    moved: Duration,
}

impl Schema for __Name__ {
    /// Called before the first iteration, and again after each sleep: open the device here.
    fn awake(&mut self, cx: &Context) -> Result {
        self.jaws.moved = cx.now();
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let passed = cx.now().saturating_sub(self.jaws.moved);
        self.jaws.moved = cx.now();
        let distance = *self.speed.get(cx) * passed.as_secs_f64();
        self.jaws.opening = (self.jaws.opening + distance).clamp(0.0, self.widest.get(cx));
        self.opening.write(cx, self.jaws.opening);
        Ok(())
    }
}

/// Opens and closes the jaws of a gripper repeatedly.
#[derive(Describe)]
#[schema(motor, period = "100ms")]
pub struct Exercise {
    /// Opening of the jaws.
    #[import(unit = "m")]
    opening: Import<f64>,
    /// Opening at which the jaws close again.
    #[modulation(default = 0.08, unit = "m", min = 0.0)]
    wide: Modulation<f64>,
    /// Speed of the jaws.
    #[actuator(unit = "m/s")]
    jaws: Actuator<f64>,
    closing: bool,
}

/// Speed of the jaws, m/s.
const SPEED: f64 = 0.05;

impl Schema for Exercise {
    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(opening) = self.opening.get(cx) else { return Ok(()) };
        let turns = if self.closing { *opening <= 0.0 } else { *opening >= self.wide.get(cx) };
        if turns {
            self.closing = !self.closing;
            info!(cx, "{} at {:.3} m", if self.closing { "closing" } else { "opening" }, *opening);
        }
        self.jaws.command(cx, if self.closing { -SPEED } else { SPEED });
        Ok(())
    }
}

jde_schema::export!("__name__", "A gripper.", [__Name__, Exercise]);

#[cfg(test)]
mod tests {
    use jde_schema::bench::Bench;

    use super::*;

    #[test]
    fn the_jaws_move_as_commanded_and_stop_without_a_command() {
        let mut bench = Bench::<__Name__>::new();
        bench.awake().unwrap();
        bench.command("speed", &0.05);
        bench.set_now(Duration::from_millis(100));
        bench.iterate().unwrap();
        let opening = bench.exported::<f64>("opening").unwrap();
        assert!((opening - 0.005).abs() < 1e-9, "0.05 m/s for 0.1 s moved the jaws by {opening} m");
        // The command is no longer in force.
        bench.set_now(Duration::from_millis(500));
        bench.iterate().unwrap();
        assert_eq!(bench.exported::<f64>("opening"), Some(opening));
    }

    #[test]
    fn the_jaws_change_direction_at_both_ends() {
        let mut bench = Bench::<Exercise>::new();
        let mut commanded_at = |opening: f64| {
            bench.import("opening", &opening);
            bench.iterate().unwrap();
            bench.commanded::<f64>("jaws").unwrap()
        };
        assert_eq!(commanded_at(0.0), SPEED);
        assert_eq!(commanded_at(0.08), -SPEED);
        assert_eq!(commanded_at(0.04), -SPEED);
        assert_eq!(commanded_at(0.0), SPEED);
    }
}
