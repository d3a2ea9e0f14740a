//! The rows of the window: schemas, their variables, and the fields of unfolded variables.

use jde_abi::describe::{FieldKind, Form, Scalar, Type};
use jde_link::message::VariableInfo;

use super::Values;
use crate::session::WindowSession;

/// A row.
pub(super) struct ValueRow {
    pub(super) what: RowKind,
    /// Level of indentation.
    pub(super) depth: usize,
    /// Whether it can be unfolded.
    pub(super) foldable: bool,
    /// The kind and unit of a value without parts, otherwise `None`.
    pub(super) leaf: Option<(Leaf, String)>,
    /// Its documentation.
    pub(super) doc: String,
}

/// The subject of a row.
pub(super) enum RowKind {
    /// A schema.
    Schema(String),
    /// A variable, by its full name.
    Variable(String),
    /// A field of a variable, by its names from the outermost to its own.
    Field { variable: String, names: Vec<String> },
}

/// A value that has no parts.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Leaf {
    /// A truth value.
    Flag,
    /// A whole number.
    Whole,
    /// A floating-point number.
    Number,
    /// Text.
    Text,
}

impl ValueRow {
    /// The unique name of the row, in the notation of all tools.
    pub(super) fn path(&self) -> String {
        match &self.what {
            RowKind::Schema(name) | RowKind::Variable(name) => name.clone(),
            RowKind::Field { variable, names } => format!("{variable}.{}", names.join(".")),
        }
    }

    /// The names of the field, from the outermost to its own; empty for other rows.
    pub(super) fn names(&self) -> &[String] {
        match &self.what {
            RowKind::Field { names, .. } => names,
            RowKind::Schema(_) | RowKind::Variable(_) => &[],
        }
    }

    /// The last part of its name.
    pub(super) fn name<'a>(&'a self, info: &'a VariableInfo) -> &'a str {
        match &self.what {
            RowKind::Schema(name) => name,
            RowKind::Variable(_) => &info.variable,
            RowKind::Field { names, .. } => names.last().map_or("", String::as_str),
        }
    }
}

/// The unfolded rows that match the search and the filter, in the application's order.
pub(super) fn of(session: &WindowSession, window: &Values) -> Vec<ValueRow> {
    let search = window.search.to_lowercase();
    let mut rows = Vec::new();
    let mut last = None;
    for info in session.variables() {
        if window.only_modulations && info.access != "modulation" {
            continue;
        }
        if window.tuned.is_only && !window.tuned.has(&info.name) {
            continue;
        }
        let found = [&info.name, &info.type_name, &info.doc]
            .iter()
            .any(|text| text.to_lowercase().contains(&search));
        if !found {
            continue;
        }
        if last != Some(&info.owner) {
            last = Some(&info.owner);
            rows.push(ValueRow {
                what: RowKind::Schema(info.owner.clone()),
                depth: 0,
                foldable: true,
                leaf: None,
                doc: String::new(),
            });
        }
        // A search also finds variables of folded schemas.
        if window.folded.contains(&info.owner) && search.is_empty() {
            continue;
        }
        let value_type = window.seen.get(&info.name).and_then(|seen| seen.value_type());
        let single_leaf = value_type.and_then(single_leaf);
        rows.push(ValueRow {
            what: RowKind::Variable(info.name.clone()),
            depth: 1,
            foldable: value_type.is_some() && single_leaf.is_none(),
            leaf: single_leaf.map(|leaf| (leaf, info.unit.clone())),
            doc: info.doc.clone(),
        });
        if window.unfolded.contains(&info.name)
            && let Some(value_type) = value_type
            && single_leaf.is_none()
        {
            fields(&mut rows, window, &info.name, value_type, &mut Vec::new());
        }
    }
    rows
}

fn fields(
    rows: &mut Vec<ValueRow>,
    window: &Values,
    variable: &str,
    value_type: &Type,
    names: &mut Vec<String>,
) {
    for field in &value_type.fields {
        names.push(field.name.clone());
        let inner = match (&field.kind, field.form) {
            (FieldKind::Struct(inner), Form::One) => Some(inner),
            _ => None,
        };
        let row = ValueRow {
            what: RowKind::Field {
                variable: variable.to_owned(),
                names: names.clone(),
            },
            depth: 1 + names.len(),
            foldable: inner.is_some_and(|inner| single_leaf(inner).is_none()),
            leaf: leaf(&field.kind, field.form).map(|leaf| (leaf, field.unit.clone())),
            doc: field.doc.clone(),
        };
        let open = row.foldable && window.unfolded.contains(&row.path());
        rows.push(row);
        if let (Some(inner), true) = (inner, open) {
            fields(rows, window, variable, inner, names);
        }
        names.pop();
    }
}

/// The kind of a type that has one number, flag or text and nothing else.
pub(super) fn single_leaf(value_type: &Type) -> Option<Leaf> {
    match value_type.fields.as_slice() {
        [field] => leaf(&field.kind, field.form),
        _ => None,
    }
}

fn leaf(kind: &FieldKind, form: Form) -> Option<Leaf> {
    match (kind, form) {
        (FieldKind::Scalar(_), Form::Text { .. }) => Some(Leaf::Text),
        (FieldKind::Scalar(Scalar::Bool), Form::One) => Some(Leaf::Flag),
        (FieldKind::Scalar(Scalar::F32 | Scalar::F64), Form::One) => Some(Leaf::Number),
        (FieldKind::Scalar(_), Form::One) => Some(Leaf::Whole),
        (FieldKind::Struct(inner), Form::One) => single_leaf(inner),
        _ => None,
    }
}
