//! A recording on the terminal: the position, the schemas' states, the last decisions, and the control keys.

use std::io;
use std::time::{Duration, Instant};

use jde_core::{Health, Nanos, State};
use jde_records::RunRecord;
use jde_session::top::branches;
use jde_terminal as terminal;
use jde_terminal::escape::escape;
use jde_timeline::{HierarchyRow, Item, OTHERS, Timeline, health_word, state_word};
use ratatui::Frame;
use ratatui::crossterm::event::{KeyCode, KeyModifiers};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Gauge, Paragraph};

use super::player::Player;

/// Time between two redraws.
const REDRAW_INTERVAL: Duration = Duration::from_millis(50);
/// How far the arrow keys seek.
const SEEK_STEP: Nanos = 5_000_000_000;

/// The least width, in columns, at which lines are beside the schemas.
const SIDE_BY_SIDE: u16 = 90;
/// The keys.
const HELP: [&str; 10] = [
    "space       pause, or go on",
    "left right  5 s back or on",
    "n  .        play to the next takeover, and pause there",
    "home end    go to the beginning, or to the end",
    "+  -        twice the speed, or half of it",
    "l           start again at the end",
    "q  Esc      leave",
    "",
    "Other terminals ask the same recording meanwhile:",
    "jde why, jde ps, jde get, jde events, jde view",
];

/// Shows a recording until the user leaves.
///
/// # Errors
/// Standard input or output is not a terminal, or it was closed.
pub(super) fn run(player: &Player, title: &str) -> io::Result<()> {
    let mut shows_help = false;
    terminal::with_screen(|terminal| {
        while !player.is_stopped() {
            terminal.draw(|frame| {
                draw(frame, player, title);
                if shows_help {
                    draw_help(frame);
                }
            })?;
            let redraw = Instant::now() + REDRAW_INTERVAL;
            if let Some(key) = terminal.read_key(redraw)? {
                let ctrl_c = key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL);
                if ctrl_c || matches!(key.code, KeyCode::Char('q') | KeyCode::Esc) {
                    return Ok(());
                }
                // Any key closes the help.
                shows_help = !shows_help && key.code == KeyCode::Char('?');
                handle_key(player, key.code);
            }
        }
        Ok(())
    })
}

fn handle_key(player: &Player, key: KeyCode) {
    let controls = player.controls();
    let position = player.position();
    match key {
        KeyCode::Char(' ') => player.set_paused(!controls.paused),
        KeyCode::Left => player.seek(position.saturating_sub(SEEK_STEP)),
        KeyCode::Right => player.seek(position + SEEK_STEP),
        KeyCode::Home => player.seek(0),
        KeyCode::End => player.seek(player.index.end),
        KeyCode::Char('.') | KeyCode::Char('n') => player.step(),
        KeyCode::Char('+' | '=') => player.set_speed(controls.speed * 2.0),
        KeyCode::Char('-') => player.set_speed(controls.speed / 2.0),
        KeyCode::Char('l') => player.set_looping(!controls.looping),
        _ => {}
    }
}

fn draw(frame: &mut Frame<'_>, player: &Player, title: &str) {
    let [title_area, gauge_area, _, middle_area, keys_area] =
        Layout::vertical([1, 1, 1, 0, 1].map(|lines| match lines {
            0 => Constraint::Min(1),
            lines => Constraint::Length(lines),
        }))
        .areas(frame.area());
    let (bold, faint) = (
        Style::new().add_modifier(Modifier::BOLD),
        Style::new().add_modifier(Modifier::DIM),
    );
    let controls = player.controls();
    let position = player.position();
    let state = match (player.at_end(), controls.paused) {
        (true, _) => "at its end",
        (false, true) => "paused",
        (false, false) => "playing",
    };
    frame.render_widget(Paragraph::new(Span::styled(escape(title), bold)), title_area);
    let (begin, end) = (player.index.begin, player.index.end);
    let played = position.saturating_sub(begin) as f64 / (end - begin).max(1) as f64;
    let gauge = Gauge::default().ratio(played.min(1.0)).label(format!(
        "{:.1} s of {:.1} s  {}x  {state}{}",
        position as f64 / 1e9,
        end as f64 / 1e9,
        controls.speed,
        if controls.looping { "  loop" } else { "" }
    ));
    frame.render_widget(gauge, gauge_area);

    let tree = player.timeline(|timeline| tree(timeline, faint));
    let (lines, width) = (
        tree.len() as u16,
        tree.iter().map(Line::width).max().unwrap_or(0) as u16,
    );
    let [tree_area, events_area] = if middle_area.width >= SIDE_BY_SIDE {
        Layout::horizontal([Constraint::Length(width + 2), Constraint::Min(1)]).areas(middle_area)
    } else {
        let lines = lines.min(middle_area.height / 2);
        Layout::vertical([Constraint::Length(lines), Constraint::Min(1)]).areas(middle_area)
    };
    frame.render_widget(Paragraph::new(tree), tree_area);

    let shown = player.recent(usize::from(events_area.height), line_text);
    let shown: Vec<_> = shown.iter().map(|line| Line::from(escape(line))).collect();
    frame.render_widget(Paragraph::new(shown), events_area);
    let keys_text = "space pause  ← → 5 s  n next takeover  + - speed  l loop  ? help  q quit";
    frame.render_widget(Paragraph::new(Span::styled(keys_text, faint)), keys_area);
}

/// Returns the schemas with their states, and the winner of each group, at the position.
fn tree(timeline: &Timeline, faint: Style) -> Vec<Line<'static>> {
    let (hierarchy, now) = (timeline.hierarchy(), timeline.snapshot());
    let rows = branches(hierarchy).into_iter().filter(|(_, row)| row.is_in(&now));
    let line = |(branch, row): (String, HierarchyRow)| match row.item {
        Item::Group(place) => {
            let group = &now.groups[place];
            let winner = hierarchy.name(group.winner);
            Line::from(escape(&format!("{branch}{} ▸ {winner}", group.name)))
        }
        Item::Schema(place, _) => {
            let (schema, state) = (&now.schemas[place], state_word(&now.schemas[place]));
            let name = escape(&format!("{:<22}", format!("{branch}{}", schema.name)));
            let state = match schema.health {
                Health::Ok => state.to_owned(),
                Health::Overrun | Health::ArbitrationFailed(_) | Health::Faulted(_) => {
                    format!("{state}, {}", health_word(&schema.health))
                }
            };
            let style = if schema.state == State::Slept {
                faint
            } else {
                Style::new()
            };
            Line::from(vec![Span::raw(name), Span::styled(format!(" {state}"), style)])
        }
        Item::Others => Line::from(Span::styled(OTHERS, faint)),
    };
    rows.map(line).collect()
}

/// Draws the list of keys in the middle of the screen. On a small terminal its end is cut.
fn draw_help(frame: &mut Frame<'_>) {
    let screen = frame.area();
    let (width, height) = (58.min(screen.width), (HELP.len() as u16 + 2).min(screen.height));
    let area = Rect {
        x: screen.x + (screen.width - width) / 2,
        y: screen.y + (screen.height - height) / 2,
        width,
        height,
    };
    let block = Block::bordered()
        .title(" keys ")
        .title_bottom(" any key closes this ");
    frame.render_widget(Clear, area);
    frame.render_widget(Paragraph::new(HELP.map(Line::raw).to_vec()).block(block), area);
}

/// Returns the text of a line, or `None` if it is not shown.
fn line_text(line: &RunRecord) -> Option<String> {
    match line {
        RunRecord::Decision(decision) if decision.changed => Some(format!(
            "{:>9.3} s  {}: {} → {}  {}",
            decision.time_s,
            decision.group,
            decision.before_name(),
            decision.choice_name(),
            decision.reason
        )),
        RunRecord::Other(event) => Some(format!("{:>9.3} s  {event}", event.time_s())),
        RunRecord::Decision(_) | RunRecord::State(_) => None,
    }
}
