//! What cargo says while it builds, in its JSON form: which tests came out. Nothing else of it is used.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context as _, Result};
use serde::Deserialize;

use crate::shell;
use crate::test::Context;

/// A test that is ready to run.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Program {
    path: PathBuf,
    /// Of its package.
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

/// Builds the integration test of a name.
pub(crate) fn build_test(context: &Context, name: &str) -> Result<Program> {
    // For the whole workspace, or cargo would choose other features of the libraries and build them again.
    let mut cargo = context.cargo(&["test", "--workspace", "--no-run", "--test", name]);
    cargo.args(["--message-format", "json-render-diagnostics"]);
    shell::show(&cargo, context.paint);
    program(&shell::read(&mut cargo)?, name)
}

impl Program {
    /// Hands the test to another program, which runs it as cargo would: in the folder of its package.
    pub(crate) fn run_by(&self, command: &mut Command) {
        let folder = self.manifest.parent().unwrap_or(&self.manifest);
        command
            .arg(&self.path)
            .current_dir(folder)
            .env("CARGO_MANIFEST_DIR", folder);
    }
}

fn program(messages: &str, name: &str) -> Result<Program> {
    let messages = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Message>(line).ok());
    let mut built =
        messages.filter(|message| message.target.as_ref().is_some_and(|target| target.name == name));
    built
        .find_map(|message| {
            Some(Program {
                path: message.executable?,
                manifest: message.manifest_path,
            })
        })
        .with_context(|| format!("cargo built no test called {name}; is it still there?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MESSAGES: &str = r#"
{"reason":"compiler-artifact","target":{"name":"torture"},"executable":null}
{"reason":"compiler-artifact","target":{"name":"other"},"executable":"a/other"}
{"reason":"compiler-artifact","target":{"name":"torture"},"executable":"a/torture-12","manifest_path":"b/Cargo.toml"}
{"reason":"build-finished","success":true}
"#;

    #[test]
    fn the_program_of_a_test_is_found() {
        let found = program(MESSAGES, "torture").unwrap();
        assert_eq!(
            found,
            Program {
                path: "a/torture-12".into(),
                manifest: "b/Cargo.toml".into()
            }
        );
        let mut command = Command::new("valgrind");
        found.run_by(&mut command);
        assert_eq!(command.get_args().collect::<Vec<_>>(), ["a/torture-12"]);
        assert_eq!(command.get_current_dir(), Some("b".as_ref()));
    }

    #[test]
    fn a_test_that_is_not_there_is_an_error() {
        let error = program(MESSAGES, "gone").unwrap_err().to_string();
        assert_eq!(error, "cargo built no test called gone; is it still there?");
    }
}
