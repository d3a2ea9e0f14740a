//! Recordings in parts: the mark and the name of each part, and which files are parts of the same recording. It reads only
//! the beginning of each file.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use mcap::records::{Record, op};

use crate::recording::scan;

/// The name of the metadata with the mark of a part.
pub(crate) const PART: &str = "jde/part";
/// The name of the metadata with the position at which the new messages of a part begin. Before it, the part
/// repeats the values in force. The first part has none.
pub(crate) const BEGINS: &str = "jde/part/begins";
/// The key of that position, in bytes from the beginning of the file.
pub(crate) const BYTE: &str = "byte";
/// The file name extension of a recording in a folder.
const EXTENSION: &str = "mcap";
/// The file that makes a folder a bag of ROS 2.
const BAG: &str = "metadata.yaml";
/// The largest size of a metadata record up to the mark, in bytes.
const MAX_METADATA_BYTES: u64 = 1 << 20;

/// The mark of a part: which part of which recording a file is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Mark {
    /// An identifier that all parts of one recording share, and no others have.
    pub(crate) recording: String,
    /// The number of the part, from 1.
    pub(crate) number: u32,
}

impl Mark {
    /// Returns the mark as metadata.
    #[cfg(feature = "record")]
    pub(crate) fn to_metadata(&self) -> BTreeMap<String, String> {
        BTreeMap::from([
            ("recording".to_owned(), self.recording.clone()),
            ("number".to_owned(), self.number.to_string()),
        ])
    }

    /// Reads the mark from metadata.
    pub(crate) fn from_metadata(metadata: &BTreeMap<String, String>) -> Option<Self> {
        Some(Self {
            recording: metadata.get("recording")?.clone(),
            number: metadata.get("number")?.parse().ok()?,
        })
    }

    /// Reads the mark of a file. `None` if the file is a whole recording, or not a recording.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(crate) fn read(path: &Path) -> io::Result<Option<Self>> {
        let mut file = File::open(path)?;
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

/// Finds the recordings that `path` denotes, each with its files in their order. A file denotes itself and
/// the other parts of its recording in its folder. A folder denotes the recordings in it, and that of a bag of ROS 2
/// without marks one recording. The name from which parts were numbered denotes the parts of the newest recording.
///
/// # Errors
/// The folder cannot be read.
pub(crate) fn find_recordings(path: &Path) -> io::Result<Vec<Vec<PathBuf>>> {
    if path.is_dir() {
        let is_mcap = |path: &Path| path.extension().is_some_and(|extension| extension == EXTENSION);
        if path.join(BAG).is_file() {
            let mut files: Vec<_> = listed(path)?.into_iter().filter(|path| is_mcap(path)).collect();
            // Tools of ROS 2 describe folders of recordings that are marked, too.
            let mut is_marked = false;
            for file in &files {
                is_marked |= Mark::read(file)?.is_some();
            }
            if !is_marked {
                // `bag_10` is behind `bag_9`.
                files.sort_by_key(|file| file.as_os_str().len());
                return Ok(Vec::from_iter((!files.is_empty()).then_some(files)));
            }
        }
        return find_in_folder(path, is_mcap);
    }
    if !path.exists() {
        let parts: Vec<_> = find_parts(path)?.into_iter().map(|(_, path)| path).collect();
        let Some(newest) = parts.last().cloned() else {
            return Ok(vec![vec![path.to_owned()]]);
        };
        return find_recordings(&newest);
    }
    let is_part = path.is_file() && Mark::read(path)?.is_some();
    let mut recordings = match path.parent().filter(|_| is_part) {
        Some(folder) => find_in_folder(folder_of(folder), |other| other.extension() == path.extension())?,
        None => Vec::new(),
    };
    recordings.retain(|parts| parts.iter().any(|part| is_same_file(part, path)));
    if recordings.is_empty() {
        recordings.push(vec![path.to_owned()]);
    }
    Ok(recordings)
}

/// Finds the parts that were numbered from a name, in the order of the numbers in their file names.
///
/// # Errors
/// The folder cannot be read.
pub(crate) fn find_parts(path: &Path) -> io::Result<Vec<(u32, PathBuf)>> {
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
            // Only the canonical form of the number counts, so not `-0001`.
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

/// Returns the name with a number: `drive-001.mcap` for `drive.mcap`.
pub(crate) fn numbered(path: &Path, number: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number:03}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// Finds all recordings of a folder, each with its parts in their order. A second copy of a part is ignored.
fn find_in_folder(folder: &Path, is_candidate: impl Fn(&Path) -> bool) -> io::Result<Vec<Vec<PathBuf>>> {
    let mut recordings = Vec::new();
    let mut parts: BTreeMap<String, BTreeMap<u32, PathBuf>> = BTreeMap::new();
    for path in listed(folder)? {
        if !is_candidate(&path) || !path.is_file() {
            continue;
        }
        match Mark::read(&path)? {
            None => recordings.push(vec![path]),
            Some(Mark { recording, number }) => {
                parts.entry(recording).or_default().entry(number).or_insert(path);
            }
        }
    }
    recordings.extend(parts.into_values().map(|parts| parts.into_values().collect()));
    Ok(recordings)
}

/// Returns the entries of a folder, sorted by name. Empty if the folder does not exist.
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
