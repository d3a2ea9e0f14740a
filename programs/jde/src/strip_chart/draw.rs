//! Draws the traces of a strip chart as lines of dots over time, with the names and newest numbers above and
//! the keys below.

use std::env;

use jde_terminal::escape::escape;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Chart, Dataset, GraphType, Paragraph};

use super::traces::Traces;

/// Colours of the terminal's theme that are easy to distinguish.
const COLORS: [Color; 6] = [
    Color::Cyan,
    Color::Yellow,
    Color::Green,
    Color::Magenta,
    Color::Red,
    Color::Blue,
];
/// Kinds of dots, so that traces also differ without colours.
const MARKERS: [Marker; 3] = [Marker::Braille, Marker::Dot, Marker::Block];

pub(super) fn draw(frame: &mut Frame<'_>, traces: &Traces, title: &str, window: f64, status: Option<&str>) {
    let [head, picture, foot] = Layout::vertical([
        Constraint::Length(1 + traces.names.len() as u16),
        Constraint::Min(3),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    let plain = env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let style = |trace: usize| {
        if plain {
            Style::new()
        } else {
            Style::new().fg(COLORS[trace % COLORS.len()])
        }
    };
    let marker = |trace: usize| {
        if plain {
            MARKERS[trace % MARKERS.len()]
        } else {
            Marker::Braille
        }
    };

    let mut lines = vec![Line::from(Span::styled(
        escape(title),
        Style::new().add_modifier(Modifier::BOLD),
    ))];
    for (trace, name) in traces.names.iter().enumerate() {
        let newest = traces.newest(trace).map_or("-".to_owned(), number);
        lines.push(Line::from(vec![
            Span::styled("━ ", style(trace)),
            Span::raw(format!("{}  ", escape(name))),
            Span::styled(newest, Style::new().add_modifier(Modifier::BOLD)),
        ]));
    }
    frame.render_widget(Paragraph::new(lines), head);

    let pieces: Vec<_> = (0..traces.names.len())
        .flat_map(|trace| {
            traces
                .pieces(trace, window)
                .into_iter()
                .map(move |piece| (trace, piece))
        })
        .collect();
    let sets = pieces
        .iter()
        .map(|(trace, piece)| {
            Dataset::default()
                .marker(marker(*trace))
                .graph_type(GraphType::Line)
                .style(style(*trace))
                .data(piece)
        })
        .collect();
    let (least, greatest) = traces.range(window);
    let faint = Style::new().add_modifier(Modifier::DIM);
    let chart = Chart::new(sets)
        .x_axis(
            Axis::default()
                .style(faint)
                .bounds([-window, 0.0])
                .labels([format!("-{} s", number(window)), format!("{:.1} s", traces.end())]),
        )
        .y_axis(Axis::default().style(faint).bounds([least, greatest]).labels([
            number(least),
            number(f64::midpoint(least, greatest)),
            number(greatest),
        ]));
    frame.render_widget(chart, picture);

    let keys = match (status, traces.is_paused()) {
        (Some(status), _) => escape(status),
        (None, true) => "paused   space continue   [ ] time   c clear   q quit".to_owned(),
        (None, false) => "space pause   [ ] time   c clear   q quit".to_owned(),
    };
    frame.render_widget(Paragraph::new(Span::styled(keys, faint)), foot);
}

/// Returns a number with the digits that matter.
fn number(value: f64) -> String {
    let digits = match value.abs() {
        size if size >= 1000.0 => 0,
        size if size >= 10.0 => 1,
        size if size >= 0.1 => 3,
        _ => 4,
    };
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    use super::*;
    use crate::strip_chart::TracePoint;

    #[test]
    fn a_chart_has_names_newest_numbers_axes_and_keys() {
        let mut traces = Traces::new(vec!["goon.speed [m/s]".to_owned()]);
        for step in 0..100 {
            traces.add(TracePoint {
                trace: 0,
                time: f64::from(step) * 0.1,
                value: f64::from(step),
            });
        }
        let mut terminal = Terminal::new(TestBackend::new(60, 16)).unwrap();
        terminal
            .draw(|frame| draw(frame, &traces, "safe-navigation", 10.0, None))
            .unwrap();
        let screen = terminal.backend().to_string();
        for part in [
            "safe-navigation",
            "goon.speed [m/s]  99",
            "-10 s",
            "9.9 s",
            "104",
            "space pause",
        ] {
            assert!(screen.contains(part), "{part} in\n{screen}");
        }
    }

    #[test]
    fn numbers_have_no_more_digits_than_needed() {
        assert_eq!(
            [0.25, 12.0, 12.34, 0.001, 12345.6, -3.0].map(number),
            ["0.25", "12", "12.3", "0.001", "12346", "-3"]
        );
    }
}
