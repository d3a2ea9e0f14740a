//! Cells of a row that are more than a text: the colored state, and the load bar.

use eframe::egui::{Align2, Rect, Shape, Stroke, Ui, pos2, vec2};
use jde_panel::Ink;
use jde_records::snapshot::SchemaView;
use jde_timeline::state_word;

use super::paint;
use crate::style::{self, Style};

/// Draws the name of the state on its color, and a diamond if the schema has authority.
pub(super) fn state(ui: &Ui, cell: Rect, view: &SchemaView, style: &Style) {
    let chip = Rect::from_min_size(
        pos2(cell.left(), cell.top() + 3.0),
        vec2(66.0_f32.min(cell.width()), cell.height() - 6.0),
    );
    let fill = style::state(view.state, style);
    ui.painter().rect_filled(chip, 3.0, fill);
    let color = style::text_on(fill);
    ui.painter().text(
        chip.center(),
        Align2::CENTER_CENTER,
        state_word(view),
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
