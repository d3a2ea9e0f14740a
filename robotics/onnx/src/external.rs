//! Weights in a second file: only below the folder of the network, so that a network that somebody sends reads nothing else.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use crate::model::Stored;
use crate::{MAX_BYTES, OnnxError};

/// The files beside a network that were read.
pub(crate) struct Beside<'a> {
    folder: Option<&'a Path>,
    /// By their stated locations.
    pub(crate) files: HashMap<String, Vec<u8>>,
}

impl<'a> Beside<'a> {
    /// Files below `folder`; none are read without one.
    pub(crate) fn new(folder: Option<&'a Path>) -> Self {
        Self {
            folder,
            files: HashMap::new(),
        }
    }

    /// Returns the bytes of stored numbers that are in another file; `None` if they are in the network's.
    pub(crate) fn bytes(&mut self, stored: &Stored) -> Result<Option<&[u8]>, OnnxError> {
        if !stored.is_external {
            return Ok(None);
        }
        let wrong = |message: String| OnnxError::tensor(&stored.name, message);
        let entry = |key: &str| {
            stored
                .external
                .iter()
                .find(|(known, _)| known == key)
                .map(|(_, value)| value.as_str())
        };
        let number = |key: &str| {
            let stated = entry(key).map(str::parse::<usize>).transpose();
            stated.map_err(|_| wrong(format!("the `{key}` of its weights in another file is no number")))
        };
        let location = entry("location")
            .ok_or_else(|| wrong("its weights are in another file without a name".to_owned()))?;
        let (offset, length) = (number("offset")?.unwrap_or(0), number("length")?);
        if !self.files.contains_key(location) {
            let bytes = self
                .read(location)
                .map_err(|message| wrong(format!("its weights are in `{location}`, {message}")))?;
            self.files.insert(location.to_owned(), bytes);
        }
        let file = &self.files[location];
        let end = match length {
            Some(length) => offset.checked_add(length),
            None => Some(file.len()),
        };
        let bytes = end.and_then(|end| file.get(offset..end));
        bytes.map(Some).ok_or_else(|| {
            wrong(format!(
                "`{location}` ends before its weights: is it of another network?"
            ))
        })
    }

    fn read(&self, location: &str) -> Result<Vec<u8>, String> {
        let folder = self.folder.ok_or("which is not read here")?;
        let below = Path::new(location);
        if !below
            .components()
            .all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
        {
            return Err(
                "which leaves the network's folder; put it beside the network, and state its name alone"
                    .to_owned(),
            );
        }
        let real = |path: PathBuf| {
            path.canonicalize()
                .map_err(|error| format!("which cannot be read: {error}"))
        };
        let path = real(folder.join(below))?;
        if !path.starts_with(real(folder.to_owned())?) {
            return Err("which is a link that leaves the network's folder; copy the file".to_owned());
        }
        jde_files::read(&path, MAX_BYTES).map_err(|error| format!("which cannot be read: {error}"))
    }
}
