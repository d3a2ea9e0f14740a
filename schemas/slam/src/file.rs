//! Saves the map, and reads it to continue it. A thread of its own writes, so that no iteration waits for a disk.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread;
use std::time::Duration;

use jde_grid::{Geometry, Occupancy, OccupancyGrid};
use jde_map_file::{MapFile, is_yaml};
use jde_schema::prelude::Pose2D;
use jde_slam::Continuation;

use crate::map::Map;

/// Reads the map of this YAML file, if there is one.
fn continued(file: &str) -> Result<Option<OccupancyGrid>, String> {
    let path = Path::new(file);
    if file.is_empty() || !path.exists() {
        return Ok(None);
    }
    let map = MapFile::load(path).map_err(|faults| format!("{faults:#}"))?;
    let [x, y, heading] = map.origin;
    let size = (map.width as u32, map.height as u32);
    let geometry = Geometry::new(size.0, size.1, map.resolution, (x, y, heading));
    let geometry = geometry.map_err(|error| format!("{file}: {error}"))?;
    let mut grid = OccupancyGrid::filled(geometry, Occupancy::Unknown);
    for (index, cell) in map.cells.iter().enumerate() {
        grid.set(geometry.cell(index), Occupancy::from_ros(cell.to_ros()));
    }
    Ok(Some(grid))
}

/// Begins to read the map of this YAML file, if there is one, on which the robot is at `start`.
///
/// # Errors
/// All faults of the file and of its image, that the start is not free, or that it has more than `most` keyframes.
pub(crate) fn begun(file: &str, start: &Pose2D, most: u32) -> Result<Option<Continuation>, String> {
    if !file.is_empty() && !is_yaml(Path::new(file)) {
        return Err(format!(
            "{file} is not the name of a YAML file: expected one such as office.yaml"
        ));
    }
    let Some(map) = continued(file)? else {
        return Ok(None);
    };
    let begun = Continuation::new(map, start).ok_or_else(|| {
        format!(
            "the map {file} has no free cells around the robot at {:.2}, {:.2}: state `map_start_pose`, or remove the files",
            start.x, start.y
        )
    })?;
    let count = begun.keyframes();
    if count > most as usize {
        return Err(format!(
            "the map {file} becomes {count} keyframes, one for each 0.7 m × 0.7 m of floor: raise `keyframes`, \
             which is {most}, or remove the files"
        ));
    }
    Ok(Some(begun))
}

/// What comes of a map that a thread reads.
pub(crate) type Loading = Receiver<Result<Option<Continuation>, String>>;

/// Has a thread begin to read the map of this YAML file, as [`begun`] does, once a build that slept has written it.
///
/// # Errors
/// Why there is no thread.
pub(crate) fn load(file: &str, start: Pose2D, most: u32) -> Result<Loading, String> {
    let (file, (sender, result)) = (file.to_owned(), mpsc::channel());
    let loading = thread::Builder::new().name("loading".to_owned()).spawn(move || {
        // Where folders cannot be locked, it does not wait.
        if let Ok(folder) = folder(&file) {
            let _ = folder.lock();
        }
        // If nobody waits for it, the schema has ended.
        let _ = sender.send(begun(&file, &start, most));
    });
    loading.map_err(|error| format!("there is no thread to read the map: {error}"))?;
    Ok(result)
}

/// Opens the folder of a file. It is locked while a schema that sleeps writes the file, since builds share nothing else.
fn folder(file: &str) -> io::Result<File> {
    let folder = Path::new(file).parent().filter(|folder| *folder != Path::new(""));
    File::open(folder.unwrap_or(Path::new(".")))
}

/// Locks the folder of a file for the one who is to write it, if it can be locked.
pub(crate) fn hold(file: &str) -> Option<File> {
    folder(file)
        .ok()
        .filter(|folder| folder.try_lock_shared().is_ok())
}

/// The time that a schema which ends waits for what is being saved.
const END_TIMEOUT: Duration = Duration::from_secs(1);

/// What is being saved. Dropping it waits for that for [`END_TIMEOUT`] at most: the process may end then.
#[derive(Debug, Default)]
pub(crate) struct Saving {
    /// The changes that the map has which is written, and what becomes of it.
    result: Option<(u64, Receiver<Result<(), String>>)>,
    /// When it last began.
    pub(crate) last: Option<Duration>,
}

impl Drop for Saving {
    fn drop(&mut self) {
        if let Some((_, result)) = &self.result {
            // A map that takes longer is as it was after the save before.
            let _ = result.recv_timeout(END_TIMEOUT);
        }
    }
}

impl Saving {
    /// Begins to save the map to this YAML file, after the one that is being written. The folder is held until then.
    ///
    /// # Errors
    /// Why it does not begin.
    pub(crate) fn begin(&mut self, file: &str, map: &Map, held: Option<File>) -> Result<(), String> {
        let (changes, map) = (map.changes(), map.file().ok_or("nothing is drawn yet")?);
        let (path, (sender, result)) = (PathBuf::from(file), mpsc::channel());
        let last = self.result.take();
        let saving = thread::Builder::new().name("saving".to_owned()).spawn(move || {
            let _held = held;
            // What became of it does not matter: this one takes its place.
            last.map(|(_, last)| last.recv());
            let saved = map.save(&path);
            // If nobody waits for it, the schema has ended.
            let _ = sender.send(saved.map_err(|error| format!("{}: {error}", path.display())));
        });
        saving.map_err(|error| format!("there is no thread to write it: {error}"))?;
        self.result = Some((changes, result));
        Ok(())
    }

    /// Whether a map is being written.
    pub(crate) const fn is_busy(&self) -> bool {
        self.result.is_some()
    }

    /// Returns once what has become of a map that was written: the changes that it has.
    pub(crate) fn end(&mut self) -> Option<Result<u64, String>> {
        let (changes, result) = self.result.as_ref()?;
        let ended = match result.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err("the thread that wrote it failed".into()),
            Ok(saved) => saved.map(|()| *changes),
        };
        self.result = None;
        Some(ended)
    }
}
