//! An operator's actions on a schema (R14), in words: below the rows for the selected schema, and in the menu of each row.
//! No single click on a row acts.

use eframe::egui::{Button, Label, RichText, Ui, vec2};
use jde_abi::describe::Kind;
use jde_link::message::Action;
use jde_records::snapshot::{HoldKind, SchemaView};

use super::input::{Input, Request};
use super::{OPERATE_HEIGHT, Scope};

/// The least side of a button that moves or stops a robot, in points.
const TARGET: f32 = 32.0;
/// The width below which the actions may not fit into one line, in points.
const NARROW_WIDTH: f32 = 500.0;

impl Scope {
    /// Shows the actions on the selected schema, with their keys while these act.
    pub(super) fn operate(&mut self, ui: &mut Ui, seen: &Input<'_>, requests: &mut Vec<Request>) {
        let keys = self.focused && self.has_row;
        let line = |ui: &mut Ui| {
            ui.set_min_height(TARGET);
            let selected = |view: &&SchemaView| self.selected.as_ref() == Some(&view.name);
            let Some(view) = seen.snapshot.schemas.iter().find(selected) else {
                ui.weak("Select a schema to play, stop, force or release it.");
                return;
            };
            let width = (0.3 * ui.available_width()).min(180.0);
            ui.scope(|ui| {
                ui.set_max_width(width);
                ui.add(Label::new(RichText::new(&view.name).strong()).truncate());
            });
            actions(ui, seen, view, keys, requests);
        };
        if ui.available_width() >= NARROW_WIDTH {
            ui.horizontal(line);
            self.operate_height = OPERATE_HEIGHT;
            return;
        }
        let shown = ui.horizontal_wrapped(line).response;
        let height = (shown.rect.height() + OPERATE_HEIGHT - TARGET).max(OPERATE_HEIGHT);
        if (height - self.operate_height).abs() > 0.5 {
            self.operate_height = height;
            ui.ctx().request_repaint();
        }
    }
}

/// Shows a button for each action; with `keys`, also the key of each.
pub(super) fn actions(
    ui: &mut Ui,
    seen: &Input<'_>,
    view: &SchemaView,
    keys: bool,
    requests: &mut Vec<Request>,
) {
    let schema = || view.name.clone();
    let accepts = seen.accepts_requests;
    let list = [
        (
            "Play",
            "P",
            "Wake it and keep it awake, until it is released.",
            accepts,
            view.is_held_to(HoldKind::Played),
            Request::Act(Action::Play { schema: schema() }),
        ),
        (
            "Stop",
            "S",
            "Put it to sleep and keep it asleep, until it is released.",
            accepts,
            view.is_held_to(HoldKind::Stopped),
            Request::Act(Action::Stop { schema: schema() }),
        ),
        (
            "Force",
            "F",
            "Make it win its group while it is awake, until it is released.",
            accepts && view.kind == Kind::Motor,
            view.is_held_to(HoldKind::Forced),
            Request::Act(Action::Force { schema: schema() }),
        ),
        (
            "Release",
            "R",
            "Release it: the hierarchy controls it again.",
            accepts && view.operator.is_some(),
            false,
            Request::Act(Action::Release { schema: schema() }),
        ),
        (
            "Panel",
            "",
            "Open the panel of the schema.",
            view.panel,
            false,
            Request::Panel(schema()),
        ),
    ];
    for (verb, key, tip, enabled, pressed, request) in list {
        let text = match keys && enabled && !key.is_empty() {
            true => format!("{verb} ({key})"),
            false => verb.to_owned(),
        };
        let button = Button::selectable(pressed, text)
            .frame_when_inactive(true)
            .min_size(vec2(TARGET, TARGET));
        let response = ui.add_enabled(enabled, button).on_hover_text(tip);
        if response
            .accessible_name(format!("{verb} {}", view.name))
            .clicked()
        {
            requests.push(request);
        }
    }
}
