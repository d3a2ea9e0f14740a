//! The base: it sends speeds within limits, when they change and periodically, and keeps the motors on. Only
//! a wish moves it.

use core::time::Duration;

use super::{Event, Setpoint};
use crate::{Command, Config, Flags, Model, Sip};

/// Speeds are repeated this often: ten times within the usual watchdog time of 2 s, after which the robot
/// stops.
const REPEAT: Duration = Duration::from_millis(200);
/// Time between attempts to switch the motors on: the robot needs a moment, and a person may be holding the
/// button.
const MOTORS_RETRY: Duration = Duration::from_secs(1);
/// Attempts before a warning asks a person to look. They start again with the next wish to move.
const MOTORS_TRIES: u32 = 5;

/// What was last sent to the base.
#[derive(Clone, Debug)]
pub(super) struct Base {
    last_sent: Option<(i16, i16)>,
    sent_at: Duration,
    motors_at: Duration,
    tries: u32,
}

impl Base {
    /// Creates a base whose motors were switched on at `now`.
    pub(super) fn new(now: Duration) -> Self {
        Self {
            last_sent: None,
            sent_at: now,
            motors_at: now,
            tries: 0,
        }
    }

    /// Sends the wanted speeds, if they have changed or it is time to repeat them.
    pub(super) fn drive(
        &mut self,
        wish: &Setpoint,
        limits: (f64, f64),
        now: Duration,
        mut say: impl FnMut(Command),
    ) {
        let speeds = (
            units(wish.linear * 1000.0, limits.0),
            units(wish.angular.to_degrees(), limits.1),
        );
        let changed = self.last_sent != Some(speeds);
        if changed || now.saturating_sub(self.sent_at) >= REPEAT {
            self.last_sent = Some(speeds);
            self.sent_at = now;
            say(Command::Velocity(speeds.0));
            say(Command::RotVelocity(speeds.1));
        }
    }

    /// Switches the motors on, if the robot reports them off while it should move.
    pub(super) fn motors(&mut self, sip: &Sip, now: Duration, mut say: impl FnMut(Command)) -> Option<Event> {
        let moves = self.last_sent.is_some_and(|speeds| speeds != (0, 0));
        if sip.motors() || !moves {
            self.tries = 0;
            return None;
        }
        if self.tries > MOTORS_TRIES || now.saturating_sub(self.motors_at) < MOTORS_RETRY {
            return None;
        }
        self.motors_at = now;
        self.tries += 1;
        let pressed = sip.flags & Flags::ESTOP != 0;
        if self.tries > MOTORS_TRIES || pressed {
            self.tries = MOTORS_TRIES + 1;
            let why = if pressed {
                ": its emergency stop is pressed"
            } else {
                ""
            };
            return Some(Event::Warning(format!(
                "the robot's motors stay off{why}; press its motors button, or stop and start it again"
            )));
        }
        say(Command::Enable(true));
        None
    }
}

/// Returns the greatest speeds, mm/s and degrees/s: the lower of the model's limits and of the robot's own
/// settings.
pub(super) fn limits(model: &Model, config: Option<&Config>) -> (f64, f64) {
    let set = |limit: f64, told: Option<u16>| match told {
        Some(told @ 1..) => limit.min(f64::from(told)),
        Some(0) | None => limit,
    };
    (
        set(
            model.limits.velocity_mm_s,
            config.map(|config| config.trans_vel_max),
        ),
        set(
            model.limits.rotation_deg_s,
            config.map(|config| config.rot_vel_max),
        ),
    )
}

/// Converts a number for the protocol; NaN becomes 0.
fn units(value: f64, limit: f64) -> i16 {
    value.clamp(-limit, limit).round() as i16
}
