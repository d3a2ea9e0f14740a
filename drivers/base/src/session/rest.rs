//! Watches over wheels that run although the board was told to stand.

use core::time::Duration;

use jde_schema::prelude::Twist;

use crate::hello::Hello;

/// Speeds that are no rest, m/s and rad/s: more than a tick of a coarse encoder in the odometer's window.
const MOVES: [f64; 2] = [0.05, 0.2];
/// Time for a stop beyond what the board's own numbers need, and for a push by a person.
const GRACE: Duration = Duration::from_secs(1);
/// Time for a stop of a board that does not state its decelerations.
const UNKNOWN: f64 = 2.0;

/// The watch.
#[derive(Debug, Default)]
pub(super) struct Rest {
    /// Since when the wheels run without a command.
    running: Option<Duration>,
}

impl Rest {
    /// Takes the speeds at `now`, and since when the board should stand. Returns what is wrong.
    pub(super) fn update(
        &mut self,
        twist: &Twist,
        standing_since: Option<Duration>,
        hello: &Hello,
        now: Duration,
    ) -> Option<String> {
        let speed = libm::hypot(twist.linear.x, twist.linear.y);
        let moves = speed > MOVES[0] || twist.angular.z.abs() > MOVES[1];
        let Some(since) = standing_since.filter(|_| moves) else {
            self.running = None;
            return None;
        };
        let running = *self.running.get_or_insert(now);
        let dynamics = &hello.dynamics;
        let time = |speed: f64, down: f64| if down > 0.0 { speed / down } else { UNKNOWN };
        let stop = f64::max(
            time(hello.limits.linear.x, dynamics.deceleration),
            time(hello.limits.angular.z, dynamics.turn_deceleration),
        ) + 4.0 * dynamics.lag;
        let end = since.max(running) + GRACE + Duration::try_from_secs_f64(stop).unwrap_or_default();
        let turn = twist.angular.z.abs();
        (now > end).then(|| {
            format!("its wheels run although they must stand: {speed:.2} m/s, {turn:.2} rad/s; if nobody pushes it, cut its power")
        })
    }
}
