//! What runs under the rules' lock, and what prints for it, neither logs under it nor panics on purpose: a thread that
//! waits or panics there keeps everything from stopping.

use super::tree::{File, Tree, Violation};

/// The places that must not panic: transactions and what they call of the host, the supervisor, and the way of a message
/// to its stream.
const NEVER_PANIC: &[&str] = &[
    "runtime/host/src/engine/operators/",
    "runtime/host/src/engine/rules/",
    "runtime/host/src/exec/supervisor.rs",
    "runtime/host/src/stalls.rs",
    "programs/session/src/log/",
    "programs/session/src/run/collector.rs",
    "programs/terminal/",
    "observe/link/src/server/events.rs",
    "observe/link/src/server/stop_socket.rs",
];
/// Whatever ends in a panic.
const PANICS: &[&str] = &[
    ".unwrap()",
    ".expect(",
    "panic!(",
    "unreachable!(",
    "unimplemented!(",
];

/// The places under the lock. Transactions leave what they have to say in `messages.rs`.
const UNDER_LOCK: &[&str] = &[
    "runtime/host/src/engine/operators/",
    "runtime/host/src/engine/rules/",
    "programs/session/src/run/collector.rs",
];
const LOGS_AFTER: &str = "runtime/host/src/engine/rules/messages.rs";
/// Whatever logs.
const LOGS: &[&str] = &[
    "tracing::trace!",
    "tracing::debug!",
    "tracing::info!",
    "tracing::warn!",
    "tracing::error!",
];

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.rust().flat_map(check_file).collect()
}

fn check_file(file: &File) -> Vec<Violation> {
    let path = file.path.as_str();
    let is_in = |places: &[&str]| places.iter().any(|place| path.starts_with(place));
    let mut found = Vec::new();
    let mut find = |ways: &[&str], what: &str, help: &str| {
        for (number, line) in file.numbered().filter(|(_, line)| !line.test) {
            for way in ways.iter().filter(|way| line.code.contains(**way)) {
                found.push(Violation::new(path, number, format!("`{way}`: {what}"), help));
            }
        }
    };
    if is_in(NEVER_PANIC) {
        let what = "a panic here leaves the robot without its rules, or without its messages";
        find(PANICS, what, "handle the case: the robot must still stop in it");
    }
    if is_in(UNDER_LOCK) && path != LOGS_AFTER {
        let what = "this runs under the rules' lock, and a log may wait, fail or panic";
        find(
            LOGS,
            what,
            "leave a `Message`, which is logged once the lock is free",
        );
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(path: &str, code: &str) -> usize {
        check_file(&File::new(path, format!("fn a() {{ {code}; }}\n"))).len()
    }

    #[test]
    fn panics_and_logs_under_the_lock_are_found() {
        let rules = "runtime/host/src/engine/rules/transact.rs";
        for code in [
            "put.expect(\"it\")",
            "put.unwrap()",
            "unreachable!(\"it\")",
            "tracing::warn!(\"it\")",
        ] {
            assert_eq!(count(rules, code), 1, "{code}");
            assert_eq!(count("runtime/host/src/engine/rules/tests.rs", code), 0, "{code}");
            assert_eq!(count("runtime/host/src/runner/mod.rs", code), 0, "{code}");
        }
    }

    #[test]
    fn code_that_handles_the_case_passes() {
        let rules = "runtime/host/src/engine/rules/transact.rs";
        for code in [
            "lock.unwrap_or_else(PoisonError::into_inner)",
            "// put.expect(it)",
            "debug_assert!(put.is_ok())",
        ] {
            assert_eq!(count(rules, code), 0, "{code}");
        }
        assert_eq!(count(LOGS_AFTER, "tracing::warn!(\"it\")"), 0);
        assert_eq!(
            count("runtime/host/src/exec/supervisor.rs", "tracing::error!(\"it\")"),
            0
        );
    }
}
