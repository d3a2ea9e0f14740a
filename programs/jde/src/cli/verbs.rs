//! Groups the verbs in the help by purpose. Adds no verb.

use std::fmt::Write as _;

use clap::Command;
use clap::builder::StyledStr;
use jde_terminal::TITLE;

/// The title of each group with its verbs.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Run", &["demo", "run", "replay", "experiment", "test", "sim"]),
    ("Write", &["new", "check", "describe", "validate", "plugins"]),
    (
        "Inspect running applications",
        &[
            "view", "web", "apps", "ps", "top", "vars", "get", "watch", "events", "why", "panel", "record",
            "ready", "shell",
        ],
    ),
    ("Report on recordings", &["info", "plot", "report"]),
    (
        "Control running applications",
        &[
            "set", "tuned", "play", "stop", "force", "release", "period", "reload", "unload", "load",
            "continue", "step",
        ],
    ),
    ("Serve agents", &["mcp"]),
];

/// Returns the command with its verbs listed by group. Verbs of no group follow last.
pub(super) fn group_verbs(command: Command) -> Command {
    let mut list = String::new();
    let title_style = TITLE.ansi();
    let mut listed = Vec::new();
    for (title, names) in GROUPS {
        let _ = writeln!(list, "{title_style}{title}:{title_style:#}");
        for verb in names.iter().filter_map(|name| command.find_subcommand(name)) {
            push_verb(verb, &mut list);
            listed.push(verb.get_name().to_owned());
        }
        list.push('\n');
    }
    let _ = writeln!(list, "{title_style}Other:{title_style:#}");
    for verb in command
        .get_subcommands()
        .filter(|verb| !listed.iter().any(|name| name == verb.get_name()))
    {
        push_verb(verb, &mut list);
    }
    let list = StyledStr::from(list);
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{}\n{{tab}}help [VERB]\n\n{title_style}Options:{title_style:#}\n{{options}}{{after-help}}",
        list.ansi()
    ))
}

fn push_verb(verb: &Command, list: &mut String) {
    let about = verb.get_about().map(ToString::to_string).unwrap_or_default();
    let _ = writeln!(list, "  {:<12} {}", verb.get_name(), about.trim_end_matches('.'));
}
