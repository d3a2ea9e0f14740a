//! The log and the health of the application, as values of the topics `/rosout` and `/diagnostics`.

use std::time::{SystemTime, UNIX_EPOCH};

use jde_link::Subject as _;
use jde_link_host::Running;
use jde_records::snapshot::SchemaView;
use jde_ros_node::NodeName;
use jde_session::log::LogRecord;
use jde_timeline::{Severity, health_severity, health_text};
use serde_json::{Value, json};
use tracing::Level;

/// The present time as a stamp.
pub(super) fn stamp() -> Value {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let seconds = i32::try_from(since.as_secs()).unwrap_or(i32::MAX);
    json!({ "sec": seconds, "nanosec": since.subsec_nanos() })
}

/// A level as `rcl_interfaces/msg/Log` has it.
pub(in crate::extensions) fn severity(level: Level) -> u8 {
    match level {
        Level::ERROR => 40,
        Level::WARN => 30,
        Level::INFO => 20,
        Level::DEBUG | Level::TRACE => 10,
    }
}

/// A line of the log. Its logger is the node, or the node and the schema.
pub(super) fn log(name: &NodeName, line: &LogRecord) -> Value {
    let node = name.full().trim_start_matches('/').replace('/', ".");
    let level = severity(line.level);
    let logger = match &line.schema {
        Some(schema) => format!("{node}.{schema}"),
        None => node,
    };
    json!({ "stamp": stamp(), "level": level, "name": logger, "msg": line.message })
}

/// The health of every schema.
pub(super) fn diagnostics(name: &NodeName, subject: &Running) -> Value {
    let snapshot = subject.snapshot();
    let statuses = snapshot.schemas.iter().map(|schema| status(name, schema));
    json!({ "header": { "stamp": stamp() }, "status": statuses.collect::<Vec<_>>() })
}

fn status(name: &NodeName, schema: &SchemaView) -> Value {
    let state = schema.state.name();
    let (level, message) = match health_severity(&schema.health) {
        Severity::Good => (0, state.to_owned()),
        Severity::Warning => (1, health_text(&schema.health)),
        Severity::Bad => (2, health_text(&schema.health)),
    };
    let seconds = |nanos: u64| format!("{} s", nanos as f64 / 1e9);
    let mut values = vec![
        ("state", state.to_owned()),
        ("period", seconds(schema.period)),
        ("longest iteration", seconds(schema.longest)),
        ("iterations", schema.iterations.to_string()),
        ("overruns", schema.overruns.to_string()),
        ("refused", schema.refused.to_string()),
        ("triggers dropped", schema.triggers_dropped.to_string()),
        ("faults", schema.faults.to_string()),
    ];
    values.extend(
        schema
            .measured
            .map(|measured| ("measured period", seconds(measured))),
    );
    values.extend(schema.held_by().map(|held| ("operator", held)));
    let values = values
        .iter()
        .map(|(key, value)| json!({ "key": key, "value": value }));
    json!({
        "level": level,
        "name": format!("{}: {}", name.node, schema.name),
        "message": message,
        "hardware_id": schema.type_name,
        "values": values.collect::<Vec<_>>(),
    })
}
