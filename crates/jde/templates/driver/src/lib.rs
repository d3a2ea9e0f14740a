//! A gripper as a driver, and a schema that moves it. Put your hardware where the jaws are.

use jde_schema::prelude::*;

/// A gripper with two jaws; here they are simulated.
#[derive(Describe)]
#[schema(driver, period = "20ms")]
pub struct __Name__ {
    /// How far the jaws open.
    #[modulation(default = 0.1, unit = "m", min = 0.0, fixed)]
    widest: Modulation<f64>,
    /// How fast the jaws are to move; positive opens. Nobody commands: they stand still.
    #[command(neutral = 0.0, validity = "200ms", unit = "m/s")]
    speed: Command<f64>,
    /// How far the jaws are open.
    #[export(unit = "m")]
    opening: Export<f64>,
    jaws: Jaws,
}

/// What stands for the hardware: it moves by the speed it was told, until it is told another.
#[derive(Default)]
struct Jaws {
    opening: f64,
    moved: Duration,
}

impl Schema for __Name__ {
    /// Called before the first iteration, and whenever somebody needs it again: open the device here.
    fn awake(&mut self, cx: &Context) -> Result {
        self.jaws.moved = cx.now();
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let passed = cx.now().saturating_sub(self.jaws.moved);
        self.jaws.moved = cx.now();
        let way = *self.speed.get(cx) * passed.as_secs_f64();
        self.jaws.opening = (self.jaws.opening + way).clamp(0.0, self.widest.get(cx));
        self.opening.write(cx, self.jaws.opening);
        Ok(())
    }
}

/// Opens the jaws of a gripper and closes them again, over and over.
#[derive(Describe)]
#[schema(motor, period = "100ms")]
pub struct Exercise {
    /// How far the jaws are open.
    #[import(unit = "m")]
    opening: Import<f64>,
    /// How far to open them.
    #[modulation(default = 0.08, unit = "m", min = 0.0)]
    wide: Modulation<f64>,
    /// How fast the jaws are to move.
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
            info!(cx, "{} at {:.3} m", if self.closing { "closes" } else { "opens" }, *opening);
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
    fn the_jaws_move_as_commanded_and_stand_still_without_a_command() {
        let mut bench = Bench::<__Name__>::new();
        bench.awake().unwrap();
        bench.command("speed", &0.05);
        bench.set_now(Duration::from_millis(100));
        bench.iterate().unwrap();
        let opening = bench.exported::<f64>("opening").unwrap();
        assert!((opening - 0.005).abs() < 1e-9, "0.05 m/s for 0.1 s, not {opening} m");
        // The command is out of force by now.
        bench.set_now(Duration::from_millis(500));
        bench.iterate().unwrap();
        assert_eq!(bench.exported::<f64>("opening"), Some(opening));
    }

    #[test]
    fn the_exercise_turns_round_at_either_end() {
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
