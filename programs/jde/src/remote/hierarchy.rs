//! The hierarchy of an application at one instant, as a table in the order of a tree.

use std::io::{self, Write};

use jde_core::State;
use jde_records::snapshot::{ReloadView, SchemaView, Snapshot};
use jde_session::top::{self, text};
use jde_terminal::{BAD, FAINT, GOOD, TITLE, WARN};
use jde_timeline::{Hierarchy, Item, OTHERS, Severity, health_severity, health_word, state_word};
use serde_json::{Value, json};

use super::table::{Alignment, Cell, Table};

/// Writes the table.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn write(snapshot: &Snapshot, output: &mut dyn Write) -> io::Result<()> {
    write_table(snapshot, false, output)
}

/// Writes the table of a recording, which has a dash for what no recording holds.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn write_recorded(snapshot: &Snapshot, output: &mut dyn Write) -> io::Result<()> {
    write_table(snapshot, true, output)
}

/// Returns the hierarchy of a recording as JSON, which has `null` for what no recording holds: how long calls took, and the
/// iterations of schemas whose turns are not in it, such as drivers.
pub(crate) fn recorded_json(snapshot: &Snapshot) -> Value {
    let mut json = json!(snapshot);
    for schema in json["schemas"].as_array_mut().into_iter().flatten() {
        schema["load"] = Value::Null;
        schema["longest"] = Value::Null;
        if schema["iterations"] == 0 {
            schema["iterations"] = Value::Null;
        }
    }
    json
}

fn write_table(snapshot: &Snapshot, is_recorded: bool, output: &mut dyn Write) -> io::Result<()> {
    let mut table = Table::new([
        ("schema", Alignment::Left),
        ("type", Alignment::Left),
        ("state", Alignment::Left),
        ("health", Alignment::Left),
        ("period", Alignment::Right),
        ("measured", Alignment::Right),
        ("load", Alignment::Right),
        ("iterations", Alignment::Right),
        ("overruns", Alignment::Right),
        ("refused", Alignment::Right),
        ("faults", Alignment::Right),
        ("process", Alignment::Right),
        ("build", Alignment::Left),
        ("operator", Alignment::Left),
    ]);
    for (branch, row) in top::branches(&Hierarchy::of_snapshot(snapshot)) {
        match row.item {
            Item::Group(group) => {
                let group = &snapshot.groups[group];
                let winner = snapshot.winner_name(group);
                table.add_row([
                    Cell::from(format!("{branch}[{}]", group.name)).styled(TITLE),
                    Cell::from(format!("{} → {winner}", group.policy)).styled(FAINT),
                    match group.chatter {
                        Some(_) => Cell::from("chatters").styled(WARN),
                        None => Cell::from(""),
                    },
                ]);
            }
            Item::Schema(schema, _) => {
                table.add_row(cells(&branch, &snapshot.schemas[schema], is_recorded));
            }
            Item::Others => table.add_row([Cell::from(OTHERS).styled(TITLE)]),
        }
    }
    table.write(output)
}

fn cells(branch: &str, view: &SchemaView, is_recorded: bool) -> Vec<Cell> {
    let style = match view.state {
        State::Winner => GOOD,
        State::Ready => WARN,
        State::Checking => TITLE,
        State::Slept => FAINT,
    };
    let word = health_word(&view.health);
    let (health, health_style) = match health_severity(&view.health) {
        Severity::Good => (word.to_owned(), FAINT),
        Severity::Warning => (word.to_owned(), WARN),
        Severity::Bad => (format!("{word}, {}", restarts(view.restarts_left)), BAD),
    };
    let health = match view.left {
        0 => Cell::from(health).styled(health_style),
        left => Cell::from(format!("{health}, {left} left behind")).styled(BAD),
    };
    let bad = |count: u64| match count {
        0 => Cell::from(0).styled(FAINT),
        count => Cell::from(count).styled(WARN),
    };
    vec![
        format!("{branch}{}", view.name).into(),
        Cell::from(&view.type_name).styled(FAINT),
        Cell::from(state_word(view)).styled(style),
        health,
        text::format_setting(view.period).into(),
        view.measured
            .map_or(Cell::from("-"), |measured| text::format_duration(measured).into()),
        match is_recorded {
            true => Cell::from("-"),
            false => format!("{:.0} %", view.load * 100.0).into(),
        },
        match view.iterations {
            0 if is_recorded => Cell::from("-"),
            iterations => iterations.into(),
        },
        bad(view.overruns),
        bad(view.refused),
        bad(view.faults),
        view.process.map_or(Cell::default(), Cell::from),
        view.reload.as_ref().map_or(Cell::default(), build_cell),
        view.held_by()
            .map_or(Cell::default(), |held| Cell::from(held).styled(WARN)),
    ]
}

/// Describes how many restarts a schema has left after a fault.
fn restarts(left: Option<u32>) -> String {
    match left {
        None => "never restarted".to_owned(),
        Some(0) => "no restart left".to_owned(),
        Some(1) => "1 restart left".to_owned(),
        Some(left) => format!("{left} restarts left"),
    }
}

/// Describes the build of the last reload. `jde ps --json` has the reason why a build was given up.
fn build_cell(reload: &ReloadView) -> Cell {
    let version = &reload.build.version;
    match (reload.on_trial, &reload.undone) {
        (true, _) => Cell::from(format!("{version} on trial")).styled(WARN),
        (false, Some(_)) => Cell::from(format!("{version}, a newer one was given up")).styled(WARN),
        (false, None) => Cell::from(version),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::snapshots::navigation;

    #[test]
    fn a_hierarchy_is_written_as_a_tree() {
        let mut out = Vec::new();
        write(&navigation(), &mut out).unwrap();
        let text = jde_terminal::escape::without_styles(&String::from_utf8(out).unwrap());
        let first: Vec<&str> = text
            .lines()
            .filter_map(|line| line.split("  ").find(|part| !part.is_empty()))
            .collect();
        assert_eq!(
            first[..4],
            ["schema", "[roots]", "├ teleop", "└ example"],
            "{text}"
        );
        assert!(text.lines().all(|line| !line.ends_with(' ')), "{text}");
    }

    #[test]
    fn what_no_recording_holds_is_not_shown_as_zero() {
        let mut snapshot = navigation();
        snapshot.schemas[0].iterations = 0;
        snapshot.schemas[1].iterations = 7;
        let mut out = Vec::new();
        write_recorded(&snapshot, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(!text.contains(" %"), "{text}");
        let json = recorded_json(&snapshot);
        let [first, second] = [0, 1].map(|place| &json["schemas"][place]);
        assert!(
            first["iterations"].is_null() && first["load"].is_null(),
            "{first}"
        );
        assert_eq!(second["iterations"], 7);
    }
}
