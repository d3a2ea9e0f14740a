//! The checks: the promises of the ABI, by name.

#![allow(unsafe_code)]

use std::collections::BTreeSet;
use std::fs;
use std::time::{Duration, Instant};

use jde_abi::describe::Role;
use jde_abi::raw;
use jde_loader::instance::{SavedMemory, memory_of};
use jde_loader::{Judge, Judgement};

use crate::CheckResult;
use crate::bench::Circumstances;
use crate::life::{Account, FailedCall, Life, Subject, USUAL};

/// A promise of the ABI, and how it is checked.
pub struct Check {
    /// Its name.
    pub name: &'static str,
    /// The promise.
    pub promise: &'static str,
    pub(crate) run: fn(Subject<'_>) -> CheckResult,
}

/// The check of the whole file, before any other.
pub(crate) const LOADS: &str = "loads";
/// The check in which no call may last.
pub(crate) const RETURNS: &str = "returns";
/// The check in which no call may end the process by a signal.
pub(crate) const SURVIVES: &str = "survives";
/// The check in which no call may end the process otherwise.
pub(crate) const STAYS: &str = "stays";

/// The lives after which an instance may leave nothing more behind.
const WARM_UP: usize = 3;
/// The lives after that.
const LIVES_PER_ROUND: usize = 24;
/// How many times that many lives are counted.
const COUNTED_ROUNDS: usize = 3;
/// The memory that each of these may leave: an allocator keeps some for itself.
const MAX_LEAK: usize = 512;
/// How long threads may take to end.
const THREADS_END: Duration = Duration::from_secs(1);

macro_rules! checks {
    ($($name:literal, $promise:literal, $run:expr;)*) => {
        /// All checks, in the order in which they run.
        pub const CHECKS: &[Check] = &[$(Check { name: $name, promise: $promise, run: $run }),*];
    };
}

checks! {
    "loads", "the file is a plugin whose description is valid", |_| CheckResult::Ok;
    "documented", "the plugin's types and ports say what they are", documented;
    "survives", "no call ends in a crash or an abort", lives;
    "stays", "no call ends the process", lives;
    "returns", "every call returns", lives;
    "creates", "`create` returns an instance, or says why not", creates;
    "statuses", "calls return statuses of jde.h", statuses;
    "reasons", "a call that fails says why", reasons;
    "panics", "no call panics", panics;
    "ports", "requests name ports and children that exist, as their kind allows", |subject| breaches(subject, "ports");
    "loans", "only loaned memory is published", |subject| breaches(subject, "loans");
    "values", "published numbers, sequences and texts are valid", |subject| breaches(subject, "values");
    "times", "no value is measured in the future", |subject| breaches(subject, "times");
    "calls", "the host is asked during calls only, on their thread", |subject| breaches(subject, "calls");
    "checks", "`check` commands nothing and wakes nobody", |subject| breaches(subject, "checks");
    "preconditions", "the urgency is a finite number", |subject| breaches(subject, "preconditions");
    "no-values", "imports without a value are no fault", |subject| compare(subject, |usual| usual.has_values = false);
    "unbound", "optional ports and children without a binding are no fault", |subject| compare(subject, |usual| usual.is_bound = false);
    "refused", "a command that is refused is no fault", |subject| compare(subject, |usual| usual.has_authority = false);
    "old-host", "a host of minor version 0 suffices, or the call that needs a later one says so", |subject| compare(subject, |usual| usual.is_old = true);
    "again", "an instance awakes again after it slept", again;
    "instances", "two instances live at once, and one outlives the other", instances;
    "repeats", "the same seed and inputs give the same values", repeats;
    "threads", "an instance that ended leaves no thread", threads;
    "files", "an instance that ended leaves no open file", files;
    "memory", "an instance that ended leaves no memory", memory;
    "process", "signal handlers and the working folder stay as they are", process;
    "silent", "nothing is printed past the log", lives;
    "panel", "the panel can be shown", |subject| if subject.schema.panel { breaches(subject, "panel") } else { skipped("it has no panel") };
    "drawing", "drawing the panel changes nothing", |subject| if subject.schema.panel { breaches(subject, "drawing") } else { skipped("it has no panel") };
    "state", "saved memory can be restored, and neither changes anything", state;
    "arbitrates", "a father chooses a candidate or none, and says why", |subject| if subject.schema.arbitrates { breaches(subject, "arbitrates") } else { skipped("it does not arbitrate") };
    "inspects", "an inspection changes nothing, and names modulations", inspects;
    "judges", "a guard's judgement depends on its arguments alone, and a refusal says why", judges;
}

fn skipped(words: &str) -> CheckResult {
    CheckResult::Skipped(words.to_owned())
}

fn verdict(failed: Option<String>) -> CheckResult {
    failed.map_or(CheckResult::Ok, CheckResult::Failed)
}

/// Lives without values and with them: such lives show most.
fn accounts(subject: Subject<'_>) -> [Account; 2] {
    [false, true].map(|has_values| subject.live(Circumstances { has_values, ..USUAL }))
}

fn lives(subject: Subject<'_>) -> CheckResult {
    let _ = accounts(subject);
    // A crash may need the answers that other hosts give.
    for (is_bound, has_authority) in [(false, true), (true, false)] {
        let _ = subject.live(Circumstances {
            is_bound,
            has_authority,
            ..USUAL
        });
    }
    CheckResult::Ok
}

fn documented(subject: Subject<'_>) -> CheckResult {
    let schema = subject.schema;
    let port = schema.ports.iter().find(|port| port.doc.trim().is_empty());
    let child = schema.children.iter().find(|child| child.doc.trim().is_empty());
    verdict(if schema.doc.trim().is_empty() {
        Some(String::from("the type has no text"))
    } else {
        let name = port.map(|port| &port.name).or(child.map(|child| &child.name));
        name.map(|name| format!("`{name}` has no text"))
    })
}

fn creates(subject: Subject<'_>) -> CheckResult {
    match subject.create(USUAL) {
        Ok(_) | Err(Some(_)) => CheckResult::Ok,
        Err(None) => CheckResult::Failed(String::from(
            "`create` returned no instance, and passed no reason to `fail`",
        )),
    }
}

fn failures(subject: Subject<'_>) -> impl Iterator<Item = FailedCall> {
    accounts(subject)
        .into_iter()
        .filter_map(|account| account.failure)
}

fn statuses(subject: Subject<'_>) -> CheckResult {
    let unknown = failures(subject).find(|failure| !(raw::OK..=raw::OUT_OF_RANGE).contains(&failure.status));
    verdict(unknown.map(|FailedCall { call, status, .. }| format!("`{call}` returned {status}")))
}

fn reasons(subject: Subject<'_>) -> CheckResult {
    let is_silent = |failure: &FailedCall| {
        failure.call != "create"
            && (raw::OK..raw::PANICKED).contains(&failure.status)
            && failure.reason.is_none()
    };
    let silent = failures(subject).find(is_silent);
    verdict(silent.map(|FailedCall { call, status, .. }| {
        format!("`{call}` returned {status}, and passed no reason to `fail`")
    }))
}

fn panics(subject: Subject<'_>) -> CheckResult {
    let panicked = failures(subject).find(|failure| failure.status == raw::PANICKED);
    verdict(panicked.map(|failure| failure.to_string()))
}

fn breaches(subject: Subject<'_>, check: &str) -> CheckResult {
    let mut breaches = accounts(subject).into_iter().flat_map(|account| account.breaches);
    verdict(
        breaches
            .find(|(broken, _)| *broken == check)
            .map(|(_, words)| words),
    )
}

/// Compares the usual life with one under other circumstances, which must not fail unless the usual one does.
fn compare(subject: Subject<'_>, change: impl Fn(&mut Circumstances)) -> CheckResult {
    let mut circumstances = USUAL;
    change(&mut circumstances);
    if let Some(declined) = declined(&subject.live(USUAL)) {
        return declined;
    }
    let failure = subject.live(circumstances).failure;
    // A plugin that needs a later host says so.
    let says_so = |failure: &FailedCall| circumstances.is_old && failure.reason.is_some();
    let failure = failure.filter(|failure| !says_so(failure));
    verdict(failure.map(|failure| failure.to_string()))
}

/// Why there is nothing to see: the usual life fails, which is no breach by itself.
fn declined(account: &Account) -> Option<CheckResult> {
    let failure = account.failure.as_ref()?;
    Some(CheckResult::Skipped(failure.to_string()))
}

fn again(subject: Subject<'_>) -> CheckResult {
    let Ok(mut life) = subject.create(USUAL) else {
        return skipped("it creates no instance");
    };
    let mut failed = life.wake_up().or_else(|| life.take_turns(1));
    life.fall_asleep();
    let is_first = failed.is_some();
    for _ in 0..2 {
        failed = failed.or_else(|| {
            let failed = life.wake_up().or_else(|| life.take_turns(1));
            life.fall_asleep();
            failed
        });
    }
    let account = life.end(failed);
    match declined(&account) {
        Some(declined) if is_first => declined,
        Some(CheckResult::Skipped(words)) => CheckResult::Failed(format!("the second time, {words}")),
        _ => CheckResult::Ok,
    }
}

fn instances(subject: Subject<'_>) -> CheckResult {
    if let Some(declined) = declined(&subject.live(USUAL)) {
        return declined;
    }
    let (first, second) = (subject.create(USUAL), subject.create(USUAL));
    let (Ok(mut first), Ok(mut second)) = (first, second) else {
        return CheckResult::Failed(String::from("there can be one instance only"));
    };
    let mut failed = first.wake_up().or_else(|| second.wake_up());
    for _ in 0..2 {
        failed = failed
            .or_else(|| first.take_turns(1))
            .or_else(|| second.take_turns(1));
    }
    first.fall_asleep();
    drop(first.end(None));
    failed = failed.or_else(|| second.take_turns(1));
    second.fall_asleep();
    match declined(&second.end(failed)) {
        Some(CheckResult::Skipped(words)) => CheckResult::Failed(format!("beside another instance, {words}")),
        _ => CheckResult::Ok,
    }
}

fn repeats(subject: Subject<'_>) -> CheckResult {
    let [first, second] = [(); 2].map(|()| subject.live(USUAL));
    let differs = first.publications.len() != second.publications.len();
    let different = first
        .publications
        .iter()
        .zip(&second.publications)
        .find(|(a, b)| a != b);
    let port = different.map(|((port, _, _), _)| &subject.schema.ports[*port as usize].name);
    verdict(match port {
        Some(port) => Some(format!(
            "two lives with the same inputs published `{port}` differently"
        )),
        None => differs.then(|| String::from("of two lives with the same inputs, one published more")),
    })
}

/// Measures before and after lives that follow others.
fn growth<T>(subject: Subject<'_>, measure: impl Fn() -> T) -> (T, T) {
    (0..WARM_UP).for_each(|_| drop(subject.live(USUAL)));
    let before = measure();
    (0..LIVES_PER_ROUND).for_each(|_| drop(subject.live(USUAL)));
    (before, measure())
}

fn threads(subject: Subject<'_>) -> CheckResult {
    let count = || fs::read_dir("/proc/self/task").map_or(0, Iterator::count);
    let (before, mut after) = growth(subject, count);
    // The last may still be ending.
    let end = Instant::now() + THREADS_END;
    while after > before && Instant::now() < end {
        std::thread::yield_now();
        after = count();
    }
    verdict((after > before).then(|| format!("{LIVES_PER_ROUND} instances left {} threads", after - before)))
}

fn files(subject: Subject<'_>) -> CheckResult {
    let (before, after) = growth(subject, || {
        fs::read_dir("/proc/self/fd").map_or(0, Iterator::count)
    });
    verdict(
        (after > before).then(|| format!("{LIVES_PER_ROUND} instances left {} files open", after - before)),
    )
}

fn memory(subject: Subject<'_>) -> CheckResult {
    // SAFETY: reads statistics of the allocator.
    let allocated = || unsafe { libc::mallinfo2() };
    let left = |_| {
        let (before, after) = growth(subject, || {
            let info = allocated();
            info.uordblks + info.hblkhd
        });
        after.saturating_sub(before)
    };
    // What instances leave grows each time; what the allocator keeps for later counts as used, and does not.
    let leaks = |left: &usize| *left > LIVES_PER_ROUND * MAX_LEAK;
    let left = (0..COUNTED_ROUNDS)
        .map(left)
        .take_while(leaks)
        .collect::<Vec<_>>();
    verdict(match left[..] {
        [.., last] if left.len() == COUNTED_ROUNDS => {
            Some(format!("{LIVES_PER_ROUND} instances left {last} bytes"))
        }
        _ => None,
    })
}

fn process(subject: Subject<'_>) -> CheckResult {
    let state = || {
        let status = fs::read_to_string("/proc/thread-self/status").unwrap_or_default();
        let is_kept = |line: &&str| {
            ["SigBlk", "SigIgn", "SigCgt", "Umask"]
                .iter()
                .any(|name| line.starts_with(name))
        };
        let mut lines: BTreeSet<String> = status.lines().filter(is_kept).map(str::to_owned).collect();
        lines.extend(std::env::current_dir().map(|folder| format!("folder {}", folder.display())));
        lines
    };
    let before = state();
    drop(subject.live(USUAL));
    let after = state();
    verdict(
        after
            .difference(&before)
            .next()
            .map(|line| format!("it left behind {}", line.replace('\t', " "))),
    )
}

fn state(subject: Subject<'_>) -> CheckResult {
    let Ok(Some(table)) = memory_of(&subject.functions) else {
        return skipped("it saves no memory");
    };
    let Ok(mut life) = subject.create(USUAL) else {
        return skipped("it creates no instance");
    };
    let failed = life.wake_up().or_else(|| life.take_turns(2));
    let is_awake = failed.is_none_or(|failure| failure.call != "awake");
    let save = |life: &mut Life<'_>| {
        let Life { bench, instance, .. } = life;
        bench.call("save", |context| instance.save(context))
    };
    let ((status, saved), reason) = save(&mut life);
    let saved = match saved {
        Ok(saved) if status == raw::OK => saved,
        Ok(_) => {
            return CheckResult::Failed(format!(
                "`save` returned {status}: {}",
                reason.unwrap_or_default()
            ));
        }
        Err(error) => return CheckResult::Failed(format!("`save` failed: {error}")),
    };
    let Ok(mut next) = subject.create(USUAL) else {
        return skipped("it creates no instance");
    };
    if is_awake {
        let _ = next.wake_up();
    }
    let memory = SavedMemory {
        version: table.version,
        bytes: saved,
    };
    let restore = |life: &mut Life<'_>, memory: &SavedMemory| {
        let Life { bench, instance, .. } = life;
        bench.call("restore", |context| instance.restore(context, memory))
    };
    let (status, reason) = restore(&mut next, &memory);
    if status != raw::OK {
        return CheckResult::Failed(format!(
            "`restore` of its own memory returned {status}: {}",
            reason.unwrap_or_default()
        ));
    }
    let ((_, again), _) = save(&mut next);
    if again.as_ref() != Ok(&memory.bytes) {
        return CheckResult::Failed(String::from(
            "what it saves after `restore` is not what was restored",
        ));
    }
    // Memory of another build may be anything.
    for length in [0, memory.bytes.len() / 2] {
        let cut = SavedMemory {
            bytes: memory.bytes[..length].to_vec(),
            ..memory.clone()
        };
        if restore(&mut next, &cut).0 == raw::PANICKED {
            return CheckResult::Failed(String::from("`restore` panics on memory that is too short"));
        }
    }
    let breaches = [life.end(None), next.end(None)]
        .into_iter()
        .flat_map(|account| account.breaches);
    let mut breaches = breaches.filter(|(check, _)| *check == "state");
    verdict(breaches.next().map(|(_, words)| words))
}

fn inspects(subject: Subject<'_>) -> CheckResult {
    if !subject.schema.inspects {
        return skipped("it has no inspection");
    }
    let Ok(mut life) = subject.create(USUAL) else {
        return skipped("it creates no instance");
    };
    let Life { bench, instance, .. } = &mut life;
    let ((status, problems), reason) = bench.call("inspect", |context| instance.inspect(context));
    let foreign = problems.as_ref().ok().and_then(|problems| {
        let mut ports = problems.iter().map(|problem| problem.port);
        ports.find(|port| {
            let named = subject.schema.ports.get(*port as usize);
            let is_export = named.is_some_and(|named| matches!(named.role, Role::Export { .. }));
            !is_export && subject.schema.modulation(*port).is_none()
        })
    });
    let breach = bench
        .breaches
        .iter()
        .find(|(check, _)| *check == "inspects")
        .map(|(_, words)| words.clone());
    verdict(match (status, foreign) {
        (raw::OK, None) => problems.err().or(breach),
        (raw::OK, Some(port)) => Some(format!(
            "its inspection blames port {port}, which is neither a modulation nor an export"
        )),
        (status, _) => Some(format!(
            "`inspect` returned {status}: {}",
            reason.unwrap_or_default()
        )),
    })
}

fn judges(subject: Subject<'_>) -> CheckResult {
    let (Some(guard), Some(judge)) = (&subject.schema.guard, Judge::of(&subject.functions)) else {
        return skipped("it is not a guard");
    };
    let state = jde_loader::AlignedBytes::new(&vec![0; subject.schema.ports[guard.state].value_type.bytes]);
    for age in [0, 1_000_000_000] {
        for byte in [0, 0x3f] {
            let command = jde_loader::AlignedBytes::new(&vec![byte; guard.command.bytes]);
            // SAFETY: values of the stated types, of which every bit pattern is valid, on 64-byte boundaries.
            let judge = || unsafe { judge.judge(state.bytes(), age, command.bytes()) };
            let judged = judge();
            if judged != judge() {
                return CheckResult::Failed(String::from("it judges the same command in two ways"));
            }
            match judged {
                Judgement::Accepted => {}
                Judgement::Limited(_, reason) | Judgement::Refused(reason) => {
                    if reason.is_empty() {
                        return CheckResult::Failed(String::from(
                            "it refuses or limits a command without a reason",
                        ));
                    }
                }
            }
        }
    }
    CheckResult::Ok
}
