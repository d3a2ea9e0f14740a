//! Drives the base by a gamepad while its dead-man's button is held. It reads no other sensor and avoids no obstacle: the
//! person watches the path.

use jde_joy::Joy;
use jde_schema::prelude::*;

use crate::ramp::{Limits, Ramp};

/// Drives the base by the sticks of a gamepad, while a person holds its enable button.
///
/// It is ready while the button is held. A pad that was not there, or that came back, needs the button anew: it must have been
/// seen released since. The parameters are those of ROS's `teleop_twist_joy`; the number -1 stands for none.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "10ms")]
pub struct Gamepad {
    /// What the person holds.
    #[import(trigger)]
    joy: Import<Joy>,
    /// The dead-man's button. By default it is the left shoulder.
    #[modulation(default = 9, min = -1, max = 31)]
    enable_button: Modulation<i32>,
    /// Another one, for the turbo speeds.
    #[modulation(default = -1, min = -1, max = 31)]
    enable_turbo_button: Modulation<i32>,
    /// The axis for the speed ahead. By default it is the left stick.
    #[modulation(default = 1, min = -1, max = 15)]
    axis_linear: Modulation<i32>,
    /// The axis for the speed to the left, of an omnidirectional base.
    #[modulation(default = -1, min = -1, max = 15)]
    axis_linear_y: Modulation<i32>,
    /// The axis for the turn rate.
    #[modulation(default = 0, min = -1, max = 15)]
    axis_angular: Modulation<i32>,
    /// The speed at the end of its axis, ahead and to the left; a negative one turns the axis round.
    #[modulation(default = 0.5, unit = "m/s", min = -10.0, max = 10.0)]
    scale_linear: Modulation<f64>,
    /// The same with the turbo button.
    #[modulation(default = 1.0, unit = "m/s", min = -10.0, max = 10.0)]
    scale_linear_turbo: Modulation<f64>,
    /// The turn rate at the end of its axis; a negative one turns the axis round.
    #[modulation(default = 1.0, unit = "rad/s", min = -20.0, max = 20.0)]
    scale_angular: Modulation<f64>,
    /// The same with the turbo button.
    #[modulation(default = 1.0, unit = "rad/s", min = -20.0, max = 20.0)]
    scale_angular_turbo: Modulation<f64>,
    /// Highest increase of the speed per second. Decreases are not limited here, only by the base.
    #[modulation(default = 0.6, unit = "m/s2", min = 0.01)]
    acceleration: Modulation<f64>,
    /// Highest increase of the turn rate per second.
    #[modulation(default = 3.0, unit = "rad/s2", min = 0.01)]
    turn_acceleration: Modulation<f64>,
    /// Speeds of the base.
    #[actuator]
    base: Actuator<Twist>,
    /// Whether the pad was seen without a held button since it is there.
    armed: bool,
    /// What is wrong with the numbers, as it was last said.
    said: String,
    ramp: Ramp,
}

impl Schema for Gamepad {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.wish(cx).is_some().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let twist = match self.wish(cx) {
            Some((wish, limits)) => self.ramp.follow(cx.now(), &wish, &limits),
            None => self.ramp.stand(cx.now()),
        };
        self.base.command(cx, twist);
        Ok(())
    }

    /// A button that is held when it awakes was not pressed for it.
    fn sleep(&mut self, _: &Context) {
        self.armed = false;
    }
}

impl Gamepad {
    /// What the person wishes, if a button is held that counts.
    fn wish(&mut self, cx: &Context) -> Option<(Twist, Limits)> {
        let Some(joy) = self.joy.get(cx) else {
            self.armed = false;
            return None;
        };
        let turbo = self.is_held(&joy, self.enable_turbo_button.get(cx));
        if !turbo && !self.is_held(&joy, self.enable_button.get(cx)) {
            self.armed = true;
            self.name_what_is_missing(cx, &joy);
            return None;
        }
        let (linear, angular) = if turbo {
            (&self.scale_linear_turbo, &self.scale_angular_turbo)
        } else {
            (&self.scale_linear, &self.scale_angular)
        };
        let (linear, angular) = (linear.get(cx), angular.get(cx));
        let position = |number: &Modulation<i32>| match number.get(cx) {
            -1 => Some(0.0),
            number => joy.axis(number).map(|position| position.clamp(-1.0, 1.0)),
        };
        let mut wish = Twist::planar(
            linear * position(&self.axis_linear)?,
            angular * position(&self.axis_angular)?,
        );
        wish.linear.y = linear * position(&self.axis_linear_y)?;
        let limits = Limits {
            speed: linear.abs(),
            turn: angular.abs(),
            acceleration: self.acceleration.get(cx),
            turn_acceleration: self.turn_acceleration.get(cx),
        };
        self.armed.then_some((wish, limits))
    }

    fn is_held(&self, joy: &Joy, button: i32) -> bool {
        joy.is_pressed(button) == Some(true)
    }

    /// Says once if a number is none of the pad's.
    fn name_what_is_missing(&mut self, cx: &Context, joy: &Joy) {
        let buttons = [
            ("enable_button", &self.enable_button),
            ("enable_turbo_button", &self.enable_turbo_button),
        ];
        let axes = [
            ("axis_linear", &self.axis_linear),
            ("axis_linear_y", &self.axis_linear_y),
            ("axis_angular", &self.axis_angular),
        ];
        let missing = |numbers: &[(&str, &Modulation<i32>)], count: usize, kind: &str| {
            let beyond = |number: i32| usize::try_from(number).is_ok_and(|number| number >= count);
            let numbers = numbers.iter().map(|(name, number)| (name, number.get(cx)));
            let found = numbers.filter(|(_, number)| beyond(*number));
            let texts =
                found.map(|(name, number)| format!("{name} is {number}, and the pad has {count} {kind}"));
            texts.collect::<Vec<_>>()
        };
        let mut texts = missing(&buttons, joy.buttons.len(), "buttons");
        texts.extend(missing(&axes, joy.axes.len(), "axes"));
        let text = texts.join("; ");
        if text != self.said {
            if !text.is_empty() {
                warn!(cx, "it cannot drive: {text}; they count from 0");
            }
            self.said = text;
        }
    }
}
