//! A host that gets nothing more of a resource: its limits become what it uses.

use anyhow::{Context as _, Result, bail};
use rustix::process::{Pid, Resource, Rlimit, getrlimit, prlimit};

use super::host::HostProcess;
use crate::plan::Kind;

impl HostProcess {
    /// Lets the process obtain nothing more of what `kind` names, until it is [relieved](Self::relieve). A thread takes memory for its stack, and the superuser
    /// may have any number of threads, so for threads it is the memory too.
    pub(super) fn exhaust(&self, kind: Kind) -> Result<()> {
        for resource in resources(kind)? {
            self.limit(*resource, Some(used(self.number(), *resource)?))?;
        }
        Ok(())
    }

    /// Lets it obtain everything again.
    pub(super) fn relieve(&self, kind: Kind) -> Result<()> {
        for resource in resources(kind)? {
            self.limit(*resource, getrlimit(*resource).maximum)?;
        }
        Ok(())
    }

    fn limit(&self, resource: Resource, current: Option<u64>) -> Result<()> {
        let process = Pid::from_raw(self.number().cast_signed()).context("the process has no id")?;
        // The greatest limit is that of this process, whose child it is.
        let maximum = getrlimit(resource).maximum;
        prlimit(Some(process), resource, Rlimit { current, maximum }).context("no limit can be set")?;
        Ok(())
    }
}

fn resources(kind: Kind) -> Result<&'static [Resource]> {
    match kind {
        Kind::NoDescriptors => Ok(&[Resource::Nofile]),
        Kind::NoThreads => Ok(&[Resource::Nproc, Resource::As]),
        Kind::NoMemory => Ok(&[Resource::As, Resource::Data]),
        kind => bail!("{kind:?} exhausts nothing"),
    }
}

fn used(process: u32, resource: Resource) -> Result<u64> {
    let kilobytes = |key: &str| -> Result<u64> {
        let status = std::fs::read_to_string(format!("/proc/{process}/status"))?;
        let line = status.lines().find_map(|line| line.strip_prefix(key));
        let size = line.with_context(|| format!("no {key} in the status of a process"))?;
        Ok(1024 * size.trim().trim_end_matches(" kB").parse::<u64>()?)
    };
    match resource {
        // The first number that no descriptor has: one that is freed below it can be used again.
        Resource::Nofile => {
            let is_free =
                |number: &u64| std::fs::symlink_metadata(format!("/proc/{process}/fd/{number}")).is_err();
            (0..).find(is_free).context("some number is free")
        }
        Resource::As => kilobytes("VmSize:"),
        Resource::Data => kilobytes("VmData:"),
        _ => Ok(1),
    }
}
