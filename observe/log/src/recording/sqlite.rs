//! The database of a bag of ROS 2, in all versions of its tables: topics, messages, and since version 4 the definitions of
//! their types. It is not trusted: no code of it runs, and its rows have no more bytes than the file.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, ErrorCode, OpenFlags, Row};

use super::{Channel, Chunk, MAX_RECORD, MessagePlace};

/// The number of bytes of messages that are read at once, unless one message has more.
const SLICE_BYTES: u64 = 1 << 20;
/// What a row takes besides its message.
const ROW_BYTES: u64 = 64;
/// The most steps of SQLite's machine for the list of tables: some thousand tables, and how many are between two checks.
const MAX_SCHEMA_STEPS: i32 = 100_000;
const SCHEMA_PERIOD: i32 = 1000;
/// The most topics, and definitions: as many channels as an MCAP file can have.
const MAX_TOPICS: usize = 1 << 16;

/// The contents of a database.
#[derive(Default)]
pub(super) struct Contents {
    /// By the numbers of their topics.
    pub(super) channels: BTreeMap<i64, Channel>,
    /// Slices of the rows of the messages.
    pub(super) chunks: Vec<Chunk>,
    /// What is wrong after them.
    pub(super) damage: Option<String>,
}

/// Opens a database for reading.
pub(super) fn open(path: &Path) -> rusqlite::Result<Connection> {
    let sibling = |ending: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(ending);
        fs::metadata(name).is_ok_and(|metadata| metadata.len() > 0)
    };
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let mut connection = if sibling("-wal") || sibling("-journal") {
        Connection::open_with_flags(path, flags)?
    } else {
        // Nothing is to be taken from a journal, so that nothing need be written beside the file to read it.
        let name: String = path
            .as_os_str()
            .as_encoded_bytes()
            .iter()
            .map(|byte| escaped(*byte))
            .collect();
        let uri = format!("file:{name}?immutable=1");
        Connection::open_with_flags(uri, flags | OpenFlags::SQLITE_OPEN_URI)?
    };
    connection.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true)?;
    connection.set_db_config(DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false)?;
    connection.set_limit(Limit::SQLITE_LIMIT_LENGTH, MAX_RECORD as i32)?;
    read_schema(&mut connection)?;
    Ok(connection)
}

/// Lets SQLite read the list of tables, all of which it holds in memory, unless it is longer than that of any bag.
fn read_schema(connection: &mut Connection) -> rusqlite::Result<()> {
    let mut periods = 0;
    let is_too_long = move || {
        periods += 1;
        periods > MAX_SCHEMA_STEPS / SCHEMA_PERIOD
    };
    connection.progress_handler(SCHEMA_PERIOD, Some(is_too_long))?;
    let read = connection.prepare("SELECT name FROM sqlite_schema").map(drop);
    connection.progress_handler(0, None::<fn() -> bool>)?;
    match read {
        Err(rusqlite::Error::SqliteFailure(code, _)) if code.code == ErrorCode::OperationInterrupted => {
            let message = Some("it has too many tables".to_owned());
            Err(rusqlite::Error::SqliteFailure(code, message))
        }
        // What else is wrong is damage, which the queries find.
        Ok(()) | Err(_) => Ok(()),
    }
}

/// A byte of a path, in the path of a URI.
fn escaped(byte: u8) -> String {
    match byte {
        b'/' | b'.' | b'-' | b'_' | b'0'..=b'9' | b'a'..=b'z' | b'A'..=b'Z' => char::from(byte).to_string(),
        byte => format!("%{byte:02x}"),
    }
}

/// Reads the topics, and where which messages are.
pub(super) fn contents(connection: &Connection, part: usize, file_bytes: u64) -> Contents {
    let mut contents = Contents::default();
    let read = topics(connection, &mut contents.channels)
        .and_then(|()| slices(connection, part, file_bytes, &mut contents.chunks));
    contents.damage = read.err();
    contents
}

/// Passes each message of a slice to `action`: the number of its topic, its row, its time and its bytes. Ends if `action`
/// returns an error.
///
/// # Errors
/// What is wrong with the database, or what `action` returns.
pub(super) fn for_each_message<E: From<String>>(
    connection: &Connection,
    [first, last]: [i64; 2],
    mut action: impl FnMut(i64, i64, u64, &[u8]) -> Result<(), E>,
) -> Result<(), E> {
    let mut statement = connection
        .prepare("SELECT rowid, topic_id, timestamp, data FROM messages WHERE rowid BETWEEN ?1 AND ?2 ORDER BY rowid")
        .map_err(text)?;
    let mut rows = statement.query([first, last]).map_err(text)?;
    while let Some(row) = rows.next().map_err(text)? {
        let [row_number, topic, time] = numbers(row)?;
        let data = match row.get_ref(3).map_err(text)? {
            ValueRef::Blob(data) | ValueRef::Text(data) => data,
            ValueRef::Null | ValueRef::Integer(_) | ValueRef::Real(_) => &[],
        };
        action(topic, row_number, u64::try_from(time).unwrap_or(0), data)?;
    }
    Ok(())
}

/// Reads the channels of all topics.
fn topics(connection: &Connection, channels: &mut BTreeMap<i64, Channel>) -> Result<(), String> {
    require_table(connection, "topics")?;
    let mut definitions = BTreeMap::new();
    if require_table(connection, "message_definitions").is_ok() {
        each_row(
            connection,
            "SELECT 0, topic_type, encoding, encoded_message_definition FROM message_definitions",
            |_, [name, encoding, definition]| {
                // rosbag2 writes this where it does not find the definition.
                if encoding != "unknown" && !definition.is_empty() {
                    definitions.insert(name, (encoding, Arc::<[u8]>::from(definition.into_bytes())));
                }
            },
        )?;
    }
    each_row(
        connection,
        "SELECT id, name, type, serialization_format FROM topics",
        |id, [topic, type_name, encoding]| {
            let (definition_encoding, definition) = definitions.get(&type_name).cloned().unwrap_or_default();
            // The first versions left the middle out.
            let type_name = match type_name.split_once('/') {
                Some((package, name)) if !name.contains('/') => format!("{package}/msg/{name}"),
                _ => type_name,
            };
            let channel = Channel {
                topic,
                type_name,
                definition_encoding,
                definition,
                encoding,
                metadata: BTreeMap::new(),
                index: 0,
            };
            channels.insert(id, channel);
        },
    )
}

/// Passes each row of a number and three texts to `action`.
fn each_row(
    connection: &Connection,
    query: &str,
    mut action: impl FnMut(i64, [String; 3]),
) -> Result<(), String> {
    let mut statement = connection.prepare(query).map_err(text)?;
    let mut rows = statement.query([]).map_err(text)?;
    for _ in 0..MAX_TOPICS {
        let Some(row) = rows.next().map_err(text)? else {
            return Ok(());
        };
        let word = |column: usize| match row.get_ref(column) {
            Ok(ValueRef::Text(bytes) | ValueRef::Blob(bytes)) => {
                Ok(String::from_utf8_lossy(bytes).into_owned())
            }
            Ok(ValueRef::Null | ValueRef::Integer(_) | ValueRef::Real(_)) => Ok(String::new()),
            Err(error) => Err(text(error)),
        };
        let id = row.get(0).map_err(text)?;
        action(id, [word(1)?, word(2)?, word(3)?]);
    }
    Err(format!("it has more than {MAX_TOPICS} topics"))
}

/// Divides the messages into slices, in one pass that reads no long message.
fn slices(
    connection: &Connection,
    part: usize,
    file_bytes: u64,
    chunks: &mut Vec<Chunk>,
) -> Result<(), String> {
    require_table(connection, "messages")?;
    let mut statement = connection
        .prepare("SELECT rowid, length(data), timestamp FROM messages ORDER BY rowid")
        .map_err(text)?;
    let mut rows = statement.query([]).map_err(text)?;
    let (mut before, mut all, mut filled) = (None, 0_u64, u64::MAX);
    while let Some(row) = rows.next().map_err(text)? {
        let [row_number, length, time] = numbers(row)?;
        let length = u64::try_from(length).unwrap_or(0);
        all = all.saturating_add(length);
        // Each page of a sound database belongs to one row.
        if before.is_some_and(|before| before >= row_number) || all > file_bytes {
            return Err("its pages contain each other".to_owned());
        }
        before = Some(row_number);
        let time = u64::try_from(time).unwrap_or(0);
        filled = filled.saturating_add(length + ROW_BYTES);
        match chunks.last_mut() {
            Some(Chunk {
                place: MessagePlace::Rows([_, last]),
                start,
                end,
                ..
            }) if filled <= SLICE_BYTES => {
                *last = row_number;
                (*start, *end) = (time.min(*start), time.max(*end));
            }
            _ => {
                filled = length + ROW_BYTES;
                chunks.push(Chunk {
                    part,
                    place: MessagePlace::Rows([row_number; 2]),
                    start: time,
                    end: time,
                });
            }
        }
    }
    Ok(())
}

fn numbers(row: &Row<'_>) -> Result<[i64; 3], String> {
    let number = |column: usize| match row.get_ref(column) {
        Ok(ValueRef::Integer(number)) => Ok(number),
        Ok(ValueRef::Null | ValueRef::Real(_) | ValueRef::Text(_) | ValueRef::Blob(_)) => Ok(0),
        Err(error) => Err(text(error)),
    };
    Ok([number(0)?, number(1)?, number(2)?])
}

/// Checks that a table is one whose rows are stored: views, virtual tables and computed columns are programs.
fn require_table(connection: &Connection, name: &str) -> Result<(), String> {
    let is_stored = connection.query_row(
        "SELECT (SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = ?1 AND rootpage > 0) = 1 \
         AND (SELECT count(*) FROM pragma_table_xinfo(?1) WHERE hidden > 0) = 0",
        [name],
        |row| row.get(0),
    );
    match is_stored.map_err(text)? {
        true => Ok(()),
        false => Err(format!("it has no table `{name}`")),
    }
}

fn text(error: rusqlite::Error) -> String {
    error.to_string()
}
