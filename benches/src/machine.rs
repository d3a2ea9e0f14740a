//! What machine this is, for whoever reads figures later. Changes nothing.

use std::fs;

use serde::Serialize;

/// Facts without which a figure says little.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Machine {
    /// As the processor calls itself.
    processor: String,
    /// Processors that this process may use.
    processors: usize,
    /// Bytes of memory.
    memory: u64,
    /// The version of the kernel.
    kernel: String,
    /// The compiler of the benches.
    compiler: String,
    /// Processes that wanted to run during the last minute, on average, before anything was measured: figures of a machine that is
    /// busy with something else are worth less.
    load: f64,
}

impl Machine {
    pub(crate) fn here() -> Self {
        let read = |file: &str| fs::read_to_string(file).unwrap_or_default();
        let field = |text: &str, name: &str| {
            let line = text.lines().find(|line| line.starts_with(name));
            line.and_then(|line| line.split_once(':'))
                .map(|(_, value)| value.trim().to_owned())
        };
        let kib = field(&read("/proc/meminfo"), "MemTotal").unwrap_or_default();
        Self {
            processor: field(&read("/proc/cpuinfo"), "model name").unwrap_or_default(),
            processors: std::thread::available_parallelism().map_or(0, usize::from),
            memory: kib
                .split(' ')
                .next()
                .and_then(|kib| kib.parse::<u64>().ok())
                .unwrap_or(0)
                * 1024,
            kernel: version(&read("/proc/sys/kernel/osrelease")).to_owned(),
            compiler: env!("JDE_BENCH_COMPILER").to_owned(),
            load: read("/proc/loadavg")
                .split(' ')
                .next()
                .and_then(|load| load.parse().ok())
                .unwrap_or(f64::NAN),
        }
    }

    /// In a line.
    pub(crate) fn words(&self) -> String {
        format!(
            "{} processors of {}, {} GB, Linux {}, {}; load {} before",
            self.processors,
            self.processor,
            self.memory / 1_000_000_000,
            self.kernel,
            self.compiler,
            self.load
        )
    }
}

/// The version alone: what follows it is whoever built the kernel.
fn version(release: &str) -> &str {
    let other = |letter: char| letter != '.' && !letter.is_ascii_digit();
    release.split(other).next().unwrap_or_default()
}
