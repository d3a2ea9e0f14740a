//! The pages that nobody writes: every schema of every plugin, every type of value, and every verb, as the
//! executable describes them.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result};
use serde::Deserialize;
use serde_json::Value;

use super::Chapter;
use crate::metadata::Package;
use crate::shell;

const FOLDER: &str = "docs/reference";

/// What `jde describe PLUGIN --json` prints, as far as a page shows it.
#[derive(Deserialize)]
struct Plugin {
    name: String,
    doc: String,
    schemas: Vec<Schema>,
}

#[derive(Deserialize)]
struct Schema {
    name: String,
    kind: String,
    doc: String,
    period_ns: f64,
    budget_ns: f64,
    ports: Vec<Port>,
    children: Vec<Child>,
}

#[derive(Deserialize)]
struct Port {
    name: String,
    role: String,
    #[serde(rename = "type")]
    value_type: String,
    unit: String,
    doc: String,
    optional: bool,
    #[serde(default)]
    trigger: bool,
    #[serde(default)]
    default: Value,
    #[serde(default)]
    min: Value,
    #[serde(default)]
    max: Value,
}

#[derive(Deserialize)]
struct Child {
    role: String,
    group: Option<String>,
    doc: String,
}

/// Writes the pages beside the others. Returns them as chapters.
pub(super) fn write(programs: &Path, plugins: &[&Package], source: &Path) -> Result<Vec<Chapter>> {
    fs::create_dir_all(source.join(FOLDER))?;
    let jde = |arguments: &[&str]| {
        let mut jde = Command::new(programs.join("jde"));
        shell::read(
            jde.args(arguments)
                .env("JDE_PLUGIN_PATH", programs)
                .env("COLUMNS", "100"),
        )
    };
    let page = |name: &str, title: &str, text: &str| -> Result<Chapter> {
        let path = format!("{FOLDER}/{name}.md");
        fs::write(source.join(&path), format!("# {title}\n\n{text}"))?;
        Ok(Chapter {
            title: title.to_owned(),
            path,
            pages: Vec::new(),
        })
    };
    let mut types = BTreeSet::new();
    let mut pages = Vec::new();
    let mut list = "| plugin | |\n|---|---|\n".to_owned();
    for package in plugins {
        let plugin: Plugin = serde_json::from_str(&jde(&["describe", &package.name, "--json"])?)
            .with_context(|| format!("the description of {} has an unknown form", package.name))?;
        let ports = plugin.schemas.iter().flat_map(|schema| &schema.ports);
        types.extend(ports.map(|port| port.value_type.clone()));
        let _ = writeln!(list, "| [{0}]({0}.md) | {1} |", plugin.name, cell(&plugin.doc));
        pages.push(page(&plugin.name, &plugin.name, &plugin.text())?);
    }
    let all = page("plugins", "Plugins", &list)?;
    let mut text = String::new();
    for value_type in &types {
        let described = jde(&["describe", value_type])?;
        let _ = write!(
            text,
            "## {value_type}\n\n```text\n{}\n```\n\n",
            described.trim_end()
        );
    }
    let values = page("types", "Types of value", &text)?;
    let mut text = format!("```text\n{}\n```\n\n", jde(&["--help"])?.trim_end());
    for verb in verbs(&jde, &source.join("man"))? {
        let help = jde(&[&verb, "--help"])?;
        let _ = write!(text, "## jde {verb}\n\n```text\n{}\n```\n\n", help.trim_end());
    }
    let verbs = page("verbs", "Verbs", &text)?;
    Ok(vec![Chapter { pages, ..all }, values, verbs])
}

/// Returns the names of all verbs: those that have a manual page.
fn verbs(jde: &impl Fn(&[&str]) -> Result<String>, folder: &Path) -> Result<Vec<String>> {
    jde(&["man", &folder.to_string_lossy()])?;
    let mut verbs = Vec::new();
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        let verb = name.strip_prefix("jde-").and_then(|name| name.strip_suffix(".1"));
        // `jde-new-app.1` is the page of a kind of `jde new`.
        verbs.extend(verb.filter(|verb| !verb.contains('-')).map(str::to_owned));
    }
    fs::remove_dir_all(folder)?;
    verbs.sort();
    Ok(verbs)
}

impl Plugin {
    fn text(&self) -> String {
        let mut text = format!("{}\n\n", self.doc);
        for schema in &self.schemas {
            let milliseconds = |time: f64| time / 1e6;
            let _ = write!(
                text,
                "## {}/{}\n\n*{}, every {} ms, at most {} ms an iteration*\n\n{}\n\n",
                self.name,
                schema.name,
                schema.kind,
                milliseconds(schema.period_ns),
                milliseconds(schema.budget_ns),
                schema.doc
            );
            if !schema.ports.is_empty() {
                text.push_str("| port | | type | default | meaning |\n|---|---|---|---|---|\n");
            }
            schema.ports.iter().for_each(|port| port.push(&mut text));
            text.push('\n');
            if !schema.children.is_empty() {
                text.push_str("| child | group | |\n|---|---|---|\n");
            }
            for Child { role, group, doc } in &schema.children {
                let _ = writeln!(
                    text,
                    "| `{role}` | {} | {} |",
                    group.as_deref().unwrap_or_default(),
                    cell(doc)
                );
            }
            text.push('\n');
        }
        text
    }
}

impl Port {
    /// Appends the port as a row of a table.
    fn push(&self, text: &mut String) {
        let mut role = self.role.clone();
        for (is_so, word) in [(self.optional, ", optional"), (self.trigger, ", triggers")] {
            role.push_str(if is_so { word } else { "" });
        }
        let value = |value: &Value| {
            (!value.is_null()).then(|| format!("{value} {}", self.unit).trim_end().to_owned())
        };
        let limits = [
            ("", &self.default),
            ("at least ", &self.min),
            ("at most ", &self.max),
        ];
        let limits = limits
            .iter()
            .filter_map(|(word, limit)| Some(format!("{word}{}", value(limit)?)));
        let limits = limits.collect::<Vec<_>>().join(", ");
        let _ = writeln!(
            text,
            "| `{}` | {role} | [{}](types.md#{}) | {} | {} |",
            self.name,
            self.value_type,
            self.value_type.to_lowercase().replace('/', ""),
            cell(&limits),
            cell(&self.doc)
        );
    }
}

/// Returns a text in the form of a cell of a table: one line without its separator.
fn cell(text: &str) -> String {
    text.split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .replace('|', "\\|")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_is_a_row_with_its_unit_and_limits() {
        let port: Port = serde_json::from_str(
            r#"{"name":"rate","role":"modulation","type":"std_msgs/msg/Float64","unit":"rad/s","doc":"A | B\nC.",
                "optional":false,"default":0.8,"min":0.0,"max":null}"#,
        )
        .unwrap();
        let mut text = String::new();
        port.push(&mut text);
        assert_eq!(
            text,
            "| `rate` | modulation | [std_msgs/msg/Float64](types.md#std_msgsmsgfloat64) | 0.8 rad/s, at least 0.0 rad/s | A \\| B C. |\n"
        );
    }
}
