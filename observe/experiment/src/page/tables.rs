//! The tables of the page: the same numbers as those on the terminal.

use jde_report::experiment::{Cell, Table, Title};

use super::Page;
use crate::result::{MeasureColumn, Outcome};
use crate::statistics::{Interval, Share};

pub(super) fn results(page: &Page<'_>) -> Table {
    let columns = page.summary.columns;
    let rows = &page.comparison.rows;
    let others: Vec<usize> = (1..Outcome::ALL.len())
        .filter(|outcome| rows.iter().any(|row| row.outcomes[*outcome] > 0))
        .collect();
    let mut titles = vec![title("", false), title("passed", true)];
    titles.extend(
        others
            .iter()
            .map(|outcome| title(Outcome::ALL[*outcome].word(), true)),
    );
    titles.extend(columns.measures.iter().map(|measure| title(&measure.name, true)));
    let row = |row: &crate::comparison::ComparisonRow| {
        let passed = row.passed;
        let mut cells = vec![
            Cell::from(row.name.as_str()),
            Cell {
                text: format!("{}/{}", passed.count, passed.total),
                details: vec![percentages(passed)],
                ..Cell::default()
            },
        ];
        cells.extend(others.iter().map(|outcome| count(row.outcomes[*outcome])));
        for (measure, column) in columns.measures.iter().enumerate() {
            let digits = page.comparison.digits[measure];
            cells.push(row.measures[measure].map_or_else(none, |found| Cell {
                text: number(&digits.text(found.median), column),
                details: vec![interval(found.interval, |value| digits.text(value))],
                ..Cell::default()
            }));
        }
        cells
    };
    Table {
        note: "A row for each combination of axes other than the seed: the share of drives that passed, and of each \
            measure the median, with their 95 % intervals."
            .to_owned(),
        titles,
        rows: rows.iter().map(row).collect(),
    }
}

pub(super) fn differences(page: &Page<'_>) -> Table {
    let columns = page.summary.columns;
    let mut rows = page.comparison.rows.iter();
    let first = rows.next().map_or("", |row| row.name.as_str());
    let mut titles = vec![title("", false), title("seeds", true)];
    titles.extend(["only here", "only there"].map(|passed| title(&format!("passed {passed}"), true)));
    titles.extend(columns.measures.iter().map(|measure| title(&measure.name, true)));
    let rows = rows.filter_map(|row| {
        let paired = row.paired.as_ref()?;
        let mut cells = vec![
            Cell::from(row.name.as_str()),
            Cell::from(paired.seeds.to_string()),
            Cell::from(paired.passed_here.to_string()),
            count(paired.passed_first),
        ];
        for (measure, column) in columns.measures.iter().enumerate() {
            let digits = page.comparison.paired_digits[measure];
            cells.push(paired.measures[measure].map_or_else(none, |found| Cell {
                text: number(&digits.signed(found.median), column),
                details: vec![
                    interval(found.interval, |value| digits.signed(value)),
                    format!("{} lower, {} higher", found.lower, found.higher),
                ],
                is_strong: !found.interval.contains(0.0),
                is_bad: false,
            }));
        }
        Some(cells)
    });
    Table {
        note: format!(
            "The differences from “{first}”, paired by seed: the median with its interval, in bold where 0 is outside."
        ),
        titles,
        rows: rows.collect(),
    }
}

pub(super) fn properties(page: &Page<'_>) -> Table {
    let names = page.summary.columns.properties.iter().enumerate();
    let rows = names.map(|(property, name)| {
        let of = |held: Option<bool>| {
            let count = |result: &&&crate::result::DriveResult| result.properties[property] == held;
            page.results.iter().filter(count).count()
        };
        vec![
            Cell::from(name.as_str()),
            Cell::from(of(Some(true)).to_string()),
            count(of(Some(false))),
            Cell::from(of(None).to_string()),
        ]
    });
    Table {
        note: String::new(),
        titles: vec![
            title("", false),
            title("holds", true),
            title("fails", true),
            title("not judged", true),
        ],
        rows: rows.collect(),
    }
}

fn title(text: &str, is_number: bool) -> Title {
    Title {
        text: text.to_owned(),
        is_number,
    }
}

/// A count of bad news.
fn count(count: usize) -> Cell {
    Cell {
        is_bad: count > 0,
        ..Cell::from(count.to_string())
    }
}

fn none() -> Cell {
    Cell::from("–")
}

fn number(number: &str, column: &MeasureColumn) -> String {
    match column.unit.as_str() {
        "" => number.to_owned(),
        unit => format!("{number} {unit}"),
    }
}

fn percentages(share: Share) -> String {
    let percent = |share: f64| format!("{:.0}", share * 100.0);
    format!("{} %", interval(share.interval, percent))
}

fn interval(Interval { low, high }: Interval, text: impl Fn(f64) -> String) -> String {
    format!("[{}, {}]", text(low), text(high))
}
