//! One thread for each instance. The thread of a sleeping schema waits without a deadline and costs no
//! processor time.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, mpsc};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use jde_core::Nanos;

use super::ending;
use super::supervisor::{Alarm, Crew, guarded};
use crate::engine::{Bells, Engine, Signal};
use crate::inbox::Inbox;
use crate::runner::{Line, Runner};

/// One mailbox and one thread for each instance.
pub(crate) struct Threads {
    seats: Vec<Arc<Seat>>,
    alarm: Arc<Alarm>,
}

struct Seat {
    mail: Mutex<Mail>,
    news: Condvar,
    idle: Condvar,
    /// The runner and its thread. A runner that hangs is replaced.
    holder: Mutex<Holder>,
}

struct Holder {
    runner: Arc<Mutex<Runner>>,
    line: Line,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Mail {
    inbox: Inbox,
    /// Its thread takes a turn, and looks here before it waits again.
    busy: bool,
    leave: bool,
    /// The number of threads that wait until there is nothing to do. Usually none, and notifying none still
    /// costs a system call.
    settling: usize,
}

impl Bells for Threads {
    fn leave(&self, instance: usize, signal: Signal) -> bool {
        let mut mail = lock(&self.seats[instance].mail);
        mail.inbox.put(signal);
        !mail.busy
    }

    fn call(&self, instance: usize) {
        self.seats[instance].news.notify_one();
    }

    fn set_alarm(&self, next: Option<Nanos>) -> bool {
        self.alarm.set(next)
    }

    fn call_alarm(&self) {
        self.alarm.call();
    }
}

impl Threads {
    pub(crate) fn new(
        engine: &Arc<Engine>,
        runners: Vec<Runner>,
        alarm: Arc<Alarm>,
    ) -> std::io::Result<Arc<Self>> {
        let seats = runners.into_iter().map(|runner| Arc::new(Seat::new(runner)));
        let threads = Arc::new(Self {
            seats: seats.collect(),
            alarm,
        });
        for (number, seat) in threads.seats.iter().enumerate() {
            let runner = Arc::clone(&lock(&seat.holder).runner);
            match spawn(engine, number, seat, move || Some(runner)) {
                Ok(thread) => lock(&seat.holder).thread = Some(thread),
                Err(error) => {
                    threads.dismiss(engine);
                    return Err(error);
                }
            }
        }
        Ok(threads)
    }
}

impl Crew for Threads {
    fn settled(&self, instance: usize, within: Duration) -> bool {
        let seat = &self.seats[instance];
        let mut mail = lock(&seat.mail);
        mail.settling += 1;
        let waiting = |mail: &mut Mail| mail.busy || !mail.inbox.is_empty();
        let (mut mail, _) = seat
            .idle
            .wait_timeout_while(mail, within, waiting)
            .unwrap_or_else(PoisonError::into_inner);
        mail.settling -= 1;
        !waiting(&mut mail)
    }

    /// The replacement thread is started before the call is given up: if the system refuses it, the schema
    /// stays as it is.
    fn relieve(
        &self,
        engine: &Arc<Engine>,
        instance: usize,
        since: Nanos,
        tell: &mut dyn FnMut(u64),
    ) -> bool {
        let seat = &self.seats[instance];
        let (hand_over, takes) = mpsc::channel();
        let thread = match spawn(engine, instance, seat, move || takes.recv().ok()) {
            Ok(thread) => thread,
            Err(error) => {
                tracing::error!("the system refuses a thread in place of one that hangs: {error}");
                return false;
            }
        };
        let line = lock(&seat.holder).line.clone();
        let Some(runner) = line.give_up(since, tell) else {
            return false;
        };
        let line = runner.line();
        let runner = Arc::new(Mutex::new(runner));
        // The hung thread is not joined. If its call ever returns, it ends the remains of the instance and
        // exits.
        *lock(&seat.holder) = Holder {
            runner: Arc::clone(&runner),
            line,
            thread: Some(thread),
        };
        lock(&seat.mail).busy = false;
        // The new thread waits for this.
        let _ = hand_over.send(runner);
        true
    }

    fn dismiss(&self, engine: &Arc<Engine>) -> Vec<usize> {
        for seat in &self.seats {
            lock(&seat.mail).leave = true;
            seat.news.notify_all();
        }
        let seats = self.seats.iter().enumerate().rev();
        let lost = ending::end(
            engine,
            seats.map(|(number, seat)| (number, Arc::clone(&lock(&seat.holder).runner))),
        );
        for (number, seat) in self.seats.iter().enumerate() {
            let thread = lock(&seat.holder).thread.take();
            if let Some(thread) = thread.filter(|_| !lost.contains(&number)) {
                // The thread only has to see `leave`. `guarded` has reported its panics.
                let _ = thread.join();
            }
        }
        lost
    }
}

impl Seat {
    fn new(runner: Runner) -> Self {
        Self {
            mail: Mutex::default(),
            news: Condvar::new(),
            idle: Condvar::new(),
            holder: Mutex::new(Holder {
                line: runner.line(),
                runner: Arc::new(Mutex::new(runner)),
                thread: None,
            }),
        }
    }

    fn run(&self, engine: &Engine, runner: &Mutex<Runner>) {
        super::supervisor::sharpen_timers();
        let mut due = None;
        loop {
            let Some(inbox) = self.next(engine, due) else {
                return;
            };
            due = lock(runner).turn(inbox);
        }
    }

    /// Waits for signals or for the deadline. Returns `None` when the thread must leave.
    fn next(&self, engine: &Engine, due: Option<Nanos>) -> Option<Inbox> {
        let mut mail = lock(&self.mail);
        mail.busy = false;
        loop {
            if mail.leave {
                return None;
            }
            if !mail.inbox.is_empty() {
                break;
            }
            if mail.settling > 0 {
                self.idle.notify_all();
            }
            if due.is_some_and(|due| engine.clock.until(due).is_zero()) {
                break;
            }
            mail = engine.clock.wait(&self.news, mail, due);
        }
        engine.clock.works();
        mail.busy = true;
        Some(std::mem::take(&mut mail.inbox))
    }
}

/// Starts a thread for a seat. It runs the runner that `runner` returns, if any.
fn spawn(
    engine: &Arc<Engine>,
    number: usize,
    seat: &Arc<Seat>,
    runner: impl FnOnce() -> Option<Arc<Mutex<Runner>>> + Send + 'static,
) -> std::io::Result<JoinHandle<()>> {
    let (engine, seat) = (Arc::clone(engine), Arc::clone(seat));
    engine.clock.hire();
    // The system shows 15 bytes of a thread's name. The instance's name is the most useful in `top` and a
    // debugger.
    let thread = Builder::new().name(engine.name(number).to_owned());
    thread.spawn(move || {
        guarded(&engine, || {
            if let Some(runner) = runner() {
                seat.run(&engine, &runner);
            }
        });
        engine.clock.dismiss();
    })
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
