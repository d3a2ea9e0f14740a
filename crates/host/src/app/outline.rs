//! The top of an application file: its own keys, and which schemas it defines. Looks into no schema and at no plugin.

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_abi::describe::Schema;
use toml::de::{DeTable, DeValue};

use super::Executor;
use super::document::{Section, Text, whole, wrong};
use super::report::{Report, quote};

const KEYS: &[&str] = &[
    "name", "doc", "roots", "plugins", "seed", "mission", "executor", "root", "schemas",
];
/// Longest name of a schema, as of everything that a plugin names.
const LONGEST_NAME: usize = 64;

/// What the top of a file says.
pub(super) struct Outline<'a> {
    pub(super) name: String,
    pub(super) doc: String,
    pub(super) roots: Vec<Text<'a>>,
    pub(super) plugin_dirs: Vec<PathBuf>,
    pub(super) seed: u64,
    pub(super) mission: Option<Text<'a>>,
    pub(super) executor: Executor,
    pub(super) root: Option<Section<'a>>,
    pub(super) drafts: Drafts<'a>,
}

/// The schemas that a file defines, by number and by name.
#[derive(Default)]
pub(super) struct Drafts<'a> {
    list: Vec<Draft<'a>>,
    places: HashMap<&'a str, usize>,
}

/// A schema that a file defines.
pub(super) struct Draft<'a> {
    pub(super) name: &'a str,
    pub(super) section: Section<'a>,
    /// None where the type is missing or unknown, which has been reported.
    pub(super) found: Option<Found>,
}

/// The type of an instance.
#[derive(Clone)]
pub(super) struct Found {
    pub(super) plugin: usize,
    pub(super) number: usize,
    pub(super) schema: Arc<Schema>,
}

/// One instance among the others.
pub(super) struct Here<'d, 'a> {
    pub(super) drafts: &'d Drafts<'a>,
    pub(super) index: usize,
    pub(super) schema: &'d Schema,
}

impl<'d, 'a> Here<'d, 'a> {
    pub(super) fn section(&self) -> &'d Section<'a> {
        &self.drafts.get(self.index).section
    }
}

impl<'a> Outline<'a> {
    /// Reads it; `file` is absolute.
    pub(super) fn read(report: &mut Report, document: &'a DeTable<'a>, file: &Path) -> Self {
        let top = Section::new("the application", 0..0, document);
        top.refuse_unknown(report, KEYS);
        let folder = file.parent().unwrap_or(Path::new("/"));
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        Self {
            name: top
                .text(report, "name")
                .map_or_else(|| stem.into_owned(), |name| name.text.to_owned()),
            doc: top
                .text(report, "doc")
                .map(|doc| doc.text.to_owned())
                .unwrap_or_default(),
            roots: roots(report, &top),
            plugin_dirs: top
                .texts(report, "plugins")
                .unwrap_or_default()
                .into_iter()
                .map(|dir| folder.join(dir.text))
                .collect(),
            seed: seed(report, &top),
            mission: top.text(report, "mission"),
            executor: executor(report, &top),
            root: top.section(report, "root", "`root`"),
            drafts: Drafts::read(report, &top),
        }
    }
}

impl<'a> Drafts<'a> {
    fn read(report: &mut Report, top: &Section<'a>) -> Self {
        let mut drafts = Self::default();
        if top.get("schemas").is_none() {
            report
                .whole("there is no `schemas`, so the application has nothing to run")
                .advise(
                    "define each schema in a table of its own: [schemas.NAME] with type = \"PLUGIN/SCHEMA\"",
                );
        }
        let Some(schemas) = top.section(report, "schemas", "`schemas`") else {
            return drafts;
        };
        for (name, node) in schemas.entries() {
            let what = format!("schema {}", quote(name.text));
            let DeValue::Table(entries) = node.get_ref() else {
                wrong(report, &what, "a table", node);
                continue;
            };
            refuse_bad_name(report, &name);
            drafts.places.insert(name.text, drafts.list.len());
            drafts.list.push(Draft {
                name: name.text,
                section: Section::new(what, name.span.clone(), entries),
                found: None,
            });
        }
        drafts
    }

    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    pub(super) fn iter(&self) -> std::slice::Iter<'_, Draft<'a>> {
        self.list.iter()
    }

    pub(super) fn iter_mut(&mut self) -> std::slice::IterMut<'_, Draft<'a>> {
        self.list.iter_mut()
    }

    pub(super) fn get(&self, index: usize) -> &Draft<'a> {
        &self.list[index]
    }

    /// The type of an instance, where it is known.
    pub(super) fn schema(&self, index: usize) -> Option<&Arc<Schema>> {
        self.list[index].found.as_ref().map(|found| &found.schema)
    }

    /// The name of an instance, quoted.
    pub(super) fn quoted(&self, index: usize) -> String {
        quote(self.list[index].name)
    }

    pub(super) fn place(&self, name: &str) -> Option<usize> {
        self.places.get(name).copied()
    }

    /// The instance of that name; reports it if there is none. `what` names it: "`roots` of the application".
    pub(super) fn find(
        &self,
        report: &mut Report,
        what: &str,
        name: &str,
        span: &Range<usize>,
    ) -> Option<usize> {
        let place = self.place(name);
        if place.is_none() {
            report
                .fault(
                    span,
                    format!("{what} names {}, and there is no such schema", quote(name)),
                )
                .suggest(name, "schemas", self.list.iter().map(|draft| draft.name));
        }
        place
    }
}

fn roots<'a>(report: &mut Report, top: &Section<'a>) -> Vec<Text<'a>> {
    let roots = top.texts(report, "roots");
    let missing = match (top.get("roots"), &roots) {
        (None, _) => Some("there is no `roots`"),
        (Some(node), _) if node.get_ref().as_array().is_some_and(|list| list.is_empty()) => {
            Some("`roots` is empty")
        }
        (Some(_), _) => None,
    };
    if let Some(missing) = missing {
        let message = format!("{missing}, so nothing would ever start");
        let fault = match top.get("roots") {
            Some(node) => report.fault(&node.span(), message),
            None => report.whole(message),
        };
        fault.advise("name the motor schemas of the top level, such as roots = [\"teleop\", \"example\"]; the first wins a collision");
    }
    roots.unwrap_or_default()
}

fn seed(report: &mut Report, top: &Section) -> u64 {
    let Some(node) = top.get("seed") else { return 0 };
    let seed = whole(node.get_ref()).and_then(|seed| u64::try_from(seed).ok());
    if seed.is_none() {
        report
            .fault(
                &node.span(),
                "`seed` of the application is no whole number from 0 to 2^64 - 1",
            )
            .advise("write a number such as seed = 7");
    }
    seed.unwrap_or_default()
}

fn executor(report: &mut Report, top: &Section) -> Executor {
    match top.text(report, "executor") {
        None => Executor::default(),
        Some(text) => match text.text {
            "threads" => Executor::Threads,
            "pool" => Executor::Pool,
            other => {
                report
                    .fault(&text.span, format!("there is no executor {}", quote(other)))
                    .suggest(other, "executors", ["threads", "pool"]);
                Executor::default()
            }
        },
    }
}

fn refuse_bad_name(report: &mut Report, name: &Text) {
    let legal = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.text.is_empty() || name.text.len() > LONGEST_NAME || !name.text.chars().all(legal) {
        report
            .fault(
                &name.span,
                format!("{} cannot be the name of a schema", quote(name.text)),
            )
            .advise("use 1 to 64 letters, digits, `_` and `-`");
    }
}
