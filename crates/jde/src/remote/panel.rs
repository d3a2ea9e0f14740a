//! Formats a schema's panel as text: all that is readable without a window, and the widgets that can be
//! touched. Pictures are described, not drawn.

use std::io::{self, Write};

use anstyle::Style;
use jde_panel::{Item, List, Shape, Solid, Trace, Words};

use crate::terminal::{BAD, FAINT, GOOD, TITLE, WARN};

/// Writes a list from top to bottom.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn write(list: &List, words: &mut dyn Write) -> io::Result<()> {
    write_items(&list.items, 0, words)
}

/// Returns the touchable widget with this id.
pub(crate) fn find<'l>(list: &'l List, id: &str) -> Option<&'l Item> {
    touchable(list).find(|item| item.id() == Some(id))
}

/// Returns all widgets that can be touched.
pub(crate) fn touchable(list: &List) -> impl Iterator<Item = &Item> + Clone {
    list.walk().filter(|item| match item {
        Item::Button { .. }
        | Item::Toggle { .. }
        | Item::Slider { .. }
        | Item::Choice { .. }
        | Item::Image { .. }
        | Item::Canvas { .. }
        | Item::Scene { .. } => true,
        Item::Text { .. }
        | Item::Value { .. }
        | Item::Plot { .. }
        | Item::Table { .. }
        | Item::Row { .. }
        | Item::Group { .. } => false,
    })
}

fn write_items(items: &[Item], depth: usize, words: &mut dyn Write) -> io::Result<()> {
    let indent = "  ".repeat(depth);
    for item in items {
        match item {
            Item::Group {
                label, items: inner, ..
            } => {
                writeln!(words, "{indent}{TITLE}{}{TITLE:#}", sanitize(label))?;
                self::write_items(inner, depth + 1, words)?;
            }
            Item::Table { columns, rows, .. } => write_table(&indent, columns, rows, words)?,
            Item::Text { text, words: how } => {
                let style = style(*how);
                for line in text.lines() {
                    writeln!(words, "{indent}{style}{}{style:#}", sanitize(line))?;
                }
            }
            Item::Row { items } => {
                let parts: Vec<String> = items.iter().map(format_item).collect();
                writeln!(words, "{indent}{}", parts.join("   "))?;
            }
            item => writeln!(words, "{indent}{}", format_item(item))?,
        }
    }
    Ok(())
}

/// Formats a widget as one line.
fn format_item(item: &Item) -> String {
    let id = |id: &str| format!("{FAINT}{}{FAINT:#}", sanitize(id));
    match item {
        Item::Text { text, words } => {
            let style = style(*words);
            format!("{style}{}{style:#}", sanitize(&text.replace('\n', " ")))
        }
        Item::Value { label, value, unit } => format!("{} {}", sanitize(label), format_number(*value, unit)),
        Item::Button {
            id: name,
            label,
            enabled,
        } => {
            let style = if *enabled { TITLE } else { FAINT };
            format!("{style}[ {} ]{style:#} {}", sanitize(label), id(name))
        }
        Item::Toggle { id: name, label, on } => {
            let mark = if *on { "[x]" } else { "[ ]" };
            format!("{mark} {} {}", sanitize(label), id(name))
        }
        Item::Slider {
            id: name,
            label,
            value,
            least,
            greatest,
            unit,
        } => format!(
            "{} {} {FAINT}of {least} to {greatest}{FAINT:#} {}",
            sanitize(label),
            format_number(*value, unit),
            id(name)
        ),
        Item::Choice {
            id: name,
            label,
            options,
            chosen,
        } => {
            let chosen = options.get(*chosen as usize).map_or("", String::as_str);
            format!(
                "{} {} {FAINT}of {}{FAINT:#} {}",
                sanitize(label),
                sanitize(chosen),
                sanitize(&options.join(", ")),
                id(name)
            )
        }
        Item::Image {
            id: name,
            width,
            height,
            ..
        } => format!("image of {width} x {height} {}", id(name)),
        Item::Plot { label, traces, .. } => {
            let traces: Vec<String> = traces.iter().map(format_trace).collect();
            format!("{}: {}", sanitize(label), traces.join(", "))
        }
        Item::Table { columns, rows, .. } => {
            format!("table of {}: {} rows", sanitize(&columns.join(", ")), rows.len())
        }
        Item::Row { items } | Item::Group { items, .. } => {
            items.iter().map(format_item).collect::<Vec<_>>().join("   ")
        }
        Item::Canvas { id: name, shapes, .. } => {
            let labels = shapes.iter().filter_map(|shape| match shape {
                Shape::Label { text, .. } => Some(text.as_str()),
                Shape::Line { .. }
                | Shape::Points { .. }
                | Shape::Circle { .. }
                | Shape::Polygon { .. }
                | Shape::Arrow { .. }
                | Shape::Robot { .. } => None,
            });
            format!("{} {}", describe_picture("plane", shapes.len(), labels), id(name))
        }
        Item::Scene { id: name, solids, .. } => {
            let labels = solids.iter().filter_map(|solid| match solid {
                Solid::Label { text, .. } => Some(text.as_str()),
                Solid::Line { .. }
                | Solid::Points { .. }
                | Solid::Box { .. }
                | Solid::Sphere { .. }
                | Solid::Cylinder { .. }
                | Solid::Arrow { .. }
                | Solid::Mesh { .. } => None,
            });
            format!("{} {}", describe_picture("space", solids.len(), labels), id(name))
        }
    }
}

/// Describes a picture: the number of its shapes, and its labels.
fn describe_picture<'l>(where_: &str, count: usize, labels: impl Iterator<Item = &'l str>) -> String {
    let labels: Vec<_> = labels.map(sanitize).collect();
    let shapes = if count == 1 { "shape" } else { "shapes" };
    match labels.as_slice() {
        [] => format!("{where_} with {count} {shapes}"),
        labels => format!("{where_} with {count} {shapes}: {}", labels.join(", ")),
    }
}

fn format_trace(trace: &Trace) -> String {
    match trace.points.last() {
        Some([_, last]) => format!("{} {}", sanitize(&trace.name), format_number(*last, "")),
        None => sanitize(&trace.name),
    }
}

fn format_number(value: f64, unit: &str) -> String {
    let rounded = (value * 1e4).round() / 1e4;
    let value = if value.abs() < 1e9 && rounded != 0.0 {
        rounded
    } else {
        value
    };
    match unit {
        "" => value.to_string(),
        unit => format!("{value} {}", sanitize(unit)),
    }
}

fn write_table(
    indent: &str,
    columns: &[String],
    rows: &[Vec<String>],
    words: &mut dyn Write,
) -> io::Result<()> {
    let width = |text: &str| ratatui::text::Span::raw(text).width();
    let shown_rows: Vec<Vec<String>> = rows
        .iter()
        .map(|row| row.iter().map(|text| sanitize(text)).collect())
        .collect();
    let titles: Vec<String> = columns.iter().map(|title| sanitize(title)).collect();
    let widths: Vec<usize> = (0..columns.len())
        .map(|column| {
            let cells = std::iter::once(&titles).chain(&shown_rows);
            cells.map(|row| width(&row[column])).max().unwrap_or(0)
        })
        .collect();
    for (place, row) in std::iter::once(&titles).chain(&shown_rows).enumerate() {
        let style = if place == 0 { FAINT } else { Style::new() };
        let mut line = String::from(indent);
        for (cell, width_of_column) in row.iter().zip(&widths) {
            line.push_str(cell);
            line.push_str(&" ".repeat(width_of_column + 2 - width(cell)));
        }
        writeln!(words, "{style}{}{style:#}", line.trim_end())?;
    }
    Ok(())
}

fn style(words: Words) -> Style {
    match words {
        Words::Plain | Words::Code => Style::new(),
        Words::Heading => TITLE,
        Words::Faint => FAINT,
        Words::Good => GOOD,
        Words::Warning => WARN,
        Words::Error => BAD,
    }
}

/// Replaces control characters by `?`, so that a text from any source is safe for a terminal.
fn sanitize(text: &str) -> String {
    let bearable = |letter: char| if letter.is_control() { '?' } else { letter };
    text.chars().map(bearable).collect()
}

#[cfg(test)]
mod tests {
    use jde_panel::{Color, Ink, Wants};

    use super::*;

    fn told(items: Vec<Item>) -> String {
        let mut words = Vec::new();
        write(&List { time: 0, items }, &mut words).unwrap();
        anstream::adapter::strip_str(&String::from_utf8(words).unwrap()).to_string()
    }

    fn text(text: &str, words: Words) -> Item {
        Item::Text {
            text: text.to_owned(),
            words,
        }
    }

    fn value(label: &str, value: f64, unit: &str) -> Item {
        Item::Value {
            label: label.to_owned(),
            value,
            unit: unit.to_owned(),
        }
    }

    fn button(id: &str) -> Item {
        Item::Button {
            id: id.to_owned(),
            label: "Clear target".to_owned(),
            enabled: true,
        }
    }

    #[test]
    fn texts_values_and_tables_are_told_and_pictures_described() {
        let table = Item::Table {
            id: "seen".to_owned(),
            columns: vec!["what".to_owned(), "how far".to_owned()],
            rows: vec![
                vec!["door".to_owned(), "1.5 m".to_owned()],
                vec!["somebody".to_owned(), "2 m".to_owned()],
            ],
        };
        let canvas = Item::Canvas {
            id: "field".to_owned(),
            area: None,
            forward_up: true,
            shapes: vec![Shape::Label {
                at: [0.0, 0.0],
                text: "target".to_owned(),
                color: Color::Ink(Ink::Goal),
            }],
            wants: Wants::default(),
        };
        let group = Item::Group {
            id: "more".to_owned(),
            label: "More".to_owned(),
            open: true,
            items: vec![
                Item::Row {
                    items: vec![value("speed", 0.123_456_7, "m/s"), button("clear")],
                },
                table,
            ],
        };
        let expected = "\
goon
two
lines
More
  speed 0.1235 m/s   [ Clear target ] clear
  what      how far
  door      1.5 m
  somebody  2 m
plane with 1 shape: target field
";
        let list = vec![
            text("goon", Words::Heading),
            text("two\nlines", Words::Plain),
            group,
            canvas,
        ];
        assert_eq!(told(list), expected);
    }

    #[test]
    fn no_text_of_a_schema_commands_the_terminal() {
        let told = told(vec![
            text("\u{1b}[2Jgone", Words::Plain),
            value("a\u{7}", 1.0, ""),
        ]);
        assert_eq!(told, "?[2Jgone\na? 1\n");
    }

    #[test]
    fn what_can_be_touched_is_found_wherever_it_stands() {
        let row = Item::Row {
            items: vec![button("one")],
        };
        let group = Item::Group {
            id: "all".to_owned(),
            label: String::new(),
            open: false,
            items: vec![row, button("two"), value("x", 1.0, "")],
        };
        let list = List {
            time: 0,
            items: vec![group],
        };
        let ids: Vec<_> = touchable(&list).filter_map(Item::id).collect();
        assert_eq!(ids, ["one", "two"]);
        assert!(find(&list, "two").is_some() && find(&list, "all").is_none());
    }
}
