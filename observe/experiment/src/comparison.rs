//! The results side by side: a row for each combination of axes other than the seed, and the differences of
//! each row from the first over equal seeds. The tables and the page show it.
//!
//! It runs nothing and draws nothing.

use std::collections::HashMap;

use serde_json::Value;

use crate::digits::Digits;
use crate::result::{Columns, DriveResult, Outcome};
use crate::statistics::{Differences, Share, Statistics};

/// The axis over which rows are statistics.
const SEED: &str = "seed";

/// The rows of an experiment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// In the order of their first drives.
    pub rows: Vec<ComparisonRow>,
    /// The digits of each measure.
    pub digits: Vec<Digits>,
    /// The digits of the differences of each measure.
    pub paired_digits: Vec<Digits>,
}

/// The drives with the same values of all axes but the seed.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonRow {
    /// The axes that differ between rows and their values: `goon.fast 0.5 m/s, variant tried`. "all drives"
    /// if it is the only row.
    pub name: String,
    /// The places of its results among all results, in the order of the drives.
    pub results: Vec<usize>,
    /// How many drives had each outcome, in the order of [`Outcome::ALL`].
    pub outcomes: [usize; Outcome::ALL.len()],
    /// The share of drives that passed.
    pub passed: Share,
    /// In how many drives each property failed, in the order of [`Columns::properties`].
    pub failed_properties: Vec<usize>,
    /// The statistics of each measure over the drives that have it, in the order of [`Columns::measures`].
    pub measures: Vec<Option<Statistics>>,
    /// The differences from the first row; `None` for the first row, and for one that shares no seed with it.
    pub paired: Option<Paired>,
}

/// How a row differs from the first over the seeds that both have.
#[derive(Clone, Debug, PartialEq)]
pub struct Paired {
    /// The number of seeds that both have.
    pub seeds: usize,
    /// How many of them passed only in this row.
    pub passed_here: usize,
    /// How many of them passed only in the first row.
    pub passed_first: usize,
    /// The differences of each measure over the seeds for which both rows have it.
    pub measures: Vec<Option<Differences>>,
}

impl Comparison {
    /// Compares results, which may be in any order.
    #[must_use]
    pub fn of(columns: &Columns, results: &[DriveResult]) -> Self {
        let seed = columns.axes.iter().position(|axis| axis == SEED);
        let groups = groups(results, seed);
        let differing: Vec<usize> = (0..columns.axes.len())
            .filter(|axis| Some(*axis) != seed)
            .filter(|axis| {
                let mut values = groups.iter().map(|group| &results[group[0]].axes[*axis]);
                let first = values.next();
                values.any(|value| Some(value) != first)
            })
            .collect();
        let first = groups.first().cloned().unwrap_or_default();
        let rows = groups.into_iter().enumerate().map(|(number, group)| {
            let paired = (number > 0).then(|| Paired::of(columns, results, seed?, &group, &first));
            ComparisonRow {
                name: name(columns, &results[group[0]], &differing),
                paired: paired.flatten(),
                ..ComparisonRow::of(columns, results, group)
            }
        });
        let rows: Vec<ComparisonRow> = rows.collect();
        let digits = |measure: usize| {
            let statistics = rows.iter().filter_map(|row| row.measures[measure]);
            Digits::of(statistics.map(|found| (found.median, found.interval)))
        };
        let paired_digits = |measure: usize| {
            let paired = rows.iter().filter_map(|row| row.paired.as_ref());
            let differences = paired.filter_map(|paired| paired.measures[measure]);
            Digits::of(differences.map(|found| (found.median, found.interval)))
        };
        let measures = 0..columns.measures.len();
        Self {
            digits: measures.clone().map(digits).collect(),
            paired_digits: measures.map(paired_digits).collect(),
            rows,
        }
    }
}

impl ComparisonRow {
    /// A row without a name and without differences.
    fn of(columns: &Columns, results: &[DriveResult], group: Vec<usize>) -> Self {
        let all = || group.iter().map(|place| &results[*place]);
        let outcomes = Outcome::ALL.map(|outcome| all().filter(|result| result.outcome == outcome).count());
        let failed = |property: usize| {
            let failed = |result: &&DriveResult| result.properties[property] == Some(false);
            all().filter(failed).count()
        };
        let statistics = |measure: usize| Statistics::of(all().filter_map(|result| result.measures[measure]));
        Self {
            name: String::new(),
            outcomes,
            passed: Share::of(outcomes[Outcome::Passed as usize], group.len()),
            failed_properties: (0..columns.properties.len()).map(failed).collect(),
            measures: (0..columns.measures.len()).map(statistics).collect(),
            paired: None,
            results: group,
        }
    }
}

impl Paired {
    /// Pairs each drive of a group with the one of the base that has the same seed.
    fn of(
        columns: &Columns,
        results: &[DriveResult],
        seed: usize,
        group: &[usize],
        base: &[usize],
    ) -> Option<Self> {
        let mut base_by_seed: HashMap<&Value, &DriveResult> = HashMap::new();
        for result in base.iter().map(|place| &results[*place]) {
            base_by_seed.entry(&result.axes[seed]).or_insert(result);
        }
        // Removed, since a seed that is listed twice would count twice.
        let pairs: Vec<(&DriveResult, &DriveResult)> = group
            .iter()
            .map(|place| &results[*place])
            .filter_map(|result| Some((result, base_by_seed.remove(&result.axes[seed])?)))
            .collect();
        if pairs.is_empty() {
            return None;
        }
        let passed = |result: &DriveResult| result.outcome == Outcome::Passed;
        let only = |here: bool| {
            let count = |(result, base): &&(&DriveResult, &DriveResult)| {
                passed(result) == here && passed(base) != here
            };
            pairs.iter().filter(count).count()
        };
        let differences = |measure: usize| {
            let values = |(result, base): &(&DriveResult, &DriveResult)| {
                Some((result.measures[measure]?, base.measures[measure]?))
            };
            Differences::of(pairs.iter().filter_map(values))
        };
        Some(Self {
            seeds: pairs.len(),
            passed_here: only(true),
            passed_first: only(false),
            measures: (0..columns.measures.len()).map(differences).collect(),
        })
    }
}

/// The places of the results of each row, in the order of the drives.
fn groups(results: &[DriveResult], seed: Option<usize>) -> Vec<Vec<usize>> {
    let mut places: Vec<usize> = (0..results.len()).collect();
    places.sort_by_key(|place| results[*place].drive);
    let mut numbers: HashMap<Vec<&Value>, usize> = HashMap::new();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for place in places {
        let axes = results[place].axes.iter().enumerate();
        let key = axes
            .filter(|(axis, _)| Some(*axis) != seed)
            .map(|(_, value)| value);
        let number = *numbers.entry(key.collect()).or_insert(groups.len());
        match groups.get_mut(number) {
            Some(group) => group.push(place),
            None => groups.push(vec![place]),
        }
    }
    groups
}

fn name(columns: &Columns, result: &DriveResult, axes: &[usize]) -> String {
    if axes.is_empty() {
        return "all drives".to_owned();
    }
    let names = axes
        .iter()
        .map(|axis| format!("{} {}", columns.axes[*axis], words(&result.axes[*axis])));
    names.collect::<Vec<_>>().join(", ")
}

/// The value of an axis in words: `{"pioneer": {"x": 1, "y": 2}}` is `pioneer x 1 y 2`.
#[must_use]
pub fn words(value: &Value) -> String {
    let joined = |words: &mut dyn Iterator<Item = String>| words.collect::<Vec<_>>().join(" ");
    match value {
        Value::String(text) => text.clone(),
        Value::Array(values) => joined(&mut values.iter().map(words)),
        Value::Object(fields) => joined(
            &mut fields
                .iter()
                .map(|(name, value)| format!("{name} {}", words(value))),
        ),
        Value::Null | Value::Bool(_) | Value::Number(_) => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde_json::json;

    use super::*;
    use crate::result::MeasureColumn;

    fn columns() -> Columns {
        Columns {
            axes: ["seed", "world", "goon.fast"].map(str::to_owned).to_vec(),
            properties: vec!["no collision".into()],
            measures: vec![MeasureColumn::default()],
        }
    }

    /// The drives of two speeds, the last axis fastest. The faster one needs half the time and fails for the
    /// seed 3.
    fn results() -> Vec<DriveResult> {
        let drive = |drive: usize| {
            let (seed, fast) = (drive / 2 + 1, drive % 2 == 1);
            let passed = !(fast && seed == 3);
            DriveResult {
                drive,
                axes: vec![
                    json!(seed),
                    json!("office.toml"),
                    json!(if fast { "0.6 m/s" } else { "0.3 m/s" }),
                ],
                outcome: if passed { Outcome::Passed } else { Outcome::Failed },
                end: "done".into(),
                seconds: 10.0,
                properties: vec![Some(passed)],
                measures: vec![passed.then_some(seed as f64 * if fast { 1.0 } else { 2.0 })],
                why: String::new(),
                failure: None,
            }
        };
        (0..10).map(drive).collect()
    }

    #[test]
    fn a_row_has_the_drives_that_differ_only_in_their_seed() {
        let comparison = Comparison::of(&columns(), &results());
        let [slow, fast] = &comparison.rows[..] else {
            panic!("{comparison:?}")
        };
        assert_eq!(slow.name, "goon.fast 0.3 m/s");
        assert_eq!(fast.name, "goon.fast 0.6 m/s");
        assert_eq!(slow.results, [0, 2, 4, 6, 8]);
        assert_eq!(fast.outcomes, [4, 1, 0, 0, 0]);
        assert_eq!((fast.passed.count, fast.passed.total), (4, 5));
        assert_eq!(fast.failed_properties, [1]);
        let [slow, fast] = [slow, fast].map(|row| row.measures[0].unwrap());
        assert_eq!((slow.count, slow.median), (5, 6.0));
        assert_eq!((fast.count, fast.median), (4, 3.0));
    }

    #[test]
    fn differences_are_over_equal_seeds() {
        let comparison = Comparison::of(&columns(), &results());
        assert_eq!(comparison.rows[0].paired, None);
        let paired = comparison.rows[1].paired.as_ref().unwrap();
        assert_eq!((paired.seeds, paired.passed_here, paired.passed_first), (5, 0, 1));
        let time = paired.measures[0].unwrap();
        // Over the seeds 1, 2, 4 and 5: the third has no value.
        assert_eq!(
            (time.pairs, time.median, time.lower, time.higher),
            (4, -3.0, 4, 0)
        );
    }

    #[test]
    fn rows_without_a_common_seed_have_no_differences() {
        let mut results = results();
        results
            .iter_mut()
            .for_each(|result| result.axes[0] = json!(result.drive));
        let comparison = Comparison::of(&columns(), &results);
        assert!(comparison.rows.iter().all(|row| row.paired.is_none()));
    }

    #[test]
    fn a_single_row_is_all_drives() {
        let comparison = Comparison::of(&columns(), &results()[..1]);
        assert_eq!(comparison.rows[0].name, "all drives");
        assert_eq!(Comparison::of(&columns(), &[]).rows, []);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn the_order_of_the_results_changes_nothing(results in Just(results()).prop_shuffle()) {
            let sorted = Comparison::of(&columns(), &self::results());
            let mut found = Comparison::of(&columns(), &results);
            for row in &mut found.rows {
                row.results.iter_mut().for_each(|place| *place = results[*place].drive);
            }
            prop_assert_eq!(found, sorted);
        }
    }

    #[test]
    fn the_value_of_an_axis_is_words() {
        assert_eq!(words(&json!("../worlds/office.toml")), "../worlds/office.toml");
        assert_eq!(words(&json!(17)), "17");
        assert_eq!(
            words(&json!({ "pioneer": { "x": 3.5, "y": 2 } })),
            "pioneer x 3.5 y 2"
        );
    }
}
