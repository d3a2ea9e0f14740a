//! A base whose commands a guard judges, among as many points as a laser has beams.

use std::f64::consts::TAU;
use std::time::Duration;

use jde_motion::{BaseDynamics, Surroundings};
use jde_schema::prelude::*;
use jde_schema::types::{Footprint, Point2D};

/// As many points as the laser of a TurtleBot 4 has beams.
pub const BEAMS: u32 = 720;
/// How far away they are, m: as in a room.
const DISTANCE: f64 = 2.0;
/// The speed of the base, m/s.
pub const SPEED: f64 = 0.3;

/// Exports what is around a base that drives at [`SPEED`] in the middle of a ring of points.
#[derive(Describe)]
#[schema(perceptive, period = "50ms")]
pub struct Watch {
    /// What it judges by.
    #[export]
    surroundings: Export<Surroundings>,
    around: Surroundings,
}

/// Commands the base.
#[derive(Describe)]
#[schema(motor, period = "1ms")]
pub struct Drive {
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
}

/// A base that reads its commands.
#[derive(Describe)]
#[schema(driver, period = "1ms")]
pub struct Base {
    /// The commanded velocity.
    #[command(neutral = Twist::ZERO, validity = "100ms")]
    velocity: Command<Twist>,
    /// The commanded speed.
    #[export]
    speed: Export<f64>,
}

/// Returns what is around the base.
#[must_use]
pub fn surroundings() -> Surroundings {
    let mut around = Surroundings {
        velocity: Twist::planar(SPEED, 0.0),
        footprint: Footprint::circle(0.25),
        reaction: 0.15,
        margin: 0.05,
        dynamics: BaseDynamics {
            acceleration: 0.3,
            deceleration: 0.3,
            turn_acceleration: 1.0,
            turn_deceleration: 1.0,
            lag: 0.0,
        },
        ..Surroundings::default()
    };
    let points = around.points.resize(BEAMS as usize);
    for (beam, point) in (0..BEAMS).zip(points) {
        let (sin, cos) = (TAU * f64::from(beam) / f64::from(BEAMS)).sin_cos();
        *point = Point2D {
            x: DISTANCE * cos,
            y: DISTANCE * sin,
        };
    }
    around
}

impl Schema for Watch {
    fn awake(&mut self, _: &Context) -> jde_schema::Result {
        self.around = surroundings();
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> jde_schema::Result {
        self.surroundings.write(cx, self.around);
        Ok(())
    }
}

impl Guard for Watch {
    type State = Surroundings;
    type Command = Twist;
    const STATE_EXPORT: &'static str = "surroundings";

    fn judge(state: &Surroundings, age: Duration, command: &Twist) -> Result<(), String> {
        state.judge(age, command)
    }
}

impl Schema for Drive {
    fn iterate(&mut self, cx: &Context) -> jde_schema::Result {
        self.base.command(cx, Twist::planar(SPEED, 0.0));
        Ok(())
    }
}

impl Schema for Base {
    fn iterate(&mut self, cx: &Context) -> jde_schema::Result {
        self.speed.write(cx, self.velocity.get(cx).linear.x);
        Ok(())
    }
}
