//! The watch over one sensor: whether its measurements are new and of this clock, and what is wrong with them, in words.

use core::time::Duration;

use jde_fuse::{Outcome, TimeError};
use jde_motion::Frozen;
use jde_schema::prelude::*;
use jde_schema::types::Value;

use crate::refusal::Refusal;

/// A sensor whose clock is set by that of this machine is ahead of it by less, s.
const MAX_AHEAD: f64 = 0.1;

/// Checks that a measurement is of this clock and at most `oldest` s old.
///
/// # Errors
/// What is wrong with it.
pub(crate) fn check_age(what: &str, now: Duration, time: Duration, oldest: f64) -> Result<(), String> {
    let age = now.as_secs_f64() - time.as_secs_f64();
    if age < -MAX_AHEAD {
        return Err(format!(
            "the {what} are stamped {:.1} s ahead of the clock of this machine: set the clock of their sensor by it",
            -age
        ));
    }
    if age > oldest {
        return Err(format!("the {what} are {age:.1} s old"));
    }
    Ok(())
}

/// The watch.
#[derive(Debug)]
pub(crate) struct Watch {
    /// What the words call it, in the plural.
    what: &'static str,
    /// The number and the time of the last measurement.
    number: u64,
    measured: Option<Duration>,
    /// The time from the measurement before to the last one, s.
    step: Option<f64>,
    /// When one was taken last.
    taken: Option<Duration>,
    /// Those that are refused because they are not what is expected.
    refused: Option<Refusal>,
    trouble: Option<String>,
    frozen: Frozen,
    last: Vec<u8>,
}

impl Watch {
    pub(crate) fn new(what: &'static str) -> Self {
        Self {
            what,
            number: 0,
            measured: None,
            step: None,
            taken: None,
            refused: None,
            trouble: None,
            frozen: Frozen::default(),
            last: Vec::new(),
        }
    }

    /// What happened during a sleep is not known.
    pub(crate) fn awake(&mut self) {
        (self.taken, self.refused, self.trouble) = (None, None, None);
    }

    /// Returns a measurement that is new, at most `oldest` s old and later than the one before.
    pub(crate) fn fresh<'cx, T: Value>(
        &mut self,
        cx: &'cx Context,
        import: &Import<T>,
        oldest: f64,
    ) -> Option<Sample<'cx, T>> {
        let sample = import.get(cx)?;
        if core::mem::replace(&mut self.number, sample.sequence()) == sample.sequence() {
            return None;
        }
        let time = sample.time();
        let what = self.what;
        if let Err(words) = check_age(what, cx.now(), time, oldest) {
            return self.trouble(words);
        }
        if self.measured.is_some_and(|last| time <= last) {
            return self.trouble(format!("the {what} are no newer than those before"));
        }
        self.step = self.measured.map(|last| (time - last).as_secs_f64());
        self.measured = Some(time);
        Some(sample)
    }

    /// Returns the time from the measurement before to the last one, s.
    pub(crate) const fn step(&self) -> Option<f64> {
        self.step
    }

    /// Notes what is wrong with a measurement.
    pub(crate) fn trouble<T>(&mut self, words: String) -> Option<T> {
        self.trouble = Some(words);
        None
    }

    /// Whether the sensor repeats what it measured, to the bit, although the wheels went by more than `most`, m or rad.
    pub(crate) fn is_frozen<T: Value>(&mut self, measured: &T, base: Option<Pose2D>, most: f64) -> bool {
        let Some(base) = base else { return false };
        let differs = self.last != measured.as_bytes();
        if differs {
            self.last.clear();
            self.last.extend_from_slice(measured.as_bytes());
        }
        let is_frozen = self.frozen.is_frozen(differs, &base, most);
        if is_frozen {
            self.trouble = Some(format!(
                "the {} repeat themselves although the base moves",
                self.what
            ));
        }
        is_frozen
    }

    /// The wheels jumped without a motion.
    pub(crate) fn jump(&mut self, from: &Pose2D, to: &Pose2D) {
        self.frozen.jump(from, to);
    }

    /// Notes what has become of a measurement.
    pub(crate) fn note(&mut self, now: Duration, outcome: Result<Outcome, TimeError>) {
        let what = self.what;
        let trouble = match outcome {
            Ok(Outcome::Taken) => None,
            Ok(Outcome::Slips(by)) => Some(format!(
                "the wheels turn by {:.1} degrees/s otherwise than the gyro",
                by.to_degrees()
            )),
            Ok(Outcome::Pushed(_)) => Some("the base moves although its wheels stand".to_owned()),
            Ok(Outcome::Refused(distance)) => {
                self.trouble = Some(format!(
                    "the {what} are refused: they differ by {distance:.0} deviations"
                ));
                return;
            }
            Ok(Outcome::Invalid) => {
                self.trouble = Some(format!("the {what} have numbers or covariances that are none"));
                return;
            }
            Err(error) => {
                self.trouble = Some(format!("the {what} come too late: {error}"));
                return;
            }
        };
        (self.taken, self.refused, self.trouble) = (Some(now), None, trouble);
    }

    /// Notes where a position was that was refused, where the estimate is, and how well the position is known, m.
    pub(crate) fn refuse(&mut self, now: Duration, measured: [f64; 2], estimated: [f64; 2], deviation: f64) {
        let first = Refusal::new(now, measured, estimated);
        self.refused = Some(
            self.refused
                .map_or(first, |refused| refused.add(now, measured, estimated, deviation)),
        );
    }

    /// Whether measurements that agree with each other have been refused for longer than `patience` s.
    pub(crate) fn is_refused(&self, now: Duration, patience: f64) -> bool {
        self.refused.is_some_and(|refused| refused.lasts(now, patience))
    }

    /// Whether one was taken within `timeout` s.
    pub(crate) fn is_alive(&self, now: Duration, timeout: f64) -> bool {
        (self.taken).is_some_and(|taken| now.saturating_sub(taken).as_secs_f64() <= timeout)
    }

    /// Returns what is wrong with a sensor from which something is expected every `timeout` s.
    pub(crate) fn words(&self, now: Duration, timeout: f64) -> Option<String> {
        if self.is_alive(now, timeout) {
            return self.trouble.clone();
        }
        let what = self.what;
        Some(self.trouble.clone().unwrap_or_else(|| match self.taken {
            Some(taken) => format!("no {what} for {:.1} s", now.saturating_sub(taken).as_secs_f64()),
            None => format!("no {what} yet"),
        }))
    }
}
