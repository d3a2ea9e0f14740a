//! Small files that would take all memory, or minutes: each reader of files refuses them with words. A reader runs in a
//! process of its own, with 1 GiB of memory and 10 s of processor time.
//!
//! One row of [`ROWS`] is one such file. It is made in a folder of its own, in which the verb runs with the plugins of
//! the workspace.

mod applications;
mod bags;
mod files;
mod maps;
mod others;
mod recordings;
mod rows;
mod worlds;

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::attached::Sandbox;
use crate::support::{jde_with_plugins, output_of};
use files::{app, lines, write};
use rows::{ROWS, Row};

/// The limits of each process: no image of its memory if it crashes, s of processor time, KiB of memory that it writes.
/// The address space is not limited, since a library reserves more of it than it uses.
const LIMITED: &str = "ulimit -c 0; ulimit -t 10; ulimit -d 1048576; exec \"$0\" \"$@\"";

#[test]
fn each_reader_refuses_hostile_files_with_words_within_its_limits() {
    let next = AtomicUsize::new(0);
    let failures = || {
        let rows = std::iter::from_fn(|| ROWS.get(next.fetch_add(1, Ordering::Relaxed)));
        rows.filter_map(failure).collect::<Vec<_>>()
    };
    let failed: Vec<String> = std::thread::scope(|scope| {
        let readers = [0; 2].map(|_| scope.spawn(failures));
        readers.map(|reader| reader.join().expect("a reader")).concat()
    });
    assert!(failed.is_empty(), "\n{}", failed.join("\n"));
}

#[test]
fn python_is_started_once_for_all_missing_plugins() {
    let sandbox = Sandbox::new();
    let (folder, python) = (sandbox.folder(), sandbox.folder().join("python"));
    fs::write(&python, "#!/bin/sh\necho started >> \"${0%/*}/starts\"\nexit 1\n").expect("a script");
    fs::set_permissions(&python, fs::Permissions::from_mode(0o755)).expect("its permissions");
    let schemas = lines(300, |n| format!("[schemas.s{n}]\ntype = \"nowhere{n}\""));
    app(
        folder,
        &format!("roots = [\"s0\"]\n{schemas}[schemas.it]\ntype = \"it.py\""),
    );
    write(folder, "it.py", "");
    let mut check = sandbox.command(jde_with_plugins(&["check", "app.toml"]));
    let output = output_of(check.current_dir(folder).env("JDE_PYTHON", &python));
    assert_eq!(output.status, Some(3), "{}", output.err);
    assert!(
        output.err.contains("there is no plugin `nowhere39`"),
        "{}",
        output.err
    );
    assert_eq!(
        fs::read_to_string(folder.join("starts")).expect("it was started"),
        "started\n"
    );
}

/// Returns what is wrong with the answer to a row.
fn failure(row: &Row) -> Option<String> {
    let sandbox = Sandbox::new();
    (row.make)(sandbox.folder());
    let arguments: Vec<&str> = row.verb.split(' ').collect();
    let direct = sandbox.command(jde_with_plugins(&arguments));
    let mut limited = Command::new("sh");
    limited
        .args(["-c", LIMITED])
        .arg(direct.get_program())
        .args(direct.get_args())
        .current_dir(sandbox.folder())
        .env("XDG_CONFIG_HOME", sandbox.folder())
        .env("COLUMNS", "1000");
    for (name, value) in direct.get_envs() {
        match value {
            Some(value) => limited.env(name, value),
            None => limited.env_remove(name),
        };
    }
    let output = output_of(&mut limited);
    let said = format!("{}{}", output.out, output.err);
    // Neither a panic nor a signal.
    let is_expected = output
        .status
        .is_some_and(|status| (status == 0) == row.is_read && status != 101 && status < 126);
    let is_well =
        is_expected && said.contains(row.words) && !said.contains("panicked") && said.len() < 200_000;
    (!is_well).then(|| {
        let start: String = said.chars().take(600).collect();
        let (verb, words) = (row.verb, row.words);
        format!(
            "jde {verb}: {:?}, expected “{words}” in {} bytes:\n{start}",
            output.status,
            said.len()
        )
    })
}
