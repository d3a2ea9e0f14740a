//! Numbers of a recording by name, such as `pioneer.odometry.twist.twist.linear.x`. Recordings by other
//! programs work too: their topics serve as variables if their types are described in the recording or are
//! standard ones.

use jde_abi::describe::{FieldKind, Form, Type};
use jde_link::message::VariableInfo;
use jde_log::{LeftOut, RecordedVariable, RecordedVariables, Recording};
use jde_report::Series;
use jde_ros::definition;

use crate::failure::{Failure, display_path};
use crate::remote::field::VariableField;
use crate::remote::name;

/// Most names offered for completion.
const MAX_NAMES: usize = 2000;

/// Returns the series of the named numbers.
///
/// # Errors
/// There is no such variable or field, in which case the error suggests the nearest; or the value is not a
/// number.
pub(crate) fn series(recording: &Recording, requested: &[String]) -> Result<Vec<Series>, Failure> {
    let known = RecordedVariables::of(recording);
    requested
        .iter()
        .map(|name| resolve_series(recording, &known, name))
        .collect()
}

/// Returns the names of all numbers, each with the doc text of its variable; at most `MAX_NAMES`.
pub(crate) fn names(recording: &Recording) -> Vec<(String, String)> {
    let mut names = Vec::new();
    for recorded in RecordedVariables::of(recording).iter() {
        visit_fields(&recorded.value_type, &recorded.name, &mut |name| {
            names.push((name, recorded.doc.clone()));
        });
        if names.len() >= MAX_NAMES {
            break;
        }
    }
    names.truncate(MAX_NAMES);
    names
}

fn resolve_series(
    recording: &Recording,
    known: &RecordedVariables,
    requested: &str,
) -> Result<Series, Failure> {
    if known.is_empty() {
        return Err(Failure::usage(
            format!(
                "{} contains no variables that can be drawn",
                display_path(recording.path())
            ),
            "`jde info` shows its contents",
        ));
    }
    // Accepts a topic name as ROS writes it: `/odom.pose.pose.position.x`.
    let requested = requested.trim_start_matches('/').replace('/', ".");
    let names = known.iter().map(|recorded| recorded.name.as_str());
    let (variable, path) = name::split_variable(&requested, names)?;
    let Some(recorded) = known.iter().find(|recorded| recorded.name == variable) else {
        return Err(Failure::usage(
            format!("there is no variable `{requested}`"),
            "`jde info` lists the variables",
        ));
    };
    let field = VariableField::resolve(&variable_info(recorded), path)?;
    if !field.is_number() {
        return Err(Failure::usage(
            format!("`{requested}` is not a number, and only numbers are drawn"),
            format!("name a field, such as {}", example_field(recorded)),
        ));
    }
    let decoded = recorded.clone();
    Ok(Series {
        topic: recorded.topic.clone(),
        variable: variable.to_owned(),
        name: field.name().to_owned(),
        unit: field.unit.clone(),
        number: Box::new(move |message| {
            // What is cut are texts, and these are no numbers.
            let value = decoded.decode(message, &mut LeftOut::default())?;
            Ok(field.decode_number(&value))
        }),
    })
}

/// Returns one number of a variable as an example.
fn example_field(recorded: &RecordedVariable) -> String {
    let mut first = None;
    visit_fields(&recorded.value_type, &recorded.name, &mut |name| {
        first.get_or_insert(name);
    });
    first.unwrap_or_else(|| format!("{}.FIELD", recorded.name))
}

/// Returns the description that a running application would send.
fn variable_info(recorded: &RecordedVariable) -> VariableInfo {
    VariableInfo {
        name: recorded.name.clone(),
        access: recorded.access.clone(),
        type_name: definition::name(&recorded.value_type),
        definition: definition::definition(&recorded.value_type),
        unit: recorded.unit.clone(),
        doc: recorded.doc.clone(),
        ..VariableInfo::default()
    }
}

/// Calls `visit` with the name of each number of a type, except elements of lists.
fn visit_fields(value_type: &Type, name: &str, visit: &mut dyn FnMut(String)) {
    if let [field] = value_type.fields.as_slice()
        && matches!(field.kind, FieldKind::Scalar(_))
        && field.form == Form::One
    {
        visit(name.to_owned());
        return;
    }
    for field in &value_type.fields {
        let name = format!("{name}.{}", field.name);
        match (&field.kind, field.form) {
            (FieldKind::Scalar(_), Form::One) => visit(name),
            (FieldKind::Struct(inner), Form::One) => visit_fields(inner, &name, visit),
            (FieldKind::Scalar(_) | FieldKind::Struct(_), _) => {}
        }
    }
}
