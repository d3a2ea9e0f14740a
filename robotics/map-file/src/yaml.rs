//! The YAML file of a ROS map: its keys, their lines, and the image that it names.
//!
//! It reads what Nav2's map server reads (`loadMapYaml` of `map_io.cpp`, Nav2 of August 2026): each value is a text that is
//! read as a number or a flag, quoted or not. Of a key that is stated twice, the first counts. What a map server does
//! not read is named as left out.

use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};

use jde_document::{FaultReport, quote, quote_all};
use jde_files::LeftOut;
use jde_nearest::nearest;
use saphyr_parser::{Event, Parser};

use crate::cells::{Mode, Thresholds};
use crate::kind::Kind;

/// The keys that a map server reads.
const KEYS: [&str; 7] = [
    "image",
    "mode",
    "resolution",
    "origin",
    "negate",
    "occupied_thresh",
    "free_thresh",
];
/// Most keys of a file: enough for what any program adds.
const MAX_KEYS: usize = 1000;
/// Most levels of a value that is left out.
const MAX_DEPTH: usize = 64;

/// The contents of the file.
pub(crate) struct MapInfo {
    /// The length of a cell's side in metres.
    pub(crate) resolution: f64,
    /// The lower left corner of the image in the world: x, y in metres and the heading in radians.
    pub(crate) origin: [f64; 3],
    pub(crate) mode: Mode,
    pub(crate) thresholds: Thresholds,
    pub(crate) left_out: LeftOut,
}

/// A value as it is written.
enum Value<'a> {
    Text(Cow<'a, str>),
    List(Vec<Cow<'a, str>>),
    /// Another one, such as a table.
    Other,
}

struct YamlEntry<'a> {
    key: Cow<'a, str>,
    value: Value<'a>,
    /// The line of the value, from 1.
    line: usize,
    /// The value, in characters from the start of the file.
    place: Range<usize>,
}

/// The entries of the file, and its faults.
struct MapYaml<'a, 'r, 't> {
    report: &'r mut FaultReport<'t>,
    entries: Vec<YamlEntry<'a>>,
}

/// Reads the file: the image that it names, also if something else is wrong, and the rest. Reports all its faults.
pub(crate) fn read(report: &mut FaultReport<'_>, text: &str) -> (Option<PathBuf>, Option<MapInfo>) {
    match entries(report, text) {
        Some(entries) => {
            let mut yaml = MapYaml { report, entries };
            (yaml.image(), yaml.info())
        }
        None => (None, None),
    }
}

/// The events of a text, with their lines.
struct Events<'a> {
    parser: Parser<'a, saphyr_parser::StrInput<'a>>,
    /// The line of the last event, from 1.
    line: usize,
    /// The last event, in characters from the start of the text.
    place: Range<usize>,
}

/// Where something is wrong, in characters from the start of the text, and what.
type Wrong = (Range<usize>, String);

impl<'a> Events<'a> {
    fn next(&mut self) -> Result<Event<'a>, Wrong> {
        match self.parser.next() {
            Some(Ok((event, span))) => {
                self.line = span.start.line();
                self.place = span.start.index()..span.end.index();
                Ok(event)
            }
            Some(Err(error)) => {
                let at = error.marker().index();
                Err((at..at, format!("this is not YAML: {}", error.info())))
            }
            None => Ok(Event::StreamEnd),
        }
    }

    /// Reads the rest of a value whose first event is given.
    fn skip(&mut self, event: &Event<'_>) -> Result<(), Wrong> {
        let mut depth = usize::from(is_start(event));
        while depth > 0 {
            match self.next()? {
                Event::MappingEnd | Event::SequenceEnd => depth -= 1,
                Event::StreamEnd => break,
                event if is_start(&event) => depth += 1,
                _ => {}
            }
            if depth > MAX_DEPTH {
                let message = format!("this is more than {MAX_DEPTH} levels deep");
                return Err((self.place.clone(), message));
            }
        }
        Ok(())
    }

    /// Reads a value whose first event is given.
    fn value(&mut self, event: Event<'a>) -> Result<Value<'a>, Wrong> {
        match event {
            Event::Scalar(text, ..) => Ok(Value::Text(text)),
            Event::SequenceStart(..) => {
                let (mut items, mut is_flat) = (Vec::new(), true);
                loop {
                    match self.next()? {
                        Event::SequenceEnd | Event::StreamEnd => break,
                        Event::Scalar(text, ..) => items.push(text),
                        other => {
                            is_flat = false;
                            self.skip(&other)?;
                        }
                    }
                }
                Ok(if is_flat { Value::List(items) } else { Value::Other })
            }
            other => {
                self.skip(&other)?;
                Ok(Value::Other)
            }
        }
    }

    /// Reads the entries of the first document, if it is a table.
    fn entries(&mut self) -> Result<Option<Vec<YamlEntry<'a>>>, Wrong> {
        loop {
            match self.next()? {
                Event::StreamStart | Event::DocumentStart(_) => {}
                Event::MappingStart(..) => break,
                _ => return Ok(None),
            }
        }
        let mut entries = Vec::new();
        loop {
            let key = match self.next()? {
                Event::MappingEnd | Event::StreamEnd => return Ok(Some(entries)),
                Event::Scalar(text, ..) => text,
                other => {
                    self.skip(&other)?;
                    Cow::Borrowed("?")
                }
            };
            let event = self.next()?;
            let (line, start) = (self.line, self.place.clone());
            let value = self.value(event)?;
            let place = start.start..self.place.end;
            entries.push(YamlEntry {
                key,
                value,
                line,
                place,
            });
            if entries.len() > MAX_KEYS {
                return Err((start, format!("this is more than {MAX_KEYS} keys")));
            }
        }
    }
}

const fn is_start(event: &Event<'_>) -> bool {
    matches!(event, Event::MappingStart(..) | Event::SequenceStart(..))
}

/// Reads the entries of a map. Reports a text that is none.
fn entries<'a>(report: &mut FaultReport<'_>, text: &'a str) -> Option<Vec<YamlEntry<'a>>> {
    let mut events = Events {
        parser: Parser::new_from_str(text),
        line: 1,
        place: 0..0,
    };
    let kind = Kind::of(text.as_bytes()).filter(|kind| *kind != Kind::RosMap);
    match (events.entries(), kind) {
        // A file of another kind may be YAML by chance.
        (Ok(Some(entries)), _) if entries.iter().any(|entry| KEYS.contains(&&*entry.key)) => {
            return Some(entries);
        }
        (_, Some(kind)) => {
            report.file_fault(format!("it is {kind}, and no ROS map: {}", kind.way_to_map()));
        }
        (Err((place, message)), None) => {
            report.fault(&report.in_bytes(&place), message);
        }
        (Ok(_), None) => {
            report
                .file_fault("it is not the YAML file of a map")
                .advise(format!("such a file states {}", quote_all(KEYS)));
        }
    }
    None
}

impl MapYaml<'_, '_, '_> {
    fn info(&mut self) -> Option<MapInfo> {
        let is_likelihood = |value: f64| (0.0..=1.0).contains(&value);
        let resolution = self.number("resolution", None, "more than 0 m", |value| {
            value > 0.0 && value <= 1e3
        });
        let origin = self.origin();
        let negate = self.negate();
        // The default thresholds classify the usual shade of unknown cells, 205, as unknown.
        let occupied = self.number("occupied_thresh", Some(0.65), "0 to 1", is_likelihood);
        let free = self.number("free_thresh", Some(0.196), "0 to 1", is_likelihood);
        let mode = self.mode();
        let (occupied, free) = (occupied?, free?);
        if free > occupied {
            let message = format!("is {free}: expected at most `occupied_thresh`, {occupied}");
            self.fault("free_thresh", message);
        }
        Some(MapInfo {
            resolution: resolution?,
            origin: origin?,
            mode: mode?,
            thresholds: Thresholds {
                negate: negate?,
                occupied: occupied as f32,
                free: free as f32,
            },
            left_out: self.left_out(),
        })
    }

    /// Returns the path of the image. Nothing stands for the user's folder in it, as in Nav2.
    fn image(&mut self) -> Option<PathBuf> {
        let folder = self.report.file().parent().unwrap_or(Path::new(""));
        match self.get("image")? {
            Value::Text(name) if name.starts_with("~/") => {
                let message = "begins with `~`, which stands for nothing in a map: write the whole path";
                self.fault("image", message);
                None
            }
            Value::Text(name) if !name.is_empty() => Some(folder.join(&**name)),
            _ => {
                self.fault("image", "is not the name of a file");
                None
            }
        }
    }

    fn origin(&mut self) -> Option<[f64; 3]> {
        let values: Option<Vec<f64>> = match self.get("origin")? {
            Value::List(items) => items.iter().map(|item| float(item)).collect(),
            Value::Text(_) | Value::Other => None,
        };
        match values.as_deref() {
            Some(&[x, y, yaw]) if [x, y, yaw].iter().all(|value| value.abs() <= 1e5) => Some([x, y, yaw]),
            _ => {
                self.fault("origin", "is not [x, y, yaw] in metres and radians");
                None
            }
        }
    }

    /// Reads a flag: an integer, or a word of YAML 1.1 in small letters, in capitals or with a capital first.
    fn negate(&mut self) -> Option<bool> {
        let text = match self.find("negate") {
            None => return Some(false),
            Some(Value::Text(text)) => text.trim().to_owned(),
            Some(_) => String::new(),
        };
        let lower = text.to_ascii_lowercase();
        let is_word = text == lower || text == text.to_ascii_uppercase() || text.get(1..) == lower.get(1..);
        match (text.parse::<i64>(), lower.as_str()) {
            (Ok(number), _) => Some(number != 0),
            (_, "true" | "yes" | "on" | "y") if is_word => Some(true),
            (_, "false" | "no" | "off" | "n") if is_word => Some(false),
            _ => {
                self.fault("negate", "is no flag: expected 0, 1, true, false, yes or no");
                None
            }
        }
    }

    fn mode(&mut self) -> Option<Mode> {
        let mode = match self.find("mode") {
            None => return Some(Mode::Trinary),
            Some(Value::Text(text)) => Mode::named(&text.to_ascii_lowercase()),
            Some(_) => None,
        };
        if mode.is_none() {
            self.fault("mode", "is none of `trinary`, `scale` and `raw`");
        }
        mode
    }

    fn number(
        &mut self,
        key: &str,
        default: Option<f64>,
        expected: &str,
        fits: impl Fn(f64) -> bool,
    ) -> Option<f64> {
        let number = match (self.find(key), default) {
            (None, Some(default)) => return Some(default),
            (None, None) => return self.get(key).and(None),
            (Some(Value::Text(text)), _) => float(text),
            (Some(_), _) => None,
        };
        match number {
            Some(value) if fits(value) => Some(value),
            Some(value) => {
                self.fault(key, format!("is {value}: expected {expected}"));
                None
            }
            None => {
                self.fault(key, format!("is not a number: expected {expected}"));
                None
            }
        }
    }

    fn find(&self, key: &str) -> Option<&Value<'_>> {
        let entry = self.entries.iter().find(|entry| entry.key == key);
        entry.map(|entry| &entry.value)
    }

    /// Returns a required key. If it is missing, the fault names the most similar key.
    fn get(&mut self, key: &str) -> Option<&Value<'_>> {
        if self.find(key).is_none() {
            let others = self.entries.iter().map(|entry| &*entry.key);
            let fault = self.report.file_fault(format!("`{key}` is missing"));
            fault.suggest_by(|| Some(format!("is {} meant for it?", quote(nearest(key, others)?))));
        }
        self.find(key)
    }

    /// Names what the map server does not read.
    fn left_out(&self) -> LeftOut {
        let mut left_out = LeftOut::default();
        for (index, YamlEntry { key, line, .. }) in self.entries.iter().enumerate() {
            let why = if !KEYS.contains(&&**key) {
                "no map server reads it"
            } else if self.entries[..index].iter().any(|earlier| earlier.key == *key) {
                "it is stated twice, and the first one counts"
            } else {
                continue;
            };
            left_out.add(
                format_args!("the key `{}`", key.escape_debug()),
                Some(&format_args!("line {line}")),
                why,
            );
        }
        left_out
    }

    fn fault(&mut self, key: &str, message: impl AsRef<str>) {
        let entry = self.entries.iter().find(|entry| entry.key == key);
        let span = entry.map_or(0..0, |entry| self.report.in_bytes(&entry.place));
        self.report.fault(&span, format!("`{key}` {}", message.as_ref()));
    }
}

fn float(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite())
}
