//! The lines at the edges: the title, the robot, the status with the input, and the keys.

use std::time::Duration;

use jde_terminal::escape::escape;
use ratatui::Frame;
use ratatui::layout::{Alignment, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use crate::top::text;
use crate::top::view_state::{ActionResult, Mode, ViewState};

/// The key that stops everything, and the one that releases it.
const PANIC_KEYS: [(&str, &str); 2] = [("space", "STOP ALL"), ("g", "GO ON")];

/// After this time without a snapshot, the application is not shown as running.
const SILENT_AFTER: Duration = Duration::from_secs(1);

/// The keys and their effects; those that a new user needs first are at the left, after the panic key.
const KEYS: [(&str, &str); 9] = [
    ("q", "quit"),
    ("?", "help"),
    ("↑↓", "select"),
    ("p", "play"),
    ("s", "stop"),
    ("f", "force"),
    ("r", "release"),
    ("+ - t", "period"),
    ("[ ]", "time"),
];

/// Draws the title of the application, its time and how it runs or ended.
pub(super) fn title(frame: &mut Frame, area: Rect, screen: &ViewState) {
    let seconds = screen.snapshot.time as f64 / 1e9;
    let silent = screen.silent > SILENT_AFTER;
    let state = match (&screen.ending, screen.stopped_by()) {
        (Some(ending), _) => ending.word().to_owned(),
        (None, _) if silent => format!("NO NEWS for {} s", screen.silent.as_secs()),
        (None, Some(operator)) => format!("STOPPED by {operator}"),
        (None, None) if screen.snapshot.standstill.is_some() => "STANDS STILL".to_owned(),
        (None, None) => "running".to_owned(),
    };
    let clock = format!(" {state}  {seconds:.1} s ");
    let room = usize::from(area.width).saturating_sub(text::columns(&clock));
    let bar = format!("{}{clock}", text::pad_or_cut(&format!(" {}", screen.title), room));
    let mut style = screen.theme.selected();
    if silent || screen.stopped_by().is_some() {
        style = style.patch(screen.theme.bad());
    }
    frame.render_widget(Paragraph::new(Line::styled(bar, style)), area);
}

/// Draws the pose of the robot and its target.
pub(super) fn robot(frame: &mut Frame, area: Rect, screen: &ViewState) {
    let Some(robot) = screen.robot else { return };
    let (x, y, heading) = robot.pose;
    let mut line = format!("robot {x:.2}, {y:.2} m  {:.0}°", heading.to_degrees());
    if let Some((to_x, to_y)) = robot.target {
        let away = (to_x - x).hypot(to_y - y);
        line += &format!("  →  {to_x:.2}, {to_y:.2} m, {away:.2} m away");
    }
    if robot.total > 0 {
        line += &format!("  ·  {} of {} reached", robot.reached, robot.total);
    }
    frame.render_widget(Paragraph::new(line), area);
}

/// Draws the input in progress, the result of the last action, or that the application has ended.
pub(super) fn status(frame: &mut Frame, area: Rect, screen: &ViewState) {
    let status_text = match &screen.status {
        Some(ActionResult::Done(what)) => Span::raw(escape(what)),
        Some(ActionResult::Refused(reason)) => Span::styled(escape(reason), screen.theme.bad()),
        None => Span::raw(""),
    };
    let line = match (&screen.mode, &screen.ending) {
        (Mode::Period { schema, typed }, _) => Line::from(vec![
            Span::styled(
                format!("new period of {}: ", screen.name(*schema)),
                screen.theme.strong(),
            ),
            Span::raw(typed.clone()),
            Span::styled(" ", screen.theme.selected()),
            if status_text.content.is_empty() {
                Span::styled(
                    "  75ms, 0.5s or 20Hz; Enter sets it, Esc does not",
                    screen.theme.faint(),
                )
            } else {
                Span::styled(format!("  {}", status_text.content), status_text.style)
            },
        ]),
        (Mode::Watch | Mode::Help, Some(ending)) if screen.status.is_none() => Line::styled(
            format!(
                "{}: {}. Press Enter to leave.",
                ending.word(),
                escape(ending.reason())
            ),
            screen.theme.strong(),
        ),
        (Mode::Watch | Mode::Help, Some(_) | None) => match &screen.snapshot.standstill {
            Some(reason) if screen.ending.is_none() => Line::from(vec![
                Span::styled("stands still: ", screen.theme.strong()),
                Span::raw(reason.as_str()),
                Span::styled("  c continues, n makes a step", screen.theme.faint()),
            ]),
            _ => Line::from(status_text),
        },
    };
    frame.render_widget(Paragraph::new(line), area);
}

/// Draws as many keys as fit.
pub(super) fn keys(frame: &mut Frame, area: Rect, screen: &ViewState) {
    let mut line = Line::default().alignment(Alignment::Left);
    let panic_key = PANIC_KEYS[usize::from(screen.stopped_by().is_some())];
    for (key, what) in std::iter::once(panic_key).chain(KEYS) {
        let width = text::columns(key) + 1 + text::columns(what);
        if line.width() + width > usize::from(area.width) {
            break;
        }
        line.push_span(Span::styled(key, screen.theme.strong()));
        line.push_span(Span::styled(format!(" {what}  "), screen.theme.faint()));
    }
    frame.render_widget(Paragraph::new(line), area);
}
