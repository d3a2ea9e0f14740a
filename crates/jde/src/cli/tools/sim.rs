//! `jde sim`: a simulated world whose robots speak the Pioneer protocol to any client.

use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::{ArgGroup, Args, ValueHint};
use jde_core::Nanos;
use jde_p2os::Model;
use jde_p2os_server::{EndpointAddress, Options, RobotStats, Server, ServerError};
use jde_sim::World;
use serde::Serialize;

use super::quantity;
use crate::cli::clock::speed;
use crate::cli::print_json;
use crate::failure::Failure;
use crate::interrupt::{self, SignalListener};
use crate::paths;
use crate::summary::pluralize;
use crate::terminal::{self, BAD, FAINT, GOOD, TITLE, TextWriter, WARN};

/// The default TCP port of the protocol.
const PORT: u16 = 8101;

/// Serve a simulated world: each of its robots speaks the Pioneer protocol to one client at a time.
///
/// Any program for Pioneer robots can drive them: ARIA, Player, Soar, and applications with the driver
/// p2os/pioneer. Runs until Ctrl-C and prints every connection and disconnection. A robot that receives
/// nothing for two seconds of the world's time stops.
#[derive(Args)]
#[command(after_help = "Examples:
  jde sim office --p2os                      on 127.0.0.1:8101, for this machine alone
  jde sim worlds/two-robots.toml --p2os 8101 its robots on 8101 and 8102
  jde sim office --pty                       on a pseudo-terminal, for clients that want a serial line
  jde sim office --p2os 0.0.0.0:8101         for the whole network: the protocol knows no password
  jde sim hall --p2os --model second=amigo --speed 2x --for 10min",
    group = ArgGroup::new("lines").args(["p2os", "pty"]).required(true).multiple(true))]
pub(crate) struct Sim {
    /// The world's file, or the name of one in the folder worlds.
    #[arg(value_name = "WORLD", value_hint = ValueHint::FilePath)]
    world: PathBuf,
    /// Serve the first robot at this TCP address or port, and the others at the next ones.
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "127.0.0.1:8101",
        value_parser = address)]
    p2os: Option<SocketAddr>,
    /// Serve each robot at a pseudo-terminal; the paths are printed at the start.
    #[arg(long)]
    pty: bool,
    /// Use another robot than a P3-DX (repeatable): p3dx, p3at, p2dx, amigo, or a file of the same form.
    #[arg(long, value_name = "ROBOT=MODEL")]
    model: Vec<String>,
    /// The seed of all noise.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Run this many times as fast as real time.
    #[arg(long, value_name = "FACTOR", value_parser = speed, default_value = "1x")]
    speed: f64,
    /// End after this time of the machine.
    #[arg(long = "for", value_name = "TIME", value_parser = quantity::time)]
    limit: Option<Nanos>,
    /// End standard output with one line of JSON; all other text goes to standard error.
    #[arg(long)]
    json: bool,
}

/// The output of `--json`.
#[derive(Serialize)]
struct SimSummary<'a> {
    world: &'a str,
    seed: u64,
    sim_seconds: f64,
    robots: Vec<RobotSummary>,
}

#[derive(Serialize)]
struct RobotSummary {
    robot: String,
    travelled_m: f64,
    collisions: u64,
    min_clearance_m: Option<f64>,
    sessions: u64,
}

impl Sim {
    /// Serves the world until a signal or the time limit.
    pub(super) fn run(self) -> Result<(), Failure> {
        let file = paths::find_world(&self.world)?;
        let world = World::load(file, self.seed)
            .map_err(|error| Failure::usage(error.to_string(), "mend the world's file"))?;
        let options = Options {
            tcp: self.p2os,
            terminal: self.pty,
            models: self
                .model
                .iter()
                .map(|text| model(text))
                .collect::<Result<_, _>>()?,
            speed: self.speed,
        };
        let mut words = if self.json {
            terminal::err()
        } else {
            terminal::out()
        };
        let warnings: Vec<String> = world.warnings().iter().map(ToString::to_string).collect();
        let mut server = Server::open(world, &options).map_err(server_failure)?;
        for warning in warnings {
            writeln!(words, "{WARN}warning{WARN:#}: {warning}")?;
        }
        self.announce(&server, &mut words)?;

        let stop = Arc::new(AtomicBool::new(false));
        let called = Arc::clone(&stop);
        let _interrupts = SignalListener::on_first(move || called.store(true, Ordering::Relaxed))?;
        let limit = self.limit.map(Duration::from_nanos);
        // The world must not wait for a reader of the output.
        let no_waiting = terminal::never_block();
        let mut told = Ok(());
        server
            .run(&stop, limit, |event| {
                let (time, robot, what) = (event.time.as_secs_f64(), &event.robot, &event.kind);
                let line = writeln!(words, "{FAINT}{time:8.1} s{FAINT:#}  {robot}: {what}");
                if let Err(error) = line.and_then(|()| words.flush()) {
                    // The output is closed: stop serving and return the error.
                    told = Err(error);
                    stop.store(true, Ordering::Relaxed);
                }
            })
            .map_err(server_failure)?;
        drop(no_waiting);
        told?;
        let tally = server.stats();
        writeln!(words)?;
        for robot in &tally {
            write_robot(robot, &mut words)?;
        }
        words.flush()?;
        if self.json {
            print_json(&SimSummary {
                world: server.world().name(),
                seed: self.seed,
                sim_seconds: server.world().now() as f64 / 1e9,
                robots: tally.into_iter().map(RobotSummary::from).collect(),
            })?;
        }
        Ok(())
    }

    fn announce(&self, server: &Server, words: &mut TextWriter) -> Result<(), Failure> {
        let name = server.world().name();
        writeln!(
            words,
            "{TITLE}{name}{TITLE:#} {FAINT}(seed {}){FAINT:#}: its robots wait for clients of the Pioneer protocol, {}",
            self.seed,
            interrupt::how_to_end()
        )?;
        for (robot, place) in server.addresses() {
            writeln!(words, "  {robot:<12} {GOOD}{place}{GOOD:#}")?;
        }
        let open = |place: &EndpointAddress| matches!(place, EndpointAddress::Tcp(address) if !address.ip().is_loopback());
        if server.addresses().any(|(_, place)| open(&place)) {
            writeln!(
                words,
                "{WARN}note{WARN:#}: whoever reaches this machine can drive them, for the protocol knows no password"
            )?;
        }
        words.flush()?;
        Ok(())
    }
}

impl From<RobotStats> for RobotSummary {
    fn from(tally: RobotStats) -> Self {
        Self {
            robot: tally.robot,
            travelled_m: tally.travelled,
            collisions: tally.collisions,
            min_clearance_m: tally.min_clearance.is_finite().then_some(tally.min_clearance),
            sessions: tally.sessions,
        }
    }
}

fn write_robot(robot: &RobotStats, words: &mut TextWriter) -> std::io::Result<()> {
    let style = if robot.collisions == 0 { GOOD } else { BAD };
    writeln!(
        words,
        "{TITLE}{}{TITLE:#}: {:.1} m driven, {style}{}{style:#}, never nearer than {:.2} m to anything, {}",
        robot.robot,
        robot.travelled,
        pluralize(robot.collisions, "collision"),
        robot.min_clearance.max(0.0),
        pluralize(robot.sessions, "session")
    )
}

fn server_failure(error: ServerError) -> Failure {
    let help = match &error {
        ServerError::Endpoint { error, .. } if error.kind() == std::io::ErrorKind::AddrInUse => {
            "another program serves there; end it, or give another port: --p2os 8111"
        }
        ServerError::Endpoint { error, .. } if error.kind() == std::io::ErrorKind::PermissionDenied => {
            "ports below 1024 belong to the system; the protocol's own is 8101"
        }
        ServerError::Endpoint { .. } => "give an address of this machine, such as 127.0.0.1:8101",
        ServerError::NoRobots(_)
        | ServerError::NoSuchRobot { .. }
        | ServerError::Names { .. }
        | ServerError::World(_)
        | ServerError::Model(_) => "mend the world's file or the options",
        ServerError::NoEndpoints | ServerError::NoPort(_) | ServerError::Wait(_) => "see jde sim --help",
    };
    match error {
        ServerError::Wait(error) => Failure::Output(error),
        error => Failure::usage(error.to_string(), help),
    }
}

/// Parses "127.0.0.1:8101", "8101" or an address without a port. A port alone means this machine.
fn address(text: &str) -> Result<SocketAddr, String> {
    let port = text.strip_prefix(':').unwrap_or(text).parse();
    if let Ok(port) = port {
        return Ok((Ipv4Addr::LOCALHOST, port).into());
    }
    let text = text.replace("localhost", "127.0.0.1");
    let alone = text.parse().map(|address| SocketAddr::new(address, PORT));
    text.parse().or(alone).map_err(|_| {
        format!("`{text}` is no address; write 8101, or one with a port, such as 127.0.0.1:8101; a world stands before --p2os")
    })
}

fn model(text: &str) -> Result<(String, Model), Failure> {
    let wrong = |message: String| Failure::usage(message, "write ROBOT=MODEL, such as second=amigo");
    let (robot, model) = text
        .split_once('=')
        .ok_or_else(|| wrong(format!("`{text}` names no robot and model")))?;
    let model = if model.contains('/') || model.ends_with(".toml") {
        let text = std::fs::read_to_string(model).map_err(Failure::file(model.as_ref()))?;
        Model::parse(&text, model)
    } else {
        Model::named(model)
    };
    let model = model.map_err(|error| wrong(error.to_string()))?;
    Ok((robot.to_owned(), model))
}

#[cfg(test)]
mod tests {
    use super::address;

    #[test]
    fn a_port_alone_is_of_this_machine() {
        for text in ["8101", ":8101", "127.0.0.1", "localhost:8101", "127.0.0.1:8101"] {
            assert_eq!(address(text).expect(text).to_string(), "127.0.0.1:8101");
        }
        assert_eq!(address("[::1]:9000").expect("six").to_string(), "[::1]:9000");
        assert_eq!(address("0.0.0.0:9000").expect("all").to_string(), "0.0.0.0:9000");
    }

    #[test]
    fn what_is_no_address_is_refused() {
        for text in ["", "here", "99999", "1.2.3.4:x", "host.example:8101"] {
            assert!(address(text).is_err(), "{text}");
        }
    }
}
