//! The process of a schema: starts it, kills it, waits for its end, and describes that end.
//!
//! Each process has a thread in the host that starts it and waits for its end. The kernel kills the child
//! when that thread ends, because it tracks parents by thread. So a child lives at most as long as that
//! thread, and as the host, however the host ends. The end of a child is its exit, not the end of its stream: a process
//! that it has forked may hold the stream open. The thread ends those, and the stream.

use std::io;
use std::net::Shutdown;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use jde_app::Isolation;
use jde_core::{SchemaId, Table};
use parking_lot::{Condvar, Mutex, MutexGuard};
use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open, pidfd_send_signal};

use super::descendants::Descendants;
use super::output::PrintedOutput;
use super::traceback::{self, Traceback};
use super::{ProcessConfig, Program};

/// How long a child may take to exit by itself after its instance has ended.
const EXIT_TIMEOUT: Duration = Duration::from_secs(1);

/// The processes of an application, and the program that runs them.
pub struct ProcessTable {
    program: Option<Program>,
    /// By instance. Of several processes, the one called last is last.
    by_instance: Table<SchemaId, Mutex<Vec<Arc<Process>>>>,
}

/// A child.
pub struct Process {
    pid: u32,
    /// Identifies the process permanently: the system reuses process numbers.
    handle: OwnedFd,
    /// What it prints, if that goes to the log.
    output: Option<PrintedOutput>,
    traceback: Option<Traceback>,
    state: Mutex<ProcessState>,
    changed: Condvar,
    waiter: Mutex<Option<JoinHandle<()>>>,
}

#[derive(Default)]
struct ProcessState {
    /// Whether a call is in progress, whose caller detects a death.
    calling: bool,
    /// Whether the process is expected to end.
    ending: bool,
    /// Whether its death was reported to the rules, or is about to be.
    is_reported: bool,
    /// Why the host killed it.
    kill_reason: Option<String>,
    /// The cause of its death, once it is dead.
    death_cause: Option<String>,
}

impl ProcessTable {
    /// Returns the table of an application with these instances.
    pub fn new(instances: impl Iterator<Item = SchemaId>, program: Option<Program>) -> Self {
        Self {
            program,
            by_instance: instances.map(|_| Mutex::default()).collect(),
        }
    }

    /// Returns the program that runs the processes, if there is one.
    pub fn program(&self) -> Option<&Program> {
        self.program.as_ref()
    }

    /// Records that this process of an instance is about to be called.
    pub fn mark_called(&self, instance: SchemaId, process: &Arc<Process>) {
        let mut children = self.by_instance[instance].lock();
        children.retain(|other| !Arc::ptr_eq(other, process));
        children.push(Arc::clone(process));
    }

    /// Removes a process that ended.
    pub fn remove(&self, instance: SchemaId, process: &Arc<Process>) {
        self.by_instance[instance]
            .lock()
            .retain(|other| !Arc::ptr_eq(other, process));
    }

    /// Whether no other process of the instance was called after this one.
    pub fn is_current(&self, instance: SchemaId, process: &Arc<Process>) -> bool {
        self.current(instance)
            .is_some_and(|current| Arc::ptr_eq(&current, process))
    }

    /// Kills the process of an instance, if it has one. With `is_reported`, the caller reports the death to
    /// the rules.
    pub fn kill(&self, instance: SchemaId, reason: &str, is_reported: bool) {
        if let Some(process) = self.current(instance) {
            process.state().is_reported |= is_reported;
            process.kill(reason);
        }
    }

    /// Whether the death of an instance's process must be reported to the rules. Returns true at most once.
    pub fn claim_death_report(&self, instance: SchemaId) -> bool {
        self.current(instance)
            .is_some_and(|process| process.claim_death_report())
    }

    /// Whether an instance has a process. If so, no call of it blocks a thread forever.
    pub fn has_process(&self, instance: SchemaId) -> bool {
        self.current(instance).is_some()
    }

    /// Returns the process number of an instance, if it has a process.
    pub fn pid(&self, instance: SchemaId) -> Option<u32> {
        self.current(instance).map(|process| process.pid)
    }

    fn current(&self, instance: SchemaId) -> Option<Arc<Process>> {
        self.by_instance[instance].lock().last().cloned()
    }
}

impl Drop for ProcessTable {
    /// Threads that are still inside a call continue; their processes are killed.
    fn drop(&mut self) {
        for process in self
            .by_instance
            .iter()
            .flat_map(|children| children.lock().clone())
        {
            process.state().is_reported = true;
            process.kill("the application ended");
        }
    }
}

impl Process {
    /// Starts a child. `on_death` is called, on the thread that waits for the child, if the child dies
    /// outside of a call and its death was not intended.
    pub fn start(
        config: &ProcessConfig,
        name: &str,
        on_death: impl FnOnce(&Arc<Self>, String) + Send + 'static,
    ) -> io::Result<(Arc<Self>, UnixStream)> {
        let (host_end, child_end) = UnixStream::pair()?;
        let limits = config.limits;
        let mut command = Command::new(&config.program.path);
        command
            .args(&config.program.arguments)
            .stdin(Stdio::from(OwnedFd::from(child_end)));
        // Signals of the terminal are for the host to handle: the child ends when its host ends it. Only the host's
        // own group may read from the terminal.
        let descendants = Descendants::mark(&mut command, !config.debugged);
        let output = match config.debugged {
            true => None,
            false => PrintedOutput::capture(&mut command, name)?,
        };
        let traceback = config
            .is_python
            .then(|| Traceback::prepare(&mut command))
            .transpose()?;
        let stream = host_end.try_clone()?;
        let (sender, started) = sync_channel(1);
        let thread = Builder::new().name(format!("of {name}"));
        let waiter = thread.spawn(move || {
            let started = command.spawn();
            let started = started.and_then(|child| Self::from_child(child, output, traceback));
            // The command holds the child's end of the stream. The host sees the child's end only if this
            // copy is closed.
            drop(command);
            match started {
                Err(error) => drop(sender.send(Err(error))),
                Ok((process, mut child)) => {
                    drop(sender.send(Ok(Arc::clone(&process))));
                    if let Some(output) = &process.output {
                        output.forward_until_exit(&process.handle);
                    }
                    descendants.end_group_at_exit(Pid::from_child(&child));
                    let end = child.wait();
                    if let Some(output) = &process.output {
                        output.finish();
                    }
                    let cause = end.map_or_else(|error| error.to_string(), |end| describe_exit(end, limits));
                    process.handle_exit(cause, on_death);
                    // Whoever still reads what the child sent finds the end after it. It fails if the host has closed it.
                    drop(stream.shutdown(Shutdown::Both));
                    descendants.end_marked();
                }
            }
        })?;
        let process: Arc<Self> = started.recv().map_err(|_| io::ErrorKind::Other)??;
        *process.waiter.lock() = Some(waiter);
        Ok((process, host_end))
    }

    fn from_child(
        mut child: Child,
        output: Option<PrintedOutput>,
        traceback: Option<Traceback>,
    ) -> io::Result<(Arc<Self>, Child)> {
        let pid = Pid::from_child(&child);
        let handle = match pidfd_open(pid, PidfdFlags::empty()) {
            Ok(handle) => handle,
            Err(error) => {
                child.kill()?;
                child.wait()?;
                return Err(error.into());
            }
        };
        let process = Self {
            pid: child.id(),
            handle,
            output,
            traceback,
            // The starter waits for its first message.
            state: Mutex::new(ProcessState {
                calling: true,
                ..ProcessState::default()
            }),
            changed: Condvar::new(),
            waiter: Mutex::default(),
        };
        Ok((Arc::new(process), child))
    }

    fn handle_exit(self: &Arc<Self>, exit: String, on_death: impl FnOnce(&Arc<Self>, String)) {
        let lines = self.traceback.as_ref().and_then(Traceback::read);
        let mut state = self.state();
        let mut cause = state.kill_reason.take().unwrap_or(exit);
        if let Some(lines) = lines {
            cause = format!("{cause}\n{lines}");
        }
        state.death_cause = Some(cause.clone());
        let is_unexpected = !(state.calling || state.ending || state.is_reported);
        drop(state);
        self.changed.notify_all();
        if is_unexpected {
            on_death(self, cause);
        }
    }

    /// Logs what the process has printed until now.
    pub fn forward_output(&self) {
        if let Some(output) = &self.output {
            output.forward();
        }
    }

    /// Starts a call. Its caller reports a death.
    ///
    /// # Errors
    /// The cause of the process's death, if it is dead.
    pub fn begin_call(&self) -> Result<(), String> {
        let mut state = self.state();
        state.calling = true;
        state.death_cause.clone().map_or(Ok(()), Err)
    }

    /// Ends a call that succeeded.
    ///
    /// # Errors
    /// The cause of the process's death, if it died after its last message.
    pub fn end_call(&self) -> Result<(), String> {
        let mut state = self.state();
        state.calling = false;
        state.death_cause.clone().map_or(Ok(()), Err)
    }

    /// Handles a broken call: ensures that the child is dead, and returns the cause of its death.
    pub fn fail_call(&self, reason: &str) -> String {
        // The stream of a dying process may close before its death is visible.
        if !self.is_dead_within(EXIT_TIMEOUT / 10) {
            self.kill(reason);
        }
        let mut state = self.state();
        self.changed
            .wait_while(&mut state, |state| state.death_cause.is_none());
        state.calling = false;
        state.death_cause.clone().unwrap_or_default()
    }

    /// Whether the process is dead, or about to be.
    pub fn is_dead(&self) -> bool {
        let state = self.state();
        state.death_cause.is_some() || state.kill_reason.is_some()
    }

    /// Whether the death must be reported to the rules. Returns true at most once.
    pub fn claim_death_report(&self) -> bool {
        !std::mem::replace(&mut self.state().is_reported, true)
    }

    /// Marks the end of the process as intended from now on.
    pub fn expect_exit(&self) {
        self.state().ending = true;
    }

    /// Waits for the intended end of the process, and kills it if it does not exit in time.
    pub fn reap(&self) {
        self.expect_exit();
        if !self.is_dead_within(EXIT_TIMEOUT) {
            self.kill("it did not exit in time");
        }
        let waiter = self.waiter.lock().take();
        if let Some(waiter) = waiter.filter(|waiter| waiter.thread().id() != std::thread::current().id()) {
            // The thread does not panic, and a panic would need no handling.
            drop(waiter.join());
        }
    }

    fn is_dead_within(&self, time: Duration) -> bool {
        let is_alive = |state: &mut ProcessState| state.death_cause.is_none();
        let mut state = self.state();
        self.changed.wait_while_for(&mut state, is_alive, time);
        state.death_cause.is_some()
    }

    fn kill(&self, reason: &str) {
        let mut state = self.state();
        if state.death_cause.is_none() {
            let is_first = state.kill_reason.is_none();
            state.kill_reason.get_or_insert_with(|| reason.to_owned());
            if is_first && self.traceback.is_some() {
                return traceback::kill(&self.handle);
            }
            // Fails only if the process is dead already.
            let _ = pidfd_send_signal(&self.handle, Signal::KILL);
        }
    }

    fn state(&self) -> MutexGuard<'_, ProcessState> {
        self.state.lock()
    }
}

/// Describes the end of a process without limits.
pub fn describe_exit_status(end: ExitStatus) -> String {
    describe_exit(end, Isolation::default())
}

/// Describes the end of a process.
fn describe_exit(end: ExitStatus, limits: Isolation) -> String {
    let Some(signal) = end.signal() else {
        return match end.code() {
            Some(code) => format!("its process exited by itself, with status {code}"),
            None => format!("its process ended: {end}"),
        };
    };
    let (name, meaning) = match signal {
        1 => ("SIGHUP", ""),
        2 => ("SIGINT", ""),
        3 => ("SIGQUIT", ""),
        4 => ("SIGILL", "an instruction that the processor does not know"),
        5 => ("SIGTRAP", ""),
        6 => ("SIGABRT", "it gave up by itself"),
        7 => ("SIGBUS", "memory that is not there"),
        8 => ("SIGFPE", "a calculation that cannot be done"),
        9 => ("SIGKILL", "somebody killed it, or the machine had no memory left"),
        11 => ("SIGSEGV", "memory that is not its own"),
        13 => ("SIGPIPE", ""),
        15 => ("SIGTERM", "somebody ended it"),
        24 => ("SIGXCPU", "more processor time than it may use"),
        31 => ("SIGSYS", "a system call that it may not make"),
        other => return format!("its process was killed by signal {other}"),
    };
    let mut text = format!("its process was killed by {name}");
    if !meaning.is_empty() {
        text += &format!(" ({meaning})");
    }
    // Code that gets no memory aborts, or uses an invalid address.
    if let (6 | 7 | 11, Some(limit)) = (signal, limits.memory) {
        text += &format!("; it may use {:.1} MB of memory", limit as f64 / 1e6);
    }
    text
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use jde_watchdog::Watchdog;

    use super::*;

    #[test]
    fn a_child_is_dead_when_it_has_exited_though_a_process_that_it_started_holds_its_stream() {
        let _watchdog = Watchdog::for_test();
        // The shell gives background processes another standard input.
        let script = "exec 3<&0; sleep 3600 & exit 3";
        let config = ProcessConfig {
            program: Program {
                path: "sh".into(),
                arguments: ["-c", script].map(Into::into).to_vec(),
            },
            limits: Isolation::default(),
            debugged: false,
            is_python: false,
        };
        let (process, mut stream) = Process::start(&config, "forker", |_, _| {}).expect("a process");
        let mut sent = Vec::new();
        stream.read_to_end(&mut sent).expect("the end of the stream");
        let cause = process.fail_call("its process closed the stream to its host");
        assert_eq!(cause, "its process exited by itself, with status 3");
        process.reap();
    }

    fn check(wait_status: i32, memory: Option<u64>, expected: &str) {
        let limits = Isolation {
            memory,
            ..Isolation::default()
        };
        assert_eq!(describe_exit(ExitStatus::from_raw(wait_status), limits), expected);
    }

    #[test]
    fn the_end_of_a_process_is_described() {
        check(3 << 8, None, "its process exited by itself, with status 3");
        check(
            11,
            None,
            "its process was killed by SIGSEGV (memory that is not its own)",
        );
        check(2, None, "its process was killed by SIGINT");
        check(34, None, "its process was killed by signal 34");
    }

    #[test]
    fn the_memory_limit_is_mentioned_if_it_may_be_the_cause() {
        let expected =
            "its process was killed by SIGABRT (it gave up by itself); it may use 200.0 MB of memory";
        check(6, Some(200_000_000), expected);
        check(3 << 8, Some(1), "its process exited by itself, with status 3");
    }
}
