//! Limits on the resources of a child, as far as the system supports them. The child limits itself, after its
//! plugin is loaded and before any of the plugin's functions runs. No limit can be removed later, except that
//! of processor time, which each call renews.

use std::collections::BTreeMap;

use landlock::{
    ABI, AccessFs, CompatLevel, Compatible, PathBeneath, PathFd, Ruleset, RulesetAttr, RulesetCreatedAttr,
    RulesetError, RulesetStatus,
};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use rustix::time::{ClockId, clock_gettime};
use seccompiler::{
    BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter, SeccompRule,
};

use jde_app::Isolation;

/// Sockets of this family cannot connect to other machines.
const AF_UNIX: u64 = libc::AF_UNIX as u64;

/// Limits this process. Returns each limit that could not be set, and the reason.
pub(crate) fn apply(limits: Isolation) -> Vec<String> {
    let mut failed = Vec::new();
    let mut record = |resource: &str, result: Result<(), String>| {
        if let Err(reason) = result {
            failed.push(format!("its {resource} cannot be limited: {reason}"));
        }
    };
    if let Some(bytes) = limits.memory {
        record("memory", limit_memory(bytes));
    }
    if let Some(seconds) = limits.cpu {
        record("processor time", limit_cpu(seconds));
    }
    // Set before the network limit: creating these rules opens files and needs no sockets.
    if limits.read_only {
        record("writing of files", forbid_writing());
    }
    if !limits.network {
        record("network", forbid_network());
    }
    failed
}

/// Renews the processor time for a call.
pub(crate) fn renew(limits: Isolation) {
    if let Some(seconds) = limits.cpu {
        // Setting the limit again fails only if `apply` failed and reported it.
        drop(limit_cpu(seconds));
    }
}

/// Limits the heap, stacks and other private memory, but neither shared memory nor mapped files.
fn limit_memory(bytes: u64) -> Result<(), String> {
    let limit = Rlimit {
        current: Some(bytes),
        maximum: Some(bytes),
    };
    setrlimit(Resource::Data, limit).map_err(|error| error.to_string())
}

/// Limits the processor time from now on. The kernel counts whole seconds since the process began, so the
/// time used until now is added.
fn limit_cpu(seconds: u64) -> Result<(), String> {
    let used = clock_gettime(ClockId::ProcessCPUTime);
    let used = used.tv_sec as u64 + u64::from(used.tv_nsec > 0);
    let limit = Rlimit {
        current: Some(used + seconds),
        maximum: getrlimit(Resource::Cpu).maximum,
    };
    setrlimit(Resource::Cpu, limit).map_err(|error| error.to_string())
}

/// Prevents that files are opened for writing, created, moved or removed, except `/dev/null`.
fn forbid_writing() -> Result<(), String> {
    // Version 3 of the kernel's interface covers all ways to change a file.
    let writing = AccessFs::from_write(ABI::V3);
    let restrict = || -> Result<RulesetStatus, RulesetError> {
        let rules = Ruleset::default()
            .set_compatibility(CompatLevel::BestEffort)
            .handle_access(writing)?
            .create()?;
        let null = PathFd::new("/dev/null").map(|file| PathBeneath::new(file, AccessFs::WriteFile));
        let rules = match null {
            Ok(rule) => rules.add_rule(rule)?,
            Err(_) => rules,
        };
        Ok(rules.restrict_self()?.ruleset)
    };
    match restrict() {
        Ok(RulesetStatus::FullyEnforced) => Ok(()),
        Ok(RulesetStatus::PartiallyEnforced) => Err(String::from(
            "this kernel's landlock is older than Linux 6.2 and permits some ways to change files",
        )),
        Ok(RulesetStatus::NotEnforced) => {
            Err(String::from("this kernel has no landlock, or it is switched off"))
        }
        Err(error) => Err(error.to_string()),
    }
}

/// Prevents that sockets are created except Unix sockets, and `io_uring`, which could create one without the
/// filter.
fn forbid_network() -> Result<(), String> {
    let filter = || -> Result<BpfProgram, seccompiler::BackendError> {
        let not_unix = SeccompCondition::new(0, SeccompCmpArgLen::Dword, SeccompCmpOp::Ne, AF_UNIX)?;
        let rules = BTreeMap::from([
            (libc::SYS_socket, vec![SeccompRule::new(vec![not_unix])?]),
            (libc::SYS_io_uring_setup, Vec::new()),
        ]);
        let refusal = SeccompAction::Errno(libc::EACCES as u32);
        let arch = std::env::consts::ARCH.try_into()?;
        SeccompFilter::new(rules, SeccompAction::Allow, refusal, arch)?.try_into()
    };
    let filter = filter().map_err(|error| error.to_string())?;
    // Applied to all threads: the plugin's library may have started some.
    seccompiler::apply_filter_all_threads(&filter).map_err(|error| error.to_string())
}
