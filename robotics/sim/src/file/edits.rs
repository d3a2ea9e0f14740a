//! Reads the text of edits: a table, a list of tables, or a numbered list. All its faults are reported
//! together.

use std::path::Path;

use toml::de::DeValue;

use super::document::{Document, Item, Table};
use super::values::{self, Read};
use super::{fixtures, starts};
use crate::edit::{Action, Edit, Edits};
use crate::error::Fault;

/// The name of the text in faults.
const NAME: &str = "edit";
const KINDS: [&str; 7] = ["place", "add", "remove", "halt", "resume", "raise", "lower"];

/// Reads a text that is not empty.
pub(crate) fn read(text: &str) -> Result<Edits, Vec<Fault>> {
    let document = Document::new(Path::new(NAME), text);
    let edits = match DeValue::parse(text) {
        Ok(root) => parse(&document, text, &root),
        Err(error) => {
            document.fault(&error.span().unwrap_or(0..0), error.message());
            None
        }
    };
    let faults = document.into_faults();
    edits.filter(|_| faults.is_empty()).ok_or(faults)
}

fn parse(document: &Document<'_>, text: &str, root: &Item<'_>) -> Option<Edits> {
    let (number, items) = match root.get_ref() {
        DeValue::Array(items) => (None, &items[..]),
        DeValue::Table(keys) if keys.contains_key("edits") => {
            let known = ["number", "edits"];
            let table = Table::new(document, keys, root.span(), "edits".to_owned(), &known);
            (
                table.optional("number", None, |item| whole(item).map(Some))?,
                table.array("edits"),
            )
        }
        _ => (None, std::slice::from_ref(root)),
    };
    let edits: Vec<_> = (1..)
        .zip(items)
        .map(|(number, item)| edit(document, text, item, number))
        .collect();
    let edits = edits.into_iter().collect::<Option<_>>()?;
    Some(Edits { number, edits })
}

fn edit<'a>(document: &'a Document<'a>, text: &str, item: &'a Item<'a>, number: usize) -> Option<Edit> {
    let table = Table::item(document, item, NAME, number, &KINDS)?;
    let mut given = KINDS.into_iter().filter(|kind| table.get(kind).is_some());
    let (Some(kind), None) = (given.next(), given.next()) else {
        table.fault(table.span(), format!("expected one of `{}`", KINDS.join("`, `")));
        return None;
    };
    let name = || table.required(kind, values::text);
    let action = match kind {
        "place" => place(document, table.get(kind)?)?,
        "add" => add(document, table.get(kind)?)?,
        "remove" => Action::Remove(name()?),
        "halt" => Action::Halt(name()?),
        "resume" => Action::Resume(name()?),
        "raise" => Action::Raise(name()?),
        _ => Action::Lower(name()?),
    };
    Some(Edit::new(action, &text[item.span()]))
}

fn place<'a>(document: &'a Document<'a>, item: &'a Item<'a>) -> Option<Action> {
    let table = Table::nested(document, item, "place", &["robot", "x", "y", "heading_deg"])?;
    let robot = table.optional("robot", None, |item| values::text(item).map(Some));
    let pose = starts::pose(&table);
    Some(Action::Place(robot?, pose?))
}

fn add<'a>(document: &'a Document<'a>, item: &'a Item<'a>) -> Option<Action> {
    let table = Table::nested(document, item, "add", &fixtures::BOX_KEYS)?;
    let name = table.required("name", values::text);
    let plan = fixtures::rectangular(&table, name.clone().unwrap_or_default());
    name.and(plan).map(Action::Add)
}

fn whole(item: &Item<'_>) -> Read<u64> {
    let number = match item.get_ref() {
        DeValue::Integer(integer) => u64::from_str_radix(integer.as_str(), integer.radix()).ok(),
        _ => None,
    };
    number.ok_or_else(|| (item.span(), "is not a whole number from 0".to_owned()))
}
