//! The measurements of the last second in their order, with the estimate after each. One that comes late is put where it
//! belongs, and those after it are taken again: the result is as if it had come in time.

use core::fmt;
use core::time::Duration;
use std::collections::VecDeque;

use crate::filter::{Filter, Outcome};
use crate::measurement::{Measurement, Thresholds, Turn};
use crate::state::ProcessNoise;

/// The most measurements that are kept: one second of a gyro of 400 Hz and of all else.
pub const MAX_MEASUREMENTS: usize = 512;

/// The longest time between two measurements of a gyro that works, s, and between one and the wheels that it is compared
/// with.
pub const MAX_GAP: f64 = 0.11;

/// For so long before the history a gyro is kept to be compared with wheels that come late.
const TURNS_BEFORE: Duration = Duration::from_millis(500);

/// Estimates and measurements.
#[derive(Clone, Debug)]
pub struct Timeline {
    /// The estimate before the first measurement that is kept.
    first: (Duration, Filter),
    entries: VecDeque<Entry>,
    /// What a gyro measured before them.
    turns: VecDeque<(Duration, Turn)>,
    /// How far before the newest measurement the oldest may be.
    length: Duration,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    time: Duration,
    measurement: Measurement,
    outcome: Outcome,
    after: Filter,
}

impl Entry {
    fn turn(&self) -> Option<(Duration, Turn)> {
        match (self.measurement, self.outcome) {
            (Measurement::Turn(turn), Outcome::Taken) => Some((self.time, turn)),
            _ => None,
        }
    }
}

/// Why a measurement has no place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeError {
    /// It is older than what is kept, by this.
    TooOld(Duration),
}

impl fmt::Display for TimeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooOld(by) => write!(f, "{:.2} s older than the history", by.as_secs_f64()),
        }
    }
}

impl core::error::Error for TimeError {}

impl Timeline {
    /// Begins at a time with an estimate, and keeps the measurements of `length` before the newest.
    #[must_use]
    pub const fn new(time: Duration, filter: Filter, length: Duration) -> Self {
        Self {
            first: (time, filter),
            entries: VecDeque::new(),
            turns: VecDeque::new(),
            length,
        }
    }

    /// Returns the time of the newest measurement, and the estimate after it.
    #[must_use]
    pub fn newest(&self) -> (Duration, &Filter) {
        self.entries
            .back()
            .map_or((self.first.0, &self.first.1), |last| (last.time, &last.after))
    }

    /// Returns the estimate of a time after the newest measurement; of an earlier time, that after the newest.
    #[must_use]
    pub fn at(&self, time: Duration, noise: &ProcessNoise) -> Filter {
        let (last, filter) = self.newest();
        let mut filter = *filter;
        if time > last {
            filter.predict((time - last).as_secs_f64(), noise);
        }
        filter
    }

    /// Takes a measurement of a time, and all later ones again. Returns what has become of it.
    ///
    /// # Errors
    /// That it is older than what is kept.
    pub fn add(
        &mut self,
        time: Duration,
        measurement: Measurement,
        noise: &ProcessNoise,
        thresholds: &Thresholds,
    ) -> Result<Outcome, TimeError> {
        if time < self.first.0 {
            return Err(TimeError::TooOld(self.first.0 - time));
        }
        let key = (time, rank(&measurement));
        let place = self
            .entries
            .partition_point(|entry| (entry.time, rank(&entry.measurement)) <= key);
        let entry = Entry {
            time,
            measurement,
            outcome: Outcome::Invalid,
            after: self.first.1,
        };
        self.entries.insert(place, entry);
        for at in place..self.entries.len() {
            self.replay(at, noise, thresholds);
        }
        let outcome = self.entries[place].outcome;
        self.trim();
        Ok(outcome)
    }

    fn replay(&mut self, at: usize, noise: &ProcessNoise, thresholds: &Thresholds) {
        let (time, mut filter) = match at.checked_sub(1) {
            Some(before) => (self.entries[before].time, self.entries[before].after),
            None => self.first,
        };
        let Entry {
            time: now,
            measurement,
            ..
        } = self.entries[at];
        if now > time {
            filter.predict((now - time).as_secs_f64(), noise);
        }
        let gyro = self.gyro(at, noise);
        let measurement = match measurement {
            Measurement::Wheels(wheels) if gyro.is_none() && self.has_turned(at, noise) => {
                Measurement::Wheels(wheels.unseen())
            }
            measurement => measurement,
        };
        let outcome = filter.update(&measurement, gyro, noise, thresholds);
        let entry = &mut self.entries[at];
        (entry.outcome, entry.after) = (outcome, filter);
    }

    /// The mean turn rate of the gyro while the wheels of an entry measured, and its variance; without a time, that when
    /// they measured.
    fn gyro(&self, at: usize, noise: &ProcessNoise) -> Option<(f64, f64)> {
        let Entry {
            time,
            measurement: Measurement::Wheels(wheels),
            ..
        } = self.entries[at]
        else {
            return None;
        };
        let since = time.saturating_sub(wheels.lasts);
        let mut turns = self.turns_before(at);
        let (mut from, newest) = turns.next()?;
        let age = (time - from).as_secs_f64();
        if age > MAX_GAP {
            return None;
        }
        if from <= since {
            return Some((newest.rate, newest.variance + noise.rate * age));
        }
        // From the newest back: the trapezoids between two, and the newest rate until the wheels measured.
        let (mut rate, mut turned, mut count) = (newest.rate, newest.rate * age, 1.0);
        for (earlier, turn) in turns {
            let step = (from - earlier).as_secs_f64();
            if step > MAX_GAP {
                break;
            }
            let within = (from - since).as_secs_f64().min(step);
            let begin = rate + (turn.rate - rate) * within / step.max(f64::MIN_POSITIVE);
            turned += within * f64::midpoint(begin, rate);
            (from, rate) = (earlier, turn.rate);
            if earlier <= since {
                break;
            }
            count += 1.0;
        }
        // Before the first that is known, it turned as then.
        let unknown = from.saturating_sub(since).as_secs_f64();
        let lasts = wheels.lasts.as_secs_f64();
        let variance =
            newest.variance / count + noise.rate * (age + unknown + lasts / (12.0 * count * count));
        Some(((turned + rate * unknown) / lasts, variance))
    }

    /// What a gyro measured before an entry, from the newest back.
    fn turns_before(&self, at: usize) -> impl Iterator<Item = (Duration, Turn)> {
        let entries = self.entries.range(..at).rev().filter_map(Entry::turn);
        entries.chain(self.turns.iter().rev().copied())
    }

    /// Whether there is a gyro, although it measures too seldom to notice whether these wheels slip.
    fn has_turned(&self, at: usize, noise: &ProcessNoise) -> bool {
        let time = self.entries[at].time;
        self.turns_before(at)
            .next()
            .is_some_and(|(turned, _)| (time - turned).as_secs_f64() < noise.standstill)
    }

    /// The gyro's bias may be off by another `bias`, rad/s, and has turned the estimate by `yaw`, rad, that was no turn.
    pub fn doubt_bias(&mut self, bias: f64, yaw: f64) {
        self.first.1.doubt_bias(bias, yaw);
        for entry in &mut self.entries {
            entry.after.doubt_bias(bias, yaw);
        }
    }

    /// Drops what is older than the history.
    fn trim(&mut self) {
        let oldest = self.newest().0.saturating_sub(self.length);
        while (self.entries.front())
            .is_some_and(|entry| entry.time < oldest || self.entries.len() > MAX_MEASUREMENTS)
        {
            if let Some(entry) = self.entries.pop_front() {
                self.turns.extend(entry.turn());
                self.first = (entry.time, entry.after);
            }
        }
        let oldest = self.first.0.saturating_sub(TURNS_BEFORE);
        while self.turns.pop_front_if(|(time, _)| *time < oldest).is_some() {}
    }
}

/// The order of measurements of the same time: the gyro before the wheels that are compared with it.
const fn rank(measurement: &Measurement) -> u8 {
    match measurement {
        Measurement::Turn(_) => 0,
        Measurement::Wheels(_) => 1,
        Measurement::Heading(_) => 2,
        Measurement::Position(_) => 3,
        Measurement::Place(_) => 4,
    }
}
