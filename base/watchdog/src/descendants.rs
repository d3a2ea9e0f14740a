//! Ends the processes below this one, such as the robots and the windows of a test.

use std::fs;
use std::process::{Command, Stdio, id};

/// Ends all processes that this one has started, and those that they have started. One whose parent has ended is not found.
pub(crate) fn end() {
    let mut found = vec![id()];
    let mut next = 0;
    while let Some(parent) = found.get(next).copied() {
        if next > 0 {
            // One that is stopped starts no other.
            signal("-STOP", &[parent]);
        }
        found.extend(children(parent));
        next += 1;
    }
    signal("-KILL", &found[1..]);
}

/// Sends a signal to processes, each of which may have ended already.
fn signal(name: &str, processes: &[u32]) {
    let numbers = processes.iter().map(u32::to_string);
    let mut kill = Command::new("kill");
    let kill = kill.arg(name).args(numbers).stderr(Stdio::null());
    drop(kill.status());
}

/// The processes that a process has started.
fn children(parent: u32) -> Vec<u32> {
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    let numbers = processes.filter_map(|process| process.file_name().to_str()?.parse().ok());
    numbers
        .filter(|number| parent_of(*number) == Some(parent))
        .collect()
}

/// The parent of a process: the second field after its name, which is in parentheses and may contain some.
fn parent_of(process: u32) -> Option<u32> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let (_, fields) = stat.rsplit_once(')')?;
    fields.split_whitespace().nth(1)?.parse().ok()
}
