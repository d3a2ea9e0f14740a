//! Starts other programs, without standard input. Errors name the command. `run` also shows the command
//! before it runs. This module does not depend on the purpose of a command.

use std::io::read_to_string;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use anyhow::{Context as _, Result, bail};

use crate::paint::Paint;

/// Returns the `cargo` that runs this program, so that all steps use one toolchain.
pub(crate) fn cargo() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    // Removes the variables in which cargo describes this package. Otherwise some packages, and all that use
    // them, would be rebuilt whenever direct calls of cargo alternate with calls through this program.
    for (name, _) in std::env::vars_os() {
        let describes_package = name
            .to_str()
            .is_some_and(|name| CARGO_VARIABLES.iter().any(|prefix| name.starts_with(prefix)));
        if describes_package {
            cargo.env_remove(name);
        }
    }
    cargo
}

/// The prefixes of the variables in which cargo describes a package to the program that it runs.
const CARGO_VARIABLES: [&str; 2] = ["CARGO_PKG_", "CARGO_MANIFEST_"];

/// A process that is killed when dropped.
pub(crate) struct ChildGuard(pub(crate) Child);

impl ChildGuard {
    /// Requests the end of the process with SIGTERM, which unlike SIGINT also ends a background process of a
    /// shell.
    pub(crate) fn terminate(&self) -> Result<()> {
        read(Command::new("kill").args(["-TERM", &self.0.id().to_string()])).map(drop)
    }
}

impl Drop for ChildGuard {
    fn drop(&mut self) {
        // The process may have ended before.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs a command whose output appears as it is written. Returns an error unless the command succeeds.
pub(crate) fn run(command: &mut Command, paint: Paint) -> Result<()> {
    show(command, paint);
    let status = command
        .stdin(Stdio::null())
        .status()
        .with_context(|| cannot_start(command))?;
    if !status.success() {
        bail!("`{}` ended with {status}", line(command));
    }
    Ok(())
}

/// Runs a command and returns its standard output. Its standard error stays visible.
pub(crate) fn read(command: &mut Command) -> Result<String> {
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| cannot_start(command))?;
    if !output.status.success() {
        bail!("`{}` ended with {}", line(command), output.status);
    }
    String::from_utf8(output.stdout)
        .with_context(|| format!("`{}` wrote something that is not UTF-8", line(command)))
}

/// Like [`read`], for a command that may block: after `patience` it is killed, which is an error.
pub(crate) fn read_within(command: &mut Command, patience: Duration) -> Result<String> {
    let (status, output) = end_within(command, patience)?;
    if !status.success() {
        bail!("`{}` ended with {status}", line(command));
    }
    Ok(output)
}

/// Runs a command that may block and may fail: after `patience` it is killed, which is an error. Returns how it ended,
/// and its standard output.
pub(crate) fn end_within(command: &mut Command, patience: Duration) -> Result<(ExitStatus, String)> {
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .with_context(|| cannot_start(command))?;
    let output = child.stdout.take().context("its output is piped")?;
    let (sender, receiver) = channel();
    thread::spawn(move || sender.send(read_to_string(output)));
    let Ok(output) = receiver.recv_timeout(patience) else {
        child.kill()?;
        child.wait()?;
        bail!("`{}` did not end within {patience:?}", line(command));
    };
    let output = output.with_context(|| format!("`{}` wrote something that is not UTF-8", line(command)))?;
    Ok((child.wait()?, output))
}

/// Returns whether a command starts and succeeds. Its output is discarded.
pub(crate) fn succeeds(command: &mut Command) -> bool {
    let silent = command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    silent.status().is_ok_and(|status| status.success())
}

/// Prints a command as it is typed in a shell.
pub(crate) fn show(command: &Command, paint: Paint) {
    println!("{}", paint.dim(&format!("$ {}", line(command))));
}

fn cannot_start(command: &Command) -> String {
    format!("cannot start `{}`", line(command))
}

fn line(command: &Command) -> String {
    let variables = command
        .get_envs()
        .filter_map(|(name, value)| Some((name, value?)))
        .map(|(name, value)| format!("{}={}", name.to_string_lossy(), quoted(&value.to_string_lossy())));
    let program = std::path::Path::new(command.get_program());
    let program = program
        .file_name()
        .unwrap_or(program.as_os_str())
        .to_string_lossy()
        .into_owned();
    let arguments = command
        .get_args()
        .map(|argument| quoted(&argument.to_string_lossy()));
    variables
        .chain([program])
        .chain(arguments)
        .collect::<Vec<_>>()
        .join(" ")
}

fn quoted(argument: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_=/.,:@+*%".contains(c);
    if !argument.is_empty() && argument.chars().all(plain) {
        argument.to_owned()
    } else {
        format!("'{}'", argument.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cargo_does_not_get_the_variables_of_this_package() {
        let cargo = cargo();
        let removed: Vec<_> = cargo.get_envs().filter(|(_, value)| value.is_none()).collect();
        for name in ["CARGO_PKG_NAME", "CARGO_MANIFEST_DIR"] {
            assert!(std::env::var_os(name).is_some(), "cargo runs this test");
            assert!(removed.iter().any(|(removed, _)| *removed == name), "{name}");
        }
        assert!(!line(&cargo).contains("CARGO_"), "{}", line(&cargo));
    }

    #[test]
    fn a_command_is_shown_in_shell_syntax() {
        let mut command = Command::new("/usr/bin/cargo");
        command
            .args(["test", "--test", "it's"])
            .env("RUSTFLAGS", "--cfg loom");
        assert_eq!(
            line(&command),
            r"RUSTFLAGS='--cfg loom' cargo test --test 'it'\''s'"
        );
    }

    #[test]
    fn a_failure_names_the_command() {
        let error = run(&mut Command::new("false"), Paint::plain())
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("`false` ended with"), "{error}");
        let error = read(&mut Command::new("no-such-program"))
            .unwrap_err()
            .to_string();
        assert_eq!(error, "cannot start `no-such-program`");
    }

    #[test]
    fn a_command_that_does_not_end_is_killed_and_reported() {
        let mut command = Command::new("tail");
        command.args(["-f", "/dev/null"]);
        let error = read_within(&mut command, Duration::from_millis(10)).unwrap_err();
        assert_eq!(error.to_string(), "`tail -f /dev/null` did not end within 10ms");
        let hello = read_within(Command::new("echo").arg("hello"), Duration::MAX).unwrap();
        assert_eq!(hello, "hello\n");
        assert!(read_within(&mut Command::new("false"), Duration::MAX).is_err());
    }

    #[test]
    fn the_output_is_read() {
        assert_eq!(read(Command::new("echo").arg("hello")).unwrap(), "hello\n");
        assert!(succeeds(&mut Command::new("true")));
        assert!(!succeeds(&mut Command::new("false")));
    }
}
