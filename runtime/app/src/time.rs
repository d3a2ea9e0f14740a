//! Times in a file: periods, budgets, patience. A number is in seconds, a text has a unit. Refuses times
//! outside the range of periods.

use jde_core::Nanos;
use jde_document::section::{self, Node, Section, report_wrong_shape};
use jde_document::{FaultReport, quote};

use super::period::{self, OutOfRange, RANGE};
use super::units::{QuantityError, quantity};

/// Reads the time at a key of a section, ns; `None` if the key is missing.
pub fn of(report: &mut FaultReport, section: &Section, key: &str) -> Option<Nanos> {
    time(report, &section.key(key), section.get(key)?)
}

/// Reads a time in ns.
pub fn time(report: &mut FaultReport, what: &str, node: &Node) -> Option<Nanos> {
    read(
        report,
        what,
        node,
        "a time such as \"75ms\", or a number of seconds",
        |text| quantity(text, "s"),
    )
}

/// Reads the period of a schema in ns, also from a frequency.
pub fn period(report: &mut FaultReport, what: &str, node: &Node) -> Option<Nanos> {
    read(
        report,
        what,
        node,
        "a time such as \"75ms\", a frequency such as \"10 Hz\", or a number of seconds",
        |text| match quantity(text, "s") {
            Err(QuantityError::OtherDimension(unit)) => quantity(text, "Hz")
                .map(|frequency| 1.0 / frequency)
                .map_err(|_| QuantityError::OtherDimension(unit)),
            other => other,
        },
    )
}

fn read(
    report: &mut FaultReport,
    what: &str,
    node: &Node,
    expected: &str,
    parse: impl Fn(&str) -> Result<f64, QuantityError>,
) -> Option<Nanos> {
    let seconds = if let Some(text) = node.get_ref().as_str() {
        match parse(text) {
            Ok(seconds) => seconds,
            Err(error) => {
                let message = match error {
                    QuantityError::NotANumber => format!("{what} is {}, which is not a time", quote(text)),
                    QuantityError::UnknownUnit(unit) => {
                        format!(
                            "{what} is {}, and {} is no unit of time",
                            quote(text),
                            quote(&unit)
                        )
                    }
                    QuantityError::OtherDimension(unit) => {
                        format!("{what} must be a time, and {} is no unit of time", quote(&unit))
                    }
                };
                report
                    .fault(&node.span(), message)
                    .advise(format!("write {expected}"));
                return None;
            }
        }
    } else if let Some(seconds) = section::number(node.get_ref()) {
        seconds
    } else {
        report_wrong_shape(report, what, expected, node);
        return None;
    };
    // Budgets and patience have the same range as periods.
    match period::from_seconds(seconds) {
        Ok(time) => Some(time),
        Err(OutOfRange { seconds }) => {
            report
                .fault(&node.span(), format!("{what} is {}", period::problem(seconds)))
                .advise(format!("give a time {RANGE}; a bare number counts seconds"));
            None
        }
    }
}
