//! Draws the view: divides the rows of the terminal among the parts, from 40x10 up.
//!
//! Of the view it changes only the scroll position of the list.

mod bars;
mod columns;
mod help;
mod panels;
mod table;

use ratatui::Frame;
use ratatui::layout::Rect;

use super::view_state::{Mode, ViewState};

/// From this width on the switches and the log are side by side: each keeps a readable line of 60 columns.
const SIDE_BY_SIDE: u16 = 120;

/// Least rows of the list before anything below it gets some: a group with four members.
const MIN_LIST_ROWS: u16 = 5;

/// Rows below the list that are kept even when the list is longer than the terminal: two switches and a line
/// of the log.
const MIN_LOWER_ROWS: u16 = 5;

/// Draws the whole view.
pub(super) fn draw(frame: &mut Frame, screen: &mut ViewState) {
    let mut rest = frame.area();
    let height = rest.height;
    let title = take_top(&mut rest, 1);
    let keys = take_bottom(&mut rest, u16::from(height >= 4));
    let status = take_bottom(&mut rest, u16::from(height >= 3));
    let robot = take_top(&mut rest, u16::from(height >= 14 && screen.robot.is_some()));
    let header = take_top(&mut rest, u16::from(height >= 8));

    let list_rows = u16::try_from(screen.rows.len()).unwrap_or(u16::MAX);
    let details = panels::details_height(screen, rest.width);
    let details = if rest.height >= MIN_LIST_ROWS + details {
        details
    } else {
        0
    };
    let spare = rest.height - details;
    let lower =
        match spare.saturating_sub(list_rows.min(spare.saturating_sub(MIN_LOWER_ROWS).max(MIN_LIST_ROWS))) {
            0..3 => 0,
            rows => rows,
        };
    let lower = take_bottom(&mut rest, lower);
    let details = take_bottom(&mut rest, details);

    bars::title(frame, title, screen);
    bars::robot(frame, robot, screen);
    table::draw(frame, header, rest, screen);
    panels::details(frame, details, screen);
    draw_lower_panels(frame, lower, screen);
    bars::status(frame, status, screen);
    bars::keys(frame, keys, screen);
    if screen.mode == Mode::Help {
        help::draw(frame, screen.theme);
    }
}

fn draw_lower_panels(frame: &mut Frame, mut area: Rect, screen: &ViewState) {
    let switches = if area.width >= SIDE_BY_SIDE {
        // The lines of switches are longer than those of the log.
        let log = area.width * 2 / 5;
        let switches = Rect {
            width: area.width - log - 2,
            ..area
        };
        area = Rect {
            x: area.right() - log,
            width: log,
            ..area
        };
        switches
    } else if area.height >= 5 {
        let more_than_half = area.height.div_ceil(2);
        take_top(&mut area, more_than_half)
    } else {
        take_top(&mut area, u16::MAX)
    };
    panels::switches(frame, switches, screen);
    panels::log(frame, area, screen);
}

fn take_top(rest: &mut Rect, rows: u16) -> Rect {
    let used_area = Rect {
        height: rows.min(rest.height),
        ..*rest
    };
    *rest = Rect {
        y: rest.y + used_area.height,
        height: rest.height - used_area.height,
        ..*rest
    };
    used_area
}

fn take_bottom(rest: &mut Rect, rows: u16) -> Rect {
    let height = rows.min(rest.height);
    rest.height -= height;
    Rect {
        y: rest.y + rest.height,
        height,
        ..*rest
    }
}
