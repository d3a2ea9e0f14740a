//! The table of faults injected and survived, for terminals and pages. Counts only; it judges nothing.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::case::{Case, Clock, What};
use crate::plan::Kind;
use crate::run::Report;

/// The columns: where faults are injected.
const LANES: [(Clock, What, &str); 5] = [
    (Clock::Lockstep, What::Demo, "lockstep, demo"),
    (Clock::Lockstep, What::Hundred, "lockstep, 100"),
    (Clock::RealTime, What::Demo, "real time, demo"),
    (Clock::RealTime, What::Hundred, "real time, 100"),
    (Clock::Outside, What::Demo, "processes"),
];

/// The counts.
#[derive(Debug, Default)]
pub struct Table {
    rows: BTreeMap<Kind, Row>,
    broken: Vec<(Case, String)>,
}

#[derive(Debug, Default)]
struct Row {
    lanes: [u64; LANES.len()],
    struck: u64,
    broke: u64,
}

impl Table {
    /// Counts the results of a case.
    pub fn add(&mut self, report: &Report) {
        let lane = LANES
            .iter()
            .position(|(clock, what, _)| *clock == report.case.clock && *what == report.case.what);
        for injected in &report.faults {
            let row = self.rows.entry(injected.fault.kind).or_default();
            if let Some(lane) = lane {
                row.lanes[lane] += 1;
            }
            row.struck += u64::from(injected.struck);
            // Among several faults of one case, the cause cannot be determined.
            row.broke += u64::from(!report.broken.is_empty());
        }
        let told = report.broken.iter().map(|broken| (report.case, broken.clone()));
        self.broken.extend(told);
    }

    /// The number of faults so far.
    #[must_use]
    pub fn injected(&self) -> u64 {
        self.rows.values().flat_map(|row| row.lanes).sum()
    }

    /// The violations, each with its case.
    #[must_use]
    pub fn broken(&self) -> &[(Case, String)] {
        &self.broken
    }

    /// The table in Markdown, which a terminal can show too.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut lines = vec![
            [
                &["fault"][..],
                &LANES.map(|(_, _, title)| title),
                &["took effect", "survived"],
            ]
            .concat()
            .join(" | "),
        ];
        let count = lines[0].split(" | ").count();
        lines.push(vec!["---"; count].join(" | "));
        let mut sum = Row::default();
        for (kind, row) in &self.rows {
            lines.push(row.line(kind.name()));
            sum.struck += row.struck;
            sum.broke += row.broke;
            for (all, one) in sum.lanes.iter_mut().zip(row.lanes) {
                *all += one;
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
        let lanes = self.lanes.map(|count| {
            if count == 0 {
                "-".to_owned()
            } else {
                count.to_string()
            }
        });
        let injected: u64 = self.lanes.iter().sum();
        let survived = injected - self.broke;
        format!("{name} | {} | {} | {survived}", lanes.join(" | "), self.struck)
    }
}
