//! The channels of an application, which are those of its recordings: every variable with the definition and the encoding that
//! a recording has, decisions, states, events and panels. One is added, which Foxglove shows as a log: the lines of the page.

use std::sync::Arc;

use jde_link::{PanelSample, Sample};
use jde_log::{log_line, panel, record};
use jde_records::{RecordKind, RunRecord};
use jde_ros::cdr;
use serde_json::{Value, json};

use super::outbox::{Keep, Message};
use crate::log::{Log, LogLine};
use crate::model::Model;

/// The topic of the lines.
pub(super) const LINES: &str = "/jde/log";

/// A channel.
pub(super) struct Channel {
    pub(super) topic: String,
    /// The name of the type of its messages, and its definition.
    pub(super) schema: (String, String),
    pub(super) source: Source,
}

/// Where the messages of a channel come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// The values of a variable.
    Variable(String),
    Records(RecordKind),
    /// The panel of a schema.
    Panel(String),
    /// What happened, as lines of text.
    Lines,
}

impl Channel {
    /// Returns what a slow client misses.
    pub(super) fn keep(&self) -> Keep {
        match self.source {
            Source::Variable(_) | Source::Panel(_) => Keep::Newest,
            Source::Records(_) | Source::Lines => Keep::Records,
        }
    }

    /// Returns the channel as clients get it. Its number is its place.
    pub(super) fn advertisement(&self, number: usize) -> Value {
        json!({
            "id": number,
            "topic": self.topic,
            "encoding": "cdr",
            "schemaName": self.schema.0,
            "schemaEncoding": "ros2msg",
            "schema": self.schema.1,
        })
    }
}

/// Returns the channels of an application. A reload changes none of them.
pub(super) fn channels(model: &Model) -> Vec<Channel> {
    let owned = |(name, definition): (&str, &str)| (name.to_owned(), definition.to_owned());
    let records = RecordKind::ALL.into_iter().map(|kind| Channel {
        topic: kind.topic().to_owned(),
        schema: owned(record::schema(kind)),
        source: Source::Records(kind),
    });
    let lines = Channel {
        topic: LINES.to_owned(),
        schema: owned((log_line::TYPE, log_line::DEFINITION)),
        source: Source::Lines,
    };
    let variables = model.variables.iter().map(|variable| Channel {
        topic: jde_log::topic_name(&variable.name),
        schema: (variable.type_name.clone(), variable.definition.clone()),
        source: Source::Variable(variable.name.clone()),
    });
    let schemas = model.schemas.schemas.iter().filter(|schema| schema.panel);
    let panels = schemas.map(|schema| Channel {
        topic: panel::topic(&schema.name),
        schema: owned((panel::TYPE, panel::DEFINITION)),
        source: Source::Panel(schema.name.clone()),
    });
    records.chain([lines]).chain(variables).chain(panels).collect()
}

/// Makes messages. Times are those of the application's clock, from its start; `started` is when that was, ns since 1970.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encoder {
    pub(super) started: u64,
}

impl Encoder {
    /// Returns the message of a value; `None` if there is none.
    pub(super) fn value(self, sample: &Sample) -> Option<Arc<Message>> {
        let bytes = sample.bytes.as_deref()?;
        let mut data = Vec::new();
        cdr::encode(&sample.value_type, bytes, &mut data);
        Some(self.message(sample.time.saturating_add(sample.age), data))
    }

    pub(super) fn record(self, record: &RunRecord) -> Arc<Message> {
        let mut data = Vec::new();
        record::encode(record.clone(), &mut data);
        self.message(record.time(), data)
    }

    pub(super) fn panel(self, sample: &PanelSample) -> Arc<Message> {
        self.message(
            sample.time.saturating_add(sample.age),
            panel::message(&sample.list),
        )
    }

    /// Returns the lines that a record adds to a log.
    pub(super) fn lines(self, log: &mut Log, record: &RunRecord) -> Vec<Arc<Message>> {
        let last = log.last();
        log.add(record);
        let lines = log.after(last, 1).into_iter();
        lines.map(|line| self.line(record.time(), &line)).collect()
    }

    fn line(self, time: u64, line: &LogLine) -> Arc<Message> {
        // The levels of ROS 2.
        let level = match line.severity {
            "bad" => 40,
            "warning" => 30,
            _ => 20,
        };
        let text = match line.because.as_str() {
            "" => line.text.clone(),
            because => format!("{}: {because}", line.text),
        };
        self.message(time, log_line::message(time, level, "jde", &text))
    }

    fn message(self, time: u64, data: Vec<u8>) -> Arc<Message> {
        let log_time = self.started.saturating_add(time);
        Arc::new(Message { log_time, data })
    }
}
