//! Reads every message of JSON that the other end sends, and refuses what makes no sense. Nothing else reads one, so that
//! nobody behind this module has to check places, names or depths again.
//!
//! Its results take no more than a few times the memory of the message, whose length is limited. The peer is not named
//! here: the caller knows it.

use std::collections::HashMap;

use jde_records::check::{MAX_TIME, check_count, check_fathers, check_name};
use jde_records::snapshot::Snapshot;
use jde_records::{RecordKind, RunRecord};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::keys::{self, PROTOCOL};
use crate::message::{
    About, OperateReply, PortInfo, Range, Refusal, Request, SchemaInfo, Schemas, Status, VariableInfo,
};

/// Longest message, bytes: the variables of the largest application with their definitions.
pub const MAX_MESSAGE: usize = 32 << 20;
/// Longest request to `operate`, bytes: the largest modulations are parameters and paths.
pub const MAX_REQUEST: usize = 1 << 20;
/// Longest text by which an application describes itself, bytes: a path.
const MAX_TEXT: usize = 4096;
/// The most names of the numbers of a modulation: those of a plugin.
const MAX_CHOICES: usize = 256;
/// Longest name of an operator, bytes, with the id of its lease.
const MAX_OPERATOR: usize = 512;

/// Why a message is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refused {
    /// It cannot be read: another version of jde may have sent it.
    Unreadable(String),
    /// It can be read and makes no sense.
    Nonsense(String),
}

/// Reads the description of an application: the answer to `about`, or an announcement file.
///
/// # Errors
/// [`Refused`], also for all functions below.
pub fn about(bytes: &[u8]) -> Result<About, Refused> {
    let about: About = json(bytes)?;
    sense(check_about(&about)).map(|()| about)
}

/// Reads the answer to `about` that came from a key.
///
/// # Errors
/// As above.
pub fn about_at(key: &str, bytes: &[u8]) -> Result<About, Refused> {
    let about = about(bytes)?;
    let mut parts = key.split('/').skip(2);
    let own = [&about.name, &about.id].map(|part| Some(keys::chunk(part)));
    if [parts.next(), parts.next()] == own.each_ref().map(Option::as_deref) {
        return Ok(about);
    }
    Err(Refused::Nonsense(format!(
        "it answers as `{}`, but its key names another application",
        about.name
    )))
}

/// Reads the answer to `schemas`.
///
/// # Errors
/// As above.
pub fn schemas(bytes: &[u8]) -> Result<Schemas, Refused> {
    let schemas: Schemas = json(bytes)?;
    sense(check_schemas(&schemas)).map(|()| schemas)
}

/// Reads the answer to `variables`.
///
/// # Errors
/// As above.
pub fn variables(bytes: &[u8]) -> Result<Vec<VariableInfo>, Refused> {
    let variables: Vec<VariableInfo> = json(bytes)?;
    sense(variables.iter().try_for_each(check_variable)).map(|()| variables)
}

/// Reads a snapshot of the hierarchy.
///
/// # Errors
/// As above.
pub fn snapshot(bytes: &[u8]) -> Result<Snapshot, Refused> {
    let snapshot: Snapshot = json(bytes)?;
    sense(snapshot.check()).map(|()| snapshot)
}

/// Reads a published record of a kind.
///
/// # Errors
/// As above.
pub fn record(kind: RecordKind, bytes: &[u8]) -> Result<RunRecord, Refused> {
    check_length(bytes, MAX_MESSAGE)?;
    let record = RunRecord::parse(kind, bytes).map_err(unreadable)?;
    sense(record.check()).map(|()| record)
}

/// Reads the answer to a query for records: each with its number.
///
/// # Errors
/// As above.
pub fn records(kind: RecordKind, bytes: &[u8]) -> Result<Vec<(u64, RunRecord)>, Refused> {
    #[derive(Deserialize)]
    struct Numbered<T> {
        number: u64,
        line: T,
    }
    fn read<T: DeserializeOwned>(
        bytes: &[u8],
        wrap: impl Fn(T) -> RunRecord,
    ) -> Result<Vec<(u64, RunRecord)>, Refused> {
        let stored: Vec<Numbered<T>> = json(bytes)?;
        let stored = stored.into_iter();
        Ok(stored.map(|record| (record.number, wrap(record.line))).collect())
    }
    let records = match kind {
        RecordKind::Decision => read(bytes, RunRecord::Decision),
        RecordKind::State => read(bytes, RunRecord::State),
        RecordKind::Event => read(bytes, RunRecord::Other),
    }?;
    let checked = records.iter().try_for_each(|(_, record)| record.check());
    sense(checked).map(|()| records)
}

/// Reads the answer to `operate`.
///
/// # Errors
/// As above.
pub fn operate_reply(bytes: &[u8]) -> Result<OperateReply, Refused> {
    let reply: OperateReply = json(bytes)?;
    if reply.ok {
        Ok(reply)
    } else {
        Err(Refused::Nonsense("it does not confirm the action".to_owned()))
    }
}

/// Reads the reason of a refusal.
///
/// # Errors
/// As above.
pub fn refusal(bytes: &[u8]) -> Result<Refusal, Refused> {
    json(bytes)
}

/// Reads a client's request to `operate`. Names and values are checked by the application, which knows what it has.
///
/// # Errors
/// As above.
pub fn request(bytes: &[u8]) -> Result<Request, Refused> {
    check_length(bytes, MAX_REQUEST)?;
    let request: Request = json(bytes)?;
    if request.by.is_empty() || request.by.len() > MAX_OPERATOR || request.by.contains(char::is_control) {
        let reason = format!("the operator's name has 1 to {MAX_OPERATOR} bytes and no control characters");
        return Err(Refused::Nonsense(reason));
    }
    Ok(request)
}

fn json<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Refused> {
    check_length(bytes, MAX_MESSAGE)?;
    serde_json::from_slice(bytes).map_err(unreadable)
}

fn check_length(bytes: &[u8], most: usize) -> Result<(), Refused> {
    if bytes.len() > most {
        let length = bytes.len();
        return Err(Refused::Nonsense(format!(
            "it has {length} bytes, and at most {most} are read"
        )));
    }
    Ok(())
}

fn unreadable(error: serde_json::Error) -> Refused {
    Refused::Unreadable(error.to_string())
}

fn sense(checked: Result<(), String>) -> Result<(), Refused> {
    checked.map_err(Refused::Nonsense)
}

fn check_about(about: &About) -> Result<(), String> {
    if !keys::is_name(&about.name) {
        return Err("it states a name that no application can have".to_owned());
    }
    // Other versions may count otherwise; the same version has 16 digits.
    let is_id =
        !about.id.is_empty() && about.id.len() <= 64 && about.id.chars().all(|c| c.is_ascii_hexdigit());
    if !is_id || about.protocol == PROTOCOL && about.id.len() != 16 {
        return Err("it states an id that is not 16 hexadecimal digits".to_owned());
    }
    let texts = [
        &about.version,
        &about.host,
        &about.user,
        &about.application,
        &about.file,
        &about.executor,
    ];
    if texts.iter().any(|text| text.len() > MAX_TEXT) {
        return Err(format!(
            "it describes itself with a text of more than {MAX_TEXT} bytes"
        ));
    }
    if !is_amount(about.speed) || about.started_ns > MAX_TIME {
        return Err("it states a speed or a start that is not valid".to_owned());
    }
    Ok(())
}

fn check_schemas(all: &Schemas) -> Result<(), String> {
    let Schemas { schemas, groups } = all;
    check_count(schemas.len(), "schemas")?;
    check_count(groups.len(), "groups")?;
    let places: HashMap<&str, usize> = schemas
        .iter()
        .enumerate()
        .map(|(place, schema)| (schema.name.as_str(), place))
        .collect();
    let missing = |what: String, name: &str| format!("{what} `{name}`, and it has no such schema");
    let mut fathers = Vec::with_capacity(schemas.len());
    for (place, schema) in schemas.iter().enumerate() {
        check_schema(place, schema)?;
        let father = match &schema.father {
            Some(father) => Some(
                *places
                    .get(father.as_str())
                    .ok_or_else(|| missing(format!("schema {place} has father"), father))?,
            ),
            None => None,
        };
        fathers.push(father);
        let mut children = schema.children.iter().filter_map(|child| child.schema.as_deref());
        if let Some(child) = children.find(|child| !places.contains_key(child)) {
            return Err(missing(format!("schema {place} has child"), child));
        }
    }
    if places.len() < schemas.len() {
        return Err("two of its schemas have the same name".to_owned());
    }
    check_fathers(&fathers)?;
    for (place, group) in groups.iter().enumerate() {
        check_name(&group.name, || format!("group {place}"))?;
        let mut names = group.father.iter().chain(&group.members);
        if let Some(name) = names.find(|name| !places.contains_key(name.as_str())) {
            return Err(missing(format!("group {place} names"), name));
        }
    }
    Ok(())
}

fn check_schema(place: usize, schema: &SchemaInfo) -> Result<(), String> {
    let what = || format!("schema {place}");
    check_name(&schema.name, what)?;
    if !["perceptive", "motor", "driver"].contains(&schema.kind.as_str()) {
        return Err(format!("{} has an unknown kind: `{}`", what(), schema.kind));
    }
    if !is_amount(schema.period_s) || !is_amount(schema.budget_s) {
        return Err(format!("{} has a period or a budget that is not a time", what()));
    }
    schema.ports.iter().try_for_each(|port| check_port(port, what))
}

fn check_port(port: &PortInfo, what: impl Fn() -> String) -> Result<(), String> {
    const ROLES: [&str; 6] = [
        "import",
        "export",
        "modulation",
        "command",
        "actuator",
        "child-modulation",
    ];
    check_name(&port.name, || format!("a port of {}", what()))?;
    if !ROLES.contains(&port.role.as_str()) {
        return Err(format!(
            "`{}` of {} has an unknown role: `{}`",
            port.name,
            what(),
            port.role
        ));
    }
    check_range(&port.range, || format!("`{}` of {}", port.name, what()))
}

fn check_variable(variable: &VariableInfo) -> Result<(), String> {
    check_name(&variable.name, || "a variable".to_owned())?;
    let name = &variable.name;
    let is_owned = match variable.owner.as_str() {
        // A topic of a recording of others may have a name of one part.
        "" => *name == variable.variable,
        owner => *name == format!("{owner}.{}", variable.variable),
    };
    if !is_owned {
        return Err(format!("the variable `{name}` does not begin with its owner"));
    }
    if !["export", "modulation", "command"].contains(&variable.access.as_str()) {
        return Err(format!("`{name}` is neither export, modulation nor command"));
    }
    check_range(&variable.range, || format!("`{name}`"))?;
    let Some(Status { age_s, rate_hz, .. }) = &variable.status else {
        return Ok(());
    };
    if !is_amount(age_s.unwrap_or_default()) || !is_amount(*rate_hz) {
        return Err(format!("`{name}` has an age or a rate that is not valid"));
    }
    Ok(())
}

fn check_range(range: &Range, what: impl FnOnce() -> String) -> Result<(), String> {
    let is_empty = matches!((range.least, range.greatest), (Some(least), Some(greatest)) if least > greatest);
    if is_empty || range.choices.len() > MAX_CHOICES {
        return Err(format!("{} has a range without a number", what()));
    }
    Ok(())
}

/// Whether a number is finite and not negative.
fn is_amount(number: f64) -> bool {
    (0.0..=f64::MAX).contains(&number)
}

#[cfg(test)]
mod tests;
