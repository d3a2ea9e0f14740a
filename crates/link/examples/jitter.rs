//! Measures what clients do to the control loop: how late a motor schema of 100 Hz wakes, with no client, with one that
//! listens to everything, with one that floods, with one that is stopped, and with one that is killed again and again.
//!
//! ```text
//! cargo run --release -p jde-link --example jitter -- 10 3
//! ```
//!
//! runs each case for 10 s, three times in turn, and prints the table of `docs/link.md`: of each case the round that the rest of
//! the machine disturbed least, which is the one with the lowest p99. Clients run at nice +19, as if on a machine of their own: a program that only computes delays its neighbours
//! too, whether it is a client or not. On a machine that others use, put `nice -n -15` in front (as root).

use std::process::{Child, Command};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use jde_abi::raw;
use jde_host::app;
use jde_host::plugin::{Plugins, SearchPath};
use jde_host::story::Kind;
use jde_host::{Options, Running};
use jde_link::{Client, Events, Folder, Link, Rate, Reach, Settings, Title};
use jde_schema::prelude::*;
use rustix::process::{Pid, Signal, kill_process};
use zenoh::Wait;
use zenoh::qos::CongestionControl;

type Failure = Box<dyn std::error::Error>;

/// When the loop woke.
static WOKE: Mutex<Vec<Instant>> = Mutex::new(Vec::new());

const PERIOD: Duration = Duration::from_millis(10);

/// A control loop that publishes a number and a path.
#[derive(Describe)]
#[schema(motor, period = "10ms", budget = "5ms")]
struct Beat {
    /// Counts.
    #[export]
    count: Export<f64>,
    /// Something larger.
    #[export]
    route: Export<Path>,
    /// How fast it counts.
    #[modulation(default = 1.0)]
    step: Modulation<f64>,
    counted: f64,
}

impl Schema for Beat {
    fn check(&mut self, _: &Context) -> Result<Precondition> {
        WOKE.lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(Instant::now());
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

/// What a client does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Case {
    NoLink,
    NoClient,
    Everything,
    Flood,
    Stopped,
    Killed,
}

const CASES: [Case; 6] = [
    Case::NoLink,
    Case::NoClient,
    Case::Everything,
    Case::Flood,
    Case::Stopped,
    Case::Killed,
];

impl Case {
    fn words(self) -> &'static str {
        match self {
            Self::NoLink => "no link at all",
            Self::NoClient => "no client",
            Self::Everything => "one that listens to everything at full rate",
            Self::Flood => "one that floods with questions, orders and puts",
            Self::Stopped => "one that listens to everything, stopped (SIGSTOP)",
            Self::Killed => "one that listens to everything, killed every second",
        }
    }
}

fn main() -> std::result::Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [role, folder] = arguments.as_slice()
        && role.parse::<u64>().is_err()
    {
        return client(role, Folder::at(folder));
    }
    let number = |place: usize, usual: u64| match arguments.get(place) {
        Some(text) => text.parse::<u64>(),
        None => Ok(usual),
    };
    let (seconds, rounds) = (number(0, 10)?, number(1, 3)?);
    let mut best: Vec<Option<Vec<Duration>>> = vec![None; CASES.len()];
    for _ in 0..rounds {
        for (case, best) in CASES.iter().zip(&mut best) {
            let mut late = measure(*case, Duration::from_secs(seconds))?;
            late.sort();
            if best.as_ref().is_none_or(|best| at(&late, 0.99) < at(best, 0.99)) {
                *best = Some(late);
            }
        }
    }
    println!("| client | wake-ups | p50 | p99 | max |");
    println!("|---|---|---|---|---|");
    for (case, late) in CASES.iter().zip(best.into_iter().flatten()) {
        let us = |share: f64| at(&late, share).as_secs_f64() * 1e6;
        println!(
            "| {} | {} | {:.0} us | {:.0} us | {:.0} us |",
            case.words(),
            late.len(),
            us(0.5),
            us(0.99),
            us(1.0)
        );
    }
    Ok(())
}

/// Of sorted times, the one below which such a share of them lies.
fn at(sorted: &[Duration], share: f64) -> Duration {
    let place = (sorted.len().saturating_sub(1) as f64 * share) as usize;
    sorted.get(place).copied().unwrap_or_default()
}

/// How late the loop woke each time.
fn measure(case: Case, time: Duration) -> std::result::Result<Vec<Duration>, Failure> {
    let files = tempfile::tempdir()?;
    let folder = Folder::at(files.path().join("jde"));
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&PLUGIN)?;
    let application = app::parse(APPLICATION, std::path::Path::new("jitter.toml"), &[], &plugins)
        .map_err(|faults| faults.to_string())?;
    let events = Events::of(&application);
    let title = Title::new(&application, 1.0);
    let options = Options {
        observers: vec![events.observer()],
        ..Options::default()
    };
    let running = Running::start(application, &plugins, options)?;
    let settings = Settings {
        folder: folder.clone(),
        ..Settings::local("jitter")
    };
    let subject = Arc::new(jde_link::Running::new(running.handle(), title));
    let _link = match case {
        Case::NoLink => None,
        _ => Some(Link::open(&settings, subject, &events)?),
    };
    let role = match case {
        Case::NoLink | Case::NoClient => None,
        Case::Flood => Some("flood"),
        Case::Everything | Case::Stopped | Case::Killed => Some("listen"),
    };
    let start = || -> std::result::Result<Option<Guest>, Failure> {
        role.map(|role| Guest::start(role, &folder)).transpose()
    };
    let mut guest = start()?;
    // Until it listens, or floods.
    std::thread::sleep(Duration::from_secs(1));
    if case == Case::Stopped
        && let Some(guest) = &guest
    {
        guest.stop()?;
    }
    WOKE.lock().unwrap_or_else(PoisonError::into_inner).clear();
    let begun = Instant::now();
    while begun.elapsed() < time {
        std::thread::sleep(Duration::from_secs(1).min(time));
        if case == Case::Killed {
            drop(guest.take());
            guest = start()?;
        }
    }
    drop(guest);
    let woke = std::mem::take(&mut *WOKE.lock().unwrap_or_else(PoisonError::into_inner));
    drop(running);
    Ok(lateness(&woke))
}

/// By how much each came after its place on the grid of periods; the earliest of all is taken to be in time.
fn lateness(woke: &[Instant]) -> Vec<Duration> {
    let Some(first) = woke.first() else {
        return Vec::new();
    };
    let period = PERIOD.as_nanos() as i128;
    let phases = woke.iter().map(|at| {
        let since = at.duration_since(*first).as_nanos() as i128;
        since - (since + period / 2).div_euclid(period) * period
    });
    let phases: Vec<i128> = phases.collect();
    let earliest = phases.iter().min().copied().unwrap_or_default();
    let late = |phase: &i128| Duration::from_nanos(u64::try_from(phase - earliest).unwrap_or_default());
    phases.iter().map(late).collect()
}

/// A client in a process of its own; killed when dropped.
struct Guest(Child);

impl Guest {
    fn start(role: &str, folder: &Folder) -> std::result::Result<Self, Failure> {
        let program = std::env::current_exe()?;
        let child = Command::new(program).arg(role).arg(folder.path()).spawn()?;
        Ok(Self(child))
    }

    fn stop(&self) -> std::result::Result<(), Failure> {
        let pid = Pid::from_raw(self.0.id().cast_signed()).ok_or("no process")?;
        Ok(kill_process(pid, Signal::STOP)?)
    }
}

impl Drop for Guest {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn client(role: &str, folder: Folder) -> std::result::Result<(), Failure> {
    rustix::process::nice(39)?;
    let client = Client::connect(&Reach::Local(folder.clone()))?;
    let remote = client.application(None)?;
    if role == "listen" {
        let mut watching = vec![
            remote.events(&Kind::ALL, 100, |_| {})?,
            remote.watch_hierarchy(|_| {})?,
        ];
        for variable in remote.variables(false)? {
            watching.push(remote.watch(&variable.name, Rate::Full, |_| {})?);
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
    let order = r#"{"by":"x","action":"modulate","schema":"beat","variable":"step","value":2.0}"#;
    loop {
        for (key, payload) in [
            ("operate", order),
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
