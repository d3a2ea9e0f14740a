//! Reads the text of edits: a table, a list of tables, or a numbered list. All its faults are reported
//! together.

use std::path::Path;

use jde_document::section::table;
use jde_document::{FaultReport, Faults, Node, Section, WrongValue, quote_all};
use toml::de::DeValue;

use super::values;
use super::{fixtures, starts};
use crate::edit::{Edit, EditAction, Edits};

/// The name of the text in faults.
const NAME: &str = "edit";
const KINDS: [&str; 7] = ["place", "add", "remove", "halt", "resume", "raise", "lower"];

/// Reads a text that is not empty.
pub(crate) fn read(text: &str) -> Result<Edits, Faults> {
    let mut report = FaultReport::new(Path::new(NAME), text);
    let edits = match DeValue::parse(text) {
        Ok(root) => parse(&mut report, text, &root),
        Err(error) => {
            report.fault(&error.span().unwrap_or(0..0), error.message());
            None
        }
    };
    match edits {
        Some(edits) => report.finish().map(|_| edits),
        None => Err(report.into_faults()),
    }
}

fn parse(report: &mut FaultReport<'_>, text: &str, root: &Node<'_>) -> Option<Edits> {
    let (number, items) = match root.get_ref() {
        DeValue::Array(items) => (None, &items[..]),
        DeValue::Table(entries) if entries.contains_key("edits") => {
            let table = Section::new("the text", root.span(), entries);
            table.refuse_unknown(report, &["number", "edits"]);
            let number = table.optional(report, "number", None, |node| values::whole(node).map(Some))?;
            let list = table.required(report, "edits", |node| {
                let list = node.get_ref().as_array();
                list.ok_or_else(|| WrongValue::shape(node, "a list of edits"))
            })?;
            (number, &list[..])
        }
        _ => (None, std::slice::from_ref(root)),
    };
    let edits: Vec<_> = (1..)
        .zip(items)
        .map(|(number, node)| edit(report, text, node, number))
        .collect();
    let edits = edits.into_iter().collect::<Option<_>>()?;
    Some(Edits { number, edits })
}

fn edit(report: &mut FaultReport<'_>, text: &str, node: &Node<'_>, number: usize) -> Option<Edit> {
    let table = table(report, node, NAME, number)?;
    table.refuse_unknown(report, &KINDS);
    let mut given = KINDS.into_iter().filter(|kind| table.get(kind).is_some());
    let (Some(kind), None) = (given.next(), given.next()) else {
        table.fault(
            report,
            &table.span,
            format!("must have one of {}", quote_all(KINDS)),
        );
        return None;
    };
    let action = match kind {
        "place" => place(report, &table)?,
        "add" => add(report, &table)?,
        _ => {
            let name = table.required(report, kind, values::text)?;
            match kind {
                "remove" => EditAction::Remove(name),
                "halt" => EditAction::Halt(name),
                "resume" => EditAction::Resume(name),
                "raise" => EditAction::Raise(name),
                _ => EditAction::Lower(name),
            }
        }
    };
    Some(Edit::new(action, &text[node.span()]))
}

fn place(report: &mut FaultReport<'_>, edit: &Section<'_>) -> Option<EditAction> {
    let table = edit.nested(report, "place", &["robot", "x", "y", "heading_deg"])?;
    let robot = table.optional(report, "robot", None, |node| values::text(node).map(Some));
    let pose = starts::pose(report, &table);
    Some(EditAction::Place(robot?, pose?))
}

fn add(report: &mut FaultReport<'_>, edit: &Section<'_>) -> Option<EditAction> {
    let table = edit.nested(report, "add", &fixtures::BOX_KEYS)?;
    let name = table.required(report, "name", values::text);
    let plan = fixtures::rectangular(report, &table, name.clone().unwrap_or_default());
    name.and(plan).map(EditAction::Add)
}
