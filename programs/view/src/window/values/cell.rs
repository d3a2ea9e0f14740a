//! The contents of a row's cells: the triangle, the name, the value.

use std::fmt::Write as _;

use eframe::egui::{self, RichText, Sense, Ui, WidgetInfo, pos2, vec2};
use jde_board::value::Value;
use jde_link::message::VariableInfo;
use jde_panel::Ink;

use super::rows::{RowKind, ValueRow};
use super::variable::VariableState;
use crate::style::{self, Style};

/// Maximum length of a displayed list or structure, in bytes; the rest is cut off.
const MAX_SHOWN_BYTES: usize = 160;

/// Shows the triangle that folds and unfolds. Returns whether it was clicked.
pub(super) fn fold(ui: &mut Ui, name: &str, open: bool) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(12.0, 16.0), Sense::click());
    let action = if open { "fold" } else { "unfold" };
    response.widget_info(|| {
        WidgetInfo::labeled(egui::Role::DisclosureTriangle, true, format!("{action} {name}"))
    });
    let (middle, radius) = (rect.center(), 4.0);
    let corners = if open {
        [(-1.0, -0.6), (1.0, -0.6), (0.0, 0.9)]
    } else {
        [(-0.6, -1.0), (-0.6, 1.0), (0.9, 0.0)]
    };
    let corners = corners.map(|(x, y)| pos2(middle.x + radius * x, middle.y + radius * y));
    let color = ui.style().interact(&response).fg_stroke.color;
    let shape = egui::Shape::convex_polygon(corners.to_vec(), color, egui::Stroke::NONE);
    ui.painter().add(shape);
    response.clicked()
}

/// Shows the name, with the details of the variable on hover.
pub(super) fn name(ui: &mut Ui, style: &Style, row: &ValueRow, info: &VariableInfo) {
    let color = match (&row.what, info.access.as_str()) {
        (RowKind::Variable(_), "modulation") => Ink::Accent,
        (RowKind::Variable(_), "command") => Ink::Warn,
        _ => Ink::Plain,
    };
    let text = RichText::new(row.name(info)).color(style::color_of(color, style));
    let label = ui.add(egui::Label::new(text).sense(Sense::click()).selectable(false));
    let mut hint = row.path();
    // Writing to a string cannot fail.
    let _ = match &row.what {
        RowKind::Variable(_) => write!(hint, "\n{} of type {}", info.access, info.type_name),
        RowKind::Schema(_) | RowKind::Field { .. } => Ok(()),
    };
    if let RowKind::Variable(_) = row.what {
        if !info.unit.is_empty() {
            let _ = write!(hint, ", in {}", info.unit);
        }
        if info.range.least.is_some() || info.range.greatest.is_some() {
            let _ = write!(hint, ", {}", info.range);
        }
        if info.fixed {
            hint.push_str("\nread only when the schema wakes");
        }
    }
    if !row.doc.is_empty() {
        let _ = write!(hint, "\n{}", row.doc);
    }
    let path = row.path();
    label.on_hover_text(hint).context_menu(|ui| {
        if ui.button("Copy name").clicked() {
            ui.ctx().copy_text(path.clone());
            ui.close();
        }
    });
}

/// Shows the button that adds a number to the oscilloscope. Returns whether it was clicked.
pub(super) fn plot(ui: &mut Ui, name: &str) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(16.0, 16.0), Sense::click());
    let response = response.on_hover_text("Show it over time, in the oscilloscope");
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, format!("plot {name}")));
    let color = ui.style().interact(&response).fg_stroke;
    let corner = |x: f32, y: f32| rect.center() + vec2(x, y);
    let axes = [corner(-6.0, -6.0), corner(-6.0, 5.0), corner(6.0, 5.0)];
    let curve = [(-4.0, 2.0), (-1.5, -2.0), (1.0, 1.0), (5.0, -5.0)].map(|(x, y)| corner(x, y));
    ui.painter()
        .line(axes.to_vec(), egui::Stroke::new(1.0, color.color));
    ui.painter()
        .line(curve.to_vec(), egui::Stroke::new(1.5, color.color));
    response.clicked()
}

/// Shows the value in one line, in the user's units.
pub(super) fn value(ui: &mut Ui, style: &Style, row: &ValueRow, info: &VariableInfo, seen: &VariableState) {
    let names = row.names();
    let faint = |text: &str| RichText::new(text).color(style::color_of(Ink::Faint, style));
    match seen.part(names) {
        Some(value) => {
            let unit = row.leaf.as_ref().map_or("", |(_, unit)| unit.as_str());
            ui.label(RichText::new(line(value, unit, style)).monospace());
        }
        None if !seen.is_known() => drop(ui.label(faint("..."))),
        None => {
            ui.label(faint("no value")).on_hover_text(format!(
                "{} has not written it yet, or has retracted it",
                info.owner
            ));
        }
    }
}

/// Formats a value in one line.
pub(super) fn line(value: &Value, unit: &str, style: &Style) -> String {
    let mut text = String::new();
    append(&mut text, value, unit, style);
    text
}

fn append(into: &mut String, value: &Value, unit: &str, style: &Style) {
    if into.len() > MAX_SHOWN_BYTES {
        if !into.ends_with('…') {
            into.push('…');
        }
        return;
    }
    match value {
        Value::Bool(flag) => into.push_str(if *flag { "yes" } else { "no" }),
        Value::Int(number) => into.push_str(&number.to_string()),
        Value::UInt(number) => into.push_str(&number.to_string()),
        Value::Float(number) => into.push_str(&style.units.show(*number, unit)),
        Value::Text(text) => into.push_str(text),
        Value::List(list) => {
            let _ = write!(into, "{} [", list.len());
            for (index, value) in list.iter().enumerate() {
                into.push_str(if index == 0 { "" } else { "  " });
                append(into, value, unit, style);
                if into.len() > MAX_SHOWN_BYTES {
                    return;
                }
            }
            into.push(']');
        }
        Value::Map(fields) => {
            for (index, (name, value)) in fields.iter().enumerate() {
                into.push_str(if index == 0 { "" } else { "  " });
                let _ = write!(into, "{name} ");
                let inner = matches!(value, Value::Map(_));
                into.push_str(if inner { "(" } else { "" });
                append(into, value, "", style);
                into.push_str(if inner { ")" } else { "" });
                if into.len() > MAX_SHOWN_BYTES {
                    return;
                }
            }
        }
    }
}
