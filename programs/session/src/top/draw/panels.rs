//! The panels below the list: the details of the selected schema, the latest switches with their reasons, and
//! the log.

use jde_abi::describe::Kind;
use jde_core::{Health, State};
use jde_records::DecidedBy;
use jde_records::snapshot::SchemaView;
use jde_timeline::{Switch, health_text, state_word};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::columns;
use crate::top::view_state::ViewState;
use crate::top::{strip, text};
use jde_drawing::text::counted;

/// Most lines of details: a long reason of a fault is cut rather than the list.
const DETAIL_LINES: usize = 3;

/// Returns the rows that the details of the selected schema need, including their rule.
pub(super) fn details_height(screen: &ViewState, width: u16) -> u16 {
    screen.selection().map_or(0, |schema| {
        1 + wrap_spans(detail_spans(screen, schema), usize::from(width)).len() as u16
    })
}

/// Draws the details of the selected schema.
pub(super) fn details(frame: &mut Frame, area: Rect, screen: &ViewState) {
    let Some(schema) = screen.selection() else { return };
    let title = format!("{} · {}, {}", schema.name, schema.type_name, schema.kind);
    let lines = wrap_spans(detail_spans(screen, schema), usize::from(area.width));
    panel(frame, area, screen, &title, lines);
}

/// Draws the latest changes of winner, newest first.
pub(super) fn switches(frame: &mut Frame, area: Rect, screen: &ViewState) {
    let width = usize::from(area.width);
    let mut lines: Vec<Line> = screen
        .timeline
        .newest_switches(strip::MAX_SWITCHES)
        .into_iter()
        .map(|(group, switch)| switch_line(screen, group, switch, width))
        .collect();
    if lines.is_empty() {
        lines.push(Line::styled("none yet", screen.theme.faint()));
    }
    panel(frame, area, screen, "switches", lines);
}

/// Draws the latest lines of the log, newest last.
pub(super) fn log(frame: &mut Frame, area: Rect, screen: &ViewState) {
    let room = usize::from(area.height.saturating_sub(1));
    let mut lines: Vec<Line> = screen
        .log
        .iter()
        .skip(screen.log.len().saturating_sub(room))
        .map(|line| Line::raw(text::cut(line, usize::from(area.width))))
        .collect();
    if lines.is_empty() {
        lines.push(Line::styled("empty", screen.theme.faint()));
    }
    panel(frame, area, screen, "log", lines);
}

fn panel(frame: &mut Frame, area: Rect, screen: &ViewState, title: &str, lines: Vec<Line>) {
    if area.height == 0 {
        return;
    }
    let width = usize::from(area.width);
    let title = text::cut(title, width.saturating_sub(4));
    let rule = "─".repeat(width.saturating_sub(4 + text::columns(&title)));
    let faint = screen.theme.faint();
    let top = Line::from(vec![
        Span::styled("── ", faint),
        Span::styled(title, screen.theme.strong()),
        Span::raw(" "),
        Span::styled(rule, faint),
    ]);
    frame.render_widget(Paragraph::new([vec![top], lines].concat()), area);
}

fn detail_spans(screen: &ViewState, schema: &SchemaView) -> Vec<Span<'static>> {
    let paint = screen.theme;
    let authority = match (schema.state, schema.authority) {
        (State::Winner, _) if schema.kind != Kind::Motor => state_word(schema),
        (State::Winner, false) => "WINNER without authority",
        (State::Winner, true) => "WINNER with authority",
        (State::Slept | State::Checking | State::Ready, _) => state_word(schema),
    };
    let mut facts = vec![
        Span::styled(authority, paint.state(schema.state)),
        Span::styled(
            health_text(&schema.health),
            if schema.health == Health::Ok {
                Style::new()
            } else {
                paint.health(&schema.health)
            },
        ),
    ];
    facts.extend(schema.held_by().map(|held| Span::styled(held, paint.operator())));
    let measured = schema.measured.map_or_else(
        || "not measured yet".to_owned(),
        |span| format!("measured {}", text::format_duration(span)),
    );
    let numbers = [
        format!("period {}, {measured}", text::format_setting(schema.period)),
        format!("longest iteration {}", text::format_duration(schema.longest)),
        format!("load {}", columns::load(schema.load)),
        counted(schema.iterations, "iteration"),
        counted(schema.overruns, "overrun"),
        format!("{} refused", schema.refused),
        counted(schema.faults, "fault"),
    ];
    facts.extend(numbers.map(Span::raw));
    if schema.triggers_dropped > 0 {
        facts.push(Span::raw(counted(schema.triggers_dropped, "dropped trigger")));
    }
    if let Some(process) = schema.process {
        facts.push(Span::raw(format!("process {process}")));
    }
    facts
}

/// Returns the line of a switch. Where there is no room for both, the latency is dropped in favour of the
/// reason.
fn switch_line(screen: &ViewState, group: usize, switch: &Switch, width: usize) -> Line<'static> {
    let name = |schema: Option<usize>| schema.map_or("nobody", |index| screen.name(index)).to_owned();
    let group = screen
        .snapshot
        .groups
        .get(group)
        .map_or("?", |group| group.name.as_str());
    let why = match &switch.decider {
        // There was no choice to make, and the reason is sufficient.
        DecidedBy::Nobody => format!("  {}", switch.reason),
        decider => format!("  {decider}: {}", switch.reason),
    };
    let mut line = Line::from(vec![
        Span::styled(
            format!("{:>9}  ", text::format_time(switch.time)),
            screen.theme.faint(),
        ),
        Span::raw(format!("{group}  {} → ", name(switch.from))),
        Span::styled(name(switch.to), screen.theme.strong()),
    ]);
    let latency = switch.latency.map_or_else(String::new, |latency| {
        format!("  in {}", text::format_duration(latency))
    });
    if line.width() + text::columns(&latency) + text::columns(&why) <= width {
        line.push_span(Span::styled(latency, screen.theme.faint()));
    }
    let room = width.saturating_sub(line.width());
    line.push_span(Span::raw(text::cut(&why, room)));
    line
}

/// Arranges facts side by side, and continues on the next line where the width ends.
fn wrap_spans(facts: Vec<Span<'static>>, width: usize) -> Vec<Line<'static>> {
    let mut lines: Vec<Line> = Vec::new();
    for fact in facts {
        let fact = Span::styled(text::cut(&fact.content, width), fact.style);
        match lines.last_mut() {
            Some(line) if line.width() + 3 + fact.width() <= width => {
                line.push_span(Span::raw(" · "));
                line.push_span(fact);
            }
            Some(_) | None => lines.push(Line::from(fact)),
        }
    }
    lines.truncate(DETAIL_LINES);
    lines
}
