//! An odometry that repeats itself although the base should move: it states a velocity, or the base is commanded to move.
//! It is broken, or the base is blocked; nobody can know which.

use std::sync::Arc;

use jde_board::{Nanos, Reader, Variable};
use jde_types::{Odometry, Pose, Twist, Value};

use super::measurement::{MOVED, NoValue};

/// The way of a command that a base may take to begin its motion, m and rad: half a second at 1 m/s.
const UNANSWERED: f64 = 0.5;
/// How long a base stands before it may try again, at first and at most, ns.
const REST: [Nanos; 2] = [1_000_000_000, 8_000_000_000];
/// The longest time between two measurements that counts, ns.
const LONGEST: Nanos = 1_000_000_000;

/// Compares an odometry with the one before, and with the commands of its driver.
pub(super) struct Unmoved {
    /// The commands of the driver that are velocities, and that it has limits for.
    commands: Vec<Reader>,
    content: Option<(Pose, Twist)>,
    /// When the last one was measured, and the speed that was commanded when it was published.
    last: (Nanos, f64),
    /// The way since the content changed by the stated velocity, and by the commands.
    stated: f64,
    commanded: f64,
    /// When a motion was last commanded.
    commanded_at: Nanos,
    rest: Nanos,
    /// The base stands, because it did not answer.
    rests: bool,
}

impl Unmoved {
    pub(super) fn new<'a>(commands: impl Iterator<Item = &'a Arc<Variable>>) -> Self {
        let twist = Twist::describe();
        let velocities = commands.filter(|command| command.describe().value_type.name == twist.name);
        Self {
            commands: velocities.map(|command| command.reader("host")).collect(),
            content: None,
            last: (0, 0.0),
            stated: 0.0,
            commanded: 0.0,
            commanded_at: 0,
            rest: REST[0],
            rests: false,
        }
    }

    /// Judges what is about to be published, and was measured at `time`. A measurement that is published again is not
    /// another one.
    pub(super) fn judge(&mut self, bytes: &[u8], time: Nanos, now: Nanos) -> Option<NoValue> {
        let odometry = Odometry::view(bytes)?;
        let twist = odometry.twist.twist;
        let command = self.commanded_speed(now);
        let (before, last_command) = std::mem::replace(&mut self.last, (time, command));
        if command > 0.0 {
            self.commanded_at = now;
        }
        let content = Some((odometry.pose.pose, twist));
        if self.content != content {
            self.content = content;
            (self.stated, self.commanded) = (0.0, 0.0);
            (self.rest, self.rests) = (REST[0], false);
            return None;
        }
        let seconds = time.saturating_sub(before).min(LONGEST) as f64 / 1e9;
        self.stated += speed(&twist) * seconds;
        self.commanded += command.min(last_command) * seconds;
        if self.stated > MOVED {
            return Some(NoValue::Stated);
        }
        if now.saturating_sub(self.commanded_at) >= self.rest {
            self.commanded = 0.0;
            if std::mem::take(&mut self.rests) {
                self.rest = (2 * self.rest).min(REST[1]);
            }
        }
        self.rests |= self.commanded > UNANSWERED;
        self.rests.then_some(NoValue::Unanswered)
    }

    /// The greatest speed that is commanded.
    fn commanded_speed(&mut self, now: Nanos) -> f64 {
        let speed_of = |reader: &mut Reader| {
            let command = reader.latch_newest(now);
            let in_force = command.filter(|command| command.stamp.valid_until >= now);
            let speed = in_force.and_then(|command| Twist::view(command.bytes).map(speed));
            reader.release();
            speed.unwrap_or_default()
        };
        self.commands.iter_mut().map(speed_of).fold(0.0, f64::max)
    }
}

/// The speed in the plane, or the turn rate if that is greater: m/s and rad/s.
fn speed(twist: &Twist) -> f64 {
    let Twist { linear, angular } = twist;
    linear.x.hypot(linear.y).max(angular.z.abs())
}
