//! `report.html`: the content of the page that crate `report` renders. It computes no statistics of its own.

mod drives;
mod tables;
mod worlds;

use jde_report::experiment::{self, Distribution, DistributionRow, Fact, Report};

use crate::comparison::{Comparison, ComparisonRow};
use crate::result::{DriveResult, Outcome};
use crate::store::sorted;
use crate::summary::Summary;
use worlds::Worlds;

/// How the numbers of the page were computed.
const METHOD: &str = "Intervals are of 95 %: those of medians by percentile bootstrap of 2000 resamples, those of \
    shares by Wilson's score. Differences are between drives of the same seed.";

/// The data that the parts of the page share.
struct Page<'a> {
    summary: &'a Summary<'a>,
    /// In the order of the drives.
    results: Vec<&'a DriveResult>,
    comparison: Comparison,
}

/// Renders the page of a summary.
pub(crate) fn html(summary: &Summary<'_>) -> String {
    let page = Page {
        summary,
        results: sorted(summary.results),
        comparison: Comparison::of(summary.columns, summary.results),
    };
    let mut worlds = Worlds::new(summary);
    experiment::page(&Report {
        name: summary.name.to_owned(),
        doc: summary.doc.to_owned(),
        facts: page.facts(),
        results: tables::results(&page),
        differences: tables::differences(&page),
        properties: tables::properties(&page),
        distributions: page.distributions(),
        places: drives::places(&page, &mut worlds),
        failures: drives::failures(&page, &mut worlds),
        method: METHOD.to_owned(),
    })
}

impl Page<'_> {
    fn facts(&self) -> Vec<Fact> {
        let total = self.results.len();
        let mut facts = vec![Fact {
            label: "Drives".to_owned(),
            value: total.to_string(),
            detail: duration(self.results.iter().map(|result| result.seconds).sum()),
            is_bad: false,
        }];
        for outcome in Outcome::ALL {
            let count = self
                .results
                .iter()
                .filter(|result| result.outcome == outcome)
                .count();
            let is_passed = outcome == Outcome::Passed;
            // The rarer outcomes only if there are any.
            if count == 0 && !matches!(outcome, Outcome::Passed | Outcome::Failed) {
                continue;
            }
            let word = outcome.word();
            facts.push(Fact {
                label: format!("{}{}", word[..1].to_uppercase(), &word[1..]),
                value: count.to_string(),
                detail: format!("{:.1} %", 100.0 * count as f64 / total.max(1) as f64),
                is_bad: count > 0 && !is_passed,
            });
        }
        facts
    }

    fn distributions(&self) -> Vec<Distribution> {
        let measures = self.summary.columns.measures.iter().enumerate();
        let distribution = |(measure, column): (usize, &crate::result::MeasureColumn)| Distribution {
            measure: column.name.clone(),
            unit: column.unit.clone(),
            rows: self
                .comparison
                .rows
                .iter()
                .map(|row| self.distribution(row, measure))
                .collect(),
        };
        measures.map(distribution).collect()
    }

    fn distribution(&self, row: &ComparisonRow, measure: usize) -> DistributionRow {
        let results = row.results.iter().map(|place| &self.summary.results[*place]);
        let (passed, others): (Vec<_>, Vec<_>) =
            results.partition(|result| result.outcome == Outcome::Passed);
        let values = |results: Vec<&DriveResult>| {
            let values = results.into_iter().filter_map(|result| result.measures[measure]);
            values.collect()
        };
        let statistics = row.measures[measure].as_ref();
        DistributionRow {
            name: row.name.clone(),
            passed: values(passed),
            others: values(others),
            median: statistics.map(|found| [found.median, found.interval.low, found.interval.high]),
        }
    }
}

/// How long all drives took together: `12.3 h of driving`.
fn duration(seconds: f64) -> String {
    match seconds {
        seconds if seconds < 120.0 => format!("{seconds:.1} s of driving"),
        seconds if seconds < 7200.0 => format!("{:.1} min of driving", seconds / 60.0),
        seconds => format!("{:.1} h of driving", seconds / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use serde_json::json;

    use super::*;
    use crate::result::{Columns, DriveFailure, MeasureColumn};

    /// A drive that fails at the end of a path, won first by goon and then by vff.
    fn failed(drive: usize) -> DriveResult {
        DriveResult {
            drive,
            axes: vec![json!(drive + 1)],
            outcome: Outcome::Failed,
            end: "done".into(),
            seconds: 12.0,
            properties: vec![Some(false)],
            measures: vec![Some(0.25)],
            why: "collisions > 0 at 10 s".into(),
            failure: Some(DriveFailure {
                at: 10.0,
                pose: Some([3.0, 1.0, 0.5]),
                path: (0..11).map(|place| [f64::from(place) * 0.3, 1.0]).collect(),
                winners: vec![(0, Some("goon".into())), (6, Some("vff".into())), (8, None)],
                selections: vec!["9.000 s example/base: vff".into()],
            }),
        }
    }

    fn page(world: Option<&std::path::Path>, results: &[DriveResult]) -> String {
        let columns = Columns {
            axes: vec!["seed".into()],
            properties: vec!["no collision".into()],
            measures: vec![MeasureColumn {
                name: "nearest".into(),
                unit: "m".into(),
            }],
        };
        html(&Summary {
            name: "safe",
            doc: "Nothing is hit.",
            columns: &columns,
            results,
            world: &|_| world.map(std::path::Path::to_owned),
            robot: None,
            command: &|drive| format!("jde experiment safe --drive {drive}"),
        })
    }

    #[test]
    fn a_failed_drive_has_its_path_in_its_world_its_selections_and_its_command() {
        let folder = tempfile::tempdir().unwrap();
        let world = folder.path().join("shed.toml");
        let text = "walls = [{ name = \"shell\", points = [[0, 0], [6, 0], [6, 4], [0, 4]], closed = true }]";
        fs::write(&world, text).unwrap();
        let page = page(Some(&world), &[failed(17)]);
        for part in [
            "collisions &gt; 0 at 10 s",
            "9.000 s example/base: vff",
            "jde experiment safe --drive 17 --record failure.mcap\njde view failure.mcap --from 9.0s",
            "0.250 m",
            "Where 1 drive of shed failed",
            // Of ten steps, six until vff won and two until nobody did.
            "goon 60 %",
            "vff 20 %",
            "nobody 20 %",
        ] {
            assert!(page.contains(part), "{part}: {page}");
        }
    }

    #[test]
    fn a_world_that_cannot_be_read_is_named_and_the_path_is_drawn_without_it() {
        let page = page(Some("no-such-folder/shed.toml".as_ref()), &[failed(0)]);
        assert!(page.contains("The world is not drawn: "), "{page}");
        assert!(page.contains("no-such-folder/shed.toml"), "{page}");
        assert!(page.contains("The path of drive 0 until it failed"), "{page}");
    }

    #[test]
    fn the_order_of_the_results_changes_nothing() {
        let [a, b, c] = [0, 1, 2].map(failed);
        assert_eq!(
            page(None, &[c.clone(), a.clone(), b.clone()]),
            page(None, &[a, b, c])
        );
    }

    #[test]
    fn a_path_that_is_damaged_is_no_panic() {
        let damaged = |path: Vec<[f64; 2]>, winners: Vec<(usize, Option<String>)>| DriveResult {
            failure: Some(DriveFailure {
                at: f64::MAX,
                path,
                winners,
                ..DriveFailure::default()
            }),
            ..failed(0)
        };
        let results = [
            damaged(vec![[1.0, 1.0]], vec![(7, None), (0, Some("goon".into()))]),
            damaged(vec![[f64::MAX, 0.0], [0.0, 0.0]], vec![(0, None)]),
            damaged(Vec::new(), vec![(0, None)]),
        ];
        assert!(page(None, &results).ends_with("</html>"));
    }
}
