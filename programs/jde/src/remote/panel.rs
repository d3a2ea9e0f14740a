//! Formats a schema's panel as text: all that is readable without a window, and the widgets that can be
//! touched. Pictures are described, not drawn.

use std::io::{self, Write};

use jde_drawing::text::counted;
use jde_panel::{Item, List, Shape, Solid, Trace, Words};
use jde_terminal::{BAD, FAINT, GOOD, Style, TITLE, WARN};

use super::table::{Alignment, Cell, Table};

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
    list.walk().filter(|item| {
        matches!(
            item,
            Item::Button { .. }
                | Item::Toggle { .. }
                | Item::Slider { .. }
                | Item::Choice { .. }
                | Item::Image { .. }
                | Item::Canvas { .. }
                | Item::Scene { .. }
        )
    })
}

/// Writes items one below another, also those of a row. Widgets in sequence are aligned in columns.
fn write_items(items: &[Item], depth: usize, words: &mut dyn Write) -> io::Result<()> {
    let indent = "  ".repeat(depth);
    let new_table = || Table::untitled(4).indented(indent.len());
    let mut widgets = new_table();
    for item in items.iter().flat_map(flatten_row) {
        if let Some(cells) = widget_cells(item) {
            widgets.add_row(cells.map(|(text, style)| Cell::from(sanitize(&text)).styled(style)));
            continue;
        }
        std::mem::replace(&mut widgets, new_table()).write(words)?;
        match item {
            Item::Group {
                label, items: inner, ..
            } => {
                writeln!(words, "{indent}{TITLE}{}{TITLE:#}", sanitize(label))?;
                write_items(inner, depth + 1, words)?;
            }
            Item::Table { columns, rows, .. } => {
                let titles = columns.iter().map(|title| (sanitize(title), Alignment::Left));
                let mut table = Table::new(titles).indented(indent.len());
                for row in rows {
                    table.add_row(row.iter().map(|text| Cell::from(sanitize(text))));
                }
                table.write(words)?;
            }
            Item::Text { text, words: how } => {
                let style = style(*how);
                for line in text.lines() {
                    writeln!(words, "{indent}{style}{}{style:#}", sanitize(line))?;
                }
            }
            item => writeln!(words, "{indent}{}", describe_item(item))?,
        }
    }
    widgets.write(words)
}

/// Returns the items of a row, and of the rows in it; any other item alone.
fn flatten_row(item: &Item) -> Vec<&Item> {
    match item {
        Item::Row { items } => items.iter().flat_map(flatten_row).collect(),
        item => vec![item],
    }
}

/// Returns label, value, range and id of a widget; `None` for all other items.
fn widget_cells(item: &Item) -> Option<[(String, Style); 4]> {
    let mut style = Style::new();
    let (id, label, value, range) = match item {
        Item::Value { label, value, unit } => ("", label.clone(), format_number(*value, unit), String::new()),
        Item::Button { id, label, enabled } => {
            style = if *enabled { TITLE } else { FAINT };
            (id.as_str(), format!("[ {label} ]"), String::new(), String::new())
        }
        Item::Toggle { id, label, on } => {
            let value = if *on { "on" } else { "off" };
            (id.as_str(), label.clone(), value.to_owned(), "on, off".to_owned())
        }
        Item::Slider {
            id,
            label,
            value,
            least,
            greatest,
            unit,
        } => {
            let range = format!("{least} to {greatest}");
            (id.as_str(), label.clone(), format_number(*value, unit), range)
        }
        Item::Choice {
            id,
            label,
            options,
            chosen,
        } => {
            let chosen = options.get(*chosen as usize).cloned().unwrap_or_default();
            (id.as_str(), label.clone(), chosen, options.join(", "))
        }
        _ => return None,
    };
    Some([
        (label, style),
        (value, Style::new()),
        (range, FAINT),
        (id.to_owned(), FAINT),
    ])
}

/// Describes a picture or a plot as one line.
fn describe_item(item: &Item) -> String {
    let id = |id: &str| format!("{FAINT}{}{FAINT:#}", sanitize(id));
    match item {
        Item::Image {
            id: name,
            width,
            height,
            ..
        } => format!("image of {width} x {height}  {}", id(name)),
        Item::Plot { label, traces, .. } => {
            let traces: Vec<String> = traces.iter().map(format_trace).collect();
            format!("{}: {}", sanitize(label), traces.join(", "))
        }
        Item::Canvas { id: name, shapes, .. } => {
            let labels = shapes.iter().filter_map(|shape| match shape {
                Shape::Label { text, .. } => Some(text.as_str()),
                _ => None,
            });
            format!(
                "{}  {}",
                describe_picture("plane", shapes.len(), labels),
                id(name)
            )
        }
        Item::Scene { id: name, solids, .. } => {
            let labels = solids.iter().filter_map(|solid| match solid {
                Solid::Label { text, .. } => Some(text.as_str()),
                _ => None,
            });
            format!(
                "{}  {}",
                describe_picture("space", solids.len(), labels),
                id(name)
            )
        }
        _ => String::new(),
    }
}

/// Describes a picture: the number of its shapes, and its labels.
fn describe_picture<'l>(where_: &str, count: usize, labels: impl Iterator<Item = &'l str>) -> String {
    let labels: Vec<_> = labels.map(sanitize).collect();
    let shapes = counted(count as u64, "shape");
    match labels.as_slice() {
        [] => format!("{where_} with {shapes}"),
        labels => format!("{where_} with {shapes}: {}", labels.join(", ")),
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

    fn printed(items: Vec<Item>) -> String {
        let mut words = Vec::new();
        write(&List { time: 0, items }, &mut words).unwrap();
        jde_terminal::escape::without_styles(&String::from_utf8(words).unwrap())
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
    fn texts_values_and_tables_are_printed_and_canvases_described() {
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
  speed             0.1235 m/s
  [ Clear target ]              clear
  what      how far
  door      1.5 m
  somebody  2 m
plane with 1 shape: target  field
";
        let list = vec![
            text("goon", Words::Heading),
            text("two\nlines", Words::Plain),
            group,
            canvas,
        ];
        assert_eq!(printed(list), expected);
    }

    #[test]
    fn label_value_range_and_id_of_widgets_are_aligned() {
        let name = str::to_owned;
        let slider = |id: &str, label: &str, value: f64| Item::Slider {
            id: name(id),
            label: name(label),
            value,
            least: 0.0,
            greatest: 3.0,
            unit: name("m"),
        };
        let list = vec![
            value("nearest", 2.0, "m"),
            slider("ahead", "Looks ahead", 1.25),
            slider("half", "Half width", 0.3),
            Item::Toggle {
                id: name("hold"),
                label: name("Hold"),
                on: true,
            },
            Item::Choice {
                id: name("gait"),
                label: name("Gait"),
                options: vec![name("walk"), name("run")],
                chosen: 1,
            },
        ];
        let expected = "\
nearest      2 m
Looks ahead  1.25 m  0 to 3     ahead
Half width   0.3 m   0 to 3     half
Hold         on      on, off    hold
Gait         run     walk, run  gait
";
        assert_eq!(printed(list), expected);
    }

    #[test]
    fn control_characters_of_a_schema_are_replaced() {
        let printed = printed(vec![
            text("\u{1b}[2Jgone", Words::Plain),
            value("a\u{7}", 1.0, ""),
        ]);
        assert_eq!(printed, "?[2Jgone\na?  1\n");
    }

    #[test]
    fn widgets_are_found_in_rows_and_groups() {
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
