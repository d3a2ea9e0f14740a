//! Numbers over time as lines. Each column shows its least and greatest value, so that no extreme is lost. A
//! value holds until the next; where there is none, there is no line.

use jde_drawing::{Align, ColorRole, Drawing, DrawnShape, LineStyle, Point};
use std::collections::BTreeMap;

use super::axis::{self, numbers};
use super::{Area, SMALL, TEXT};
use crate::analysis::{ColumnRange, Columns, Series, Trace};

/// Height of the legend above a chart, and distance between two charts, units.
const LEGEND_HEIGHT: f32 = 26.0;
const CHART_GAP: f32 = 16.0;
/// Width of a legend entry without its name, units.
const LEGEND_SIGN_WIDTH: f32 = 36.0;

/// Draws one chart per unit, one above the other.
pub(crate) fn charts(drawing: &mut Drawing, area: Area, columns: Columns, traces: &[(Series, Trace)]) {
    let mut units: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (number, (series, _)) in traces.iter().enumerate() {
        units.entry(&series.unit).or_default().push(number);
    }
    // In the order of the request.
    let mut units: Vec<_> = units.into_iter().collect();
    units.sort_by_key(|(_, numbers)| numbers[0]);
    let height = area.height / units.len().max(1) as f32;
    for (place, (unit, numbers)) in units.into_iter().enumerate() {
        let part = Area {
            top: area.top + place as f32 * height,
            height: height - CHART_GAP,
            ..area
        };
        chart(drawing, part, columns, traces, &numbers, unit);
    }
}

fn chart(
    drawing: &mut Drawing,
    area: Area,
    columns: Columns,
    traces: &[(Series, Trace)],
    numbers_of: &[usize],
    unit: &str,
) {
    let legend = legend(drawing, area, traces, numbers_of, unit);
    let area = Area {
        top: area.top + legend,
        height: (area.height - legend).max(20.0),
        ..area
    };
    let ranges = numbers_of.iter().filter_map(|number| traces[*number].1.range());
    let range = ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let (least, greatest) = with_margin(range.unwrap_or((0.0, 1.0)));
    axis::time_grid(drawing, area, columns);
    for (value, text) in numbers(least, greatest, area.height) {
        let y = at(area, least, greatest, value).floor() + 0.5;
        let line = LineStyle::new(ColorRole::Grid, 1.0);
        drawing.polyline(&[(area.left, y), (area.right(), y)], line);
        drawing.label(&text, SMALL, (area.left - 8.0, y), Align::Right, ColorRole::Soft);
    }
    frame(drawing, area);
    for number in numbers_of {
        let style = LineStyle::new(ColorRole::Of(*number), 1.8);
        line(drawing, area, traces[*number].1.cells(), (least, greatest), style);
    }
    if range.is_none() {
        let middle = (area.left + area.width / 2.0, area.top + area.height / 2.0);
        drawing.label(
            "no value in this time",
            TEXT,
            middle,
            Align::Middle,
            ColorRole::Soft,
        );
    }
}

/// Draws the legend of a chart in as many rows as it needs; returns its height.
fn legend(
    drawing: &mut Drawing,
    area: Area,
    traces: &[(Series, Trace)],
    numbers_of: &[usize],
    unit: &str,
) -> f32 {
    let (mut x, mut y) = (area.left, area.top + LEGEND_HEIGHT / 2.0);
    for number in numbers_of {
        let (series, trace) = &traces[*number];
        let name = match unit {
            "" => series.name.clone(),
            unit => format!("{} [{unit}]", series.name),
        };
        let name = drawing.fitted(&name, TEXT, area.width - LEGEND_SIGN_WIDTH);
        let range = trace.range().map_or(String::new(), |(least, greatest)| {
            format!("  {} to {}", axis::number(least), axis::number(greatest))
        });
        let text = format!("{name}{range}");
        let width = LEGEND_SIGN_WIDTH + drawing.width(&text, TEXT) + 20.0;
        if x > area.left && x + width > area.right() {
            (x, y) = (area.left, y + LEGEND_HEIGHT);
        }
        let sign = LineStyle::new(ColorRole::Of(*number), 4.0);
        drawing.polyline(&[(x, y), (x + LEGEND_SIGN_WIDTH - 12.0, y)], sign);
        drawing.label(
            &text,
            TEXT,
            (x + LEGEND_SIGN_WIDTH - 4.0, y),
            Align::Left,
            ColorRole::Ink,
        );
        x += width;
    }
    y - area.top + LEGEND_HEIGHT / 2.0 + 2.0
}

/// Draws a small chart without text: a line within a range, and a horizontal line at the nominal value.
pub(crate) fn small_chart(
    drawing: &mut Drawing,
    area: Area,
    trace: &Trace,
    range: (f64, f64),
    nominal: Option<f64>,
    style: LineStyle,
) {
    frame(drawing, area);
    let (least, greatest) = range;
    if let Some(nominal) = nominal.filter(|nominal| (least..=greatest).contains(nominal)) {
        let y = at(area, least, greatest, nominal);
        let nominal_line = LineStyle::new(ColorRole::Soft, 1.0).dashed(4.0, 3.0);
        drawing.polyline(&[(area.left, y), (area.right(), y)], nominal_line);
    }
    line(drawing, area, trace.cells(), range, style);
}

fn frame(drawing: &mut Drawing, area: Area) {
    if let Some(edge) = DrawnShape::bar(area.left, area.top, area.width, area.height) {
        drawing.stroke(edge, LineStyle::new(ColorRole::Edge, 1.0));
    }
}

fn line(
    drawing: &mut Drawing,
    area: Area,
    cells: &[Option<ColumnRange>],
    (least, greatest): (f64, f64),
    style: LineStyle,
) {
    let column_width = area.width / cells.len().max(1) as f32;
    let y = |value: f64| at(area, least, greatest, value);
    let mut points: Vec<Point> = Vec::new();
    for (column, cell) in cells.iter().enumerate() {
        let left = area.left + column as f32 * column_width;
        let Some(cell) = cell else {
            drawing.polyline(&std::mem::take(&mut points), style);
            continue;
        };
        let middle = left + column_width / 2.0;
        add(&mut points, (left, y(cell.first)));
        if cell.least < cell.greatest {
            // The farther extreme first, so that the line is as short as possible.
            let order = if cell.last >= cell.first {
                [cell.least, cell.greatest]
            } else {
                [cell.greatest, cell.least]
            };
            order
                .into_iter()
                .for_each(|value| add(&mut points, (middle, y(value))));
        }
        add(&mut points, (left + column_width, y(cell.last)));
    }
    drawing.polyline(&points, style);
}

/// Adds a point. On a level stretch, the end of the line moves instead.
fn add(points: &mut Vec<Point>, point: Point) {
    if let [.., before, last] = points.as_mut_slice()
        && before.1 == last.1
        && last.1 == point.1
    {
        *last = point;
    } else {
        points.push(point);
    }
}

fn at(area: Area, least: f64, greatest: f64, value: f64) -> f32 {
    let share = ((value - least) / (greatest - least)).clamp(-0.02, 1.02);
    area.bottom() - area.height * share as f32
}

/// The range of a chart with a margin, also for a constant.
fn with_margin((least, greatest): (f64, f64)) -> (f64, f64) {
    let size = greatest.abs().max(least.abs());
    let range = greatest - least;
    let margin = if range > size * 1e-6 {
        range * 0.06
    } else if size > 0.0 {
        size * 0.2
    } else {
        1.0
    };
    (least - margin, greatest + margin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_line_has_two_points_and_a_range_has_a_margin() {
        let mut points = Vec::new();
        for x in [0.0, 1.0, 2.0, 3.0] {
            add(&mut points, (x, 5.0));
        }
        add(&mut points, (3.0, 7.0));
        assert_eq!(points, [(0.0, 5.0), (3.0, 5.0), (3.0, 7.0)]);
        assert_eq!(with_margin((5.0, 5.0)), (4.0, 6.0));
        assert_eq!(with_margin((0.0, 0.0)), (-1.0, 1.0));
    }
}
