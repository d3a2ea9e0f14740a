//! The configured period in its cell. A click opens a text field, Enter sets the period, Escape cancels. An
//! unreadable text shows an error.

use eframe::egui::{Color32, Id, Key, Popup, Rect, Role, Sense, TextEdit, Ui, WidgetInfo};
use jde_panel::Ink;

use super::paint;
use crate::style::{self, Style, time};

/// The period that the user is typing, if any.
#[derive(Debug, Default)]
pub(super) struct Period {
    typed: Option<Typed>,
}

#[derive(Debug)]
struct Typed {
    schema: String,
    text: String,
    trouble: Option<String>,
    fresh: bool,
}

impl Period {
    /// Starts to edit the period of a schema, in s.
    pub(super) fn begin(&mut self, schema: &str, period: f64) {
        self.typed = Some(Typed {
            schema: schema.to_owned(),
            text: time::setting(period),
            trouble: None,
            fresh: true,
        });
    }

    /// Draws the cell of a schema. Returns the new period in s when one is entered.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cell: Rect,
        schema: &str,
        period: f64,
        color: Color32,
        style: &Style,
    ) -> Option<f64> {
        match self.typed.as_mut().filter(|typed| typed.schema == schema) {
            Some(typed) => {
                let (entered, done) = typed.show(ui, cell, style);
                if done {
                    self.typed = None;
                }
                entered.filter(|entered| *entered != period)
            }
            None => {
                let response = ui.interact(cell, ui.scope_id().with((schema, "period")), Sense::click());
                response.widget_info(|| {
                    let name = format!("Period of {schema}: {}", time::setting(period));
                    WidgetInfo::labeled(Role::Button, true, name)
                });
                paint::write_right(ui.painter(), cell, &time::setting(period), color);
                if response.hovered() || response.has_focus() {
                    let line = [cell.left_bottom(), cell.right_bottom()]
                        .map(|at| at + eframe::egui::vec2(0.0, -3.0));
                    ui.painter()
                        .line_segment(line, ui.visuals().widgets.hovered.fg_stroke);
                }
                if response.clicked() {
                    self.begin(schema, period);
                }
                if response.hovered() {
                    response.on_hover_text("Click to enter another period: 50ms or 20Hz.");
                }
                None
            }
        }
    }
}

impl Typed {
    fn show(&mut self, ui: &mut Ui, cell: Rect, style: &Style) -> (Option<f64>, bool) {
        let id = Id::unique(("period", &self.schema));
        let edit = TextEdit::singleline(&mut self.text)
            .id(id)
            .font(paint::digits())
            .margin(eframe::egui::Margin::symmetric(3, 1));
        let response = ui
            .put(cell.expand2(eframe::egui::vec2(3.0, -1.0)), edit)
            .accessible_name(format!("New period of {}", self.schema));
        if std::mem::take(&mut self.fresh) {
            response.request_focus();
            let mut state = TextEdit::load_state(ui.ctx(), id).unwrap_or_default();
            let all = eframe::egui::text::CCursorRange::two(
                eframe::egui::text::CCursor::new(0),
                eframe::egui::text::CCursor::new(self.text.chars().count()),
            );
            state.cursor.set_char_range(Some(all));
            state.store(ui.ctx(), id);
            return (None, false);
        }
        if response.changed() {
            self.trouble = None;
        }
        if let Some(trouble) = &self.trouble {
            let message = eframe::egui::RichText::new(trouble).color(style::color_of(Ink::Bad, style));
            Popup::from_response(&response)
                .open(true)
                .show(|ui| ui.label(message));
        }
        if !response.lost_focus() {
            return (None, false);
        }
        if !ui.input(|input| input.key_pressed(Key::Enter)) {
            return (None, true);
        }
        match time::period(&self.text) {
            Ok(period) => (Some(period), true),
            Err(message) => {
                self.trouble = Some(message);
                response.request_focus();
                (None, false)
            }
        }
    }
}
