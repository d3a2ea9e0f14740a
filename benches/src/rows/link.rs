//! The time of a value from one process to another, over the link and over Zenoh alone, in turns. Zenoh alone
//! has the settings and the niceness that the link uses. The other process runs this program too.

use std::io::Read as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, anyhow, ensure};
use jde_host::{Options, Running};
use jde_link::{Client, Events, Folders, Link, Rate, Reach, Settings, SubjectInfo};
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::{Rounds, median};
use serde::{Deserialize, Serialize};
use zenoh::pubsub::Subscriber;
use zenoh::qos::CongestionControl;
use zenoh::{Session, Wait};

use crate::schemas::{Large, Small};
use crate::scope::Scope;
use crate::{bare, loaded, schemas};

/// The option that starts the other process, before the folder of the sockets.
pub(crate) const LISTEN: &str = "--listen";
/// The niceness of the link's threads, which are less urgent than the robot's.
const NICE: i32 = 10;
/// The interval between two values over Zenoh alone, small and large in turn.
const PERIOD: Duration = Duration::from_millis(20);
/// The number of values in a round.
const ROUND: usize = 25;

const APPLICATION: &str =
    "roots = [\"source\"]\n[schemas.source]\ntype = \"pace/source\"\nperiod = \"20ms\"\n";

/// The transfer times of values, ns.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Received {
    small: Vec<u64>,
    large: Vec<u64>,
    bare_small: Vec<u64>,
    bare_large: Vec<u64>,
}

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let files = tempfile::tempdir()?;
    let folder = Folders::at(files.path().join("jde"));
    let plugins = schemas::plugins()?;
    let application = loaded::application(APPLICATION, &plugins)?;
    let events = Events::of(&application);
    let title = SubjectInfo::new(&application, 1.0);
    let running = Running::start(application, &plugins, Options::default())?;
    let settings = Settings {
        folder: folder.clone(),
        ..Settings::local("bench")
    };
    let subject = Arc::new(jde_link_host::Running::new(running.handle(), title));
    let _link = Link::open(&settings, subject, &events)?;
    let session = session(folder.path(), "listen")?;
    let publisher = |key: &'static str| {
        let publisher = session
            .declare_publisher(key)
            .congestion_control(CongestionControl::Drop);
        publisher.wait().map_err(|error| anyhow!("{error}"))
    };
    let (small, large) = (publisher("bench/small")?, publisher("bench/large")?);
    let mut listener = Listener::start(folder.path())?;
    let buffer = vec![1u8; size_of::<Large>()];
    let start = Instant::now();
    let time = Duration::from_secs(scope.either(2, 20));
    let mut turn = 0u32;
    while start.elapsed() < time {
        // A schema's value that is written at the same instant belongs to another round.
        std::thread::sleep(PERIOD);
        turn += 1;
        let publisher = if turn.is_multiple_of(2) { &small } else { &large };
        let bytes = if turn.is_multiple_of(2) {
            size_of::<Small>()
        } else {
            size_of::<Large>()
        };
        let mut message = buffer[..bytes].to_vec();
        // The timer starts here: from here on Zenoh handles the message.
        message[..8].copy_from_slice(&bare::now().to_ne_bytes());
        publisher
            .put(message)
            .wait()
            .map_err(|error| anyhow!("{error}"))?;
    }
    let received = listener.end()?;
    drop(running);
    let line = |what: &str, ours: &[u64], theirs: &[u64]| -> Result<Line> {
        ensure!(
            !ours.is_empty() && !theirs.is_empty(),
            "values are missing: {} and {}",
            ours.len(),
            theirs.len()
        );
        let (ours, theirs) = (rounds(ours), rounds(theirs));
        Ok(Line::compared(
            format!("{what} to another process"),
            Figure::Time(ours.median()),
            "Zenoh alone",
            Figure::Time(theirs.median()),
            Goal::AtMost(1.1),
        ))
    };
    Ok(vec![
        line("64 B", &received.small, &received.bare_small)?,
        line("900 kB", &received.large, &received.bare_large)?,
    ])
}

/// Returns the medians of consecutive rounds.
fn rounds(times: &[u64]) -> Rounds {
    let rounds = times
        .chunks(ROUND)
        .map(|round| median(round.iter().map(|time| *time as f64).collect()));
    Rounds::of(rounds.collect())
}

/// The other process: receives both kinds until its standard input closes, and prints the times.
pub(crate) fn listen(folder: &Path) -> Result<()> {
    let received: Arc<Mutex<Received>> = Arc::default();
    let record = |of: fn(&mut Received) -> &mut Vec<u64>| {
        let received = Arc::clone(&received);
        move |bytes: &[u8]| {
            let now = bare::now();
            if let Some(sent) = bytes.first_chunk() {
                let mut received = received.lock().unwrap_or_else(PoisonError::into_inner);
                of(&mut received).push(now.saturating_sub(u64::from_ne_bytes(*sent)));
            }
        }
    };
    // Zenoh's threads inherit the niceness of the thread that starts them.
    rustix::process::nice(NICE)?;
    let client = Client::connect(&Reach::Local(Folders::at(folder)))?;
    let remote = client.application(None)?;
    let (small, large) = (
        record(|received| &mut received.small),
        record(|received| &mut received.large),
    );
    let watching = [
        remote.watch("source.small", Rate::Full, move |sample| {
            small(sample.bytes.as_deref().unwrap_or(&[]))
        })?,
        remote.watch("source.large", Rate::Full, move |sample| {
            large(sample.bytes.as_deref().unwrap_or(&[]))
        })?,
    ];
    let session = session(folder, "connect")?;
    let (small, large) = (
        record(|received| &mut received.bare_small),
        record(|received| &mut received.bare_large),
    );
    let subscribed = [
        subscribe(&session, "bench/small", small)?,
        subscribe(&session, "bench/large", large)?,
    ];
    println!("ready");
    std::io::stdin().read_to_end(&mut Vec::new())?;
    drop((watching, subscribed));
    let received = received.lock().unwrap_or_else(PoisonError::into_inner);
    println!("{}", serde_json::to_string(&*received)?);
    Ok(())
}

/// Subscribes to a key and records every message.
fn subscribe(
    session: &Session,
    key: &'static str,
    record: impl Fn(&[u8]) + Send + Sync + 'static,
) -> Result<Subscriber<()>> {
    let subscriber = session.declare_subscriber(key);
    // Read in place: a contiguous message would need a copy, which Zenoh alone does not make.
    let subscriber = subscriber.callback(move |sample| {
        let mut sent = [0; 8];
        if sample.payload().reader().read_exact(&mut sent).is_ok() {
            record(&sent);
        }
    });
    subscriber.wait().map_err(|error| anyhow!("{error}"))
}

/// Opens a session with the link's settings on its own socket in the folder.
fn session(folder: &Path, end: &'static str) -> Result<Session> {
    let endpoint = format!("unixsock-stream/{}", folder.join("bare.sock").display());
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("mode", String::from("\"peer\"")),
        ("listen/endpoints", String::from("[]")),
        ("scouting/multicast/enabled", String::from("false")),
        ("scouting/gossip/enabled", String::from("false")),
        ("timestamping/enabled", String::from("false")),
        ("adminspace/enabled", String::from("false")),
        ("transport/shared_memory/enabled", String::from("false")),
        ("transport/link/rx/max_message_size", (64 << 20).to_string()),
        (&format!("{end}/endpoints"), format!("[\"{endpoint}\"]")),
    ] {
        config
            .insert_json5(key, &value)
            .map_err(|error| anyhow!("{key}: {error}"))?;
    }
    let open = std::thread::spawn(move || {
        // A system that refuses the niceness also refuses it to the link.
        let _ = rustix::process::nice(NICE);
        zenoh::open(config).wait()
    });
    let opened = open.join().map_err(|_| anyhow!("Zenoh panicked"))?;
    opened.map_err(|error| anyhow!("{error}"))
}

/// The other process; killed when dropped.
struct Listener(Child);

impl Listener {
    /// Starts the process and waits until it listens.
    fn start(folder: &Path) -> Result<Self> {
        let mut command = Command::new(std::env::current_exe()?);
        command
            .arg(LISTEN)
            .arg(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        let mut listener = Self(command.spawn()?);
        let mut ready = [0; 6];
        let stdout = listener.0.stdout.as_mut().context("its output is piped")?;
        stdout
            .read_exact(&mut ready)
            .context("the other process does not listen")?;
        Ok(listener)
    }

    /// Ends the process and returns its times.
    fn end(&mut self) -> Result<Received> {
        drop(self.0.stdin.take());
        let mut output = String::new();
        self.0
            .stdout
            .take()
            .context("its output is piped")?
            .read_to_string(&mut output)?;
        Ok(serde_json::from_str(&output)?)
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        // The process may have ended before.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
