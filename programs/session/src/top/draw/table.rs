//! The list of groups and schemas, with a strip of the past for each schema.
//!
//! The height of a strip's cell shows the state, as its colour does.

use jde_records::snapshot::GroupView;
use jde_timeline::{HierarchyRow, Item, OTHERS};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::columns::{self, Column};
use crate::top::strip::{self, StripState};
use crate::top::text;
use crate::top::view_state::ViewState;
use jde_drawing::text::counted;

/// The least width of the name column, so that the list does not jump when short names appear or disappear.
const MIN_NAME_WIDTH: usize = 12;

/// Draws the header and the list below it, scrolled so that the selection is visible.
pub(super) fn draw(frame: &mut Frame, header: Rect, area: Rect, screen: &mut ViewState) {
    let width = usize::from(area.width);
    let longest = screen
        .rows
        .iter()
        .map(|(branch, row)| name_width(branch, row, screen))
        .max()
        .unwrap_or(0);
    let name = longest.min(width * 2 / 5).max(MIN_NAME_WIDTH.min(width));
    let (columns, strip) = columns::plan(width, name);
    scroll(screen, usize::from(area.height));

    let mut titles = text::pad_or_cut("schema", name + 1);
    for column in &columns {
        titles += &align(*column, column.title());
        titles.push(' ');
    }
    titles += &text::cut(
        &format!("last {}", text::format_setting(screen.slice() * strip as u64)),
        strip,
    );
    frame.render_widget(Paragraph::new(Line::styled(titles, screen.theme.faint())), header);

    let shown = screen
        .rows
        .iter()
        .skip(screen.first_row)
        .take(usize::from(area.height));
    let lines: Vec<Line> = shown
        .map(|(branch, row)| match row.item {
            Item::Group(group) => group_line(screen, branch, &screen.snapshot.groups[group], name, width),
            Item::Schema(schema, _) => schema_line(screen, branch, schema, name, &columns, strip),
            Item::Others => Line::styled(OTHERS, screen.theme.strong()),
        })
        .collect();
    frame.render_widget(Paragraph::new(lines), area);
}

fn name_width(branch: &str, row: &HierarchyRow, screen: &ViewState) -> usize {
    match row.item {
        Item::Group(group) => text::columns(branch) + text::columns(&screen.snapshot.groups[group].name),
        Item::Schema(schema, _) => text::columns(branch) + text::columns(screen.name(schema)),
        Item::Others => 0,
    }
}

fn scroll(screen: &mut ViewState, height: usize) {
    let Some(selected) = screen.selected_row() else {
        return;
    };
    // The row of the group becomes visible with its first member.
    let above = selected.checked_sub(1).map(|above| screen.rows[above].1);
    let from = match above.filter(|row| row.schema().is_none()) {
        Some(_) if height > 1 => selected - 1,
        Some(_) | None => selected,
    };
    let lowest = screen.rows.len().saturating_sub(height);
    screen.first_row = screen
        .first_row
        .min(from)
        .max((selected + 1).saturating_sub(height))
        .min(lowest);
}

fn schema_line(
    screen: &ViewState,
    branch: &str,
    schema: usize,
    name: usize,
    columns: &[Column],
    strip: usize,
) -> Line<'static> {
    let view = &screen.snapshot.schemas[schema];
    let style = if schema == screen.selected {
        screen.theme.selected()
    } else {
        Style::new()
    };
    let room = name.saturating_sub(text::columns(branch));
    let mut line = Line::from(vec![
        Span::styled(text::cut(branch, name), screen.theme.faint()),
        Span::styled(text::pad_or_cut(&view.name, room), style),
        Span::raw(" "),
    ]);
    for column in columns {
        let (cell, style) = column.cell(view, screen.theme);
        // An empty mark is a gap, and gets no style of the operator.
        let style = if cell.is_empty() { Style::new() } else { style };
        line.push_span(Span::styled(align(*column, &cell), style));
        line.push_span(Span::raw(" "));
    }
    let known = &screen.timeline.schemas()[schema];
    for slice in strip::cells(known, screen.snapshot.time, screen.slice(), strip) {
        line.push_span(match slice {
            Some(trace) => Span::styled(symbol(trace), screen.theme.strip_state(trace)),
            None => Span::raw(" "),
        });
    }
    line
}

fn group_line(
    screen: &ViewState,
    branch: &str,
    group: &GroupView,
    name: usize,
    width: usize,
) -> Line<'static> {
    let theme = screen.theme;
    let title = format!("{branch}{}", group.name);
    let winner = match group.winner {
        Some(winner) => Span::styled(
            format!("▸ {}", screen.name(winner)),
            theme.strip_state(StripState::Winner),
        ),
        None => Span::styled("▸ nobody", theme.bad()),
    };
    let late = group.allowed > 0 && group.worst > group.allowed;
    let worst = match (group.worst, group.allowed) {
        (0, 0) => String::new(),
        (worst, 0) => format!("worst {}", text::format_duration(worst)),
        (worst, allowed) => format!(
            "worst {} of {}",
            text::format_duration(worst),
            text::format_setting(allowed)
        ),
    };
    let chatters = group.chatter.as_ref().map(|chatter| {
        let [first, second] = chatter
            .between
            .map(|schema| schema.map_or("nobody", |schema| screen.name(schema)));
        let text = format!("chatters: {first} ⇄ {second} {} a second", chatter.switches);
        Span::styled(text, theme.bad())
    });
    let pieces = [
        Some(winner),
        chatters,
        Some(Span::raw(group.policy.clone())),
        Some(Span::raw(counted(group.switches, "switch"))),
        Some(Span::styled(
            worst,
            if late { theme.bad() } else { theme.faint() },
        )),
    ];
    let mut line = Line::from(Span::styled(text::pad_or_cut(&title, name), theme.strong()));
    for (nth, piece) in pieces.into_iter().flatten().enumerate() {
        let gap = if nth == 0 { " " } else { "  " };
        if line.width() + gap.len() + piece.width() > width {
            break;
        }
        line.push_span(Span::raw(gap));
        line.push_span(piece);
    }
    line
}

fn align(column: Column, cell: &str) -> String {
    let width = column.width();
    if column.is_text() {
        return text::pad_or_cut(cell, width);
    }
    let cell = text::cut(cell, width);
    format!("{}{cell}", " ".repeat(width - text::columns(&cell)))
}

fn symbol(trace: StripState) -> &'static str {
    match trace {
        StripState::Slept => "·",
        StripState::Checking => "▁",
        StripState::Ready => "▄",
        StripState::Winner => "█",
        StripState::Faulted => "×",
    }
}
