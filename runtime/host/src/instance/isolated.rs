//! The host's side of an instance in its own process: calls its functions, and replies to the plugin's
//! requests through the [`CallContext`].

use std::mem::discriminant;
use std::sync::Arc;
use std::time::Duration;

use jde_abi::host::Host as _;
use jde_abi::raw;
use jde_core::{Id, SchemaId};
use jde_isolation::launch::{Launch, send_files};
use jde_isolation::messages::{Bytes, Call, Changes, Done, FromChild, Function, Reply, Returned, ToChild};
use jde_isolation::process::Process;
use jde_isolation::wire::Wire;
use jde_isolation::{HeldTerminal, ProcessConfig, TypeLocation, machine_time};
use jde_loader::instance::{ArbitrationQuery, SavedMemory, Verdict};
use jde_panel::{Gesture, List};

use super::CallContext;
use super::early::{self, CallKind, EarlyPorts};
use super::shared_ports::describe_ports;
use crate::engine::Engine;

/// Values up to this size are sent with the message that requests them; larger ones are mapped. One page:
/// beyond it, copying costs more than the message.
pub(crate) const MAX_INLINE_BYTES: usize = 4096;

/// How long a call may take in lockstep, where no supervisor runs: no virtual time passes, and a child can be
/// killed.
const LOCKSTEP_TIMEOUT: Duration = Duration::from_secs(10);

/// How long a process may take to start before `hang` counts: an interpreter that imports large packages on a busy
/// machine takes seconds, and is no call of the schema.
const START_TIMEOUT: Duration = Duration::from_secs(20);

/// An instance that was created in a child.
pub(crate) struct IsolatedInstance {
    process: Arc<Process>,
    wire: Wire,
    early: EarlyPorts,
    debugged: bool,
}

impl IsolatedInstance {
    /// Starts a child and creates the instance there. The reason for a failure is stored in the call.
    pub(crate) fn create(call: &mut CallContext<'_>, config: &ProcessConfig) -> Option<Self> {
        let engine = call.engine;
        let (clock, meter) = (&engine.clock, &engine.metrics[call.number]);
        meter.begin_call(
            clock
                .now()
                .saturating_add(clock.scale_machine_time(START_TIMEOUT)),
        );
        let started = Self::start(call, config);
        meter.begin_call(clock.now());
        let started = started.and_then(|mut instance| match instance.try_invoke(call, Function::Create) {
            Ok((raw::OK, _)) => Ok(instance),
            Ok((_, outcome)) => {
                instance.terminate(call.engine, call.number);
                let Returned::Refused(reason) = outcome else {
                    return Err(None);
                };
                Err(Some(reason))
            }
            Err(cause) => {
                instance.terminate(call.engine, call.number);
                Err(Some(cause))
            }
        });
        match started {
            Ok(instance) => Some(instance),
            Err(cause) => {
                // A reason from the plugin itself takes precedence.
                if call.failure.is_none() {
                    call.failure = cause;
                }
                None
            }
        }
    }

    pub(crate) fn awake(&mut self, call: &mut CallContext<'_>) -> i32 {
        self.invoke(call, Function::Awake).0
    }

    pub(crate) fn check(&mut self, call: &mut CallContext<'_>) -> (i32, bool, f64) {
        checked(self.invoke(call, Function::Check))
    }

    pub(crate) fn iterate(&mut self, call: &mut CallContext<'_>) -> i32 {
        self.invoke(call, Function::Iterate).0
    }

    /// Checks, and iterates if the precondition is true. The status is that of the iteration if it is.
    pub(crate) fn check_and_iterate(&mut self, call: &mut CallContext<'_>) -> (i32, bool, f64) {
        checked(self.invoke(call, Function::CheckAndIterate))
    }

    pub(crate) fn arbitrate(
        &mut self,
        call: &mut CallContext<'_>,
        query: &ArbitrationQuery,
    ) -> (i32, Verdict) {
        let (status, outcome) = self.invoke(call, Function::Arbitrate(query.clone()));
        let Returned::Arbitrated(verdict) = outcome else {
            return (status, Verdict::default());
        };
        (status, verdict)
    }

    pub(crate) fn sleep(&mut self, call: &mut CallContext<'_>) {
        // A dead process needs no sleep, and its death is reported already.
        if !self.is_dead() {
            self.invoke(call, Function::Sleep);
        }
    }

    pub(crate) fn draw(&mut self, call: &mut CallContext<'_>) -> (i32, Result<List, String>) {
        let (status, outcome) = self.invoke(call, Function::Draw);
        let Returned::Drawn(Bytes(list)) = outcome else {
            return (status, Err(String::from("its process has drawn nothing")));
        };
        let list = jde_panel::decode::<Result<List, String>>(&list);
        let list = list.unwrap_or_else(|error| Err(error.to_string()));
        let checked = list.and_then(|list| {
            let validity = jde_panel::check(&list);
            validity.map(|()| list).map_err(|error| error.to_string())
        });
        (status, checked)
    }

    pub(crate) fn touch(&mut self, call: &mut CallContext<'_>, by: &str, gesture: &Gesture) -> i32 {
        let touch = Function::Touch {
            by: by.to_owned(),
            gesture: gesture.clone(),
        };
        self.invoke(call, touch).0
    }

    pub(crate) fn save(&mut self, call: &mut CallContext<'_>) -> (i32, Result<Vec<u8>, String>) {
        let (status, outcome) = self.invoke(call, Function::Save);
        let Returned::Saved(memory) = outcome else {
            return (status, Err(String::from("its process has saved nothing")));
        };
        let memory = memory.and_then(|Bytes(memory)| match memory.len() as u64 <= raw::STATE_MOST {
            true => Ok(memory),
            false => Err(String::from("it saves more than is kept")),
        });
        (status, memory)
    }

    pub(crate) fn restore(&mut self, call: &mut CallContext<'_>, memory: &SavedMemory) -> i32 {
        let restore = Function::Restore {
            version: memory.version,
            memory: Bytes(memory.bytes.clone()),
        };
        self.invoke(call, restore).0
    }

    /// Ends the instance and its child.
    pub(crate) fn destroy(mut self, engine: &Arc<Engine>, number: SchemaId) {
        let meter = &engine.metrics[number];
        meter.begin_call(engine.clock.now());
        self.process.expect_exit();
        if self.process.begin_call().is_ok() && self.wire.send(&ToChild::Destroy).is_ok() {
            // Receives the reply to the end. A child that sends none is ended as well.
            drop(self.wire.receive::<FromChild<'_>>());
        }
        self.terminate(engine, number);
        meter.end_call();
    }

    /// Whether the child is dead.
    pub(crate) fn is_dead(&self) -> bool {
        self.process.is_dead()
    }

    /// Whether the rules must be informed of a failed call. A death returns true only once.
    pub(crate) fn claim_failure_report(&self) -> bool {
        !self.is_dead() || self.process.claim_death_report()
    }

    fn start(call: &mut CallContext<'_>, config: &ProcessConfig) -> Result<Self, Option<String>> {
        let engine = call.engine;
        let number = call.number;
        let name = engine.name(number);
        let failed = |what: &str, error: &dyn std::fmt::Display| Some(format!("{what}: {error}"));
        let (ports, files) =
            describe_ports(call).map_err(|error| failed("its memory cannot be shared", &error))?;
        let weak = Arc::downgrade(engine);
        let died = move |process: &Arc<Process>, why| {
            // The death of a previous build, which sleeps until the end of the trial, matters only at its next
            // call.
            if let Some(engine) = weak.upgrade()
                && engine.processes.is_current(number, process)
                && process.claim_death_report()
            {
                engine.report_death(number, why);
            }
        };
        let (process, stream) = Process::start(config, name, died)
            .map_err(|error| failed("its process cannot be started", &error))?;
        // From now on the thread that waits for a reply reports a death.
        let entered = process.begin_call();
        engine.processes.mark_called(number, &process);
        let sent = send_files(&stream, &files);
        let mut instance = Self {
            process,
            wire: Wire::new(stream),
            early: EarlyPorts::new(ports.len()),
            debugged: config.debugged,
        };
        let launch = Launch {
            code: TypeLocation {
                plugin: call.build.plugin.location(),
                number: call.build.number,
            },
            name: name.to_owned(),
            application: engine.id,
            seed: engine.seed_of(number),
            real_time: engine.clock.has_wall_clock_speed(),
            ports,
            listed: engine.application.instances[number].listed.clone(),
            limits: config.limits,
            authority: engine.authority.is_some().then_some(number.index()),
        };
        if !engine.clock.is_real() {
            drop(instance.wire.set_timeout(Some(LOCKSTEP_TIMEOUT)));
        }
        let reply = match (entered, sent) {
            (Ok(()), Ok(())) => instance.try_invoke(call, Function::Start(Box::new(launch))),
            (Err(cause), _) => Err(cause),
            (_, Err(error)) => Err(instance.process.fail_call(&error.to_string())),
        };
        let refused = match reply {
            Ok((raw::OK, outcome)) => {
                if let Returned::Started(unset_limits) = outcome {
                    engine.warn_unset_limits(number, &unset_limits);
                }
                return Ok(instance);
            }
            Ok(_) => call.failure.take(),
            Err(cause) => Some(cause),
        };
        instance.terminate(call.engine, number);
        Err(refused)
    }

    fn terminate(&mut self, engine: &Engine, number: SchemaId) {
        self.process.expect_exit();
        self.wire.close();
        self.process.reap();
        engine.processes.remove(number, &self.process);
    }

    /// One call: its status and what the function returned. A death is returned as a failure; the caller handles it.
    fn invoke(&mut self, call: &mut CallContext<'_>, function: Function) -> (i32, Returned) {
        self.try_invoke(call, function).unwrap_or_else(|cause| {
            call.failure = Some(cause);
            (raw::FAILED, Returned::Nothing)
        })
    }

    /// Sends a call and replies to its requests until it is done.
    ///
    /// # Errors
    /// Why the child is dead.
    fn try_invoke(
        &mut self,
        call: &mut CallContext<'_>,
        function: Function,
    ) -> Result<(i32, Returned), String> {
        self.process.begin_call()?;
        call.engine.processes.mark_called(call.number, &self.process);
        let message = Call {
            now: call.engine.clock.now(),
            machine: machine_time(),
            speed: call.engine.clock.speed(),
            release: call.releases(),
            changes: match (call.is_read_only(), call.may_do_all()) {
                (true, _) => Changes::Nothing,
                (false, false) => Changes::Answered,
                (false, true) => Changes::All,
            },
            function,
        };
        match self.exchange(call, message) {
            Ok(done) => {
                self.process.end_call()?;
                Ok((done.status, done.outcome))
            }
            Err(why) => Err(self.process.fail_call(&why)),
        }
    }

    fn exchange(&mut self, call: &mut CallContext<'_>, message: Call) -> Result<Done, String> {
        let kind = discriminant(&message.function);
        self.early.queue(call, kind, &mut self.wire);
        let done = self.wire.send(&ToChild::Call(message)).map_err(stream_error);
        let done = done.and_then(|()| self.serve_until_done(call, kind));
        let read = done.as_ref().map_or(0, |done| done.read_early);
        if !self.early.settle(call, kind, read) {
            return Err(String::from("its process read an input that it was not sent"));
        }
        done
    }

    /// Carries out and answers what the plugin requests until its call is done.
    fn serve_until_done(&mut self, call: &mut CallContext<'_>, during: CallKind) -> Result<Done, String> {
        let mut terminal = None;
        let impossible = |what| Err(format!("its process sent an invalid request: {what}"));
        loop {
            let reply = match self.wire.receive().map_err(stream_error)? {
                FromChild::Done(done) => {
                    forward_output(&self.process, call);
                    if let Some(time) = done.first_time {
                        call.first_time.get_or_insert(time);
                    }
                    return Ok(done);
                }
                FromChild::Log { level, text } => {
                    forward_output(&self.process, call);
                    call.log(level, text);
                    continue;
                }
                FromChild::Fail(reason) => {
                    call.failure = Some(reason.to_owned());
                    continue;
                }
                FromChild::Read { port } => {
                    self.early.reply(call, during, port, &mut self.wire);
                    self.wire.flush().map_err(stream_error)?;
                    continue;
                }
                FromChild::Loan { port } => {
                    let variable = call.variable(port).map(|(variable, _)| variable);
                    Reply::Loan(early::loan(call, port, variable))
                }
                FromChild::Publish {
                    port,
                    time,
                    value,
                    unanswered,
                } => {
                    let Some(status) = publish(call, port, time, value) else {
                        return impossible("Publish");
                    };
                    if value.is_none() {
                        self.early.record_write(during, port);
                    }
                    if unanswered {
                        continue;
                    }
                    Reply::Status(status)
                }
                FromChild::Retract { port, unanswered } => {
                    let status = call.retract(port);
                    if unanswered {
                        continue;
                    }
                    Reply::Status(status)
                }
                FromChild::Wake { child } => Reply::Status(call.wake(child)),
                FromChild::PutToSleep { child } => Reply::Status(call.sleep(child)),
                FromChild::Child { child } => Reply::Child(call.child(child)),
                FromChild::SetPolicy {
                    child,
                    policy,
                    dwell_ns,
                    hysteresis,
                } => Reply::Status(call.set_policy(child, policy, dwell_ns, hysteresis)),
                FromChild::Hold(held) => {
                    if !self.debugged {
                        return impossible("Hold");
                    }
                    if terminal.is_some() != held {
                        terminal = self.hold(call, held);
                    }
                    Reply::Status(raw::OK)
                }
            };
            self.wire.send(&ToChild::Reply(reply)).map_err(stream_error)?;
        }
    }

    /// Lets a debugger hold the call, at a terminal of its own, or go on. In lockstep time stands still meanwhile.
    fn hold(&self, call: &CallContext<'_>, held: bool) -> Option<HeldTerminal> {
        let (engine, meter) = (call.engine, &call.engine.metrics[call.number]);
        let timeout = (!held && !engine.clock.is_real()).then_some(LOCKSTEP_TIMEOUT);
        drop(self.wire.set_timeout(timeout));
        if !held {
            meter.begin_call(engine.clock.now());
        } else {
            meter.hold_call();
        }
        if engine.clock.is_real() {
            engine.report_debugged(call.number, held);
        }
        held.then(HeldTerminal::wait)
    }
}

fn checked((status, outcome): (i32, Returned)) -> (i32, bool, f64) {
    let Returned::Checked { ready, urgency } = outcome else {
        return (status, false, 0.0);
    };
    (status, ready, urgency)
}

/// Publishes a loan, or the value that was sent. Returns the status; `None` if the value has another size.
fn publish(call: &mut CallContext<'_>, port: u32, time: u64, value: Option<Bytes<&[u8]>>) -> Option<i32> {
    if let Some(Bytes(value)) = value {
        let fits = call.lend(port, |buffer| {
            let fits = buffer.len() == value.len();
            if fits {
                buffer.copy_from_slice(value);
            }
            fits
        });
        match fits {
            Ok(true) => {}
            Ok(false) => return None,
            Err(status) => return Some(status),
        }
    }
    Some(call.publish(port, time))
}

/// Logs what a process has printed in this call. In real time its own thread does, and no turn waits for it.
fn forward_output(process: &Process, call: &CallContext<'_>) {
    if !call.engine.clock.is_real() {
        process.forward_output();
    }
}

/// Returns why a child is killed after its stream broke, unless its own death was the cause.
fn stream_error(error: std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut => {
            format!("its process has not returned from a call for {LOCKSTEP_TIMEOUT:?}")
        }
        std::io::ErrorKind::InvalidData => String::from("its process sent an invalid message"),
        _ => format!("its process closed the stream to its host ({error})"),
    }
}
