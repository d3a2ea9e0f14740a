//! Values given outside a file, as options and to tools: TOML, or a text without its quotes. Checks no range.

use std::path::Path;

use jde_abi::describe::{Form, Type};
use jde_board::value::Value;
use toml::Spanned;
use toml::de::DeValue;

use super::values::ValueTarget;
use jde_document::Faults;
use jde_document::section::Node;
use jde_document::{FaultReport, quote};

/// Parses a value for the variable `name` of a schema: TOML, or a text without its quotes. Units are
/// converted to the variable's own; a relative path starts in `folder`. The owner of the variable checks the
/// range.
///
/// # Errors
/// The faults of the value; the place of each is `option`, as the user gave it.
pub fn parse_value(
    text: &str,
    (schema, name): (&str, &str),
    value_type: &Type,
    unit: &str,
    folder: &Path,
    option: &str,
) -> Result<Value, Faults> {
    let mut report = FaultReport::new(folder, "");
    let owner = format!("schema `{schema}`");
    let target = ValueTarget {
        name: name.to_owned(),
        owner: &owner,
        unit,
        folder,
    };
    let read = report.in_option(option.to_owned(), |report| {
        let node = parse_node(report, text, value_type)?;
        target.value(report, value_type, &node)
    });
    report.finish()?;
    // Without a fault there is a value.
    Ok(read.unwrap_or(Value::Map(Vec::new())))
}

/// Parses a text for a type: as TOML if possible, otherwise as the text itself. Reports a list or a table that is
/// no TOML.
pub(super) fn parse_node<'t>(report: &mut FaultReport, text: &'t str, value_type: &Type) -> Option<Node<'t>> {
    let as_text = || Spanned::new(0..text.len(), DeValue::String(text.into()));
    let takes_text =
        matches!(value_type.fields.as_slice(), [field] if matches!(field.form, Form::Text { .. }));
    match DeValue::parse(text) {
        // A text may look like a number: name=7.
        Ok(node) if takes_text && node.get_ref().as_str().is_none() => Some(as_text()),
        Ok(node) => Some(node),
        Err(error) if !takes_text && text.starts_with(['[', '{']) => {
            report
                .fault(
                    &(0..0),
                    format!("{} is no TOML: {}", quote(text), error.message()),
                )
                .advise("write a list as [1, 2] and a table as {x = 1, y = 2}, each bracket closed");
            None
        }
        Err(_) => Some(as_text()),
    }
}

#[cfg(test)]
mod tests {
    use jde_types::{Pose2D, Start, Value as _};

    use super::*;

    #[test]
    fn a_list_of_values_without_their_brackets_is_refused_with_the_form_to_write() {
        let owner = ("localize", "initial");
        let read = |text| parse_value(text, owner, &Start::describe(), "", Path::new(""), text);
        let faults = read("[3.55, 1.6, 0.0]").unwrap_err().to_string();
        assert!(faults.contains("[[x, y, theta]]"), "{faults}");
        read("[[3.55, 1.6, 0.0]]").unwrap();
    }

    fn read(text: &str, value_type: &Type, unit: &str) -> Result<Value, String> {
        parse_value(text, ("goon", "fast"), value_type, unit, Path::new("/maps"), text)
            .map_err(|faults| faults.list()[0].message.clone())
    }

    #[test]
    fn units_become_the_variables_own() {
        let number = f64::describe();
        let speed = |metres| Ok(Value::Map(vec![("data".to_owned(), Value::Float(metres))]));
        assert_eq!(read("30 cm/s", &number, "m/s"), speed(0.3));
        assert_eq!(read("0.25", &number, "m/s"), speed(0.25));
        assert_eq!(read("\"1 m/s\"", &number, "m/s"), speed(1.0));
        assert!(
            read("30 deg", &number, "m/s")
                .unwrap_err()
                .contains("`fast` of schema `goon`")
        );
        assert!(read("fast", &number, "m/s").is_err());
    }

    #[test]
    fn structures_are_tables_or_lists() {
        let pose = Pose2D::describe();
        let unclosed = read("{x = 1.0, y = [2.0", &pose, "").unwrap_err();
        assert!(
            unclosed.starts_with("`{x = 1.0, y = [2.0` is no TOML: "),
            "{unclosed}"
        );
        assert_eq!(
            read("[1.0, 2.0, 0.5]", &pose, ""),
            read("{x = 1.0, y = 2.0, theta = 0.5}", &pose, "")
        );
        assert!(read("[1.0]", &pose, "").is_err());
    }
}
