//! A recording on the terminal: the position, the schemas' states, the last decisions, and the control keys.

use std::io;
use std::time::{Duration, Instant};

use jde_core::Nanos;
use jde_records::RunRecord;
use jde_terminal as terminal;
use jde_terminal::escape::escape;
use ratatui::Frame;
use ratatui::crossterm::event::{KeyCode, KeyModifiers};
use ratatui::layout::{Constraint, Layout};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Gauge, Paragraph};

use super::player::Player;

/// Time between two redraws.
const REDRAW_INTERVAL: Duration = Duration::from_millis(50);
/// How far the arrow keys seek.
const SEEK_STEP: Nanos = 5_000_000_000;

/// Shows a recording until the user leaves.
///
/// # Errors
/// Standard input or output is not a terminal, or it was closed.
pub(super) fn run(player: &Player, title: &str) -> io::Result<()> {
    terminal::with_screen(|terminal| {
        while !player.is_stopped() {
            terminal.draw(|frame| draw(frame, player, title))?;
            let redraw = Instant::now() + REDRAW_INTERVAL;
            if let Some(key) = terminal.read_key(redraw)? {
                let ctrl_c = key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL);
                if ctrl_c || matches!(key.code, KeyCode::Char('q') | KeyCode::Esc) {
                    return Ok(());
                }
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
    let [title_area, gauge_area, winners_area, events_area, keys_area] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(1),
        Constraint::Length(2),
        Constraint::Min(1),
        Constraint::Length(1),
    ])
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

    let winners = player.timeline(|timeline| {
        let hierarchy = timeline.hierarchy();
        let groups = hierarchy.groups().iter().zip(timeline.groups());
        let winners =
            groups.map(|(group, known)| format!("{} ▸ {}", group.name, hierarchy.name(known.winner())));
        winners.collect::<Vec<_>>().join("   ")
    });
    frame.render_widget(
        Paragraph::new(vec![Line::default(), Line::from(escape(&winners))]),
        winners_area,
    );

    let shown = player.recent(usize::from(events_area.height), line_text);
    let shown: Vec<_> = shown.iter().map(|line| Line::from(escape(line))).collect();
    frame.render_widget(Paragraph::new(shown), events_area);
    let keys_text = "space pause  ← → 5 s  n next takeover  + - speed  l loop  q quit";
    frame.render_widget(Paragraph::new(Span::styled(keys_text, faint)), keys_area);
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
