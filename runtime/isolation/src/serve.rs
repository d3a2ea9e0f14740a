//! The child: loads its plugin, limits itself, and runs the functions that its host calls, until the host
//! ends the connection.

#![allow(unsafe_code)]

use std::ffi::CString;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;

use jde_abi::raw;
use jde_core::{Id, SchemaId};
use jde_loader::instance::{InProcessInstance, SavedMemory};
use jde_loader::{LoadedPlugin, PluginLocation, Plugins, SchemaFunctions};
use rustix::fs::{Mode, OFlags};
use rustix::process::{Signal, set_parent_process_death_signal};

use super::authority::AuthorityFlag;
use super::launch::{Launch, receive_files};
use super::limits;
use super::memory::IsolatedPort;
use super::messages::{Bytes, Call, FromChild, Function, Returned, ToChild};
use super::table::{CallState, ChildSession, HOST, store_early};
use super::wire::Wire;

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
    write_each_line();
    let mut wire = Wire::new(stream);
    let first = wire.receive().map_err(ServeError::NoHost)?;
    let ToChild::Call(Call {
        function: Function::Start(launch),
        ..
    }) = first
    else {
        return Err(ServeError::NoHost(io::ErrorKind::InvalidData.into()));
    };
    let name = CString::new(launch.name.replace('\0', "")).unwrap_or_default();
    // The name that `ps` and `top` show. Failing to set it is harmless.
    let _ = rustix::thread::set_name(&name);
    super::run_when_due();
    let mut session = ChildSession {
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
            session.notify(&FromChild::Fail(&reason));
            return session
                .finish_call(raw::FAILED, Returned::Nothing)
                .map_err(ServeError::NoHost);
        }
    };
    let started = Returned::Started(limits::apply(launch.limits));
    session
        .finish_call(raw::OK, started)
        .map_err(ServeError::NoHost)?;
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

/// Lets the C library write each line at once, as to a terminal: the host reads them.
fn write_each_line() {
    #[allow(non_upper_case_globals, reason = "its name in C")]
    unsafe extern "C" {
        static stdout: *mut libc::FILE;
        fn setlinebuf(stream: *mut libc::FILE);
    }
    // SAFETY: the stream of the C library, before code of a plugin runs.
    unsafe { setlinebuf(stdout) };
}

impl ChildSession {
    /// Maps the shared memory.
    fn map_memory(&mut self, launch: &Launch, files: &mut impl Iterator<Item = OwnedFd>) -> io::Result<()> {
        self.ports = IsolatedPort::open_all(&launch.ports, files)?;
        if let Some(instance) = launch.authority {
            let file = files.next().ok_or(io::ErrorKind::UnexpectedEof)?;
            self.authority = Some(AuthorityFlag::open(&file, SchemaId::new(instance))?);
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

/// Runs the functions that the host calls, until it ends the instance or the stream ends.
fn run(session: &mut ChildSession, table: SchemaFunctions, launch: &Launch) {
    let mut instance = None;
    while let Ok(message) = session.wire.receive() {
        match message {
            ToChild::Early { port, input } => {
                store_early(&mut session.ports, port, |port| port.store_early(input));
            }
            ToChild::EarlyLoan { port, place } => {
                store_early(&mut session.ports, port, |port| port.store_early_loan(place));
            }
            ToChild::Call(call) => {
                session.call = CallState::of(&call);
                limits::renew(launch.limits);
                let (status, outcome) = dispatch(session, table, launch, &mut instance, call.function);
                if session.finish_call(status, outcome).is_err() {
                    return;
                }
            }
            ToChild::Destroy => {
                session.call = CallState::default();
                limits::renew(launch.limits);
                drop(instance);
                // The host expects nothing after this reply.
                drop(session.finish_call(raw::OK, Returned::Nothing));
                return;
            }
            ToChild::Reply(_) => return,
        }
    }
}

fn dispatch(
    session: &mut ChildSession,
    table: SchemaFunctions,
    launch: &Launch,
    instance: &mut Option<InProcessInstance>,
    function: Function,
) -> (i32, Returned) {
    let now = session.call.now();
    let context = session.context();
    let status = |status| (status, Returned::Nothing);
    if let Function::Create = function {
        let own = launch.ports.len() - launch.listed.len();
        // SAFETY: the table was checked when it was loaded.
        let created = unsafe { InProcessInstance::create(table, &HOST, context, &launch.listed, own) };
        return match created {
            Ok(created) => {
                *instance = Some(created);
                status(raw::OK)
            }
            Err(reason) => (raw::FAILED, Returned::Refused(reason.to_owned())),
        };
    }
    let Some(running) = instance else {
        return status(raw::FAILED);
    };
    match function {
        Function::Start(_) | Function::Create => status(raw::FAILED),
        Function::Awake => status(running.awake(context)),
        Function::Check | Function::CheckAndIterate => {
            let (mut done, ready, urgency) = running.check(context);
            let ready = done == raw::OK && ready;
            if ready && matches!(function, Function::CheckAndIterate) {
                done = running.iterate(session.context());
            }
            (done, Returned::Checked { ready, urgency })
        }
        Function::Iterate => status(running.iterate(context)),
        Function::Arbitrate(query) => {
            let (done, verdict) = running.arbitrate(context, &query);
            (done, Returned::Arbitrated(verdict))
        }
        Function::Sleep => {
            running.sleep(context);
            status(raw::OK)
        }
        Function::Draw => {
            let (done, list) = running.draw(context, now);
            (done, Returned::Drawn(Bytes(jde_panel::encode(&list))))
        }
        Function::Touch { by, gesture } => status(running.touch(context, &by, &gesture)),
        Function::Save => {
            let (done, saved) = running.save(context);
            (done, Returned::Saved(saved.map(Bytes)))
        }
        Function::Restore { version, memory } => {
            let saved = SavedMemory {
                version,
                bytes: memory.0,
            };
            status(running.restore(context, &saved))
        }
    }
}
