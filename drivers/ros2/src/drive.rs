//! When a ROS 2 robot receives velocities: repeatedly while a command is in force, so that its watchdog does
//! not stop it; zero for a while after the last command, so that it stops; then nothing, so that other
//! programs can drive it.

use core::time::Duration;

use jde_schema::prelude::Twist;

/// Period of repetitions: 20 per second, like the programs of ROS 2.
const REPEAT_INTERVAL: Duration = Duration::from_millis(50);
/// How long zero is sent: up to ten times, because the network may lose some messages.
const STOPPING: Duration = Duration::from_millis(500);

/// The last velocity sent to the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Drive {
    /// None since the start or the last stop.
    #[default]
    Silent,
    /// A command, to be repeated at `due`.
    Driving { twist: Twist, due: Duration },
    /// Zero, to stop the robot; to be repeated at `due`.
    Stopping { since: Duration, due: Duration },
}

impl Drive {
    /// Returns the velocity to send now, if any; `command` is the command in force.
    pub(crate) fn step(&mut self, now: Duration, command: Option<Twist>) -> Option<Twist> {
        let first = now + REPEAT_INTERVAL;
        // From when it was due, so that iterations which come later do not lower the rate.
        let again = |due: Duration| {
            Some(due + REPEAT_INTERVAL)
                .filter(|next| *next > now)
                .unwrap_or(first)
        };
        let (next, output) = match (command, *self) {
            (Some(twist), Self::Driving { twist: last, due }) if twist == last => {
                if now < due {
                    return None;
                }
                let due = again(due);
                (Self::Driving { twist, due }, Some(twist))
            }
            (Some(twist), _) => (Self::Driving { twist, due: first }, Some(twist)),
            (None, Self::Silent) => return None,
            (None, Self::Driving { .. }) => (
                Self::Stopping {
                    since: now,
                    due: first,
                },
                Some(Twist::ZERO),
            ),
            (None, Self::Stopping { since, .. }) if now >= since + STOPPING => (Self::Silent, None),
            (None, Self::Stopping { due, .. }) if now < due => return None,
            (None, Self::Stopping { since, due }) => {
                let due = again(due);
                (Self::Stopping { since, due }, Some(Twist::ZERO))
            }
        };
        *self = next;
        output
    }

    /// Returns the last velocity to send, if one is needed.
    pub(crate) fn end(&mut self) -> Option<Twist> {
        (core::mem::take(self) != Self::Silent).then_some(Twist::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AHEAD: Twist = Twist::planar(0.3, 0.0);
    const LEFT: Twist = Twist::planar(0.0, 0.5);

    fn at(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn a_command_is_sent_at_once_and_repeated_while_it_is_in_force() {
        let mut drive = Drive::default();
        assert_eq!(drive.step(at(0), None), None);
        assert_eq!(drive.step(at(20), Some(AHEAD)), Some(AHEAD));
        assert_eq!(drive.step(at(40), Some(AHEAD)), None);
        assert_eq!(drive.step(at(70), Some(AHEAD)), Some(AHEAD));
        assert_eq!(drive.step(at(80), Some(LEFT)), Some(LEFT));
    }

    #[test]
    fn a_command_is_repeated_20_times_a_second_whatever_the_period() {
        for period in [7, 20, 33] {
            let mut drive = Drive::default();
            let iterations = (0..10_000).step_by(period);
            let sent = iterations.filter(|now| drive.step(at(*now), Some(AHEAD)).is_some());
            assert!((199..=201).contains(&sent.count()), "every {period} ms");
        }
    }

    #[test]
    fn an_iteration_that_comes_late_leaves_no_burst_behind() {
        let mut drive = Drive::default();
        drive.step(at(0), Some(AHEAD));
        let sent: Vec<u64> = [1000, 1001, 1049, 1050, 1051]
            .into_iter()
            .filter(|now| drive.step(at(*now), Some(AHEAD)).is_some())
            .collect();
        assert_eq!(sent, [1000, 1050]);
    }

    #[test]
    fn r7_without_a_command_zero_is_sent_for_a_while_and_then_nothing() {
        let mut drive = Drive::default();
        drive.step(at(0), Some(AHEAD));
        let sent: Vec<u64> = (1..100)
            .map(|iteration| iteration * 20)
            .filter(|now| {
                let output = drive.step(at(*now), None);
                assert!(output.is_none_or(|twist| twist == Twist::ZERO));
                output.is_some()
            })
            .collect();
        assert_eq!(sent, [20, 80, 120, 180, 220, 280, 320, 380, 420, 480]);
        assert_eq!(drive, Drive::Silent);
        assert_eq!(drive.end(), None);
    }

    #[test]
    fn the_last_velocity_sent_is_zero() {
        let mut drive = Drive::default();
        drive.step(at(0), Some(AHEAD));
        assert_eq!(drive.end(), Some(Twist::ZERO));
        assert_eq!(drive.end(), None);
    }
}
