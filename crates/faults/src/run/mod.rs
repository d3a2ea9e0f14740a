//! Runs a case in this process: an application runs, faults are injected at their times, and the observer
//! judges it throughout.

mod act;
mod baseline;
mod leaks;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use jde_core::Nanos;
use jde_host::{Handle, Lockstep, Options, Running};
use jde_isolation::Program;
use jde_loader::{LoadedPlugin, Plugins};

use crate::application::{self, TestApplication};
use crate::case::{Case, Clock};
use crate::observer::{CAME_BACK, LEFT_AT_THE_END, LEFT_BEHIND, Observer, Symptom, Tamper};
use crate::plan::{Act, Fault, Kind};
use baseline::BaselineThread;
pub(crate) use baseline::is_machine_loaded;
pub use leaks::{LeakDetector, Leftovers};

/// The argument with which this program runs as the process of one schema.
pub const SERVE: &str = "--serve-schema";

const MS: Nanos = 1_000_000;
/// Time between two judgements.
const SLICE: Nanos = 10 * MS;
/// Time for which an application continues after the last fault: longer than the back-off after some faults,
/// and than a validity.
const TAIL: Nanos = 1_600 * MS;
/// Longest time from a fault's end to its consequences: a hang is found after 300 ms, and a dawdling call
/// returns after 900 ms.
const SYMPTOM_TIMEOUT: Nanos = 1_000 * MS;
/// How long dawdling calls may take to return after the application has ended.
const PATIENCE: Duration = Duration::from_secs(5);
/// The number of other builds of the plugin: the same code in different files, each mapped once.
const BUILDS: usize = 3;

/// The resources that all cases use.
pub struct Resources {
    /// The plugins.
    pub plugins: Plugins,
    builds: Vec<LoadedPlugin>,
    _folder: tempfile::TempDir,
}

/// How a case runs.
#[derive(Clone, Copy, Debug)]
pub struct RunOptions {
    /// The application's seed.
    pub seed: u64,
    /// Whether periods are judged in real time.
    pub rhythm: bool,
    /// False data for the observer, to test that it finds them.
    pub tamper: Option<Tamper>,
}

/// The result of a case.
#[derive(Debug)]
pub struct Report {
    /// The case.
    pub case: Case,
    /// All faults, in order.
    pub faults: Vec<Injected>,
    /// The violations.
    pub violations: Vec<String>,
    /// The least share of its turns that a bystander had in real time.
    pub min_turn_share: Option<f64>,
    /// Whether periods were judged; measured only in real time in this process.
    pub rhythm: Option<bool>,
    /// What abandoned calls that have not returned keep.
    pub leftovers: Leftovers,
}

/// An injected fault.
#[derive(Debug)]
pub struct Injected {
    /// The fault.
    pub fault: Fault,
    /// The schema; none if no schema was suitable.
    pub target: Option<String>,
    /// The fault took effect. The schema may have slept instead.
    pub took_effect: bool,
}

/// A running application of either clock.
enum Run {
    Lockstep(Lockstep),
    RealTime(Running),
}

impl Resources {
    /// Loads the plugins of these folders and the usual ones.
    ///
    /// # Errors
    /// A plugin is missing.
    pub fn new(folders: &[PathBuf]) -> Result<Self> {
        let plugins = application::plugins(folders);
        let file = application::file_of(&plugins, "fault")?;
        let folder = tempfile::tempdir().context("no folder for builds")?;
        let first = std::fs::read(&file).with_context(|| format!("cannot read {}", file.display()))?;
        let mut builds = Vec::new();
        for number in 0..BUILDS {
            // Bytes after the sections of a library are ignored: another file with the same code.
            let mut bytes = first.clone();
            bytes.extend(format!("build {number}").bytes());
            let file = folder.path().join("libfault.so");
            std::fs::write(&file, bytes).context("cannot write a build")?;
            builds.push(plugins.refresh(&file)?.plugin);
        }
        Ok(Self {
            plugins,
            builds,
            _folder: folder,
        })
    }
}

/// Runs a case; ends early when `stop` is set.
///
/// # Errors
/// The case could not run, which is no verdict.
pub fn run(
    gear: &Resources,
    case: Case,
    harness: &TestApplication,
    plan: Vec<Fault>,
    how: RunOptions,
    stop: &AtomicBool,
) -> Result<Report> {
    let application = harness.application(&gear.plugins, how.seed)?;
    let mut observer = Observer::new(case.clock, how.tamper);
    let mut options = Options {
        isolation_program: Some(Program {
            path: "/proc/self/exe".into(),
            arguments: vec![SERVE.into()],
        }),
        ..Options::default()
    };
    observer.watch(&mut options);
    let mut run = match case.clock {
        Clock::Lockstep => Run::Lockstep(Lockstep::start(application, &gear.plugins, options)?),
        Clock::RealTime | Clock::Outside => {
            Run::RealTime(Running::start(application, &gear.plugins, options)?)
        }
    };
    let handle = run.handle();
    let variables: Vec<_> = handle
        .board()
        .list()
        .map(|variable| std::sync::Arc::downgrade(&variable))
        .collect();
    let lie = match how.tamper {
        Some(Tamper::Held) => handle.board().list().next(),
        _ => None,
    };
    let shared = handle
        .board()
        .list()
        .filter(|variable| variable.shared().is_some())
        .count() as u64;
    let bare = matches!(run, Run::RealTime(_)).then(BaselineThread::start);
    let mut under: Vec<Option<act::ActiveFault>> = plan.iter().map(|_| None).collect();
    let mut struck = vec![false; plan.len()];
    let begins = plan
        .iter()
        .enumerate()
        .map(|(number, fault)| (fault.at, number, true));
    let ends = plan
        .iter()
        .enumerate()
        .map(|(number, fault)| (fault.ends(), number, false));
    let mut steps: Vec<(Nanos, usize, bool)> = begins.chain(ends).collect();
    steps.sort_by_key(|step| step.0);
    for (time, number, begins) in steps {
        if !run.go_to(time, &handle, &mut observer, stop) {
            break;
        }
        let fault = &plan[number];
        if !begins {
            if let Some(under) = &mut under[number] {
                struck[number] = act::end(fault, &handle, under);
                if !fault.stays {
                    observer.recovers(under.schema, fault.ends() + SYMPTOM_TIMEOUT);
                }
            }
        } else if let Some(place) = act::victim(fault, harness, &handle) {
            observer.excuse(place);
            under[number] = Some(act::begin(fault, place, &handle, &gear.builds));
        }
    }
    let end = plan.iter().map(Fault::ends).max().unwrap_or(0) + TAIL;
    run.go_to(end, &handle, &mut observer, stop);
    observer.judge_recovery(&handle);
    let ended = handle.outcome();
    let bare = bare.map(BaselineThread::end);
    let judged = bare.filter(|bare| how.rhythm && !bare.is_machine_loaded);
    if let Some(bare) = judged {
        observer.conclude(bare.lost);
    }
    observer.set_ended();
    let name = |under: &act::ActiveFault| handle.application().instances[under.schema].name.clone();
    let whom: Vec<Option<String>> = under.iter().map(|under| under.as_ref().map(name)).collect();
    drop(handle);
    drop(run);
    let signs = observer.symptoms();
    for (number, fault) in plan.iter().enumerate() {
        let came =
            |under: &act::ActiveFault| signs.iter().any(|sign| is_symptom_of(sign, fault, under.schema));
        struck[number] |= under[number].as_ref().is_some_and(came);
    }
    let mut broken = observer.violations();
    if let Some(outcome) = ended.filter(|_| !stop.load(Ordering::Relaxed)) {
        broken.push(format!("the application ended by itself: {}", outcome.message()));
    }
    // Dawdling calls return and release everything; hanging ones do not.
    let count = |what: &str| {
        observer
            .symptoms()
            .iter()
            .filter(|sign| sign.what == what)
            .count() as u64
    };
    let given_up = || count(LEFT_BEHIND).saturating_sub(count(CAME_BACK));
    let held = || {
        variables
            .iter()
            .filter(|variable| variable.strong_count() > 0)
            .count()
    };
    let gone = wait_within(PATIENCE, || held() == 0);
    let hangs = plan.iter().any(|fault| fault.kind == Kind::Hang);
    let left = if hangs {
        given_up() + count(LEFT_AT_THE_END)
    } else {
        0
    };
    if !gone && left == 0 {
        broken.push(format!(
            "leak: {} variables of an application that has ended are still held by somebody",
            held()
        ));
    }
    drop(lie);
    if !hangs && given_up() > 0 {
        broken.push(format!(
            "leak: {} calls that were given up never came back, and none was told to hang",
            given_up()
        ));
    }
    let faults = plan.into_iter().zip(whom).zip(struck);
    let faults = faults.map(|((fault, whom), struck)| Injected {
        fault,
        target: whom,
        took_effect: struck,
    });
    Ok(Report {
        case,
        faults: faults.collect(),
        violations: broken,
        min_turn_share: judged.and_then(|_| observer.min_turn_share()),
        rhythm: bare.map(|_| judged.is_some()),
        leftovers: Leftovers {
            calls: left,
            files: if left > 0 { shared } else { 0 },
        },
    })
}

/// Whether a sign is a consequence of this fault.
fn is_symptom_of(sign: &Symptom, fault: &Fault, place: usize) -> bool {
    let asked = matches!(fault.act, Act::Operate(_));
    sign.schema == place
        && (sign.what != "operated" || asked)
        && (fault.at..=fault.ends() + SYMPTOM_TIMEOUT).contains(&sign.time)
}

impl Run {
    fn handle(&self) -> Handle {
        match self {
            Self::Lockstep(lockstep) => lockstep.handle(),
            Self::RealTime(running) => running.handle(),
        }
    }

    /// Runs until `then` and judges on the way; returns `false` if the application ended before.
    fn go_to(&mut self, then: Nanos, handle: &Handle, observer: &mut Observer, stop: &AtomicBool) -> bool {
        loop {
            let now = handle.now();
            if now >= then {
                return true;
            }
            if handle.outcome().is_some() || stop.load(Ordering::Relaxed) {
                return false;
            }
            let next = then.min(now + SLICE);
            match self {
                Self::Lockstep(lockstep) => {
                    lockstep.run_until(next);
                }
                Self::RealTime(_) => std::thread::sleep(Duration::from_nanos(next - now)),
            }
            observer.judge(handle);
        }
    }
}

/// Polls a condition for at most `time`; returns whether it became true.
pub(crate) fn wait_within(time: Duration, mut done: impl FnMut() -> bool) -> bool {
    let until = Instant::now() + time;
    while !done() {
        if Instant::now() > until {
            return false;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    true
}
