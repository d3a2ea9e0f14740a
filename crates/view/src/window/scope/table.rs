//! The left half of a row: a schema's facts in columns, and what an operator can do with it; or a group's.

use eframe::egui::{Align2, Rect, Response, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use jde_abi::describe::Kind;
use jde_core::{Health, State};
use jde_host::snapshot::{GroupView, SchemaView};
use jde_link::message::Action;
use jde_panel::Ink;

use super::bands;
use super::cells;
use super::ink::{self, Icon, ROW};
use super::period::Period;
use super::rows::{self, Below};
use super::seen::{Ask, Seen};
use crate::look::{self, Look, time};

/// Room that a name keeps, points.
const NAME: f32 = 110.0;
/// A level of the tree.
const INDENT: f32 = 10.0;

/// A column right of the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Column {
    State,
    Health,
    Period,
    Measured,
    Load,
    Overruns,
    Buttons,
}

/// The columns by their importance: a narrow table has the first.
const IMPORTANCE: [Column; 7] = [
    Column::Buttons,
    Column::State,
    Column::Period,
    Column::Measured,
    Column::Load,
    Column::Health,
    Column::Overruns,
];

impl Column {
    fn width(self) -> f32 {
        match self {
            Self::State => 86.0,
            Self::Health => 64.0,
            Self::Period | Self::Measured => 62.0,
            Self::Load => 46.0,
            Self::Overruns => 44.0,
            Self::Buttons => 5.0 * cells::BUTTON + 4.0,
        }
    }

    fn title(self) -> (&'static str, &'static str) {
        match self {
            Self::State => (
                "state",
                "SLEPT costs nothing; CHECKING: its precondition is false; READY: it could act, another was chosen; WINNER: it \
                 iterates. A diamond: what it commands counts (R7).",
            ),
            Self::Health => ("health", "Whether it keeps its deadlines, or why it cannot run."),
            Self::Period => (
                "period",
                "The cycle time asked for. Click one to type another: 50ms or 20Hz.",
            ),
            Self::Measured => ("measured", "The cycle time as it is."),
            Self::Load => ("load", "Share of one processor core."),
            Self::Overruns => ("late", "Deadlines missed and budgets passed."),
            Self::Buttons => (
                "operate",
                "Play, stop, force to win, let go of it, open its panel.",
            ),
        }
    }
}

/// Where the columns are.
pub(super) struct Table {
    pub(super) left: f32,
    pub(super) right: f32,
    columns: Vec<(Column, f32)>,
    /// Where names end.
    names: f32,
}

/// What was done with a row.
#[derive(Default)]
pub(super) struct Done {
    pub(super) selected: bool,
    pub(super) folded: bool,
}

impl Table {
    pub(super) fn new(left: f32, right: f32) -> Self {
        let mut room = right - left - NAME;
        let mut fitting = Vec::new();
        for column in IMPORTANCE {
            if column.width() > room {
                break;
            }
            room -= column.width();
            fitting.push(column);
        }
        fitting.sort_unstable();
        let mut end = right - 4.0;
        let mut columns = Vec::new();
        for column in fitting.into_iter().rev() {
            end -= column.width();
            columns.push((column, end));
        }
        columns.reverse();
        Self {
            left,
            right,
            names: end,
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
                        ink::small(),
                        faint,
                    );
                    cell
                }
                Column::State | Column::Health | Column::Buttons => {
                    ink::write(ui.painter(), cell, title, ink::small(), faint);
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

    /// A group: its policy, winner, switches, and its worst takeover against what its contract allows.
    pub(super) fn group(
        &self,
        ui: &Ui,
        rect: Rect,
        seen: &Seen<'_>,
        group: &GroupView,
        depth: usize,
        look: &Look,
    ) {
        let winner = group
            .winner
            .and_then(|winner| seen.snapshot.schemas.get(winner))
            .map_or("nobody", |winner| &winner.name);
        let (worst, allowed) = (
            time::span(group.worst as f64 / 1e9),
            time::span(group.allowed as f64 / 1e9),
        );
        let late = group.worst > group.allowed;
        let facts = format!(
            "{} · {winner} wins · {} switches · worst takeover {worst} of {allowed}",
            group.policy, group.switches
        );
        let left = self.left + 6.0 + depth as f32 * INDENT;
        let line = Rect::from_min_max(pos2(left, rect.top()), pos2(self.right - 4.0, rect.bottom()));
        let response = ui.interact(line, ui.scope_id().with(("group", &group.name)), Sense::hover());
        response.widget_info(|| {
            let text = format!("group {}: {facts}", group.name);
            WidgetInfo::labeled(Role::Label, true, text)
        });
        let accent = look::ink(Ink::Accent, look);
        let end = ink::write(ui.painter(), line, &group.name, ink::font(), accent);
        let rest = line.with_min_x((end + 8.0).min(line.right()));
        let color = if late {
            look::ink(Ink::Bad, look)
        } else {
            ui.visuals().weak_text_color()
        };
        ink::write(ui.painter(), rest, &facts, ink::small(), color);
        if response.hovered() {
            let members = group
                .members
                .iter()
                .filter_map(|&member| seen.snapshot.schemas.get(member))
                .map(|member| member.name.as_str())
                .collect::<Vec<_>>()
                .join(", ");
            response.on_hover_text(format!(
                "{}\nOne of these wins: {members}\nPolicy: {}\nWinner: {winner}\nSwitches: {}\nWorst takeover: {worst} of the {allowed} \
                 that its contract allows (R17)",
                group.name, group.policy, group.switches
            ));
        }
    }

    /// A schema.
    #[expect(clippy::too_many_arguments, reason = "each is another half of a row's facts")]
    pub(super) fn schema(
        &self,
        ui: &mut Ui,
        rect: Rect,
        seen: &Seen<'_>,
        place: usize,
        (depth, below): (usize, Below),
        editing: &mut Period,
        look: &Look,
        asks: &mut Vec<Ask>,
    ) -> Done {
        let view = &seen.snapshot.schemas[place];
        let id = ui.scope_id().with(("schema", &view.name));
        let mut done = Done::default();
        let left = self.left + 4.0 + depth as f32 * INDENT;
        let line = Rect::from_min_max(pos2(self.left, rect.top()), pos2(self.right, rect.bottom()));
        let row = ui.interact(line, id, Sense::click());
        row.widget_info(|| WidgetInfo::labeled(Role::Label, true, spoken(view)));
        done.selected = row.clicked();
        let fold = Rect::from_min_size(pos2(left, rect.top()), vec2(14.0, ROW));
        if below != Below::Nothing {
            let (icon, word) = match below {
                Below::Folded => (Icon::Unfold, "Unfold"),
                Below::Shown | Below::Nothing => (Icon::Fold, "Fold"),
            };
            let name = format!("{word} {}", view.name);
            let tip = "Show or hide what is below it.";
            done.folded = ink::button(ui, fold, id.with("fold"), icon, (&name, tip), (true, false)).clicked();
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
        let end = ink::write(ui.painter(), name, &view.name, ink::font(), color);
        if let Some(hold) = &view.operator {
            let held = format!("{} by {}", hold.kind.word(), hold.by);
            let rest = name.with_min_x((end + 6.0).min(name.right()));
            ink::write(
                ui.painter(),
                rest,
                &held,
                ink::small(),
                look::ink(Ink::Goal, look),
            );
        }
        for &(column, x) in &self.columns {
            let cell = self.cell(rect, column, x);
            self.fact(ui, cell, column, seen, view, editing, look, asks);
        }
        if row.hovered() {
            row.on_hover_ui(|ui| details(ui, seen, place));
        }
        done
    }

    #[expect(clippy::too_many_arguments, reason = "each is another half of a cell's facts")]
    fn fact(
        &self,
        ui: &mut Ui,
        cell: Rect,
        column: Column,
        seen: &Seen<'_>,
        view: &SchemaView,
        editing: &mut Period,
        look: &Look,
        asks: &mut Vec<Ask>,
    ) {
        let faint = ui.visuals().weak_text_color();
        let plain = if view.state == State::Slept {
            faint
        } else {
            ui.visuals().text_color()
        };
        match column {
            Column::State => cells::state(ui, cell, view, look),
            Column::Health => {
                let (word, _) = rows::health(&view.health);
                let color = match view.health {
                    Health::Ok => faint,
                    Health::Overrun => look::ink(Ink::Warn, look),
                    Health::ArbitrationFailed(_) | Health::Faulted(_) => look::ink(Ink::Bad, look),
                };
                ink::write(ui.painter(), cell, word, ink::font(), color);
            }
            Column::Period => {
                let period = view.period as f64 / 1e9;
                if let Some(period_s) = editing.show(ui, cell, &view.name, period, plain, look) {
                    asks.push(Ask::Act(Action::Period {
                        schema: view.name.clone(),
                        period_s,
                    }));
                }
            }
            Column::Measured => {
                let text = view
                    .measured
                    .map_or_else(|| "–".to_owned(), |measured| time::span(measured as f64 / 1e9));
                ink::write_right(ui.painter(), cell, &text, plain);
            }
            Column::Load => cells::load(ui, cell, view.load, look),
            Column::Overruns => {
                let color = if view.overruns == 0 {
                    faint
                } else {
                    look::ink(Ink::Warn, look)
                };
                ink::write_right(ui.painter(), cell, &view.overruns.to_string(), color);
            }
            Column::Buttons => cells::buttons(ui, cell, seen, view, asks),
        }
    }
}

/// All of a row in words.
fn spoken(view: &SchemaView) -> String {
    let (health, why) = rows::health(&view.health);
    let mut text = format!("{}, {}, {health}", view.name, bands::word(view.state),);
    if let Some(why) = why {
        text += &format!(": {why}");
    }
    if let Some(hold) = &view.operator {
        text += &format!(", {} by {}", hold.kind.word(), hold.by);
    }
    text
}

fn details(ui: &mut Ui, seen: &Seen<'_>, place: usize) {
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
    let (health, why) = rows::health(&view.health);
    let mut lines = vec![format!(
        "{}{}, {health}",
        bands::word(view.state),
        if view.authority { " with authority" } else { "" }
    )];
    lines.extend(why.map(|why| format!("Why: {why}")));
    if let Some(hold) = &view.operator {
        lines.push(format!("{} by {}", hold.kind.word(), hold.by));
    }
    lines.push(format!(
        "{} iterations, the longest {}; {} overruns, {} refused, {} faults",
        view.iterations,
        time::span(view.longest as f64 / 1e9),
        view.overruns,
        view.refused,
        view.faults
    ));
    lines.into_iter().for_each(|line| drop(ui.label(line)));
}

/// Marks a row that is selected or pointed at.
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
