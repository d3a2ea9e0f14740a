//! What a process leaves behind: the processes that it has started, and those that they have. They end with it, so
//! that none keeps a device, a stream or the processor. It finds them by their process group and by a mark in their
//! environment; one that has left the group and was started without its environment is not found.

use std::fs;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, id};
use std::sync::atomic::{AtomicU64, Ordering};

use rustix::io::retry_on_intr;
use rustix::process::{
    Pid, PidfdFlags, Signal, WaitId, WaitIdOptions, kill_process_group, pidfd_open, pidfd_send_signal, waitid,
};

/// The variable with the marks of the processes above, separated by blanks.
const VARIABLE: &str = "JDE_PROCESSES";
/// A process may start others while they are searched. Each time, fewer are left to do so.
const MAX_SEARCHES: usize = 10;

/// Marks a process and all that come from it.
pub struct Descendants {
    mark: String,
    /// Whether the process leads a group of its own.
    is_leader: bool,
}

impl Descendants {
    /// Marks the process that `command` will start, and makes it the leader of a group of its own if `is_leader` is set:
    /// signals of the terminal are then for its parent alone.
    pub fn mark(command: &mut Command, is_leader: bool) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let mark = format!("{}.{}", id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let outer = std::env::var(VARIABLE).unwrap_or_default();
        command.env(VARIABLE, format!("{outer} {mark}"));
        if is_leader {
            command.process_group(0);
        }
        Self { mark, is_leader }
    }

    /// Waits until the process has exited, and ends its group. The process is not reaped: until then no other gets its
    /// number, which is that of the group.
    pub fn end_group_at_exit(&self, child: Pid) {
        // It fails only if the process is reaped already.
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOWAIT;
        let exited = retry_on_intr(|| waitid(WaitId::Pid(child), options));
        if self.is_leader && exited.is_ok() {
            // It fails if there is no other process in the group.
            let _ = kill_process_group(child, Signal::KILL);
        }
    }

    /// Ends the processes with the mark. One process may see those of its own user alone.
    pub fn end_marked(&self) {
        for _ in 0..MAX_SEARCHES {
            let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
            let numbers = processes.filter_map(|process| process.file_name().to_str()?.parse().ok());
            if numbers.filter(|number| self.end_if_marked(*number)).count() == 0 {
                return;
            }
        }
    }

    /// Ends a process if it has the mark. Returns whether it did.
    fn end_if_marked(&self, number: i32) -> bool {
        // Opened before it is looked at, so that no other process has its number when the signal is sent.
        let Some(process) = Pid::from_raw(number).and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok())
        else {
            return false;
        };
        let environment = fs::read(format!("/proc/{number}/environ")).unwrap_or_default();
        let mut variables = environment.split(|byte| *byte == 0);
        let is_marked = variables.any(|variable| {
            let marks = variable.strip_prefix(VARIABLE.as_bytes());
            marks.is_some_and(|marks| {
                let mut marks = marks.split(|byte| matches!(byte, b' ' | b'='));
                marks.any(|mark| mark == self.mark.as_bytes())
            })
        });
        is_marked && pidfd_send_signal(&process, Signal::KILL).is_ok()
    }
}

/// Ends what a child leaves behind, on a thread of its own. The child must be reaped after the thread has ended.
///
/// # Errors
/// The system refuses the thread.
pub fn end_after(child: &Child, descendants: Descendants) -> std::io::Result<std::thread::JoinHandle<()>> {
    let pid = Pid::from_child(child);
    std::thread::Builder::new()
        .name(format!("of {pid}"))
        .spawn(move || {
            descendants.end_group_at_exit(pid);
            descendants.end_marked();
        })
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead, BufReader, Read};
    use std::process::Stdio;

    use jde_watchdog::Watchdog;

    use super::*;

    /// Starts a shell that starts a process by `command` in the background, waits until that runs, and exits. The
    /// returned stream ends when nobody holds it.
    fn leave_behind(command: &str) -> (Child, Descendants, BufReader<std::process::ChildStdout>) {
        let script = format!("{command} sh -c 'echo begun; exec sleep 3600' & read -r _; exit 3");
        let mut shell = Command::new("sh");
        shell
            .args(["-c", &script])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        let descendants = Descendants::mark(&mut shell, true);
        let mut child = shell.spawn().expect("a shell");
        let mut stream = BufReader::new(child.stdout.take().expect("its output"));
        let mut line = String::new();
        stream.read_line(&mut line).expect("a line");
        assert_eq!(line, "begun\n");
        // The end of its input lets it exit.
        drop(child.stdin.take());
        (child, descendants, stream)
    }

    #[test]
    fn processes_that_a_child_has_started_end_with_it_in_its_group_and_outside() {
        let _watchdog = Watchdog::for_test();
        for command in ["", "setsid", "setsid --fork setsid --fork"] {
            let (mut child, descendants, mut stream) = leave_behind(command);
            let ending = end_after(&child, descendants).expect("a thread");
            let mut rest = String::new();
            stream.read_to_string(&mut rest).expect("the end of the stream");
            ending.join().expect("no panic");
            assert_eq!(child.wait().expect("an exit").code(), Some(3), "{command}");
        }
    }
}
