//! The `isolate` key of a schema, which runs it in its own process with limits. Starts no process.

use serde::{Deserialize, Serialize};
use toml::de::DeValue;

use super::time;
use jde_document::section::{Node, Section, WordOrTable, integer};
use jde_document::{FaultReport, quote};

/// A process of its own, and its limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Isolation {
    /// The most memory, bytes: heap and stacks. No limit if `None`.
    pub memory: Option<u64>,
    /// The most processor time from the start of one call to the start of the next, s. No limit if `None`.
    pub cpu: Option<u64>,
    /// Whether it may use the network beyond this machine.
    pub network: bool,
    /// Whether it may only read files.
    pub read_only: bool,
}

impl Default for Isolation {
    fn default() -> Self {
        Self {
            memory: None,
            cpu: None,
            network: true,
            read_only: false,
        }
    }
}

/// Reads `isolate = "process"`, or `{ memory = "200 MB", cpu = "2s", network = false, files = "read-only" }`.
pub(super) fn isolation(report: &mut FaultReport, section: &Section) -> Option<Isolation> {
    const EXPECTED: &str =
        "\"process\", or a table of its limits such as { memory = \"200 MB\", network = false }";
    let table = match section.word_or_table(report, "isolate", EXPECTED)? {
        WordOrTable::Table(table) => table,
        WordOrTable::Word(mode) => {
            if mode.text != "process" {
                let (what, mode_name) = (section.key("isolate"), quote(mode.text));
                report
                    .fault(
                        &mode.span,
                        format!("{what} is {mode_name}, which is not a way to isolate"),
                    )
                    .suggest(mode.text, "ways", ["process"]);
            }
            return Some(Isolation::default());
        }
    };
    table.refuse_unknown(report, &["memory", "cpu", "network", "files"]);
    Some(Isolation {
        memory: table
            .get("memory")
            .and_then(|node| memory(report, &table.key("memory"), node)),
        cpu: time::of(report, &table, "cpu").map(|time| time.div_ceil(1_000_000_000)),
        network: table.flag(report, "network").unwrap_or(true),
        read_only: read_only(report, &table),
    })
}

fn read_only(report: &mut FaultReport, table: &Section) -> bool {
    let Some(files) = table.text(report, "files") else {
        return false;
    };
    if files.text != "read-only" {
        report
            .fault(
                &files.span,
                format!("{} is {}", table.key("files"), quote(files.text)),
            )
            .advise("write files = \"read-only\", or leave it out");
    }
    true
}

/// Reads a number of bytes, or a text such as "200 MB".
fn memory(report: &mut FaultReport, what: &str, node: &Node) -> Option<u64> {
    let bytes = match node.get_ref() {
        DeValue::String(text) => bytes(text),
        value => integer(value).and_then(|bytes| u64::try_from(bytes).ok()),
    };
    let bytes = bytes.filter(|bytes| *bytes > 0);
    if bytes.is_none() {
        report
            .fault(&node.span(), format!("{what} is not a size of memory"))
            .advise("write a size such as \"200 MB\" or \"1 GiB\", or a number of bytes");
    }
    bytes
}

fn bytes(text: &str) -> Option<u64> {
    let text = text.trim();
    let unit = text.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let number: f64 = text[..text.len() - unit.len()].parse().ok()?;
    let factor = match unit.trim() {
        "" | "B" => 1.0,
        "kB" => 1e3,
        "MB" => 1e6,
        "GB" => 1e9,
        "KiB" => 1024.0,
        "MiB" => 1048576.0,
        "GiB" => 1073741824.0,
        _ => return None,
    };
    Some((number * factor) as u64)
}

#[cfg(test)]
mod tests {
    use super::bytes;

    #[test]
    fn sizes_of_memory_are_read_with_their_units() {
        let check = |text, expected| assert_eq!(bytes(text), expected, "{text}");
        check("200 MB", Some(200_000_000));
        check("1.5 GB", Some(1_500_000_000));
        check("64MiB", Some(64 << 20));
        check("4096", Some(4096));
        for text in ["", "MB", "much", "-1 MB", "1 mb", "1 MB/s"] {
            check(text, None);
        }
    }
}
