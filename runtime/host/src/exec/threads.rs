//! One thread for each instance. The thread of a sleeping schema waits without a deadline and costs no
//! processor time.

use std::sync::{Arc, mpsc};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use jde_core::{Nanos, SchemaId, Table};
use parking_lot::{Condvar, Mutex};

use super::shutdown;
use super::supervisor::{Alarm, ThreadExecutor, run_guarded};
use crate::engine::{Engine, Notifier, Signal};
use crate::inbox::Inbox;
use crate::runner::{CallHandle, Runner};

/// One mailbox and one thread for each instance.
pub(crate) struct Threads {
    instances: Table<SchemaId, Arc<InstanceThread>>,
    alarm: Arc<Alarm>,
}

struct InstanceThread {
    mailbox: Mutex<Mailbox>,
    signalled: Condvar,
    idle: Condvar,
    /// The runner and its thread. A runner that hangs is replaced.
    runner: Mutex<ThreadRunner>,
}

struct ThreadRunner {
    runner: Arc<Mutex<Runner>>,
    call_handle: CallHandle,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Mailbox {
    inbox: Inbox,
    /// Its thread takes a turn, and checks the mailbox before it waits again.
    busy: bool,
    is_stopping: bool,
    /// The number of threads that wait until the instance is idle. Usually none, and notifying none still
    /// costs a system call.
    idle_waiters: usize,
}

impl Notifier for Threads {
    fn post(&self, instance: SchemaId, signal: Signal) -> bool {
        let mut mailbox = self.instances[instance].mailbox.lock();
        mailbox.inbox.push(signal);
        !mailbox.busy
    }

    fn notify(&self, instance: SchemaId) {
        self.instances[instance].signalled.notify_one();
    }

    fn set_timer(&self, next: Option<Nanos>) -> bool {
        self.alarm.set(next)
    }

    fn notify_timer(&self) {
        self.alarm.notify();
    }
}

impl Threads {
    pub(crate) fn new(
        engine: &Arc<Engine>,
        runners: Table<SchemaId, Runner>,
        alarm: Arc<Alarm>,
    ) -> std::io::Result<Arc<Self>> {
        let instances = runners
            .into_iter()
            .map(|runner| Arc::new(InstanceThread::new(runner)));
        let threads = Arc::new(Self {
            instances: instances.collect(),
            alarm,
        });
        for (number, thread) in threads.instances.entries() {
            let runner = Arc::clone(&thread.runner.lock().runner);
            match spawn(engine, number, thread, move || Some(runner)) {
                Ok(handle) => thread.runner.lock().thread = Some(handle),
                Err(error) => {
                    threads.end_all(engine);
                    return Err(error);
                }
            }
        }
        Ok(threads)
    }
}

impl ThreadExecutor for Threads {
    fn wait_until_idle(&self, instance: SchemaId, within: Duration) -> bool {
        let thread = &self.instances[instance];
        let mut mailbox = thread.mailbox.lock();
        mailbox.idle_waiters += 1;
        let is_busy = |mailbox: &mut Mailbox| mailbox.busy || !mailbox.inbox.is_empty();
        thread.idle.wait_while_for(&mut mailbox, is_busy, within);
        mailbox.idle_waiters -= 1;
        !is_busy(&mut mailbox)
    }

    /// The replacement thread is started before the call is given up: if the system refuses it, the schema
    /// stays as it is.
    fn replace_runner(
        &self,
        engine: &Arc<Engine>,
        instance: SchemaId,
        (since, guard): (Nanos, Option<SchemaId>),
        report: &mut dyn FnMut(u64),
    ) -> bool {
        let thread = &self.instances[instance];
        let (hand_over, replacement) = mpsc::channel();
        let handle = match spawn(engine, instance, thread, move || replacement.recv().ok()) {
            Ok(handle) => handle,
            Err(error) => {
                tracing::error!("the system refuses a thread in place of one that hangs: {error}");
                return false;
            }
        };
        let hung_call = thread.runner.lock().call_handle.clone();
        let Some(runner) = hung_call.give_up(since, guard, report) else {
            return false;
        };
        let call_handle = runner.call_handle();
        let runner = Arc::new(Mutex::new(runner));
        // The hung thread is not joined. If its call ever returns, it ends the remains of the instance and
        // exits.
        *thread.runner.lock() = ThreadRunner {
            runner: Arc::clone(&runner),
            call_handle,
            thread: Some(handle),
        };
        thread.mailbox.lock().busy = false;
        // The new thread waits for this.
        let _ = hand_over.send(runner);
        true
    }

    fn end_all(&self, engine: &Arc<Engine>) -> Vec<SchemaId> {
        for thread in &self.instances {
            thread.mailbox.lock().is_stopping = true;
            thread.signalled.notify_all();
        }
        let instances = self.instances.entries().rev();
        let lost = shutdown::end_all(
            engine,
            instances.map(|(number, thread)| (number, Arc::clone(&thread.runner.lock().runner))),
        );
        for (number, thread) in self.instances.entries() {
            let handle = thread.runner.lock().thread.take();
            if let Some(handle) = handle.filter(|_| !lost.contains(&number)) {
                // `run_guarded` has reported its panics.
                let _ = handle.join();
            }
        }
        lost
    }
}

impl InstanceThread {
    fn new(runner: Runner) -> Self {
        Self {
            mailbox: Mutex::default(),
            signalled: Condvar::new(),
            idle: Condvar::new(),
            runner: Mutex::new(ThreadRunner {
                call_handle: runner.call_handle(),
                runner: Arc::new(Mutex::new(runner)),
                thread: None,
            }),
        }
    }

    fn run(&self, engine: &Engine, runner: &Mutex<Runner>) {
        jde_isolation::run_when_due();
        let mut due = None;
        loop {
            let Some(inbox) = self.next_turn(engine, due) else {
                return;
            };
            due = runner.lock().take_turn(Some(inbox));
        }
    }

    /// Waits for signals or for the deadline. Returns `None` when the thread must exit.
    fn next_turn(&self, engine: &Engine, due: Option<Nanos>) -> Option<Inbox> {
        let mut mailbox = self.mailbox.lock();
        mailbox.busy = false;
        loop {
            if mailbox.is_stopping {
                return None;
            }
            if !mailbox.inbox.is_empty() {
                break;
            }
            if mailbox.idle_waiters > 0 {
                self.idle.notify_all();
            }
            if due.is_some_and(|due| engine.clock.duration_until(due).is_zero()) {
                break;
            }
            engine.clock.wait(&self.signalled, &mut mailbox, due);
        }
        engine.clock.mark_busy();
        mailbox.busy = true;
        Some(std::mem::take(&mut mailbox.inbox))
    }
}

/// Starts the thread of an instance. It runs the runner that `runner` returns, if any.
fn spawn(
    engine: &Arc<Engine>,
    number: SchemaId,
    thread: &Arc<InstanceThread>,
    runner: impl FnOnce() -> Option<Arc<Mutex<Runner>>> + Send + 'static,
) -> std::io::Result<JoinHandle<()>> {
    let (engine, thread) = (Arc::clone(engine), Arc::clone(thread));
    engine.clock.register_thread();
    // `top` and debuggers show the first 15 bytes of it.
    let builder = Builder::new().name(engine.name(number).to_owned());
    builder.spawn(move || {
        run_guarded(&engine, || {
            if let Some(runner) = runner() {
                thread.run(&engine, &runner);
            }
        });
        engine.clock.unregister_thread();
    })
}
