//! `jde validate`: checks whether a plugin keeps the promises of the ABI.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_loader::SearchPath;
use jde_loader::python::is_python;
use jde_session::cli::{print_json, print_value};
use jde_session::load;
use jde_terminal as terminal;
use jde_terminal::{BAD, FAINT, GOOD, TITLE};
use jde_validate::{CHECKS, CheckResult, Finding, ValidationError, validate};

use crate::failure::{Failure, display_path};
use crate::{child, complete};

/// How long a check may take.
const CHECK_TIMEOUT: Duration = Duration::from_secs(10);

/// Validate a plugin: check whether it keeps the promises of the ABI (jde.h), in any language that makes libraries.
///
/// Runs each check in a process of its own, so a plugin that crashes or hangs fails that check alone. Opens no device.
#[derive(Args)]
#[command(after_help = "Examples:
  jde validate target/debug/libfollow.so
  jde validate vff --only silent --only memory

Exit status: 0 if no check fails, otherwise 1.")]
pub(crate) struct Validate {
    /// The plugin's name or file.
    #[arg(
        value_name = "PLUGIN",
        required_unless_present = "list",
        add = ArgValueCompleter::new(complete::plugins_and_value_types)
    )]
    name: Option<String>,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
    /// List the checks.
    #[arg(long)]
    list: bool,
    /// Run only this check (repeatable).
    #[arg(long, value_name = "CHECK")]
    only: Vec<String>,
}

impl Validate {
    /// Checks the plugin and prints the findings.
    pub(super) fn run(self) -> Result<(), Failure> {
        let Some(name) = self.name.filter(|_| !self.list) else {
            return list(self.json);
        };
        let file = file_of(&name)?;
        if is_python(&file) {
            return Err(Failure::usage(
                format!(
                    "{} is a plugin in Python, and only libraries are validated",
                    display_path(&file)
                ),
                "`jde describe` shows what it offers",
            ));
        }
        let findings =
            validate(&file, &child::validator(), &self.only, CHECK_TIMEOUT).map_err(|error| match error {
                ValidationError::UnknownCheck(name) => {
                    Failure::unknown("check", &name, CHECKS.iter().map(|check| check.name))
                }
                ValidationError::NotStarted(error) => {
                    Failure::broken(format!("no process can be started: {error}"))
                }
            })?;
        print_value(self.json, &findings, |findings, out| write(&file, findings, out))?;
        let is_failed = |finding: &Finding| matches!(finding.verdict, CheckResult::Failed(_));
        match findings.iter().any(is_failed) {
            true => Err(Failure::Promise),
            false => Ok(()),
        }
    }
}

fn list(json: bool) -> Result<(), Failure> {
    if json {
        let checks = CHECKS
            .iter()
            .map(|check| serde_json::json!({ "check": check.name, "promise": check.promise }));
        return Ok(print_json(&checks.collect::<Vec<_>>())?);
    }
    let mut out = terminal::out();
    for check in CHECKS {
        writeln!(out, "{:<14} {}", check.name, check.promise)?;
    }
    Ok(out.flush()?)
}

/// Returns the file of a plugin, given by its name or its file.
fn file_of(name: &str) -> Result<PathBuf, Failure> {
    let path = Path::new(name);
    if path.is_file() || name.ends_with(".so") || name.starts_with(['.', '/']) {
        let file = jde_files::open(path).and_then(|_| path.canonicalize());
        return file.map_err(Failure::file(path));
    }
    let plugin = load::plugins(SearchPath::usual(None)).describe(name, &[])?;
    plugin
        .path
        .ok_or_else(|| Failure::usage(format!("the plugin `{name}` has no file"), "name a file"))
}

fn write(file: &Path, findings: &[Finding], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{TITLE}{}{TITLE:#}", display_path(file))?;
    let mut schema = &None;
    for finding in findings {
        if finding.schema != *schema {
            schema = &finding.schema;
            writeln!(out)?;
            writeln!(out, "{TITLE}{}{TITLE:#}", schema.as_deref().unwrap_or_default())?;
        }
        let check = finding.check;
        match &finding.verdict {
            CheckResult::Ok => writeln!(out, "{GOOD}ok     {GOOD:#} {check}")?,
            CheckResult::Failed(words) => writeln!(out, "{BAD}failed {BAD:#} {check}: {words}")?,
            CheckResult::Skipped(words) => writeln!(out, "{FAINT}skipped {check}: {words}{FAINT:#}")?,
        }
    }
    let count = |is: fn(&CheckResult) -> bool| findings.iter().filter(|finding| is(&finding.verdict)).count();
    let ok = count(|verdict| matches!(verdict, CheckResult::Ok));
    let failed = count(|verdict| matches!(verdict, CheckResult::Failed(_)));
    writeln!(out)?;
    writeln!(
        out,
        "{ok} ok, {failed} failed, {} skipped",
        findings.len() - ok - failed
    )
}
