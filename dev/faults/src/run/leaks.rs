//! The resources of this process: threads, open files, children, memory. An application must release all
//! of them when it ends.

use std::path::Path;
use std::time::Duration;

use super::wait_within;

/// Longest time for an abandoned thread to return: a slow call returns after 0.9 s, plus delays under load.
const RETURN_TIMEOUT: Duration = Duration::from_secs(5);
/// Allowed growth of the process per case, bytes: heap fragmentation.
const GROWTH_PER_CASE: u64 = 96 << 10;
/// Allowed growth after the warm-up however many cases follow, bytes: cases of one kind differ in what they
/// need at most.
const GROWTH_AFTER_WARM_UP: u64 = 2 << 20;
/// Cases until the heap has reached the size that one case needs.
const WARMUP_CASES: u64 = 10;
/// Memory of a call that never returns, bytes: its stack, its part of the heap, and the variables of its
/// application that it may still access.
const LEFTOVER_BYTES: u64 = 4 << 20;

/// The resources before and after cases.
#[derive(Default)]
pub struct LeakDetector {
    before: Option<ResourceCounts>,
    cases: u64,
    /// Cases of the current kind: their number, and, once warm, the resident memory with the number of
    /// abandoned calls.
    similar: u64,
    warm: Option<(u64, u64)>,
    leftovers: Leftovers,
    grown: Option<String>,
}

/// What calls that never return keep of an application that has ended.
#[derive(Clone, Copy, Debug, Default)]
pub struct Leftovers {
    /// The number of such calls; each keeps its thread.
    pub calls: u64,
    /// Most files: the memory that the application shared with processes of schemas.
    pub files: u64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct ResourceCounts {
    threads: u64,
    files: u64,
    children: u64,
}

impl LeakDetector {
    /// Whether the first case has run.
    #[must_use]
    pub fn has_begun(&self) -> bool {
        self.before.is_some()
    }

    /// Records the resources after the first case, which created what all cases share.
    pub fn begin(&mut self, leftovers: Leftovers) {
        let now = ResourceCounts::now();
        self.cases = 1;
        self.leftovers = leftovers;
        self.before = Some(ResourceCounts {
            threads: now.threads.saturating_sub(leftovers.calls),
            files: now.files.saturating_sub(leftovers.files),
            ..now
        });
    }

    /// Judges a case; returns the resources that leaked.
    pub fn judge(&mut self, leftovers: Leftovers) -> Vec<String> {
        let Some(before) = self.before else {
            return Vec::new();
        };
        self.leftovers.calls += leftovers.calls;
        self.leftovers.files += leftovers.files;
        let allowed = ResourceCounts {
            threads: before.threads + self.leftovers.calls,
            files: before.files + self.leftovers.files,
            ..before
        };
        let is_allowed = |now: ResourceCounts| {
            now.threads <= allowed.threads && now.files <= allowed.files && now.children <= allowed.children
        };
        let mut violations = Vec::new();
        if !wait_within(RETURN_TIMEOUT, || is_allowed(ResourceCounts::now())) {
            let now = ResourceCounts::now();
            violations.push(format!(
                "leak: {} threads, {} files and {} children, where {}, {} and {} are allowed",
                now.threads, now.files, now.children, allowed.threads, allowed.files, allowed.children
            ));
            // Reported once: later cases are compared with the current state.
            self.before = Some(ResourceCounts {
                threads: now.threads.saturating_sub(self.leftovers.calls),
                files: now.files.saturating_sub(self.leftovers.files),
                ..now
            });
        }
        self.cases += 1;
        self.similar += 1;
        if self.similar == WARMUP_CASES {
            self.warm = Some((resident(), self.leftovers.calls));
        }
        violations
    }

    /// Prepares for cases of another kind, with other threads and another heap.
    pub fn warms_up(&mut self) {
        self.check_memory();
        (self.similar, self.warm) = (0, None);
    }

    /// The growth of the process with cases of one kind, if it exceeds the allowed amount. Called at the end.
    #[must_use]
    pub fn conclude(&mut self) -> Option<String> {
        self.check_memory();
        self.grown.take()
    }

    fn check_memory(&mut self) {
        let Some((warm, warm_calls)) = self.warm else {
            return;
        };
        let (cases, calls) = (self.similar - WARMUP_CASES, self.leftovers.calls - warm_calls);
        let (allowed, now) = (
            warm + GROWTH_AFTER_WARM_UP + GROWTH_PER_CASE * cases + LEFTOVER_BYTES * calls,
            resident(),
        );
        if now > allowed {
            self.grown.get_or_insert(format!(
                "leak: {:.1} MB of memory after {cases} cases, where {:.1} MB are allowed",
                now as f64 / 1e6,
                allowed as f64 / 1e6
            ));
        }
    }

    /// "118 cases in this process: 44.0 MB at the end".
    #[must_use]
    pub fn summary(&self) -> String {
        format!(
            "{} cases in this process: {:.1} MB at the end; {} calls that never returned keep a thread each",
            self.cases,
            resident() as f64 / 1e6,
            self.leftovers.calls
        )
    }
}

impl ResourceCounts {
    fn now() -> Self {
        let status = read("/proc/self/status");
        let threads = status.lines().find_map(|line| line.strip_prefix("Threads:"));
        let processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
        let children = processes.filter(|process| is_descendant(&process.path()));
        // The copy of a plugin is held open for ever, as its library is mapped for ever.
        let is_copy = |file: &std::path::Path| {
            let target = std::fs::read_link(file).unwrap_or_default();
            target.to_string_lossy().contains(".so")
        };
        let files = std::fs::read_dir("/proc/self/fd").into_iter().flatten().flatten();
        let files = files.filter(|file| !is_copy(&file.path())).count() as u64;
        Self {
            threads: threads.and_then(|number| number.trim().parse().ok()).unwrap_or(0),
            files,
            children: children.count() as u64,
        }
    }
}

/// Whether a process is a child of this one, or comes from one, wherever it belongs now.
fn is_descendant(process: &Path) -> bool {
    let own = std::process::id();
    let status = std::fs::read_to_string(process.join("status")).unwrap_or_default();
    let father = status.lines().find_map(|line| line.strip_prefix("PPid:"));
    if father.is_some_and(|father| father.trim() == own.to_string()) {
        return true;
    }
    // The mark that the host gives to what it starts.
    let environment = std::fs::read(process.join("environ")).unwrap_or_default();
    let mut variables = environment.split(|byte| *byte == 0);
    variables.any(|variable| {
        let marks = String::from_utf8_lossy(variable);
        let marks = marks.strip_prefix("JDE_PROCESSES=").unwrap_or_default();
        marks.split(' ').any(|mark| mark.starts_with(&format!("{own}.")))
    })
}

fn resident() -> u64 {
    let status = read("/proc/self/status");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
    kilobytes.unwrap_or(0) * 1024
}

fn read(path: &str) -> String {
    std::fs::read_to_string(path).unwrap_or_default()
}
