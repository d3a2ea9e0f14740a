//! The events of an application, newest first: faults, overruns, refusals, operators' actions and all others, and of a
//! recording what schemas logged; filtered by schema, level and words. It keeps no history: it reads that of the timeline.

use std::collections::VecDeque;

use eframe::egui::{self, ComboBox, RichText, Sense, TextEdit, TextWrapMode, Ui};
use egui_extras::{Column, TableBuilder};
use jde_core::Nanos;
use jde_log::log_line::LogLine;
use jde_panel::Ink;
use jde_records::{RecordKind, RunRecord};
use jde_timeline::{MarkKind, Severity, Timeline};
use serde::{Deserialize, Serialize};

use super::Window;
use crate::recorded::Recorded;
use crate::session::WindowSession;
use crate::style::{self, Style};

/// The level of a warning in the log of schemas.
const WARNING: u8 = 30;

/// The least important events that are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Level {
    /// Values that ended, takeovers in time, recoveries.
    All,
    /// Whatever deserves a look: an overrun, a refusal, an operator's action.
    #[default]
    Warnings,
    /// Faults, late takeovers, chattering, stalls.
    Faults,
}

impl Level {
    const ALL: [Self; 3] = [Self::All, Self::Warnings, Self::Faults];

    fn of(kind: MarkKind) -> Self {
        match (kind, kind.severity()) {
            (MarkKind::Other | MarkKind::Delayed, _) | (_, Severity::Good) => Self::All,
            (_, Severity::Warning) => Self::Warnings,
            (_, Severity::Bad) => Self::Faults,
        }
    }

    fn word(self) -> &'static str {
        match self {
            Self::All => "everything",
            Self::Warnings => "warnings and worse",
            Self::Faults => "faults",
        }
    }
}

/// Which events are shown, as saved.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
struct Filter {
    /// Only those of this schema; all if it is empty.
    schema: String,
    level: Level,
    /// All of these words occur in the event.
    words: String,
}

/// The window.
#[derive(Default)]
pub(crate) struct EventsWindow {
    filter: Filter,
    /// One for each event that the timeline keeps.
    rows: VecDeque<EventRow>,
    made_of: Source,
}

/// What the rows were made from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Source {
    /// Whether it is the timeline of a whole recording.
    is_whole: bool,
    /// How often the timeline went back.
    rewinds: u64,
    /// How many records had arrived in it.
    received: u64,
}

/// An event as shown.
struct EventRow {
    time: Nanos,
    level: Level,
    kind: String,
    schema: String,
    by: String,
    text: String,
    /// Everything in lower case, for the search.
    searched: String,
}

impl EventRow {
    fn of(record: &RunRecord) -> Option<Self> {
        let RunRecord::Other(event) = record else {
            return None;
        };
        let owned = |text: Option<&str>| text.unwrap_or_default().to_owned();
        let (kind, schema) = (
            event.what.kind().to_owned(),
            owned(event.what.schema().map(String::as_str)),
        );
        let (by, text) = (owned(event.what.by()), event.text());
        Some(Self {
            time: event.time,
            level: Level::of(MarkKind::of(&event.what)),
            searched: format!("{kind} {schema} {by} {text}").to_lowercase(),
            kind,
            schema,
            by,
            text,
        })
    }
}

impl EventRow {
    /// A line that a schema logged.
    fn of_line(line: &LogLine) -> Self {
        let LogLine {
            time,
            level,
            schema,
            text,
        } = line;
        Self {
            time: *time,
            level: if *level >= WARNING {
                Level::Warnings
            } else {
                Level::All
            },
            searched: format!("log {schema} {text}").to_lowercase(),
            kind: "log".to_owned(),
            schema: schema.clone(),
            by: String::new(),
            text: text.clone(),
        }
    }
}

impl EventsWindow {
    /// Opens the window with its saved state.
    pub(crate) fn open(saved: &serde_json::Value) -> Self {
        Self {
            filter: serde_json::from_value(saved.clone()).unwrap_or_default(),
            ..Self::default()
        }
    }

    /// Takes the events of a timeline that came since the last call, and drops the rows of those that it keeps no more.
    fn read(&mut self, timeline: &Timeline, recorded: Option<&[LogLine]>) {
        let is_whole = recorded.is_some();
        let log = timeline.log();
        let source = Source {
            is_whole,
            rewinds: timeline.rewinds(),
            received: log.received(),
        };
        let known = std::mem::replace(&mut self.made_of, source);
        if source == known {
            return;
        }
        let (before, now) = ((known.is_whole, known.rewinds), (is_whole, source.rewinds));
        if before != now || source.received < known.received {
            self.rows.clear();
        }
        let events = log.of(RecordKind::Event);
        if let Some(lines) = recorded {
            self.rows = events
                .filter_map(EventRow::of)
                .chain(lines.iter().map(EventRow::of_line))
                .collect();
            self.rows.make_contiguous().sort_by_key(|row| row.time);
            return;
        }
        let kept = events.len();
        let new = match self.rows.is_empty() {
            true => kept,
            false => {
                let records = log.since(known.received);
                let is_event = |record: &&RunRecord| record.kind() == RecordKind::Event;
                records.iter().filter(is_event).count()
            }
        };
        self.rows
            .extend(events.skip(kept.saturating_sub(new)).filter_map(EventRow::of));
        let dropped = self.rows.len().saturating_sub(kept);
        self.rows.drain(..dropped);
    }

    /// The places of the events to show, newest first.
    fn shown(&self) -> Vec<usize> {
        let words: Vec<_> = self
            .filter
            .words
            .split_whitespace()
            .map(str::to_lowercase)
            .collect();
        let passes = |row: &EventRow| {
            row.level >= self.filter.level
                && (self.filter.schema.is_empty() || row.schema == self.filter.schema)
                && words.iter().all(|word| row.searched.contains(word))
        };
        let rows = self.rows.iter().enumerate().rev();
        rows.filter(|(_, row)| passes(row))
            .map(|(place, _)| place)
            .collect()
    }

    fn head(&mut self, ui: &mut Ui, session: &WindowSession, count: usize) {
        ui.horizontal_wrapped(|ui| {
            let name = ui.label("Search");
            let field = TextEdit::singleline(&mut self.filter.words)
                .hint_text("words of the event")
                .desired_width(160.0);
            ui.add(field).labelled_by(name.id);
            let levels = ComboBox::from_id_salt("level").selected_text(self.filter.level.word());
            let levels = levels.show_ui(ui, |ui| {
                for level in Level::ALL {
                    ui.selectable_value(&mut self.filter.level, level, level.word());
                }
            });
            levels.response.accessible_name("Level");
            let all = "all schemas";
            let chosen = match self.filter.schema.as_str() {
                "" => all,
                schema => schema,
            };
            let schemas = ComboBox::from_id_salt("schema").selected_text(chosen);
            let schemas = schemas.show_ui(ui, |ui| {
                ui.selectable_value(&mut self.filter.schema, String::new(), all);
                for schema in &session.schemas().schemas {
                    let name = schema.name.clone();
                    ui.selectable_value(&mut self.filter.schema, name, &schema.name);
                }
            });
            schemas.response.accessible_name("Schema");
            if self.filter != Filter::default() && ui.small_button("Reset").clicked() {
                self.filter = Filter::default();
            }
            ui.weak(format!("{count} of {}", self.rows.len()));
        });
        ui.add_space(2.0);
    }
}

impl Window for EventsWindow {
    fn show(&mut self, ui: &mut Ui, session: &WindowSession, style: &Style) {
        if let Some(schema) = session.requested_events() {
            self.filter = Filter {
                schema: schema.unwrap_or_default(),
                ..Filter::default()
            };
        }
        let past = session.recorded().and_then(Recorded::past);
        let timeline = past.as_ref().map_or(session.timeline(), |past| &past.timeline);
        self.read(timeline, past.as_ref().map(|past| past.log.as_slice()));
        let shown = self.shown();
        self.head(ui, session, shown.len());
        if shown.is_empty() {
            ui.weak(if self.rows.is_empty() {
                "Nothing has happened yet but selections, whose reasons are in the oscilloscope."
            } else {
                "No event passes the filter."
            });
            return;
        }
        ui.style_mut().wrap_mode = Some(TextWrapMode::Truncate);
        let line = ui.spacing().interact_size.y;
        let mut table = TableBuilder::new(ui)
            .striped(true)
            .resizable(true)
            .auto_shrink(false)
            .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
            .column(Column::initial(78.0).at_least(50.0).clip(true))
            .column(Column::initial(96.0).at_least(50.0).clip(true))
            .column(Column::initial(110.0).at_least(50.0).clip(true))
            .column(Column::remainder().at_least(120.0).clip(true));
        if session.is_recording() {
            table = table.sense(Sense::click());
        }
        let titles = ["Time", "Kind", "Schema", "Event"];
        let table = table.header(line, |mut header| {
            titles
                .iter()
                .for_each(|title| drop(header.col(|ui| drop(ui.strong(*title)))));
        });
        table.body(|body| {
            body.rows(line, shown.len(), |mut table| {
                let Some(row) = shown.get(table.index()).and_then(|place| self.rows.get(*place)) else {
                    return;
                };
                let color = style::color_of(color(row), style);
                let time_s = row.time as f64 / 1e9;
                table.col(|ui| drop(ui.label(format!("{time_s:.3} s"))));
                table.col(|ui| drop(ui.label(RichText::new(&row.kind).color(color))));
                table.col(|ui| drop(ui.label(&row.schema)));
                table.col(|ui| {
                    let text = match row.by.as_str() {
                        "" => row.text.clone(),
                        by => format!("{} (by {by})", row.text),
                    };
                    ui.label(&text).on_hover_text(text);
                });
                if table.response().clicked() {
                    session.seek_switch(time_s);
                }
            });
        });
    }

    fn keep(&self) -> serde_json::Value {
        serde_json::to_value(&self.filter).unwrap_or_default()
    }
}

fn color(row: &EventRow) -> Ink {
    match row.level {
        Level::All => Ink::Faint,
        Level::Warnings => Ink::Warn,
        Level::Faults => Ink::Bad,
    }
}

#[cfg(test)]
mod tests {
    use jde_records::event::What;
    use jde_timeline::{Hierarchy, Keep};

    use super::*;

    fn add(timeline: &mut Timeline, time: Nanos) {
        let overrun = What::Overrun {
            schema: "goon".to_owned(),
            took: 2,
            budget: 1,
        };
        timeline.add(&RunRecord::Other(overrun.at(time)));
    }

    fn times(window: &EventsWindow) -> Vec<Nanos> {
        window.rows.iter().map(|row| row.time).collect()
    }

    #[test]
    fn the_rows_are_those_of_the_events_that_the_timeline_keeps() {
        let mut keep = Keep::LIVE;
        keep.records.records = 3;
        let mut timeline = Timeline::new(Hierarchy::default(), keep);
        let mut window = EventsWindow::default();
        window.read(&timeline, None);
        assert!(times(&window).is_empty());
        for time in 1..=2 {
            add(&mut timeline, time);
        }
        window.read(&timeline, None);
        assert_eq!(times(&window), [1, 2]);
        for time in 3..=4 {
            add(&mut timeline, time);
        }
        window.read(&timeline, None);
        assert_eq!(times(&window), [2, 3, 4]);
        for time in 5..=9 {
            add(&mut timeline, time);
        }
        window.read(&timeline, None);
        assert_eq!(times(&window), [7, 8, 9]);
        let mut whole = Timeline::new(Hierarchy::default(), Keep::ALL);
        for time in 1..=20 {
            add(&mut whole, time);
        }
        let line = |time| LogLine {
            time,
            level: 40,
            schema: "goon".to_owned(),
            text: "no laser".to_owned(),
        };
        window.read(&whole, Some(&[line(5), line(30)]));
        assert_eq!(times(&window).len(), 22);
        assert_eq!(window.rows.back().map(|row| row.kind.as_str()), Some("log"));
    }
}
