//! The rows of the window: schemas, their variables, and the fields of those that are unfolded.

use jde_abi::describe::{FieldKind, Form, Scalar, Type};
use jde_link::message::VariableInfo;

use super::Values;
use crate::session::Session;

/// A row.
pub(super) struct Row {
    pub(super) what: RowKind,
    /// How far it stands to the right.
    pub(super) depth: usize,
    /// It can be unfolded.
    pub(super) foldable: bool,
    /// It is a single number, flag or text; its unit.
    pub(super) leaf: Option<(Leaf, String)>,
    /// What it means.
    pub(super) doc: String,
}

/// Of what a row is.
pub(super) enum RowKind {
    /// A schema.
    Schema(String),
    /// A variable, by its full name.
    Variable(String),
    /// A field of a variable, by its names from the outside in.
    Field { variable: String, names: Vec<String> },
}

/// A value that has no parts.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Leaf {
    /// Yes or no.
    Flag,
    /// A whole number.
    Whole,
    /// A number.
    Number,
    /// Text.
    Text,
}

impl Row {
    /// What names it alone, as the tools write it.
    pub(super) fn path(&self) -> String {
        match &self.what {
            RowKind::Schema(name) | RowKind::Variable(name) => name.clone(),
            RowKind::Field { variable, names } => format!("{variable}.{}", names.join(".")),
        }
    }

    /// The fields it is in, from the outside in.
    pub(super) fn names(&self) -> &[String] {
        match &self.what {
            RowKind::Field { names, .. } => names,
            RowKind::Schema(_) | RowKind::Variable(_) => &[],
        }
    }

    /// Its own name.
    pub(super) fn name<'a>(&'a self, info: &'a VariableInfo) -> &'a str {
        match &self.what {
            RowKind::Schema(name) => name,
            RowKind::Variable(_) => &info.variable,
            RowKind::Field { names, .. } => names.last().map_or("", String::as_str),
        }
    }
}

/// All rows that are unfolded and wanted, in the application's order.
pub(super) fn of(session: &Session, window: &Values) -> Vec<Row> {
    let words = window.search.to_lowercase();
    let mut rows = Vec::new();
    let mut last = None;
    for info in session.variables() {
        if window.only_modulations && info.access != "modulation" {
            continue;
        }
        let found = [&info.name, &info.type_name, &info.doc]
            .iter()
            .any(|text| text.to_lowercase().contains(&words));
        if !found {
            continue;
        }
        if last != Some(&info.owner) {
            last = Some(&info.owner);
            rows.push(Row {
                what: RowKind::Schema(info.owner.clone()),
                depth: 0,
                foldable: true,
                leaf: None,
                doc: String::new(),
            });
        }
        // What is searched for is shown, folded or not.
        if window.folded.contains(&info.owner) && words.is_empty() {
            continue;
        }
        let value_type = window.seen.get(&info.name).and_then(|seen| seen.value_type());
        let alone = value_type.and_then(alone);
        rows.push(Row {
            what: RowKind::Variable(info.name.clone()),
            depth: 1,
            foldable: value_type.is_some() && alone.is_none(),
            leaf: alone.map(|leaf| (leaf, info.unit.clone())),
            doc: info.doc.clone(),
        });
        if window.unfolded.contains(&info.name)
            && let Some(value_type) = value_type
            && alone.is_none()
        {
            fields(&mut rows, window, &info.name, value_type, &mut Vec::new());
        }
    }
    rows
}

fn fields(rows: &mut Vec<Row>, window: &Values, variable: &str, value_type: &Type, names: &mut Vec<String>) {
    for field in &value_type.fields {
        names.push(field.name.clone());
        let inner = match (&field.kind, field.form) {
            (FieldKind::Struct(inner), Form::One) => Some(inner),
            _ => None,
        };
        let row = Row {
            what: RowKind::Field {
                variable: variable.to_owned(),
                names: names.clone(),
            },
            depth: 1 + names.len(),
            foldable: inner.is_some_and(|inner| alone(inner).is_none()),
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

/// What a type is that is nothing but one number or flag.
pub(super) fn alone(value_type: &Type) -> Option<Leaf> {
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
        (FieldKind::Struct(inner), Form::One) => alone(inner),
        _ => None,
    }
}
