//! The YAML file of a ROS map: its keys, their lines, and the image that it names.
//!
//! It reads what Nav2's map server reads (`loadMapYaml` of `map_io.cpp`, Nav2 of August 2026): each value is a text that is
//! read as a number or a flag, quoted or not. Of a key that is stated twice, the first counts. What a map server does
//! not read is named as left out.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use jde_files::LeftOut;
use saphyr_parser::{Event, Parser};

use crate::cells::{Mode, Thresholds};
use crate::fault::Fault;
use crate::kind::Kind;
use crate::similar::nearest;

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
    pub(crate) image: PathBuf,
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

struct Entry<'a> {
    key: Cow<'a, str>,
    value: Value<'a>,
    /// The line of the value.
    line: usize,
}

struct MapYaml<'a> {
    path: &'a Path,
    entries: Vec<Entry<'a>>,
    faults: Vec<Fault>,
}

/// Returns the image that this text of the YAML file names.
pub(crate) fn image(path: &Path, text: &str) -> Option<PathBuf> {
    MapYaml::new(path, text).ok()?.image()
}

/// Reads the file. Returns all its faults.
pub(crate) fn read(path: &Path, text: &str) -> Result<MapInfo, Vec<Fault>> {
    let mut yaml = MapYaml::new(path, text)?;
    let is_likelihood = |value: f64| (0.0..=1.0).contains(&value);
    let image = yaml.image();
    let resolution = yaml.number("resolution", None, "more than 0 m", |value| {
        value > 0.0 && value <= 1e3
    });
    let origin = yaml.origin();
    let negate = yaml.negate();
    // The default thresholds classify the usual shade of unknown cells, 205, as unknown.
    let occupied = yaml.number("occupied_thresh", Some(0.65), "0 to 1", is_likelihood);
    let free = yaml.number("free_thresh", Some(0.196), "0 to 1", is_likelihood);
    let mode = yaml.mode();
    if let (Some(occupied), Some(free)) = (occupied, free)
        && free > occupied
    {
        yaml.fault(
            "free_thresh",
            format!("is {free}: expected at most `occupied_thresh`, {occupied}"),
        );
    }
    match (image, resolution, origin, negate, occupied, free, mode) {
        (
            Some(image),
            Some(resolution),
            Some(origin),
            Some(negate),
            Some(occupied),
            Some(free),
            Some(mode),
        ) if yaml.faults.is_empty() => Ok(MapInfo {
            image,
            resolution,
            origin,
            mode,
            thresholds: Thresholds {
                negate,
                occupied: occupied as f32,
                free: free as f32,
            },
            left_out: yaml.left_out(),
        }),
        _ => Err(yaml.faults),
    }
}

/// The events of a text, with their lines.
struct Events<'a> {
    parser: Parser<'a, saphyr_parser::StrInput<'a>>,
    /// The line of the last event.
    line: usize,
}

/// The line, and what is wrong there.
type Wrong = (usize, String);

impl<'a> Events<'a> {
    fn next(&mut self) -> Result<Event<'a>, Wrong> {
        match self.parser.next() {
            Some(Ok((event, span))) => {
                self.line = span.start.line();
                Ok(event)
            }
            Some(Err(error)) => Err((error.marker().line(), format!("invalid YAML: {}", error.info()))),
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
                let message = format!("has values more than {MAX_DEPTH} levels deep");
                return Err((self.line, message));
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
    fn entries(&mut self) -> Result<Option<Vec<Entry<'a>>>, Wrong> {
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
            let line = self.line;
            let value = self.value(event)?;
            entries.push(Entry { key, value, line });
            if entries.len() > MAX_KEYS {
                return Err((line, format!("has more than {MAX_KEYS} keys")));
            }
        }
    }
}

const fn is_start(event: &Event<'_>) -> bool {
    matches!(event, Event::MappingStart(..) | Event::SequenceStart(..))
}

impl<'a> MapYaml<'a> {
    fn new(path: &'a Path, text: &'a str) -> Result<Self, Vec<Fault>> {
        let mut events = Events {
            parser: Parser::new_from_str(text),
            line: 1,
        };
        let kind = Kind::of(text.as_bytes()).filter(|kind| *kind != Kind::RosMap);
        let (line, message) = match (events.entries(), kind) {
            // A file of another kind may be YAML by chance.
            (Ok(Some(entries)), _) if entries.iter().any(|entry| KEYS.contains(&&*entry.key)) => {
                let faults = Vec::new();
                return Ok(Self {
                    path,
                    entries,
                    faults,
                });
            }
            (_, Some(kind)) => (1, format!("it is {kind}, and no ROS map: {}", kind.way_to_map())),
            (Err(wrong), None) => wrong,
            (Ok(_), None) => (
                1,
                "expected the YAML of a map: image, resolution, origin, ...".to_owned(),
            ),
        };
        Err(vec![Fault {
            file: path.to_owned(),
            line: Some(line),
            message,
        }])
    }
}

impl MapYaml<'_> {
    /// Returns the path of the image. Nothing stands for the user's folder in it, as in Nav2.
    fn image(&mut self) -> Option<PathBuf> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
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
            let similar = nearest(key, self.entries.iter().map(|entry| &*entry.key));
            let hint = similar
                .map(|similar| format!("; is `{}` meant for it?", similar.escape_debug()))
                .unwrap_or_default();
            self.push(1, format!("`{key}` is missing{hint}"));
        }
        self.find(key)
    }

    /// Names what the map server does not read.
    fn left_out(&self) -> LeftOut {
        let mut left_out = LeftOut::default();
        for (index, Entry { key, line, .. }) in self.entries.iter().enumerate() {
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
        self.push(
            entry.map_or(1, |entry| entry.line),
            format!("`{key}` {}", message.as_ref()),
        );
    }

    fn push(&mut self, line: usize, message: String) {
        self.faults.push(Fault {
            file: self.path.to_owned(),
            line: Some(line),
            message,
        });
    }
}

fn float(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite())
}
