//! Each kind of fault of a TOML file: its place, its words, the faulty part of its line, and its help.

use std::path::Path;

use jde_document::section::number;
use jde_document::{Checked, Fault, FaultReport, Node, Section, WrongValue, parse};

fn positive(node: &Node) -> Checked<f64> {
    match number(node.get_ref()) {
        Some(number) if number > 0.0 => Ok(number),
        Some(number) => Err(WrongValue::new(
            node,
            format!("is {number}: expected more than 0"),
        )),
        None => Err(WrongValue::shape(node, "a number")),
    }
}

fn shade(node: &Node) -> Checked<()> {
    match node.get_ref().as_str() {
        Some("light" | "dark") => Ok(()),
        Some(other) => Err(WrongValue::unknown(node, other, "a shade", ["light", "dark"])),
        None => Err(WrongValue::shape(node, "a text")),
    }
}

/// Reads a room: its width, its boxes with a size and a shade, and its lamp.
fn read(report: &mut FaultReport, root: &Section) {
    root.refuse_unknown(report, &["width", "boxes", "lamp"]);
    root.required(report, "width", positive);
    root.nested(report, "lamp", &["x", "y"]);
    let boxes = root.tables(report, "boxes", "box").unwrap_or_default();
    for table in boxes.into_iter().flatten() {
        table.refuse_unknown(report, &["name", "size", "shade"]);
        table.required(report, "size", positive);
        table.optional(report, "shade", (), shade);
    }
}

/// Returns the faults of a room in full.
fn faults(text: &str) -> String {
    let mut report = FaultReport::new(Path::new("room.toml"), text);
    if let Some(document) = parse(&mut report, text) {
        read(&mut report, &Section::new("the room", 0..0, document.get_ref()));
    }
    match report.finish() {
        Ok(_) => String::new(),
        Err(faults) => format!("{faults:#}"),
    }
}

#[test]
fn each_kind_of_fault_is_shown_at_its_place() {
    for (text, expected) in [
        ("width = 4\nboxes = [{ size = 1, shade = 'dark' }]", ""),
        (
            "widht = 4\nwidth = 4",
            "room.toml:1:1: unknown key `widht` in the room\n    1 | widht = 4\n      | ^^^^^\n    help: did you mean `width`?",
        ),
        (
            "width = 4\ncolour = 1",
            "room.toml:2:1: unknown key `colour` in the room\n    2 | colour = 1\n      | ^^^^^^\n    \
             help: keys: `width`, `boxes` and `lamp`",
        ),
        (
            "width = '4 m'",
            "room.toml:1:9: `width` of the room must be a number, not a text\n    1 | width = '4 m'\n      |         ^^^^^",
        ),
        (
            "width = -4",
            "room.toml:1:9: `width` of the room is -4: expected more than 0\n    1 | width = -4\n      |         ^^",
        ),
        (
            "width = 4\nwidth = 5",
            "room.toml:2:1: there is a key `width` already\n    2 | width = 5\n      | ^^^^^\n    help: keep one of the two",
        ),
        (
            "width = 4 m",
            "room.toml:1:9: this is not TOML: string values must be quoted, expected literal string\n    1 | width = 4 m\n      |         ^^^",
        ),
        (
            "width = 4\nboxes = 3",
            "room.toml:2:9: `boxes` of the room must be a list of tables, each [[boxes]], not a whole number\n    \
             2 | boxes = 3\n      |         ^",
        ),
        (
            "width = 4\n[[boxes]]\nname = 'desk'",
            "room.toml:2:1: `size` of box `desk` is missing\n    2 | [[boxes]]\n      | ^^^^^^^^^",
        ),
        (
            "width = 4\nboxes = [{ size = 1 }, 7]",
            "room.toml:2:24: box 2 must be a table, not a whole number\n    2 | boxes = [{ size = 1 }, 7]\n      |                        ^",
        ),
        (
            "width = 4\nboxes = [{ size = 1, shade = 'drak' }]",
            "room.toml:2:30: `shade` of box 1 is `drak`, which is not a shade\n    2 | boxes = [{ size = 1, shade = 'drak' }]\n      \
             |                              ^^^^^^\n    help: did you mean `dark`?",
        ),
        (
            "width = 4\nlamp = true",
            "room.toml:2:8: `lamp` of the room must be a table of `x` and `y`, not true or false\n    2 | lamp = true\n      \
             |        ^^^^",
        ),
        (
            "width = 4\n[lamp]\nz = 1",
            "room.toml:3:1: unknown key `z` in `lamp` of the room\n    3 | z = 1\n      | ^\n    help: keys: `x` and `y`",
        ),
    ] {
        assert_eq!(faults(text), expected, "{text}");
    }
}

#[test]
fn all_faults_are_reported_in_the_order_of_the_lines_before_those_of_other_files() {
    let text = "lamp = 1\n[[boxes]]\nsize = 0\n";
    let mut report = FaultReport::new(Path::new("room.toml"), text);
    report.include(Fault::of_file(Path::new("map.png"), "it is half an image").into());
    let document = parse(&mut report, text).expect("TOML");
    read(&mut report, &Section::new("the room", 0..0, document.get_ref()));
    report.file_fault("it is old");
    let faults = report.into_faults();
    let places: Vec<_> = faults
        .list()
        .iter()
        .map(|fault| fault.location.to_string())
        .collect();
    assert_eq!(
        places,
        [
            "room.toml",
            "room.toml:1:1",
            "room.toml:1:8",
            "room.toml:3:8",
            "map.png"
        ]
    );
    assert_eq!(faults.count(), 5);
}

#[test]
fn of_many_faults_the_first_are_shown_and_the_others_counted() {
    let text: String = (0..9_000).map(|key| format!("key{key} = 1\n")).collect();
    let shown = faults(&(text + "width = 1"));
    assert!(shown.ends_with("\nand 8960 more"), "{shown}");
    assert!(shown.len() < 10_000, "{}", shown.len());
}
