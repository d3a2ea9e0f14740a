//! Measures the effect of clients on the control loop: the lateness of a motor schema's wake-ups at 100 Hz,
//! with no client, with one that subscribes to everything, with one that floods, with one that is stopped,
//! and with one that is killed repeatedly. For comparison it measures with a program that only computes and
//! does not use the link.
//!
//! ```text
//! cargo run --release -p jde-link --example jitter -- 10 3
//! ```
//!
//! runs each case for 10 s, three times in turn, and prints the table of `docs/link.md`: for each case the
//! round whose p99 is the median of all its rounds. Clients and the computing program run at nice +19, as if
//! on another machine.

use std::process::{Child, Command};
use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_abi::raw;
use jde_core::State;
use jde_host::{Options, Running};
use jde_link::{Client, Events, Folders, Link, Rate, Reach, Settings, SubjectInfo};
use jde_loader::{Plugins, SearchPath};
use jde_records::RecordKind;
use jde_records::event::{Event, Observer, StateChange};
use jde_schema::prelude::*;
use parking_lot::Mutex;
use rustix::process::{Pid, Signal, kill_process};
use zenoh::Wait;
use zenoh::qos::CongestionControl;

type Failure = Box<dyn std::error::Error>;

/// Wake-ups of the loop, in application time.
static WAKE_UPS: Mutex<Vec<Duration>> = Mutex::new(Vec::new());
/// The schema's awakening, from which its periods count.
static AWAKENED_AT: Mutex<Duration> = Mutex::new(Duration::ZERO);

const SCHEMA_PERIOD: Duration = Duration::from_millis(10);

/// A control loop that publishes a number and a path.
#[derive(Describe)]
#[schema(motor, period = "10ms", budget = "5ms")]
struct Beat {
    /// The count.
    #[export]
    count: Export<f64>,
    /// A larger value.
    #[export]
    route: Export<Path>,
    /// Increment per iteration.
    #[modulation(default = 1.0)]
    step: Modulation<f64>,
    counted: f64,
}

impl Schema for Beat {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        WAKE_UPS.lock().push(cx.now());
        Ok(true.into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.counted += self.step.get(cx);
        self.count.write(cx, self.counted);
        self.route.write(cx, Path::default());
        Ok(())
    }
}

static PLUGIN: raw::Plugin = jde_schema::plugin!("jitter", "A control loop.", [Beat]);

const APPLICATION: &str = "name = \"jitter\"\nroots = [\"beat\"]\n[schemas.beat]\ntype = \"jitter/beat\"\n";

/// The client of a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Case {
    NoLink,
    NoClient,
    Computes,
    Everything,
    Flood,
    Stopped,
    Killed,
}

const CASES: [Case; 7] = [
    Case::NoLink,
    Case::NoClient,
    Case::Computes,
    Case::Everything,
    Case::Flood,
    Case::Stopped,
    Case::Killed,
];

impl Case {
    fn label(self) -> &'static str {
        match self {
            Self::NoLink => "no link at all",
            Self::NoClient => "no client",
            Self::Computes => "no client, but a program that computes on every core",
            Self::Everything => "one that subscribes to everything at full rate",
            Self::Flood => "one that floods with queries, requests and puts",
            Self::Stopped => "one that subscribes to everything, stopped (SIGSTOP)",
            Self::Killed => "one that subscribes to everything, killed every second",
        }
    }
}

fn main() -> std::result::Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [role, folder] = arguments.as_slice()
        && role.parse::<u64>().is_err()
    {
        return client(role, Folders::at(folder));
    }
    let number = |index: usize, default: u64| match arguments.get(index) {
        Some(text) => text.parse::<u64>(),
        None => Ok(default),
    };
    let (seconds, rounds) = (number(0, 10)?, number(1, 3)?);
    let mut all: Vec<Vec<Vec<Duration>>> = vec![Vec::new(); CASES.len()];
    for _ in 0..rounds.max(1) {
        for (case, rounds) in CASES.iter().zip(&mut all) {
            let mut late = measure(*case, Duration::from_secs(seconds))?;
            late.sort();
            rounds.push(late);
        }
    }
    println!("| client | wake-ups | p50 | p99 | max |");
    println!("|---|---|---|---|---|");
    for (case, mut rounds) in CASES.iter().zip(all) {
        rounds.sort_by_key(|late| quantile(late, 0.99));
        let late = &rounds[(rounds.len() - 1) / 2];
        let us = |share: f64| quantile(late, share).as_secs_f64() * 1e6;
        println!(
            "| {} | {} | {:.0} us | {:.0} us | {:.0} us |",
            case.label(),
            late.len(),
            us(0.5),
            us(0.99),
            us(1.0)
        );
    }
    Ok(())
}

/// The value below which a share of sorted times lies.
fn quantile(sorted: &[Duration], share: f64) -> Duration {
    let index = (sorted.len().saturating_sub(1) as f64 * share) as usize;
    sorted.get(index).copied().unwrap_or_default()
}

/// The lateness of each wake-up of the loop.
fn measure(case: Case, time: Duration) -> std::result::Result<Vec<Duration>, Failure> {
    let files = tempfile::tempdir()?;
    let folder = Folders::at(files.path().join("jde"));
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&PLUGIN)?;
    let application = jde_app::parse(APPLICATION, std::path::Path::new("jitter.toml"), &[], &plugins)
        .map_err(|faults| faults.to_string())?;
    let events = Events::of(&application);
    let info = SubjectInfo::new(&application, 1.0);
    let options = Options {
        observers: vec![events.observer(), Box::new(AwakeningObserver)],
        ..Options::default()
    };
    let running = Running::start(application, &plugins, options)?;
    let settings = Settings {
        folder: folder.clone(),
        ..Settings::local("jitter")
    };
    let subject = Arc::new(jde_link_host::Running::new(running.handle(), info));
    let _link = match case {
        Case::NoLink => None,
        _ => Some(Link::open(&settings, subject, &events)?),
    };
    let role = match case {
        Case::NoLink | Case::NoClient => None,
        Case::Computes => Some("compute"),
        Case::Flood => Some("flood"),
        Case::Everything | Case::Stopped | Case::Killed => Some("subscribe"),
    };
    let start = || -> std::result::Result<Option<ClientProcess>, Failure> {
        role.map(|role| ClientProcess::start(role, &folder)).transpose()
    };
    let mut client = start()?;
    // Until the client subscribes or floods.
    std::thread::sleep(Duration::from_secs(1));
    if case == Case::Stopped
        && let Some(client) = &client
    {
        client.stop()?;
    }
    WAKE_UPS.lock().clear();
    let start_time = Instant::now();
    while start_time.elapsed() < time {
        std::thread::sleep(Duration::from_secs(1).min(time));
        if case == Case::Killed {
            drop(client.take());
            client = start()?;
        }
    }
    drop(client);
    let woke = std::mem::take(&mut *WAKE_UPS.lock());
    let awoke = *AWAKENED_AT.lock();
    drop(running);
    Ok(woke.into_iter().map(|at| lateness(awoke, at)).collect())
}

/// The delay of a wake-up from its place on the grid of periods.
fn lateness(awoke: Duration, woke: Duration) -> Duration {
    let late = woke.saturating_sub(awoke).as_nanos() % SCHEMA_PERIOD.as_nanos();
    Duration::from_nanos(late as u64)
}

/// Records the awakening of the loop's schema.
struct AwakeningObserver;

impl Observer for AwakeningObserver {
    fn on_event(&mut self, event: &Event) {
        if let Event::State(StateChange {
            time,
            from: State::Slept,
            ..
        }) = event
        {
            *AWAKENED_AT.lock() = Duration::from_nanos(*time);
        }
    }
}

/// A client in a child process; killed when dropped.
struct ClientProcess(Child);

impl ClientProcess {
    fn start(role: &str, folder: &Folders) -> std::result::Result<Self, Failure> {
        let program = std::env::current_exe()?;
        let child = Command::new(program).arg(role).arg(folder.path()).spawn()?;
        Ok(Self(child))
    }

    fn stop(&self) -> std::result::Result<(), Failure> {
        let pid = Pid::from_raw(self.0.id().cast_signed()).ok_or("no process")?;
        Ok(kill_process(pid, Signal::STOP)?)
    }
}

impl Drop for ClientProcess {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Keeps every core busy until it is killed.
fn compute() -> ! {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    for _ in 1..cores {
        std::thread::spawn(count);
    }
    count()
}

fn count() -> ! {
    let mut counted = 0_u64;
    loop {
        counted = std::hint::black_box(counted.wrapping_add(1));
    }
}

fn client(role: &str, folder: Folders) -> std::result::Result<(), Failure> {
    rustix::process::nice(39)?;
    if role == "compute" {
        compute();
    }
    let client = Client::connect(&Reach::Local(folder.clone()))?;
    let remote = client.application(None)?;
    if role == "subscribe" {
        let mut subscriptions = vec![
            remote.events(&RecordKind::ALL, 100, |_| {})?,
            remote.watch_hierarchy(|_| {})?,
        ];
        for variable in remote.variables(false)? {
            subscriptions.push(remote.watch(&variable.name, Rate::Full, |_| {})?);
        }
        loop {
            std::thread::park();
        }
    }
    let socket = folder.path().join(format!("{}.sock", remote.about().id));
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("mode", "\"client\"".to_owned()),
        (
            "connect/endpoints",
            format!("[\"unixsock-stream/{}\"]", socket.display()),
        ),
        ("scouting/multicast/enabled", "false".to_owned()),
    ] {
        config
            .insert_json5(key, &value)
            .map_err(|error| error.to_string())?;
    }
    let session = zenoh::open(config).wait().map_err(|error| error.to_string())?;
    let root = format!("jde/1/jitter/{}", remote.about().id);
    let request = r#"{"by":"x","action":"modulate","schema":"beat","variable":"step","value":2.0}"#;
    loop {
        for (key, payload) in [
            ("operate", request),
            ("variables?status", ""),
            ("**", ""),
            ("hierarchy", ""),
        ] {
            let get = session.get(format!("{root}/{key}")).payload(payload);
            let _ = get
                .congestion_control(CongestionControl::Drop)
                .callback(|_| {})
                .wait();
        }
        let put = session.put("jde/1/jitter/x/hierarchy", vec![0; 1000]);
        let _ = put.congestion_control(CongestionControl::Drop).wait();
    }
}
