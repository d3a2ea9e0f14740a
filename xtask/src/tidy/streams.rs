//! Nothing prints outside the listed places: a thread of a robot that prints to a pipe blocks until the pipe
//! is read.

use super::tree::{File, Tree, Violation};
use super::unfinished::has_word;

/// Names of streams and macros that can block on the stream's reader, or on a key.
const CALLS: &[&str] = &[
    "println!",
    "eprintln!",
    "print!",
    "eprint!",
    "stdout()",
    "stderr()",
    "tracing_subscriber",
    "event::poll",
    "event::read",
];

/// The places that may print, with the reason.
const EXCEPTIONS: &[(&str, &str)] = &[
    (
        "programs/terminal/",
        "everything that the executables print, and every key it reads, goes through here",
    ),
    ("dev/faults/", "a program for developers, in which no robot runs"),
    (
        "observe/experiment/src/worker.rs",
        "a process for drives in virtual time, which answers its parent",
    ),
    (
        "programs/launcher/",
        "it builds jde and then becomes it, and runs no schema while it prints",
    ),
    (
        "base/watchdog/",
        "it ends a test that hangs, and reports the state of its threads",
    ),
];

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.rust().flat_map(check_file).collect()
}

fn check_file(file: &File) -> Vec<Violation> {
    let path = file.path.as_str();
    let of_project = ["xtask/", "benches/", "fuzz/", "examples/"];
    let is_of_robots = !of_project.iter().any(|folder| path.starts_with(folder)) && path.contains("/src/");
    if !is_of_robots || EXCEPTIONS.iter().any(|(place, _)| path.starts_with(place)) {
        return Vec::new();
    }
    let mut found = Vec::new();
    for (number, line) in file.numbered().filter(|(_, line)| !line.test) {
        for way in CALLS.iter().filter(|way| has_word(&line.code, way)) {
            found.push(Violation::new(
                path,
                number,
                format!(
                    "`{way}`: whoever calls this waits for whoever reads, and a robot may wait for the caller"
                ),
                "log it by `tracing`, or print by `crate::terminal` of the executable",
            ));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(path: &str, text: &str) -> usize {
        check_file(&File::new(path, text)).len()
    }

    #[test]
    fn code_that_prints_outside_the_listed_places_is_found() {
        for way in [
            "println!(\"x\")",
            "let mut out = io::stderr().lock()",
            "io::stdout()",
            "event::read()?",
        ] {
            let code = format!("fn a() {{ {way}; }}\n");
            assert_eq!(count("runtime/host/src/a.rs", &code), 1, "{way}");
            assert_eq!(count("programs/terminal/src/lib.rs", &code), 0, "{way}");
            assert_eq!(count("runtime/host/tests/a.rs", &code), 0, "{way}");
        }
    }

    #[test]
    fn similar_code_that_does_not_print_passes() {
        for code in [
            "writeln!(words, \"x\")",
            "command.stdout(Stdio::null())",
            "error.use_stderr()",
            "// println!",
        ] {
            assert_eq!(
                count("schemas/a/src/lib.rs", &format!("fn a() {{ {code}; }}\n")),
                0,
                "{code}"
            );
        }
    }
}
