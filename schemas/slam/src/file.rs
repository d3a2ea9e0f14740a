//! Saves the map, and reads it to continue it. A thread of its own writes, so that no iteration waits for a disk.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread;
use std::time::Duration;

use jde_grid::{Geometry, Occupancy, OccupancyGrid};
use jde_map_file::{Cell, MapFile};

use crate::map::Map;

/// Reads the map of this YAML file, if there is one.
///
/// # Errors
/// All faults of the file and of its image.
pub(crate) fn continued(file: &str) -> Result<Option<OccupancyGrid>, String> {
    let path = Path::new(file);
    if file.is_empty() || !path.exists() {
        return Ok(None);
    }
    let map = MapFile::load(path).map_err(|faults| {
        let lines: Vec<String> = faults.iter().map(ToString::to_string).collect();
        lines.join("\n")
    })?;
    let [x, y, heading] = map.origin;
    let size = (map.width as u32, map.height as u32);
    let geometry = Geometry::new(size.0, size.1, map.resolution, (x, y, heading));
    let geometry = geometry.map_err(|error| format!("{file}: {error}"))?;
    let mut grid = OccupancyGrid::filled(geometry, Occupancy::Unknown);
    for (index, cell) in map.cells.iter().enumerate() {
        let state = match cell {
            Cell::Free => Occupancy::Free,
            Cell::Occupied => Occupancy::Occupied,
            Cell::Unknown => Occupancy::Unknown,
        };
        grid.set(geometry.cell(index), state);
    }
    Ok(Some(grid))
}

/// What is being saved.
#[derive(Debug, Default)]
pub(crate) struct Saving {
    result: Option<Receiver<Result<(), String>>>,
    /// When it last began.
    pub(crate) last: Option<Duration>,
    failure: Option<String>,
}

impl Saving {
    /// Begins to save the map to this YAML file. Returns whether it did: not while the last one is not saved yet.
    pub(crate) fn begin(&mut self, file: &str, map: &Map) -> bool {
        if self.is_busy() {
            return false;
        }
        let Some(map) = map.file() else { return false };
        let (path, (sender, result)) = (PathBuf::from(file), mpsc::channel());
        let saving = thread::Builder::new().name("saving".to_owned()).spawn(move || {
            let saved = map.save(&path);
            // If nobody waits for it, the schema has ended.
            let _ = sender.send(saved.map_err(|error| format!("{}: {error}", path.display())));
        });
        match saving {
            Ok(_) => self.result = Some(result),
            Err(error) => self.failure = Some(format!("there is no thread to write it: {error}")),
        }
        true
    }

    /// Whether a map is being written.
    pub(crate) fn is_busy(&mut self) -> bool {
        let Some(result) = &self.result else { return false };
        match result.try_recv() {
            Err(TryRecvError::Empty) => return true,
            Ok(Err(error)) => self.failure = Some(error),
            Err(TryRecvError::Disconnected) => self.failure = Some("the thread that wrote it failed".into()),
            Ok(Ok(())) => {}
        }
        self.result = None;
        false
    }

    /// Returns why the last map was not saved, once.
    pub(crate) fn failure(&mut self) -> Option<String> {
        self.is_busy();
        self.failure.take()
    }
}
