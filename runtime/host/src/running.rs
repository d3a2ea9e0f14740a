//! A running application, in real time or in lockstep, and the [`Handle`] through which programs and tools
//! use it. It loads no plugin and prints nothing.

use std::sync::Arc;
use std::thread::JoinHandle;

use jde_app::{Application, Executor};
use jde_board::Board;
use jde_core::{Nanos, SchemaId};
use jde_isolation::Program;
use jde_loader::Plugins;
use jde_panel::Gesture;
use jde_records::event::{Observer, Outcome, What};
use jde_records::snapshot::Snapshot;
use jde_records::turn::OnTurn;

use crate::clock::Clock;
use crate::engine::{Engine, Notifier};
use crate::exec::lockstep;
use crate::exec::pool::Pool;
use crate::exec::supervisor::{self, Alarm, ThreadExecutor};
use crate::exec::threads::Threads;
use crate::mission;
use crate::mock::Mock;
use crate::operator_handle::{OperatorHandle, printable_name};
use crate::panels::{PanelError, PanelViewGuard};
use crate::prepare::prepare;
use crate::transaction_observer::TransactionObserver;
use jde_panel::PanelFrame;

/// Called with an application that is about to start. An error prevents the start.
pub type StartHook = Box<dyn FnOnce(&Handle) -> Result<(), StartHookError>>;

/// Why a [`StartHook`] function prevents the start.
pub type StartHookError = Box<dyn std::error::Error + Send + Sync>;

/// The options for running an application.
pub struct Options {
    /// The observers, which receive every event in order.
    pub observers: Vec<Box<dyn Observer>>,
    /// Called after all variables are declared and before the first write, so that a watch misses no value.
    pub start_hook: Option<StartHook>,
    /// The time at which the application ends, ns.
    pub limit: Option<Nanos>,
    /// Seconds of application time per second of machine time; real time only.
    pub speed: f64,
    /// Runs the real-time executors in virtual time. Time advances when all their threads wait, and a call
    /// takes exactly the time that it [spends](Handle::spend), however loaded the machine is. For tests of
    /// timing guarantees.
    pub counted: bool,
    /// Whether time may stand still ([`Handle::stand_still`]). Drivers of devices refuse that.
    pub may_stand_still: bool,
    /// Called with every turn of a schema and the inputs that it used, so that the turn can be replayed (see
    /// [`crate::replay`]).
    pub on_turn: Option<OnTurn>,
    /// Observes every transaction of the rules.
    pub transaction_observer: Option<Box<dyn TransactionObserver>>,
    /// The program that runs schemas in processes of their own. Those in Python get the package of its installation.
    pub isolation_program: Option<Program>,
    /// The schemas, by name, that a mock takes the place of; of several for one schema, the last.
    pub mocks: Vec<(String, Mock)>,
}

/// Why an application did not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// A plugin cannot create an instance.
    #[error("schema `{schema}` (type `{type_name}`) cannot be created: {reason}")]
    Create {
        /// The instance.
        schema: String,
        /// Its type.
        type_name: String,
        /// The reason.
        reason: String,
    },
    /// A plugin of the application is not among those supplied.
    #[error(
        "plugin `{0}` of the application is not loaded; start it with the plugins it was checked against"
    )]
    MissingPlugin(String),
    /// A schema requires a process of its own, and [`Options::isolation_program`] is `None`.
    #[error(
        "schema `{0}` requires a process of its own, and the program that started it provides none; remove its `isolate`"
    )]
    NoProgram(String),
    /// A mock does not fit the application.
    #[error("the mock of schema `{schema}` cannot be used: {reason}")]
    Mock {
        /// The schema.
        schema: String,
        /// The reason.
        reason: String,
    },
    /// The system refused to create a thread.
    #[error("the system refuses a thread: {0}")]
    Thread(#[from] std::io::Error),
    /// The function in [`Options::start_hook`] prevented the start.
    #[error("{0}")]
    HookFailed(#[source] StartHookError),
    /// The application contradicts itself. `app::load` never returns such an application.
    #[error("the application cannot be wired: {0}")]
    Wiring(String),
}

/// An application that runs in real time, on threads of its own. Dropping it stops the application and brings
/// it to rest.
pub struct Running {
    engine: Arc<Engine>,
    executor: Arc<dyn ThreadExecutor>,
    alarm: Arc<Alarm>,
    supervisor: Option<JoinHandle<()>>,
}

/// An application that runs in lockstep: in virtual time, on the caller's thread. Dropping it stops the
/// application and brings it to rest.
pub struct Lockstep {
    pub(crate) engine: Arc<Engine>,
    executor: lockstep::LockstepExecutor,
    limit: Option<Nanos>,
    is_shut_down: bool,
}

/// Access to a running application of either kind. Usable from any thread, also after the application has
/// ended.
#[derive(Clone)]
pub struct Handle {
    pub(crate) engine: Arc<Engine>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            observers: Vec::new(),
            start_hook: None,
            limit: None,
            speed: 1.0,
            counted: false,
            may_stand_still: false,
            on_turn: None,
            transaction_observer: None,
            isolation_program: None,
            mocks: Vec::new(),
        }
    }
}

impl Running {
    /// Starts an application.
    ///
    /// # Errors
    /// [`StartError`]. On an error no schema is awake, and every instance that was created has been
    /// destroyed.
    pub fn start(
        application: Application,
        plugins: &Plugins,
        mut options: Options,
    ) -> Result<Self, StartError> {
        let executor = application.executor;
        let clock = if options.counted {
            Clock::counted()
        } else {
            Clock::real(options.speed)
        };
        let clock = with_standstill(clock, &options);
        let (engine, runners) = prepare(application, plugins, clock, &mut options)?;
        // Counted time cannot advance until this thread has started the others.
        engine.clock.register_thread();
        let alarm = Arc::new(Alarm::default());
        let (threads, notifier): (Arc<dyn ThreadExecutor>, Arc<dyn Notifier>) = match executor {
            Executor::Threads => {
                let threads = Threads::new(&engine, runners, Arc::clone(&alarm))?;
                (Arc::clone(&threads) as _, threads)
            }
            Executor::Pool => {
                let pool = Pool::new(&engine, runners, Arc::clone(&alarm))?;
                (Arc::clone(&pool) as _, pool)
            }
        };
        engine.attach(&notifier);
        mission::watch_mission(&engine);
        run_start_hook(&engine, options.start_hook).inspect_err(|_| drop(threads.end_all(&engine)))?;
        let supervision = (Arc::clone(&engine), Arc::clone(&threads), Arc::clone(&alarm));
        let supervise = move || {
            let (engine, threads, alarm) = supervision;
            supervisor::run_guarded(&engine, || {
                supervisor::supervise(&engine, &*threads, &alarm, options.limit);
            });
            engine.clock.unregister_thread();
        };
        engine.clock.register_thread();
        let supervisor = std::thread::Builder::new()
            .name(String::from("supervisor"))
            .spawn(supervise)
            .inspect_err(|_| drop(threads.end_all(&engine)))?;
        engine.rules.start();
        engine.clock.unregister_thread();
        Ok(Self {
            engine,
            executor: threads,
            alarm,
            supervisor: Some(supervisor),
        })
    }

    /// Returns a handle for tools.
    #[must_use]
    pub fn handle(&self) -> Handle {
        Handle::new(&self.engine)
    }

    /// Blocks until the application ends, brings it to rest, and returns its outcome.
    pub fn wait(mut self) -> Outcome {
        let outcome = self.engine.outcome.wait();
        self.shut_down(&outcome);
        outcome
    }

    fn shut_down(&mut self, outcome: &Outcome) {
        let Some(thread) = self.supervisor.take() else {
            return;
        };
        supervisor::bring_to_rest(&self.engine, &*self.executor);
        self.alarm.stop();
        // `run_guarded` has reported a panic of this thread.
        let _ = thread.join();
        self.engine.rules.report_now(What::Ended {
            outcome: outcome.clone(),
        });
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.engine.outcome.conclude(Outcome::Stopped);
        let outcome = self.engine.outcome.wait();
        self.shut_down(&outcome);
    }
}

impl Lockstep {
    /// Prepares an application; its schemas awake at time 0.
    ///
    /// # Errors
    /// [`StartError`].
    pub fn start(
        application: Application,
        plugins: &Plugins,
        mut options: Options,
    ) -> Result<Self, StartError> {
        let clock = with_standstill(Clock::new_virtual(), &options);
        let (engine, runners) = prepare(application, plugins, clock, &mut options)?;
        let mut executor = lockstep::LockstepExecutor::new(Arc::clone(&engine), runners);
        mission::watch_mission(&engine);
        run_start_hook(&engine, options.start_hook).inspect_err(|_| executor.shut_down())?;
        executor.start();
        Ok(Self {
            engine,
            executor,
            limit: options.limit,
            is_shut_down: false,
        })
    }

    /// Returns a handle for tools.
    #[must_use]
    pub fn handle(&self) -> Handle {
        Handle::new(&self.engine)
    }

    /// Runs until virtual time reaches `time` or stands still. Returns the outcome if the application ended.
    pub fn run_until(&mut self, time: Nanos) -> Option<Outcome> {
        let end = self.limit.map_or(time, |limit| limit.min(time));
        if let Some(outcome) = self.executor.run_until(end) {
            return Some(outcome);
        }
        if self.limit.is_some_and(|limit| limit <= time) && !self.engine.clock.is_still() {
            self.engine.outcome.conclude(Outcome::TimeUp);
        }
        self.engine.outcome.get()
    }

    /// Returns the next time at which a schema takes its turn, a timer of the rules ends or a value is over; `None` if
    /// nothing is due.
    #[must_use]
    pub fn next_instant(&self) -> Option<Nanos> {
        self.executor.next_instant()
    }

    /// Runs until the application ends, brings it to rest, and returns its outcome. Without a limit and
    /// without a mission, it ends only when it is stopped.
    pub fn run(mut self) -> Outcome {
        let outcome = self.run_until(Nanos::MAX - 1).unwrap_or(Outcome::Stopped);
        self.shut_down();
        outcome
    }

    /// Brings the application to rest. Afterwards only its [`Handle`]s are usable.
    fn shut_down(&mut self) {
        if !std::mem::replace(&mut self.is_shut_down, true) {
            self.engine.outcome.conclude(Outcome::Stopped);
            self.executor.shut_down();
            let outcome = self.engine.outcome.wait();
            self.engine.rules.report_now(What::Ended { outcome });
        }
    }
}

impl Drop for Lockstep {
    fn drop(&mut self) {
        self.shut_down();
    }
}

impl Handle {
    pub(crate) fn new(engine: &Arc<Engine>) -> Self {
        Self {
            engine: Arc::clone(engine),
        }
    }

    /// Returns the application that runs.
    #[must_use]
    pub fn application(&self) -> &Application {
        &self.engine.application
    }

    /// Returns the schemas that a name denotes: the instance of that name, or else all
    /// instances of the plugin of that name.
    #[must_use]
    pub fn schemas_named(&self, name: &str) -> Vec<SchemaId> {
        let application = &self.engine.application;
        if let Some(id) = application.instance(name) {
            return vec![id];
        }
        let instances = application.instances.entries();
        let of_plugin = instances.filter(|(_, instance)| application.plugins[instance.plugin].name == name);
        of_plugin.map(|(id, _)| id).collect()
    }

    /// Returns the shared variables of the application.
    #[must_use]
    pub fn board(&self) -> &Board {
        &self.engine.board
    }

    /// Returns the newest value of a variable, by its full name; `None` if it has no value.
    ///
    /// # Errors
    /// There is no such variable, or it has another type.
    pub fn value<T: jde_types::Value>(&self, variable: &str) -> Result<Option<T>, String> {
        let variable = self
            .engine
            .board
            .get(variable)
            .map_err(|error| error.to_string())?;
        let declared = variable.describe();
        let requested = T::describe();
        if !declared.value_type.same_as(&requested) {
            return Err(format!(
                "`{}` is a {}, not a {}",
                declared.full_name(),
                declared.value_type.name,
                requested.name
            ));
        }
        let mut reader = variable.reader("handle").of_what_is_in_force();
        Ok(reader
            .latch(self.now())
            .and_then(|latched| T::from_bytes(latched.bytes)))
    }

    /// Returns the time since the application's start, ns.
    #[must_use]
    pub fn now(&self) -> Nanos {
        self.engine.clock.now()
    }

    /// Advances time by `time` within a call if time is [counted](Options::counted); otherwise does nothing.
    pub fn spend(&self, time: Nanos) {
        self.engine.clock.spend(time);
    }

    /// Returns the current state of every schema and group.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        self.engine.snapshot()
    }

    /// Returns the outcome; `None` while the application runs.
    #[must_use]
    pub fn outcome(&self) -> Option<Outcome> {
        self.engine.outcome.get()
    }

    /// Requests the end of the application.
    pub fn stop(&self) {
        self.engine.outcome.conclude(Outcome::Stopped);
    }

    /// Returns the schemas that have a panel.
    #[must_use]
    pub fn panels(&self) -> Vec<SchemaId> {
        let schemas = self.engine.application.instances.ids();
        schemas
            .filter(|schema| self.engine.panels.has_panel(*schema))
            .collect()
    }

    /// Draws the panel of a schema, at most `rate` times a second and never more often than
    /// [`MAX_RATE`], until the returned value is dropped. An awake schema draws after its iterations and
    /// checks; a sleeping schema is drawn on its own.
    ///
    /// `on_drawing` is called after each drawing, on the schema's thread. If there is no instance to draw the
    /// panel, it is called at once, on the caller's thread. It must return at once: it may wake a thread or
    /// send a message.
    ///
    /// [`MAX_RATE`]: jde_panel::MAX_RATE
    ///
    /// # Errors
    /// [`PanelError`]: there is no such schema, it has no panel, or the run is a replay.
    pub fn view_panel(
        &self,
        schema: SchemaId,
        rate: f64,
        on_drawing: impl Fn() + Send + Sync + 'static,
    ) -> Result<PanelViewGuard, PanelError> {
        self.engine.view_panel(schema, rate, Arc::new(on_drawing))
    }

    /// Returns what the panel of a schema shows, or why it shows nothing; `None` before the first drawing for
    /// the current viewers.
    #[must_use]
    pub fn panel(&self, schema: SchemaId) -> Option<Arc<PanelFrame>> {
        self.engine.panels.newest(schema)
    }

    /// Applies a gesture to a widget of a schema's panel, in the name of `by`. The schema receives gestures
    /// between two of its iterations, in the order in which they arrive; each is reported as an operator's
    /// action (R14). If a drag or a slider moves again before the schema receives the gesture, only the
    /// newest position is delivered.
    ///
    /// # Errors
    /// [`PanelError`]: there is no instance to receive it, it does not fit what the panel shows, or too many
    /// gestures wait already.
    pub fn touch(&self, by: &str, schema: SchemaId, gesture: Gesture) -> Result<(), PanelError> {
        self.engine.queue_gesture(&printable_name(by), schema, gesture)
    }

    /// Returns the actions of an operator (R14). `by` is the name of the operator, such as "ana@laptop".
    #[must_use]
    pub fn operator(&self, by: &str) -> OperatorHandle {
        OperatorHandle::new(&self.engine, by)
    }
}

fn with_standstill(clock: Clock, options: &Options) -> Clock {
    match options.may_stand_still {
        true => clock.with_standstill(),
        false => clock,
    }
}

fn run_start_hook(engine: &Arc<Engine>, before_start: Option<StartHook>) -> Result<(), StartError> {
    let Some(before_start) = before_start else {
        return Ok(());
    };
    before_start(&Handle::new(engine)).map_err(StartError::HookFailed)
}
