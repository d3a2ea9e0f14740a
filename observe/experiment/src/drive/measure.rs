//! Measures: a number of a drive, reduced from the values of an expression or from the robot's true motion. A
//! value stands from its instant to the next one. A meter reads nothing itself.

use jde_core::Nanos;

use super::motion::{MotionMeasure, RobotMotion};

/// A measure.
#[derive(Clone, Debug, PartialEq)]
pub enum Measure {
    /// The reduction of an expression, by its place in
    /// [`Experiment::expressions`](crate::Experiment::expressions).
    Reduced(Reduction, usize),
    /// Seconds until the drive ended.
    Time,
    /// A measure of a robot's motion, by the robot's place among those of the drive.
    Motion(MotionMeasure, usize),
}

/// How the values of an expression become one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reduction {
    /// The last value.
    Last,
    /// The least value.
    Min,
    /// The greatest value.
    Max,
    /// The mean over the time for which there is a value.
    Mean,
    /// The integral over time, in the unit of the expression times seconds.
    Integral,
    /// How often it becomes true.
    Count,
    /// When it becomes true first, s.
    TimeOf,
    /// The share of the drive for which it is true, 0 to 1.
    Share,
}

impl Measure {
    /// Whether it may need the length of the world's reference path.
    pub(super) fn needs_reference_length(&self) -> bool {
        matches!(self, Self::Motion(MotionMeasure::Barn { length: None, .. }, _))
    }
}

impl Reduction {
    /// The key of each in a file.
    pub const KEYS: [(&'static str, Self); 8] = [
        ("last", Self::Last),
        ("min", Self::Min),
        ("max", Self::Max),
        ("mean", Self::Mean),
        ("integral", Self::Integral),
        ("count", Self::Count),
        ("time_of", Self::TimeOf),
        ("share", Self::Share),
    ];
}

/// A measure during one drive.
#[derive(Clone, Debug)]
pub struct Meter {
    measure: Measure,
    sums: Sums,
}

#[derive(Clone, Debug, Default)]
struct Sums {
    /// The value since the last instant, and that instant.
    present: Option<(f64, Nanos)>,
    min: Option<f64>,
    max: Option<f64>,
    last: Option<f64>,
    integral: f64,
    /// Time with a value, ns.
    known: Nanos,
    /// Time with a value other than 0, ns.
    true_for: Nanos,
    count: u64,
    first_true: Option<Nanos>,
}

impl Meter {
    /// Begins to measure.
    #[must_use]
    pub fn new(measure: &Measure) -> Self {
        Self {
            measure: measure.clone(),
            sums: Sums::default(),
        }
    }

    /// Takes the values of all expressions at an instant. Instants come in order.
    pub fn observe(&mut self, now: Nanos, values: &[Option<f64>]) {
        if let Measure::Reduced(_, expression) = self.measure {
            self.sums.advance(now);
            self.sums.set(now, values[expression]);
        }
    }

    /// Ends the drive, and returns the measure; `None` if there was no value.
    #[must_use]
    pub fn finish(mut self, now: Nanos, is_success: bool, motions: &[RobotMotion]) -> Option<f64> {
        let value = match self.measure {
            Measure::Time => Some(now as f64 / 1e9),
            Measure::Motion(measure, robot) => motions[robot].measure(measure, now, is_success),
            Measure::Reduced(reduction, _) => {
                self.sums.advance(now);
                self.sums.result(reduction, now)
            }
        };
        value.filter(|value| value.is_finite())
    }
}

impl Sums {
    fn advance(&mut self, now: Nanos) {
        let Some((value, since)) = self.present.as_mut() else {
            return;
        };
        let passed = now.saturating_sub(*since);
        self.integral += *value * passed as f64 / 1e9;
        self.known += passed;
        self.true_for += if *value == 0.0 { 0 } else { passed };
        *since = now;
    }

    fn set(&mut self, now: Nanos, value: Option<f64>) {
        let was_true = self.present.is_some_and(|(value, _)| value != 0.0);
        if let Some(value) = value {
            self.min = Some(self.min.map_or(value, |least| least.min(value)));
            self.max = Some(self.max.map_or(value, |greatest| greatest.max(value)));
            self.last = Some(value);
            if value != 0.0 && !was_true {
                self.count += 1;
                self.first_true.get_or_insert(now);
            }
        }
        self.present = value.map(|value| (value, now));
    }

    fn result(&self, reduction: Reduction, now: Nanos) -> Option<f64> {
        match reduction {
            Reduction::Last => self.last,
            Reduction::Min => self.min,
            Reduction::Max => self.max,
            Reduction::Mean if self.known == 0 => self.last,
            Reduction::Mean => Some(self.integral / (self.known as f64 / 1e9)),
            Reduction::Integral => self.last.map(|_| self.integral),
            Reduction::Count => Some(self.count as f64),
            Reduction::TimeOf => self.first_true.map(|time| time as f64 / 1e9),
            Reduction::Share => (now > 0).then(|| self.true_for as f64 / now as f64),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Nanos = 1_000_000_000;

    fn reduced(reduction: Reduction, values: &[Option<f64>]) -> Option<f64> {
        let mut meter = Meter::new(&Measure::Reduced(reduction, 0));
        for (second, value) in values.iter().enumerate() {
            meter.observe(second as Nanos * SECOND, &[*value]);
        }
        meter.finish(values.len() as Nanos * SECOND, true, &[])
    }

    #[test]
    fn each_reduction_of_values_that_stand_for_a_second_each() {
        let values = [None, Some(2.0), Some(0.0), Some(4.0), None];
        let expected = [
            (Reduction::Last, 4.0),
            (Reduction::Min, 0.0),
            (Reduction::Max, 4.0),
            (Reduction::Mean, 2.0),
            (Reduction::Integral, 6.0),
            (Reduction::Count, 2.0),
            (Reduction::TimeOf, 1.0),
            (Reduction::Share, 0.4),
        ];
        for (reduction, value) in expected {
            assert_eq!(reduced(reduction, &values), Some(value), "{reduction:?}");
        }
    }

    #[test]
    fn without_a_value_there_is_no_measure_but_a_count_and_a_share() {
        for (key, reduction) in Reduction::KEYS {
            let expected = matches!(reduction, Reduction::Count | Reduction::Share).then_some(0.0);
            assert_eq!(reduced(reduction, &[None, None]), expected, "{key}");
        }
    }
}
