//! Writes `jde/types.py` from the descriptions of the standard types: a dataclass for each, whose layout is that of
//! Rust.

use std::fmt::Write;

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};

/// The classes with functions, in `jde/_standard.py`.
const FUNCTIONS: &str = include_str!("../../../programs/python/python/jde/_standard.py");
/// The longest line.
const LINE_WIDTH: usize = 120;

pub(super) fn module() -> String {
    let mut out = String::from(
        "\"\"\"The standard types of sensors and actuators: SI units, axes of REP-103.\n\n\
         Generated from plugin/types; `cargo xtask headers` renews it.\n\"\"\"\n\n\
         import math\nfrom collections.abc import Sequence\n\nfrom jde import _standard\n\
         from jde._standard import LaserPoint, SonarEcho, normalize_angle\n\
         from jde._values import field, standard\n",
    );
    let types: Vec<Type> = jde_types::standard()
        .into_iter()
        .filter(|ty| !is_plain(ty))
        .collect();
    let mut names: Vec<&str> = types.iter().map(class_name).collect();
    names.extend(["LaserPoint", "SonarEcho", "normalize_angle"]);
    names.sort_unstable();
    out.push_str("\n__all__ = [\n");
    for name in names {
        let _ = writeln!(out, "    \"{name}\",");
    }
    out.push_str("]\n");
    for ty in &types {
        write_class(ty, &mut out);
    }
    out
}

/// Whether values of a type are numbers or texts of Python. A request is none, though it may have the one field `data`.
fn is_plain(ty: &Type) -> bool {
    !ty.name.contains("/srv/") && matches!(ty.fields.as_slice(), [field] if field.name == "data")
}

fn write_class(ty: &Type, out: &mut String) {
    let name = class_name(ty);
    let functions = format!("{name}Functions");
    let base = match FUNCTIONS.contains(&format!("class {functions}:")) {
        true => format!("(_standard.{functions})"),
        false => String::new(),
    };
    let _ = writeln!(out, "\n\n@standard(\"{}\")\nclass {name}{base}:", ty.name);
    write_doc(&ty.doc, out);
    for field in &ty.fields {
        let _ = writeln!(
            out,
            "\n    {}: {} = {}",
            field.name,
            annotation(field),
            default(ty, field)
        );
        let unit = match field.unit.as_str() {
            "" => String::new(),
            unit => format!(" [{unit}]"),
        };
        if !field.doc.is_empty() || !unit.is_empty() {
            write_doc(format!("{}{unit}", field.doc).trim(), out);
        }
    }
}

/// Writes a text below a class or an attribute.
fn write_doc(doc: &str, out: &mut String) {
    let doc = doc.replace('\n', " ");
    if doc.len() + "    \"\"\"\"\"\"".len() <= LINE_WIDTH {
        let _ = writeln!(out, "    \"\"\"{doc}\"\"\"");
        return;
    }
    let mut line = String::from("    \"\"\"");
    for word in doc.split(' ') {
        if line.len() + 1 + word.len() > LINE_WIDTH {
            let _ = writeln!(out, "{}", line.trim_end());
            line = String::from("    ");
        }
        line.push_str(word);
        line.push(' ');
    }
    let _ = writeln!(out, "{}\n    \"\"\"", line.trim_end());
}

fn annotation(field: &Field) -> String {
    let element = element(&field.kind);
    match field.form {
        Form::One => element.to_owned(),
        Form::Text { .. } => "str".to_owned(),
        Form::Array(_) | Form::Sequence { .. } => format!("Sequence[{element}]"),
    }
}

fn element(kind: &FieldKind) -> &str {
    match kind {
        FieldKind::Struct(ty) if is_plain(ty) => "str",
        FieldKind::Struct(ty) => class_name(ty),
        FieldKind::Scalar(scalar) => match scalar {
            Scalar::Bool => "bool",
            Scalar::F32 | Scalar::F64 => "float",
            Scalar::U8
            | Scalar::U16
            | Scalar::U32
            | Scalar::U64
            | Scalar::I8
            | Scalar::I16
            | Scalar::I32
            | Scalar::I64 => "int",
        },
    }
}

/// Returns the default of a field: that of Rust's `Default`.
fn default(ty: &Type, field: &Field) -> String {
    let one = match (class_name(ty), field.name.as_str(), &field.kind) {
        ("Quaternion", "w", _) => "1.0".to_owned(),
        ("NavSatStatus", "status", _) => "-2".to_owned(),
        ("BatteryState", _, FieldKind::Scalar(Scalar::F32)) if field.form == Form::One => {
            "math.nan".to_owned()
        }
        (_, _, FieldKind::Struct(part)) => class_name(part).to_owned(),
        (_, _, kind) => match element(kind) {
            "bool" => "False",
            "float" => "0.0",
            _ => "0",
        }
        .to_owned(),
    };
    match (field.form, &field.kind) {
        (Form::One, FieldKind::Struct(_)) => format!("field(default_factory={one})"),
        (Form::One, FieldKind::Scalar(_)) => one,
        (Form::Text { .. }, _) => "\"\"".to_owned(),
        (Form::Sequence { .. }, _) => "field(default_factory=list)".to_owned(),
        (Form::Array(count), FieldKind::Scalar(_)) => {
            format!("field(default_factory=lambda: [{one}] * {count})")
        }
        (Form::Array(count), FieldKind::Struct(_)) => {
            format!("field(default_factory=lambda: [{one}() for _ in range({count})])")
        }
    }
}

/// Returns the name of the class: `LaserScan` for `sensor_msgs/msg/LaserScan`.
fn class_name(ty: &Type) -> &str {
    ty.name.rsplit('/').next().unwrap_or(&ty.name)
}
