//! Small files that would take all memory, or minutes: each reader of files refuses them with words. A reader runs in a
//! process of its own, with 1 GiB of memory and 10 s of processor time.
//!
//! One row of [`ROWS`] is one such file. It is made in a folder of its own, in which the verb runs with the plugins of
//! the workspace.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::attached::Sandbox;
use crate::support::{jde_with_plugins, output_of};

/// The limits of each process: no image of its memory if it crashes, s of processor time, KiB of memory that it writes.
/// The address space is not limited, since a library reserves more of it than it uses.
const LIMITED: &str = "ulimit -c 0; ulimit -t 10; ulimit -d 1048576; exec \"$0\" \"$@\"";

/// A file, and what reads it.
struct Row {
    /// The arguments of the executable.
    verb: &'static str,
    /// Makes the file in a folder.
    make: fn(&Path),
    /// A part of what is said. The rest names the file.
    words: &'static str,
}

const fn row(verb: &'static str, make: fn(&Path), words: &'static str) -> Row {
    Row { verb, make, words }
}

/// Each is refused: the exit status is neither 0 nor that of a panic.
const ROWS: &[Row] = &[
    // Applications.
    row("check /dev/zero", nothing, "/dev/zero: it is no regular file"),
    row(
        "check pipe.toml",
        |folder| pipe(folder, "pipe.toml"),
        "pipe.toml: it is no regular file",
    ),
    row(
        "check sparse.toml",
        |folder| sparse(folder, "sparse.toml"),
        "it has more than 2 MiB",
    ),
    row(
        "check app.toml",
        |folder| app(folder, &"[".repeat(1 << 20)),
        "this is not TOML",
    ),
    row(
        "check app.toml",
        |folder| app(folder, &format!("a = {}", "[".repeat(1 << 20))),
        "recursion",
    ),
    row(
        "check app.toml",
        |folder| app(folder, &format!("a = {}", "{b=".repeat(1 << 19))),
        "recursion",
    ),
    row(
        "check app.toml",
        |folder| app(folder, &format!("{}a = 1", "a.".repeat(1 << 19))),
        "recursion",
    ),
    row(
        "check app.toml",
        |folder| app(folder, &format!("[{}a]", "a.".repeat(1 << 19))),
        "recursion",
    ),
    row(
        "check app.toml",
        |folder| app(folder, &"a = 1\n".repeat(1 << 18)),
        "there is a key `a` already",
    ),
    row(
        "check app.toml",
        |folder| app(folder, &"\u{0}".repeat(1 << 20)),
        "this is not TOML",
    ),
    row(
        "check app.toml",
        |folder| app(folder, &lines(60_000, |n| format!("key{n} = 1"))),
        "60000 entries",
    ),
    row(
        "check app.toml",
        |folder| app(folder, &lines(65_000, |n| format!("[schemas.s{n}]"))),
        "65000 entries",
    ),
    row(
        "check app.toml",
        |folder| app(folder, &lines(9_000, |n| format!("key{n:056} = 1"))),
        "and 8961 more",
    ),
    row("check app.toml", missing_types, "has no `type`"),
    row("check app.toml", misspelt_roots, "there is no such schema"),
    row("check app.toml", levels, "names `a` twice"),
    row("check app.toml", groups, "has no children to wake"),
    row("check app.toml", children, "there is no role `c0`"),
    row(
        "check app.toml",
        |folder| app(folder, &nested(9_000)),
        "is below 256 others",
    ),
    row("check app.toml", folders, "more than 100 entries"),
    row("check app.toml", one_line, "unknown key"),
];

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
    let is_refused = output
        .status
        .is_some_and(|status| ![0, 101].contains(&status) && status < 126);
    let is_well =
        is_refused && said.contains(row.words) && !said.contains("panicked") && said.len() < 200_000;
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

fn nothing(_: &Path) {}

fn write(folder: &Path, name: &str, content: impl AsRef<[u8]>) {
    fs::write(folder.join(name), content).expect("a written file");
}

fn app(folder: &Path, text: &str) {
    write(folder, "app.toml", text);
}

fn pipe(folder: &Path, name: &str) {
    let made = Command::new("mkfifo").arg(folder.join(name)).status();
    assert!(made.expect("mkfifo is installed").success());
}

/// A file of a terabyte that takes no place.
fn sparse(folder: &Path, name: &str) {
    let file = File::create(folder.join(name)).expect("a file");
    // Some file systems have no files as large.
    let sizes = [1 << 40, 1 << 33];
    assert!(sizes.iter().any(|size| file.set_len(*size).is_ok()));
}

fn lines(count: usize, line: impl Fn(usize) -> String) -> String {
    (0..count).fold(String::new(), |mut text, number| {
        let _ = writeln!(text, "{}", line(number));
        text
    })
}

fn list(count: usize, item: impl Fn(usize) -> String) -> String {
    format!("[{}]", lines(count, |number| format!("\"{}\",", item(number))))
}

/// Schemas whose type is missing.
fn missing_types(folder: &Path) {
    app(
        folder,
        &format!(
            "roots = [\"s0\"]\n{}",
            lines(9_000, |n| format!("[schemas.s{n}]\ndoc = \"\""))
        ),
    );
}

/// Names that are as long as a name may be, each like many others.
fn misspelt_roots(folder: &Path) {
    let roots = list(9_000, |n| format!("b{n:063}"));
    let schemas = lines(9_000, |n| format!("[schemas.a{n:063}]\ntype=\"stop\""));
    app(folder, &format!("roots = {roots}\n{schemas}"));
}

/// Levels of roots that name the same schema.
fn levels(folder: &Path) {
    let levels = lines(9_999, |n| format!("l{n} = {{ members = [\"a\"] }}"));
    app(
        folder,
        &format!("[schemas.a]\ntype = \"stop\"\n[roots]\n{levels}"),
    );
}

/// Groups of a father in which nothing competes, and members that it does not have.
fn groups(folder: &Path) {
    let groups = lines(9_999, |n| format!("g{n} = {{ members = [\"a\", \"b{n}\"] }}"));
    app(
        folder,
        &format!("roots = [\"a\"]\n[schemas.a]\ntype = \"father\"\n[schemas.a.groups]\n{groups}"),
    );
}

/// Children in roles that their father does not have.
fn children(folder: &Path) {
    let children = lines(9_999, |n| format!("c{n} = \"s{n}\""));
    let schemas = lines(9_999, |n| format!("[schemas.s{n}]\ntype=\"stop\""));
    app(
        folder,
        &format!(
            "roots = [\"a\"]\n[schemas.a]\ntype=\"example\"\n[schemas.a.children]\n{children}\n{schemas}"
        ),
    );
}

/// Fathers below each other.
fn nested(count: usize) -> String {
    let father = |n| format!("[schemas.s{n}]\ntype=\"father\"\nchildren={{a=\"s{}\"}}", n + 1);
    format!(
        "roots = [\"s0\"]\n{}[schemas.s{count}]\ntype=\"stop\"",
        lines(count, father)
    )
}

/// Folders of plugins, and plugins that none of them has.
fn folders(folder: &Path) {
    let plugins = list(9_000, |n| format!("folder{n}"));
    let schemas = lines(5_000, |n| format!("[schemas.s{n}]\ntype = \"p{n}\""));
    app(
        folder,
        &format!("roots = [\"s0\"]\nplugins = {plugins}\n{schemas}"),
    );
}

/// Many faults in one long line.
fn one_line(folder: &Path) {
    let keys: Vec<_> = (0..9_000).map(|n| format!("key{n:060} = 1")).collect();
    app(
        folder,
        &format!("roots = [\"a\"]\nlink = {{ {} }}", keys.join(", ")),
    );
}
