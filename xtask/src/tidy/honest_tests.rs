//! Tests always run, and never wait for time to pass.

use super::tree::{File, Tree, Violation};
use super::unfinished::has_word;

/// How the reason of an ignored test names the step that runs it.
const STEP: &str = "cargo xtask test --only ";

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.rust().flat_map(check_file).collect()
}

fn check_file(file: &File) -> Vec<Violation> {
    let mut found = Vec::new();
    for (number, line) in file.numbered() {
        let code: String = line.code.split_whitespace().collect();
        if code.contains("#[ignore") && !line.literal.contains(STEP) {
            found.push(Violation::new(
                file.path.as_str(),
                number,
                "a test that does not run",
                "make it pass, or remove it; what a step of `cargo xtask test` runs names it: `cargo xtask test --only STEP`",
            ));
        }
        let waits = sleeps(&code) || (code.contains("Command::new(\"\")") && line.literal == "sleep");
        if line.test && waits {
            found.push(Violation::new(
                file.path.as_str(),
                number,
                "a test that sleeps",
                "wait for the thing itself (a channel, a barrier, a join) or step a virtual clock",
            ));
        }
        if line.test && is_prefixed(&line.code) {
            found.push(Violation::new(
                file.path.as_str(),
                number,
                "a test called `test_...`",
                "name the behaviour that it holds, without the prefix",
            ));
        }
    }
    found
}

/// Returns whether code makes a thread sleep. The `sleep` of a schema does not count.
fn sleeps(code: &str) -> bool {
    ["thread::sleep", "thread::{sleep", "time::sleep(", "sleep_ms("]
        .iter()
        .any(|call| code.contains(call))
        || has_word(code, "sleep(Duration")
}

fn is_prefixed(code: &str) -> bool {
    let code = code.trim_start();
    code.strip_prefix("async ")
        .unwrap_or(code)
        .starts_with("fn test_")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        let file = File::new("rules/a/tests/b.rs", text);
        check_file(&file)
            .iter()
            .map(|violation| violation.message.clone())
            .collect()
    }

    #[test]
    fn a_test_that_does_not_run_fails() {
        assert_eq!(
            found("#[ignore = \"slow\"]\nfn a() {}\n"),
            ["a test that does not run"]
        );
        assert_eq!(found("# [ ignore ]\nfn a() {}\n"), ["a test that does not run"]);
        let step = "#[ignore = \"needs more: cargo xtask test --only more\"]\nfn a() {}\n";
        assert_eq!(found(step), [""; 0]);
    }

    #[test]
    fn a_test_that_sleeps_fails() {
        for code in [
            "std::thread::sleep(a);",
            "use std::thread::{sleep};",
            "sleep(Duration::from_secs(1));",
            "Command::new(\"sleep\")",
        ] {
            assert_eq!(found(code), ["a test that sleeps"], "{code}");
        }
    }

    #[test]
    fn schemas_may_sleep_and_so_may_other_code() {
        assert_eq!(
            found("schema.sleep(); on_sleep(duration); // thread::sleep\n"),
            [""; 0]
        );
        assert_eq!(
            check_file(&File::new("src/a.rs", "std::thread::sleep(rest);\n")),
            []
        );
    }

    #[test]
    fn a_test_is_named_after_the_behaviour() {
        assert_eq!(found("fn test_stop() {}\n"), ["a test called `test_...`"]);
        assert_eq!(found("fn the_test_bench_is_empty() {}\n"), [""; 0]);
    }
}
