//! The overlay that explains the keys and the signs.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::Line;
use ratatui::widgets::{Block, Clear, Paragraph};

use crate::top::theme::Theme;

const TEXT: [&str; 23] = [
    "↑ ↓  j k     select a schema",
    "space        STOP EVERYTHING: all roots sleep, all actuators brake",
    "g            release everything that space stopped",
    "p            play it",
    "s            stop it",
    "f            force it to win",
    "r            release it: the hierarchy decides again",
    "+  -         a longer or shorter period, by a tenth",
    "t            type a period: 75ms, 0.5s, 20Hz",
    "[  ]         a shorter or longer time in the strips",
    "q  Esc       leave",
    "",
    "█ WINNER     selected, or running: it iterates and may command",
    "▄ READY      it could act, another was selected",
    "▁ CHECKING   awake, its precondition is false",
    "· SLEPT      does not run",
    "× faulted    panicked, erred, hung or died",
    "",
    "P S F U      played, stopped, forced, unloaded by an operator",
    "R M          with another period, or another modulation",
    "period       the set one; measured: the real one",
    "▸ name       the winner of a group; how it is chosen;",
    "             worst takeover, and the time its contract allows",
];

/// Draws the help in the middle of the screen. On a small terminal its end is cut.
pub(super) fn draw(frame: &mut Frame, theme: Theme) {
    let screen = frame.area();
    let longest = TEXT
        .iter()
        .map(|line| Line::raw(*line).width())
        .max()
        .unwrap_or(0);
    let (width, height) = (
        (longest as u16 + 4).min(screen.width),
        (TEXT.len() as u16 + 2).min(screen.height),
    );
    let area = Rect {
        x: screen.x + (screen.width - width) / 2,
        y: screen.y + (screen.height - height) / 2,
        width,
        height,
    };
    let block = Block::bordered()
        .title(" keys and signs ")
        .title_bottom(" any key closes this ")
        .title_style(theme.strong())
        .padding(ratatui::widgets::Padding::horizontal(1));
    frame.render_widget(Clear, area);
    frame.render_widget(Paragraph::new(TEXT.map(Line::raw).to_vec()).block(block), area);
}
