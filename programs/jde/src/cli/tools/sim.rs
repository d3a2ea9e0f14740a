//! `jde sim`: a simulated world whose robots use the Pioneer protocol with any client.

use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

use clap::{ArgGroup, Args, ValueHint};
use jde_core::Nanos;
use jde_drawing::text::counted;
use jde_p2os::Model;
use jde_p2os_server::{EndpointAddress, Options, RobotStats, Server, ServerError};
use jde_session::cli::print_json;
use jde_session::clock::speed;
use jde_session::paths;
use jde_sim::World;
use jde_terminal::interrupt::{self, SignalListener};
use jde_terminal::{self as terminal, BAD, FAINT, GOOD, TITLE, TextWriter, WARN};
use serde::Serialize;

use crate::failure::Failure;
use crate::quantity;

/// The default TCP port of the protocol.
const DEFAULT_PORT: u16 = 8101;

/// Serve a simulated world: each of its robots serves one client at a time over the Pioneer protocol.
///
/// Any program for Pioneer robots can drive them: ARIA, Player, Soar, and applications with the driver
/// p2os/pioneer. Runs until Ctrl-C and prints every connection and disconnection. A robot that receives
/// nothing for two seconds of the world's time stops.
#[derive(Args)]
#[command(after_help = "Examples:
  jde sim office --p2os                      on 127.0.0.1:8101, for this machine alone
  jde sim worlds/two-robots.toml --p2os 8101 its robots on 8101 and 8102
  jde sim office --pty                       on a pseudo-terminal, for clients that want a serial line
  jde sim office --p2os 0.0.0.0:8101         for the whole network: the protocol has no password
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
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 1)]
    seed: u64,
    /// Run this many times as fast as real time.
    #[arg(long, value_name = "FACTOR", value_parser = speed, default_value = "1x")]
    speed: f64,
    /// End after this time of the machine.
    #[arg(long = "for", value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
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
        let world = World::load(file, self.seed).map_err(Failure::world)?;
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
        let mut output = terminal::text_out(self.json);
        let warnings: Vec<String> = world.warnings().iter().map(ToString::to_string).collect();
        let mut server = Server::open(world, &options).map_err(server_failure)?;
        for warning in warnings {
            writeln!(output, "{WARN}warning{WARN:#}: {warning}")?;
        }
        // Before the lines that others wait for: a signal after them must find a listener.
        let (stop, _interrupts) = SignalListener::flag(|| {})?;
        self.announce(&server, &mut output)?;

        let limit = self.limit.map(Duration::from_nanos);
        // The world must not wait for a reader of the output.
        let no_waiting = terminal::never_block();
        let mut printed = Ok(());
        server
            .run(&stop, limit, |event| {
                let (time, robot, kind) = (event.time.as_secs_f64(), &event.robot, &event.kind);
                let line = writeln!(output, "{FAINT}{time:8.1} s{FAINT:#}  {robot}: {kind}");
                if let Err(error) = line.and_then(|()| output.flush()) {
                    // The output is closed: stop serving and return the error.
                    printed = Err(error);
                    stop.store(true, Ordering::Relaxed);
                }
            })
            .map_err(server_failure)?;
        drop(no_waiting);
        printed?;
        let stats = server.stats();
        writeln!(output)?;
        for robot in &stats {
            write_robot(robot, &mut output)?;
        }
        output.flush()?;
        if self.json {
            print_json(&SimSummary {
                world: server.world().name(),
                seed: self.seed,
                sim_seconds: server.world().now() as f64 / 1e9,
                robots: stats.into_iter().map(RobotSummary::from).collect(),
            })?;
        }
        Ok(())
    }

    fn announce(&self, server: &Server, output: &mut TextWriter) -> Result<(), Failure> {
        let name = server.world().name();
        writeln!(
            output,
            "{TITLE}{name}{TITLE:#} {FAINT}(seed {}){FAINT:#}: its robots wait for clients of the Pioneer protocol, {}",
            self.seed,
            interrupt::how_to_end()
        )?;
        for (robot, address) in server.addresses() {
            writeln!(output, "  {robot:<12} {GOOD}{address}{GOOD:#}")?;
        }
        let is_open = |address: &EndpointAddress| matches!(address, EndpointAddress::Tcp(address) if !address.ip().is_loopback());
        if server.addresses().any(|(_, address)| is_open(&address)) {
            writeln!(
                output,
                "{WARN}note{WARN:#}: everyone who can reach this machine can drive the robots: the protocol has no password"
            )?;
        }
        output.flush()?;
        Ok(())
    }
}

impl From<RobotStats> for RobotSummary {
    fn from(stats: RobotStats) -> Self {
        Self {
            robot: stats.robot,
            travelled_m: stats.travelled,
            collisions: stats.collisions,
            min_clearance_m: stats.min_clearance.is_finite().then_some(stats.min_clearance),
            sessions: stats.sessions,
        }
    }
}

fn write_robot(robot: &RobotStats, output: &mut TextWriter) -> std::io::Result<()> {
    let style = if robot.collisions == 0 { GOOD } else { BAD };
    writeln!(
        output,
        "{TITLE}{}{TITLE:#}: {:.1} m driven, {style}{}{style:#}, never nearer than {:.2} m to anything, {}",
        robot.robot,
        robot.travelled,
        counted(robot.collisions, "contact"),
        robot.min_clearance.max(0.0),
        counted(robot.sessions, "session")
    )
}

fn server_failure(error: ServerError) -> Failure {
    let help = match &error {
        ServerError::Endpoint { error, .. } if error.kind() == std::io::ErrorKind::AddrInUse => {
            "another program uses this address; end it, or give another port: --p2os 8111"
        }
        ServerError::Endpoint { error, .. } if error.kind() == std::io::ErrorKind::PermissionDenied => {
            "ports below 1024 belong to the system; the protocol's own is 8101"
        }
        ServerError::Endpoint { .. } => "give an address of this machine, such as 127.0.0.1:8101",
        ServerError::NoRobots(_)
        | ServerError::NoSuchRobot { .. }
        | ServerError::Names { .. }
        | ServerError::World(_)
        | ServerError::Model(_) => "correct the world's file or the options",
        ServerError::NoEndpoints | ServerError::NoPort(_) | ServerError::Wait(_) => "see jde sim --help",
    };
    match error {
        ServerError::Wait(error) => error.into(),
        error => Failure::usage(error.to_string(), help),
    }
}

/// Parses "127.0.0.1:8101", "8101" or an address without a port. A port without an address is on this
/// machine.
fn address(text: &str) -> Result<SocketAddr, String> {
    let port = text.strip_prefix(':').unwrap_or(text).parse();
    if let Ok(port) = port {
        return Ok((Ipv4Addr::LOCALHOST, port).into());
    }
    let text = text.replace("localhost", "127.0.0.1");
    let with_default_port = text.parse().map(|address| SocketAddr::new(address, DEFAULT_PORT));
    text.parse().or(with_default_port).map_err(|_| {
        format!("`{text}` is not an address; write 8101, or one with a port, such as 127.0.0.1:8101; the world precedes --p2os")
    })
}

/// The largest file of a model, bytes.
const MAX_MODEL: u64 = 1 << 20;

fn model(text: &str) -> Result<(String, Model), Failure> {
    let wrong = |message: String| Failure::usage(message, "write ROBOT=MODEL, such as second=amigo");
    let (robot, model) = text
        .split_once('=')
        .ok_or_else(|| wrong(format!("`{text}` is not ROBOT=MODEL")))?;
    let model = if model.contains('/') || model.ends_with(".toml") {
        let text = jde_files::read_text(model.as_ref(), MAX_MODEL).map_err(Failure::file(model.as_ref()))?;
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
    fn a_port_without_an_address_is_on_this_machine() {
        for text in ["8101", ":8101", "127.0.0.1", "localhost:8101", "127.0.0.1:8101"] {
            assert_eq!(address(text).expect(text).to_string(), "127.0.0.1:8101");
        }
        assert_eq!(address("[::1]:9000").expect("six").to_string(), "[::1]:9000");
        assert_eq!(address("0.0.0.0:9000").expect("all").to_string(), "0.0.0.0:9000");
    }

    #[test]
    fn invalid_addresses_are_refused() {
        for text in ["", "here", "99999", "1.2.3.4:x", "host.example:8101"] {
            assert!(address(text).is_err(), "{text}");
        }
    }
}
