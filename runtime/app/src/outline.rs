//! The top level of an application file: its own keys, and the names of its schemas. Reads no schema and no
//! plugin.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use toml::de::DeTable;

use super::Executor;
use super::drafts::{Drafts, refuse_bad_name};
use super::link::{self, Link};
use super::recorded;
use super::time;
use super::web::{self, Web};
use jde_document::section::{Section, Text, integer};
use jde_document::{FaultReport, quote};

const KEYS: &[&str] = &[
    "name",
    "doc",
    "roots",
    "awake",
    "interfaces",
    "plugins",
    "seed",
    "mission",
    "faults",
    "executor",
    "root",
    "schemas",
    "link",
    "web",
];

/// The most folders of one list: each name is searched for in each folder.
const MAX_FOLDERS: usize = 100;

/// The contents of the top level.
pub(super) struct Outline<'a> {
    pub(super) name: String,
    pub(super) doc: String,
    pub(super) roots: Roots<'a>,
    /// The schemas that every root needs.
    pub(super) awake: Vec<Text<'a>>,
    pub(super) plugin_dirs: Vec<PathBuf>,
    /// The folders of definitions of types.
    pub(super) interfaces: Vec<PathBuf>,
    /// The definitions in recordings, by the names of the types.
    pub(super) recorded: BTreeMap<String, String>,
    pub(super) seed: u64,
    pub(super) mission: Option<Text<'a>>,
    pub(super) mission_stalls_ns: Option<u64>,
    pub(super) ignores_faults: bool,
    pub(super) executor: Executor,
    pub(super) link: Link,
    pub(super) web: Option<Web>,
    pub(super) drafts: Drafts<'a>,
    /// Whether to check that required files exist.
    pub(super) check_files: bool,
}

/// The top of the hierarchy.
pub(super) struct Roots<'a> {
    /// One level, or as many as the file names.
    pub(super) levels: Vec<Level<'a>>,
    /// Whether all names were texts, so that none was dropped.
    pub(super) complete: bool,
}

/// Roots that compete with each other and with no other schema.
pub(super) struct Level<'a> {
    /// `roots`, or `roots/left`.
    pub(super) name: String,
    pub(super) members: Vec<Text<'a>>,
    /// The other settings of the level.
    pub(super) section: Option<Section<'a>>,
}

impl<'a> Outline<'a> {
    /// Reads the top level; `file` is absolute.
    /// With `check_files`, checks that required files exist.
    pub(super) fn read(
        report: &mut FaultReport,
        document: &'a DeTable<'a>,
        file: &Path,
        check_files: bool,
    ) -> Self {
        let top = Section::new("the application", 0..0, document);
        top.refuse_unknown(report, KEYS);
        let folder = file.parent().unwrap_or(Path::new("/"));
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        let name = top
            .text(report, "name")
            .map_or_else(|| stem.into_owned(), |name| name.text.to_owned());
        let (mission, mission_stalls_ns) = mission(report, &top);
        let plugin_dirs = folders(report, &top, "plugins");
        let interfaces = folders(report, &top, "interfaces").into_iter();
        let (recordings, interfaces): (Vec<_>, Vec<_>) =
            interfaces.partition(|stated| stated.text.ends_with(".mcap"));
        let link = link::read(report, &top, &name, folder);
        let web = web::read(report, &top, folder, check_files);
        if web.is_some() && link.off {
            report
                .fault(
                    &top.key_span("web"),
                    "the page is a client of the link, and `off` of `link` removes it",
                )
                .advise("remove `off`, or the section `[web]`");
        }
        Self {
            link,
            web,
            name,
            doc: top
                .text(report, "doc")
                .map(|doc| doc.text.to_owned())
                .unwrap_or_default(),
            roots: roots(report, &top),
            awake: top.texts(report, "awake").unwrap_or_default(),
            plugin_dirs: plugin_dirs.iter().map(|dir| folder.join(dir.text)).collect(),
            recorded: recorded::definitions(report, &recordings, folder),
            interfaces: interface_folders(report, &interfaces, folder),
            seed: seed(report, &top),
            mission,
            mission_stalls_ns,
            ignores_faults: ignores_faults(report, &top),
            executor: executor(report, &top),
            drafts: Drafts::read(report, &top),
            check_files,
        }
    }
}

/// Returns a list of folders in which things are searched for.
fn folders<'a>(report: &mut FaultReport, top: &Section<'a>, key: &str) -> Vec<Text<'a>> {
    let mut stated = top.texts(report, key).unwrap_or_default();
    if stated.len() > MAX_FOLDERS {
        let message = format!("{} has more than {MAX_FOLDERS} entries", top.key(key));
        report.fault(&top.key_span(key), message);
        stated.truncate(MAX_FOLDERS);
    }
    stated
}

/// Returns the folders of definitions that exist.
fn interface_folders(report: &mut FaultReport, stated: &[Text], folder: &Path) -> Vec<PathBuf> {
    let mut folders = Vec::new();
    for stated in stated {
        let path = folder.join(stated.text);
        if path.is_dir() {
            folders.push(path);
        } else {
            let message = format!("there is no folder {}", quote(stated.text));
            report
                .fault(&stated.span, message)
                .advise("it contains PACKAGE/msg/NAME.msg; a recording ends with .mcap");
        }
    }
    folders
}

fn roots<'a>(report: &mut FaultReport, top: &Section<'a>) -> Roots<'a> {
    const ADVICE: &str = "name the motor schemas of the top level, such as roots = [\"teleop\", \"example\"]; the first wins a collision";
    let Some(node) = top.get("roots") else {
        report
            .file_fault("there is no `roots`, so nothing would ever start")
            .advise(ADVICE);
        return Roots {
            levels: Vec::new(),
            complete: false,
        };
    };
    let root = top.section(report, "root", "`root`");
    if node.get_ref().is_table() {
        if root.is_some() {
            report
                .fault(
                    &top.key_span("root"),
                    "`root` configures the one level of `roots = [...]`, and this file has several levels",
                )
                .advise("write the keys in each level, beside its `members`");
        }
        return levels(report, top);
    }
    let members = top.texts(report, "roots").unwrap_or_default();
    let written = node.get_ref().as_array().map(|list| list.len());
    if written == Some(0) {
        report
            .fault(
                &top.key_span("roots"),
                "`roots` is empty, so nothing would ever start",
            )
            .advise(ADVICE);
    }
    Roots {
        complete: written == Some(members.len()),
        levels: vec![Level {
            name: "roots".to_owned(),
            members,
            section: root,
        }],
    }
}

/// Reads the levels of `[roots.NAME]`, each of which has a winner of its own.
fn levels<'a>(report: &mut FaultReport, top: &Section<'a>) -> Roots<'a> {
    const ADVICE: &str =
        "name its motor schemas, such as members = [\"teleop\", \"example\"]; the first wins a collision";
    let mut levels = Vec::new();
    let mut complete = true;
    let roots = top.section(report, "roots", "`roots`");
    for (name, _) in roots.iter().flat_map(Section::entries) {
        let what = format!("level {} of `roots`", quote(name.text));
        refuse_bad_name(report, &name, "a level");
        let Some(section) = roots
            .as_ref()
            .and_then(|roots| roots.section(report, name.text, what))
        else {
            complete = false;
            continue;
        };
        let members = section.texts(report, "members").unwrap_or_default();
        let written = section
            .get("members")
            .map(|node| node.get_ref().as_array().map(|list| list.len()));
        match written {
            None | Some(Some(0)) => {
                let message = format!(
                    "{} has no members, so nothing would ever start in it",
                    section.label
                );
                report.fault(&section.key_span("members"), message).advise(ADVICE);
            }
            Some(_) => {}
        }
        complete &= written == Some(Some(members.len()));
        levels.push(Level {
            name: format!("roots/{}", name.text),
            members,
            section: Some(section),
        });
    }
    if levels.is_empty() && complete {
        report
            .fault(
                &top.key_span("roots"),
                "`roots` is empty, so nothing would ever start",
            )
            .advise("write [roots.NAME] with members = [...], or just roots = [...]");
    }
    Roots { levels, complete }
}

/// Reads the mission's export, and the time without progress after which that is reported.
fn mission<'a>(report: &mut FaultReport, top: &Section<'a>) -> (Option<Text<'a>>, Option<u64>) {
    if top.get("mission").is_none_or(|node| !node.get_ref().is_table()) {
        return (top.text(report, "mission"), None);
    }
    let Some(section) = top.section(report, "mission", "`mission`") else {
        return (None, None);
    };
    section.refuse_unknown(report, &["from", "stalls"]);
    let from = section.text(report, "from");
    if section.get("from").is_none() {
        report
            .fault(&section.span, "`mission` does not name an export")
            .advise("add from = \"SCHEMA.mission\"");
    }
    (from, time::of(report, &section, "stalls"))
}

/// Reads the key with which the file of an application or of an experiment states that schemas may fault.
pub fn ignores_faults(report: &mut FaultReport, top: &Section) -> bool {
    let Some(word) = top.text(report, "faults") else {
        return false;
    };
    if word.text != "ignored" {
        report
            .fault(&word.span, format!("`faults` is {}", quote(word.text)))
            .advise("write \"ignored\", or leave it out: then a schema that faults is a failure");
    }
    true
}

fn seed(report: &mut FaultReport, top: &Section) -> u64 {
    let Some(node) = top.get("seed") else { return 0 };
    let seed = integer(node.get_ref()).and_then(|seed| u64::try_from(seed).ok());
    if seed.is_none() {
        report
            .fault(
                &node.span(),
                "`seed` of the application is not a whole number from 0 to 2^64 - 1",
            )
            .advise("write a number such as seed = 7");
    }
    seed.unwrap_or_default()
}

fn executor(report: &mut FaultReport, top: &Section) -> Executor {
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
