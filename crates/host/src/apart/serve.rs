//! The child: loads its plugin, limits itself, and runs the functions that its host calls, until the host
//! ends the connection.

#![allow(unsafe_code)]

use std::ffi::CString;
use std::io;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;

use jde_abi::raw;
use jde_panel::Gesture;
use rustix::fs::{Mode, OFlags};
use rustix::process::{Signal, set_parent_process_death_signal};

use super::launch::{Launch, receive_files};
use super::limits;
use super::memory::Port;
use super::table::{HOST, Present, Session};
use super::wire::{Frame, Kind, READY, Wire};
use super::{Code, Plugin};
use crate::instance::{Here, Question, Remembered};
use crate::plugin::{Functions, Loaded, Plugins};

/// Why a schema is not run.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// There is no host at the other end.
    #[error(
        "this is how a host runs a schema in a process of its own, and there is no host at standard input ({0}): \
         write isolate = \"process\" in the schema's table and run the application"
    )]
    NoHost(#[source] io::Error),
}

/// Runs one schema in this process for the host at standard input, and returns when the host ends the
/// connection. `plugins` holds the plugins linked into this program. Must be called first in a program of its
/// own, which does nothing else.
///
/// # Errors
/// [`ServeError`].
pub fn serve(plugins: &Plugins) -> Result<(), ServeError> {
    let (stream, files) = meet().map_err(ServeError::NoHost)?;
    let mut wire = Wire::new(stream);
    let launch = wire.receive().map_err(ServeError::NoHost)?;
    let Ok(launch) = jde_panel::decode::<Launch>(&launch.bytes) else {
        return Err(ServeError::NoHost(io::ErrorKind::InvalidData.into()));
    };
    let name = CString::new(launch.name.replace('\0', "")).unwrap_or_default();
    // The name that `ps` and `top` show. Failing to set it is harmless.
    let _ = rustix::thread::set_name(&name);
    crate::exec::supervisor::sharpen_timers();
    let mut session = Session {
        wire,
        name,
        application: launch.application,
        seed: launch.seed,
        real_time: launch.real_time,
        ports: Vec::new(),
        call: Present::default(),
    };
    let ready = Port::all(&launch.ports, files)
        .map_err(|error| format!("its memory cannot be mapped: {error}"))
        .and_then(|ports| {
            session.ports = ports;
            load(plugins, &launch.code)
        });
    let table = match ready {
        Ok(table) => table,
        Err(reason) => {
            session.tell(Kind::Fail, 0, &reason);
            return session.done(failed()).map_err(ServeError::NoHost);
        }
    };
    let not_limited = limits::apply(launch.limits);
    let done = Frame {
        bytes: jde_panel::encode(&not_limited),
        ..Frame::new(Kind::Done)
    };
    session.done(done).map_err(ServeError::NoHost)?;
    run(&mut session, table, &launch);
    Ok(())
}

/// The stream to the host and the files of shared memory. From here on this process ends with its host.
fn meet() -> io::Result<(UnixStream, Vec<std::os::fd::OwnedFd>)> {
    set_parent_process_death_signal(Some(Signal::KILL))?;
    let stream = UnixStream::from(rustix::stdio::stdin().try_clone_to_owned()?);
    let files = receive_files(&stream)?;
    // From here on standard input is empty: the plugin must not read the host's messages.
    let nothing = rustix::fs::open("/dev/null", OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty())?;
    rustix::stdio::dup2_stdin(nothing.as_fd())?;
    Ok((stream, files))
}

fn load(plugins: &Plugins, code: &Code) -> Result<Functions, String> {
    let loaded = match &code.plugin {
        Plugin::File(path) => Loaded::open_copy(path).map_err(|error| error.to_string()),
        Plugin::LinkedIn(name) => plugins.load(name, &[]).map_err(|error| error.to_string()),
    }?;
    if code.number >= loaded.description.schemas.len() {
        return Err(format!("its plugin has no type number {}", code.number));
    }
    Ok(loaded.schema(code.number))
}

/// Runs the functions that the host calls, until the stream ends.
fn run(session: &mut Session, table: Functions, launch: &Launch) {
    let mut instance: Option<Here> = None;
    while let Ok(frame) = session.wire.receive() {
        session.call = Present::of(&frame);
        limits::renew(launch.limits);
        let done = match (frame.kind, &mut instance) {
            (Kind::Create, _) => {
                // SAFETY: the table was checked when it was loaded.
                instance = unsafe { Here::create(table, &HOST, session.context()) };
                status(if instance.is_some() { raw::OK } else { raw::FAILED })
            }
            (Kind::Destroy, _) => {
                drop(instance.take());
                // The host waits for nothing after this answer.
                drop(session.done(status(raw::OK)));
                return;
            }
            (kind, Some(instance)) => call(session, instance, kind, &frame),
            (_, None) => failed(),
        };
        if session.done(done).is_err() {
            return;
        }
    }
}

fn call(session: &mut Session, instance: &mut Here, kind: Kind, frame: &Frame) -> Frame {
    let now = session.call.now();
    let context = session.context();
    match kind {
        Kind::Awake => status(instance.awake(context)),
        Kind::Check => {
            let (done, ready, urgency) = instance.check(context);
            Frame {
                flags: if ready { READY } else { 0 },
                words: [urgency.to_bits(), 0, 0, 0],
                ..status(done)
            }
        }
        Kind::Iterate => status(instance.iterate(context)),
        Kind::Arbitrate => {
            let Ok(question) = jde_panel::decode::<Question>(&frame.bytes) else {
                return failed();
            };
            let (done, verdict) = instance.arbitrate(context, &question);
            Frame {
                bytes: jde_panel::encode(&verdict),
                ..status(done)
            }
        }
        Kind::Sleep => {
            instance.sleep(context);
            status(raw::OK)
        }
        Kind::Draw => {
            let (done, list) = instance.draw(context, now);
            Frame {
                bytes: jde_panel::encode(&list),
                ..status(done)
            }
        }
        Kind::Touch => {
            let Ok((by, gesture)) = jde_panel::decode::<(String, Gesture)>(&frame.bytes) else {
                return failed();
            };
            status(instance.touch(context, &by, &gesture))
        }
        Kind::Save => {
            let (done, kept) = instance.save(context);
            Frame {
                bytes: jde_panel::encode(&kept),
                ..status(done)
            }
        }
        Kind::Restore => {
            let remembered = Remembered {
                version: frame.number,
                bytes: frame.bytes.clone(),
            };
            status(instance.restore(context, &remembered))
        }
        Kind::Start
        | Kind::Create
        | Kind::Destroy
        | Kind::Answer
        | Kind::Read
        | Kind::Loan
        | Kind::Publish
        | Kind::Retract
        | Kind::Wake
        | Kind::LayDown
        | Kind::Child
        | Kind::SetPolicy
        | Kind::Log
        | Kind::Fail
        | Kind::Done => failed(),
    }
}

fn status(status: i32) -> Frame {
    Frame {
        status,
        ..Frame::new(Kind::Done)
    }
}

fn failed() -> Frame {
    status(raw::FAILED)
}
