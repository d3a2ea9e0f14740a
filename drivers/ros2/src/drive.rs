//! When a ROS 2 robot receives velocities: repeatedly while a command is in force, so that its watchdog does
//! not stop it; zero after the last command, for a while and until the robot stands; then nothing, so that other
//! programs can drive it.

use core::time::Duration;
use std::thread;

use jde_schema::prelude::Twist;

/// Period of repetitions: 20 per second, like the programs of ROS 2.
pub(crate) const REPEAT_INTERVAL: Duration = Duration::from_millis(50);
/// How long zero is sent at least: ten times, because the network may lose some messages, and a robot that stands may not
/// have begun to follow the last command.
pub(crate) const MIN_STOP_TIME: Duration = Duration::from_millis(500);
/// How long zero is sent at most to a robot that moves: another program may drive it.
const MAX_STOP_TIME: Duration = Duration::from_secs(5);
/// A robot that measures less than this stands, in m/s and rad/s.
const STANDING_SPEED: f64 = 0.01;

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
    /// Returns the velocity to send now, if any; `command` is the command in force, and `moves` whether the robot is known
    /// to move.
    pub(crate) fn step(&mut self, now: Duration, command: Option<Twist>, moves: bool) -> Option<Twist> {
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
            (None, Self::Stopping { since, .. })
                if now >= since + if moves { MAX_STOP_TIME } else { MIN_STOP_TIME } =>
            {
                (Self::Silent, None)
            }
            (None, Self::Stopping { due, .. }) if now < due => return None,
            (None, Self::Stopping { since, due }) => {
                let due = again(due);
                (Self::Stopping { since, due }, Some(Twist::ZERO))
            }
        };
        *self = next;
        output
    }

    /// Sends what is still to be sent to stop the robot, to one that may move no longer than a robot that stands: the call
    /// blocks meanwhile.
    pub(crate) fn end(&mut self, mut now: Duration, mut send: impl FnMut(&Twist)) {
        while let Some(twist) = self.step(now, None, false) {
            send(&twist);
            thread::sleep(REPEAT_INTERVAL);
            now += REPEAT_INTERVAL;
        }
    }
}

/// Whether a robot with this measured velocity moves.
pub(crate) fn moves(velocity: &Twist) -> bool {
    let Twist { linear, angular } = velocity;
    libm::hypot(linear.x, linear.y) > STANDING_SPEED || angular.z.abs() > STANDING_SPEED
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
        assert_eq!(drive.step(at(0), None, false), None);
        assert_eq!(drive.step(at(20), Some(AHEAD), false), Some(AHEAD));
        assert_eq!(drive.step(at(40), Some(AHEAD), false), None);
        assert_eq!(drive.step(at(70), Some(AHEAD), false), Some(AHEAD));
        assert_eq!(drive.step(at(80), Some(LEFT), false), Some(LEFT));
    }

    #[test]
    fn a_command_is_repeated_20_times_a_second_whatever_the_period() {
        for period in [7, 20, 33] {
            let mut drive = Drive::default();
            let iterations = (0..10_000).step_by(period);
            let sent = iterations.filter(|now| drive.step(at(*now), Some(AHEAD), false).is_some());
            assert!((199..=201).contains(&sent.count()), "every {period} ms");
        }
    }

    #[test]
    fn an_iteration_that_comes_late_leaves_no_burst_behind() {
        let mut drive = Drive::default();
        drive.step(at(0), Some(AHEAD), false);
        let sent: Vec<u64> = [1000, 1001, 1049, 1050, 1051]
            .into_iter()
            .filter(|now| drive.step(at(*now), Some(AHEAD), false).is_some())
            .collect();
        assert_eq!(sent, [1000, 1050]);
    }

    #[test]
    fn r7_without_a_command_zero_is_sent_for_a_while_and_then_nothing() {
        let mut drive = Drive::default();
        drive.step(at(0), Some(AHEAD), false);
        let sent: Vec<u64> = (1..100)
            .map(|iteration| iteration * 20)
            .filter(|now| {
                let output = drive.step(at(*now), None, false);
                assert!(output.is_none_or(|twist| twist == Twist::ZERO));
                output.is_some()
            })
            .collect();
        assert_eq!(sent, [20, 80, 120, 180, 220, 280, 320, 380, 420, 480]);
        assert_eq!(drive, Drive::Silent);
        drive.end(at(2000), |twist| panic!("{twist:?} is sent"));
    }

    #[test]
    fn r7_zero_is_sent_until_a_robot_that_moves_stands_but_not_for_ever() {
        for (stands_at, last) in [(0, 450), (400, 450), (1210, 1200), (1_000_000, 4950)] {
            let mut drive = Drive::default();
            drive.step(at(0), Some(AHEAD), true);
            let sent = (0..=700)
                .map(|iteration| iteration * 10)
                .filter(|now| drive.step(at(*now), None, *now < stands_at).is_some());
            assert_eq!(sent.last(), Some(last), "it stands after {stands_at} ms");
            assert_eq!(drive, Drive::Silent);
        }
    }

    #[test]
    fn a_robot_moves_if_it_measures_more_than_noise() {
        for still in [Twist::ZERO, Twist::planar(-0.009, 0.009)] {
            assert!(!moves(&still));
        }
        for moving in [Twist::planar(-0.02, 0.0), Twist::planar(0.0, 0.02)] {
            assert!(moves(&moving));
        }
    }

    #[test]
    fn r7_zero_is_sent_as_often_by_a_driver_that_ends() {
        let mut drive = Drive::default();
        drive.step(at(0), Some(AHEAD), false);
        let mut sent = Vec::new();
        drive.end(at(10), |twist| sent.push(*twist));
        assert_eq!((sent, drive), (vec![Twist::ZERO; 10], Drive::Silent));
    }
}
