//! Bands of states. Each schema has a row whose height shows its state, in the schema's colour while it is
//! WINNER. Above the members of a group is a row for the group, in the colour of its winner, with a mark at
//! every switch.
//!
//! A state that lasted for part of a column is drawn fainter, but never invisible.

use jde_core::State;
use jde_drawing::map::Palette;
use jde_drawing::text::{counted, percent};
use jde_drawing::{Align, ColorRole, Drawing, DrawnShape, Fill};
use jde_timeline::{HierarchyRow, Item};

use super::{Area, SMALL, TEXT};
use crate::analysis::Analysis;

/// Width of the names on the left, and of the numbers on the right, units.
pub(crate) const NAMES: f32 = 200.0;
pub(crate) const NUMBERS: f32 = 110.0;
/// Height of a row, units: the easily readable maximum, and the visible minimum.
const MAX_ROW_HEIGHT: f32 = 30.0;
const MIN_ROW_HEIGHT: f32 = 5.0;
/// Rows lower than this have no names.
const MIN_NAMED_HEIGHT: f32 = 13.0;
/// Indentation of a child's name, units.
const CHILD_INDENT: f32 = 12.0;
/// Heights of the states, as shares of a row.
const WINNER_HEIGHT: f32 = 0.78;
const READY_HEIGHT: f32 = 0.48;
const CHECKING_HEIGHT: f32 = 0.16;
/// The number of shades for parts of a column, and the faintest.
const SHADE_COUNT: f32 = 8.0;
const FAINTEST_SHADE: f32 = 0.375;

/// The rows that fit the available height.
pub(crate) struct Bands<'t> {
    analysis: &'t Analysis,
    rows: Vec<HierarchyRow>,
    /// Rows without room.
    pub(crate) left_out: usize,
    row: f32,
}

impl<'t> Bands<'t> {
    /// The rows of an analysis within this height; none if there are no schemas.
    pub(crate) fn new(analysis: &'t Analysis, max_height: f32) -> Self {
        let mut rows = analysis.rows();
        let capacity = (max_height / MIN_ROW_HEIGHT) as usize;
        let all = rows.len();
        if all > capacity {
            // Schemas that never were awake are dropped first.
            rows.retain(|row| {
                row.schema()
                    .is_none_or(|schema| analysis.bands[schema].was_awake())
            });
            rows.truncate(capacity);
        }
        Self {
            analysis,
            left_out: all - rows.len(),
            row: (max_height / rows.len().max(1) as f32).clamp(MIN_ROW_HEIGHT, MAX_ROW_HEIGHT),
            rows,
        }
    }

    /// Height of all rows, units.
    pub(crate) fn height(&self) -> f32 {
        self.rows.len() as f32 * self.row
    }

    /// Draws the rows from the top of an area, with the width of the time axis. Names are on its left.
    pub(crate) fn draw(&self, drawing: &mut Drawing, area: Area, palette: &Palette) {
        for (place, row) in self.rows.iter().enumerate() {
            let row_area = Area {
                top: area.top + place as f32 * self.row,
                height: self.row,
                ..area
            };
            drawing.note(Some(self.tooltip(*row)));
            match row.item {
                Item::Group(group) => self.group(drawing, row_area, group, row.depth, palette),
                Item::Schema(schema, _) => self.schema(drawing, row_area, schema, row.depth, palette),
                Item::Others => {}
            }
        }
        drawing.note(None);
    }

    /// The tooltip of a row.
    fn tooltip(&self, row: HierarchyRow) -> String {
        let analysis = self.analysis;
        match row.item {
            Item::Others => String::new(),
            Item::Group(group) => {
                let (about, statistics) = (&analysis.hierarchy().groups()[group], &analysis.groups[group]);
                format!("{}: {}", about.name, counted(statistics.switches, "switch"))
            }
            Item::Schema(schema, _) => {
                let band = &analysis.bands[schema];
                let times = [
                    ("WINNER", State::Winner),
                    ("READY", State::Ready),
                    ("CHECKING", State::Checking),
                ];
                let times = times.map(|(name, state)| {
                    let time = super::seconds(band.time(state) as f64 / 1e9);
                    format!("{name} {time}")
                });
                format!(
                    "{}: {}",
                    analysis.hierarchy().schemas()[schema].name,
                    times.join(", ")
                )
            }
        }
    }

    fn schema(&self, drawing: &mut Drawing, area: Area, schema: usize, depth: usize, palette: &Palette) {
        let (name, band) = (
            &self.analysis.hierarchy().schemas()[schema].name,
            &self.analysis.bands[schema],
        );
        let acts = self.analysis.hierarchy().is_actor(schema);
        let color = if acts {
            palette.tone(Some(schema))
        } else {
            ColorRole::Edge
        };
        let layers = [
            (State::Checking, CHECKING_HEIGHT, ColorRole::Edge.faded(0.7)),
            (State::Ready, READY_HEIGHT, color.faded(0.5)),
            (State::Winner, WINNER_HEIGHT, color.faded(1.0)),
        ];
        for (state, height, ink) in layers {
            layer(drawing, area, band.shares(state), height, ink);
        }
        self.name(drawing, area, name, depth, ColorRole::Ink);
        let total = self.analysis.columns.to - self.analysis.columns.from;
        let share = band.time(State::Winner) as f64 / total as f64;
        if band.was_awake() {
            self.number(drawing, area, &percent(share));
        }
    }

    fn group(&self, drawing: &mut Drawing, area: Area, group: usize, depth: usize, palette: &Palette) {
        let (about, statistics) = (
            &self.analysis.hierarchy().groups()[group],
            &self.analysis.groups[group],
        );
        let column_width = area.width / self.analysis.columns.count as f32;
        let (top, height) = (area.top + area.height * 0.62, area.height * 0.2);
        for member in &about.members {
            let ink = match self.analysis.hierarchy().is_actor(*member) {
                true => palette.tone(Some(*member)).faded(1.0),
                false => ColorRole::Edge.faded(1.0),
            };
            for (from, to, shade) in runs(self.analysis.bands[*member].shares(State::Winner)) {
                let bar = DrawnShape::bar(
                    area.left + from as f32 * column_width,
                    top,
                    (to - from) as f32 * column_width,
                    height,
                );
                if let Some(bar) = bar {
                    drawing.fill(bar, ink.tone.faded(shade));
                }
            }
        }
        // Wide enough to be visible, centred on its column.
        let mark = column_width.max(1.4);
        for (column, _) in statistics
            .marks
            .iter()
            .enumerate()
            .filter(|(_, count)| **count > 0)
        {
            let middle = area.left + (column as f32 + 0.5) * column_width;
            let left = (middle - mark / 2.0).clamp(area.left, area.right() - mark);
            drawing.bar(
                (left, area.top + area.height * 0.22),
                mark,
                area.height * 0.6,
                ColorRole::Ink,
            );
        }
        self.name(drawing, area, &about.name, depth, ColorRole::Soft);
        self.number(drawing, area, &counted(statistics.switches, "switch"));
    }

    fn name(&self, drawing: &mut Drawing, area: Area, name: &str, depth: usize, tone: ColorRole) {
        if self.row < MIN_NAMED_HEIGHT {
            return;
        }
        let indent = CHILD_INDENT * depth.min(6) as f32;
        let size = TEXT.min(self.row * 0.75);
        let left = area.left - NAMES + indent;
        // A page may show the same text in a wider typeface.
        let text = drawing.fitted(name, size, (NAMES - indent - 10.0) * 0.9);
        drawing.label(&text, size, (left, area.top + self.row * 0.58), Align::Left, tone);
    }

    fn number(&self, drawing: &mut Drawing, area: Area, text: &str) {
        if self.row >= MIN_NAMED_HEIGHT {
            let at = (area.right() + NUMBERS - 4.0, area.top + self.row * 0.58);
            drawing.label(text, SMALL.min(self.row * 0.7), at, Align::Right, ColorRole::Soft);
        }
    }
}

/// Draws the bars of one state, from the bottom of the row to the state's height.
fn layer(drawing: &mut Drawing, area: Area, shares: impl Iterator<Item = f32>, height: f32, ink: Fill) {
    let shares: Vec<f32> = shares.collect();
    let column_width = area.width / shares.len().max(1) as f32;
    let bar_height = area.height * height;
    let top = area.top + area.height * 0.9 - bar_height;
    let mut runs: Vec<_> = runs(shares.into_iter()).collect();
    // Sorted by shade, since bars of one colour are drawn together.
    runs.sort_by(|a, b| a.2.total_cmp(&b.2));
    for (from, to, shade) in runs {
        let faded = ink.tone.faded(shade * ink.opacity);
        drawing.bar(
            (area.left + from as f32 * column_width, top),
            (to - from) as f32 * column_width,
            bar_height,
            faded,
        );
    }
}

/// Runs of columns of the same shade: first column, end (exclusive) and shade.
fn runs(shares: impl Iterator<Item = f32>) -> impl Iterator<Item = (usize, usize, f32)> {
    let mut shades = shares.map(shade).enumerate().peekable();
    std::iter::from_fn(move || {
        loop {
            let (from, shade) = shades.next()?;
            let mut to = from + 1;
            while shades.next_if(|(_, next)| *next == shade).is_some() {
                to += 1;
            }
            if shade > 0.0 {
                return Some((from, to, shade));
            }
        }
    })
}

fn shade(share: f32) -> f32 {
    // Smaller shares are rounding errors.
    if share < 1e-5 {
        0.0
    } else {
        ((share - 1e-4) * SHADE_COUNT)
            .ceil()
            .max(SHADE_COUNT * FAINTEST_SHADE)
            / SHADE_COUNT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_one_shade_are_one_bar_and_short_states_are_visible() {
        let shares = [0.0, 1.0, 1.0, 0.999_99, 0.01, 0.0, 0.5];
        let runs: Vec<_> = runs(shares.into_iter()).collect();
        assert_eq!(runs, [(1, 4, 1.0), (4, 5, FAINTEST_SHADE), (6, 7, 0.5)]);
    }
}
