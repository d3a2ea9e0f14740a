//! Turns the head as a person wishes, within limits.

use jde_schema::prelude::*;

use crate::setpoint::{Look, is_in_force};

/// Lead of the commanded over the measured position, as turning time, s. It exceeds the time between two
/// measurements, so that the head turns without halts. It is short, because the head turns on by this much
/// after the wish ends.
const LEAD: f64 = 0.15;

/// Turns the head as a person wishes, for as long as the wish is renewed.
///
/// It is ready while the wish is not older than `patience` and the position of the head is known.
#[derive(Describe)]
#[schema(motor, period = "50ms", budget = "10ms")]
pub struct Head {
    /// The measured position of the head.
    #[import]
    pan_tilt: Import<PanTilt>,
    /// The wish of the person. The operator writes it at least twice in each `patience`.
    #[modulation(default = Look::NONE)]
    want: Modulation<Look>,
    /// Oldest wish that counts: the dead-man's switch.
    #[modulation(default = 0.5, unit = "s", min = 0.05, max = 10.0)]
    patience: Modulation<f64>,
    /// Highest turn rate.
    #[modulation(default = 0.8, unit = "rad/s", min = 0.0)]
    turn: Modulation<f64>,
    /// The pan-tilt head.
    #[actuator]
    head: Actuator<PanTilt>,
}

impl Schema for Head {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok((self.requested_rates(cx).is_some() && self.pan_tilt.get(cx).is_some()).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(now) = self.pan_tilt.get(cx) else {
            return Ok(());
        };
        let rates = self.requested_rates(cx).unwrap_or(Look::NONE);
        let most = self.turn.get(cx);
        let (pan, tilt) = (rates.pan.clamp(-most, most), rates.tilt.clamp(-most, most));
        self.head.command(
            cx,
            PanTilt {
                header: Header::new(cx.now(), now.header.frame_id.as_str()),
                pan: now.pan + LEAD * pan,
                tilt: now.tilt + LEAD * tilt,
                // A speed of 0 holds the axis.
                pan_velocity: pan.abs(),
                tilt_velocity: tilt.abs(),
            },
        );
        Ok(())
    }
}

impl Head {
    fn requested_rates(&self, cx: &Context) -> Option<Look> {
        let wish = self.want.sample(cx);
        is_in_force(cx, wish.wanted, wish.time(), self.patience.get(cx)).then_some(*wish.value())
    }
}
