//! The table of faults injected and survived, for terminals and pages.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::case::{Case, RunMode, Scenario, name};
use crate::plan::Kind;
use crate::run::CaseResult;

/// The columns: where faults are injected.
const COLUMNS: [(RunMode, Scenario, &str); 5] = [
    (RunMode::Lockstep, Scenario::Demo, "lockstep, demo"),
    (RunMode::Lockstep, Scenario::Hundred, "lockstep, 100"),
    (RunMode::RealTime, Scenario::Demo, "real time, demo"),
    (RunMode::RealTime, Scenario::Hundred, "real time, 100"),
    (RunMode::Outside, Scenario::Demo, "processes"),
];

/// The counts.
#[derive(Debug, Default)]
pub struct Table {
    rows: BTreeMap<Kind, Row>,
    violations: Vec<(Case, String)>,
}

#[derive(Debug, Default)]
struct Row {
    counts: [u64; COLUMNS.len()],
    effective: u64,
    failed: u64,
}

impl Table {
    /// Counts the results of a case.
    pub fn add(&mut self, report: &CaseResult) {
        let column = COLUMNS.iter().position(|(clock, scenario, _)| {
            *clock == report.case.clock && *scenario == report.case.scenario
        });
        for injected in &report.faults {
            let row = self.rows.entry(injected.fault.kind).or_default();
            if let Some(column) = column {
                row.counts[column] += 1;
            }
            row.effective += u64::from(injected.took_effect);
            // Among several faults of one case, the cause cannot be determined.
            row.failed += u64::from(!report.violations.is_empty());
        }
        let violations = report
            .violations
            .iter()
            .map(|violation| (report.case, violation.clone()));
        self.violations.extend(violations);
    }

    /// The number of faults so far.
    #[must_use]
    pub fn injected(&self) -> u64 {
        self.rows.values().flat_map(|row| row.counts).sum()
    }

    /// The violations, each with its case.
    #[must_use]
    pub fn violations(&self) -> &[(Case, String)] {
        &self.violations
    }

    /// The table in Markdown, which a terminal can show too.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut lines = vec![
            [
                &["fault"][..],
                &COLUMNS.map(|(_, _, title)| title),
                &["took effect", "survived"],
            ]
            .concat()
            .join(" | "),
        ];
        let count = lines[0].split(" | ").count();
        lines.push(vec!["---"; count].join(" | "));
        let mut sum = Row::default();
        for (kind, row) in &self.rows {
            lines.push(row.line(&name(kind)));
            sum.effective += row.effective;
            sum.failed += row.failed;
            for (total, count) in sum.counts.iter_mut().zip(row.counts) {
                *total += count;
            }
        }
        lines.push(sum.line("all"));
        lines.iter().fold(String::new(), |mut text, line| {
            let _ = writeln!(text, "| {line} |");
            text
        })
    }
}

impl Row {
    fn line(&self, name: &str) -> String {
        let cells = self.counts.map(|count| {
            if count == 0 {
                "-".to_owned()
            } else {
                count.to_string()
            }
        });
        let injected: u64 = self.counts.iter().sum();
        let survived = injected - self.failed;
        format!("{name} | {} | {} | {survived}", cells.join(" | "), self.effective)
    }
}
