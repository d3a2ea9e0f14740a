//! The left half of a schema's row: its facts in columns, and an operator's actions.

use eframe::egui::{Align2, Color32, Rect, Response, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use jde_abi::describe::Kind;
use jde_core::State;
use jde_link::message::Action;
use jde_panel::Ink;
use jde_records::snapshot::SchemaView;
use jde_timeline::{
    Children, HierarchyRow, Severity, health_reason, health_severity, health_word, state_word,
};

use super::cells;
use super::columns::{self, Column};
use super::input::{Input, Request};
use super::operate;
use super::paint::{self, Icon, ROW};
use super::period::Period;
use crate::style::{self, Style, time};

/// Minimum width of the names, in points.
const MIN_NAME_WIDTH: f32 = 110.0;
/// Width for who holds a schema, in points: "forced by ana@l…".
const HELD_WIDTH: f32 = 100.0;
/// Indentation per level of the tree, in points.
pub(super) const INDENT: f32 = 10.0;

/// The positions of the columns.
pub(super) struct Table {
    pub(super) left: f32,
    pub(super) right: f32,
    columns: Vec<(Column, f32)>,
    /// The right end of the names.
    names: f32,
}

/// The user's input on a row.
#[derive(Default)]
pub(super) struct RowActions {
    pub(super) selected: bool,
    pub(super) folded: bool,
}

/// Returns the width that the longest name of the rows needs, with the beginning of who holds the schema, in points.
pub(super) fn name_width(ui: &Ui, seen: &Input<'_>, list: &[HierarchyRow]) -> f32 {
    let begin = |depth: usize| 4.0 + depth as f32 * INDENT + 16.0;
    let held = |view: &SchemaView| if view.operator.is_some() { HELD_WIDTH } else { 6.0 };
    let rows = list.iter().filter_map(|row| {
        let view = seen.snapshot.schemas.get(row.schema()?)?;
        let beside = begin(row.depth) + held(view);
        Some((
            view.name.chars().count() as f32 * paint::LETTER + beside,
            beside,
            &view.name,
        ))
    });
    // One name is measured, not thousands.
    let longest = rows.max_by(|one, other| one.0.total_cmp(&other.0));
    longest.map_or(0.0, |(_, beside, name)| {
        let galley = ui
            .painter()
            .layout_no_wrap(name.clone(), paint::font(), Color32::WHITE);
        beside + galley.size().x
    })
}

impl Table {
    /// Divides the space: the state has its place, then the names have theirs, and then the other columns as they fit.
    pub(super) fn new(left: f32, right: f32, names: f32) -> Self {
        let most = (right - left - Column::State.width()).max(MIN_NAME_WIDTH);
        let names = names.clamp(MIN_NAME_WIDTH, most);
        let columns = columns::fitting(right - left - names, right - 4.0);
        Self {
            left,
            right,
            names: columns.first().map_or(right - 4.0, |(_, first)| *first),
            columns,
        }
    }

    pub(super) fn titles(&self, ui: &Ui, rect: Rect) {
        let faint = ui.visuals().weak_text_color();
        for &(column, x) in &self.columns {
            let (title, tip) = column.title();
            let cell = self.cell(rect, column, x);
            let rect = match column {
                Column::Period | Column::Measured | Column::Load | Column::Overruns => {
                    ui.painter().text(
                        cell.right_center(),
                        Align2::RIGHT_CENTER,
                        title,
                        paint::small(),
                        faint,
                    );
                    cell
                }
                Column::State | Column::Health => {
                    paint::write(ui.painter(), cell, title, paint::small(), faint);
                    cell
                }
            };
            let hovered = ui.interact(rect, ui.scope_id().with(("title", title)), Sense::hover());
            if hovered.hovered() {
                hovered.on_hover_text(tip);
            }
        }
    }

    fn cell(&self, row: Rect, column: Column, x: f32) -> Rect {
        Rect::from_min_size(pos2(x + 4.0, row.top()), vec2(column.width() - 8.0, row.height()))
    }

    /// Draws the row of a schema. Returns the input on it.
    #[expect(clippy::too_many_arguments, reason = "each is needed for the facts of a row")]
    pub(super) fn schema(
        &self,
        ui: &mut Ui,
        rect: Rect,
        seen: &Input<'_>,
        place: usize,
        (depth, below): (usize, Children),
        editing: &mut Period,
        style: &Style,
        requests: &mut Vec<Request>,
    ) -> RowActions {
        let view = &seen.snapshot.schemas[place];
        let id = ui.scope_id().with(("schema", &view.name));
        let mut actions = RowActions::default();
        let left = self.left + 4.0 + depth as f32 * INDENT;
        let line = Rect::from_min_max(pos2(self.left, rect.top()), pos2(self.right, rect.bottom()));
        let row = ui.interact(line, id, Sense::click());
        row.widget_info(|| WidgetInfo::labeled(Role::Label, true, accessible_text(view)));
        actions.selected = row.clicked();
        let fold = Rect::from_min_size(pos2(left, rect.top()), vec2(14.0, ROW));
        if below != Children::Nothing {
            let (icon, action) = match below {
                Children::Folded => (Icon::Unfold, "Unfold"),
                Children::Shown | Children::Nothing => (Icon::Fold, "Fold"),
            };
            let name = format!("{action} {}", view.name);
            let tip = "Show or hide its children.";
            actions.folded =
                paint::button(ui, fold, id.with("fold"), icon, (&name, tip), (true, false)).clicked();
        }
        let name = Rect::from_min_max(
            pos2(fold.right() + 2.0, rect.top()),
            pos2(self.names, rect.bottom()),
        );
        let color = if view.state == State::Slept {
            ui.visuals().weak_text_color()
        } else {
            ui.visuals().text_color()
        };
        let end = paint::write_name(ui.painter(), name, &view.name, paint::font(), color);
        if let Some(held) = view.held_by() {
            let rest = name.with_min_x((end + 6.0).min(name.right()));
            paint::write(
                ui.painter(),
                rest,
                &held,
                paint::small(),
                style::color_of(Ink::Goal, style),
            );
        }
        for &(column, x) in &self.columns {
            let cell = self.cell(rect, column, x);
            self.fact(ui, cell, column, view, editing, style, requests);
        }
        row.context_menu(|ui| operate::actions(ui, seen, view, false, requests));
        if row.hovered() {
            row.on_hover_ui(|ui| details(ui, seen, place));
        }
        actions
    }

    #[expect(clippy::too_many_arguments, reason = "each is needed for the facts of a cell")]
    fn fact(
        &self,
        ui: &mut Ui,
        cell: Rect,
        column: Column,
        view: &SchemaView,
        editing: &mut Period,
        style: &Style,
        requests: &mut Vec<Request>,
    ) {
        let faint = ui.visuals().weak_text_color();
        let plain = if view.state == State::Slept {
            faint
        } else {
            ui.visuals().text_color()
        };
        match column {
            Column::State => cells::state(ui, cell, view, style),
            Column::Health => {
                let color = match health_severity(&view.health) {
                    Severity::Good => faint,
                    Severity::Warning => style::color_of(Ink::Warn, style),
                    Severity::Bad => style::color_of(Ink::Bad, style),
                };
                paint::write(
                    ui.painter(),
                    cell,
                    health_word(&view.health),
                    paint::font(),
                    color,
                );
            }
            Column::Period => {
                let period = view.period as f64 / 1e9;
                if let Some(period_s) = editing.show(ui, cell, &view.name, period, plain, style) {
                    requests.push(Request::Act(Action::Period {
                        schema: view.name.clone(),
                        period_s,
                    }));
                }
            }
            Column::Measured => {
                let text = view
                    .measured
                    .map_or_else(|| "–".to_owned(), |measured| time::span(measured as f64 / 1e9));
                paint::write_right(ui.painter(), cell, &text, plain);
            }
            Column::Load => cells::load(ui, cell, view.load, style),
            Column::Overruns => {
                let color = if view.overruns == 0 {
                    faint
                } else {
                    style::color_of(Ink::Warn, style)
                };
                paint::write_right(ui.painter(), cell, &view.overruns.to_string(), color);
            }
        }
    }
}

/// The row as text, for screen readers.
fn accessible_text(view: &SchemaView) -> String {
    let (health, reason) = (health_word(&view.health), health_reason(&view.health));
    let mut text = format!("{}, {}, {health}", view.name, state_word(view));
    if let Some(reason) = reason {
        text += &format!(": {reason}");
    }
    if let Some(held) = view.held_by() {
        text += &format!(", {held}");
    }
    text
}

fn details(ui: &mut Ui, seen: &Input<'_>, place: usize) {
    let view = &seen.snapshot.schemas[place];
    let info = seen.schemas.schemas.iter().find(|info| info.name == view.name);
    ui.strong(&view.name);
    let kind = match view.kind {
        Kind::Perceptive => "perceptive",
        Kind::Motor => "motor",
        Kind::Driver => "driver",
    };
    ui.label(format!("{kind} schema of type {}", view.type_name));
    if let Some(info) = info.filter(|info| !info.doc.is_empty()) {
        ui.label(&info.doc);
    }
    let (health, reason) = (health_word(&view.health), health_reason(&view.health));
    let mut lines = vec![format!(
        "{}{}, {health}",
        state_word(view),
        if view.authority { " with authority" } else { "" }
    )];
    lines.extend(reason.map(|reason| format!("Reason: {reason}")));
    lines.extend(view.holds().map(ToString::to_string));
    lines.push(format!(
        "{} iterations, the longest {}; {} overruns, {} refused, {} faults",
        view.iterations,
        time::span(view.longest as f64 / 1e9),
        view.overruns,
        view.refused,
        view.faults
    ));
    if view.triggers_dropped > 0 {
        lines.push(format!("{} triggers dropped", view.triggers_dropped));
    }
    lines.into_iter().for_each(|line| drop(ui.label(line)));
}

/// Draws the background of a row that is selected or under the pointer.
pub(super) fn ground(ui: &Ui, rect: Rect, selected: bool, striped: bool) {
    let visuals = ui.visuals();
    if selected {
        ui.painter()
            .rect_filled(rect, 0.0, visuals.selection.bg_fill.gamma_multiply(0.35));
    } else if striped {
        ui.painter().rect_filled(rect, 0.0, visuals.faint_bg_color);
    }
}

/// Whether the pointer is over a row.
pub(super) fn is_hovered(response: &Response, rect: Rect) -> bool {
    response.hover_pos().is_some_and(|at| rect.contains(at))
}
