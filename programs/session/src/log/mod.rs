//! The log of the host and the schemas: lines on standard error, or kept lines while the oscilloscope uses
//! the screen.
//!
//! Logging never fails, and never waits for a reader while a robot moves: a line that is not read in time is
//! dropped and counted. When no robot moves, the thread that started the log waits for the reader. All other threads
//! never wait, because a library such as the link would stand still. A warning of a schema that says the same again is counted, too.

mod filter;
mod printed;
mod repeats;

use std::collections::VecDeque;
use std::fmt::{self, Write as _};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::thread::{self, ThreadId};

use jde_host::Handle;
use jde_terminal::{self as terminal, BAD, FAINT, Style, WARN};
use parking_lot::{Mutex, MutexGuard};
use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::subscriber::Interest;
use tracing::{Event, Level, Metadata, Subscriber, span};

use printed::{PRINTED_TARGET, PrintedLines};
use repeats::{Counted, Repeats};

pub use filter::Filter;

/// Number of lines kept while the oscilloscope uses the screen: more than it can show.
const MAX_BUFFERED: usize = 200;

/// The tracing target of lines that repeat an event of the application.
const EVENT_TARGET: &str = "jde::event";

/// The log of this process.
#[derive(Clone)]
pub struct Log {
    sink: Arc<Mutex<Sink>>,
    /// The thread that started it.
    owner: ThreadId,
}

#[derive(Default)]
struct Sink {
    /// Lines to print as soon as the sink is unlocked, since printing may wait.
    ready: Vec<String>,
    /// The application whose time the lines show.
    clock: Option<Handle>,
    /// Lines that are kept instead of written.
    buffered: Option<VecDeque<String>>,
    /// The warnings of schemas that were written.
    repeats: Repeats,
    /// What schemas printed.
    printed: PrintedLines,
    /// Lines that stay on the screen of the oscilloscope, from its beginning.
    pinned: Vec<String>,
    /// Where the lines go in addition.
    forward: Option<SyncSender<LogRecord>>,
    /// Who receives the lines of schemas besides, and the lines for it. It may wait, as printing may.
    observer: Option<LineObserver>,
    observed: Vec<LogRecord>,
    /// Whether something else shows events, so that their lines are not shown.
    shows_events: bool,
}

/// Receives lines of the log.
pub type LineObserver = Arc<dyn Fn(&LogRecord) + Send + Sync>;

/// A line of the log.
#[derive(Clone, Debug)]
pub struct LogRecord {
    /// Its level.
    pub level: Level,
    /// The schema that wrote it; `None` for the host.
    pub schema: Option<String>,
    /// Its text.
    pub message: String,
}

struct LogSubscriber {
    filter: Filter,
    log: Log,
}

impl Log {
    /// Starts to log all events of this process that `filter` selects.
    pub fn start(filter: Filter) -> Self {
        let log = Self {
            sink: Arc::default(),
            owner: thread::current().id(),
        };
        let listener = LogSubscriber {
            filter,
            log: log.clone(),
        };
        // This fails only at a second call. The first log stays.
        let _ = tracing::subscriber::set_global_default(listener);
        log
    }

    /// Shows the time of this application in each line, until [`Self::clear_clock`].
    pub fn set_clock(&self, handle: &Handle) {
        self.sink().clock = Some(handle.clone());
    }

    /// Drops the handle of the application and the observer of its lines. Later lines show no time.
    pub fn clear_clock(&self) {
        self.print(|sink| {
            let rest = sink.repeats.rest();
            sink.write_counted(rest);
            for (schema, text) in sink.printed.rest() {
                sink.write_of(Level::INFO, &schema, &text);
            }
            (sink.clock, sink.observer) = (None, None);
        });
    }

    /// Sends the following lines here as well. What the receiver does not take in time is dropped.
    pub fn forward(&self, sender: SyncSender<LogRecord>) {
        self.sink().forward = Some(sender);
    }

    /// Lets `observer` receive the following lines of schemas, outside any lock of the log. Those of the host are not for it,
    /// since it may write some itself.
    pub fn observe(&self, observer: LineObserver) {
        self.sink().observer = Some(observer);
    }

    /// Shows no lines that repeat events from now on, or shows them again: something else shows these events.
    pub fn hide_events(&self, hide: bool) {
        self.sink().shows_events = hide;
    }

    /// Shows a line at once, and again where the oscilloscope uses the screen. It goes nowhere else: it may be a secret.
    pub fn pin(&self, line: String) {
        self.print(|sink| {
            sink.ready.push(line.clone());
            sink.pinned.push(line);
        });
    }

    /// Keeps all following lines if `keep` is set. Otherwise writes the kept lines and all that follow.
    pub fn set_buffered(&self, keep: bool) {
        self.print(|sink| {
            let previous_buffer = std::mem::replace(
                &mut sink.buffered,
                keep.then(|| VecDeque::from(sink.pinned.clone())),
            );
            sink.ready.extend(previous_buffer.into_iter().flatten());
        });
    }

    /// Returns the kept lines, oldest first.
    pub fn buffered_lines(&self) -> Vec<String> {
        self.sink().buffered.iter().flatten().cloned().collect()
    }

    fn sink(&self) -> MutexGuard<'_, Sink> {
        self.sink.lock()
    }

    fn write_line(&self, metadata: &Metadata<'_>, line: &LogLine) {
        self.print(|sink| {
            let now = sink.seconds();
            sink.write_line(now, metadata, line);
        });
    }

    /// Changes the sink, and prints the lines that this makes ready.
    fn print(&self, change: impl FnOnce(&mut Sink)) {
        let mut sink = self.sink();
        change(&mut sink);
        let ready = std::mem::take(&mut sink.ready);
        let observed = std::mem::take(&mut sink.observed);
        let observer = sink.observer.clone();
        drop(sink);
        if let Some(observer) = observer {
            observed.iter().for_each(|line| observer(line));
        }
        let mut output = match thread::current().id() == self.owner {
            true => terminal::err(),
            false => terminal::err_without_waiting(),
        };
        for line in ready {
            // There is nowhere to report that standard error cannot be written.
            let _ = writeln!(output, "{line}");
        }
    }
}

impl Sink {
    /// Returns the time of the application, s.
    fn seconds(&self) -> Option<f64> {
        self.clock.as_ref().map(|handle| handle.now() as f64 / 1e9)
    }

    /// Writes a line at this time of the application, s, unless it repeats another.
    fn write_line(&mut self, now: Option<f64>, metadata: &Metadata<'_>, line: &LogLine) {
        let (level, text) = (*metadata.level(), line.text());
        if metadata.target() == PRINTED_TARGET {
            return self.write_printed(now, line.schema.as_deref().unwrap_or_default(), &text);
        }
        if let Some(now) = now {
            let due = self.repeats.due(now);
            self.write_counted(due);
            if let Some(schema) = &line.schema
                && level == Level::WARN
                && !self.repeats.is_shown(schema, &text, now)
            {
                return;
            }
        }
        // To forward a line of a library that sends lines would cause the next one.
        if metadata.target().starts_with("jde") {
            self.forward(level, line.schema.as_deref(), &text);
        }
        if !(self.shows_events && metadata.target() == EVENT_TARGET) {
            self.write(level, &line.to_string());
        }
    }

    /// Writes what a schema printed at this time of the application, s.
    fn write_printed(&mut self, now: Option<f64>, schema: &str, text: &str) {
        let (is_shown, hidden) = self.printed.take(schema, now.unwrap_or_default());
        for text in hidden.iter().map(String::as_str).chain(is_shown.then_some(text)) {
            self.write_of(Level::INFO, schema, text);
        }
    }

    /// Writes warnings that were counted.
    fn write_counted(&mut self, warnings: Vec<Counted>) {
        for Counted { schema, text } in warnings {
            self.write_of(Level::WARN, &schema, &text);
        }
    }

    fn write_of(&mut self, level: Level, schema: &str, text: &str) {
        self.forward(level, Some(schema), text);
        self.write(level, &format!("{schema}: {text}"));
    }

    fn forward(&mut self, level: Level, schema: Option<&str>, text: &str) {
        if self.forward.is_none() && self.observer.is_none() {
            return;
        }
        let line = LogRecord {
            level,
            schema: schema.map(str::to_owned),
            message: text.to_owned(),
        };
        if self.observer.is_some() && schema.is_some() {
            self.observed.push(line.clone());
        }
        if let Some(forward) = &self.forward {
            let _ = forward.try_send(line);
        }
    }

    fn write(&mut self, level: Level, line: &str) {
        let time = self.seconds();
        match &mut self.buffered {
            Some(buffer) => {
                if buffer.len() == MAX_BUFFERED {
                    buffer.pop_front();
                }
                buffer.push_back(format!("{:.3} {} {line}", time.unwrap_or_default(), name(level)));
            }
            None => {
                let style = style(level);
                // Without an application's clock, a line has no time.
                let time = time.map_or_else(String::new, |time| format!("{time:>9.3} s  "));
                let level = name(level);
                self.ready
                    .push(format!("{time}{style}{level:<5}{style:#} {line}"));
            }
        }
    }
}

impl Subscriber for LogSubscriber {
    fn register_callsite(&self, metadata: &'static Metadata<'static>) -> Interest {
        if self.enabled(metadata) {
            Interest::always()
        } else {
            Interest::never()
        }
    }

    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.is_event() && *metadata.level() <= self.filter.max_level()
    }

    fn max_level_hint(&self) -> Option<LevelFilter> {
        Some(self.filter.max_level())
    }

    fn new_span(&self, _: &span::Attributes<'_>) -> span::Id {
        span::Id::from_u64(1)
    }

    fn record(&self, _: &span::Id, _: &span::Record<'_>) {}

    fn record_follows_from(&self, _: &span::Id, _: &span::Id) {}

    fn event(&self, event: &Event<'_>) {
        let metadata = event.metadata();
        let mut line = LogLine::default();
        event.record(&mut line);
        if self
            .filter
            .is_enabled(metadata.target(), line.schema.as_deref(), *metadata.level())
        {
            self.log.write_line(metadata, &line);
        }
    }

    fn enter(&self, _: &span::Id) {}

    fn exit(&self, _: &span::Id) {}
}

/// An event as text.
#[derive(Default)]
struct LogLine {
    schema: Option<String>,
    message: String,
    rest: String,
}

impl Visit for LogLine {
    fn record_str(&mut self, field: &Field, value: &str) {
        match field.name() {
            "schema" => self.schema = Some(value.to_owned()),
            "message" => self.message.push_str(value),
            name => {
                let _ = write!(self.rest, " {name}={value}");
            }
        }
    }

    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        let _ = match field.name() {
            "message" => write!(self.message, "{value:?}"),
            name => write!(self.rest, " {name}={value:?}"),
        };
    }
}

impl fmt::Display for LogLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(schema) = &self.schema {
            write!(f, "{schema}: ")?;
        }
        f.write_str(&self.text())
    }
}

impl LogLine {
    /// The text without the schema. One event is one line, even if a schema's message has several.
    fn text(&self) -> String {
        if self.message.is_empty() {
            return self.rest.trim_start().to_owned();
        }
        self.message.replace('\n', "; ") + &self.rest
    }
}

fn name(level: Level) -> String {
    level.as_str().to_lowercase()
}

fn style(level: Level) -> Style {
    match level {
        Level::ERROR => BAD,
        Level::WARN => WARN,
        Level::INFO => Style::new(),
        Level::DEBUG | Level::TRACE => FAINT,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::sync_channel;

    use super::*;

    #[test]
    fn a_repeated_warning_is_forwarded_as_it_is_shown() {
        let (sender, forwarded) = sync_channel(100);
        let mut sink = Sink {
            buffered: Some(VecDeque::new()),
            forward: Some(sender),
            ..Sink::default()
        };
        let callsite = tracing::callsite!(name: "warning", kind: tracing::metadata::Kind::EVENT, target: "jde", level: Level::WARN, fields: message);
        for tick in 0..=300 {
            let line = LogLine {
                schema: Some("slam".to_owned()),
                message: format!("the odometry jumped by {tick} m"),
                ..LogLine::default()
            };
            let now = f64::from(tick) / 5.0;
            sink.write_line(Some(now), tracing::callsite::Callsite::metadata(callsite), &line);
        }
        let forwarded: Vec<_> = forwarded.try_iter().map(|line| line.message).collect();
        let expected = [
            "the odometry jumped by 0 m",
            "the odometry jumped by 299 m (299 more times)",
        ];
        assert_eq!(forwarded, expected);
        let shown: Vec<_> = sink.buffered.into_iter().flatten().collect();
        let expected = expected.map(|text| format!("0.000 warn slam: {text}"));
        assert_eq!(shown, expected);
    }
}
