//! Cells of a row that are more than a text: the colored state, the load bar, and an operator's buttons.

use eframe::egui::{Align2, Color32, Rect, Shape, Stroke, Ui, pos2, vec2};
use jde_abi::describe::Kind;
use jde_link::message::Action;
use jde_panel::Ink;
use jde_records::snapshot::{HoldKind, SchemaView};

use super::input::{Input, Request};
use super::paint::{self, Icon};
use crate::style::{self, Style};

/// Width of a button, in points.
pub(super) const BUTTON: f32 = 21.0;

/// Draws the name of the state on its color, and a diamond if the schema has authority.
pub(super) fn state(ui: &Ui, cell: Rect, view: &SchemaView, style: &Style) {
    let chip = Rect::from_min_size(
        pos2(cell.left(), cell.top() + 3.0),
        vec2(66.0_f32.min(cell.width()), cell.height() - 6.0),
    );
    let fill = style::state(view.state, style);
    ui.painter().rect_filled(chip, 3.0, fill);
    let color = if bright(fill) {
        Color32::BLACK
    } else {
        Color32::WHITE
    };
    ui.painter().text(
        chip.center(),
        Align2::CENTER_CENTER,
        view.state.name(),
        paint::small(),
        color,
    );
    if view.authority {
        let at = pos2(chip.right() + 7.0, chip.center().y);
        let diamond = [(0.0, -4.0), (4.0, 0.0), (0.0, 4.0), (-4.0, 0.0)].map(|(x, y)| at + vec2(x, y));
        ui.painter().add(Shape::convex_polygon(
            diamond.to_vec(),
            style::color_of(Ink::Accent, style),
            Stroke::NONE,
        ));
    }
}

/// Whether black is more readable than white on a color.
fn bright(color: Color32) -> bool {
    let [red, green, blue, _] = color.to_array().map(f32::from);
    0.299 * red + 0.587 * green + 0.114 * blue > 128.0
}

/// Draws the load as a fraction of one processor core.
pub(super) fn load(ui: &Ui, cell: Rect, share: f64, style: &Style) {
    let bar = Rect::from_min_max(
        pos2(cell.left(), cell.bottom() - 5.0),
        pos2(cell.right(), cell.bottom() - 3.0),
    );
    let color = match share {
        share if share >= 0.9 => Ink::Bad,
        share if share >= 0.5 => Ink::Warn,
        _ => Ink::Good,
    };
    ui.painter()
        .rect_filled(bar, 0.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    let filled = bar.with_max_x(bar.left() + bar.width() * share.clamp(0.0, 1.0) as f32);
    ui.painter()
        .rect_filled(filled, 0.0, style::color_of(color, style));
    let text = if share > 0.0 && share < 0.01 {
        "<1%".to_owned()
    } else {
        format!("{:.0}%", share * 100.0)
    };
    let text_area = cell.with_max_y(cell.bottom() - 3.0);
    let color = if share < 0.005 {
        ui.visuals().weak_text_color()
    } else {
        ui.visuals().text_color()
    };
    paint::write_right(ui.painter(), text_area, &text, color);
}

/// Draws the buttons of an operator's actions (R14).
pub(super) fn buttons(ui: &Ui, cell: Rect, seen: &Input<'_>, view: &SchemaView, requests: &mut Vec<Request>) {
    let schema = || view.name.clone();
    let is_motor = view.kind == Kind::Motor;
    let accepts_requests = seen.accepts_requests;
    let list = [
        (
            Icon::Play,
            "Play",
            "Wake it and keep it awake, until it is released.",
            accepts_requests,
            view.is_held_to(HoldKind::Played),
            Request::Act(Action::Play { schema: schema() }),
        ),
        (
            Icon::Stop,
            "Stop",
            "Put it to sleep and keep it asleep, until it is released.",
            accepts_requests,
            view.is_held_to(HoldKind::Stopped),
            Request::Act(Action::Stop { schema: schema() }),
        ),
        (
            Icon::Force,
            "Force",
            "Make it win its group while it is awake, until it is released.",
            accepts_requests && is_motor,
            view.is_held_to(HoldKind::Forced),
            Request::Act(Action::Force { schema: schema() }),
        ),
        (
            Icon::Release,
            "Release",
            "Release it: the hierarchy controls it again.",
            accepts_requests && view.operator.is_some(),
            false,
            Request::Act(Action::Release { schema: schema() }),
        ),
        (
            Icon::Panel,
            "Panel of",
            "Open the panel of the schema.",
            view.panel,
            false,
            Request::Panel(schema()),
        ),
    ];
    for (number, (icon, verb, tip, enabled, pressed, request)) in list.into_iter().enumerate() {
        let rect = Rect::from_min_size(
            pos2(cell.left() + number as f32 * BUTTON, cell.top()),
            vec2(BUTTON, cell.height()),
        );
        let name = format!("{verb} {}", view.name);
        let id = ui.scope_id().with((&view.name, verb));
        if paint::button(ui, rect, id, icon, (&name, tip), (enabled, pressed)).clicked() {
            requests.push(request);
        }
    }
}
