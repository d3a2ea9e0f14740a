//! Help, version, usage errors and completions of every verb.

use jde_abi::raw;

use crate::support::{jde, output_of};

const VERBS: [&str; 31] = [
    "demo",
    "run",
    "check",
    "describe",
    "plugins",
    "new",
    "completions",
    "man",
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
fn the_path_of_an_application_that_comes_with_jde_is_answered_with_its_name() {
    let elsewhere = tempfile::tempdir().unwrap();
    for verb in ["run", "check"] {
        let refused = output_of(jde(&[verb, "apps/dock.toml"]).current_dir(elsewhere.path()));
        assert_eq!(refused.status, Some(2), "{refused:?}");
        let all = refused.err;
        assert!(all.contains("apps/dock.toml: there is no such file"), "{all}");
        assert!(all.contains("did you mean `dock`"), "{all}");
    }
}

#[test]
fn every_verb_has_help_with_an_example() {
    for verb in VERBS {
        let help = output_of(&mut jde(&[verb, "--help"]));
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
fn the_options_of_a_demonstration_come_before_those_of_its_link() {
    let help = output_of(&mut jde(&["demo", "--help"])).out;
    let place = |option: &str| help.find(option).unwrap_or_else(|| panic!("{option}: {help}"));
    assert!(help.starts_with("Watch a simulated robot"), "{help}");
    let order = [
        "Options:",
        "--headless",
        "--lockstep",
        "How tools connect:",
        "--no-link",
    ]
    .map(place);
    assert!(order.is_sorted(), "{help}");
}

#[test]
fn without_arguments_the_executable_prints_help_that_names_every_verb() {
    let without_arguments = output_of(&mut jde(&[]));
    let help = output_of(&mut jde(&["--help"]));
    assert_eq!(help.status, Some(0));
    for verb in VERBS {
        let line = format!("\n  {verb} ");
        assert!(
            help.out.contains(&line) && without_arguments.err.contains(&line),
            "{verb}: {}",
            without_arguments.err
        );
    }
}

#[test]
fn the_version_is_that_of_the_package_and_names_those_of_plugins_and_the_link() {
    let package = concat!("jde ", env!("CARGO_PKG_VERSION"), "\n");
    let short = output_of(&mut jde(&["-V"]));
    assert_eq!((short.status, short.out.as_str()), (Some(0), package));
    let (major, minor, protocol) = (raw::ABI_MAJOR, raw::ABI_MINOR, jde_link::PROTOCOL);
    let all = format!("{package}plugin ABI {major}.{minor}\nlink protocol {protocol}\n");
    let version = output_of(&mut jde(&["--version"]));
    assert_eq!((version.status, version.out), (Some(0), all));
}

#[test]
fn every_verb_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let written = output_of(jde(&["man"]).arg(folder.path()));
    assert_eq!(written.status, Some(0), "{}", written.err);
    for verb in VERBS {
        let page = std::fs::read_to_string(folder.path().join(format!("jde-{verb}.1"))).unwrap();
        assert!(page.contains(&format!("jde {verb}")), "{page}");
    }
    let refused = output_of(jde(&["man"]).arg(folder.path().join("none/man1")));
    let advice = format!("mkdir -p {}", folder.path().join("none").display());
    assert_eq!(refused.status, Some(1), "{}", refused.err);
    assert!(refused.err.contains(&advice), "{}", refused.err);
    assert!(!folder.path().join("none").exists());
}

#[test]
fn usage_errors_have_exit_status_2_and_a_message() {
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
        let wrong = output_of(&mut jde(args));
        assert_eq!(wrong.status, Some(2), "{args:?}: {}", wrong.err);
        assert!(
            wrong.err.starts_with("error: ") && wrong.out.is_empty(),
            "{args:?}: {}",
            wrong.err
        );
    }
}

#[test]
fn usage_errors_advise_what_works() {
    for (args, advice) in [
        (&["watch", "goon.fast", "--in", "x.mcap"][..], "jde replay FILE"),
        (&["top", "--in", "x.mcap"], "jde replay FILE"),
        (&["version"], "jde --version"),
        (&["run", "x.toml", "--for", "-5s"], "`-5s` must be 0 or more"),
        (&["replay", "x.mcap", "--from", "-5s"], "`-5s` must be 0 or more"),
        (&["run", "x.toml", "--seed", "-1"], "'-1' for '--seed <N>'"),
        (
            &["get", "pioneer.odometry", "--at", "30s"],
            "a time needs --in FILE",
        ),
        (&["why", "--at", "30s", "--in", "x.mcap"], "jde why at 12.4s"),
    ] {
        let wrong = output_of(&mut jde(args));
        assert_eq!(wrong.status, Some(2), "{args:?}: {}", wrong.err);
        assert!(
            wrong.err.contains(advice) && !wrong.err.contains("as a value"),
            "{args:?}: {}",
            wrong.err
        );
    }
}

#[test]
fn completions_exist_for_every_shell() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = output_of(&mut jde(&["completions", shell]));
        assert_eq!(script.status, Some(0), "{shell}");
        assert!(
            script.out.contains("COMPLETE") && script.out.contains("jde"),
            "{shell}: {}",
            script.out
        );
    }
    // The completion script runs the executable for each completion.
    let mut completion = jde(&["--", "jde", ""]);
    completion
        .env("COMPLETE", "bash")
        .env("_CLAP_COMPLETE_INDEX", "1")
        .env("_CLAP_COMPLETE_COMP_TYPE", "9")
        .env("_CLAP_COMPLETE_SPACE", "false")
        .env("_CLAP_IFS", "\n");
    let offered = output_of(&mut completion).out;
    for verb in VERBS {
        assert!(offered.lines().any(|word| word == verb), "{verb} in {offered}");
    }
}

#[test]
fn output_to_a_pipe_has_colours_only_on_request() {
    let plain = output_of(&mut jde(&["check", "no/such.toml"]));
    assert!(!plain.err.contains('\u{1b}'), "{}", plain.err);
    let coloured = output_of(&mut jde(&["check", "no/such.toml", "--color", "always"]));
    assert!(coloured.err.contains('\u{1b}'), "{}", coloured.err);
}
