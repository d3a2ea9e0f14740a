//! Small files that would take all memory, or minutes: each reader of files refuses them with words. A reader runs in a
//! process of its own, with 1 GiB of memory and 10 s of processor time.
//!
//! One row of [`ROWS`] is one such file. It is made in a folder of its own, in which the verb runs with the plugins of
//! the workspace.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::os::unix::fs::PermissionsExt as _;
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
#[rustfmt::skip] // A row is a line.
const ROWS: &[Row] = &[
    // Applications.
    row("check /dev/zero", nothing, "/dev/zero: it is no regular file"),
    row("check pipe.toml", |folder| pipe(folder, "pipe.toml"), "pipe.toml: it is no regular file"),
    row("check sparse.toml", |folder| sparse(folder, "sparse.toml"), "it has more than 2 MiB"),
    row("check app.toml", |folder| app(folder, &"[".repeat(1 << 18)), "this is not TOML"),
    row("check app.toml", |folder| app(folder, &format!("a = {}", "[".repeat(1 << 18))), "recursion"),
    row("check app.toml", |folder| app(folder, &format!("a = {}", "{b=".repeat(1 << 17))), "recursion"),
    row("check app.toml", |folder| app(folder, &format!("{}a = 1", "a.".repeat(1 << 17))), "recursion"),
    row("check app.toml", |folder| app(folder, &format!("[{}a]", "a.".repeat(1 << 17))), "recursion"),
    row("check app.toml", |folder| app(folder, &"a = 1\n".repeat(1 << 16)), "there is a key `a` already"),
    row("check app.toml", |folder| app(folder, &"\u{0}".repeat(1 << 18)), "this is not TOML"),
    row("check app.toml", |folder| app(folder, &lines(60_000, |n| format!("key{n} = 1"))), "60000 entries"),
    row("check app.toml", |folder| app(folder, &lines(65_000, |n| format!("[schemas.s{n}]"))), "65000 entries"),
    row("check app.toml", |folder| app(folder, &lines(4_000, |n| format!("key{n:056} = 1"))), "and 3962 more"),
    row("check app.toml", missing_types, "has no `type`"),
    row("check app.toml", misspelt_roots, "there is no such schema"),
    row("check app.toml", levels, "names `a` twice"),
    row("check app.toml", groups, "has no children to wake"),
    row("check app.toml", children, "there is no role `c0`"),
    row("check app.toml", |folder| app(folder, &nested(4_000)), "is below 256 others"),
    row("check app.toml", folders, "more than 100 entries"),
    row("check app.toml", one_line, "unknown key"),
    // Experiments and tests.
    row("experiment /dev/zero", nothing, "it is no regular file"),
    row("experiment e.toml", |folder| write(folder, "e.toml", lines(60_000, |n| format!("k{n} = 1"))), "60000 entries"),
    row("experiment e.toml", |folder| write(folder, "e.toml", format!("a = {}", "[".repeat(1 << 17))), "recurse"),
    row("test pipe.toml", |folder| pipe(folder, "pipe.toml"), "there is no test in pipe.toml"),
    // Files that options name.
    row("run app.toml --ros-args --params-file /dev/zero", nothing, "/dev/zero: it is no regular file"),
    row("run app.toml --ros-args --params-file p", |folder| pipe(folder, "p"), "p: it is no regular file"),
    row("run app.toml --ros-args --params-file p", |folder| write(folder, "p", "[".repeat(1 << 17)), "recursion limit"),
    row("run app.toml --ros-args --params-file p", aliases, "alias expansion"),
    row("ps --at localhost --key /dev/zero", nothing, "/dev/zero: it is no regular file"),
    row("ps --at localhost --key key.toml", key, "/dev/zero: it is no regular file"),
    row("sim office --p2os 0 --model a=./pipe.toml", |folder| pipe(folder, "pipe.toml"), "it is no regular file"),
    // Plugins.
    row("describe ./lib.so", |folder| pipe(folder, "lib.so"), "lib.so: cannot read it: it is no regular file"),
    row("describe ./lib.so", |folder| sparse(folder, "lib.so"), "no plugin is that large"),
    row("describe ./lib.so", sections, "lib.so: "),
    row("validate ./lib.so", |folder| pipe(folder, "lib.so"), "it is no regular file"),
    // Recordings.
    row("view pipe.mcap", |folder| pipe(folder, "pipe.mcap"), "it is no regular file"),
    row("replay pipe.mcap --plain", |folder| pipe(folder, "pipe.mcap"), "it is no regular file"),
    row("report pipe.mcap", |folder| pipe(folder, "pipe.mcap"), "it is no regular file"),
    // Worlds and maps of other programs.
    row("new world w --from multiplied.world", multiplied, "multiplied.world"),
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
            lines(4_000, |n| format!("[schemas.s{n}]\ndoc = \"\""))
        ),
    );
}

/// Names that are as long as a name may be, each like many others.
fn misspelt_roots(folder: &Path) {
    let roots = list(4_000, |n| format!("b{n:063}"));
    let schemas = lines(4_000, |n| format!("[schemas.a{n:063}]\ntype=\"stop\""));
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

/// Aliases that stand for ten times as many each.
fn aliases(folder: &Path) {
    let level = |n: usize| {
        format!(
            "a{}: &a{} [{}]",
            n + 1,
            n + 1,
            vec![format!("*a{n}"); 10].join(", ")
        )
    };
    write(folder, "p", format!("a0: &a0 [1]\n{}", lines(9, level)));
}

/// A key whose password is in an endless file.
fn key(folder: &Path) {
    write(
        folder,
        "key.toml",
        "user = \"ana\"\npassword-file = \"/dev/zero\"",
    );
}

/// A library whose header states 2^60 sections.
fn sections(folder: &Path) {
    let mut file = vec![0; 128];
    file[..7].copy_from_slice(b"\x7fELF\x02\x01\x01");
    // A shared library, for x86-64, whose sections are at byte 64, the first of which states their number.
    (file[16], file[18], file[40], file[52], file[58]) = (3, 62, 64, 64, 64);
    file[96 + 7] = 0x10;
    write(folder, "lib.so", file);
}

/// Definitions of which each has two of the one before.
fn multiplied(folder: &Path) {
    let define = |n: usize| format!("define a{} position ( a{n}() a{n}() )", n + 1);
    let text = format!("define a0 position ( )\n{}a40()\n", lines(40, define));
    write(folder, "multiplied.world", text);
}
