//! One thread for each instance. The thread of a sleeping schema waits without a deadline and costs no
//! processor time.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, mpsc};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use jde_core::Nanos;

use super::shutdown;
use super::supervisor::{Alarm, ThreadExecutor, run_guarded};
use crate::engine::{Engine, Notifier, Signal};
use crate::inbox::Inbox;
use crate::runner::{CallHandle, Runner};

/// One mailbox and one thread for each instance.
pub(crate) struct Threads {
    instances: Vec<Arc<InstanceThread>>,
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
    /// Its thread takes a turn, and looks here before it waits again.
    busy: bool,
    is_stopping: bool,
    /// The number of threads that wait until there is nothing to do. Usually none, and notifying none still
    /// costs a system call.
    settling: usize,
}

impl Notifier for Threads {
    fn post(&self, instance: usize, signal: Signal) -> bool {
        let mut mail = lock(&self.instances[instance].mailbox);
        mail.inbox.push(signal);
        !mail.busy
    }

    fn notify(&self, instance: usize) {
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
        runners: Vec<Runner>,
        alarm: Arc<Alarm>,
    ) -> std::io::Result<Arc<Self>> {
        let seats = runners
            .into_iter()
            .map(|runner| Arc::new(InstanceThread::new(runner)));
        let threads = Arc::new(Self {
            instances: seats.collect(),
            alarm,
        });
        for (number, seat) in threads.instances.iter().enumerate() {
            let runner = Arc::clone(&lock(&seat.runner).runner);
            match spawn(engine, number, seat, move || Some(runner)) {
                Ok(thread) => lock(&seat.runner).thread = Some(thread),
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
    fn wait_until_idle(&self, instance: usize, within: Duration) -> bool {
        let seat = &self.instances[instance];
        let mut mail = lock(&seat.mailbox);
        mail.settling += 1;
        let waiting = |mail: &mut Mailbox| mail.busy || !mail.inbox.is_empty();
        let (mut mail, _) = seat
            .idle
            .wait_timeout_while(mail, within, waiting)
            .unwrap_or_else(PoisonError::into_inner);
        mail.settling -= 1;
        !waiting(&mut mail)
    }

    /// The replacement thread is started before the call is given up: if the system refuses it, the schema
    /// stays as it is.
    fn replace_runner(
        &self,
        engine: &Arc<Engine>,
        instance: usize,
        since: Nanos,
        tell: &mut dyn FnMut(u64),
    ) -> bool {
        let seat = &self.instances[instance];
        let (hand_over, takes) = mpsc::channel();
        let thread = match spawn(engine, instance, seat, move || takes.recv().ok()) {
            Ok(thread) => thread,
            Err(error) => {
                tracing::error!("the system refuses a thread in place of one that hangs: {error}");
                return false;
            }
        };
        let line = lock(&seat.runner).call_handle.clone();
        let Some(runner) = line.give_up(since, tell) else {
            return false;
        };
        let line = runner.call_handle();
        let runner = Arc::new(Mutex::new(runner));
        // The hung thread is not joined. If its call ever returns, it ends the remains of the instance and
        // exits.
        *lock(&seat.runner) = ThreadRunner {
            runner: Arc::clone(&runner),
            call_handle: line,
            thread: Some(thread),
        };
        lock(&seat.mailbox).busy = false;
        // The new thread waits for this.
        let _ = hand_over.send(runner);
        true
    }

    fn end_all(&self, engine: &Arc<Engine>) -> Vec<usize> {
        for seat in &self.instances {
            lock(&seat.mailbox).is_stopping = true;
            seat.signalled.notify_all();
        }
        let seats = self.instances.iter().enumerate().rev();
        let lost = shutdown::end_all(
            engine,
            seats.map(|(number, seat)| (number, Arc::clone(&lock(&seat.runner).runner))),
        );
        for (number, seat) in self.instances.iter().enumerate() {
            let thread = lock(&seat.runner).thread.take();
            if let Some(thread) = thread.filter(|_| !lost.contains(&number)) {
                // The thread only has to see `leave`. `guarded` has reported its panics.
                let _ = thread.join();
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
        jde_isolation::sharpen_timers();
        let mut due = None;
        loop {
            let Some(inbox) = self.next_turn(engine, due) else {
                return;
            };
            due = lock(runner).take_turn(inbox);
        }
    }

    /// Waits for signals or for the deadline. Returns `None` when the thread must leave.
    fn next_turn(&self, engine: &Engine, due: Option<Nanos>) -> Option<Inbox> {
        let mut mail = lock(&self.mailbox);
        mail.busy = false;
        loop {
            if mail.is_stopping {
                return None;
            }
            if !mail.inbox.is_empty() {
                break;
            }
            if mail.settling > 0 {
                self.idle.notify_all();
            }
            if due.is_some_and(|due| engine.clock.duration_until(due).is_zero()) {
                break;
            }
            mail = engine.clock.wait(&self.signalled, mail, due);
        }
        engine.clock.mark_busy();
        mail.busy = true;
        Some(std::mem::take(&mut mail.inbox))
    }
}

/// Starts a thread for a seat. It runs the runner that `runner` returns, if any.
fn spawn(
    engine: &Arc<Engine>,
    number: usize,
    seat: &Arc<InstanceThread>,
    runner: impl FnOnce() -> Option<Arc<Mutex<Runner>>> + Send + 'static,
) -> std::io::Result<JoinHandle<()>> {
    let (engine, seat) = (Arc::clone(engine), Arc::clone(seat));
    engine.clock.register_thread();
    // The system shows 15 bytes of a thread's name. The instance's name is the most useful in `top` and a
    // debugger.
    let thread = Builder::new().name(engine.name(number).to_owned());
    thread.spawn(move || {
        run_guarded(&engine, || {
            if let Some(runner) = runner() {
                seat.run(&engine, &runner);
            }
        });
        engine.clock.unregister_thread();
    })
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
