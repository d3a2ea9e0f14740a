//! When a robot of ROS 2 is told which velocity: again and again while a command is in force, so that its watchdog lets it drive;
//! zero for a while once none is, so that it stops; and then nothing, so that others may drive it.

use core::time::Duration;

use jde_schema::prelude::Twist;

/// Between two of the same: 20 a second, as ROS 2's own programs do.
const AGAIN: Duration = Duration::from_millis(50);
/// How long zero is said: ten times, on a network that may lose some.
const STOPPING: Duration = Duration::from_millis(500);

/// What the robot was told last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Drive {
    /// Nothing that counts.
    #[default]
    Silent,
    /// A command.
    Driving { twist: Twist, said: Duration },
    /// To stop.
    Stopping { since: Duration, said: Duration },
}

impl Drive {
    /// What is to be said now, with this command in force, or none.
    pub(crate) fn step(&mut self, now: Duration, command: Option<Twist>) -> Option<Twist> {
        let due = |said: Duration| now >= said + AGAIN;
        let (next, words) = match (command, *self) {
            (Some(twist), Self::Driving { twist: last, said }) if twist == last && !due(said) => {
                (*self, None)
            }
            (Some(twist), _) => (Self::Driving { twist, said: now }, Some(twist)),
            (None, Self::Silent) => (Self::Silent, None),
            (None, Self::Driving { .. }) => (
                Self::Stopping {
                    since: now,
                    said: now,
                },
                Some(Twist::ZERO),
            ),
            (None, Self::Stopping { since, .. }) if now >= since + STOPPING => (Self::Silent, None),
            (None, Self::Stopping { since, said }) if due(said) => {
                (Self::Stopping { since, said: now }, Some(Twist::ZERO))
            }
            (None, Self::Stopping { .. }) => (*self, None),
        };
        *self = next;
        words
    }

    /// The last words, if any are needed.
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
    fn a_command_is_said_at_once_and_repeated_while_it_is_in_force() {
        let mut drive = Drive::default();
        assert_eq!(drive.step(at(0), None), None);
        assert_eq!(drive.step(at(20), Some(AHEAD)), Some(AHEAD));
        assert_eq!(drive.step(at(40), Some(AHEAD)), None);
        assert_eq!(drive.step(at(70), Some(AHEAD)), Some(AHEAD));
        assert_eq!(drive.step(at(80), Some(LEFT)), Some(LEFT));
    }

    #[test]
    fn r7_without_a_command_it_is_told_to_stop_and_then_left_to_others() {
        let mut drive = Drive::default();
        drive.step(at(0), Some(AHEAD));
        let said: Vec<u64> = (1..100)
            .map(|turn| turn * 20)
            .filter(|now| {
                let words = drive.step(at(*now), None);
                assert!(words.is_none_or(|twist| twist == Twist::ZERO));
                words.is_some()
            })
            .collect();
        assert_eq!(said, [20, 80, 140, 200, 260, 320, 380, 440, 500]);
        assert_eq!(drive, Drive::Silent);
        assert_eq!(drive.end(), None);
    }

    #[test]
    fn the_last_word_is_to_stop() {
        let mut drive = Drive::default();
        drive.step(at(0), Some(AHEAD));
        assert_eq!(drive.end(), Some(Twist::ZERO));
        assert_eq!(drive.end(), None);
    }
}
