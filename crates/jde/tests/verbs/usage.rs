//! Help, version, wrong use and completions of every verb.

use crate::support::{jde, said};

const VERBS: [&str; 30] = [
    "demo",
    "run",
    "check",
    "describe",
    "plugins",
    "new",
    "completions",
    "replay",
    "info",
    "plot",
    "report",
    "apps",
    "ps",
    "top",
    "vars",
    "get",
    "set",
    "watch",
    "events",
    "why",
    "play",
    "stop",
    "force",
    "release",
    "period",
    "unload",
    "load",
    "reload",
    "record",
    "shell",
];

#[test]
fn every_verb_has_help_with_an_example() {
    for verb in VERBS {
        let help = said(&mut jde(&[verb, "--help"]));
        assert_eq!(help.status, Some(0), "{verb}");
        assert!(
            help.out.contains(&format!("jde {verb}")) && help.out.contains("Example"),
            "{verb}: {}",
            help.out
        );
        assert!(
            help.out.contains("--color") && help.err.is_empty(),
            "{verb}: {}",
            help.err
        );
    }
}

#[test]
fn alone_it_prints_help_that_names_every_verb() {
    let alone = said(&mut jde(&[]));
    let help = said(&mut jde(&["--help"]));
    assert_eq!(help.status, Some(0));
    for verb in VERBS {
        let line = format!("\n  {verb} ");
        assert!(
            help.out.contains(&line) && alone.err.contains(&line),
            "{verb}: {}",
            alone.err
        );
    }
}

#[test]
fn the_version_is_that_of_the_package() {
    let version = said(&mut jde(&["--version"]));
    assert_eq!(
        (version.status, version.out.as_str()),
        (Some(0), concat!("jde ", env!("CARGO_PKG_VERSION"), "\n"))
    );
}

#[test]
fn wrong_use_ends_with_status_2_and_says_what_to_do() {
    for args in [
        &["fly"][..],
        &["run"],
        &["run", "x.toml", "--speed", "fast"],
        &["run", "x.toml", "--for", "ten"],
        &["run", "x.toml", "--set", "nothing"],
        &["run", "x.toml", "--lockstep", "--speed", "2x"],
        &["run", "x.toml", "--log", "goon=loud"],
        &["describe"],
        &["plot"],
        &["plot", "x.mcap", "--size", "huge"],
        &["plot", "x.mcap", "--from", "never"],
        &["report"],
        &["completions", "dos"],
        &["new", "schema", "Not A Name"],
    ] {
        let wrong = said(&mut jde(args));
        assert_eq!(wrong.status, Some(2), "{args:?}: {}", wrong.err);
        assert!(
            wrong.err.starts_with("error: ") && wrong.out.is_empty(),
            "{args:?}: {}",
            wrong.err
        );
    }
}

#[test]
fn completions_are_there_for_every_shell() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = said(&mut jde(&["completions", shell]));
        assert_eq!(script.status, Some(0), "{shell}");
        assert!(
            script.out.contains("COMPLETE") && script.out.contains("jde"),
            "{shell}: {}",
            script.out
        );
    }
    // The completion script runs the executable at each press of the key.
    let mut asked = jde(&["--", "jde", ""]);
    asked
        .env("COMPLETE", "bash")
        .env("_CLAP_COMPLETE_INDEX", "1")
        .env("_CLAP_COMPLETE_COMP_TYPE", "9")
        .env("_CLAP_COMPLETE_SPACE", "false")
        .env("_CLAP_IFS", "\n");
    let words = said(&mut asked).out;
    for verb in VERBS {
        assert!(words.lines().any(|word| word == verb), "{verb} in {words}");
    }
}

#[test]
fn colours_are_for_terminals_unless_they_are_asked_for() {
    let plain = said(&mut jde(&["check", "no/such.toml"]));
    assert!(!plain.err.contains('\u{1b}'), "{}", plain.err);
    let coloured = said(&mut jde(&["check", "no/such.toml", "--color", "always"]));
    assert!(coloured.err.contains('\u{1b}'), "{}", coloured.err);
}
