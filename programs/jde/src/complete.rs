//! Completes names in the shell: of running applications, of their contents, and of recordings. A source that
//! does not reply within [`COMPLETION_TIMEOUT`] is omitted, because a key press must not wait.

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use clap_complete::engine::{CompletionCandidate, PathCompleter, ValueCompleter};
use jde_files::{escape, is_control};
use jde_link::message::{SchemaInfo, VariableInfo};
use jde_link::{Client, Folders, Rate, Reach, Remote};
use jde_loader::SearchPath;
use jde_log::Recording;
use jde_panel::Item;
use jde_session::load;

use crate::remote::name::split_application;
use crate::remote::panel;
use crate::{analysis, inspect};

/// The longest time that a key press may wait.
const COMPLETION_TIMEOUT: Duration = Duration::from_millis(700);

/// Completes the names of applications that run on this machine.
pub(crate) fn applications(current: &OsStr) -> Vec<CompletionCandidate> {
    let known = with_timeout(|| {
        let applications = client()?.applications().ok()?.into_iter();
        Some(applications.map(|about| (about.name, about.file)).collect())
    });
    candidates(current, known)
}

/// Completes the schemas of the chosen application.
pub(crate) fn schemas(current: &OsStr) -> Vec<CompletionCandidate> {
    complete_names(current, |remote| schemas_of(remote, |_| true))
}

/// Completes the schemas that have panels.
pub(crate) fn panels(current: &OsStr) -> Vec<CompletionCandidate> {
    complete_names(current, |remote| schemas_of(remote, |schema| schema.panel))
}

/// Completes the schemas of the chosen application, and their plugins.
pub(crate) fn schemas_and_plugins(current: &OsStr) -> Vec<CompletionCandidate> {
    complete_names(current, |remote| {
        let schemas = remote.schemas().ok()?.schemas.into_iter();
        let both = schemas.flat_map(|schema| {
            let plugin = schema.type_name.split('/').next().unwrap_or_default();
            let all = format!("all schemas of the plugin {plugin}");
            [(plugin.to_owned(), all), (schema.name, schema.doc)]
        });
        Some(both.collect())
    })
}

/// Completes the variables of the chosen application.
pub(crate) fn variables(current: &OsStr) -> Vec<CompletionCandidate> {
    complete_names(current, |remote| variables_of(remote, |_| true))
}

/// Completes the modulations of the chosen application.
pub(crate) fn modulations(current: &OsStr) -> Vec<CompletionCandidate> {
    complete_names(current, |remote| {
        variables_of(remote, |variable| variable.access == "modulation")
    })
}

/// Completes the widgets of the panel that the command line names.
pub(crate) fn widgets(current: &OsStr) -> Vec<CompletionCandidate> {
    let line = CommandLine::parse(std::env::args_os());
    let mut words = line.positionals.into_iter().skip_while(|word| word != "panel");
    let Some(schema) = words.nth(1) else {
        return Vec::new();
    };
    let default = line.application.or_else(default_application);
    let widgets = with_timeout(move || {
        let (named, schema) = split_application(&schema);
        let remote = client()?.application(named.or(default.as_deref())).ok()?;
        let (sender, receiver) = channel();
        let _watching = remote
            .watch_panel(schema, Rate::Full, move |sample| drop(sender.send(sample.list)))
            .ok()?;
        let list = receiver.recv_timeout(COMPLETION_TIMEOUT).ok()?.ok()?;
        let names = panel::touchable(&list).filter_map(Item::id);
        Some(names.map(|id| (id.to_owned(), String::new())).collect())
    });
    candidates(current, widgets)
}

/// Completes the numbers of the recording on the same command line.
pub(crate) fn recorded_fields(current: &OsStr) -> Vec<CompletionCandidate> {
    let is_recording = |word: &OsString| {
        Path::new(word)
            .extension()
            .is_some_and(|extension| extension == "mcap")
    };
    let names = std::env::args_os().find(is_recording).and_then(|file| {
        with_timeout(move || {
            let recording = Recording::open(Path::new(&file)).ok()?;
            Some(analysis::names(&recording))
        })
    });
    candidates(current, names)
}

/// Completes the names of plugins, the types of value in them, and files.
pub(crate) fn plugins_and_value_types(current: &OsStr) -> Vec<CompletionCandidate> {
    let names = with_timeout(|| {
        let plugins = load::describe_all(&load::plugins(SearchPath::usual(None)), &[]);
        let of_plugins = plugins.iter().map(|plugin| plugin.description.name.clone());
        let names = of_plugins.chain(inspect::value_type_names(&plugins));
        Some(names.map(|name| (name, String::new())).collect())
    });
    let mut known = candidates(current, names);
    known.extend(PathCompleter::file().complete(current));
    known
}

/// Names with their documentation.
type DocumentedNames = Vec<(String, String)>;

/// Returns the candidates that begin with the current word.
fn candidates(current: &OsStr, known: Option<DocumentedNames>) -> Vec<CompletionCandidate> {
    let start = current.to_string_lossy();
    let known = known.unwrap_or_default().into_iter();
    known
        // A name with a character that controls the terminal is typed by nobody.
        .filter(|(name, _)| name.starts_with(&*start) && !name.contains(is_control))
        .map(|(name, doc)| {
            let doc = doc.lines().next().map(escape);
            CompletionCandidate::new(name).help(doc.map(Into::into))
        })
        .collect()
}

/// Connects to the applications of this machine.
fn client() -> Option<Client> {
    Client::connect(&Reach::Local(Folders::of_user())).ok()
}

fn schemas_of(remote: &Remote, fits: fn(&SchemaInfo) -> bool) -> Option<DocumentedNames> {
    let schemas = remote.schemas().ok()?.schemas.into_iter().filter(fits);
    Some(schemas.map(|schema| (schema.name, schema.doc)).collect())
}

fn variables_of(remote: &Remote, fits: fn(&VariableInfo) -> bool) -> Option<DocumentedNames> {
    let variables = remote.variables(false).ok()?.into_iter().filter(fits);
    Some(variables.map(|variable| (variable.name, variable.doc)).collect())
}

fn complete_names(current: &OsStr, list: fn(&Remote) -> Option<DocumentedNames>) -> Vec<CompletionCandidate> {
    let word = current.to_string_lossy().into_owned();
    let default = CommandLine::parse(std::env::args_os()).application;
    let default = default.or_else(default_application);
    let known = with_timeout(move || {
        let client = client()?;
        let list = |name: Option<&str>| list(&client.application(name).ok()?);
        // The name of an imported variable already contains its application.
        let mut known = list(default.as_deref()).unwrap_or_default();
        if let (Some(named), _) = split_application(&word) {
            let of_named = list(Some(named)).unwrap_or_default().into_iter();
            known.extend(of_named.map(|(name, doc)| (format!("{named}:{name}"), doc)));
        }
        known.sort_unstable();
        known.dedup_by(|a, b| a.0 == b.0);
        Some(known)
    });
    candidates(current, known)
}

/// The application to use if the command line names none.
fn default_application() -> Option<String> {
    std::env::var("JDE_APP").ok()
}

/// The parts of a command line that determine which names exist.
#[derive(Debug, Default, PartialEq)]
struct CommandLine {
    /// The value of --app.
    application: Option<String>,
    /// Words that are neither an option nor its value.
    positionals: Vec<String>,
}

impl CommandLine {
    /// Parses an unfinished line: invalid UTF-8 is replaced, and an option may still lack its value.
    fn parse(line: impl Iterator<Item = OsString>) -> Self {
        let mut parsed = Self::default();
        let mut line = line.map(|word| word.to_string_lossy().into_owned());
        while let Some(word) = line.next() {
            match word.as_str() {
                "--app" | "-a" => parsed.application = line.next(),
                "--at" | "--key" | "--touch" => drop(line.next()),
                option if option.starts_with('-') => {
                    let named = option.strip_prefix("--app=").or(option.strip_prefix("-a"));
                    parsed.application = named.map(str::to_owned).or(parsed.application);
                }
                _ => parsed.positionals.push(word),
            }
        }
        parsed
    }
}

/// Returns the result of `query` if it arrives within [`COMPLETION_TIMEOUT`]. The thread is not joined.
fn with_timeout<T: Send + 'static>(query: impl FnOnce() -> Option<T> + Send + 'static) -> Option<T> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        // The receiver is dropped if the result is late.
        let _ = sender.send(query());
    });
    receiver.recv_timeout(COMPLETION_TIMEOUT).ok().flatten()
}

#[cfg(test)]
mod tests {
    use std::os::unix::ffi::OsStringExt;

    use super::*;

    fn parse(line: &[&str]) -> (Option<String>, Vec<String>) {
        let CommandLine {
            application,
            positionals,
        } = CommandLine::parse(line.iter().map(OsString::from));
        (application, positionals)
    }

    #[test]
    fn values_of_options_are_not_positional() {
        let panel = vec!["jde".to_owned(), "panel".to_owned(), "example".to_owned()];
        let robot = Some("robot2".to_owned());
        for line in [
            &["jde", "panel", "--app", "robot2", "example", "--touch", "cl"][..],
            &[
                "jde",
                "panel",
                "--app=robot2",
                "--at",
                "tcp/robot2:7447",
                "example",
            ],
            &["jde", "-a", "robot2", "panel", "example", "--touch"],
            &[
                "jde", "panel", "-arobot2", "--key", "key.toml", "--json", "example",
            ],
        ] {
            assert_eq!(parse(line), (robot.clone(), panel.clone()), "{line:?}");
        }
        assert_eq!(parse(&["jde", "panel", "example"]), (None, panel));
        assert_eq!(parse(&["jde", "--app"]), (None, vec!["jde".to_owned()]));
    }

    #[test]
    fn invalid_utf_8_is_replaced() {
        let line = [b"jde".to_vec(), vec![0xff, b'x'], b"panel".to_vec()];
        let words = CommandLine::parse(line.into_iter().map(OsString::from_vec));
        assert_eq!(words.positionals, ["jde", "\u{fffd}x", "panel"]);
    }
}
