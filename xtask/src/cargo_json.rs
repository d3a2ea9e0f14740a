//! What cargo says while it builds, in its JSON form: which programs came out. Nothing else of it is used.

use std::path::PathBuf;

use anyhow::{Context as _, Result};
use serde::Deserialize;

use crate::shell;
use crate::test::Context;

#[derive(Deserialize)]
struct Message {
    #[serde(default)]
    executable: Option<PathBuf>,
    #[serde(default)]
    target: Option<Target>,
}

#[derive(Deserialize)]
struct Target {
    name: String,
}

/// Builds the integration tests of one name and returns the program.
pub(crate) fn build_test(context: &Context, name: &str) -> Result<PathBuf> {
    // For the whole workspace, or cargo would choose other features of the libraries and build them again.
    let mut cargo = context.cargo(&["test", "--workspace", "--no-run", "--test", name]);
    cargo.args(["--message-format", "json-render-diagnostics"]);
    shell::show(&cargo, context.paint);
    executable(&shell::read(&mut cargo)?, name)
}

fn executable(messages: &str, name: &str) -> Result<PathBuf> {
    let messages = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Message>(line).ok());
    let mut built =
        messages.filter(|message| message.target.as_ref().is_some_and(|target| target.name == name));
    built
        .find_map(|message| message.executable)
        .with_context(|| format!("cargo built no test called {name}; is it still there?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MESSAGES: &str = r#"
{"reason":"compiler-artifact","target":{"name":"torture"},"executable":null}
{"reason":"compiler-artifact","target":{"name":"other"},"executable":"a/other"}
{"reason":"compiler-artifact","target":{"name":"torture"},"executable":"a/torture-12"}
{"reason":"build-finished","success":true}
"#;

    #[test]
    fn the_program_of_a_test_is_found() {
        assert_eq!(
            executable(MESSAGES, "torture").unwrap(),
            PathBuf::from("a/torture-12")
        );
    }

    #[test]
    fn a_test_that_is_not_there_is_an_error() {
        let error = executable(MESSAGES, "gone").unwrap_err().to_string();
        assert_eq!(error, "cargo built no test called gone; is it still there?");
    }
}
