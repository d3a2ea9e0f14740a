//! Recordings in parts: what each part says of itself, and which files are the parts of one. Reads no more of a file than its head.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use mcap::records::{Record, op};

use crate::recording::scan;
use crate::sink::numbered;

/// Where a part says which it is.
pub(crate) const PART: &str = "jde/part";
/// Where all parts but the first say before which byte they repeat what was in force.
pub(crate) const BEGINS: &str = "jde/part/begins";
/// The key of that byte.
pub(crate) const BYTE: &str = "byte";
/// What a recording is called if it has parts.
const ENDING: &str = "mcap";
/// Most bytes of what a part says of itself at its head.
const MOST_SAID: u64 = 1 << 20;

/// Which part of which recording a file is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Mark {
    /// The same in all parts of one recording and in no others.
    pub(crate) recording: String,
    /// Counts from 1.
    pub(crate) number: u32,
}

impl Mark {
    /// What the file says.
    pub(crate) fn told(&self) -> BTreeMap<String, String> {
        BTreeMap::from([
            ("recording".to_owned(), self.recording.clone()),
            ("number".to_owned(), self.number.to_string()),
        ])
    }

    /// What a file has said.
    pub(crate) fn of(told: &BTreeMap<String, String>) -> Option<Self> {
        Some(Self {
            recording: told.get("recording")?.clone(),
            number: told.get("number")?.parse().ok()?,
        })
    }

    /// The mark of a file; none if it is a whole recording, or no recording at all.
    ///
    /// # Errors
    /// It cannot be read.
    pub(crate) fn read(path: &Path) -> io::Result<Option<Self>> {
        let mut file = File::open(path)?;
        let mut offset = mcap::MAGIC.len() as u64;
        while let Some((opcode, length)) = scan::head(&mut file, offset)? {
            match opcode {
                op::HEADER => {}
                op::METADATA if length <= MOST_SAID => {
                    let Some((opcode, body)) = scan::record(&mut file, offset)? else {
                        return Ok(None);
                    };
                    if let Ok(Record::Metadata(said)) = mcap::parse_record(opcode, &body)
                        && said.name == PART
                    {
                        return Ok(Self::of(&said.metadata));
                    }
                }
                _ => return Ok(None),
            }
            offset = offset.saturating_add(scan::HEAD + length);
        }
        Ok(None)
    }
}

/// The files that are read as one if this is asked for, in their order: itself and the other parts of its recording in its folder;
/// of a folder, the recordings in it; of a name that parts were numbered from, the parts of the newest recording.
///
/// # Errors
/// The folder cannot be read.
pub(crate) fn recordings(path: &Path) -> io::Result<Vec<Vec<PathBuf>>> {
    if path.is_dir() {
        return all(path, |path| {
            path.extension().is_some_and(|ending| ending == ENDING)
        });
    }
    if !path.exists() {
        let parts: Vec<_> = named(path)?.into_iter().map(|(_, path)| path).collect();
        let Some(newest) = parts.last().cloned() else {
            return Ok(vec![vec![path.to_owned()]]);
        };
        return recordings(&newest);
    }
    let is_part = path.is_file() && Mark::read(path)?.is_some();
    let mut alike = match path.parent().filter(|_| is_part) {
        Some(folder) => all(folder_of(folder), |other| other.extension() == path.extension())?,
        None => Vec::new(),
    };
    alike.retain(|parts| parts.iter().any(|part| same(part, path)));
    if alike.is_empty() {
        alike.push(vec![path.to_owned()]);
    }
    Ok(alike)
}

/// The parts that were numbered from a name, by their files' numbers.
///
/// # Errors
/// The folder cannot be read.
pub(crate) fn named(path: &Path) -> io::Result<Vec<(u32, PathBuf)>> {
    let folder = folder_of(path.parent().unwrap_or(Path::new("")));
    let stem = path.file_stem().unwrap_or_default().as_encoded_bytes();
    let mut parts = Vec::new();
    for entry in listed(folder)? {
        let other = entry.file_stem().unwrap_or_default().as_encoded_bytes();
        let number = other
            .strip_prefix(stem)
            .and_then(|rest| rest.strip_prefix(b"-"))
            .and_then(|digits| str::from_utf8(digits).ok()?.parse().ok());
        if let Some(number) = number
            // There are other ways to write a number.
            && entry.file_name() == numbered(path, number).file_name()
            && entry.is_file()
            && Mark::read(&entry)?.is_some()
        {
            parts.push((number, entry));
        }
    }
    parts.sort();
    Ok(parts)
}

/// All recordings of a folder, each with its parts in their order. A copy of a part beside it is passed over.
fn all(folder: &Path, wanted: impl Fn(&Path) -> bool) -> io::Result<Vec<Vec<PathBuf>>> {
    let mut whole = Vec::new();
    let mut parts: BTreeMap<String, BTreeMap<u32, PathBuf>> = BTreeMap::new();
    for path in listed(folder)? {
        if !wanted(&path) || !path.is_file() {
            continue;
        }
        match Mark::read(&path)? {
            None => whole.push(vec![path]),
            Some(Mark { recording, number }) => {
                parts.entry(recording).or_default().entry(number).or_insert(path);
            }
        }
    }
    whole.extend(parts.into_values().map(|parts| parts.into_values().collect()));
    Ok(whole)
}

/// What is in a folder, by name; nothing in one that is not there.
fn listed(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let listed = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
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

fn same(one: &Path, other: &Path) -> bool {
    let real = |path: &Path| path.canonicalize().ok();
    real(one).is_some_and(|one| Some(one) == real(other))
}
