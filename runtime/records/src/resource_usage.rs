//! The resources of the whole process. The share of a single schema cannot be measured: schemas share one
//! heap.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The resources of the process at one instant. A value that the system does not provide is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ResourceUsage {
    /// Files, sockets and devices that are open.
    pub files: u64,
    /// Bytes of memory in use.
    pub memory: u64,
}

impl ResourceUsage {
    /// Measures this process now, through the kernel's `/proc`.
    #[must_use]
    pub fn now() -> Self {
        let files = std::fs::read_dir("/proc/self/fd").map_or(0, |files| files.count() as u64);
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let kilobytes = resident.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        Self {
            // One of the open files is the folder just read.
            files: files.saturating_sub(1),
            memory: kilobytes.unwrap_or(0) * 1024,
        }
    }
}

impl fmt::Display for ResourceUsage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} files open, {:.1} MB of memory",
            self.files,
            self.memory as f64 / 1e6
        )
    }
}
