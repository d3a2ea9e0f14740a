//! The log of schemas in recordings: messages of the topic `/rosout`, in the form of ROS 2, which Foxglove and others show as
//! a log. This module keeps no log.

use jde_ros::cdr;

use crate::Channel;

/// The topic.
pub const TOPIC: &str = "/rosout";
/// The name of the type of the messages.
pub const TYPE: &str = "rcl_interfaces/msg/Log";
/// Their definition.
pub const DEFINITION: &str = "\
# A line of the log of a schema.

# When, since the application's start.
builtin_interfaces/Time stamp
# 10 debug, 20 info, 30 warning, 40 error.
uint8 level
# The schema.
string name
# The line.
string msg
# Empty.
string file
# Empty.
string function
# 0.
uint32 line
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";
/// The key in a channel's metadata that states that it is this log, and no variable of another program.
pub const LOG: &str = "log";

/// Whether a channel contains the log of schemas.
#[must_use]
pub fn is_log(channel: &Channel) -> bool {
    channel.topic == TOPIC && channel.metadata.contains_key(LOG)
}

/// Encodes a line of a schema at a time, ns since the application's start.
#[must_use]
pub fn message(time: u64, level: u8, schema: &str, text: &str) -> Vec<u8> {
    let mut message = Vec::new();
    let mut writer = cdr::Writer::new(&mut message);
    let seconds = i32::try_from(time / 1_000_000_000).unwrap_or(i32::MAX);
    writer.number(seconds.to_le_bytes());
    writer.number(((time % 1_000_000_000) as u32).to_le_bytes());
    writer.number([level]);
    for text in [schema, text, "", ""] {
        writer.text(text.as_bytes());
    }
    writer.number(0_u32.to_le_bytes());
    message
}

/// A line of the log of a schema.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// When, ns since the application's start.
    pub time: u64,
    /// 10 debug, 20 info, 30 warning, 40 error.
    pub level: u8,
    /// The schema.
    pub schema: String,
    /// The line.
    pub text: String,
}

/// Reads what [`message`] encodes. `None` for anything else.
#[must_use]
pub fn read(message: &[u8]) -> Option<LogLine> {
    let mut reader = cdr::Reader::new(message).ok()?;
    let seconds = i32::from_le_bytes(reader.number("sec").ok()?);
    let nanoseconds = u32::from_le_bytes(reader.number("nanosec").ok()?);
    let [level] = reader.number("level").ok()?;
    Some(LogLine {
        time: u64::try_from(seconds).ok()? * 1_000_000_000 + u64::from(nanoseconds),
        level,
        schema: reader.text("name").ok()?.to_owned(),
        text: reader.text("msg").ok()?.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_read_as_it_was_written_and_nothing_else_is_a_line() {
        let line = LogLine {
            time: 61_000_000_002,
            level: 30,
            schema: "goon".to_owned(),
            text: "the laser is dirty".to_owned(),
        };
        let written = message(line.time, line.level, &line.schema, &line.text);
        assert_eq!(read(&written), Some(line));
        assert_eq!(read(&written[..20]), None);
        assert_eq!(read(b"no message"), None);
    }
}
