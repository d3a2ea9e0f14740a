//! The top of an application file: its own keys, and which schemas it defines. Looks into no schema and at no plugin.

use std::path::{Path, PathBuf};

use toml::de::DeTable;

use super::Executor;
use super::document::{Section, Text, whole};
use super::drafts::Drafts;
use super::link::{self, Link};
use super::report::{Report, quote};

const KEYS: &[&str] = &[
    "name", "doc", "roots", "plugins", "seed", "mission", "executor", "root", "schemas", "link",
];

/// What the top of a file says.
pub(super) struct Outline<'a> {
    pub(super) name: String,
    pub(super) doc: String,
    pub(super) roots: Roots<'a>,
    pub(super) plugin_dirs: Vec<PathBuf>,
    pub(super) seed: u64,
    pub(super) mission: Option<Text<'a>>,
    pub(super) executor: Executor,
    pub(super) root: Option<Section<'a>>,
    pub(super) link: Link,
    pub(super) drafts: Drafts<'a>,
}

/// The names of the top level.
pub(super) struct Roots<'a> {
    pub(super) names: Vec<Text<'a>>,
    /// None was lost, as is one that is no text.
    pub(super) complete: bool,
}

impl<'a> Outline<'a> {
    /// Reads it; `file` is absolute.
    pub(super) fn read(report: &mut Report, document: &'a DeTable<'a>, file: &Path) -> Self {
        let top = Section::new("the application", 0..0, document);
        top.refuse_unknown(report, KEYS);
        let folder = file.parent().unwrap_or(Path::new("/"));
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        let name = top
            .text(report, "name")
            .map_or_else(|| stem.into_owned(), |name| name.text.to_owned());
        Self {
            link: link::read(report, &top, &name, folder),
            name,
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

fn roots<'a>(report: &mut Report, top: &Section<'a>) -> Roots<'a> {
    const ADVICE: &str = "name the motor schemas of the top level, such as roots = [\"teleop\", \"example\"]; the first wins a collision";
    let names = top.texts(report, "roots").unwrap_or_default();
    let written = match top.get("roots") {
        None => {
            report
                .whole("there is no `roots`, so nothing would ever start")
                .advise(ADVICE);
            None
        }
        Some(node) => node.get_ref().as_array().map(|list| list.len()),
    };
    if written == Some(0) {
        report
            .fault(
                &top.key_span("roots"),
                "`roots` is empty, so nothing would ever start",
            )
            .advise(ADVICE);
    }
    Roots {
        complete: written == Some(names.len()),
        names,
    }
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
