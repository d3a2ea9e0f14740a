//! Recordings in parts: the mark and the name of each part, and which files are parts of the same recording. It reads only
//! the beginning of each file.

use std::collections::BTreeMap;
use std::fmt::{self, Display};
use std::fs;
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use jde_files::LeftOut;
use mcap::records::{Record, op};
use serde::Serialize;

use crate::bag;
use crate::recording::{self, scan};

/// The name of the metadata with the mark of a part.
pub const PART: &str = "jde/part";
/// The key in it of a file that was to be the only one.
const WHOLE: &str = "whole";
/// The name of the metadata with the position at which the new messages of a part begin. Before it, the part
/// repeats the values in force. The first part has none.
pub const BEGINS: &str = "jde/part/begins";
/// The key of that position, in bytes from the beginning of the file.
pub const BYTE: &str = "byte";
/// The name of the metadata with the gap before a part.
pub const GAP: &str = "jde/part/gap";
/// The largest size of a metadata record up to the mark, in bytes.
const MAX_METADATA_BYTES: u64 = 1 << 20;

/// The mark of a part: which part of which recording a file is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mark {
    /// An identifier that all parts of one recording share, and no others have.
    pub recording: String,
    /// The number of the part, from 1.
    pub number: u32,
    /// Whether it was to be the only file. It has the name of the recording, and others only where the disk failed.
    pub is_whole: bool,
}

impl Mark {
    /// Returns the mark as metadata.
    #[must_use]
    pub fn to_metadata(&self) -> BTreeMap<String, String> {
        let whole = self.is_whole.then(|| (WHOLE.to_owned(), "yes".to_owned()));
        let mark = [
            ("recording".to_owned(), self.recording.clone()),
            ("number".to_owned(), self.number.to_string()),
        ];
        mark.into_iter().chain(whole).collect()
    }

    /// Reads the mark from metadata.
    #[must_use]
    pub fn from_metadata(metadata: &BTreeMap<String, String>) -> Option<Self> {
        Some(Self {
            recording: metadata.get("recording")?.clone(),
            number: metadata.get("number")?.parse().ok()?,
            is_whole: metadata.contains_key(WHOLE),
        })
    }

    /// Reads the mark of a file. `None` if the file is a recording without parts.
    ///
    /// # Errors
    /// The file cannot be read, or is no recording.
    pub fn read(path: &Path) -> io::Result<Option<Self>> {
        let mut file = jde_files::open(path)?;
        let mut magic = Vec::new();
        Read::by_ref(&mut file)
            .take(mcap::MAGIC.len() as u64)
            .read_to_end(&mut magic)?;
        if recording::is_of_bag(&magic) {
            return Ok(None);
        }
        if magic != mcap::MAGIC {
            return Err(io::Error::new(ErrorKind::InvalidData, "it is no MCAP file"));
        }
        let mut offset = mcap::MAGIC.len() as u64;
        while let Some((opcode, length)) = scan::head(&mut file, offset)? {
            match opcode {
                op::HEADER => {}
                op::METADATA if length <= MAX_METADATA_BYTES => {
                    let Some((opcode, body)) = scan::record(&mut file, offset)? else {
                        return Ok(None);
                    };
                    if let Ok(Record::Metadata(metadata)) = mcap::parse_record(opcode, &body)
                        && metadata.name == PART
                    {
                        return Ok(Self::from_metadata(&metadata.metadata));
                    }
                }
                _ => return Ok(None),
            }
            offset = offset.saturating_add(scan::HEAD + length);
        }
        Ok(None)
    }
}

/// A time of which a recording has nothing: the disk did not accept it, or it cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Gap {
    /// The time since the application's start from which messages are missing, in ns.
    pub from: u64,
    /// The time at which the recording went on, in ns. `None` if it did not.
    pub until: Option<u64>,
    /// The number of messages that the writer had and could not keep.
    pub lost: u64,
    /// What the system said.
    pub reason: String,
    /// Whether it was recorded, and the file is damaged there. How many messages that were is not known.
    pub damaged: bool,
}

impl Gap {
    /// Returns the gap as metadata.
    #[must_use]
    pub fn to_metadata(&self) -> BTreeMap<String, String> {
        let until = self.until.map(|until| ("until_ns".to_owned(), until.to_string()));
        let all = [
            ("from_ns".to_owned(), self.from.to_string()),
            ("lost".to_owned(), self.lost.to_string()),
            ("reason".to_owned(), self.reason.clone()),
        ];
        all.into_iter().chain(until).collect()
    }

    /// Reads the gap from metadata.
    #[must_use]
    pub fn from_metadata(metadata: &BTreeMap<String, String>) -> Option<Self> {
        let number = |key: &str| metadata.get(key)?.parse().ok();
        Some(Self {
            from: number("from_ns")?,
            until: number("until_ns"),
            lost: number("lost")?,
            reason: metadata.get("reason")?.clone(),
            damaged: false,
        })
    }
}

impl Display for Gap {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = |time: u64| time as f64 / 1e9;
        let (from, lost) = (seconds(self.from), self.lost);
        if let (true, Some(until)) = (self.damaged, self.until.map(seconds)) {
            let reason = &self.reason;
            return write!(
                out,
                "nothing can be read from {from:.3} s to {until:.3} s: {reason}"
            );
        }
        match self.until.map(seconds) {
            Some(until) => write!(out, "nothing is recorded from {from:.3} s to {until:.3} s")?,
            None => write!(out, "nothing is recorded from {from:.3} s on")?,
        }
        write!(out, " ({lost} lost): {}", self.reason)
    }
}

/// The recordings that a path denotes, each with its files in their order, and the files that may belong to them and
/// cannot be read.
#[derive(Debug, Default)]
pub(crate) struct Found {
    pub(crate) recordings: Vec<Vec<PathBuf>>,
    pub(crate) left_out: LeftOut,
    /// The first of these files, and why it cannot be read.
    pub(crate) first_unread: Option<(PathBuf, io::Error)>,
}

impl Found {
    fn only(files: Vec<PathBuf>) -> Self {
        Self {
            recordings: vec![files],
            ..Self::default()
        }
    }

    /// Returns the mark of a file. `None` if it cannot be read: a file of somebody else does not hide the others.
    fn mark(&mut self, path: &Path) -> Option<Option<Mark>> {
        match Mark::read(path) {
            Ok(mark) => Some(mark),
            // It was deleted meanwhile.
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(error) => {
                self.left_out.add(path.display(), None, &error);
                self.first_unread.get_or_insert((path.to_owned(), error));
                None
            }
        }
    }
}

/// Finds the recordings that `path` denotes. A file denotes itself and
/// the other parts of its recording in its folder. A folder denotes the recordings in it. The name from which parts were
/// numbered denotes the parts of the newest recording.
///
/// # Errors
/// The folder cannot be read.
pub(crate) fn find_recordings(path: &Path) -> io::Result<Found> {
    if path.is_dir() {
        return find_in_folder(path, bag::is_recording);
    }
    if !path.exists() {
        let (parts, left_out) = find_parts(path)?;
        let Some((_, newest)) = parts.last() else {
            return Ok(Found::only(vec![path.to_owned()]));
        };
        let mut found = find_recordings(newest)?;
        if found.left_out.is_empty() {
            found.left_out = left_out;
        }
        return Ok(found);
    }
    let mark = path.is_file().then(|| Mark::read(path).ok().flatten()).flatten();
    if let Some(mark) = mark.as_ref().filter(|mark| mark.is_whole) {
        // A folder that cannot be listed does not hide its files.
        let (further, left_out) = find_further_parts(path, mark).unwrap_or_default();
        let files = [path.to_owned()].into_iter().chain(further);
        return Ok(Found {
            left_out,
            ..Found::only(files.collect())
        });
    }
    let mut found = match path.parent().filter(|_| mark.is_some()) {
        Some(folder) => find_in_folder(folder_of(folder), |other| other.extension() == path.extension())?,
        None => Found::default(),
    };
    let recordings = &mut found.recordings;
    recordings.retain(|parts| parts.iter().any(|part| is_same_file(part, path)));
    if recordings.is_empty() {
        recordings.push(vec![path.to_owned()]);
    }
    Ok(found)
}

/// Finds the parts that were numbered from a name, in the order of the numbers in their file names, and the files of such
/// names that cannot be read. A file that was to be the only one of its recording is none of them.
///
/// # Errors
/// The folder cannot be read.
pub fn find_parts(path: &Path) -> io::Result<(Vec<(u32, PathBuf)>, LeftOut)> {
    let (parts, left_out) = find_marked(path)?;
    // Those in which a recording in the file itself went on belong to that one.
    let own = path.is_file().then(|| Mark::read(path).ok().flatten()).flatten();
    let own = own.filter(|mark| mark.is_whole).map(|mark| mark.recording);
    let is_split = |mark: &Mark| !mark.is_whole && own.as_ref() != Some(&mark.recording);
    let parts = parts.into_iter().filter(|file| is_split(&file.mark));
    Ok((parts.map(|file| (file.number, file.path)).collect(), left_out))
}

/// Finds the parts in which the recording of the file `path` went on, in their order, and the files of such names that
/// cannot be read. `mark` is that of the file.
///
/// # Errors
/// The folder cannot be read.
pub fn find_further_parts(path: &Path, mark: &Mark) -> io::Result<(Vec<PathBuf>, LeftOut)> {
    let (parts, left_out) = find_marked(path)?;
    let is_further = |file: &Marked| file.mark.recording == mark.recording && file.mark.number > mark.number;
    let further = parts.into_iter().filter(is_further);
    let further: BTreeMap<u32, PathBuf> = further.map(|file| (file.mark.number, file.path)).collect();
    Ok((further.into_values().collect(), left_out))
}

/// A file with a mark, and the number in its name.
struct Marked {
    number: u32,
    path: PathBuf,
    mark: Mark,
}

/// Finds the files with a mark whose names were numbered from a name, in the order of those numbers, and the files of such
/// names that cannot be read.
fn find_marked(path: &Path) -> io::Result<(Vec<Marked>, LeftOut)> {
    let folder = folder_of(path.parent().unwrap_or(Path::new("")));
    let stem = path.file_stem().unwrap_or_default().as_encoded_bytes();
    let mut parts = Vec::new();
    let mut found = Found::default();
    for entry in listed(folder)? {
        let other = entry.file_stem().unwrap_or_default().as_encoded_bytes();
        let number = other
            .strip_prefix(stem)
            .and_then(|rest| rest.strip_prefix(b"-"))
            .and_then(|digits| str::from_utf8(digits).ok()?.parse().ok());
        if let Some(number) = number
            // Only the canonical form of the number counts, so not `-0001`.
            && entry.file_name() == numbered(path, number).file_name()
            && entry.is_file()
            && let Some(Some(mark)) = found.mark(&entry)
        {
            parts.push(Marked {
                number,
                path: entry,
                mark,
            });
        }
    }
    parts.sort_by_key(|file| file.number);
    Ok((parts, found.left_out))
}

/// Returns the name with a number: `drive-001.mcap` for `drive.mcap`.
#[must_use]
pub fn numbered(path: &Path, number: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number:03}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// Finds all recordings of a folder, each with its parts in their order. A second copy of a part is ignored.
fn find_in_folder(folder: &Path, is_candidate: impl Fn(&Path) -> bool) -> io::Result<Found> {
    let mut found = Found::default();
    let mut parts: BTreeMap<String, BTreeMap<u32, PathBuf>> = BTreeMap::new();
    for path in listed(folder)? {
        if !is_candidate(&path) || !path.is_file() {
            continue;
        }
        match found.mark(&path) {
            None => {}
            Some(None) => found.recordings.push(vec![path]),
            Some(Some(Mark {
                recording, number, ..
            })) => {
                parts.entry(recording).or_default().entry(number).or_insert(path);
            }
        }
    }
    let parts = parts.into_values().map(|parts| parts.into_values().collect());
    found.recordings.extend(parts);
    Ok(found)
}

/// Returns the entries of a folder, sorted by name. Empty if the folder does not exist.
fn listed(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let listed = match fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        listed => listed?,
    };
    let mut paths = listed
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<io::Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}

fn folder_of(parent: &Path) -> &Path {
    if parent.as_os_str().is_empty() {
        Path::new(".")
    } else {
        parent
    }
}

fn is_same_file(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| path.canonicalize().ok();
    real(a).is_some_and(|a| Some(a) == real(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_files_precede_the_extension() {
        for (path, third) in [
            ("runs/drive.mcap", "runs/drive-003.mcap"),
            ("drive", "drive-003"),
            ("a.b.mcap", "a.b-003.mcap"),
        ] {
            assert_eq!(numbered(path.as_ref(), 3), Path::new(third));
        }
        assert_eq!(numbered("d.mcap".as_ref(), 1234), Path::new("d-1234.mcap"));
    }
}
