//! The tables of an experiment: its rows, and their differences from the first. They fit the terminal. It
//! computes nothing.

use std::io::{self, Write};

use jde_experiment::comparison::{Comparison, ComparisonRow, Paired};
use jde_experiment::result::{Columns, Outcome};
use jde_experiment::statistics::{Interval, Share};
use jde_session::top::text::{columns, cut_start};
use jde_terminal::{BAD, FAINT, GOOD, Style, TITLE, WARN};

use crate::remote::table::{Alignment, Cell, Table};

/// The space between two columns.
const COLUMN_GAP: usize = 2;
/// Least width of the names of rows, however little room the numbers leave.
const LEAST_NAME: usize = 16;

/// Columns that stay together: a number and its interval.
struct Group {
    titles: Vec<(String, Alignment)>,
    rows: Vec<Vec<(String, Style)>>,
}

/// Writes the tables of a comparison in lines of at most `width` columns, if the terminal has that many for a
/// name and one measure.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn write(
    output: &mut dyn Write,
    names: &Columns,
    comparison: &Comparison,
    width: Option<usize>,
) -> io::Result<()> {
    let width = width.unwrap_or(usize::MAX);
    match &comparison.rows[..] {
        [] => return Ok(()),
        [row] => write_row(output, names, comparison, row)?,
        rows => {
            let mut groups = vec![passed(rows), outcomes(rows)];
            groups.extend((0..names.measures.len()).map(|measure| values(names, comparison, measure)));
            let row_names: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
            write_groups(output, &row_names, groups, width)?;
            write_paired(output, names, comparison, width)?;
        }
    }
    write_properties(output, names, comparison)
}

/// Writes the only row: a line for each measure.
fn write_row(
    output: &mut dyn Write,
    names: &Columns,
    comparison: &Comparison,
    row: &ComparisonRow,
) -> io::Result<()> {
    let style = verdict(row.passed);
    write!(
        output,
        "{style}passed {}/{}{style:#}{FAINT} {}{FAINT:#}",
        row.passed.count,
        row.passed.total,
        percentages(row.passed)
    )?;
    for (outcome, count) in other_outcomes(row).filter(|(_, count)| *count > 0) {
        write!(output, ", {count} {}", outcome.word())?;
    }
    writeln!(output)?;
    let titles = ["", "median", "95 % interval", "min", "max", "drives"].into_iter();
    let mut table = Table::new(titles.enumerate().map(|(column, title)| {
        let is_text = column == 0 || column == 2;
        (
            title,
            if is_text {
                Alignment::Left
            } else {
                Alignment::Right
            },
        )
    }));
    for (measure, (name, digits)) in names.measures.iter().zip(&comparison.digits).enumerate() {
        let Some(found) = &row.measures[measure] else {
            table.add_row([Cell::from(&name.name), Cell::from("none").styled(FAINT)]);
            continue;
        };
        let number = |value: f64| with_unit(&digits.text(value), &name.unit);
        let interval = interval(found.interval, |value| digits.text(value));
        table.add_row([
            Cell::from(&name.name),
            Cell::from(number(found.median)).styled(TITLE),
            Cell::from(interval).styled(FAINT),
            number(found.min).into(),
            number(found.max).into(),
            found.count.into(),
        ]);
    }
    if !names.measures.is_empty() {
        writeln!(output)?;
        table.write(output)?;
    }
    Ok(())
}

/// Writes the differences of the rows that share seeds with the first one.
fn write_paired(
    output: &mut dyn Write,
    names: &Columns,
    comparison: &Comparison,
    width: usize,
) -> io::Result<()> {
    let rows = comparison.rows.iter();
    let (row_names, paired): (Vec<&str>, Vec<&Paired>) = rows
        .filter_map(|row| Some((row.name.as_str(), row.paired.as_ref()?)))
        .unzip();
    if paired.is_empty() {
        return Ok(());
    }
    let first = cut_start(&comparison.rows[0].name, width.saturating_sub(34).max(LEAST_NAME));
    writeln!(output)?;
    writeln!(output, "{TITLE}difference from {first}, paired by seed{TITLE:#}")?;
    let counts = paired.iter().map(|paired| {
        let (more, less) = (paired.passed_here, paired.passed_first);
        vec![
            (paired.seeds.to_string(), Style::new()),
            (format!("+{more}"), if more > 0 { GOOD } else { FAINT }),
            (format!("-{less}"), if less > 0 { BAD } else { FAINT }),
        ]
    });
    let mut groups = vec![Group {
        titles: ["seeds", "passed", ""]
            .map(|title| (title.to_owned(), Alignment::Right))
            .to_vec(),
        rows: counts.collect(),
    }];
    for (measure, (name, digits)) in names.measures.iter().zip(&comparison.paired_digits).enumerate() {
        let rows = paired.iter().map(|paired| {
            let Some(found) = &paired.measures[measure] else {
                return empty();
            };
            // An interval without 0 is what a reader looks for.
            let style = if found.interval.contains(0.0) {
                Style::new()
            } else {
                TITLE
            };
            let median = with_unit(&digits.signed(found.median), &name.unit);
            let interval = interval(found.interval, |value| digits.signed(value));
            vec![(median, style), (interval, FAINT)]
        });
        groups.push(Group::of_measure(&name.name, rows.collect()));
    }
    write_groups(output, &row_names, groups, width)
}

/// Writes which properties failed, and how often.
fn write_properties(output: &mut dyn Write, names: &Columns, comparison: &Comparison) -> io::Result<()> {
    let mut table = Table::untitled(2);
    for (property, name) in names.properties.iter().enumerate() {
        let failed: usize = comparison
            .rows
            .iter()
            .map(|row| row.failed_properties[property])
            .sum();
        if failed > 0 {
            let drives: usize = comparison.rows.iter().map(|row| row.results.len()).sum();
            table.add_row([
                Cell::from(name),
                Cell::from(format!("fails in {failed} of {drives}")).styled(BAD),
            ]);
        }
    }
    if !table.is_empty() {
        writeln!(output)?;
        table.write(output)?;
    }
    Ok(())
}

/// The drives that passed in each row.
fn passed(rows: &[ComparisonRow]) -> Group {
    let cells = rows.iter().map(|row| {
        let Share { count, total, .. } = row.passed;
        vec![
            (format!("{count}/{total}"), verdict(row.passed)),
            (percentages(row.passed), FAINT),
        ]
    });
    Group::of_measure("passed", cells.collect())
}

/// How the other drives of each row ended.
fn outcomes(rows: &[ComparisonRow]) -> Group {
    let titles = Outcome::ALL
        .into_iter()
        .filter(|outcome| *outcome != Outcome::Passed);
    let cells = rows.iter().map(|row| {
        let counts = other_outcomes(row);
        counts
            .map(|(_, count)| match count {
                0 => (String::new(), Style::new()),
                count => (count.to_string(), BAD),
            })
            .collect()
    });
    Group {
        titles: titles
            .map(|outcome| (outcome.word().to_owned(), Alignment::Right))
            .collect(),
        rows: cells.collect(),
    }
}

/// A measure in each row.
fn values(names: &Columns, comparison: &Comparison, measure: usize) -> Group {
    let (name, digits) = (&names.measures[measure], comparison.digits[measure]);
    let cells = comparison.rows.iter().map(|row| {
        let Some(found) = &row.measures[measure] else {
            return empty();
        };
        vec![
            (with_unit(&digits.text(found.median), &name.unit), Style::new()),
            (interval(found.interval, |value| digits.text(value)), FAINT),
        ]
    });
    Group::of_measure(&name.name, cells.collect())
}

/// Writes rows with as many groups as fit beside the names, and the others in further tables below.
fn write_groups(
    output: &mut dyn Write,
    names: &[&str],
    mut groups: Vec<Group>,
    width: usize,
) -> io::Result<()> {
    let longest = names.iter().map(|name| columns(name)).max().unwrap_or(0);
    let widths = || groups.iter().map(Group::width);
    let name_width = match longest + widths().sum::<usize>() {
        whole if whole <= width => longest,
        // At most half of the line, and never what the widest group needs.
        _ => {
            let rest = width.saturating_sub(widths().max().unwrap_or(0));
            longest.min(rest.min(width / 2).max(LEAST_NAME))
        }
    };
    while !groups.is_empty() {
        let mut used = name_width;
        let fitting = groups.iter().take_while(|group| {
            used += group.width();
            used <= width
        });
        // A group alone is written even if it is too wide.
        let count = fitting.count().max(1);
        let shown: Vec<Group> = groups.drain(..count).collect();
        let titles = shown.iter().flat_map(|group| group.titles.iter().cloned());
        let first = (String::new(), Alignment::Left);
        let mut table = Table::new([first].into_iter().chain(titles));
        for (row, name) in names.iter().enumerate() {
            let cells = shown.iter().flat_map(|group| &group.rows[row]);
            let cells = cells.map(|(text, style)| Cell::from(text).styled(*style));
            table.add_row([Cell::from(cut_start(name, name_width))].into_iter().chain(cells));
        }
        table.write(output)?;
        if !groups.is_empty() {
            writeln!(output)?;
        }
    }
    Ok(())
}

impl Group {
    /// A number and its interval, below one title.
    fn of_measure(title: &str, rows: Vec<Vec<(String, Style)>>) -> Self {
        Self {
            titles: vec![
                (title.to_owned(), Alignment::Right),
                (String::new(), Alignment::Left),
            ],
            rows,
        }
    }

    /// The width with the gaps before its columns. Empty columns are omitted.
    fn width(&self) -> usize {
        let widths = self.titles.iter().enumerate().map(|(column, (title, _))| {
            let cells = self.rows.iter().map(|row| columns(&row[column].0));
            match cells.max() {
                None | Some(0) => 0,
                Some(widest) => COLUMN_GAP + widest.max(columns(title)),
            }
        });
        widths.sum()
    }
}

/// The cells of a measure without values.
fn empty() -> Vec<(String, Style)> {
    vec![("none".to_owned(), FAINT), (String::new(), FAINT)]
}

fn other_outcomes(row: &ComparisonRow) -> impl Iterator<Item = (Outcome, usize)> {
    let counts = Outcome::ALL.into_iter().zip(row.outcomes);
    counts.filter(|(outcome, _)| *outcome != Outcome::Passed)
}

fn verdict(passed: Share) -> Style {
    match passed.count {
        count if count == passed.total => GOOD,
        0 => BAD,
        _ => WARN,
    }
}

fn percentages(share: Share) -> String {
    let percent = |share: f64| format!("{:.0}", share * 100.0);
    format!("{} %", interval(share.interval, percent))
}

fn interval(Interval { low, high }: Interval, text: impl Fn(f64) -> String) -> String {
    format!("[{}, {}]", text(low), text(high))
}

fn with_unit(number: &str, unit: &str) -> String {
    match unit {
        "" => number.to_owned(),
        unit => format!("{number} {unit}"),
    }
}

#[cfg(test)]
mod tests {
    use jde_experiment::result::{DriveResult, MeasureColumn};

    use super::*;

    /// Drives of a hundred seeds each at some speeds: faster ones are nearer and fail more often.
    fn text(speeds: &[&str], width: usize) -> String {
        let names = Columns {
            axes: vec!["seed".into(), "variant".into()],
            properties: vec!["no collision".into(), "reached".into()],
            measures: [("nearest", "m"), ("time", "s"), ("stops", "")]
                .map(|(name, unit)| MeasureColumn {
                    name: name.into(),
                    unit: unit.into(),
                })
                .to_vec(),
        };
        let drive = |drive: usize| {
            let (seed, speed) = (drive / speeds.len(), drive % speeds.len());
            let fails = speed > 0 && seed.is_multiple_of(50);
            DriveResult {
                drive,
                axes: vec![seed.into(), speeds[speed].into()],
                outcome: match (fails, seed) {
                    (false, _) => Outcome::Passed,
                    (true, 0) => Outcome::Crashed,
                    (true, _) => Outcome::Failed,
                },
                end: "done".into(),
                seconds: 1.0,
                properties: vec![Some(!fails || seed == 0), Some(true)],
                measures: vec![
                    Some(0.4 - 0.1 * speed as f64 + seed as f64 / 1e3),
                    Some(100.0 / (1.0 + speed as f64) + seed as f64 / 7.0),
                    None,
                ],
                why: String::new(),
                failure: None,
            }
        };
        let results: Vec<_> = (0..100 * speeds.len()).map(drive).collect();
        let mut text = Vec::new();
        write(&mut text, &names, &Comparison::of(&names, &results), Some(width)).unwrap();
        jde_terminal::escape::without_styles(&String::from_utf8(text).unwrap())
    }

    #[test]
    fn rows_have_a_median_with_its_interval_and_differences_from_the_first() {
        let expected = "
               passed               failed  crashed  nearest
variant slow  100/100  [96, 100] %                   0.450 m  [0.440, 0.459]
variant fast   98/100  [93, 99] %        1        1  0.350 m  [0.340, 0.359]

                 time                  stops
variant slow  107.1 s  [105.7, 108.4]   none
variant fast   57.1 s  [55.7, 58.4]     none

difference from variant slow, paired by seed
              seeds  passed       nearest                     time              stops
variant fast    100      +0  -2  -0.100 m  [-0.100, -0.100]  -50 s  [-50, -50]   none

no collision  fails in 1 of 200
";
        assert_eq!(text(&["slow", "fast"], 100), expected[1..]);
    }

    #[test]
    fn a_single_row_has_a_line_for_each_measure() {
        let expected = "\
passed 100/100 [96, 100] %

          median  95 % interval       min      max  drives
nearest  0.450 m  [0.440, 0.459]  0.400 m  0.499 m     100
time     107.1 s  [105.7, 108.4]  100.0 s  114.1 s     100
stops       none
";
        assert_eq!(text(&["slow"], 100), expected);
    }

    #[test]
    fn the_tables_fit_the_terminal_and_names_keep_their_ends() {
        let long = "target/release/some/folder/of/the/variant/libgoon.so";
        for width in [52, 64, 80, 100] {
            let text = text(&["slow", long], width);
            let widest = text.lines().map(columns).max();
            assert!(widest <= Some(width), "{width}:\n{text}");
            assert!(text.contains("…") && text.contains("libgoon.so"), "{text}");
        }
    }
}
