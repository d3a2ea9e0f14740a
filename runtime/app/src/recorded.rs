//! Definitions of messages in MCAP files, which contain those of all their topics: in the summary at their end. What
//! reads whole recordings, `jde-log`, is above this crate and takes a library.

use std::collections::BTreeMap;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use jde_document::section::Text;
use jde_document::{FaultReport, quote};
use jde_ros::definition::split;

/// The last bytes of a file: the record of its footer, and then these.
const MCAP_MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// The bytes of the footer: kind, length, two places, a checksum; and those after it.
const FOOTER_BYTES: usize = 1 + 8 + 20 + MCAP_MAGIC.len();
/// The largest summary that is read, bytes. One has as much as the definitions of its topics.
const MAX_SUMMARY: u64 = 64 << 20;
/// Kinds of records.
const FOOTER_RECORD: u64 = 2;
const SCHEMA_RECORD: u64 = 3;

/// Returns the text of each message that these recordings define, by its name. The first of a name counts.
pub(super) fn definitions(
    report: &mut FaultReport,
    recordings: &[Text],
    folder: &Path,
) -> BTreeMap<String, String> {
    let mut definitions = BTreeMap::new();
    for recording in recordings {
        let cut = || io::Error::other("it is not a complete MCAP file");
        let found = summary(&folder.join(recording.text))
            .and_then(|summary| summary.as_deref().and_then(schemas).ok_or_else(cut));
        match found {
            Ok(found) => {
                for (name, text) in found {
                    definitions.entry(name).or_insert(text);
                }
            }
            Err(error) => {
                let name = quote(recording.text);
                let message = format!("the definitions in {name} cannot be read: {error}");
                report.fault(&recording.span, message);
            }
        }
    }
    definitions
}

/// Reads the summary of a recording; `None` if there is none.
fn summary(path: &Path) -> io::Result<Option<Vec<u8>>> {
    let mut file = jde_files::open(path)?;
    let Some(before_end) = file.metadata()?.len().checked_sub(FOOTER_BYTES as u64) else {
        return Ok(None);
    };
    let mut end = [0; FOOTER_BYTES];
    file.seek(SeekFrom::Start(before_end))?;
    file.read_exact(&mut end)?;
    let mut rest = &end[..];
    let (kind, _, start) = (number(&mut rest, 1), number(&mut rest, 8), number(&mut rest, 8));
    let start = start.filter(|start| (1..=before_end).contains(start));
    let (Some(start), Some(FOOTER_RECORD), true) = (start, kind, end.ends_with(&MCAP_MAGIC)) else {
        return Ok(None);
    };
    if before_end - start > MAX_SUMMARY {
        let message = format!("its summary has more than {} MiB", MAX_SUMMARY >> 20);
        return Err(io::Error::new(io::ErrorKind::InvalidData, message));
    }
    let mut summary = Vec::new();
    file.seek(SeekFrom::Start(start))?;
    file.take(before_end - start).read_to_end(&mut summary)?;
    Ok(Some(summary))
}

/// Returns the messages that a summary defines in the form of ROS 2; `None` if it is damaged.
fn schemas(mut summary: &[u8]) -> Option<BTreeMap<String, String>> {
    let mut found = BTreeMap::new();
    while let Some(kind) = number(&mut summary, 1) {
        let length = number(&mut summary, 8)?;
        let mut record = part(&mut summary, length)?;
        if kind == SCHEMA_RECORD {
            let _ = number(&mut record, 2)?;
            let (name, encoding, definition) = (text(&mut record)?, text(&mut record)?, text(&mut record)?);
            if encoding == "ros2msg" {
                found.extend(split(&name, &definition));
            }
        }
    }
    Some(found)
}

fn part<'b>(bytes: &mut &'b [u8], length: u64) -> Option<&'b [u8]> {
    bytes.split_off(..usize::try_from(length).ok()?)
}

/// Takes a number of so many bytes.
fn number(bytes: &mut &[u8], length: usize) -> Option<u64> {
    let mut number = [0; 8];
    number[..length].copy_from_slice(bytes.split_off(..length)?);
    Some(u64::from_le_bytes(number))
}

/// Takes a text that follows its length.
fn text(bytes: &mut &[u8]) -> Option<String> {
    let length = number(bytes, 4)?;
    Some(String::from_utf8_lossy(part(bytes, length)?).into_owned())
}
