//! Imports of variables that another application exports: `robot2:pioneer.odometry`. Their types are those of
//! the importing ports. Whether the other application has such a variable is known only once it is connected.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use jde_abi::describe::{Port, Type};
use jde_core::Nanos;

use super::drafts::is_legal_name;
use super::link::Link;
use super::time;
use super::variable;
use jde_document::section::{Section, Text, WordOrTable};
use jde_document::{FaultReport, quote};

/// An imported variable of another application. On the board it is an export that the link writes. It has no
/// value before the first one arrives, after the last one has expired, and while the other application is
/// gone.
#[derive(Clone, Debug, PartialEq)]
pub struct RemoteVariable {
    /// The other application's name on the link.
    pub peer: String,
    /// The variable's full name there: `pioneer.odometry`.
    pub variable: String,
    /// Its full local name, on the board: `robot2:pioneer.odometry`.
    pub local: String,
    /// The type of the importing ports.
    pub value_type: Arc<Type>,
    /// The unit of the importing ports; empty if none of them names one.
    pub unit: String,
    /// The age at which a value is retracted, ns.
    pub stale_ns: Nanos,
}

impl RemoteVariable {
    /// The writer in the stamps of such values.
    pub const WRITER: u32 = u32::MAX - 2;

    /// Returns the local owner and name of the variable: `robot2:pioneer` and `odometry`.
    #[must_use]
    pub fn parts(&self) -> (&str, &str) {
        // Both parts are checked when the file is read.
        self.local.split_once('.').unwrap_or((&self.local, ""))
    }
}

/// An entry of `imports`: the text, and the age limit if it states one.
pub(super) struct ImportEntry<'a> {
    pub(super) role: Text<'a>,
    pub(super) from: Text<'a>,
    stale: Option<(Nanos, Range<usize>)>,
}

/// The remote variables of an application, collected while the imports are read.
pub(super) struct RemoteVariables<'l> {
    link: &'l Link,
    list: Vec<RemoteImport>,
    /// Their places in the list, by their full local names.
    places: HashMap<String, usize>,
}

struct RemoteImport {
    remote: RemoteVariable,
    /// Whether an import states the age limit.
    stated: bool,
}

/// Reads `imports`: each entry is a text, or a table with `from` and `stale`.
pub(super) fn entries<'a>(report: &mut FaultReport, section: &Section<'a>) -> Vec<ImportEntry<'a>> {
    let Some(table) = section.section(report, "imports", section.key("imports")) else {
        return Vec::new();
    };
    let entries = table.entries();
    entries
        .filter_map(|(role, _)| entry(report, &table, role))
        .collect()
}

fn entry<'a>(report: &mut FaultReport, table: &Section<'a>, role: Text<'a>) -> Option<ImportEntry<'a>> {
    const EXPECTED: &str =
        "a text, or a table such as { from = \"robot2:pioneer.odometry\", stale = \"300ms\" }";
    match table.word_or_table(report, role.text, EXPECTED)? {
        WordOrTable::Word(from) => Some(ImportEntry {
            role,
            from,
            stale: None,
        }),
        WordOrTable::Table(inner) => {
            inner.refuse_unknown(report, &["from", "stale"]);
            if inner.get("from").is_none() {
                report
                    .fault(&inner.span, format!("{} has no `from`", inner.label))
                    .advise("name the variable, as in from = \"robot2:pioneer.odometry\"");
            }
            let from = inner.text(report, "from");
            let stale = inner
                .get("stale")
                .and_then(|node| Some((time::of(report, &inner, "stale")?, node.span())));
            Some(ImportEntry {
                role,
                from: from?,
                stale,
            })
        }
    }
}

impl ImportEntry<'_> {
    /// Whether it names another application.
    pub(super) fn is_remote(&self) -> bool {
        self.from.text.contains(':')
    }

    /// The age limit of an import from this application, ns, if it states one.
    pub(super) fn local_stale(&self) -> Option<Nanos> {
        let (stale, _) = self.stale.as_ref().filter(|_| !self.is_remote())?;
        Some(*stale)
    }
}

impl<'l> RemoteVariables<'l> {
    pub(super) fn new(link: &'l Link) -> Self {
        let (list, places) = (Vec::new(), HashMap::new());
        Self { link, list, places }
    }

    pub(super) fn into_list(self) -> Vec<RemoteVariable> {
        self.list.into_iter().map(|found| found.remote).collect()
    }

    /// Returns the place of the variable that an import names, for a port; reports its faults.
    pub(super) fn find(
        &mut self,
        report: &mut FaultReport,
        what: &str,
        entry: &ImportEntry,
        port: &Port,
    ) -> Option<usize> {
        let (peer, name) = self.parse_name(report, what, &entry.from)?;
        let local = format!("{peer}:{name}");
        let unit = variable::unit(port).unwrap_or_default();
        let Some(place) = self.places.get(&local).copied() else {
            self.places.insert(local.clone(), self.list.len());
            let stale_ns = entry
                .stale
                .as_ref()
                .map_or(self.link.stale_ns, |(stale, _)| *stale);
            self.list.push(RemoteImport {
                remote: RemoteVariable {
                    peer: peer.to_owned(),
                    variable: name.to_owned(),
                    local,
                    value_type: Arc::clone(&port.value_type),
                    unit: unit.to_owned(),
                    stale_ns,
                },
                stated: entry.stale.is_some(),
            });
            return Some(self.list.len() - 1);
        };
        let found = &mut self.list[place];
        found
            .check_agreement(report, what, entry, port, unit)
            .then_some(place)
    }

    fn parse_name<'e>(
        &self,
        report: &mut FaultReport,
        what: &str,
        from: &Text<'e>,
    ) -> Option<(&'e str, &'e str)> {
        let (peer, name) = from.text.split_once(':')?;
        let owned = name.split_once('.');
        if !Link::is_name(peer)
            || !owned.is_some_and(|(owner, name)| is_legal_name(owner) && is_legal_name(name))
        {
            report
                .fault(
                    &from.span,
                    format!(
                        "{what} is {}, which names no variable of another application",
                        quote(from.text)
                    ),
                )
                .advise("write NAME:SCHEMA.VARIABLE, such as \"robot2:pioneer.odometry\"");
            return None;
        }
        if peer == self.link.name {
            report
                .fault(
                    &from.span,
                    format!(
                        "{what} is {}, and {} is this application itself",
                        quote(from.text),
                        quote(peer)
                    ),
                )
                .advise(format!("write \"{name}\", or give the link another `name`"));
            return None;
        }
        if self.link.off {
            report
                .fault(
                    &from.span,
                    format!("{what} is {}, and the link is off", quote(from.text)),
                )
                .advise("remove off = true from `[link]`, or import a variable of this application");
            return None;
        }
        Some((peer, name))
    }
}

impl RemoteImport {
    /// Checks that another import agrees on the variable; reports differences.
    fn check_agreement(
        &mut self,
        report: &mut FaultReport,
        what: &str,
        entry: &ImportEntry,
        port: &Port,
        unit: &str,
    ) -> bool {
        let remote = &mut self.remote;
        let (span, full) = (&entry.from.span, quote(&remote.local));
        if !remote.value_type.same_as(&port.value_type) {
            let (takes, other) = (quote(&port.value_type.name), quote(&remote.value_type.name));
            report
                .fault(
                    span,
                    format!("{what} takes {full} as {takes}, and another import takes it as {other}"),
                )
                .advise("one variable has one type: one of the two means another variable");
            return false;
        }
        if remote.unit.is_empty() {
            unit.clone_into(&mut remote.unit);
        } else if !unit.is_empty() && !jde_abi::unit::same(unit, &remote.unit) {
            let (takes, other) = (quote(unit), quote(&remote.unit));
            report.fault(
                span,
                format!("{what} takes {full} in {takes}, and another import takes it in {other}"),
            );
            return false;
        }
        let Some((stale, span)) = &entry.stale else {
            return true;
        };
        if self.stated && remote.stale_ns != *stale {
            report
                .fault(
                    span,
                    format!("{what} and another import of {full} state different `stale`"),
                )
                .advise("state it once; it holds for all that import the variable");
            return false;
        }
        (remote.stale_ns, self.stated) = (*stale, true);
        true
    }
}
