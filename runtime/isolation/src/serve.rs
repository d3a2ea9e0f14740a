//! The child: loads its plugin, limits itself, and runs the functions that its host calls, until the host
//! ends the connection.

#![allow(unsafe_code)]

use std::ffi::CString;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;

use jde_abi::raw;
use jde_loader::instance::{ArbitrationQuery, InProcessInstance, SavedMemory};
use jde_loader::{LoadedPlugin, PluginLocation, Plugins, SchemaFunctions};
use jde_panel::Gesture;
use rustix::fs::{Mode, OFlags};
use rustix::process::{Signal, set_parent_process_death_signal};

use super::authority::AuthorityFlag;
use super::launch::{Launch, receive_files};
use super::limits;
use super::memory::IsolatedPort;
use super::table::{CallState, HOST, Session};
use super::wire::{Frame, FrameKind, READY, Wire};

/// Why a schema is not run.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// There is no host at the other end.
    #[error(
        "this program runs a schema in a process of its own for a host, and there is no host at standard input ({0}): \
         write isolate = \"process\" in the schema's table and run the application"
    )]
    NoHost(#[source] io::Error),
}

/// Runs one schema in this process for the host at standard input, and returns when the host ends the
/// connection. `load` loads the plugin: [`load`], unless the program runs plugins of its own kind. Must be
/// called first in a program of its own, which does nothing else.
///
/// # Errors
/// [`ServeError`].
pub fn serve(load: impl FnOnce(&PluginLocation) -> Result<LoadedPlugin, String>) -> Result<(), ServeError> {
    let (stream, files) = connect_to_host().map_err(ServeError::NoHost)?;
    let mut wire = Wire::new(stream);
    let launch = wire.receive().map_err(ServeError::NoHost)?;
    let Ok(launch) = jde_panel::decode::<Launch>(&launch.bytes) else {
        return Err(ServeError::NoHost(io::ErrorKind::InvalidData.into()));
    };
    let name = CString::new(launch.name.replace('\0', "")).unwrap_or_default();
    // The name that `ps` and `top` show. Failing to set it is harmless.
    let _ = rustix::thread::set_name(&name);
    super::run_when_due();
    let mut session = Session {
        wire,
        name,
        application: launch.application,
        seed: launch.seed,
        real_time: launch.real_time,
        ports: Vec::new(),
        authority: None,
        call: CallState::default(),
    };
    let mut files = files.into_iter();
    let loaded = session
        .map_memory(&launch, &mut files)
        .map_err(|error| format!("its memory cannot be mapped: {error}"))
        .and_then(|()| {
            let plugin = load(&launch.code.plugin.clone().or_open(files.next()))?;
            find(&plugin, &launch, &mut session.ports)
        });
    let table = match loaded {
        Ok(table) => table,
        Err(reason) => {
            session.notify(FrameKind::Fail, 0, &reason);
            return session.finish_call(failed()).map_err(ServeError::NoHost);
        }
    };
    let unset_limits = limits::apply(launch.limits);
    let done = Frame {
        bytes: jde_panel::encode(&unset_limits),
        ..Frame::new(FrameKind::Done)
    };
    session.finish_call(done).map_err(ServeError::NoHost)?;
    run(&mut session, table, &launch);
    // Threads of the plugin may still read the memory of its ports. The process is about to end.
    std::mem::forget(session);
    Ok(())
}

/// Returns the stream to the host and the files of shared memory. From now on this process ends with its
/// host.
fn connect_to_host() -> io::Result<(UnixStream, Vec<OwnedFd>)> {
    set_parent_process_death_signal(Some(Signal::KILL))?;
    let stream = UnixStream::from(rustix::stdio::stdin().try_clone_to_owned()?);
    let files = receive_files(&stream)?;
    // From now on standard input is empty: the plugin must not read the host's messages.
    let null = rustix::fs::open("/dev/null", OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty())?;
    rustix::stdio::dup2_stdin(null.as_fd())?;
    Ok((stream, files))
}

impl Session {
    /// Maps the shared memory.
    fn map_memory(&mut self, launch: &Launch, files: &mut impl Iterator<Item = OwnedFd>) -> io::Result<()> {
        self.ports = IsolatedPort::open_all(&launch.ports, files)?;
        if let Some(instance) = launch.authority {
            let file = files.next().ok_or(io::ErrorKind::UnexpectedEof)?;
            self.authority = Some(AuthorityFlag::open(&file, instance)?);
        }
        Ok(())
    }
}

/// Loads a library, or one of `plugins`, those that are linked into this program.
///
/// # Errors
/// Why it cannot be loaded.
pub fn load(plugins: &Plugins, plugin: &PluginLocation) -> Result<LoadedPlugin, String> {
    match plugin {
        PluginLocation::File(path) => LoadedPlugin::open_copy(path, path).map_err(|error| error.to_string()),
        PluginLocation::LinkedIn(name) => plugins.load(name, &[]).map_err(|error| error.to_string()),
        PluginLocation::Python { path, .. } => Err(format!("{} is a file of Python", path.display())),
    }
}

/// Returns the functions of a type of a plugin, and tells the ports their types.
fn find(
    plugin: &LoadedPlugin,
    launch: &Launch,
    ports: &mut [IsolatedPort],
) -> Result<SchemaFunctions, String> {
    let number = launch.code.number;
    let Some(schema) = plugin.description.schemas.get(number) else {
        return Err(format!("its plugin has no type number {number}"));
    };
    let own = schema.ports.iter().map(|port| &port.value_type);
    let listed = launch.listed.iter().map(|port| &port.value_type);
    for (port, value_type) in ports.iter_mut().zip(own.chain(listed)) {
        port.set_type(value_type);
    }
    Ok(plugin.schema(number))
}

/// Runs the functions that the host calls, until the stream ends.
fn run(session: &mut Session, table: SchemaFunctions, launch: &Launch) {
    let mut instance: Option<InProcessInstance> = None;
    while let Ok(frame) = session.wire.receive() {
        if frame.kind == FrameKind::Value {
            session.store_early(&frame);
            continue;
        }
        session.call = CallState::of(&frame);
        limits::renew(launch.limits);
        let done = match (frame.kind, &mut instance) {
            (FrameKind::Create, _) => {
                let own = launch.ports.len() - launch.listed.len();
                // SAFETY: the table was checked when it was loaded.
                let created = unsafe {
                    InProcessInstance::create(table, &HOST, session.context(), &launch.listed, own)
                };
                let done = match &created {
                    Ok(_) => status(raw::OK),
                    Err(reason) => Frame {
                        bytes: reason.as_bytes().to_vec(),
                        ..failed()
                    },
                };
                instance = created.ok();
                done
            }
            (FrameKind::Destroy, _) => {
                drop(instance.take());
                // The host expects nothing after this reply.
                drop(session.finish_call(status(raw::OK)));
                return;
            }
            (kind, Some(instance)) => dispatch(session, instance, kind, &frame),
            (_, None) => failed(),
        };
        if session.finish_call(done).is_err() {
            return;
        }
    }
}

fn dispatch(
    session: &mut Session,
    instance: &mut InProcessInstance,
    kind: FrameKind,
    frame: &Frame,
) -> Frame {
    let now = session.call.now();
    let context = session.context();
    match kind {
        FrameKind::Awake => status(instance.awake(context)),
        FrameKind::Check | FrameKind::CheckAndIterate => {
            let (done, ready, urgency) = instance.check(context);
            let is_ready = done == raw::OK && ready;
            let done = match kind {
                FrameKind::CheckAndIterate if is_ready => instance.iterate(session.context()),
                _ => done,
            };
            Frame {
                flags: if is_ready { READY } else { 0 },
                words: [urgency.to_bits(), 0, 0, 0],
                ..status(done)
            }
        }
        FrameKind::Iterate => status(instance.iterate(context)),
        FrameKind::Arbitrate => {
            let Ok(query) = jde_panel::decode::<ArbitrationQuery>(&frame.bytes) else {
                return failed();
            };
            let (done, verdict) = instance.arbitrate(context, &query);
            Frame {
                bytes: jde_panel::encode(&verdict),
                ..status(done)
            }
        }
        FrameKind::Sleep => {
            instance.sleep(context);
            status(raw::OK)
        }
        FrameKind::Draw => {
            let (done, list) = instance.draw(context, now);
            Frame {
                bytes: jde_panel::encode(&list),
                ..status(done)
            }
        }
        FrameKind::Touch => {
            let Ok((by, gesture)) = jde_panel::decode::<(String, Gesture)>(&frame.bytes) else {
                return failed();
            };
            status(instance.touch(context, &by, &gesture))
        }
        FrameKind::Save => {
            let (done, saved) = instance.save(context);
            Frame {
                bytes: jde_panel::encode(&saved),
                ..status(done)
            }
        }
        FrameKind::Restore => {
            let saved = SavedMemory {
                version: frame.number,
                bytes: frame.bytes.clone(),
            };
            status(instance.restore(context, &saved))
        }
        FrameKind::Start
        | FrameKind::Value
        | FrameKind::Create
        | FrameKind::Destroy
        | FrameKind::Reply
        | FrameKind::Read
        | FrameKind::Loan
        | FrameKind::Publish
        | FrameKind::Retract
        | FrameKind::Wake
        | FrameKind::PutToSleep
        | FrameKind::Child
        | FrameKind::SetPolicy
        | FrameKind::Hold
        | FrameKind::Log
        | FrameKind::Fail
        | FrameKind::Done => failed(),
    }
}

fn status(status: i32) -> Frame {
    Frame {
        status,
        ..Frame::new(FrameKind::Done)
    }
}

fn failed() -> Frame {
    status(raw::FAILED)
}
