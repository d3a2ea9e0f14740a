//! Editing a modulation in place: by typing with its unit, by a slider, or by a checkbox. An error is shown
//! beside it.

use std::collections::HashMap;

use eframe::egui::{self, Key, RichText, Slider, TextEdit, Ui, vec2};
use jde_board::value::Value;
use jde_link::message::{Action, VariableInfo};
use jde_panel::Ink;
use serde_json::json;

use super::cell;
use super::rows::{Leaf, ValueRow};
use super::variable::VariableState;
use crate::session::{OrderOutcome, WindowSession};
use crate::style::{self, Style};

/// The state of editing one value.
#[derive(Default)]
pub(super) struct Edit {
    /// The text in the field while it has the focus.
    text: Option<String>,
    /// The value that the slider ordered, and the sequence number then. It is shown until the order is
    /// accepted or a newer value arrives.
    ordered: Option<(f64, u64)>,
    outcome: OrderOutcome,
    error: Option<String>,
}

/// Shows an editor for the value of a row.
pub(super) fn show(
    ui: &mut Ui,
    session: &WindowSession,
    style: &Style,
    edits: &mut HashMap<String, Edit>,
    row: &ValueRow,
    info: &VariableInfo,
    seen: &VariableState,
) {
    let Some((leaf, unit)) = &row.leaf else { return };
    let names = row.names();
    let path = row.path();
    let edit = edits.entry(path.clone()).or_default();
    let value = seen.part(names);
    let order = |edit: &mut Edit, value: serde_json::Value| {
        edit.error = None;
        edit.outcome = session.order(Action::Modulate {
            schema: info.owner.clone(),
            variable: info.variable.clone(),
            value: within(names, value),
        });
    };
    match (leaf, value) {
        (Leaf::Flag, Some(Value::Bool(on))) => {
            let label = if *on { "yes" } else { "no" };
            let mut on = *on;
            let tick = ui.checkbox(&mut on, label);
            tick.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, on, &path));
            if tick.changed() {
                order(edit, json!(on));
            }
        }
        (Leaf::Flag, _) => cell::value(ui, style, row, info, seen),
        (Leaf::Number | Leaf::Whole | Leaf::Text, _) => {
            if let (Leaf::Number, Some(Value::Float(number)), Some(least), Some(greatest)) =
                (leaf, value, info.range.least, info.range.greatest)
                && names.is_empty()
            {
                let mut at = match edit.ordered {
                    Some((ordered, sequence))
                        if seen.sequence() <= sequence && edit.outcome.get() != Some(&Ok(())) =>
                    {
                        ordered
                    }
                    _ => *number,
                };
                // A logarithmic slider gives each order of magnitude equal space, from milliseconds to
                // minutes.
                let wide = least > 0.0 && greatest > 100.0 * least;
                ui.spacing_mut().slider_width = 80.0;
                let slider = ui.add(
                    Slider::new(&mut at, least..=greatest)
                        .show_value(false)
                        .logarithmic(wide),
                );
                slider.widget_info(|| egui::WidgetInfo::slider(true, at, format!("slide {path}")));
                if slider.changed() {
                    edit.ordered = Some((at, seen.sequence()));
                    order(edit, json!(at));
                }
            }
            let shown = value.map_or_else(String::new, |value| cell::line(value, unit, style));
            let mut text = edit.text.clone().unwrap_or_else(|| shown.clone());
            let field = ui.add_sized(
                vec2(96.0, ui.available_height()),
                // The slider before it appears with the first value. A fixed id keeps the focus in the field
                // then.
                TextEdit::singleline(&mut text)
                    .id_salt(&path)
                    .font(egui::TextStyle::Monospace),
            );
            let field = field
                .accessible_name(path.clone())
                .on_hover_text("Type a value and press Enter; Escape cancels");
            if field.gained_focus() || field.changed() {
                edit.text = Some(text.clone());
            }
            if field.lost_focus() {
                if ui.input(|input| input.key_pressed(Key::Enter)) && text != shown {
                    match read(*leaf, &text, unit, style) {
                        Ok(number) if refused(info, names, &number) => {
                            edit.error = Some(format!("enter {}", bounds(info, unit, style)));
                        }
                        Ok(value) => order(edit, value),
                        Err(reason) => edit.error = Some(reason),
                    }
                }
                edit.text = None;
            }
        }
    }
    let error = edit.error.as_deref().or(match edit.outcome.get() {
        Some(Err(reason)) => Some(reason.as_str()),
        Some(Ok(())) | None => None,
    });
    if let Some(error) = error {
        let color = style::color_of(Ink::Bad, style);
        ui.label(RichText::new(error).color(color)).on_hover_text(error);
    }
}

/// Wraps the value of a field in its structures. Omitted fields keep their values.
fn within(names: &[String], value: serde_json::Value) -> serde_json::Value {
    names
        .iter()
        .rev()
        .fold(value, |value, name| json!({ name.as_str(): value }))
}

fn refused(info: &VariableInfo, names: &[String], value: &serde_json::Value) -> bool {
    names.is_empty() && value.as_f64().is_some_and(|number| !info.range.contains(number))
}

/// The range as text, in the user's units.
fn bounds(info: &VariableInfo, unit: &str, style: &Style) -> String {
    let show = |number| style.units.show(number, unit);
    match (info.range.least, info.range.greatest) {
        (Some(least), Some(greatest)) => format!("{} to {}", show(least), show(greatest)),
        (Some(least), None) => format!("{} or more", show(least)),
        (None, Some(greatest)) => format!("{} or less", show(greatest)),
        (None, None) => "any number".to_owned(),
    }
}

/// Parses the typed text. A number without a unit is in the displayed unit; the SI unit is accepted too.
/// Returns the value in SI units.
fn read(leaf: Leaf, text: &str, unit: &str, style: &Style) -> Result<serde_json::Value, String> {
    let text = text.trim();
    if leaf == Leaf::Text {
        return Ok(json!(text));
    }
    let (factor, shown) = style.units.convert(1.0, unit);
    let end = text
        .find(|letter: char| letter.is_alphabetic() && !matches!(letter, 'e' | 'E') || letter == '°')
        .unwrap_or(text.len());
    let (number, typed_unit) = (text[..end].trim(), text[end..].trim());
    if leaf == Leaf::Whole {
        return number
            .parse::<i64>()
            .ok()
            .filter(|_| typed_unit.is_empty())
            .map(|number| json!(number))
            .ok_or_else(|| format!("`{text}` is not a whole number"));
    }
    let number: f64 = number
        .parse()
        .ok()
        .filter(|number: &f64| number.is_finite())
        .ok_or_else(|| format!("`{text}` is not a number"))?;
    if typed_unit.is_empty() || typed_unit == shown {
        Ok(json!(number / factor))
    } else if typed_unit == unit {
        Ok(json!(number))
    } else if shown.is_empty() {
        Err(format!("it has no unit; remove `{typed_unit}`"))
    } else if shown == unit {
        Err(format!("its unit is {unit}, not {typed_unit}"))
    } else {
        Err(format!("its unit is {shown} or {unit}, not {typed_unit}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::style::Units;

    fn read(leaf: Leaf, text: &str, unit: &str) -> Result<serde_json::Value, String> {
        let style = Style {
            dark: true,
            units: Units::default(),
        };
        super::read(leaf, text, unit, &style)
    }

    #[test]
    fn a_number_is_parsed_in_the_displayed_unit_or_in_its_own() {
        let half_turn = json!(std::f64::consts::PI);
        assert_eq!(read(Leaf::Number, "180", "rad"), Ok(half_turn.clone()));
        assert_eq!(read(Leaf::Number, "180 deg", "rad"), Ok(half_turn));
        assert_eq!(read(Leaf::Number, "2 rad", "rad"), Ok(json!(2.0)));
        assert_eq!(read(Leaf::Number, " 1e-3 ", ""), Ok(json!(0.001)));
        assert_eq!(read(Leaf::Whole, "-4", ""), Ok(json!(-4)));
    }

    #[test]
    fn invalid_numbers_are_refused_with_a_message() {
        let error = |leaf, text, unit| read(leaf, text, unit).unwrap_err();
        assert_eq!(error(Leaf::Number, "fast", "m/s"), "`fast` is not a number");
        assert_eq!(error(Leaf::Number, "3 kg", "m"), "its unit is m, not kg");
        assert_eq!(error(Leaf::Number, "3 m", "rad"), "its unit is deg or rad, not m");
        assert_eq!(error(Leaf::Number, "3 m", ""), "it has no unit; remove `m`");
        assert_eq!(error(Leaf::Whole, "1.5", ""), "`1.5` is not a whole number");
    }

    #[test]
    fn a_field_is_written_as_the_part_that_changes() {
        let names = ["linear".to_owned(), "x".to_owned()];
        assert_eq!(within(&names, json!(0.2)), json!({ "linear": { "x": 0.2 } }));
    }
}
