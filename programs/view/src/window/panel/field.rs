//! Small widgets of a panel: values, toggles, sliders and choices. Numbers are shown in the user's units and
//! reported in SI units.

use eframe::egui::{self, RichText, Slider, Ui, vec2};
use jde_panel::{Ink, Touch};

use super::layout::ListLayout;
use crate::style::{self, Style};
use crate::tap::tap;

/// Minimum width of the labels of fields in a column, so that the fields align. In points.
const MIN_LABEL_WIDTH: f32 = 110.0;

/// The range of a slider.
pub(super) struct Range<'a> {
    pub(super) least: f64,
    pub(super) greatest: f64,
    pub(super) unit: &'a str,
}

/// Shows a number with its label.
pub(super) fn value(layout: &ListLayout<'_>, ui: &mut Ui, label: &str, value: f64, unit: &str) {
    ui.horizontal(|ui| {
        name(ui, layout.style, label, !layout.beside);
        // A whole number without a unit is a count.
        let text = match unit.is_empty() && value.fract() == 0.0 {
            true => format!("{value:.0}"),
            false => layout.style.units.show(value, unit),
        };
        ui.label(RichText::new(text).monospace());
    });
}

pub(super) fn toggle(layout: &mut ListLayout<'_>, ui: &mut Ui, id: &str, label: &str, reported: bool) {
    let mut on = layout.kept.shown(ui, id, f64::from(reported)) != 0.0;
    if ui.checkbox(&mut on, label).clicked() {
        layout.kept.moved(id, f64::from(reported), f64::from(on));
        layout.record_gesture(id, Touch::Toggled(on));
    }
}

pub(super) fn slider(
    layout: &mut ListLayout<'_>,
    ui: &mut Ui,
    id: &str,
    label: &str,
    reported: f64,
    range: &Range<'_>,
) {
    let (factor, unit) = layout.style.units.convert(1.0, range.unit);
    let before = layout.kept.shown(ui, id, reported) * factor;
    let mut number = before;
    let suffix = if unit.is_empty() { unit } else { format!(" {unit}") };
    let (least, greatest) = (range.least * factor, range.greatest * factor);
    let (response, moved) = ui
        .horizontal(|ui| {
            let name = name(ui, layout.style, label, !layout.beside);
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
        layout.kept.moved(id, reported, number);
        layout.record_gesture(id, Touch::Moved(number));
    } else if response.dragged() {
        // The slider keeps its value while the user holds it.
        layout.kept.moved(id, reported, before / factor);
    }
}

pub(super) fn choice(
    layout: &mut ListLayout<'_>,
    ui: &mut Ui,
    id: &str,
    label: &str,
    options: &[String],
    reported: u32,
) {
    let shown = layout.kept.shown(ui, id, f64::from(reported)) as usize;
    let mut chosen = None;
    ui.horizontal(|ui| {
        let name = name(ui, layout.style, label, !layout.beside);
        egui::ComboBox::from_id_salt(id)
            .selected_text(options.get(shown).map_or("", String::as_str))
            .show_ui(ui, |ui| {
                for (place, option) in options.iter().enumerate() {
                    if ui.selectable_label(place == shown, option).clicked() {
                        chosen = Some(place as u32);
                    }
                }
            })
            .response
            .labelled_by(name.id);
    });
    if let Some(place) = chosen {
        layout.kept.moved(id, f64::from(reported), f64::from(place));
        layout.record_gesture(id, Touch::Chose(place));
    }
}

/// Shows a label. In a column, it is at least [`MIN_LABEL_WIDTH`] wide; in a row, only as wide as its text.
fn name(ui: &mut Ui, style: &Style, label: &str, column: bool) -> egui::Response {
    let text = RichText::new(label).color(style::color_of(Ink::Plain, style).gamma_multiply(0.75));
    let left = ui.cursor().left();
    let response = ui.label(text);
    let missing = MIN_LABEL_WIDTH - (ui.cursor().left() - left);
    if column && missing > 0.0 {
        ui.allocate_space(vec2(missing - ui.spacing().item_spacing.x, 0.0));
    }
    response
}
