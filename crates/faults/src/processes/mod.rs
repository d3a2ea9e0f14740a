//! Runs a case in processes of their own. The real executable runs the demonstration with a robot that this
//! process serves by the code of `jde sim --p2os`. So the robot's ground truth stays visible whatever happens
//! to the other process.

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
use crate::case::{Case, Clock};
use crate::plan::{Act, Fault, Kind, TargetKind};
use crate::rng::Rng;
use crate::run::{Injected, Leftovers, Report, is_machine_loaded, wait_within};
use host::{Environment, HostProcess};
use proxy::TcpProxy;
use robot::RobotServer;

/// Longest time until the robot moves, at the start and after a fault.
const MOVES: Duration = Duration::from_secs(30);
/// Least speed that counts as driving, m/s.
const DRIVEN: f64 = 0.1;
/// Time until a robot without messages brakes, s: the watchdog of a Pioneer (docs/safety.md).
const WATCHDOG: f64 = 2.0;
/// Time until it brakes when the connection ends, s.
const AT_ONCE: f64 = 0.1;
/// Deceleration, m/s².
const BRAKE: f64 = 0.3;
/// Additional time under load, s.
const SLACK: f64 = 0.5;
/// How long a stopped robot must stay so, s.
const STAYS: f64 = 1.0;
/// How long clients are hostile.
const HOSTILE: Duration = Duration::from_millis(2500);
/// How long the machine's load is measured first; under too much load, periods are not judged.
const LOOKS: Duration = Duration::from_millis(500);
/// Least share of their turns that schemas must keep throughout.
const KEEPS: f64 = 0.9;
/// Longest time for a process to end on request.
const ENDS: Duration = Duration::from_secs(15);

/// Runs a case with one fault.
///
/// # Errors
/// The case could not run, which is no verdict.
pub(crate) fn run(campaign: &Campaign, case: Case, stop: &AtomicBool) -> Result<Report> {
    let kinds = campaign.kinds.iter().filter(|kind| kind.fits(Clock::Outside));
    let kinds: Vec<Kind> = kinds.copied().collect();
    // The kinds take turns, so that a short campaign includes all of them.
    let kind = kinds[case.number as usize % kinds.len()];
    let mut chance = Rng::new(campaign.seed, &format!("plan {case}"));
    let wait = Duration::from_millis(chance.between(0, 1500));
    let robot = RobotServer::serve(&campaign.root, campaign.seed ^ case.number)?;
    let cable = (kind == Kind::LineCut)
        .then(|| TcpProxy::to(&robot.address))
        .transpose()?;
    let address = cable.as_ref().map_or(&robot.address, |cable| &cable.address);
    let mut host = HostProcess::start(campaign, address, Environment::of(kind))?;
    let mut broken = Vec::new();
    let begun = Instant::now();
    if !wait_within(MOVES, || robot.speed() >= DRIVEN || stop.load(Ordering::Relaxed)) {
        bail!(
            "{case}: the robot has not moved within {MOVES:?}; {}",
            host.output()
        );
    }
    std::thread::sleep(wait);
    wait_within(MOVES, || robot.speed() >= DRIVEN || stop.load(Ordering::Relaxed));
    let at = begun.elapsed();
    let struck = !stop.load(Ordering::Relaxed);
    if struck {
        match kind {
            Kind::HostKilled => {
                host.signal(Signal::KILL)?;
                check_standstill(&robot, AT_ONCE, "the host was killed", &mut broken);
            }
            Kind::HostStopped => {
                host.signal(Signal::STOP)?;
                check_standstill(&robot, WATCHDOG, "the host stood still", &mut broken);
                host.signal(Signal::CONT)?;
                if !wait_within(MOVES, || robot.speed() >= DRIVEN) {
                    broken.push("the host goes on, and its robot has not moved again".to_owned());
                }
            }
            Kind::HostCrashed => {
                host.jde(&["set", "drifter.place", "check"])?;
                // The host dies of this, possibly before it answers.
                let _ = host.jde(&["set", "drifter.trouble", "segfault"]);
                check_standstill(
                    &robot,
                    AT_ONCE,
                    "a schema crashed in the host's process",
                    &mut broken,
                );
                if !wait_within(ENDS, || !host.is_running()) {
                    broken.push("a wild pointer in the host's process did not end it".to_owned());
                }
            }
            Kind::LineCut => {
                cable.as_ref().context("there is a cable")?.cut();
                check_standstill(&robot, WATCHDOG, "the line was cut", &mut broken);
            }
            Kind::Client => hostile(&mut host, &robot, &mut chance, &mut broken)?,
            Kind::Unread => unread(&mut host, &robot, &mut broken)?,
            Kind::TerminalLost => {
                host.hang_up();
                check_standstill(&robot, AT_ONCE, "the terminal was lost", &mut broken);
                if !wait_within(ENDS, || !host.is_running()) {
                    broken.push("the host goes on without its terminal".to_owned());
                }
            }
            Kind::DiskFull => spoilt(&mut host, &robot, "No space left", &mut broken)?,
            Kind::DiskFails => spoilt(&mut host, &robot, "Input/output error", &mut broken)?,
            Kind::Panic
            | Kind::Error
            | Kind::Hang
            | Kind::Dawdle
            | Kind::Slow
            | Kind::Silence
            | Kind::Nan
            | Kind::Beyond
            | Kind::Flood
            | Kind::Trespass
            | Kind::Chatter
            | Kind::Meddle
            | Kind::Crash
            | Kind::Kill
            | Kind::Freeze
            | Kind::Reload
            | Kind::Operator
            | Kind::StopAll
            | Kind::Contest
            | Kind::AmidReload => unreachable!("faults of schemas are none of whole processes: see `fits`"),
        }
    }
    end(&mut host, kind, &mut broken);
    broken.extend(robot.stop());
    let fault = Fault {
        at: at.as_nanos().try_into().unwrap_or(u64::MAX),
        duration: 0,
        kind,
        target: TargetKind::Motor,
        choice: 0,
        any: true,
        stays: false,
        act: Act::SetTrouble {
            trouble: kind.name(),
            place: "its process",
        },
    };
    Ok(Report {
        case,
        faults: vec![Injected {
            fault,
            target: None,
            took_effect: struck,
        }],
        violations: broken,
        min_turn_share: None,
        rhythm: None,
        leftovers: Leftovers::default(),
    })
}

/// Checks that the robot stops within the promised time and stays so, both in the time of its world.
fn check_standstill(robot: &RobotServer, promised: f64, what: &str, broken: &mut Vec<String>) {
    let since = robot.time();
    // Until it brakes it may still accelerate by the last command.
    let mut fastest = robot.speed();
    wait_within(MOVES, || {
        fastest = fastest.max(robot.speed());
        robot.is_standing() || robot.time() > since + promised + fastest / BRAKE + SLACK
    });
    if !robot.is_standing() {
        broken.push(format!(
            "motion: {what}, its robot drove at {fastest:.2} m/s at most, and {:.1} s later the robot still moves at {:.2} m/s",
            robot.time() - since,
            robot.speed()
        ));
        return;
    }
    let stood = robot.time();
    wait_within(MOVES, || !robot.is_standing() || robot.time() > stood + STAYS);
    if !robot.is_standing() {
        broken.push(format!("motion: {what}, the robot stood, and moves again"));
    }
}

/// Clients send endless requests and nonsense, and are killed amid them. Schemas must not be affected.
fn hostile(
    host: &mut HostProcess,
    robot: &RobotServer,
    chance: &mut Rng,
    broken: &mut Vec<String>,
) -> Result<()> {
    let full = is_machine_loaded(LOOKS);
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
        .map(|words| host.client(words, Stdio::null))
        .collect::<Result<_>>()?;
    let until = Instant::now() + HOSTILE;
    while Instant::now() < until {
        match chance.between(0, 3) {
            0 => send_garbage(host, chance),
            1 => {
                let victim = chance.between(0, clients.len() as u64 - 1) as usize;
                // It may have ended by itself: `top` does so without a terminal.
                let _ = clients[victim].kill();
                let _ = clients[victim].wait();
                clients[victim] = host.client(chance.pick(&all), Stdio::null)?;
            }
            2 => drop(host.jde(&[
                "set",
                "goon.fast",
                chance.pick(&["0.3 m/s", "0.4 m/s", "nan", "1e99"]),
            ])),
            _ => drop(host.jde(&["ps", "--json"])),
        }
    }
    let held: Vec<Child> = std::mem::take(&mut clients);
    for mut client in held {
        let _ = client.kill();
        let _ = client.wait();
    }
    if !full {
        have_had_turns(host, &before, since, "hostile clients", broken)?;
    }
    check_continues(host, robot, "hostile clients", broken);
    Ok(())
}

/// No process reads the output of the host and its clients. Schemas must not be affected, and an order to
/// stop must succeed.
fn unread(host: &mut HostProcess, robot: &RobotServer, broken: &mut Vec<String>) -> Result<()> {
    let full = is_machine_loaded(LOOKS);
    let before = host.turns()?;
    let since = Instant::now();
    let mut clients = [&["watch", "pioneer.laser"][..], &["events"]]
        .iter()
        .map(|words| host.client(words, Stdio::piped))
        .collect::<Result<Vec<Child>>>()?;
    std::thread::sleep(HOSTILE);
    if !full {
        have_had_turns(host, &before, since, "words that nobody reads", broken)?;
    }
    match host.jde(&["stop", "--all"]) {
        Ok(_) => check_standstill(robot, AT_ONCE, "everything was stopped", broken),
        Err(error) => broken.push(format!("while nobody reads, nothing can be stopped: {error:#}")),
    }
    if let Err(error) = host.jde(&["release", "--all"]) {
        broken.push(format!("while nobody reads, nothing can be let go on: {error:#}"));
    }
    for client in &mut clients {
        let process = Pid::from_raw(client.id().cast_signed()).context("it has a number")?;
        // It may have ended by itself.
        let _ = kill_process(process, Signal::TERM);
        if !wait_within(ENDS, || !matches!(client.try_wait(), Ok(None))) {
            broken.push("a client that nobody reads has not ended when it was asked to".to_owned());
            drop((client.kill(), client.wait()));
        }
    }
    check_continues(host, robot, "words that nobody read", broken);
    Ok(())
}

/// The disk of the recording fails. The host must report it, and schemas must not be affected.
fn spoilt(host: &mut HostProcess, robot: &RobotServer, said: &str, broken: &mut Vec<String>) -> Result<()> {
    let full = is_machine_loaded(LOOKS);
    if !wait_within(MOVES, || host.has_logged(said)) {
        broken.push(format!(
            "the recording's disk is spoilt, and nothing is said of `{said}`"
        ));
    }
    let before = host.turns()?;
    let since = Instant::now();
    std::thread::sleep(HOSTILE);
    if !full {
        have_had_turns(host, &before, since, "a spoilt disk", broken)?;
    }
    check_continues(host, robot, "a spoilt disk", broken);
    Ok(())
}

/// Checks that schemas that iterate all the time have had their turns since.
fn have_had_turns(
    host: &HostProcess,
    before: &BTreeMap<String, (u64, u64)>,
    since: Instant,
    of: &str,
    broken: &mut Vec<String>,
) -> Result<()> {
    let after = host.turns()?;
    let seconds = since.elapsed().as_secs_f64();
    for (name, (had, period)) in &after {
        let before = before.get(name).map_or(0, |(had, _)| *had);
        let owed = seconds * 1e9 / *period as f64;
        if ((had - before) as f64) < owed * KEEPS {
            broken.push(format!(
                "R11: `{name}` had {} turns in {seconds:.1} s of {of}, of {owed:.0}",
                had - before
            ));
        }
    }
    Ok(())
}

/// Checks that the host runs and its robot drives.
fn check_continues(host: &mut HostProcess, robot: &RobotServer, after: &str, broken: &mut Vec<String>) {
    if !host.is_running() {
        broken.push(format!("{after} ended the host"));
    } else if !wait_within(MOVES, || robot.speed() >= DRIVEN) {
        broken.push(format!("after {after} the robot has not moved again"));
    }
}

/// Sends random bytes to every socket in the folder of the link.
fn send_garbage(host: &HostProcess, chance: &mut Rng) {
    for socket in host.sockets() {
        if let Ok(mut stream) = UnixStream::connect(&socket) {
            let bytes: Vec<u8> = (0..chance.between(1, 4096))
                .map(|_| chance.next_u64() as u8)
                .collect();
            // The link may close the connection before all bytes are sent.
            let _ = stream.write_all(&bytes);
        }
    }
}

/// Ends the host in order, if it still runs.
fn end(host: &mut HostProcess, kind: Kind, broken: &mut Vec<String>) {
    if matches!(kind, Kind::HostKilled | Kind::HostCrashed | Kind::TerminalLost) {
        host.reap();
        return;
    }
    if host.signal(Signal::TERM).is_err() || !wait_within(ENDS, || !host.is_running()) {
        broken.push(format!(
            "the host has not ended within {ENDS:?} of being asked to"
        ));
        host.reap();
    }
}

/// A file for the output of a process.
fn log_file(folder: &std::path::Path, name: &str) -> Result<File> {
    File::create(folder.join(name)).with_context(|| format!("cannot make {name}"))
}
