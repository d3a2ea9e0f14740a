//! Numbers of a file, in the units and within the bounds of their fields. Encodes nothing.

use jde_abi::describe::Scalar;
use jde_board::value::Value;
use toml::de::DeValue;

use super::units::{QuantityError, quantity};
use super::values::ValueTarget;
use jde_document::section::{self, Node, expect, report_wrong_shape};
use jde_document::{FaultReport, quote};

impl ValueTarget<'_> {
    pub(super) fn float(
        &self,
        report: &mut FaultReport,
        unit: &str,
        most: f64,
        node: &Node,
    ) -> Option<Value> {
        let number = match section::number(node.get_ref()) {
            Some(number) => number,
            None => self.quantity(report, unit, node)?,
        };
        if !number.is_finite() {
            report.fault(&node.span(), format!("{} is not a finite number", self.label()));
            return None;
        }
        if number.abs() > most {
            report.fault(
                &node.span(),
                format!("{} is beyond what a float32 holds", self.label()),
            );
            return None;
        }
        Some(Value::Float(number))
    }

    pub(super) fn integer(
        &self,
        report: &mut FaultReport,
        scalar: Scalar,
        unit: &str,
        node: &Node,
    ) -> Option<Value> {
        let number = match node.get_ref() {
            DeValue::Integer(_) => section::integer(node.get_ref()),
            // The guard makes this exact: a whole float below 2^64 is a whole number of 128 bits.
            DeValue::String(_) => Some(self.quantity(report, unit, node)?)
                .filter(|number| number.fract() == 0.0 && number.abs() < 2f64.powi(64))
                .map(|number| number as i128),
            DeValue::Float(_)
            | DeValue::Boolean(_)
            | DeValue::Datetime(_)
            | DeValue::Array(_)
            | DeValue::Table(_) => {
                report_wrong_shape(
                    report,
                    &self.label(),
                    &format!("a whole number{}", in_unit(unit)),
                    node,
                );
                return None;
            }
        };
        let (least, most) = bounds(scalar);
        let fitting = number.filter(|number| (least..=most).contains(number));
        let value = fitting.and_then(|number| {
            i64::try_from(number)
                .map(Value::Int)
                .or_else(|_| u64::try_from(number).map(Value::UInt))
                .ok()
        });
        if value.is_none() {
            report.fault(
                &node.span(),
                format!("{} is not a whole number from {least} to {most}", self.label()),
            );
        }
        value
    }

    /// Reads a text such as "30 cm".
    fn quantity(&self, report: &mut FaultReport, unit: &str, node: &Node) -> Option<f64> {
        let expected = format!("a number{}", in_unit(unit));
        let text = expect(report, &self.label(), &expected, node, node.get_ref().as_str())?;
        let message = match quantity(text, unit) {
            Ok(number) => return Some(number),
            Err(QuantityError::NotANumber) => {
                format!(
                    "{} must be {expected}, not the text {}",
                    self.label(),
                    quote(text)
                )
            }
            Err(QuantityError::UnknownUnit(given)) => {
                format!(
                    "{} must be {expected}, and {} is no known unit",
                    self.label(),
                    quote(&given)
                )
            }
            Err(QuantityError::OtherDimension(given)) => {
                format!(
                    "{} must be {expected}, and {} does not convert to that",
                    self.label(),
                    quote(&given)
                )
            }
        };
        report.fault(&node.span(), message);
        None
    }
}

fn bounds(scalar: Scalar) -> (i128, i128) {
    match scalar {
        Scalar::U8 => (0, u8::MAX.into()),
        Scalar::U16 => (0, u16::MAX.into()),
        Scalar::U32 => (0, u32::MAX.into()),
        Scalar::U64 => (0, u64::MAX.into()),
        Scalar::I8 => (i8::MIN.into(), i8::MAX.into()),
        Scalar::I16 => (i16::MIN.into(), i16::MAX.into()),
        Scalar::I32 => (i32::MIN.into(), i32::MAX.into()),
        Scalar::I64 => (i64::MIN.into(), i64::MAX.into()),
        Scalar::Bool | Scalar::F32 | Scalar::F64 => (0, 0),
    }
}

fn in_unit(unit: &str) -> String {
    if unit.is_empty() {
        String::new()
    } else {
        format!(" in {unit}")
    }
}
