//! The inspecting process: maps the requested files, returns their descriptions, and lets their schemas
//! inspect the resources that their modulations name, until the host closes the stream.

use std::io;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};

use jde_abi::inspect::Problem;
use jde_loader::{LoadError, LoadedPlugin};
use rustix::fs::{Mode, OFlags};
use rustix::process::{DumpableBehavior, Signal, set_dumpable_behavior, set_parent_process_death_signal};

use super::run::{restrict_to_reading, run_inspection};
use super::{EntryPoint, InspectorRequest, InspectorResponse};
use crate::ServeError;
use crate::messages::{Done, FromChild};
use crate::wire::Wire;

/// Inspects plugins in this process for the host at standard input; returns when the host sends no more
/// requests. `open` loads a file, which the user knows by its second argument: [`LoadedPlugin::open_copy`],
/// unless the program runs plugins of its own kind. `entry_points` lists the names and files of plugins that
/// are found without a search path. Call it first in a program of its own that does nothing else.
///
/// # Errors
/// [`ServeError::NoHost`].
pub fn serve(
    open: fn(&Path, &Path) -> Result<LoadedPlugin, LoadError>,
    entry_points: fn() -> Vec<(String, PathBuf)>,
) -> Result<(), ServeError> {
    let mut wire = Wire::new(connect_to_host().map_err(ServeError::NoHost)?);
    let mut mapped = Vec::new();
    let mut is_restricted = false;
    loop {
        let request = match wire.receive() {
            Ok(request) => request,
            Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                return Err(ServeError::NoHost(error));
            }
            Err(_) => return Ok(()),
        };
        let response = match request {
            InspectorRequest::Describe { copy, path } => match map(open, &mut mapped, &copy, path) {
                Ok(loaded) => InspectorResponse::Plugin((*loaded.description).clone()),
                Err(error) => InspectorResponse::Refused(error.to_string()),
            },
            InspectorRequest::EntryPoints => {
                let found = entry_points().into_iter();
                InspectorResponse::EntryPoints(found.map(|(name, file)| EntryPoint(name, file)).collect())
            }
            InspectorRequest::Inspect {
                path,
                number,
                name,
                listed,
            } => {
                if !std::mem::replace(&mut is_restricted, true) {
                    restrict_to_reading();
                }
                // A process that replaced a dead one has mapped nothing yet.
                let known = mapped.iter().find(|(known, _)| *known == path);
                let loaded = match known {
                    Some((_, loaded)) => Ok(loaded.clone()),
                    None => map(open, &mut mapped, &path.clone(), path),
                };
                let response = match loaded
                    .as_ref()
                    .map(|loaded| (loaded, loaded.description.schemas.get(number)))
                {
                    Ok((loaded, Some(schema))) => {
                        let (returned_wire, (status, found)) =
                            run_inspection(wire, loaded.schema(number), (schema.ports.len(), &listed), &name);
                        wire = returned_wire;
                        let parts = |problem: Problem| (problem.unavailable, problem.port, problem.words);
                        InspectorResponse::Inspected {
                            status,
                            found: found.map(|found| found.into_iter().map(parts).collect()),
                        }
                    }
                    Ok((_, None)) => {
                        InspectorResponse::Refused(format!("its file no longer has a type number {number}"))
                    }
                    Err(error) => InspectorResponse::Refused(error.to_string()),
                };
                wire.queue(&FromChild::Done(Done::default()));
                response
            }
        };
        wire.send(&response).map_err(ServeError::NoHost)?;
    }
}

/// Maps `file`, which the user knows as `path`, and keeps it.
fn map(
    open: fn(&Path, &Path) -> Result<LoadedPlugin, LoadError>,
    mapped: &mut Vec<(PathBuf, LoadedPlugin)>,
    file: &Path,
    path: PathBuf,
) -> Result<LoadedPlugin, LoadError> {
    let loaded = open(file, &path)?;
    mapped.push((path, loaded.clone()));
    Ok(loaded)
}

/// Returns the stream to the host. From now on this process ends with the host, and leaves no core dump when
/// it crashes.
fn connect_to_host() -> io::Result<UnixStream> {
    set_parent_process_death_signal(Some(Signal::KILL))?;
    set_dumpable_behavior(DumpableBehavior::NotDumpable)?;
    let stream = UnixStream::from(rustix::stdio::stdin().try_clone_to_owned()?);
    // Without a peer there is no host.
    stream.peer_addr()?;
    let null = rustix::fs::open("/dev/null", OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty())?;
    rustix::stdio::dup2_stdin(null.as_fd())?;
    Ok(stream)
}
