//! Programs in C and C++ that run applications: the examples, and every mistake that a program can make.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use jde_watchdog::{DEFAULT_LIMIT, Watchdog};
use tempfile::TempDir;

/// The plugins of `apps/safe-navigation.toml` and `apps/dock.toml`.
const PLUGINS: &[&str] = &[
    "sim", "example", "goon", "vff", "stop", "teleop", "dock", "guard", "tags",
];

/// A program, and the libraries that it needs.
struct Program {
    folder: TempDir,
    plugins: PathBuf,
}

impl Program {
    /// Compiles a program as a user would, with every warning an error.
    fn compile(source: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let plugins = jde_test_plugins::folder(PLUGINS);
        let library = jde_test_plugins::library("jde-c", "jde");
        for name in ["libjde.so", "libjde.so.0"] {
            symlink(&library, folder.path().join(name)).unwrap();
        }
        let (compiler, standard) = match Path::new(source).extension() {
            Some(extension) if extension == "cpp" => ("c++", "-std=c++17"),
            _ => ("cc", "-std=c11"),
        };
        let mut compile = Command::new(compiler);
        compile
            .args([
                standard,
                "-Wall",
                "-Wextra",
                "-Wpedantic",
                "-Werror",
                "-pthread",
                "-I",
            ])
            .arg(root().join("include"))
            .arg(root().join(source))
            .arg("-L")
            .arg(folder.path())
            .args(["-ljde", "-lm", "-o"])
            .arg(folder.path().join("program"));
        let output = compile
            .output()
            .unwrap_or_else(|error| panic!("{compile:?} needs a C and a C++ compiler: {error}"));
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        Self { folder, plugins }
    }

    /// Runs it in the root of the project. Returns what it prints on the standard output.
    fn run(&self, arguments: &[&str]) -> String {
        let output = self.output(arguments);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{errors}");
        String::from_utf8(output.stdout).unwrap()
    }

    fn output(&self, arguments: &[&str]) -> Output {
        let _watchdog = Watchdog::new(DEFAULT_LIMIT, || String::from("a program of C hangs"));
        let mut program = Command::new(self.folder.path().join("program"));
        program
            .args(arguments)
            .current_dir(root())
            .env("LD_LIBRARY_PATH", self.folder.path())
            .env("JDE_PLUGIN_PATH", &self.plugins)
            .output()
            .unwrap()
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

const NAVIGATION: &str = "apps/safe-navigation.toml";

#[test]
fn the_example_in_c_drives_in_lockstep() {
    let example = Program::compile("examples/embed/lockstep.c");
    let output = example.run(&[NAVIGATION]);
    let expected = "\
\x205.000 s: the robot is at 3.55, 3.31 m, and goon wins
\x205.000 s: scan 101 has 180 ranges
\x20         the nearest obstacle is 2.00 m away
10.000 s: the robot is at 3.55, 3.98 m, and goon wins
18.100 s: the robot is at 3.56, 7.01 m, and vff wins
\x20         495 selections were recorded
";
    assert_eq!(output, expected);
}

#[test]
fn the_example_in_cpp_waits_for_the_mission() {
    let output = Program::compile("examples/embed/real_time.cpp").run(&[NAVIGATION]);
    assert_eq!(output, "the mission is done\n");
}

#[test]
fn the_examples_say_what_is_wrong() {
    for example in ["lockstep.c", "real_time.cpp"] {
        let output =
            Program::compile(&format!("examples/embed/{example}")).output(&["apps/safe-navigatoin.toml"]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{errors}");
        assert!(
            errors.starts_with("apps/safe-navigatoin.toml: there is no such file"),
            "{errors}"
        );
        assert!(
            errors.contains("did you mean `apps/safe-navigation.toml`?"),
            "{errors}"
        );
    }
}

#[test]
fn every_mistake_is_an_error_in_words() {
    let broken = tempfile::tempdir().unwrap();
    let file = broken.path().join("broken.toml");
    fs::write(
        &file,
        "name = \"broken\"\nroots = [\"a\"]\n\n[schemas.a]\ntype = \"goon\"\nfast = \"1 kg\"\n",
    )
    .unwrap();
    let output =
        Program::compile("programs/c/tests/c/misuse.c").output(&[NAVIGATION, file.to_str().unwrap()]);
    assert!(output.status.success(), "{output:?}");
    assert!(output.stderr.is_empty(), "the library prints nothing: {output:?}");
    let output = String::from_utf8(output.stdout).unwrap();
    let output = output.replace(file.to_str().unwrap(), "broken.toml");
    assert_eq!(
        output,
        fs::read_to_string(root().join("programs/c/tests/c/misuse.txt")).unwrap()
    );
}

#[test]
fn a_program_is_a_mock_and_reads_types_that_it_does_not_know() {
    let output = Program::compile("programs/c/tests/c/values.c").run(&[NAVIGATION]);
    let expected = "\
the program drove 0.9 m
reached of jde_msgs/msg/Mission: 0
total of jde_msgs/msg/Mission: 8
the description is the same
the laser is in the frame laser
4 the run keeps no records; start it with them
done
4 edit:1:12: `remove` of edit 1 must be a text, not a whole number
32 the application has ended: time up
";
    assert_eq!(output, expected);
}

#[test]
fn a_program_in_cpp_writes_numbers_of_every_type() {
    let output = Program::compile("programs/c/tests/c/numbers.cpp").run(&["apps/dock.toml"]);
    assert_eq!(output, "1\n0.25\n0.5\n0.75\n9\n1\n");
}

#[test]
fn any_number_of_threads_may_call_and_any_number_of_runs_go_on() {
    let output = Program::compile("programs/c/tests/c/threads.c").run(&[NAVIGATION]);
    let lines: Vec<_> = output.lines().collect();
    let [one, other, rest @ ..] = lines.as_slice() else {
        panic!("{output}");
    };
    assert_eq!(one, other, "one seed gives one run");
    assert_eq!(rest, ["ended", "ended"]);
}

#[test]
fn r14_what_is_held_ends_with_the_lease() {
    let output = Program::compile("programs/c/tests/c/lease.c").run(&[NAVIGATION]);
    let expected = "\
1.000 s: goon is awake, ahead 1.30 m
1.400 s: goon sleeps, ahead 0.90 m
1.890 s: goon sleeps, ahead 0.90 m
2.100 s: goon is awake, ahead 1.30 m
9.000 s: goon sleeps, ahead 1.30 m
11.000 s: goon sleeps, ahead 1.30 m
";
    assert_eq!(output, expected);
}
