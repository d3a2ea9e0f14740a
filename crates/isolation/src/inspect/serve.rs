//! The inspecting process: maps the requested files, returns their descriptions, and has their schemas
//! inspect what their modulations name, until the host closes the stream.

use std::io;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};

use jde_abi::inspect::Problem;
use jde_loader::{LoadError, LoadedPlugin};
use rustix::fs::{Mode, OFlags};
use rustix::process::{DumpableBehavior, Signal, set_dumpable_behavior, set_parent_process_death_signal};

use super::run::{restrict_to_reading, run_inspection};
use super::{InspectorRequest, InspectorResponse};
use crate::ServeError;
use crate::wire::{Frame, FrameKind, Wire};

/// Inspects plugins in this process for the host at standard input; returns when the host sends no more
/// requests. Call it first in a program of its own that does nothing else.
///
/// # Errors
/// [`ServeError::NoHost`].
pub fn serve() -> Result<(), ServeError> {
    let mut wire = Wire::new(connect_to_host().map_err(ServeError::NoHost)?);
    let mut mapped = Vec::new();
    let mut limited = false;
    while let Ok(frame) = wire.receive() {
        let Ok(question) = serde_json::from_slice::<InspectorRequest>(&frame.bytes) else {
            return Err(ServeError::NoHost(io::ErrorKind::InvalidData.into()));
        };
        let answer = match question {
            InspectorRequest::Look { copy, path } => match map(&mut mapped, &copy, path) {
                Ok(loaded) => InspectorResponse::Plugin((*loaded.description).clone()),
                Err(error) => InspectorResponse::Refused(error.to_string()),
            },
            InspectorRequest::Inspect { path, number, name } => {
                if !std::mem::replace(&mut limited, true) {
                    restrict_to_reading();
                }
                // A process that replaced a dead one has mapped nothing yet.
                let known = mapped.iter().find(|(known, _)| *known == path);
                let loaded = match known {
                    Some((_, loaded)) => Ok(loaded.clone()),
                    None => map(&mut mapped, &path.clone(), path),
                };
                match loaded
                    .as_ref()
                    .map(|loaded| (loaded, loaded.description.schemas.get(number)))
                {
                    Ok((loaded, Some(about))) => {
                        let (back, (status, found)) =
                            run_inspection(wire, loaded.schema(number), about.ports.len(), &name);
                        wire = back;
                        let parts = |one: Problem| (one.unavailable, one.port, one.words);
                        InspectorResponse::Inspected {
                            status,
                            found: found.map(|found| found.into_iter().map(parts).collect()),
                        }
                    }
                    Ok((_, None)) => {
                        InspectorResponse::Refused(format!("its file has no type number {number} any more"))
                    }
                    Err(error) => InspectorResponse::Refused(error.to_string()),
                }
            }
        };
        let done = Frame {
            bytes: serde_json::to_vec(&answer).map_err(|error| ServeError::NoHost(error.into()))?,
            ..Frame::new(FrameKind::Done)
        };
        wire.send(&done).map_err(ServeError::NoHost)?;
    }
    Ok(())
}

/// Maps `file`, which the user knows as `path`, and keeps it.
fn map(
    mapped: &mut Vec<(PathBuf, LoadedPlugin)>,
    file: &Path,
    path: PathBuf,
) -> Result<LoadedPlugin, LoadError> {
    let loaded = LoadedPlugin::open_copy(file, &path)?;
    mapped.push((path, loaded.clone()));
    Ok(loaded)
}

/// Returns the stream to the host. From here on this process ends with the host, and leaves no core dump when
/// it crashes.
fn connect_to_host() -> io::Result<UnixStream> {
    set_parent_process_death_signal(Some(Signal::KILL))?;
    set_dumpable_behavior(DumpableBehavior::NotDumpable)?;
    let stream = UnixStream::from(rustix::stdio::stdin().try_clone_to_owned()?);
    // Without a peer there is no host.
    stream.peer_addr()?;
    let nothing = rustix::fs::open("/dev/null", OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty())?;
    rustix::stdio::dup2_stdin(nothing.as_fd())?;
    Ok(stream)
}
