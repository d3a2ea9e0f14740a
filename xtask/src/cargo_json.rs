//! The tests that a build produced, from cargo's JSON messages. All other messages are ignored.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context as _, Result};
use serde::Deserialize;

use crate::shell;
use crate::test::Context;

/// A test program that is ready to run.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Program {
    path: PathBuf,
    /// The manifest of the test's package.
    manifest: PathBuf,
}

#[derive(Deserialize)]
struct Message {
    #[serde(default)]
    executable: Option<PathBuf>,
    #[serde(default)]
    manifest_path: PathBuf,
    #[serde(default)]
    target: Option<Target>,
}

#[derive(Deserialize)]
struct Target {
    name: String,
}

/// Builds integration tests. Each is named by the folder of its package and by its own name.
pub(crate) fn build_tests(context: &Context, tests: &[(&str, &str)]) -> Result<Vec<Program>> {
    // For the whole workspace: for single packages cargo would choose other features of the libraries and
    // build them again.
    let mut cargo = context.cargo(&["test", "--workspace", "--no-run"]);
    cargo.args(tests.iter().flat_map(|(_, name)| ["--test", name]));
    cargo.args(["--message-format", "json-render-diagnostics"]);
    shell::show(&cargo, context.paint);
    let messages = shell::read(&mut cargo)?;
    tests
        .iter()
        .map(|(folder, name)| program(&messages, folder, name))
        .collect()
}

impl Program {
    /// Appends the test to a command that runs it as cargo does: in the folder of its package.
    pub(crate) fn run_by(&self, command: &mut Command) {
        let folder = self.manifest.parent().unwrap_or(&self.manifest);
        command
            .arg(&self.path)
            .current_dir(folder)
            .env("CARGO_MANIFEST_DIR", folder);
    }
}

fn program(messages: &str, folder: &str, name: &str) -> Result<Program> {
    let messages = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Message>(line).ok());
    let wanted = |message: &Message| {
        let named = message.target.as_ref().is_some_and(|target| target.name == name);
        named
            && message
                .manifest_path
                .parent()
                .is_some_and(|of_package| of_package.ends_with(folder))
    };
    let mut built = messages.filter(wanted);
    built
        .find_map(|message| {
            Some(Program {
                path: message.executable?,
                manifest: message.manifest_path,
            })
        })
        .with_context(|| format!("{folder} has no test called {name} any more"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MESSAGES: &str = r#"
{"reason":"compiler-artifact","target":{"name":"torture"},"executable":null,"manifest_path":"b/Cargo.toml"}
{"reason":"compiler-artifact","target":{"name":"other"},"executable":"x/other","manifest_path":"b/Cargo.toml"}
{"reason":"compiler-artifact","target":{"name":"torture"},"executable":"x/a","manifest_path":"a/Cargo.toml"}
{"reason":"compiler-artifact","target":{"name":"torture"},"executable":"x/b","manifest_path":"b/Cargo.toml"}
{"reason":"build-finished","success":true}
"#;

    #[test]
    fn the_program_of_a_test_is_found_and_runs_in_the_folder_of_its_package() {
        let found = program(MESSAGES, "b", "torture").unwrap();
        let mut command = Command::new("valgrind");
        found.run_by(&mut command);
        assert_eq!(command.get_args().collect::<Vec<_>>(), ["x/b"]);
        assert_eq!(command.get_current_dir(), Some("b".as_ref()));
    }

    #[test]
    fn a_test_that_is_not_there_is_an_error() {
        let error = program(MESSAGES, "b", "gone").unwrap_err().to_string();
        assert_eq!(error, "b has no test called gone any more");
        assert!(program(MESSAGES, "c", "torture").is_err());
    }
}
