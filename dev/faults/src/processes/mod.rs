//! Runs a case in processes of their own. The real executable runs the demonstration with a robot that this
//! process serves by the code of `jde sim --p2os`. Therefore the robot's ground truth stays visible
//! whatever happens to the other process.

mod exhausted;
mod host;
mod proxy;
mod robot;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write as _;
use std::os::unix::net::UnixStream;
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use rustix::process::{Pid, Signal, kill_process};

use crate::campaign::Campaign;
use crate::case::{Case, RunMode, name};
use crate::plan::{Act, Kind, PlannedFault, TargetKind};
use crate::rng::Rng;
use crate::run::{CaseResult, Injected, Leftovers, is_machine_loaded, wait_within};
use host::{Environment, HostProcess};
use proxy::TcpProxy;
use robot::RobotServer;

/// Longest time until the robot moves, at the start and after a fault.
const MOVE_TIMEOUT: Duration = Duration::from_secs(30);
/// Least speed that counts as driving, m/s.
const MIN_DRIVING_SPEED: f64 = 0.1;
/// Time until a robot without messages brakes, s: the watchdog of a Pioneer (docs/safety.md).
const ROBOT_WATCHDOG: f64 = 2.0;
/// Time until it brakes when the connection ends, s.
const DISCONNECT_DELAY: f64 = 0.1;
/// Deceleration, m/s².
const DECELERATION: f64 = 0.3;
/// Additional time under load, s.
const LOAD_SLACK: f64 = 0.5;
/// How long a stopped robot must stay so, s.
const STANDSTILL_TIME: f64 = 1.0;
/// How long clients are hostile.
const ATTACK_TIME: Duration = Duration::from_millis(2500);
/// How long the machine's load is measured first; under too much load, periods are not judged.
const LOAD_MEASURING_TIME: Duration = Duration::from_millis(500);
/// Least share of their turns that schemas must keep throughout.
const MIN_TURN_SHARE: f64 = 0.9;
/// How often the host is stopped for a moment.
const STUTTER_COUNT: usize = 6;
/// Longest time for a process to end on request.
const END_TIMEOUT: Duration = Duration::from_secs(15);

/// Runs a case with one fault.
///
/// # Errors
/// The case could not run, which is no verdict.
pub(crate) fn run(campaign: &Campaign, case: Case, stop: &AtomicBool) -> Result<CaseResult> {
    let kinds = campaign.kinds.iter().filter(|kind| kind.fits(RunMode::Outside));
    let kinds: Vec<Kind> = kinds.copied().collect();
    // The kinds follow each other in order, so that a short campaign includes all of them.
    let kind = kinds[case.number as usize % kinds.len()];
    let mut rng = Rng::new(campaign.seed, &format!("plan {case}"));
    let wait = Duration::from_millis(rng.between(0, 1500));
    let robot = RobotServer::serve(&campaign.root, campaign.seed ^ case.number)?;
    let proxy = (kind == Kind::LineCut)
        .then(|| TcpProxy::to(&robot.address))
        .transpose()?;
    let address = proxy.as_ref().map_or(&robot.address, |proxy| &proxy.address);
    let mut host = HostProcess::start(campaign, address, Environment::of(kind))?;
    let mut violations = Vec::new();
    let begun = Instant::now();
    if !wait_within(MOVE_TIMEOUT, || {
        robot.speed() >= MIN_DRIVING_SPEED || stop.load(Ordering::Relaxed)
    }) {
        bail!(
            "{case}: the robot has not moved within {MOVE_TIMEOUT:?}; {}",
            host.output()
        );
    }
    std::thread::sleep(wait);
    wait_within(MOVE_TIMEOUT, || {
        robot.speed() >= MIN_DRIVING_SPEED || stop.load(Ordering::Relaxed)
    });
    let at = begun.elapsed();
    let injected = !stop.load(Ordering::Relaxed);
    if injected {
        match kind {
            Kind::HostKilled => {
                host.signal(Signal::KILL)?;
                check_standstill(&robot, DISCONNECT_DELAY, "the host was killed", &mut violations);
            }
            Kind::HostStopped => {
                host.signal(Signal::STOP)?;
                check_standstill(&robot, ROBOT_WATCHDOG, "the host was stopped", &mut violations);
                host.signal(Signal::CONT)?;
                if !wait_within(MOVE_TIMEOUT, || robot.speed() >= MIN_DRIVING_SPEED) {
                    violations.push("the host continues, and its robot has not moved again".to_owned());
                }
            }
            Kind::HostStutters => stutter(&mut host, &robot, &mut rng, &mut violations)?,
            Kind::NoDescriptors | Kind::NoThreads | Kind::NoMemory => {
                host.exhaust(kind)?;
                stop_with_nothing_left(&mut host, &robot, &mut violations);
                host.relieve(kind)?;
                if let Err(error) = host.jde(&["release", "--all"]) {
                    violations.push(format!("it has everything again, and does not go on: {error:#}"));
                }
                check_continues(&mut host, &robot, "a stop with nothing left", &mut violations);
            }
            Kind::HostCrashed => {
                host.jde(&["set", "drifter.place", "check"])?;
                // The host dies of this, possibly before it replies.
                let _ = host.jde(&["set", "drifter.trouble", "segfault"]);
                check_standstill(
                    &robot,
                    DISCONNECT_DELAY,
                    "a schema crashed in the host's process",
                    &mut violations,
                );
                if !wait_within(END_TIMEOUT, || !host.is_running()) {
                    violations.push("a wild pointer in the host's process did not end it".to_owned());
                }
            }
            Kind::LineCut => {
                proxy.as_ref().context("there is no proxy")?.cut();
                check_standstill(&robot, ROBOT_WATCHDOG, "the line was cut", &mut violations);
            }
            Kind::Client => attack_with_clients(&mut host, &robot, &mut rng, &mut violations)?,
            Kind::Unread => leave_output_unread(&mut host, &robot, &mut violations)?,
            Kind::TerminalLost => {
                host.hang_up();
                check_standstill(&robot, DISCONNECT_DELAY, "the terminal was lost", &mut violations);
                if !wait_within(END_TIMEOUT, || !host.is_running()) {
                    violations.push("the host continues without its terminal".to_owned());
                }
            }
            Kind::DiskFull => let_disk_fail(&mut host, &robot, "No space left", &mut violations)?,
            Kind::DiskFails => let_disk_fail(&mut host, &robot, "Input/output error", &mut violations)?,
            kind => unreachable!("{kind:?} is a fault of a schema, not of a whole process: see `fits`"),
        }
    }
    end(&mut host, kind, &mut violations);
    violations.extend(robot.stop());
    let fault = PlannedFault {
        at: at.as_nanos().try_into().unwrap_or(u64::MAX),
        duration: 0,
        kind,
        target: TargetKind::Motor,
        choice: 0,
        any: true,
        stays: false,
        act: Act::SetTrouble {
            trouble: name(&kind).into(),
            place: "its process",
        },
    };
    Ok(CaseResult {
        case,
        faults: vec![Injected {
            fault,
            target: None,
            took_effect: injected,
        }],
        violations,
        min_turn_share: None,
        rhythm: None,
        leftovers: Leftovers::default(),
    })
}

/// Checks that the robot stops within `time` and remains at rest, both in the time of its world.
fn check_standstill(robot: &RobotServer, time: f64, event: &str, violations: &mut Vec<String>) {
    let since = robot.time();
    // Until it brakes it may still accelerate by the last command.
    let mut fastest = robot.speed();
    wait_within(MOVE_TIMEOUT, || {
        fastest = fastest.max(robot.speed());
        robot.is_standing() || robot.time() > since + time + fastest / DECELERATION + LOAD_SLACK
    });
    if !robot.is_standing() {
        violations.push(format!(
            "motion: {event}, its robot drove at {fastest:.2} m/s at most, and {:.1} s later the robot still moves at {:.2} m/s",
            robot.time() - since,
            robot.speed()
        ));
        return;
    }
    let stopped = robot.time();
    wait_within(MOVE_TIMEOUT, || {
        !robot.is_standing() || robot.time() > stopped + STANDSTILL_TIME
    });
    if !robot.is_standing() {
        violations.push(format!("motion: {event}, the robot stopped and moves again"));
    }
}

/// Clients send endless and invalid requests, and are killed while they do. Schemas must not be affected.
fn attack_with_clients(
    host: &mut HostProcess,
    robot: &RobotServer,
    rng: &mut Rng,
    violations: &mut Vec<String>,
) -> Result<()> {
    let is_loaded = is_machine_loaded(LOAD_MEASURING_TIME);
    let before = host.turns()?;
    let since = Instant::now();
    let all = [
        &["watch", "pioneer.laser"][..],
        &["events"],
        &["watch", "--plot", "pioneer.odometry.twist.twist.linear.x"],
        &["top"],
    ];
    let mut clients: Vec<Child> = all
        .iter()
        .map(|arguments| host.client(arguments, Stdio::null))
        .collect::<Result<_>>()?;
    let until = Instant::now() + ATTACK_TIME;
    while Instant::now() < until {
        match rng.between(0, 3) {
            0 => send_garbage(host, rng),
            1 => {
                let victim = rng.between(0, clients.len() as u64 - 1) as usize;
                // It may have ended by itself: `top` does so without a terminal.
                let _ = clients[victim].kill();
                let _ = clients[victim].wait();
                clients[victim] = host.client(rng.pick(&all), Stdio::null)?;
            }
            2 => drop(host.jde(&[
                "set",
                "goon.fast",
                rng.pick(&["0.3 m/s", "0.4 m/s", "nan", "1e99"]),
            ])),
            _ => drop(host.jde(&["ps", "--json"])),
        }
    }
    for mut client in clients {
        let _ = client.kill();
        let _ = client.wait();
    }
    if !is_loaded {
        check_turns(host, &before, since, "hostile clients", violations)?;
    }
    check_continues(host, robot, "hostile clients", violations);
    Ok(())
}

/// No process reads the output of the host and its clients. Schemas must not be affected, and a request to
/// stop must succeed.
fn leave_output_unread(
    host: &mut HostProcess,
    robot: &RobotServer,
    violations: &mut Vec<String>,
) -> Result<()> {
    let is_loaded = is_machine_loaded(LOAD_MEASURING_TIME);
    let before = host.turns()?;
    let since = Instant::now();
    let mut clients = [&["watch", "pioneer.laser"][..], &["events"]]
        .iter()
        .map(|arguments| host.client(arguments, Stdio::piped))
        .collect::<Result<Vec<Child>>>()?;
    std::thread::sleep(ATTACK_TIME);
    if !is_loaded {
        check_turns(host, &before, since, "unread output", violations)?;
    }
    match host.jde(&["stop", "--all"]) {
        Ok(_) => check_standstill(robot, DISCONNECT_DELAY, "everything was stopped", violations),
        Err(error) => violations.push(format!("with unread output, nothing can be stopped: {error:#}")),
    }
    if let Err(error) = host.jde(&["release", "--all"]) {
        violations.push(format!("with unread output, nothing can be released: {error:#}"));
    }
    for client in &mut clients {
        let process = Pid::from_raw(client.id().cast_signed()).context("the client has no process id")?;
        // It may have ended by itself.
        let _ = kill_process(process, Signal::TERM);
        if !wait_within(END_TIMEOUT, || !matches!(client.try_wait(), Ok(None))) {
            violations.push("a client with unread output has not ended on SIGTERM".to_owned());
            drop((client.kill(), client.wait()));
        }
    }
    check_continues(host, robot, "unread output", violations);
    Ok(())
}

/// The host is stopped for random times. None of its schemas is to blame.
fn stutter(
    host: &mut HostProcess,
    robot: &RobotServer,
    rng: &mut Rng,
    violations: &mut Vec<String>,
) -> Result<()> {
    for _ in 0..STUTTER_COUNT {
        host.signal(Signal::STOP)?;
        std::thread::sleep(Duration::from_millis(rng.between(20, 1500)));
        host.signal(Signal::CONT)?;
        std::thread::sleep(Duration::from_millis(rng.between(20, 500)));
    }
    for name in host.faulty()? {
        violations.push(format!("`{name}` faulted because the host was stopped"));
    }
    check_continues(host, robot, "stops of the host", violations);
    Ok(())
}

/// The host gets nothing more of a resource. The robot drives on, and everything can be stopped.
fn stop_with_nothing_left(host: &mut HostProcess, robot: &RobotServer, violations: &mut Vec<String>) {
    std::thread::sleep(ATTACK_TIME);
    check_continues(host, robot, "the end of a resource", violations);
    match host.jde(&["stop", "--all"]) {
        Ok(_) => check_standstill(robot, DISCONNECT_DELAY, "everything was stopped", violations),
        Err(error) => violations.push(format!("with nothing left, nothing can be stopped: {error:#}")),
    }
}

/// The disk of the recording fails. The host must report it, and schemas must not be affected.
fn let_disk_fail(
    host: &mut HostProcess,
    robot: &RobotServer,
    message: &str,
    violations: &mut Vec<String>,
) -> Result<()> {
    let is_loaded = is_machine_loaded(LOAD_MEASURING_TIME);
    if !wait_within(MOVE_TIMEOUT, || host.has_logged(message)) {
        violations.push(format!(
            "the disk of the recording failed, and the log does not contain `{message}`"
        ));
    }
    let before = host.turns()?;
    let since = Instant::now();
    std::thread::sleep(ATTACK_TIME);
    if !is_loaded {
        check_turns(host, &before, since, "a failed disk", violations)?;
    }
    check_continues(host, robot, "a failed disk", violations);
    Ok(())
}

/// Checks that schemas that iterate all the time have had their turns since.
fn check_turns(
    host: &HostProcess,
    before: &BTreeMap<String, (u64, u64)>,
    since: Instant,
    cause: &str,
    violations: &mut Vec<String>,
) -> Result<()> {
    let after = host.turns()?;
    let seconds = since.elapsed().as_secs_f64();
    for (name, (had, period)) in &after {
        let before = before.get(name).map_or(0, |(had, _)| *had);
        let expected = seconds * 1e9 / *period as f64;
        if ((had - before) as f64) < expected * MIN_TURN_SHARE {
            violations.push(format!(
                "R11: `{name}` had {} turns in {seconds:.1} s of {cause}, of {expected:.0}",
                had - before
            ));
        }
    }
    Ok(())
}

/// Checks that the host still runs and its robot drives.
fn check_continues(host: &mut HostProcess, robot: &RobotServer, after: &str, violations: &mut Vec<String>) {
    if !host.is_running() {
        violations.push(format!("{after} ended the host"));
    } else if !wait_within(MOVE_TIMEOUT, || robot.speed() >= MIN_DRIVING_SPEED) {
        violations.push(format!("after {after} the robot has not moved again"));
    }
}

/// Sends random bytes to every socket in the folder of the link.
fn send_garbage(host: &HostProcess, rng: &mut Rng) {
    for socket in host.sockets() {
        if let Ok(mut stream) = UnixStream::connect(&socket) {
            let bytes: Vec<u8> = (0..rng.between(1, 4096)).map(|_| rng.next_u64() as u8).collect();
            // The link may close the connection before all bytes are sent.
            let _ = stream.write_all(&bytes);
        }
    }
}

/// Ends the host in order, if it still runs.
fn end(host: &mut HostProcess, kind: Kind, violations: &mut Vec<String>) {
    if matches!(kind, Kind::HostKilled | Kind::HostCrashed | Kind::TerminalLost) {
        host.reap();
        return;
    }
    if host.signal(Signal::TERM).is_err() || !wait_within(END_TIMEOUT, || !host.is_running()) {
        violations.push(format!(
            "the host has not ended within {END_TIMEOUT:?} of SIGTERM"
        ));
        host.reap();
    }
}

/// A file for the output of a process.
fn log_file(folder: &std::path::Path, name: &str) -> Result<File> {
    File::create(folder.join(name)).with_context(|| format!("cannot create {name}"))
}
