//! The host's side of an instance in its own process: calls its functions, and replies to the plugin's
//! requests through the [`CallContext`].

use std::sync::Arc;
use std::time::Duration;

use jde_abi::raw;
use jde_isolation::launch::{Launch, send_files};
use jde_isolation::process::Process;
use jde_isolation::wire::{ANSWERED, CHANGES_NOTHING, Frame, FrameKind, IN_PLACE, READY, UNANSWERED, Wire};
use jde_isolation::{HeldTerminal, ProcessConfig, TypeLocation, machine_time};
use jde_loader::instance::{ArbitrationQuery, SavedMemory, Verdict};
use jde_panel::{Gesture, List};

use super::CallContext;
use super::early::{self, EarlyPorts};
use super::shared_ports::describe_ports;
use crate::engine::Engine;

/// Values up to this size are sent with the message that requests them; larger ones are mapped. One page:
/// beyond it, copying costs more than the message.
pub(crate) const MAX_INLINE_BYTES: usize = 4096;

/// How long a call may take in lockstep, where no supervisor runs: no virtual time passes, and a child can be
/// killed.
const LOCKSTEP_TIMEOUT: Duration = Duration::from_secs(10);

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
        let started = Self::start(call, config).and_then(|mut instance| {
            match instance.try_invoke(call, Frame::new(FrameKind::Create)) {
                Ok(result) if result.status == raw::OK => Ok(instance),
                Ok(result) => {
                    instance.terminate(call.engine, call.number);
                    Err(Some(String::from_utf8_lossy(&result.bytes).into_owned()))
                }
                Err(cause) => {
                    instance.terminate(call.engine, call.number);
                    Err(Some(cause))
                }
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
        self.invoke(call, Frame::new(FrameKind::Awake)).status
    }

    pub(crate) fn check(&mut self, call: &mut CallContext<'_>) -> (i32, bool, f64) {
        check_result(&self.invoke(call, Frame::new(FrameKind::Check)))
    }

    pub(crate) fn iterate(&mut self, call: &mut CallContext<'_>) -> i32 {
        self.invoke(call, Frame::new(FrameKind::Iterate)).status
    }

    /// Checks, and iterates if the precondition is true. The status is that of the iteration if it is.
    pub(crate) fn check_and_iterate(&mut self, call: &mut CallContext<'_>) -> (i32, bool, f64) {
        check_result(&self.invoke(call, Frame::new(FrameKind::CheckAndIterate)))
    }

    pub(crate) fn arbitrate(
        &mut self,
        call: &mut CallContext<'_>,
        query: &ArbitrationQuery,
    ) -> (i32, Verdict) {
        let bytes = jde_panel::encode(query);
        let result = self.invoke(
            call,
            Frame {
                bytes,
                ..Frame::new(FrameKind::Arbitrate)
            },
        );
        (
            result.status,
            jde_panel::decode(&result.bytes).unwrap_or_default(),
        )
    }

    pub(crate) fn sleep(&mut self, call: &mut CallContext<'_>) {
        // A dead process needs no sleep, and its death is reported already.
        if !self.is_dead() {
            self.invoke(call, Frame::new(FrameKind::Sleep));
        }
    }

    pub(crate) fn draw(&mut self, call: &mut CallContext<'_>) -> (i32, Result<List, String>) {
        let result = self.invoke(call, Frame::new(FrameKind::Draw));
        let list = jde_panel::decode::<Result<List, String>>(&result.bytes);
        let list = list.unwrap_or_else(|error| Err(error.to_string()));
        let checked = list.and_then(|list| {
            let validity = jde_panel::check(&list);
            validity.map(|()| list).map_err(|error| error.to_string())
        });
        (result.status, checked)
    }

    pub(crate) fn touch(&mut self, call: &mut CallContext<'_>, by: &str, gesture: &Gesture) -> i32 {
        let bytes = jde_panel::encode(&(by, gesture));
        self.invoke(
            call,
            Frame {
                bytes,
                ..Frame::new(FrameKind::Touch)
            },
        )
        .status
    }

    pub(crate) fn save(&mut self, call: &mut CallContext<'_>) -> (i32, Result<Vec<u8>, String>) {
        let result = self.invoke(call, Frame::new(FrameKind::Save));
        let memory = jde_panel::decode::<Result<Vec<u8>, String>>(&result.bytes);
        let memory = memory.unwrap_or_else(|error| Err(error.to_string()));
        let fits = |memory: &Vec<u8>| memory.len() as u64 <= raw::STATE_MOST;
        let memory = memory.and_then(|memory| match fits(&memory) {
            true => Ok(memory),
            false => Err(String::from("it saves more than is kept")),
        });
        (result.status, memory)
    }

    pub(crate) fn restore(&mut self, call: &mut CallContext<'_>, memory: &SavedMemory) -> i32 {
        let frame = Frame {
            number: memory.version,
            bytes: memory.bytes.clone(),
            ..Frame::new(FrameKind::Restore)
        };
        self.invoke(call, frame).status
    }

    /// Ends the instance and its child.
    pub(crate) fn destroy(mut self, engine: &Arc<Engine>, number: usize) {
        let meter = &engine.metrics[number];
        meter.begin_call(engine.clock.now());
        self.process.expect_exit();
        if self.process.begin_call().is_ok() && self.wire.send(&Frame::new(FrameKind::Destroy)).is_ok() {
            // Receives the reply to the end. A child that sends none is ended as well.
            drop(self.wire.receive());
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
            authority: engine.authority.is_some().then_some(number),
        };
        let frame = Frame {
            bytes: jde_panel::encode(&launch),
            ..Frame::new(FrameKind::Start)
        };
        if !engine.clock.is_real() {
            drop(instance.wire.set_timeout(Some(LOCKSTEP_TIMEOUT)));
        }
        let reply = match (entered, sent) {
            (Ok(()), Ok(())) => instance.try_invoke(call, frame),
            (Err(cause), _) => Err(cause),
            (_, Err(error)) => Err(instance.process.fail_call(&error.to_string())),
        };
        let refused = match reply {
            Ok(result) if result.status == raw::OK => {
                engine.warn_unset_limits(
                    number,
                    &jde_panel::decode::<Vec<String>>(&result.bytes).unwrap_or_default(),
                );
                return Ok(instance);
            }
            Ok(_) => call.failure.take(),
            Err(cause) => Some(cause),
        };
        instance.terminate(call.engine, number);
        Err(refused)
    }

    fn terminate(&mut self, engine: &Engine, number: usize) {
        self.process.expect_exit();
        self.wire.close();
        self.process.reap();
        engine.processes.remove(number, &self.process);
    }

    /// One call. A death is returned as a failure; the caller handles it.
    fn invoke(&mut self, call: &mut CallContext<'_>, frame: Frame) -> Frame {
        match self.try_invoke(call, frame) {
            Ok(result) => result,
            Err(cause) => {
                call.failure = Some(cause);
                Frame {
                    status: raw::FAILED,
                    ..Frame::new(FrameKind::Done)
                }
            }
        }
    }

    /// Sends a call and replies to its requests until it is done.
    ///
    /// # Errors
    /// Why the child is dead.
    fn try_invoke(&mut self, call: &mut CallContext<'_>, mut frame: Frame) -> Result<Frame, String> {
        self.process.begin_call()?;
        call.engine.processes.mark_called(call.number, &self.process);
        if call.is_read_only() {
            frame.flags |= CHANGES_NOTHING;
        } else if !call.may_do_all() {
            frame.flags |= ANSWERED;
        }
        let (now, speed) = (call.engine.clock.now(), call.engine.clock.speed());
        frame.words = [now, machine_time(), speed.to_bits(), call.releases()];
        match self.exchange(call, &frame) {
            Ok(result) => {
                self.process.end_call()?;
                Ok(result)
            }
            Err(why) => Err(self.process.fail_call(&why)),
        }
    }

    fn exchange(&mut self, call: &mut CallContext<'_>, frame: &Frame) -> Result<Frame, String> {
        self.early.queue(call, frame.kind, &mut self.wire);
        let done = self.wire.send(frame).map_err(stream_error);
        let done = done.and_then(|()| self.serve_until_done(call, frame.kind));
        let read = done.as_ref().map_or(0, |done| {
            u128::from(done.words[1]) | u128::from(done.words[2]) << 64
        });
        if !self.early.settle(call, frame.kind, read) {
            return Err(String::from("its process read an input that it was not sent"));
        }
        done
    }

    /// Carries out and answers what the plugin requests until its call is done.
    fn serve_until_done(&mut self, call: &mut CallContext<'_>, during: FrameKind) -> Result<Frame, String> {
        let mut terminal = None;
        loop {
            let request = self.wire.receive().map_err(stream_error)?;
            match request.kind {
                FrameKind::Done => {
                    if let Some(time) = request.words[3].checked_sub(1) {
                        call.first_time.get_or_insert(time);
                    }
                    return Ok(request);
                }
                FrameKind::Hold if self.debugged => {
                    if terminal.is_some() != (request.number != 0) {
                        terminal = self.hold(call, terminal.is_none());
                    }
                    self.wire
                        .send(&Frame::new(FrameKind::Reply))
                        .map_err(stream_error)?;
                }
                FrameKind::Log => call.log(request.number, &String::from_utf8_lossy(&request.bytes)),
                FrameKind::Fail => call.failure = Some(String::from_utf8_lossy(&request.bytes).into_owned()),
                _ => {
                    let reply = reply_to(call, &request).ok_or_else(|| {
                        format!("its process asked what cannot be asked: {:?}", request.kind)
                    })?;
                    match request.kind {
                        FrameKind::Read => self.early.record_request(during, call.releases(), &reply),
                        FrameKind::Publish if request.bytes.is_empty() => {
                            self.early.record_write(during, request.number);
                        }
                        _ => {}
                    }
                    if request.flags & UNANSWERED == 0 {
                        self.wire.send(&reply).map_err(stream_error)?;
                    }
                }
            }
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

fn check_result(done: &Frame) -> (i32, bool, f64) {
    let is_ready = done.flags & READY != 0;
    (done.status, is_ready, f64::from_bits(done.words[0]))
}

/// Returns the host's reply to a request during a call; `None` if that kind is no request.
fn reply_to(call: &mut CallContext<'_>, request: &Frame) -> Option<Frame> {
    let mut reply = Frame::new(FrameKind::Reply);
    let number = request.number;
    reply.number = number;
    match request.kind {
        FrameKind::Read => {
            let variable = call.variable(number);
            let variable = variable.map(|(variable, _)| variable);
            let shown = call.read(number, |view| early::show(&mut reply, view, variable.as_deref()));
            reply.status = shown.map_or_else(|status| status, |()| raw::OK);
        }
        FrameKind::Loan => {
            let variable = call.variable(number);
            let loaned = call.loan(number, |buffer| {
                variable.and_then(|(variable, _)| variable.offset_of(buffer))
            });
            match loaned {
                Err(status) => reply.status = status,
                Ok(Some(place)) => {
                    reply.flags = IN_PLACE;
                    reply.words[2] = place as u64;
                }
                Ok(None) => {}
            }
        }
        FrameKind::Publish => {
            reply.status = raw::OK;
            if !request.bytes.is_empty() {
                let fits = call.loan(number, |buffer| {
                    let fits = buffer.len() == request.bytes.len();
                    if fits {
                        buffer.copy_from_slice(&request.bytes);
                    }
                    fits
                });
                match fits {
                    Ok(true) => {}
                    Ok(false) => return None,
                    Err(status) => reply.status = status,
                }
            }
            if reply.status == raw::OK {
                reply.status = call.publish(number, request.words[0]);
            }
        }
        FrameKind::Retract => reply.status = call.retract(number),
        FrameKind::Wake => reply.status = call.wake(number),
        FrameKind::PutToSleep => reply.status = call.sleep(number),
        FrameKind::Child => match call.child(number) {
            Err(status) => reply.status = status,
            Ok(child) => reply.words = [u64::from(child.state), u64::from(child.faulted), 0, 0],
        },
        FrameKind::SetPolicy => {
            let [policy, dwell, hysteresis, _] = request.words;
            let policy = u32::try_from(policy).ok()?;
            reply.status = call.set_policy(number, policy, dwell, f64::from_bits(hysteresis));
        }
        FrameKind::Start
        | FrameKind::Value
        | FrameKind::Create
        | FrameKind::Awake
        | FrameKind::Check
        | FrameKind::Iterate
        | FrameKind::CheckAndIterate
        | FrameKind::Arbitrate
        | FrameKind::Sleep
        | FrameKind::Draw
        | FrameKind::Touch
        | FrameKind::Save
        | FrameKind::Restore
        | FrameKind::Destroy
        | FrameKind::Reply
        | FrameKind::Log
        | FrameKind::Fail
        | FrameKind::Hold
        | FrameKind::Done => return None,
    }
    Some(reply)
}

/// Returns why a child is killed after its stream broke, unless its own death was the cause.
fn stream_error(error: std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut => {
            format!("its process has not returned from a call for {LOCKSTEP_TIMEOUT:?}")
        }
        std::io::ErrorKind::InvalidData => String::from("its process sent what is no message"),
        _ => format!("its process closed the stream to its host ({error})"),
    }
}
