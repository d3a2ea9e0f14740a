//! The host's side of a child: calls its functions, and answers the plugin's requests through the [`Call`].

use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::time::Duration;

use jde_abi::raw;
use jde_panel::{Gesture, List};
use rustix::time::{ClockId, clock_gettime};

use super::launch::{Launch, PortAbout, send_files};
use super::process::Process;
use super::wire::{CHANGES_NOTHING, Frame, IN_PLACE, Kind, READY, Wire};
use super::{Code, Room};
use crate::build::Way;
use crate::engine::Engine;
use crate::instance::{Call, Question, Remembered, Verdict};

/// Values up to this size are sent with the message that requests them; larger ones are mapped. One page:
/// beyond it, copying costs more than the message.
pub(crate) const MOST_SENT: usize = 4096;

/// How long a call may take in lockstep, where no supervisor runs: no virtual time passes, and a child can be
/// killed.
const LOCKSTEP_PATIENCE: Duration = Duration::from_secs(10);

/// An instance that was created in a child.
pub(crate) struct Apart {
    process: Arc<Process>,
    wire: Wire,
}

impl Apart {
    /// Starts a child and creates the instance there. The reason for a failure is left in the call.
    pub(crate) fn create(call: &mut Call<'_>, room: &Room) -> Option<Self> {
        let made = Self::start(call, room).and_then(|mut apart| {
            match apart.converse(call, Frame::new(Kind::Create)) {
                Ok(done) if done.status == raw::OK => Ok(apart),
                Ok(_) => {
                    apart.end(call.engine, call.number);
                    Err(None)
                }
                Err(cause) => {
                    apart.end(call.engine, call.number);
                    Err(Some(cause))
                }
            }
        });
        match made {
            Ok(apart) => Some(apart),
            Err(cause) => {
                // A reason from the plugin itself takes precedence.
                if call.failure.is_none() {
                    call.failure = cause;
                }
                None
            }
        }
    }

    pub(crate) fn awake(&mut self, call: &mut Call<'_>) -> i32 {
        self.ask(call, Frame::new(Kind::Awake)).status
    }

    pub(crate) fn check(&mut self, call: &mut Call<'_>) -> (i32, bool, f64) {
        let done = self.ask(call, Frame::new(Kind::Check));
        (
            done.status,
            done.flags & READY != 0,
            f64::from_bits(done.words[0]),
        )
    }

    pub(crate) fn iterate(&mut self, call: &mut Call<'_>) -> i32 {
        self.ask(call, Frame::new(Kind::Iterate)).status
    }

    pub(crate) fn arbitrate(&mut self, call: &mut Call<'_>, question: &Question) -> (i32, Verdict) {
        let bytes = jde_panel::encode(question);
        let done = self.ask(
            call,
            Frame {
                bytes,
                ..Frame::new(Kind::Arbitrate)
            },
        );
        (done.status, jde_panel::decode(&done.bytes).unwrap_or_default())
    }

    pub(crate) fn sleep(&mut self, call: &mut Call<'_>) {
        // A dead process needs no sleep, and its death is reported already.
        if !self.is_dead() {
            self.ask(call, Frame::new(Kind::Sleep));
        }
    }

    pub(crate) fn draw(&mut self, call: &mut Call<'_>) -> (i32, Result<List, String>) {
        let done = self.ask(call, Frame::new(Kind::Draw));
        let list = jde_panel::decode::<Result<List, String>>(&done.bytes);
        let list = list.unwrap_or_else(|broken| Err(broken.to_string()));
        let checked = list.and_then(|list| {
            let sound = jde_panel::check(&list);
            sound.map(|()| list).map_err(|broken| broken.to_string())
        });
        (done.status, checked)
    }

    pub(crate) fn touch(&mut self, call: &mut Call<'_>, by: &str, gesture: &Gesture) -> i32 {
        let bytes = jde_panel::encode(&(by, gesture));
        self.ask(
            call,
            Frame {
                bytes,
                ..Frame::new(Kind::Touch)
            },
        )
        .status
    }

    pub(crate) fn save(&mut self, call: &mut Call<'_>) -> (i32, Result<Vec<u8>, String>) {
        let done = self.ask(call, Frame::new(Kind::Save));
        let kept = jde_panel::decode::<Result<Vec<u8>, String>>(&done.bytes);
        let kept = kept.unwrap_or_else(|broken| Err(broken.to_string()));
        let few = |kept: &Vec<u8>| kept.len() as u64 <= raw::STATE_MOST;
        let kept = kept.and_then(|kept| match few(&kept) {
            true => Ok(kept),
            false => Err(String::from("it saves more than is kept")),
        });
        (done.status, kept)
    }

    pub(crate) fn restore(&mut self, call: &mut Call<'_>, remembered: &Remembered) -> i32 {
        let frame = Frame {
            number: remembered.version,
            bytes: remembered.bytes.clone(),
            ..Frame::new(Kind::Restore)
        };
        self.ask(call, frame).status
    }

    /// Ends the instance and its child.
    pub(crate) fn destroy(mut self, engine: &Arc<Engine>, number: usize) {
        let meter = &engine.meters[number];
        meter.enter(engine.clock.now());
        self.process.part();
        if self.process.enter().is_ok() && self.wire.send(&Frame::new(Kind::Destroy)).is_ok() {
            // The answer to the end. A child that sends none is ended as well.
            drop(self.wire.receive());
        }
        self.end(engine, number);
        meter.leave();
    }

    /// Whether the child is dead.
    pub(crate) fn is_dead(&self) -> bool {
        self.process.is_dead()
    }

    /// Whether the rules must be informed of a failed call. A death returns true only once.
    pub(crate) fn is_to_tell(&self) -> bool {
        !self.is_dead() || self.process.is_to_be_told()
    }

    fn start(call: &mut Call<'_>, room: &Room) -> Result<Self, Option<String>> {
        let engine = call.engine;
        let number = call.number;
        let name = engine.name(number);
        let failed = |what: &str, error: &dyn std::fmt::Display| Some(format!("{what}: {error}"));
        let (ports, files) = ports(call).map_err(|error| failed("its memory cannot be shared", &error))?;
        let weak = Arc::downgrade(engine);
        let died = move |process: &Arc<Process>, why| {
            // The death of a process that waits asleep for the end of a trial matters only when it is called.
            if let Some(engine) = weak.upgrade()
                && engine.processes.is_present(number, process)
                && process.is_to_be_told()
            {
                engine.died(number, why);
            }
        };
        let (process, stream) = Process::start(&room.program, name, room.limits, died)
            .map_err(|error| failed("its process cannot be started", &error))?;
        // From here on the thread that waits for an answer reports a death.
        let entered = process.enter();
        engine.processes.called(number, &process);
        let sent = send_files(&stream, &files);
        let mut apart = Self {
            process,
            wire: Wire::new(stream),
        };
        let launch = Launch {
            code: Code {
                plugin: call.build.plugin.code(),
                number: call.build.number,
            },
            name: name.to_owned(),
            application: engine.id,
            seed: engine.seed_of(number),
            real_time: engine.clock.is_everybodys(),
            ports,
            limits: room.limits,
        };
        let frame = Frame {
            bytes: jde_panel::encode(&launch),
            ..Frame::new(Kind::Start)
        };
        if !engine.clock.is_real() {
            drop(apart.wire.set_patience(Some(LOCKSTEP_PATIENCE)));
        }
        let told = match (entered, sent) {
            (Ok(()), Ok(())) => apart.converse(call, frame),
            (Err(cause), _) => Err(cause),
            (_, Err(error)) => Err(apart.process.broke(&error.to_string())),
        };
        let refused = match told {
            Ok(done) if done.status == raw::OK => {
                engine.unlimited(
                    number,
                    &jde_panel::decode::<Vec<String>>(&done.bytes).unwrap_or_default(),
                );
                return Ok(apart);
            }
            Ok(_) => call.failure.take(),
            Err(cause) => Some(cause),
        };
        apart.end(call.engine, number);
        Err(refused)
    }

    fn end(&mut self, engine: &Engine, number: usize) {
        self.process.part();
        self.wire.close();
        self.process.bury();
        engine.processes.gone(number, &self.process);
    }

    /// One call. A death is returned as a failure; the caller handles it.
    fn ask(&mut self, call: &mut Call<'_>, frame: Frame) -> Frame {
        match self.converse(call, frame) {
            Ok(done) => done,
            Err(cause) => {
                call.failure = Some(cause);
                Frame {
                    status: raw::FAILED,
                    ..Frame::new(Kind::Done)
                }
            }
        }
    }

    /// Sends a call and answers its requests until it is done.
    ///
    /// # Errors
    /// Why the child is dead.
    fn converse(&mut self, call: &mut Call<'_>, mut frame: Frame) -> Result<Frame, String> {
        self.process.enter()?;
        call.engine.processes.called(call.number, &self.process);
        if call.changes_nothing() {
            frame.flags |= CHANGES_NOTHING;
        }
        let (now, speed) = (call.engine.clock.now(), call.engine.clock.speed());
        frame.words = [now, machine_time(), speed.to_bits(), call.releases()];
        match self.exchange(call, &frame) {
            Ok(done) => {
                self.process.leave()?;
                Ok(done)
            }
            Err(why) => Err(self.process.broke(&why)),
        }
    }

    fn exchange(&mut self, call: &mut Call<'_>, frame: &Frame) -> Result<Frame, String> {
        self.wire.send(frame).map_err(cut)?;
        loop {
            let asked = self.wire.receive().map_err(cut)?;
            match asked.kind {
                Kind::Done => {
                    if let Some(told) = asked.words[3].checked_sub(1) {
                        call.told.get_or_insert(told);
                    }
                    return Ok(asked);
                }
                Kind::Log => call.log(asked.number, &String::from_utf8_lossy(&asked.bytes)),
                Kind::Fail => call.failure = Some(String::from_utf8_lossy(&asked.bytes).into_owned()),
                _ => {
                    let answer = answer(call, &asked)
                        .ok_or_else(|| format!("its process asked what cannot be asked: {:?}", asked.kind))?;
                    self.wire.send(&answer).map_err(cut)?;
                }
            }
        }
    }
}

/// The host's answer to a request during a call; `None` if that kind is no request.
fn answer(call: &mut Call<'_>, asked: &Frame) -> Option<Frame> {
    let mut answer = Frame::new(Kind::Answer);
    let number = asked.number;
    match asked.kind {
        Kind::Read => {
            let variable = call.variable(number);
            let shown = call.read(number, |view| {
                let sample = view.sample();
                answer.number = sample.writer;
                answer.flags = sample.flags;
                answer.words = [sample.time_ns, sample.sequence, 0, sample.bytes];
                match variable.and_then(|(variable, _)| variable.place_of(view.bytes)) {
                    Some(place) => {
                        answer.flags |= IN_PLACE;
                        answer.words[2] = place as u64;
                    }
                    None => answer.bytes = view.bytes.to_vec(),
                }
            });
            answer.status = shown.map_or_else(|status| status, |()| raw::OK);
        }
        Kind::Loan => {
            let variable = call.variable(number);
            let lent = call.loan(number, |room| {
                variable.and_then(|(variable, _)| variable.place_of(room))
            });
            match lent {
                Err(status) => answer.status = status,
                Ok(Some(place)) => {
                    answer.flags = IN_PLACE;
                    answer.words[2] = place as u64;
                }
                Ok(None) => {}
            }
        }
        Kind::Publish => {
            answer.status = raw::OK;
            if !asked.bytes.is_empty() {
                let fits = call.loan(number, |room| {
                    let fits = room.len() == asked.bytes.len();
                    if fits {
                        room.copy_from_slice(&asked.bytes);
                    }
                    fits
                });
                match fits {
                    Ok(true) => {}
                    Ok(false) => return None,
                    Err(status) => answer.status = status,
                }
            }
            if answer.status == raw::OK {
                answer.status = call.publish(number, asked.words[0]);
            }
        }
        Kind::Retract => answer.status = call.retract(number),
        Kind::Wake => answer.status = call.wake(number),
        Kind::LayDown => answer.status = call.sleep(number),
        Kind::Child => match call.child(number) {
            Err(status) => answer.status = status,
            Ok(child) => answer.words = [u64::from(child.state), u64::from(child.faulted), 0, 0],
        },
        Kind::SetPolicy => {
            let [policy, dwell, hysteresis, _] = asked.words;
            let policy = u32::try_from(policy).ok()?;
            answer.status = call.set_policy(number, policy, dwell, f64::from_bits(hysteresis));
        }
        Kind::Start
        | Kind::Create
        | Kind::Awake
        | Kind::Check
        | Kind::Iterate
        | Kind::Arbitrate
        | Kind::Sleep
        | Kind::Draw
        | Kind::Touch
        | Kind::Save
        | Kind::Restore
        | Kind::Destroy
        | Kind::Answer
        | Kind::Log
        | Kind::Fail
        | Kind::Done => return None,
    }
    Some(answer)
}

/// What a child needs to know of its ports, and the files of their memory.
fn ports(call: &Call<'_>) -> std::io::Result<(Vec<PortAbout>, Vec<OwnedFd>)> {
    let mut files = Vec::new();
    let mut ports = Vec::new();
    for port in 0..call.build.ports() {
        let port = port as u32;
        let Some((variable, writes)) = call.variable(port) else {
            ports.push(match call.build.way(port) {
                Some(Way::Unheard(bytes)) => PortAbout {
                    writes: true,
                    bytes: *bytes,
                    memory: None,
                },
                Some(Way::Bound(_) | Way::Unbound | Way::Fixed { .. }) | None => PortAbout::default(),
            });
            continue;
        };
        let memory = match variable.shared() {
            None => None,
            Some(shared) => {
                files.push(if writes {
                    shared.to_write()
                } else {
                    shared.to_read()
                }?);
                Some(shared.extent())
            }
        };
        ports.push(PortAbout {
            writes,
            bytes: variable.describe().value_type.bytes,
            memory,
        });
    }
    Ok((ports, files))
}

/// The machine's monotonic clock, the same in every process, ns.
pub(super) fn machine_time() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}

/// Why a child is killed after its stream broke, unless its own death was the cause.
fn cut(error: std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut => {
            format!("its process has not returned from a call for {LOCKSTEP_PATIENCE:?}")
        }
        std::io::ErrorKind::InvalidData => String::from("its process sent what is no message"),
        _ => format!("its process closed the stream to its host ({error})"),
    }
}
