//! Runs a case in this process: an application runs, faults are injected at their times, and the observer
//! judges it throughout.

mod act;
mod baseline;
mod leaks;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use jde_core::{Nanos, SchemaId};
use jde_host::{Handle, Lockstep, Options, Running};
use jde_isolation::Program;
use jde_loader::{LoadedPlugin, Plugins};

use crate::application::{self, TestApplication};
use crate::case::{Case, RunMode};
use crate::observer::{ABANDONED_AT_END, CALL_ABANDONED, CALL_RETURNED, Observer, Symptom, Tamper};
use crate::plan::{Act, Kind, PlannedFault};
use baseline::BaselineThread;
pub(crate) use baseline::is_machine_loaded;
pub use leaks::{LeakDetector, Leftovers};

/// The argument with which this program runs as the process of one schema.
pub const SERVE: &str = "--serve-schema";

const MS: Nanos = 1_000_000;
/// Time between two judgements.
const JUDGEMENT_INTERVAL: Nanos = 10 * MS;
/// Time for which an application continues after the last fault: longer than the back-off after some faults,
/// and than a validity.
const TIME_AFTER_FAULTS: Nanos = 1_600 * MS;
/// Longest time from a fault's end to its consequences: a hang is found after 300 ms, and a slow call
/// returns after 900 ms.
const SYMPTOM_TIMEOUT: Nanos = 1_000 * MS;
/// How long slow calls may take to return after the application has ended.
const RETURN_TIMEOUT: Duration = Duration::from_secs(5);
/// The number of other builds of the plugin: the same code in different files, each mapped once.
const OTHER_BUILDS: usize = 3;

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
pub struct CaseResult {
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
    pub fault: PlannedFault,
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
        for number in 0..OTHER_BUILDS {
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
/// The case could not run. This is not a verdict.
pub fn run(
    resources: &Resources,
    case: Case,
    test_application: &TestApplication,
    plan: Vec<PlannedFault>,
    run_options: RunOptions,
    stop: &AtomicBool,
) -> Result<CaseResult> {
    let application = test_application.application(&resources.plugins, run_options.seed)?;
    let mut observer = Observer::new(case.clock, run_options.tamper);
    let mut options = Options {
        isolation_program: Some(Program {
            path: "/proc/self/exe".into(),
            arguments: vec![SERVE.into()],
        }),
        ..Options::default()
    };
    observer.watch(&mut options);
    let mut run = match case.clock {
        RunMode::Lockstep => Run::Lockstep(Lockstep::start(application, &resources.plugins, options)?),
        RunMode::RealTime | RunMode::Outside => {
            Run::RealTime(Running::start(application, &resources.plugins, options)?)
        }
    };
    let handle = run.handle();
    let variables: Vec<_> = handle
        .board()
        .list()
        .map(|variable| std::sync::Arc::downgrade(&variable))
        .collect();
    let held_variable = match run_options.tamper {
        Some(Tamper::Held) => handle.board().list().next(),
        _ => None,
    };
    // The variables that processes of schemas share, and the table of authority for these processes.
    let shared = handle
        .board()
        .list()
        .filter(|variable| variable.shared().is_some())
        .count() as u64;
    let instances = &handle.application().instances;
    let shared = shared + u64::from(instances.iter().any(|instance| instance.isolate.is_some()));
    let bare = matches!(run, Run::RealTime(_)).then(BaselineThread::start);
    let mut active: Vec<Option<act::ActiveFault>> = plan.iter().map(|_| None).collect();
    let mut took_effect = vec![false; plan.len()];
    let mut found = Vec::new();
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
        if !run.run_until(time, &handle, &mut observer, stop) {
            break;
        }
        let fault = &plan[number];
        if !begins {
            if let Some(active) = &mut active[number] {
                took_effect[number] = act::end(fault, &handle, active);
                found.extend(active.violation());
                if !fault.stays {
                    observer.recovers(active.schema, fault.ends() + SYMPTOM_TIMEOUT);
                }
            }
        } else if let Some(schema) = act::victim(fault, test_application, &handle) {
            observer.excuse(schema);
            active[number] = Some(act::begin(
                fault,
                schema,
                &handle,
                &resources.builds,
                run_options.tamper,
            ));
        }
    }
    let end = plan.iter().map(PlannedFault::ends).max().unwrap_or(0) + TIME_AFTER_FAULTS;
    run.run_until(end, &handle, &mut observer, stop);
    observer.judge_recovery(&handle);
    let ended = handle.outcome();
    let bare = bare.map(BaselineThread::end);
    let judged = bare.filter(|bare| run_options.rhythm && !bare.is_machine_loaded);
    if let Some(bare) = judged {
        observer.conclude(bare.lost);
    }
    observer.set_ended();
    let name = |active: &act::ActiveFault| handle.application().instances[active.schema].name.clone();
    let targets: Vec<Option<String>> = active.iter().map(|active| active.as_ref().map(name)).collect();
    drop(handle);
    drop(run);
    let symptoms = observer.symptoms();
    for (number, fault) in plan.iter().enumerate() {
        let has_symptom = |active: &act::ActiveFault| {
            symptoms
                .iter()
                .any(|symptom| is_symptom_of(symptom, fault, active.schema))
        };
        took_effect[number] |= active[number].as_ref().is_some_and(has_symptom);
    }
    let mut violations = observer.violations();
    violations.extend(found);
    if let Some(outcome) = ended.filter(|_| !stop.load(Ordering::Relaxed)) {
        violations.push(format!("the application ended by itself: {}", outcome.message()));
    }
    // Slow calls return and release everything; calls that hang do not.
    let count = |what: &str| {
        observer
            .symptoms()
            .iter()
            .filter(|symptom| symptom.what == what)
            .count() as u64
    };
    let abandoned = || count(CALL_ABANDONED).saturating_sub(count(CALL_RETURNED));
    let held = || {
        variables
            .iter()
            .filter(|variable| variable.strong_count() > 0)
            .count()
    };
    let all_released = wait_within(RETURN_TIMEOUT, || held() == 0);
    let hangs = plan.iter().any(|fault| fault.kind == Kind::Hang);
    let never_returned = if hangs {
        abandoned() + count(ABANDONED_AT_END)
    } else {
        0
    };
    if !all_released && never_returned == 0 {
        violations.push(format!(
            "leak: {} variables of an application that has ended are still referenced",
            held()
        ));
    }
    drop(held_variable);
    if !hangs && abandoned() > 0 {
        violations.push(format!(
            "leak: {} abandoned calls never returned, and none was to hang",
            abandoned()
        ));
    }
    let faults = plan.into_iter().zip(targets).zip(took_effect);
    let faults = faults.map(|((fault, target), took_effect)| Injected {
        fault,
        target,
        took_effect,
    });
    Ok(CaseResult {
        case,
        faults: faults.collect(),
        violations,
        min_turn_share: judged.and_then(|_| observer.min_turn_share()),
        rhythm: bare.map(|_| judged.is_some()),
        leftovers: Leftovers {
            calls: never_returned,
            files: if never_returned > 0 { shared } else { 0 },
        },
    })
}

/// Whether a symptom is a consequence of this fault.
fn is_symptom_of(symptom: &Symptom, fault: &PlannedFault, schema: SchemaId) -> bool {
    let is_operation = matches!(fault.act, Act::Operate(_));
    symptom.schema == schema
        && (symptom.what != "operated" || is_operation)
        && (fault.at..=fault.ends() + SYMPTOM_TIMEOUT).contains(&symptom.time)
}

impl Run {
    fn handle(&self) -> Handle {
        match self {
            Self::Lockstep(lockstep) => lockstep.handle(),
            Self::RealTime(running) => running.handle(),
        }
    }

    /// Runs until `time`, and judges meanwhile. Returns `false` if the application ended before.
    fn run_until(
        &mut self,
        time: Nanos,
        handle: &Handle,
        observer: &mut Observer,
        stop: &AtomicBool,
    ) -> bool {
        loop {
            let now = handle.now();
            if now >= time {
                return true;
            }
            if handle.outcome().is_some() || stop.load(Ordering::Relaxed) {
                return false;
            }
            let next = time.min(now + JUDGEMENT_INTERVAL);
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
