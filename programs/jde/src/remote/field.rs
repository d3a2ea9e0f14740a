//! A variable or one of its fields: decodes its value, and formats it with its unit.

use jde_abi::describe::{FieldKind, Type};
use jde_board::value::{Value, ValueError, get_path};
use jde_link::message::VariableInfo;

use crate::failure::Failure;
use crate::inspect::value::{decode_plain, format_with_unit};

/// A field of a variable, or the whole variable.
pub(crate) struct VariableField {
    /// Its unit; empty for none.
    pub(crate) unit: String,
    /// The names of its numbers, if it is a choice.
    choices: Vec<String>,
    value_type: Type,
    path: String,
    name: String,
}

impl VariableField {
    /// Returns the field of a variable at a path. The empty path is the whole variable.
    ///
    /// # Errors
    /// There is no such field. The error contains the nearest name.
    pub(crate) fn resolve(variable: &VariableInfo, path: &str) -> Result<Self, Failure> {
        let name = match path {
            "" => variable.name.clone(),
            path => format!("{}.{path}", variable.name),
        };
        let value_type = variable.value_type().map_err(|error| {
            Failure::broken(format!("the type of `{}` cannot be read: {error}", variable.name))
        })?;
        let field = Self {
            unit: match path {
                "" => variable.unit.clone(),
                path => unit(&value_type, path),
            },
            choices: match path {
                "" => variable.range.choices.clone(),
                _ => Vec::new(),
            },
            path: path.to_owned(),
            value_type,
            name,
        };
        // An element of a list may exist later. A field that does not exist now never will.
        match get_path(&field.value_type, &vec![0; field.value_type.bytes], path) {
            Ok(_) | Err(ValueError::NoElement { .. }) => Ok(field),
            Err(error) => Err(field.usage_error(&error)),
        }
    }

    /// `pioneer.odometry.pose.pose.position.x`.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The most bytes of a value of the variable.
    pub(crate) fn bytes(&self) -> usize {
        self.value_type.bytes
    }

    /// Decodes its value from the bytes of the variable.
    ///
    /// # Errors
    /// An element past the end of its list.
    pub(crate) fn decode(&self, bytes: &[u8]) -> Result<Value, Failure> {
        if self.path.is_empty() {
            return Ok(decode_plain(&self.value_type, bytes));
        }
        get_path(&self.value_type, bytes, &self.path).map_err(|error| self.usage_error(&error))
    }

    /// Whether it is a number or a flag.
    pub(crate) fn is_number(&self) -> bool {
        match get_path(&self.value_type, &vec![0; self.value_type.bytes], &self.path) {
            Ok(Value::Map(fields)) => {
                fields.len() == 1 && !matches!(fields[0].1, Value::Text(_) | Value::List(_) | Value::Map(_))
            }
            Ok(Value::Text(_) | Value::List(_)) => false,
            // The type of a list element is known only when it arrives.
            Ok(Value::Bool(_) | Value::Int(_) | Value::UInt(_) | Value::Float(_)) | Err(_) => true,
        }
    }

    /// Decodes its value as a number; a flag is 0 or 1. `None` if it is neither.
    pub(crate) fn decode_number(&self, bytes: &[u8]) -> Option<f64> {
        match self.decode(bytes).ok()? {
            Value::Bool(flag) => Some(f64::from(u8::from(flag))),
            value => value.as_number(),
        }
    }

    /// Formats one of its values with the unit, or as the name of a choice.
    pub(crate) fn format_value(&self, value: Value) -> String {
        let chosen = value
            .as_number()
            .and_then(|number| self.choices.get(number as usize));
        if let Some(chosen) = chosen {
            return chosen.clone();
        }
        format_with_unit(value, &self.unit)
    }

    fn usage_error(&self, error: &ValueError) -> Failure {
        Failure::usage(
            format!("`{}`: {error}", self.name),
            "`jde get VARIABLE` shows all fields",
        )
    }
}

/// Returns the unit of the field at a path.
fn unit(value_type: &Type, path: &str) -> String {
    let mut value_type = value_type;
    let mut unit = String::new();
    for step in path.split('.') {
        let name = step.split('[').next().unwrap_or(step);
        let Some(field) = value_type.fields.iter().find(|field| field.name == name) else {
            return String::new();
        };
        unit.clone_from(&field.unit);
        if let FieldKind::Struct(inner) = &field.kind {
            value_type = inner;
        }
    }
    unit
}

#[cfg(test)]
mod tests {
    use jde_types::{LaserScan, Value as _};

    use super::*;

    fn laser() -> VariableInfo {
        let value_type = LaserScan::describe();
        VariableInfo {
            name: "pioneer.laser".to_owned(),
            owner: "pioneer".to_owned(),
            variable: "laser".to_owned(),
            access: "export".to_owned(),
            type_name: jde_ros::definition::name(&value_type),
            definition: jde_ros::definition::definition(&value_type),
            ..VariableInfo::default()
        }
    }

    #[test]
    fn a_field_has_its_own_unit_and_number() {
        let mut scan = LaserScan::default();
        scan.ranges.push(2.5).unwrap();
        let field = VariableField::resolve(&laser(), "ranges[0]").unwrap();
        assert_eq!(field.unit, "m");
        assert_eq!(field.decode_number(scan.as_bytes()), Some(2.5));
        assert_eq!(
            field.format_value(field.decode(scan.as_bytes()).unwrap()),
            "2.5 m"
        );
        assert_eq!(field.name(), "pioneer.laser.ranges[0]");
    }

    #[test]
    fn an_unknown_field_is_refused_and_a_missing_element_is_not() {
        let Err(Failure::Run(crate::failure::RunFailure::Usage { message, .. })) =
            VariableField::resolve(&laser(), "rangs")
        else {
            panic!("an unknown field was found");
        };
        assert!(message.contains("did you mean `ranges`?"), "{message}");
        let field = VariableField::resolve(&laser(), "ranges[5]").unwrap();
        assert_eq!(field.decode_number(LaserScan::default().as_bytes()), None);
    }
}
