//! What a process of its own costs: the time of the machine that a turn of the same schema takes in lockstep, in process,
//! apart and in Python, beside the times of pipes to another process and back; and the share of a core of ten such schemas
//! in real time.
//!
//! `PYTHONPATH=target/python cargo run --release -p jde-host --example apart`

use std::error::Error;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{self, Stdio};
use std::result::Result;
use std::time::{Duration, Instant};

use jde_abi::raw;
use jde_app::{Application, parse};
use jde_host::{Lockstep, Options, Running};
use jde_isolation::{Inspector, Program, load, serve};
use jde_loader::{Plugins, SearchPath};
use jde_schema::prelude::*;

/// What this program is called with to be the process of a schema.
const SERVE: &str = "serve";
/// What it is called with to return each byte.
const ECHO: &str = "echo";
/// A process of Python that does the same without jde: it unpacks the 360 ranges of a scan and answers with a speed.
const PYTHON_ECHO: &str = "
import os, struct
scan, speed = struct.Struct('360f'), struct.Struct('6d')
while data := os.read(0, scan.size):
    os.write(1, speed.pack(scan.unpack(data)[180], 0, 0, 0, 0, 0))
";
/// The bytes of the ranges of a scan, and of a speed.
const SCAN_BYTES: usize = 1440;
const SPEED_BYTES: usize = size_of::<Twist>();
/// The turns and the messages of which the median is shown.
const TURN_COUNT: u64 = 5000;

/// Looks at a scan and commands a speed: what a behaviour does in an iteration.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Follow {
    /// What a laser sees.
    #[import(optional)]
    laser: Import<LaserScan>,
    /// Speeds of the base.
    #[actuator(optional)]
    base: Actuator<Twist>,
}

impl Schema for Follow {
    fn iterate(&mut self, cx: &Context) -> jde_schema::Result {
        let mut twist = Twist::ZERO;
        twist.linear.x = self.laser.get(cx).map_or(0.0, |laser| f64::from(laser.range_max));
        self.base.command(cx, twist);
        Ok(())
    }
}

/// A base with a laser.
#[derive(Describe)]
#[schema(driver, period = "10ms")]
struct CostBase {
    /// What the laser sees.
    #[export]
    laser: Export<LaserScan>,
    /// Speeds.
    #[command(neutral = Twist::ZERO, validity = "100ms")]
    velocity: Command<Twist>,
}

impl Schema for CostBase {
    fn iterate(&mut self, cx: &Context) -> jde_schema::Result {
        let mut laser = self.laser.loan(cx);
        laser.range_max = 8.0;
        laser.publish();
        let _ = self.velocity.get(cx);
        Ok(())
    }
}

static PLUGIN: raw::Plugin = jde_schema::plugin!("cost", "What an iteration costs.", [Follow, CostBase]);

const APPLICATION: &str = r#"
    roots = ["follow"]
    [schemas.base]
    type = "cost/base"
    [schemas.follow]
    type = "cost/follow"
    imports = { laser = "base.laser" }
    actuators = { base = "base.velocity" }
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let mut path = SearchPath::default();
    path.push(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("examples"),
        "the example",
    );
    let mut plugins = Plugins::new(path).with_inspector(Inspector::new(own(SERVE)?));
    plugins.link(&PLUGIN)?;
    match std::env::args().nth(1).as_deref() {
        Some(SERVE) => return Ok(serve(|plugin| load(&plugins, plugin))?),
        Some(ECHO) => return echo(),
        _ => {}
    }
    let apart = APPLICATION.replace("\"cost/follow\"", "\"cost/follow\"\nisolate = \"process\"");
    let (in_process, apart) = (turn(APPLICATION, &plugins)?, turn(&apart, &plugins)?);
    let pipe_time = pipe(&own(ECHO)?, 1, 1)?;
    let bytes = size_of::<LaserScan>();
    println!(
        "in process {in_process:8.2} us for a turn that reads a scan of {bytes} bytes and commands a speed"
    );
    println!("apart {apart:8.2} us");
    println!("pipe  {pipe_time:8.2} us for a byte to another process and back");
    println!(
        "share {:8.2} % of a core for ten at 20 Hz",
        share(&plugins)? * 100.0
    );
    let python = APPLICATION.replace("cost/follow", "apart.py/Follow");
    println!(
        "python {:8.2} us for the same turn in Python",
        turn(&python, &plugins)?
    );
    let echo = Program {
        path: "python3".into(),
        arguments: vec!["-c".into(), PYTHON_ECHO.into()],
    };
    println!(
        "python pipe {:8.2} us for {SCAN_BYTES} bytes to a process of Python that unpacks them, and {SPEED_BYTES} back",
        pipe(&echo, SCAN_BYTES, SPEED_BYTES)?
    );
    Ok(())
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn configure(text: &str, plugins: &Plugins) -> Result<(Application, Options), Box<dyn Error>> {
    let application = parse(text, Path::new("cost.toml"), &[], plugins)?;
    let options = Options {
        isolation_program: Some(own(SERVE)?),
        ..Options::default()
    };
    Ok((application, options))
}

/// Median time of the machine for a period of the application in lockstep, us.
fn turn(text: &str, plugins: &Plugins) -> Result<f64, Box<dyn Error>> {
    let (application, options) = configure(text, plugins)?;
    let mut run = Lockstep::start(application, plugins, options)?;
    let period = 10_000_000;
    let time = |turn| {
        let start = Instant::now();
        run.run_until(turn * period);
        start.elapsed().as_secs_f64() * 1e6
    };
    Ok(median((1..=TURN_COUNT).map(time).collect()))
}

/// This program, with another task.
fn own(task: &str) -> Result<Program, Box<dyn Error>> {
    Ok(Program::new(std::env::current_exe()?, task))
}

/// Median time of the machine for `there` bytes through a pipe to a program, and `back` bytes from it, us.
fn pipe(program: &Program, there: usize, back: usize) -> Result<f64, Box<dyn Error>> {
    let (sent, mut received) = (vec![1; there], vec![0; back]);
    let mut child = process::Command::new(&program.path)
        .args(&program.arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    let (Some(mut there), Some(mut back)) = (child.stdin.take(), child.stdout.take()) else {
        return Err("the child has no pipes".into());
    };
    let mut times = Vec::new();
    for _ in 0..TURN_COUNT {
        let start = Instant::now();
        there.write_all(&sent)?;
        back.read_exact(&mut received)?;
        times.push(start.elapsed().as_secs_f64() * 1e6);
    }
    drop(there);
    child.wait()?;
    Ok(median(times))
}

/// Returns each byte, until there is none.
fn echo() -> Result<(), Box<dyn Error>> {
    let mut byte = [0];
    while std::io::stdin().read(&mut byte)? > 0 {
        std::io::stdout().write_all(&byte)?;
        std::io::stdout().flush()?;
    }
    Ok(())
}

/// The processor time of this process and its children in a second of an application with ten schemas apart, without that
/// of the same schemas in process.
fn share(plugins: &Plugins) -> Result<f64, Box<dyn Error>> {
    let time = |isolate: &str| -> Result<f64, Box<dyn Error>> {
        let names: Vec<String> = (0..10).map(|number| format!("follow{number}")).collect();
        let (head, follow) = APPLICATION.split_once("[schemas.follow]").ok_or("no schema")?;
        let mut text = head.replace("[\"follow\"]", &format!("{names:?}"));
        for name in names {
            text += &format!("[schemas.{name}]\nperiod = \"50ms\"\n{isolate}{follow}");
        }
        let (application, options) = configure(&text, plugins)?;
        let (start, before) = (Instant::now(), processor_time()?);
        let running = Running::start(application, plugins, options)?;
        std::thread::sleep(Duration::from_secs(5));
        drop(running);
        Ok((processor_time()? - before) / start.elapsed().as_secs_f64())
    };
    Ok(time("isolate = \"process\"\n")? - time("")?)
}

/// The processor time of this process and of its children that have ended, s.
fn processor_time() -> Result<f64, Box<dyn Error>> {
    let text = std::fs::read_to_string("/proc/self/stat")?;
    let fields = text.rsplit_once(')').ok_or("no fields")?.1.split_whitespace();
    let ticks: u64 = fields
        .skip(11)
        .take(4)
        .map(|field| field.parse().unwrap_or(0))
        .sum();
    Ok(ticks as f64 / 100.0)
}
