//! The overlay that explains the keys and the signs.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::Line;
use ratatui::widgets::{Block, Clear, Paragraph};

use crate::top::theme::Theme;

const TEXT: [&str; 22] = [
    "↑ ↓  j k     select a schema",
    "space        STOP EVERYTHING: all roots sleep, all actuators brake",
    "g            let everything go on that space stopped",
    "p            play it if it sleeps, stop it if it is awake",
    "f            force it to win, or let it go",
    "r            release it: the hierarchy decides again",
    "+  -         a longer or shorter period, by a tenth",
    "t            type a period: 75ms, 0.5s, 20Hz",
    "[  ]         a shorter or longer past in the strips",
    "q  Esc       leave",
    "",
    "█ WINNER     chosen: it iterates and may command",
    "▄ READY      it could act, another was chosen",
    "▁ CHECKING   awake, its precondition is false",
    "· SLEPT      costs nothing",
    "× faulted    panicked, erred, hung or died",
    "",
    "P S F U      played, stopped, forced, unloaded by an operator",
    "R M          given another period, or another modulation",
    "cycle        the period asked for; measured: what it is",
    "▸ name       the winner of a group; how it is chosen;",
    "             worst takeover, of what its contract allows",
];

/// Draws the help in the middle of the screen. On a small terminal its end is cut.
pub(super) fn draw(frame: &mut Frame, paint: Theme) {
    let whole = frame.area();
    let longest = TEXT
        .iter()
        .map(|line| Line::raw(*line).width())
        .max()
        .unwrap_or(0);
    let (width, height) = (
        (longest as u16 + 4).min(whole.width),
        (TEXT.len() as u16 + 2).min(whole.height),
    );
    let area = Rect {
        x: whole.x + (whole.width - width) / 2,
        y: whole.y + (whole.height - height) / 2,
        width,
        height,
    };
    let block = Block::bordered()
        .title(" keys and signs ")
        .title_bottom(" any key closes this ")
        .title_style(paint.strong())
        .padding(ratatui::widgets::Padding::horizontal(1));
    frame.render_widget(Clear, area);
    frame.render_widget(Paragraph::new(TEXT.map(Line::raw).to_vec()).block(block), area);
}
