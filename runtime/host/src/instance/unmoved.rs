//! An odometry that repeats itself although the base should move: it states a velocity, or the base is commanded to move.
//! It is broken, or the base is blocked; nobody can know which.

use std::sync::Arc;

use jde_board::{Nanos, Reader, Variable};
use jde_types::{Odometry, Pose, Twist, Value};

use super::measurement::{MOVED, NoValue};

/// How far a base may be commanded before it must have moved, m and rad, and for how long at least, s: dead times of bases
/// and radios are shorter.
const UNANSWERED_COMMAND: (f64, f64) = (0.5, 0.5);
/// The least time of a velocity that is stated, s: some devices measure ten times a second and say so more often.
const MIN_STATED_TIME: f64 = 0.25;
/// How long a base stands before it may try again, at first and at most, ns.
const RETRY_PAUSE: [Nanos; 2] = [1_000_000_000, 8_000_000_000];
/// The longest time between two measurements that counts, ns.
const LONGEST_INTERVAL: Nanos = 1_000_000_000;

/// Compares an odometry with the one before, and with the commands of its driver.
pub(super) struct Unmoved {
    /// The commands of the driver that are velocities, and that it has limits for.
    commands: Vec<Reader>,
    content: Option<(Pose, Twist)>,
    /// When the last one was measured, and the speed that was commanded when it was published.
    last: (Nanos, f64),
    /// The time and the way since the content changed, s, m and rad: by the stated velocity, and by commands.
    stated: (f64, f64),
    commanded: (f64, f64),
    /// Since when a motion is commanded without a pause, and when one was last.
    commanded_since: Option<Nanos>,
    commanded_at: Nanos,
    /// How long the base stands before it may try again.
    pause: Nanos,
    /// It does, because it did not answer.
    is_pausing: bool,
}

impl Unmoved {
    pub(super) fn new<'a>(commands: impl Iterator<Item = &'a Arc<Variable>>) -> Self {
        let twist = Twist::describe();
        let velocities = commands.filter(|command| command.describe().value_type.name == twist.name);
        Self {
            commands: velocities.map(|command| command.reader("host")).collect(),
            content: None,
            last: (0, 0.0),
            stated: (0.0, 0.0),
            commanded: (0.0, 0.0),
            commanded_since: None,
            commanded_at: 0,
            pause: RETRY_PAUSE[0],
            is_pausing: false,
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
            self.commanded_since.get_or_insert(now);
        } else {
            self.commanded_since = None;
        }
        let content = Some((odometry.pose.pose, twist));
        if self.content != content {
            self.content = content;
            (self.stated, self.commanded) = ((0.0, 0.0), (0.0, 0.0));
            (self.pause, self.is_pausing) = (RETRY_PAUSE[0], false);
            return None;
        }
        add(&mut self.stated, speed(&twist), before, time);
        if let Some(since) = self.commanded_since {
            // What was measured before the command says nothing about it.
            add(
                &mut self.commanded,
                command.min(last_command),
                before.max(since),
                time,
            );
        }
        if self.stated.0 > MIN_STATED_TIME && self.stated.1 > MOVED {
            return Some(NoValue::Stated);
        }
        if now.saturating_sub(self.commanded_at) >= self.pause {
            self.commanded = (0.0, 0.0);
            if std::mem::take(&mut self.is_pausing) {
                self.pause = (2 * self.pause).min(RETRY_PAUSE[1]);
            }
        }
        self.is_pausing |= self.commanded.0 > UNANSWERED_COMMAND.0 && self.commanded.1 > UNANSWERED_COMMAND.1;
        self.is_pausing.then_some(NoValue::Unanswered)
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

/// Adds a time and the way of a speed in it.
fn add(sum: &mut (f64, f64), speed: f64, from: Nanos, to: Nanos) {
    let seconds = to.saturating_sub(from).min(LONGEST_INTERVAL) as f64 / 1e9;
    if speed > 0.0 {
        sum.0 += seconds;
        sum.1 += speed * seconds;
    }
}

/// The speed in the plane, or the turn rate if that is greater: m/s and rad/s.
fn speed(twist: &Twist) -> f64 {
    let Twist { linear, angular } = twist;
    libm::hypot(linear.x, linear.y).max(angular.z.abs())
}

#[cfg(test)]
mod tests {
    use std::iter::{empty, repeat_n};

    use jde_types::Time;

    use super::*;

    const MS: Nanos = 1_000_000;

    /// Publishes an odometry that never changes at these times, each measured then or at the first of them.
    fn judge(speed: f64, is_measured_again: bool) -> Option<Nanos> {
        let mut unmoved = Unmoved::new(empty());
        let twist = Twist::planar(speed, 0.0);
        let odometry = Odometry::planar(Time::default(), jde_types::Pose2D::ORIGIN, twist);
        let times = repeat_n(50 * MS, 100).scan(0, |now, step| {
            *now += step;
            Some(*now)
        });
        times.into_iter().find(|now| {
            let time = if is_measured_again { *now } else { 50 * MS };
            unmoved.judge(odometry.as_bytes(), time, *now).is_some()
        })
    }

    #[test]
    fn r19_only_measurements_count_for_at_least_a_quarter_of_a_second() {
        assert_eq!(judge(2.0, true), Some(350 * MS), "0.5 m, but not sooner");
        assert_eq!(judge(0.09, true), Some(1_200 * MS), "0.1 m");
        assert_eq!(judge(2.0, false), None, "one measurement, published again");
        assert_eq!(judge(0.0, true), None, "it may stand");
    }
}
