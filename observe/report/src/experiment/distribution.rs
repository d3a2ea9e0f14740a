//! Histograms of measures: a row for each combination of axes, above one axis for all of them.

use jde_drawing::text::counted;
use jde_drawing::{Align, ColorRole, Drawing, Font, LineStyle};
use maud::{Markup, PreEscaped, html};

use super::{Distribution, DistributionRow};
use crate::chart::{SMALL, axis_numbers};

/// Width of a drawing, units: half of a wide page, so that its texts are readable on a narrow one.
const DRAWING_WIDTH: f32 = 560.0;
/// Margin on either side, for half a number of the axis, units.
const SIDE_MARGIN: f32 = 24.0;
/// Heights of a row's name, of its bars, and of its median's interval with the gap below, units.
const NAME_HEIGHT: f32 = 22.0;
const BARS_HEIGHT: f32 = 52.0;
const INTERVAL_HEIGHT: f32 = 18.0;
/// Height of the axis, units.
const AXIS_HEIGHT: f32 = 26.0;
/// Bars of a histogram, at most.
const MAX_BINS: usize = 40;
/// Most rows of a drawing; the table has the others.
const MAX_ROWS: usize = 12;

/// The axis of a measure.
struct Scale {
    least: f64,
    greatest: f64,
    bins: usize,
}

pub(super) fn distributions(all: &[Distribution]) -> Option<Markup> {
    let drawn: Vec<_> = all
        .iter()
        .enumerate()
        .filter_map(|(number, distribution)| Some((number, distribution, Scale::of(distribution)?)))
        .collect();
    if drawn.is_empty() {
        return None;
    }
    Some(html! {
        p.note {
            "How many drives have each value: " i.sign style={ "background:var(" (ColorRole::Of(0)) ")" } {} "passed "
            i.sign style={ "background:var(" (ColorRole::Bad) ")" } {} "not passed. "
            "The upright line is the median of all, and the line below is its interval."
        }
        div.charts {
            @for (number, distribution, scale) in &drawn {
                figure {
                    figcaption {
                        (distribution.measure)
                        @if !distribution.unit.is_empty() { " " small { (distribution.unit) } }
                    }
                    @let label = format!("How the values of {} are distributed", distribution.measure);
                    (PreEscaped(draw(distribution, scale).svg(&label, &format!("d{number}-"))))
                    @if distribution.rows.len() > MAX_ROWS {
                        p.note { (counted((distribution.rows.len() - MAX_ROWS) as u64, "more row")) " in the table above." }
                    }
                }
            }
        }
    })
}

fn draw(distribution: &Distribution, scale: &Scale) -> Drawing {
    let rows = &distribution.rows[..distribution.rows.len().min(MAX_ROWS)];
    let row_height = NAME_HEIGHT + BARS_HEIGHT + INTERVAL_HEIGHT;
    let bottom = row_height * rows.len() as f32;
    let mut drawing = Drawing::new(DRAWING_WIDTH, bottom + AXIS_HEIGHT);
    // Numbers of an axis along a line need about twice the room of those of an upright one.
    for (value, text) in axis_numbers(
        scale.least,
        scale.greatest,
        (DRAWING_WIDTH - 2.0 * SIDE_MARGIN) / 2.0,
    ) {
        let x = scale.at(value).floor() + 0.5;
        drawing.polyline(
            &[(x, NAME_HEIGHT), (x, bottom)],
            LineStyle::new(ColorRole::Grid, 1.0),
        );
        drawing.label(
            &text,
            SMALL,
            (x, bottom + AXIS_HEIGHT / 2.0),
            Align::Middle,
            ColorRole::Soft,
        );
    }
    for (number, row) in rows.iter().enumerate() {
        draw_row(&mut drawing, row, scale, number as f32 * row_height);
    }
    drawing
}

fn draw_row(drawing: &mut Drawing, row: &DistributionRow, scale: &Scale, top: f32) {
    let total = row.passed.len() + row.others.len();
    let count = counted(total as u64, "drive");
    let font = Font::default();
    let room = DRAWING_WIDTH - 2.0 * SIDE_MARGIN - font.width(&count, SMALL) - 12.0;
    let (middle, baseline) = (top + NAME_HEIGHT / 2.0, top + NAME_HEIGHT + BARS_HEIGHT);
    let name = font.fitted(&row.name, SMALL, room);
    drawing.note((name != row.name).then(|| row.name.clone()));
    drawing.label(&name, SMALL, (SIDE_MARGIN, middle), Align::Left, ColorRole::Ink);
    drawing.note(None);
    let right = DRAWING_WIDTH - SIDE_MARGIN;
    drawing.label(&count, SMALL, (right, middle), Align::Right, ColorRole::Soft);
    bars(drawing, row, scale, baseline);
    drawing.polyline(
        &[(SIDE_MARGIN, baseline), (right, baseline)],
        LineStyle::new(ColorRole::Edge, 1.0),
    );
    if let Some([median, low, high]) = row.median {
        let y = baseline + INTERVAL_HEIGHT / 2.0 - 2.0;
        let line = LineStyle::new(ColorRole::Ink, 3.0);
        drawing.polyline(&[(scale.at(low), y), (scale.at(high), y)], line);
        let x = scale.at(median);
        for line in [
            LineStyle::new(ColorRole::Paper, 4.0),
            LineStyle::new(ColorRole::Ink, 2.0),
        ] {
            drawing.polyline(&[(x, baseline - BARS_HEIGHT), (x, y + 4.0)], line);
        }
    }
}

/// Draws the bars: drives that passed on top of the others.
fn bars(drawing: &mut Drawing, row: &DistributionRow, scale: &Scale, baseline: f32) {
    let [passed, others] = [&row.passed, &row.others].map(|values| scale.count(values));
    let sums = passed.iter().zip(&others).map(|(passed, others)| passed + others);
    let most = sums.max().unwrap_or(0).max(1) as f32;
    let width = (DRAWING_WIDTH - 2.0 * SIDE_MARGIN) / scale.bins as f32;
    let height = |count: usize| BARS_HEIGHT * count as f32 / most;
    let mut draw = |counts: &[usize], below: &dyn Fn(usize) -> usize, tone: ColorRole| {
        for (bin, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let left = SIDE_MARGIN + bin as f32 * width;
            let top = baseline - height(below(bin) + count);
            drawing.bar((left + 0.5, top), width - 1.0, height(*count), tone);
        }
    };
    draw(&others, &|_| 0, ColorRole::Bad);
    draw(&passed, &|bin| others[bin], ColorRole::Of(0));
}

impl Scale {
    /// The axis of all rows; `None` without values.
    fn of(distribution: &Distribution) -> Option<Self> {
        let rows = distribution.rows.iter();
        let values = || {
            let all = rows.clone().flat_map(|row| row.passed.iter().chain(&row.others));
            all.copied().filter(|value| value.is_finite())
        };
        let least = values().reduce(f64::min)?;
        let greatest = values().reduce(f64::max)?;
        // A bar for each number, if they are few and whole.
        if greatest - least < MAX_BINS as f64 && values().all(|value| value.fract() == 0.0) {
            return Some(Self {
                least: least - 0.5,
                greatest: greatest + 0.5,
                bins: (greatest - least) as usize + 1,
            });
        }
        let room = if least < greatest {
            0.0
        } else {
            (least.abs() * 0.1).max(1e-9)
        };
        let (least, greatest) = (least - room, greatest + room);
        // The numbers at both ends of the range of floats have no finite distance.
        (greatest - least).is_finite().then_some(Self {
            least,
            greatest,
            bins: MAX_BINS,
        })
    }

    fn share(&self, value: f64) -> f64 {
        (value - self.least) / (self.greatest - self.least)
    }

    fn at(&self, value: f64) -> f32 {
        SIDE_MARGIN + (DRAWING_WIDTH - 2.0 * SIDE_MARGIN) * self.share(value) as f32
    }

    fn count(&self, values: &[f64]) -> Vec<usize> {
        let mut counts = vec![0; self.bins];
        for value in values.iter().filter(|value| value.is_finite()) {
            let bin = self.share(*value) * self.bins as f64;
            counts[(bin as usize).min(self.bins - 1)] += 1;
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_a_bar() {
        for values in [
            &[3.0; 5][..],
            &[1e9, 1e9 + 1.0],
            &[-0.5, 0.25, 1e-9],
            &[0.0, 1e300],
            &[0.0, f64::NAN],
        ] {
            let distribution = Distribution {
                rows: vec![DistributionRow {
                    passed: values.to_vec(),
                    ..DistributionRow::default()
                }],
                ..Distribution::default()
            };
            let scale = Scale::of(&distribution).unwrap();
            let finite = values.iter().filter(|value| value.is_finite());
            let counted: usize = scale.count(values).iter().sum();
            assert_eq!(counted, finite.clone().count(), "{values:?}");
            for value in finite {
                let x = scale.at(*value);
                assert!(
                    (SIDE_MARGIN..=DRAWING_WIDTH - SIDE_MARGIN).contains(&x),
                    "{value}: {x}"
                );
            }
        }
    }

    #[test]
    fn few_whole_numbers_have_a_bar_each() {
        let distribution = Distribution {
            rows: vec![DistributionRow {
                passed: vec![0.0, 2.0],
                others: vec![3.0, 3.0],
                ..DistributionRow::default()
            }],
            ..Distribution::default()
        };
        let scale = Scale::of(&distribution).unwrap();
        assert_eq!(scale.count(&[0.0, 2.0, 3.0, 3.0]), [1, 0, 1, 2]);
    }
}
