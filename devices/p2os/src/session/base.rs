//! The base: it sends speeds within limits, when they change and periodically, and keeps the motors on. Only
//! a setpoint moves it.

use core::time::Duration;

use super::{Event, Setpoint};
use crate::{Command, Config, Flags, Model, Sip};

/// Speeds are repeated this often: ten times within the usual watchdog time of 2 s, after which the robot
/// stops.
const SPEED_REPEAT: Duration = Duration::from_millis(200);
/// Time between attempts to switch the motors on: the robot needs a moment, and a person may be holding the
/// button.
const MOTORS_RETRY: Duration = Duration::from_secs(1);
/// Attempts before a warning requests help. They start again with the next request to move.
const MAX_MOTOR_ATTEMPTS: u32 = 5;

/// What was last sent to the base.
#[derive(Clone, Debug)]
pub(super) struct Base {
    last_sent: Option<(i16, i16)>,
    sent_at: Duration,
    motors_at: Duration,
    attempts: u32,
}

impl Base {
    /// Creates a base whose motors were switched on at `now`.
    pub(super) fn new(now: Duration) -> Self {
        Self {
            last_sent: None,
            sent_at: now,
            motors_at: now,
            attempts: 0,
        }
    }

    /// Sends the requested speeds, if they have changed or are due for repetition.
    pub(super) fn drive(
        &mut self,
        setpoint: &Setpoint,
        limits: (f64, f64),
        now: Duration,
        mut send: impl FnMut(Command),
    ) {
        let speeds = (
            units(setpoint.linear * 1000.0, limits.0),
            units(setpoint.angular.to_degrees(), limits.1),
        );
        let changed = self.last_sent != Some(speeds);
        if changed || now.saturating_sub(self.sent_at) >= SPEED_REPEAT {
            self.last_sent = Some(speeds);
            self.sent_at = now;
            send(Command::Velocity(speeds.0));
            send(Command::RotVelocity(speeds.1));
        }
    }

    /// Switches the motors on, if the robot reports them off while it should move.
    pub(super) fn motors(
        &mut self,
        sip: &Sip,
        now: Duration,
        mut send: impl FnMut(Command),
    ) -> Option<Event> {
        let moves = self.last_sent.is_some_and(|speeds| speeds != (0, 0));
        if sip.motors() || !moves {
            self.attempts = 0;
            return None;
        }
        if self.attempts > MAX_MOTOR_ATTEMPTS || now.saturating_sub(self.motors_at) < MOTORS_RETRY {
            return None;
        }
        self.motors_at = now;
        self.attempts += 1;
        let pressed = sip.flags & Flags::ESTOP != 0;
        if self.attempts > MAX_MOTOR_ATTEMPTS || pressed {
            self.attempts = MAX_MOTOR_ATTEMPTS + 1;
            let cause = if pressed {
                ": its emergency stop is pressed"
            } else {
                ""
            };
            return Some(Event::Warning(format!(
                "the robot's motors stay off{cause}; press its motors button, or stop and start it again"
            )));
        }
        send(Command::Enable(true));
        None
    }
}

/// Returns the greatest speeds, mm/s and degrees/s: the lower of the model's limits and of the robot's own
/// settings.
pub(super) fn limits(model: &Model, config: Option<&Config>) -> (f64, f64) {
    let lower = |limit: f64, setting: Option<u16>| match setting {
        Some(setting @ 1..) => limit.min(f64::from(setting)),
        Some(0) | None => limit,
    };
    (
        lower(
            model.limits.velocity_mm_s,
            config.map(|config| config.trans_vel_max),
        ),
        lower(
            model.limits.rotation_deg_s,
            config.map(|config| config.rot_vel_max),
        ),
    )
}

/// Converts a number for the protocol; NaN becomes 0.
fn units(value: f64, limit: f64) -> i16 {
    value.clamp(-limit, limit).round() as i16
}
