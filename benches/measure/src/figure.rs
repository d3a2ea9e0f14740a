//! Measured figures with their units, goals, and whether the goals are met. Measures nothing.

use std::fmt;

use serde::Serialize;

/// A quantity and its unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "unit", content = "value")]
pub enum Figure {
    /// Nanoseconds.
    Time(f64),
    /// A multiple of real time.
    Speed(f64),
    /// A share of one processor, in percent.
    Processor(f64),
    /// A share of a total, in percent.
    Share(f64),
    /// Bytes.
    Bytes(f64),
    /// A number of things.
    Count(f64),
}

/// The goal of a line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind", content = "value")]
pub enum Goal {
    /// The figure of jde is at most this many times the yardstick.
    AtMost(f64),
    /// The yardstick is at least this many times the figure of jde.
    TimesFaster(f64),
    /// The figure of jde exceeds the yardstick by at most this.
    Above(Figure),
    /// The figure of jde is at most this.
    Below(Figure),
    /// The figure of jde is at least this.
    Least(Figure),
    /// No goal: the figure is only reported.
    #[serde(rename = "told")]
    Reported,
}

/// The other side of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Yardstick {
    /// Its name.
    pub name: String,
    /// Its figure.
    pub figure: Figure,
    /// Whether it was measured elsewhere, on a machine of the same kind, and not in this run.
    pub given: bool,
}

/// One line of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// What was measured.
    pub what: String,
    /// The figure of jde.
    pub ours: Figure,
    /// The figure to compare with.
    pub yardstick: Option<Yardstick>,
    /// The figure of jde divided by the yardstick: the median over pairs if they were measured in pairs.
    pub ratio: Option<f64>,
    /// The goal.
    pub goal: Goal,
}

/// Whether the goal of a line is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The goal is met.
    Met,
    /// The goal is missed.
    Missed,
    /// There is no goal.
    #[serde(rename = "told")]
    Reported,
}

impl Figure {
    /// Returns the number without its unit.
    pub fn value(self) -> f64 {
        match self {
            Self::Time(value)
            | Self::Speed(value)
            | Self::Processor(value)
            | Self::Share(value)
            | Self::Bytes(value)
            | Self::Count(value) => value,
        }
    }

    /// Returns a time from milliseconds.
    pub fn millis(millis: f64) -> Self {
        Self::Time(millis * 1e6)
    }
}

impl Line {
    /// Makes a line without a yardstick.
    pub fn alone(what: impl Into<String>, ours: Figure, goal: Goal) -> Self {
        Self {
            what: what.into(),
            ours,
            yardstick: None,
            ratio: None,
            goal,
        }
    }

    /// Makes a line with a yardstick of the same run.
    pub fn beside(
        what: impl Into<String>,
        ours: Figure,
        name: impl Into<String>,
        theirs: Figure,
        goal: Goal,
    ) -> Self {
        Self {
            what: what.into(),
            ours,
            yardstick: Some(Yardstick {
                name: name.into(),
                figure: theirs,
                given: false,
            }),
            ratio: None,
            goal,
        }
    }

    /// Makes a line with a yardstick from elsewhere.
    pub fn given(
        what: impl Into<String>,
        ours: Figure,
        name: impl Into<String>,
        theirs: Figure,
        goal: Goal,
    ) -> Self {
        let mut line = Self::beside(what, ours, name, theirs, goal);
        line.yardstick
            .iter_mut()
            .for_each(|yardstick| yardstick.given = true);
        line
    }

    /// Sets the ratio to the median of the ratios of pairs.
    pub fn paired(self, ratio: f64) -> Self {
        Self {
            ratio: Some(ratio),
            ..self
        }
    }

    /// Returns the figure of jde divided by the yardstick, or `None` if the goal is a difference or the ratio
    /// is not finite.
    pub fn ratio(&self) -> Option<f64> {
        if matches!(self.goal, Goal::Above(_)) {
            return None;
        }
        let yardstick = self.yardstick.as_ref()?;
        let ratio = self.ratio.unwrap_or(self.ours.value() / yardstick.figure.value());
        // A yardstick of 0 gives no ratio.
        Some(ratio).filter(|ratio| ratio.is_finite())
    }

    /// Returns whether the goal is met.
    pub fn verdict(&self) -> Verdict {
        let ours = self.ours.value();
        let theirs = self.yardstick.as_ref().map(|yardstick| yardstick.figure.value());
        let met = match self.goal {
            Goal::AtMost(times) => self.ratio().is_some_and(|ratio| ratio <= times),
            Goal::TimesFaster(times) => self.ratio().is_some_and(|ratio| 1.0 / ratio >= times),
            Goal::Above(margin) => theirs.is_some_and(|theirs| ours - theirs <= margin.value()),
            Goal::Below(most) => ours <= most.value(),
            Goal::Least(least) => ours >= least.value(),
            Goal::Reported => return Verdict::Reported,
        };
        if met { Verdict::Met } else { Verdict::Missed }
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Time(ns) => f.write_str(&scaled(ns, &[(1.0, "ns"), (1e3, "us"), (1e6, "ms"), (1e9, "s")])),
            Self::Speed(times) => write!(f, "{times:.0}x real time"),
            Self::Processor(percent) => write!(f, "{percent:.2} % CPU"),
            Self::Share(percent) => write!(f, "{percent:.1} %"),
            Self::Bytes(bytes) => f.write_str(&scaled(bytes, &[(1.0, "B"), (1e3, "kB"), (1e6, "MB")])),
            Self::Count(count) => write!(f, "{count:.0}"),
        }
    }
}

impl fmt::Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtMost(times) => write!(f, "at most {times}x"),
            Self::TimesFaster(times) if *times == 1.0 => f.write_str("faster"),
            Self::TimesFaster(times) => write!(f, "{times}x faster"),
            Self::Above(margin) => write!(f, "{margin} above at most"),
            Self::Below(most) => write!(f, "at most {most}"),
            Self::Least(least) => write!(f, "{least} or more"),
            Self::Reported => f.write_str("-"),
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Met => "met",
            Self::Missed => "MISSED",
            Self::Reported => "-",
        })
    }
}

/// Formats a number with three digits, in the largest unit in which it is at least 1.
fn scaled(value: f64, units: &[(f64, &str)]) -> String {
    let fits = units.iter().rev().find(|(size, _)| value.abs() >= *size);
    let (size, unit) = *fits.unwrap_or(&units[0]);
    let value = value / size;
    let digits = match value.abs() {
        value if value >= 100.0 => 0,
        value if value >= 10.0 => 1,
        _ => 2,
    };
    format!("{value:.digits$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(ours: f64, theirs: f64, goal: Goal) -> Line {
        Line::beside("it", Figure::Time(ours), "them", Figure::Time(theirs), goal)
    }

    #[test]
    fn a_figure_has_three_digits() {
        assert_eq!(Figure::Time(0.5).to_string(), "0.50 ns");
        assert_eq!(Figure::Time(12_345.0).to_string(), "12.3 us");
        assert_eq!(Figure::Time(2.5e9).to_string(), "2.50 s");
        assert_eq!(Figure::Bytes(900_000.0).to_string(), "900 kB");
    }

    #[test]
    fn a_goal_is_met_up_to_its_limit() {
        assert_eq!(line(2.0, 1.0, Goal::AtMost(2.0)).verdict(), Verdict::Met);
        assert_eq!(line(2.1, 1.0, Goal::AtMost(2.0)).verdict(), Verdict::Missed);
        assert_eq!(line(1.0, 3.0, Goal::TimesFaster(3.0)).verdict(), Verdict::Met);
        assert_eq!(line(1.1, 3.0, Goal::TimesFaster(3.0)).verdict(), Verdict::Missed);
        let above = Goal::Above(Figure::Time(100.0));
        assert_eq!(line(101.0, 1.0, above).verdict(), Verdict::Met);
        assert_eq!(line(102.0, 1.0, above).verdict(), Verdict::Missed);
        assert_eq!(line(101.0, 1.0, above).ratio(), None, "the goal is a difference");
        let below = Goal::Below(Figure::Time(10.0));
        assert_eq!(
            Line::alone("it", Figure::Time(11.0), below).verdict(),
            Verdict::Missed
        );
        assert_eq!(
            Line::alone("it", Figure::Time(11.0), Goal::Reported).verdict(),
            Verdict::Reported
        );
    }

    #[test]
    fn a_ratio_without_a_yardstick_is_missed() {
        let line = Line::alone("it", Figure::Time(1.0), Goal::AtMost(2.0));
        assert_eq!(line.verdict(), Verdict::Missed);
    }

    #[test]
    fn the_median_of_pairs_replaces_the_ratio_of_medians() {
        assert_eq!(
            line(3.0, 1.0, Goal::AtMost(2.0)).paired(1.9).verdict(),
            Verdict::Met
        );
    }
}
