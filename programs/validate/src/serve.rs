//! The process of one check.

use std::fs::File;
use std::io;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::path::Path;

use jde_loader::LoadedPlugin;
use rustix::fs::{Mode, OFlags};
use rustix::process::{DumpableBehavior, Signal, set_dumpable_behavior, set_parent_process_death_signal};
use serde::{Deserialize, Serialize};

use crate::CheckResult;
use crate::checks::{CHECKS, LOADS};
use crate::life::Subject;

/// What a process reports.
#[derive(Serialize, Deserialize)]
pub(crate) struct CheckReport {
    pub(crate) verdict: CheckResult,
    /// The plugin's types.
    pub(crate) types: Vec<String>,
}

/// Runs one check in this process for the one at standard input. The arguments are the plugin, the check and the
/// number of the type. Must be called first in a program of its own, which does nothing else.
///
/// # Errors
/// No other process asks, or the arguments are wrong.
pub fn serve(arguments: &[String]) -> io::Result<()> {
    set_parent_process_death_signal(Some(Signal::KILL))?;
    set_dumpable_behavior(DumpableBehavior::NotDumpable)?;
    let stream = UnixStream::from(rustix::stdio::stdin().try_clone_to_owned()?);
    stream.peer_addr()?;
    let null = rustix::fs::open("/dev/null", OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty())?;
    rustix::stdio::dup2_stdin(null.as_fd())?;
    // What this program printed before is not the plugin's.
    let _ = File::options().write(true).truncate(true).open("/proc/self/fd/1");
    let [file, check, number] = arguments else {
        return Err(io::ErrorKind::InvalidInput.into());
    };
    let report = report(
        &stream,
        Path::new(file),
        check,
        number.parse().unwrap_or_default(),
    );
    serde_json::to_writer(&stream, &report)?;
    Ok(())
}

fn report(asker: &UnixStream, file: &Path, check: &str, number: usize) -> CheckReport {
    let report = |verdict, types| CheckReport { verdict, types };
    let plugin = match LoadedPlugin::open_copy(file, file) {
        Ok(plugin) => plugin,
        Err(error) => return report(CheckResult::Failed(error.to_string()), Vec::new()),
    };
    let schemas = &plugin.description.schemas;
    let types = schemas.iter().map(|schema| schema.name.clone()).collect();
    let check = CHECKS.iter().find(|known| known.name == check && check != LOADS);
    let verdict = match (check, schemas.get(number)) {
        (Some(check), Some(schema)) => (check.run)(Subject {
            schema,
            functions: plugin.schema(number),
            asker,
        }),
        _ => CheckResult::Ok,
    };
    report(verdict, types)
}
