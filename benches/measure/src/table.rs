//! The table as plain text. Judges nothing; the lines do.

use std::fmt::Write as _;

use crate::figure::{Line, Verdict};

/// Colour on a terminal, plain text elsewhere.
#[derive(Clone, Copy, Debug)]
pub struct Paint(pub bool);

impl Paint {
    fn verdict(self, text: &str, verdict: Verdict) -> String {
        let code = match verdict {
            Verdict::Met => "32",
            Verdict::Missed => "31",
            Verdict::Reported => "2",
        };
        if self.0 {
            format!("\x1b[{code}m{text}\x1b[0m")
        } else {
            text.to_owned()
        }
    }
}

const HEAD: [&str; 7] = ["what", "ours", "yardstick", "theirs", "ratio", "goal", "met"];

/// Returns all lines of all rows, and how many met their goals.
pub fn table(rows: &[(String, Vec<Line>)], paint: Paint) -> String {
    let lines: Vec<&Line> = rows.iter().flat_map(|(_, lines)| lines).collect();
    let cells: Vec<[String; 7]> = lines.iter().map(|line| cells(line)).collect();
    let width = |column: usize| {
        let all = cells.iter().map(|cells| cells[column].chars().count());
        all.chain([HEAD[column].len()]).max().unwrap_or_default()
    };
    let widths: [usize; 7] = std::array::from_fn(width);
    let mut text = row(&HEAD.map(str::to_owned), &widths).trim_end().to_owned() + "\n";
    let mut cells = cells.iter();
    for (_, lines) in rows {
        let _ = writeln!(text, "{}", "-".repeat(widths.iter().sum::<usize>() + 2 * 6));
        for (line, cells) in lines.iter().zip(&mut cells) {
            let verdict = line.verdict();
            let (front, last) = (&cells[..6], &cells[6]);
            let front: Vec<String> = front.to_vec();
            let _ = writeln!(
                text,
                "{}  {}",
                row(&front, &widths[..6]),
                paint.verdict(last, verdict)
            );
        }
    }
    let count = |verdict| lines.iter().filter(|line| line.verdict() == verdict).count();
    let _ = write!(
        text,
        "\n{} met, {} missed, {} reported only",
        count(Verdict::Met),
        count(Verdict::Missed),
        count(Verdict::Reported)
    );
    text
}

/// Returns the text of a line in each column.
pub(crate) fn cells(line: &Line) -> [String; 7] {
    let (name, theirs) = match &line.yardstick {
        None => (String::from("-"), String::from("-")),
        Some(yardstick) if yardstick.given => (
            format!("{} (given)", yardstick.name),
            yardstick.figure.to_string(),
        ),
        Some(yardstick) => (yardstick.name.clone(), yardstick.figure.to_string()),
    };
    [
        line.what.clone(),
        line.ours.to_string(),
        name,
        theirs,
        line.ratio()
            .map_or(String::from("-"), |ratio| format!("{ratio:.2}")),
        line.goal.to_string(),
        line.verdict().to_string(),
    ]
}

/// Aligns texts to the left and numbers to the right.
fn row(cells: &[String], widths: &[usize]) -> String {
    let aligned = cells
        .iter()
        .zip(widths)
        .enumerate()
        .map(|(column, (cell, width))| match column {
            1 | 3 | 4 => format!("{cell:>width$}"),
            _ => format!("{cell:<width$}"),
        });
    aligned.collect::<Vec<_>>().join("  ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Figure, Goal};

    #[test]
    fn a_figure_from_elsewhere_is_marked() {
        let lines = vec![
            Line::given(
                "a",
                Figure::Time(5.0),
                "theirs",
                Figure::Time(10.0),
                Goal::TimesFaster(1.0),
            ),
            Line::alone("longer", Figure::Count(3.0), Goal::Below(Figure::Count(0.0))),
        ];
        let expected = "\
what       ours  yardstick        theirs  ratio  goal       met
------------------------------------------------------------------
a       5.00 ns  theirs (given)  10.0 ns   0.50  faster     met
longer        3  -                     -      -  at most 0  MISSED

1 met, 1 missed, 0 reported only";
        assert_eq!(table(&[(String::from("row"), lines)], Paint(false)), expected);
    }
}
