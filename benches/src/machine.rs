//! Describes the machine on which the figures were measured. Changes nothing.

use std::fs;

use serde::Serialize;

/// The facts that a reader needs to judge the figures.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Machine {
    /// The name of the processor's model.
    processor: String,
    /// The number of processors that this process may use.
    processors: usize,
    /// The size of the memory, bytes.
    memory: u64,
    /// The version of the kernel.
    kernel: String,
    /// The compiler that built the benches.
    compiler: String,
    /// The load average of the last minute before the measurement. Figures of a busy
    /// machine are less reliable.
    load: f64,
}

impl Machine {
    pub(crate) fn current() -> Self {
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

    /// Returns the description as one line.
    pub(crate) fn summary(&self) -> String {
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

/// Returns the version number alone, without the suffix of the kernel's builder.
fn version(release: &str) -> &str {
    let other = |letter: char| letter != '.' && !letter.is_ascii_digit();
    release.split(other).next().unwrap_or_default()
}
