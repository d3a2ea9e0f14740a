//! The result of a drive: one line of `results.jsonl`. Depends on no clock of the machine, so the same drive
//! gives the same line everywhere.

use serde::ser::{Serialize, SerializeMap, Serializer};
use serde_json::Value;

/// The columns of an experiment's results, in their order. All names are distinct, also from [`FIXED`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Columns {
    /// The axes that have values: `seed`, `world`, `goon.fast`.
    pub axes: Vec<String>,
    /// The properties: `no collision`.
    pub properties: Vec<String>,
    /// The measures.
    pub measures: Vec<MeasureColumn>,
}

/// A measure's column.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeasureColumn {
    /// Its name.
    pub name: String,
    /// Its unit; may be empty.
    pub unit: String,
}

/// The columns that every result has.
pub const FIXED: [&str; 6] = ["drive", "outcome", "end", "seconds", "why", "failure"];

/// The verdict on a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// Every property holds.
    Passed,
    /// A property does not hold.
    Failed,
    /// The drive's process died.
    Crashed,
    /// The drive took longer than the limit of the machine's time.
    Hung,
    /// The application could not start, or could not continue.
    Broken,
}

/// The result of a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveResult {
    /// The number of the drive in the experiment, from 0.
    pub drive: usize,
    /// The value of each axis, in the order of [`Columns::axes`].
    pub axes: Vec<Value>,
    /// The verdict.
    pub outcome: Outcome,
    /// Why the drive ended: "done", "failed", "time up", "end", "broken"; empty if its process died.
    pub end: String,
    /// How long it drove, s of the application's time.
    pub seconds: f64,
    /// Whether each property holds; `None` if the drive could not be judged.
    pub properties: Vec<Option<bool>>,
    /// The value of each measure; `None` if it has none.
    pub measures: Vec<Option<f64>>,
    /// Why it did not pass, in words; empty if it passed.
    pub why: String,
    /// What led to the failure, if the drive failed.
    pub failure: Option<DriveFailure>,
}

/// What led to a failure.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DriveFailure {
    /// When the first property failed, s.
    pub at: f64,
    /// The robot's position and heading at that time: m, m, rad.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub pose: Option<[f64; 3]>,
    /// The robot's positions until then, at most 200, at equal intervals of time.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub path: Vec<[f64; 2]>,
    /// The winners along the path: each with the place of the first point at which it won, `None` for nobody.
    /// Empty if they are not known.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub winners: Vec<(usize, Option<String>)>,
    /// The last selections before it, the newest last, each as a line of text.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub selections: Vec<String>,
}

impl Outcome {
    /// All outcomes, in the order in which they are listed.
    pub const ALL: [Self; 5] = [
        Self::Passed,
        Self::Failed,
        Self::Crashed,
        Self::Hung,
        Self::Broken,
    ];

    /// The word in results.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::Crashed => "crashed",
            Self::Hung => "hung",
            Self::Broken => "broken",
        }
    }
}

impl DriveResult {
    /// Returns the result as a line of `results.jsonl`, without its line break.
    #[must_use]
    pub fn to_line(&self, columns: &Columns) -> String {
        serde_json::to_string(&ResultLine {
            result: self,
            columns,
        })
        .expect("its keys are texts")
    }

    /// Reads a line of `results.jsonl` of an experiment with these columns; `None` if it is not one.
    #[must_use]
    pub fn from_json(line: &str, columns: &Columns) -> Option<Self> {
        let Value::Object(object) = serde_json::from_str(line).ok()? else {
            return None;
        };
        let text = |name: &str| object.get(name).and_then(Value::as_str).map(str::to_owned);
        let outcome = text("outcome")?;
        let axes = columns.axes.iter().map(|name| object.get(name).cloned());
        let properties = columns
            .properties
            .iter()
            .map(|name| object.get(name).map(Value::as_bool));
        let measures = columns
            .measures
            .iter()
            .map(|measure| object.get(&measure.name).map(Value::as_f64));
        Some(Self {
            drive: usize::try_from(object.get("drive")?.as_u64()?).ok()?,
            axes: axes.collect::<Option<_>>()?,
            outcome: Outcome::ALL.into_iter().find(|known| known.word() == outcome)?,
            end: text("end")?,
            seconds: object.get("seconds")?.as_f64()?,
            properties: properties.collect::<Option<_>>()?,
            measures: measures.collect::<Option<_>>()?,
            why: text("why").unwrap_or_default(),
            failure: match object.get("failure") {
                Some(failure) => Some(serde_json::from_value(failure.clone()).ok()?),
                None => None,
            },
        })
    }
}

/// A result with the names of its columns.
struct ResultLine<'r> {
    result: &'r DriveResult,
    columns: &'r Columns,
}

impl Serialize for ResultLine<'_> {
    /// In the order of the columns, which a map of `serde_json` would lose.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { result, columns } = self;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("drive", &result.drive)?;
        for (name, value) in columns.axes.iter().zip(&result.axes) {
            map.serialize_entry(name, value)?;
        }
        map.serialize_entry("outcome", result.outcome.word())?;
        map.serialize_entry("end", &result.end)?;
        map.serialize_entry("seconds", &result.seconds)?;
        for (name, holds) in columns.properties.iter().zip(&result.properties) {
            map.serialize_entry(name, holds)?;
        }
        for (measure, value) in columns.measures.iter().zip(&result.measures) {
            map.serialize_entry(&measure.name, value)?;
        }
        if !result.why.is_empty() {
            map.serialize_entry("why", &result.why)?;
        }
        if let Some(failure) = &result.failure {
            map.serialize_entry("failure", failure)?;
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_survives_its_line() {
        let columns = Columns {
            axes: vec!["seed".into(), "goon.fast".into()],
            properties: vec!["no collision".into(), "reached".into()],
            measures: vec![MeasureColumn {
                name: "nearest".into(),
                unit: "m".into(),
            }],
        };
        let result = DriveResult {
            drive: 7,
            axes: vec![8.into(), "0.3 m/s".into()],
            outcome: Outcome::Failed,
            end: "time up".into(),
            seconds: 0.1 + 0.2,
            properties: vec![Some(false), None],
            measures: vec![Some(1.0 / 3.0)],
            why: "collisions > 0 at 12.3 s".into(),
            failure: Some(DriveFailure {
                at: 12.3,
                pose: Some([1.0, 2.0, 0.1]),
                path: vec![[0.0, 0.0], [1.0, 2.0]],
                winners: vec![(0, Some("goon".into())), (1, None)],
                selections: vec!["12.000 s example/base: vff".into()],
            }),
        };
        let line = result.to_line(&columns);
        assert_eq!(DriveResult::from_json(&line, &columns), Some(result));
        assert_eq!(
            DriveResult::from_json(&line[..line.len() - 1], &columns),
            None,
            "a torn line"
        );
    }
}
