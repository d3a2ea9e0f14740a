//! Curves of a panel over an axis. Dense points are thinned per column of the screen, so that no peak is
//! lost.

use eframe::egui::{self, RichText, Ui, WidgetInfo};
use egui_plot::{Legend, Line, Plot, PlotPoints};
use jde_panel::{Ink, Trace};

use crate::style::{self, Style};

/// Shows the curves.
pub(super) fn show(
    style: &Style,
    ui: &mut Ui,
    height: f32,
    id: &str,
    label: &str,
    [across, up]: [&str; 2],
    traces: &[Trace],
) {
    let top = ui.cursor().top();
    ui.label(
        RichText::new(label)
            .color(style::color_of(Ink::Plain, style))
            .strong(),
    );
    let width = ui.available_width();
    let height = height - (ui.cursor().top() - top);
    let mut plot = Plot::new(id)
        .height(height)
        .width(width)
        .x_axis_label(across)
        .y_axis_label(up)
        // The wheel zooms. Otherwise it would also scroll the surrounding area.
        .allow_scroll(false);
    if traces.len() > 1 {
        plot = plot.legend(Legend::default());
    }
    let lines: Vec<_> = traces
        .iter()
        .map(|trace| {
            let points = thinned(&trace.points, width.max(16.0) as usize);
            Line::new(trace.name.clone(), PlotPoints::from(points))
                .color(style::exact(trace.color, style))
                .width(1.5)
        })
        .collect();
    let shown = plot.show(ui, |plot| lines.into_iter().for_each(|line| plot.line(line)));
    shown
        .response
        .widget_info(|| WidgetInfo::labeled(egui::Role::Canvas, true, format!("plot of {label}")));
}

/// The lowest and highest point of each column, if the points are sorted by x and there are many; otherwise
/// all points.
fn thinned(points: &[[f64; 2]], columns: usize) -> Vec<[f64; 2]> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    if points.len() <= 4 * columns || !points.is_sorted_by(|a, b| a[0] <= b[0]) {
        return points.to_vec();
    }
    let width = (last[0] - first[0]) / columns as f64;
    points
        .chunk_by(|a, b| ((a[0] - first[0]) / width).floor() == ((b[0] - first[0]) / width).floor())
        .flat_map(|column| {
            let least = column.iter().min_by(|a, b| a[1].total_cmp(&b[1]));
            let greatest = column.iter().max_by(|a, b| a[1].total_cmp(&b[1]));
            let mut ends: Vec<_> = least.into_iter().chain(greatest).copied().collect();
            ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
            ends
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinned_points_keep_every_peak() {
        let mut points: Vec<_> = (0..100_000).map(|x| [f64::from(x), 0.0]).collect();
        points[54_321][1] = 9.0;
        points[77_777][1] = -3.0;
        let thinned_points = thinned(&points, 200);
        assert!(thinned_points.len() <= 402, "{}", thinned_points.len());
        assert!(thinned_points.contains(&[54_321.0, 9.0]) && thinned_points.contains(&[77_777.0, -3.0]));
        assert!(thinned_points.is_sorted_by(|a, b| a[0] <= b[0]));
    }

    #[test]
    fn a_curve_that_turns_back_is_not_thinned() {
        let circle: Vec<_> = (0..5000)
            .map(|n| f64::from(n) * 0.01)
            .map(|a| [a.cos(), a.sin()])
            .collect();
        assert_eq!(thinned(&circle, 10), circle);
    }
}
