//! Converts a value of a file into a value of a port's type: units into the port's, paths into absolute ones,
//! lists and tables into structures. Reports the exact position of a value that does not fit; the board
//! encodes it.

use std::path::Path;

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};
use jde_board::value::Value;
use toml::de::{DeArray, DeTable, DeValue};

use jde_document::section::{Node, expect, report_wrong_shape};
use jde_document::{FaultReport, quote};

/// The unit of a text that is a path.
const PATH: &str = "path";
/// The unit of a text that is the path of a file which must exist before the application starts.
const FILE: &str = "file";

/// The unit of a text that is the path of a TOML file, or the name of something that the plugin has.
const MODEL: &str = "model";

/// Whether a text is a path, by its unit.
#[must_use]
pub fn is_path(unit: &str, text: &str) -> bool {
    match unit {
        PATH | FILE => !text.is_empty(),
        MODEL => text.ends_with(".toml"),
        _ => false,
    }
}

/// How the paths of a file are resolved and checked.
#[derive(Clone, Copy)]
pub(super) struct Paths<'p> {
    /// The folder of relative paths.
    pub(super) folder: &'p Path,
    /// Whether to check that files of unit [`FILE`] exist.
    pub(super) check_files: bool,
}

impl Paths<'_> {
    /// Returns the path in a value if it names a required file that does not exist.
    pub(super) fn missing_file<'v>(self, unit: &str, value: &'v Value) -> Option<&'v str> {
        let Value::Map(fields) = value else { return None };
        let [(_, Value::Text(path))] = fields.as_slice() else {
            return None;
        };
        let absent = self.check_files && unit == FILE && !path.is_empty() && !Path::new(path).is_file();
        absent.then_some(path.as_str())
    }
}

/// The destination of a value.
pub(super) struct ValueTarget<'t> {
    /// Its name in messages: "`speed` of schema `goon`", and for a field "`start.theta` of ...".
    pub(super) name: String,
    pub(super) owner: &'t str,
    /// The unit of a plain number or text; empty if the type's fields have units of their own.
    pub(super) unit: &'t str,
    /// The folder of relative paths.
    pub(super) folder: &'t Path,
}

impl ValueTarget<'_> {
    /// Converts a value into the form that [`jde_board::value::encode`] takes for `ty`; reports what does not
    /// fit.
    pub(super) fn value(&self, report: &mut FaultReport, ty: &Type, node: &Node) -> Option<Value> {
        match node.get_ref() {
            DeValue::Table(table) => self.by_name(report, ty, table),
            DeValue::Array(list) => match ty.fields.as_slice() {
                [field] if !matches!(field.form, Form::One) => self.only(report, field, node),
                fields => self.by_order(report, ty, fields, list, node),
            },
            DeValue::String(_)
            | DeValue::Integer(_)
            | DeValue::Float(_)
            | DeValue::Boolean(_)
            | DeValue::Datetime(_) => match ty.fields.as_slice() {
                [field] => self.only(report, field, node),
                _ => {
                    let expected = format!("a table or a list of {}", fields(ty));
                    report_wrong_shape(report, &self.label(), &expected, node);
                    None
                }
            },
        }
    }

    pub(super) fn label(&self) -> String {
        format!("{} of {}", quote(&self.name), self.owner)
    }

    /// Converts the single field of a type, given without its name.
    fn only(&self, report: &mut FaultReport, field: &Field, node: &Node) -> Option<Value> {
        let value = self.field(report, field, node)?;
        Some(Value::Map(vec![(field.name.clone(), value)]))
    }

    pub(super) fn by_name(&self, report: &mut FaultReport, ty: &Type, table: &DeTable) -> Option<Value> {
        let mut values = Vec::with_capacity(table.len());
        let mut complete = true;
        for (key, node) in table {
            let name = key.get_ref();
            let Some(field) = ty.fields.iter().find(|field| field.name == **name) else {
                report
                    .fault(
                        &key.span(),
                        format!("{} has no field {}", self.label(), quote(name)),
                    )
                    .suggest(name, "fields", ty.fields.iter().map(|field| field.name.as_str()));
                complete = false;
                continue;
            };
            match self.inner(field).field(report, field, node) {
                Some(value) => values.push((field.name.clone(), value)),
                None => complete = false,
            }
        }
        complete.then_some(Value::Map(values))
    }

    fn by_order(
        &self,
        report: &mut FaultReport,
        ty: &Type,
        all: &[Field],
        list: &DeArray,
        node: &Node,
    ) -> Option<Value> {
        if list.len() != all.len() {
            let message = format!(
                "{} has {} values, and {} of them are expected: {}",
                self.label(),
                list.len(),
                all.len(),
                fields(ty)
            );
            report.fault(&node.span(), message);
            return None;
        }
        let values: Vec<_> = all
            .iter()
            .zip(list.iter())
            .map(|(field, node)| Some((field.name.clone(), self.inner(field).field(report, field, node)?)))
            .collect();
        Some(Value::Map(values.into_iter().collect::<Option<_>>()?))
    }

    fn inner<'t>(&'t self, field: &'t Field) -> ValueTarget<'t> {
        ValueTarget {
            name: format!("{}.{}", self.name, field.name),
            owner: self.owner,
            unit: &field.unit,
            folder: self.folder,
        }
    }

    fn field(&self, report: &mut FaultReport, field: &Field, node: &Node) -> Option<Value> {
        let unit = if self.unit.is_empty() {
            &field.unit
        } else {
            self.unit
        };
        match field.form {
            Form::One => self.element(report, &field.kind, unit, node),
            Form::Text { capacity, .. } => self.text(report, unit, capacity, node),
            Form::Array(count) => self.list(report, field, unit, (count, count), node),
            Form::Sequence { capacity, .. } => self.list(report, field, unit, (0, capacity), node),
        }
    }

    fn list(
        &self,
        report: &mut FaultReport,
        field: &Field,
        unit: &str,
        (least, most): (usize, usize),
        node: &Node,
    ) -> Option<Value> {
        let list = expect(report, &self.label(), "a list", node, node.get_ref().as_array())?;
        let is_plain = |node: &Node| !node.get_ref().is_array() && !node.get_ref().is_table();
        if let FieldKind::Struct(ty) = &field.kind
            && let [_, _, ..] = ty.fields[..]
            && !list.is_empty()
            && list.iter().all(is_plain)
        {
            let message = format!("{} must be a list of lists", self.label());
            let fault = report.fault(&node.span(), message);
            fault.advise(format!("each value is a list itself: [[{}]]", fields(ty)));
            return None;
        }
        if !(least..=most).contains(&list.len()) {
            let expected = if least == most { "exactly" } else { "at most" };
            let message = format!(
                "{} has {} values, and {expected} {most} fit",
                self.label(),
                list.len()
            );
            report.fault(&node.span(), message);
            return None;
        }
        let values: Vec<_> = list
            .iter()
            .enumerate()
            .map(|(index, node)| {
                let name = format!("{}[{index}]", self.name);
                ValueTarget { name, ..*self }.element(report, &field.kind, unit, node)
            })
            .collect();
        Some(Value::List(values.into_iter().collect::<Option<_>>()?))
    }

    fn element(&self, report: &mut FaultReport, kind: &FieldKind, unit: &str, node: &Node) -> Option<Value> {
        match kind {
            FieldKind::Struct(ty) => self.value(report, ty, node),
            FieldKind::Scalar(Scalar::Bool) => {
                let value = node.get_ref().as_bool();
                expect(report, &self.label(), "true or false", node, value).map(Value::Bool)
            }
            FieldKind::Scalar(Scalar::F32) => self.float(report, unit, f64::from(f32::MAX), node),
            FieldKind::Scalar(Scalar::F64) => self.float(report, unit, f64::MAX, node),
            FieldKind::Scalar(scalar) => self.integer(report, *scalar, unit, node),
        }
    }

    fn text(&self, report: &mut FaultReport, unit: &str, capacity: usize, node: &Node) -> Option<Value> {
        let text = expect(report, &self.label(), "a text", node, node.get_ref().as_str())?;
        let text = if is_path(unit, text) {
            self.folder.join(text).to_string_lossy().into_owned()
        } else {
            text.to_owned()
        };
        if text.len() > capacity {
            let message = format!(
                "{} has {} bytes, and at most {capacity} fit",
                self.label(),
                text.len()
            );
            report.fault(&node.span(), message);
            return None;
        }
        Some(Value::Text(text))
    }
}

fn fields(ty: &Type) -> String {
    let names: Vec<_> = ty.fields.iter().map(|field| field.name.as_str()).collect();
    names.join(", ")
}
