//! Writes values of modulations into an application's file: each takes the place of the old one, in the unit that is written
//! there, and everything else stays as it is. Overwrites no value that somebody has changed in the file meanwhile.

mod same;
#[cfg(test)]
mod tests;

use std::fs;
use std::io::{self, Read, Write};
use std::ops::Range;
use std::path::Path;

use jde_abi::describe::Type;
use jde_board::value::Value;
use jde_document::section::{Node, Section};
use jde_document::{FaultReport, Faults, parse, quote, read};

use super::time;
use super::units::{quantity, split};
use super::values::{ValueTarget, is_path};

pub use same::is_same;
use same::{has_field, only};

/// The kind of the file, in messages.
const KIND: &str = "an application file";
/// The byte order mark, with which some editors begin a file.
const MARK: &str = "\u{feff}";
/// The key of a schema's period, which is a modulation of every schema.
const PERIOD: &str = "period";
/// The key that every schema has.
const TYPE: &str = "type";
/// Digits of a number that a conversion of units does not change.
const DIGITS: usize = 15;

/// A value for a modulation in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// The schema.
    pub schema: String,
    /// The name of the modulation, or `period`.
    pub name: String,
    /// The name that it had before, which the file may state.
    pub former_name: Option<String>,
    /// Its type.
    pub value_type: Type,
    /// The unit of a plain number; empty if there is none.
    pub unit: String,
    /// For an enumeration: the names of its numbers.
    pub choices: Vec<String>,
    /// What the file stated when it was last read, or the default of the type; `None` if whatever it states now is overwritten.
    pub before: Option<Value>,
    /// The value to write.
    pub now: Value,
    /// Whether this is the value of the run's start again, which a file that does not state it has already.
    pub is_back: bool,
}

/// A piece of a file and what takes its place.
struct Edit {
    place: Range<usize>,
    text: String,
    /// What is written, for people: "goon.fast = 0.4".
    line: String,
}

/// The text of a file, and the folder of its paths.
struct Source<'s> {
    text: &'s str,
    folder: &'s Path,
}

/// Writes values into a file, which is replaced as a whole. Returns the lines that are written: "fast = 0.4". Waits for the
/// disk.
///
/// # Errors
/// All reasons: the file cannot be read or written, is no application file, does not have a schema, or states a value that
/// is neither the one before nor the one to write; or its form does not permit the edit. Nothing is written then.
pub fn save(file: &Path, tunings: &[Tuning]) -> Result<Vec<String>, Faults> {
    let text = read(file, KIND)?;
    let mut report = FaultReport::new(file, &text);
    if fs::metadata(file).is_ok_and(|about| about.permissions().readonly()) {
        let fault = report.file_fault("it is read-only, so nothing is written");
        fault.advise(format!("`chmod u+w {}` permits it", file.display()));
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    let source = Source { text: &text, folder };
    let edits = source.edits(&mut report, tunings);
    report.finish()?;
    let mut edited = text.clone();
    for edit in edits.iter().rev() {
        edited.replace_range(edit.place.clone(), &edit.text);
    }
    let lines: Vec<_> = edits.into_iter().map(|edit| edit.line).collect();
    // Whatever form the file has, only what states the values takes its place.
    let mut report = FaultReport::new(file, &edited);
    let source = Source {
        text: &edited,
        folder,
    };
    if !source.edits(&mut report, tunings).is_empty() || report.count() > 0 {
        let mut report = FaultReport::new(file, "");
        let fault = report.file_fault("its form does not permit this edit, so nothing is written");
        fault.advise(format!("write the values yourself: {}", lines.join(", ")));
        return Err(report.into_faults());
    }
    if read(file, KIND)? != text {
        return Err(of_file(
            file,
            "it changed while it was edited, so nothing is written; save again",
        ));
    }
    let written = has_mark(file).and_then(|has_mark| {
        if has_mark {
            edited.insert_str(0, MARK);
        }
        jde_files::replace(file, |output| output.write_all(edited.as_bytes()))
    });
    written.map_err(|error| of_file(file, &format!("it cannot be written: {error}")))?;
    Ok(lines)
}

/// Whether a file begins with a byte order mark, which [`read`] leaves out.
fn has_mark(file: &Path) -> io::Result<bool> {
    let mut start = Vec::new();
    fs::File::open(file)?
        .take(MARK.len() as u64)
        .read_to_end(&mut start)?;
    Ok(start == MARK.as_bytes())
}

fn of_file(file: &Path, message: &str) -> Faults {
    let mut report = FaultReport::new(file, "");
    report.file_fault(message);
    report.into_faults()
}

impl Source<'_> {
    /// Returns the edits that state all values, in the order of their places.
    fn edits(&self, report: &mut FaultReport, tunings: &[Tuning]) -> Vec<Edit> {
        let mut edits = Vec::new();
        if let Some(document) = parse(report, self.text) {
            let schemas = document.get_ref().get("schemas");
            let schemas = schemas.and_then(|schemas| schemas.get_ref().as_table());
            for tuning in tunings {
                let node = schemas.and_then(|schemas| schemas.get(tuning.schema.as_str()));
                edits.extend(tuning.edits(report, self, node));
            }
        }
        edits.sort_by_key(|edit| edit.place.start);
        edits
    }
}

impl Tuning {
    /// Returns the edits that state its value; none if the file does already.
    fn edits(&self, report: &mut FaultReport, source: &Source, node: Option<&Node>) -> Vec<Edit> {
        let label = format!("schema {}", quote(&self.schema));
        let found = node.and_then(|node| Some((node.span(), node.get_ref().as_table()?)));
        let Some((span, entries)) = found else {
            report.file_fault(format!(
                "it has no {label}, of which {} is to be written",
                quote(&self.name)
            ));
            return Vec::new();
        };
        let section = Section::new(label, span, entries);
        let names = [Some(self.name.as_str()), self.former_name.as_deref()];
        let stated = names
            .into_iter()
            .flatten()
            .find_map(|name| Some((name, section.get(name)?)));
        let Some((name, old)) = stated else {
            if self.is_back {
                return Vec::new();
            }
            return self.addition(report, source, &section).into_iter().collect();
        };
        match self.stated(report, source, &section, old) {
            None => Vec::new(),
            Some(stated) if is_same(&stated, &self.now) => Vec::new(),
            Some(stated)
                if self
                    .before
                    .as_ref()
                    .is_some_and(|before| !is_same(&stated, before)) =>
            {
                let message = format!("{} was changed here since the run began", section.key(name));
                let now = self.literal(source, &self.now, "");
                let advice = format!("`jde tuned --save --overwrite` writes {name} = {now} all the same");
                report.fault(&old.span(), message).advise(advice);
                Vec::new()
            }
            Some(_) => self.replacements(report, source, (name, old), &self.now),
        }
    }

    /// Reads the value that the file states.
    fn stated(
        &self,
        report: &mut FaultReport,
        source: &Source,
        section: &Section,
        old: &Node,
    ) -> Option<Value> {
        if self.name == PERIOD {
            let period = time::period(report, &section.key(PERIOD), old)?;
            return Some(Value::Float(period as f64 / 1e9));
        }
        if !self.choices.is_empty() {
            let choice = old.get_ref().as_str().unwrap_or_default();
            let number = self.choices.iter().position(|known| known == choice);
            // The name of no choice is the same as no number.
            let unknown = || Value::Text(choice.to_owned());
            return Some(number.map_or_else(unknown, |number| Value::UInt(number as u64)));
        }
        let target = ValueTarget {
            name: self.name.clone(),
            owner: &section.label,
            unit: &self.unit,
            folder: source.folder,
        };
        target.value(report, &self.value_type, old)
    }

    /// Puts a value in the place of another one.
    fn replacements(
        &self,
        report: &mut FaultReport,
        source: &Source,
        (name, old): (&str, &Node),
        now: &Value,
    ) -> Vec<Edit> {
        let span = old.span();
        let before = &source.text[span.clone()];
        // The value of a type with one field is that field, which the file may state by its name.
        let table = old.get_ref().as_table();
        if let Some((key, inner)) = table.and_then(|table| table.iter().next())
            && !has_field(now, key.get_ref())
        {
            return self.replacements(report, source, (name, inner), now);
        }
        let (Some(table), Value::Map(fields)) = (table, now) else {
            let text = self.literal(source, now, before);
            return vec![Edit {
                line: format!("{}.{name} = {text}", self.schema),
                place: span,
                text,
            }];
        };
        // Each field by itself, so that a table keeps its form, whether it is in one line or has a header.
        let mut edits = Vec::new();
        for (name, value) in fields {
            match table.iter().find(|(key, _)| key.get_ref() == name.as_str()) {
                Some((_, old)) => edits.extend(self.replacements(report, source, (name, old), value)),
                None => {
                    let advice = format!(
                        "write it here yourself: {name} = {}",
                        self.literal(source, value, "")
                    );
                    let message = format!("{} of {} is not stated here", quote(name), quote(&self.name));
                    report.fault(&span, message).advise(advice);
                }
            }
        }
        edits
    }

    /// Adds the key beside that of the schema's type.
    fn addition(&self, report: &mut FaultReport, source: &Source, section: &Section) -> Option<Edit> {
        let Some((key, value)) = section.entries().find(|(key, _)| key.text == TYPE) else {
            report.fault(&section.span, format!("{} has no type", section.label));
            return None;
        };
        let (text, pair) = (
            source.text,
            format!("{} = {}", self.name, self.literal(source, &self.now, "")),
        );
        let line = format!("{}.{pair}", self.schema);
        let end = value.span().end;
        if text[section.span.clone()].starts_with('{') {
            return Some(Edit {
                place: end..end,
                text: format!(", {pair}"),
                line,
            });
        }
        let end = text[end..]
            .find(['\r', '\n'])
            .map_or(text.len(), |length| end + length);
        // The table before a dotted key, such as `goon.type`.
        let begin = text[..key.span.start].rfind('\n').map_or(0, |end| end + 1);
        // The last line may have no ending, and then has that of the line before.
        let has_return = match &text[end..] {
            "" => text[..begin].ends_with("\r\n"),
            rest => rest.starts_with("\r\n"),
        };
        let ending = if has_return { "\r\n" } else { "\n" };
        Some(Edit {
            place: end..end,
            text: format!("{ending}{}{pair}", &text[begin..key.span.start]),
            line,
        })
    }

    /// A value as TOML, in the form and the unit of the text that it replaces.
    fn literal(&self, source: &Source, value: &Value, before: &str) -> String {
        match only(value) {
            Value::Bool(flag) => flag.to_string(),
            Value::Text(text) => {
                let path = Path::new(text).strip_prefix(source.folder).ok();
                let path = path.filter(|_| is_path(&self.unit, text)).and_then(Path::to_str);
                toml::Value::from(path.unwrap_or(text)).to_string()
            }
            Value::Int(number) => self.whole(i128::from(*number)),
            Value::UInt(number) => self.whole(i128::from(*number)),
            Value::Float(number) => self.quantity(*number, before),
            Value::List(list) => {
                let list: Vec<_> = list.iter().map(|value| self.literal(source, value, "")).collect();
                format!("[{}]", list.join(", "))
            }
            Value::Map(fields) => {
                let fields: Vec<_> = fields
                    .iter()
                    .map(|(_, value)| self.literal(source, value, ""))
                    .collect();
                format!("[{}]", fields.join(", "))
            }
        }
    }

    /// A whole number, or the name of a choice.
    fn whole(&self, number: i128) -> String {
        let index = usize::try_from(number).ok();
        match index.and_then(|index| self.choices.get(index)) {
            Some(choice) => toml::Value::from(choice.as_str()).to_string(),
            None => number.to_string(),
        }
    }

    /// A number in the unit of the text that it replaces.
    fn quantity(&self, number: f64, before: &str) -> String {
        let before = before.trim_matches(['"', '\'']).trim();
        let unit = split(before).map_or("", |(_, unit)| unit);
        let per_unit = quantity(&format!("1 {unit}"), &self.unit).ok();
        match per_unit.filter(|_| !unit.is_empty()) {
            Some(per_unit) => {
                let gap = if before.ends_with(&format!(" {unit}")) {
                    " "
                } else {
                    ""
                };
                format!("\"{}{gap}{unit}\"", rounded(number / per_unit))
            }
            None => format!("{:?}", rounded(number)),
        }
    }
}

/// A number without the noise of conversions.
fn rounded(number: f64) -> f64 {
    // A number of 32 bits has a shorter form as such.
    let short = number as f32;
    let text = match f64::from(short) == number {
        true => short.to_string(),
        false => format!("{number:.*e}", DIGITS - 1),
    };
    text.parse().unwrap_or(number)
}
