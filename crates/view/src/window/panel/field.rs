//! Small widgets of a panel: values, toggles, sliders and choices. Numbers are shown in the user's units and
//! reported in SI units.

use eframe::egui::{self, RichText, Slider, Ui, vec2};
use jde_panel::{Ink, Touch};

use super::layout::ListLayout;
use crate::style::{self, Style};
use crate::tap::tap;

/// Minimum width of the labels of fields in a column, so that the fields align. In points.
const NAMES: f32 = 110.0;

/// The range of a slider.
pub(super) struct Range<'a> {
    pub(super) least: f64,
    pub(super) greatest: f64,
    pub(super) unit: &'a str,
}

/// Shows a number with its label.
pub(super) fn value(board: &ListLayout<'_>, ui: &mut Ui, label: &str, value: f64, unit: &str) {
    ui.horizontal(|ui| {
        name(ui, board.style, label, !board.beside);
        ui.label(RichText::new(board.style.units.show(value, unit)).monospace());
    });
}

pub(super) fn toggle(board: &mut ListLayout<'_>, ui: &mut Ui, id: &str, label: &str, said: bool) {
    let mut on = board.kept.shown(ui, id, f64::from(said)) != 0.0;
    if ui.checkbox(&mut on, label).clicked() {
        board.kept.moved(id, f64::from(said), f64::from(on));
        board.did(id, Touch::Toggled(on));
    }
}

pub(super) fn slider(
    board: &mut ListLayout<'_>,
    ui: &mut Ui,
    id: &str,
    label: &str,
    said: f64,
    range: &Range<'_>,
) {
    let (factor, unit) = board.style.units.convert(1.0, range.unit);
    let before = board.kept.shown(ui, id, said) * factor;
    let mut number = before;
    let suffix = if unit.is_empty() { unit } else { format!(" {unit}") };
    let (least, greatest) = (range.least * factor, range.greatest * factor);
    let (response, moved) = ui
        .horizontal(|ui| {
            let name = name(ui, board.style, label, !board.beside);
            let width = (ui.available_width() - 100.0).clamp(60.0, 260.0);
            ui.spacing_mut().slider_width = width;
            let slider = ui.add(Slider::new(&mut number, least..=greatest).suffix(suffix));
            let mut moved = slider.changed();
            let rail = slider.rect.left()..=slider.rect.left() + width;
            if let Some(at) = tap(ui, &slider).filter(|at| rail.contains(&at.x)) {
                let rail = f64::from(*rail.start())..=f64::from(*rail.end());
                number = egui::remap_clamp(f64::from(at.x), rail, least..=greatest);
                moved = true;
            }
            (slider.labelled_by(name.id), moved)
        })
        .inner;
    // A schema's value may be out of range. That the slider clamps it is not a move by the user.
    if moved && number != before {
        let number = (number / factor).clamp(range.least, range.greatest);
        board.kept.moved(id, said, number);
        board.did(id, Touch::Moved(number));
    } else if response.dragged() {
        // The slider keeps its value while the user holds it.
        board.kept.moved(id, said, before / factor);
    }
}

pub(super) fn choice(
    board: &mut ListLayout<'_>,
    ui: &mut Ui,
    id: &str,
    label: &str,
    options: &[String],
    said: u32,
) {
    let shown = board.kept.shown(ui, id, f64::from(said)) as usize;
    let mut taken = None;
    ui.horizontal(|ui| {
        let name = name(ui, board.style, label, !board.beside);
        egui::ComboBox::from_id_salt(id)
            .selected_text(options.get(shown).map_or("", String::as_str))
            .show_ui(ui, |ui| {
                for (place, option) in options.iter().enumerate() {
                    if ui.selectable_label(place == shown, option).clicked() {
                        taken = Some(place as u32);
                    }
                }
            })
            .response
            .labelled_by(name.id);
    });
    if let Some(place) = taken {
        board.kept.moved(id, f64::from(said), f64::from(place));
        board.did(id, Touch::Chose(place));
    }
}

/// Shows a label. In a column, it is at least [`NAMES`] wide; in a row, only as wide as its text.
fn name(ui: &mut Ui, style: &Style, label: &str, column: bool) -> egui::Response {
    let words = RichText::new(label).color(style::color_of(Ink::Plain, style).gamma_multiply(0.75));
    let left = ui.cursor().left();
    let response = ui.label(words);
    let lacks = NAMES - (ui.cursor().left() - left);
    if column && lacks > 0.0 {
        ui.allocate_space(vec2(lacks - ui.spacing().item_spacing.x, 0.0));
    }
    response
}
