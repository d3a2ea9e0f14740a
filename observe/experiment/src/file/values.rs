//! Values of an experiment file: times that may be 0, labels in results, and the text of a value as the file
//! has it.

use jde_app::units::quantity;
use jde_core::Nanos;
use jde_document::section::{Node, number, report_wrong_shape};
use jde_document::{FaultReport, quote};
use serde_json::Value;
use toml::de::DeValue;

/// Reads a time from the start of a drive, ns; it may be 0.
pub(super) fn moment(report: &mut FaultReport, what: &str, node: &Node) -> Option<Nanos> {
    const EXPECTED: &str = "a time such as \"20s\", or a number of seconds";
    let seconds = match node.get_ref().as_str() {
        Some(text) => {
            let Ok(seconds) = quantity(text, "s") else {
                let message = format!("{what} is {}, which is not a time", quote(text));
                report
                    .fault(&node.span(), message)
                    .advise(format!("write {EXPECTED}"));
                return None;
            };
            Some(seconds)
        }
        None => number(node.get_ref()),
    };
    let Some(seconds) = seconds else {
        report_wrong_shape(report, what, EXPECTED, node);
        return None;
    };
    let nanos = seconds * 1e9;
    if !(0.0..1e18).contains(&nanos) {
        report.fault(
            &node.span(),
            format!("{what} must be 0 or more, and less than 30 years"),
        );
        return None;
    }
    Some(nanos.round() as Nanos)
}

/// Returns the value in results: numbers, texts and truth values as they are, anything else as the file
/// writes it.
pub(super) fn label(text: &str, node: &Node) -> Value {
    match node.get_ref() {
        DeValue::String(text) => text.as_ref().into(),
        DeValue::Boolean(boolean) => (*boolean).into(),
        DeValue::Integer(_) | DeValue::Float(_) => number(node.get_ref()).map_or(Value::Null, |number| {
            if number.fract() == 0.0 && number.abs() < 9e15 {
                (number as i64).into()
            } else {
                number.into()
            }
        }),
        DeValue::Datetime(_) | DeValue::Array(_) | DeValue::Table(_) => source(text, node).into(),
    }
}

/// Returns the value as the file writes it.
pub(super) fn source(text: &str, node: &Node) -> String {
    text.get(node.span()).unwrap_or_default().to_owned()
}
