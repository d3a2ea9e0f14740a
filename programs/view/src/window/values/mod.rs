//! Variables by schema: the newest value, its age and its writer. Modulations can be edited in place (R8,
//! R14). It subscribes only to visible rows. It writes only modulations: commands belong to the schemas.

mod cell;
mod edit;
mod rows;
mod tuned;
mod variable;

use std::collections::{HashMap, HashSet};

use eframe::egui::{self, RichText, TextWrapMode, Ui};
use egui_extras::{Column, TableBuilder};
use jde_link::Rate;
use jde_link::message::Action;
use jde_panel::Ink;
use jde_records::snapshot::{HoldKind, SchemaView};

use super::Window;
use super::scope::field;
use crate::session::WindowSession;
use crate::style::{self, Style};
use edit::Edit;
use rows::{RowKind, ValueRow};
use tuned::TunedList;
use variable::VariableState;

/// Rate of visible rows: as fast as numbers can be read.
const RATE: Rate = Rate::Hz(5);

/// The window.
#[derive(Default)]
pub(crate) struct Values {
    search: String,
    only_modulations: bool,
    /// Schemas that are folded.
    folded: HashSet<String>,
    /// Variables and fields that are unfolded, by their full paths.
    unfolded: HashSet<String>,
    seen: HashMap<String, VariableState>,
    edits: HashMap<String, Edit>,
    tuned: TunedList,
}

impl Values {
    /// Opens the window with its saved state.
    pub(crate) fn open(kept: &serde_json::Value) -> Self {
        let set = |name: &str| serde_json::from_value(kept[name].clone()).unwrap_or_default();
        Self {
            folded: set("folded"),
            unfolded: set("unfolded"),
            only_modulations: kept["only-modulations"].as_bool().unwrap_or_default(),
            ..Self::default()
        }
    }

    fn head(&mut self, ui: &mut Ui, session: &WindowSession, style: &Style) {
        ui.horizontal(|ui| {
            let name = ui.label("Search");
            ui.add(
                egui::TextEdit::singleline(&mut self.search)
                    .hint_text("name, type or schema")
                    .desired_width(180.0),
            )
            .labelled_by(name.id);
            ui.checkbox(&mut self.only_modulations, "Modulations only")
                .on_hover_text("Inputs that fathers and operators may change while schemas run");
            ui.checkbox(&mut self.tuned.is_only, "Tuned only")
                .on_hover_text("Modulations that differ from the application's file");
        });
        self.tuned.show(ui, session, style);
        ui.add_space(2.0);
    }

    fn schema(&mut self, ui: &mut Ui, session: &WindowSession, style: &Style, name: &str) {
        let folded = self.folded.contains(name);
        if cell::fold(ui, name, !folded) {
            if folded {
                self.folded.remove(name);
            } else {
                self.folded.insert(name.to_owned());
            }
        }
        let (spot, _) = ui.allocate_exact_size(egui::Vec2::splat(8.0), egui::Sense::hover());
        let view = session.view(name);
        if let Some(view) = view {
            let color = style::state(view.state, style);
            ui.painter().circle_filled(spot.center(), 4.0, color);
        }
        let title = ui.label(RichText::new(name).strong());
        if let Some(schema) = session.schema(name) {
            title.on_hover_text(format!("{}: {}", schema.type_name, schema.doc));
        }
    }

    /// Shows the operator that modulates a schema, and a button that releases it.
    fn held(ui: &mut Ui, session: &WindowSession, style: &Style, name: &str) {
        let holds = session.view(name).into_iter().flat_map(SchemaView::holds);
        let holds = holds.filter(|hold| hold.kind == HoldKind::Modulated);
        let by: Vec<_> = holds.map(|hold| hold.by.as_str()).collect();
        if by.is_empty() {
            return;
        }
        let color = style::color_of(Ink::Warn, style);
        ui.label(RichText::new(format!("modulated by {}", by.join(", "))).color(color));
        let mine = by == [jde_link::operator()];
        let (action, hint) = if mine {
            (
                "Reset",
                "Release your changes: the father's values are in force again",
            )
        } else {
            ("Release", "Undo the changes of all operators")
        };
        let button = ui.small_button(action).on_hover_text(hint);
        button
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{action} {name}")));
        if button.clicked() {
            let schema = name.to_owned();
            session.act(if mine {
                Action::LetGo { schema }
            } else {
                Action::Release { schema }
            });
        }
    }

    fn row(
        &mut self,
        table: &mut egui_extras::TableRow<'_, '_>,
        session: &WindowSession,
        style: &Style,
        row: &ValueRow,
    ) {
        let name = match &row.what {
            RowKind::Schema(name) => {
                table.col(|ui| self.schema(ui, session, style, name));
                table.col(|ui| Self::held(ui, session, style, name));
                (0..4).for_each(|_| drop(table.col(|_| {})));
                return;
            }
            RowKind::Variable(name) | RowKind::Field { variable: name, .. } => name,
        };
        let Some(info) = session.variables().iter().find(|variable| variable.name == *name) else {
            return;
        };
        let sample = session.value(name, RATE);
        let seen = self
            .seen
            .entry(name.clone())
            .or_insert_with(|| VariableState::new(info));
        if let Some(sample) = &sample {
            seen.take(sample);
        }
        let path = row.path();
        table.col(|ui| {
            ui.add_space(14.0 * row.depth as f32);
            let open = self.unfolded.contains(&path);
            if row.foldable {
                if cell::fold(ui, &path, open) {
                    if open {
                        self.unfolded.remove(&path);
                    } else {
                        self.unfolded.insert(path.clone());
                    }
                }
            } else {
                ui.add_space(16.0);
            }
            cell::name(ui, style, row, info);
        });
        let trouble = session.trouble(name);
        table.col(|ui| {
            if let Some(trouble) = &trouble {
                ui.label(RichText::new(trouble).color(style::color_of(Ink::Bad, style)));
            } else if info.access == "modulation"
                && !info.fixed
                && row.leaf.is_some()
                && session.can_set(&info.owner)
            {
                edit::show(ui, session, style, &mut self.edits, row, info, seen);
                if let (RowKind::Variable(_), Some(sample)) = (&row.what, &sample) {
                    self.tuned.show_back(ui, session, style, info, sample);
                }
            } else if session.is_over() && !seen.is_known() {
                ui.label(RichText::new("not received").color(style::color_of(Ink::Faint, style)))
                    .on_hover_text("The application ended before this value was on the screen.");
            } else {
                cell::value(ui, style, row, info, seen);
            }
        });
        let is_number = seen
            .value_type()
            .is_some_and(|of| field::find(of, &row.names().join(".")).is_ok());
        table.col(|ui| {
            if is_number && cell::plot(ui, &path) {
                session.plot(path.clone());
            }
        });
        if matches!(row.what, RowKind::Field { .. }) {
            (0..3).for_each(|_| drop(table.col(|_| {})));
            return;
        }
        let faint = |text: String| RichText::new(text).color(style::color_of(Ink::Faint, style));
        table.col(|ui| drop(ui.label(faint(seen.age(session.now())))));
        table.col(|ui| drop(ui.label(faint(seen.rate()))));
        table.col(|ui| drop(ui.label(faint(seen.writer().to_owned()))));
    }
}

impl Window for Values {
    fn show(&mut self, ui: &mut Ui, session: &WindowSession, style: &Style) {
        self.head(ui, session, style);
        let rows = rows::of(session, self);
        if rows.is_empty() {
            let nothing = if session.variables().is_empty() {
                "This application has no variables."
            } else if self.tuned.is_only {
                "No modulation differs from the application's file."
            } else {
                "No variable matches the search."
            };
            ui.label(RichText::new(nothing).color(style::color_of(Ink::Faint, style)));
            return;
        }
        ui.style_mut().wrap_mode = Some(TextWrapMode::Truncate);
        let line = ui.spacing().interact_size.y;
        TableBuilder::new(ui)
            .striped(true)
            .resizable(true)
            .auto_shrink(false)
            .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
            .column(Column::initial(210.0).at_least(80.0).clip(true))
            .column(Column::remainder().at_least(120.0).clip(true))
            .column(Column::exact(18.0))
            .column(Column::initial(52.0).at_least(40.0).clip(true))
            .column(Column::initial(58.0).at_least(40.0).clip(true))
            .column(Column::initial(90.0).at_least(40.0).clip(true))
            .header(line, |mut header| {
                for (title, hint) in [
                    (
                        "Variable",
                        "Fold and unfold with the triangles; a right click copies the name",
                    ),
                    ("Value", "The newest value; modulations can be changed in place"),
                    ("", "A click plots the number in the oscilloscope"),
                    ("Age", "Since it was measured or written"),
                    ("Rate", "Values that this window receives per second, at most 5"),
                    ("Writer", "The schema or operator that wrote the value"),
                ] {
                    header.col(|ui| drop(ui.strong(title).on_hover_text(hint)));
                }
            })
            .body(|body| {
                body.rows(line, rows.len(), |mut table| {
                    if let Some(row) = rows.get(table.index()) {
                        self.row(&mut table, session, style, row);
                    }
                });
            });
    }

    fn keep(&self) -> serde_json::Value {
        serde_json::json!({
            "folded": self.folded,
            "unfolded": self.unfolded,
            "only-modulations": self.only_modulations,
        })
    }
}
