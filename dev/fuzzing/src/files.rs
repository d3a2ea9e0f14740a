//! What must hold for any bytes in the place of a file: they are read or refused with words. The fuzz targets run these
//! checks as well.

use std::fs;
use std::path::PathBuf;
use std::process;
use std::thread;

use jde_sim::World;

/// Writes the bytes up to the first 0 as a file, and those after it as an image beside it, `m`.
fn written(name: &str, data: &[u8]) -> PathBuf {
    let (process, thread) = (process::id(), thread::current().id());
    let folder = std::env::temp_dir().join(format!("jde-files-{process}-{thread:?}"));
    fs::create_dir_all(&folder).expect("a folder");
    let mut parts = data.splitn(2, |byte| *byte == 0);
    let file = folder.join(name);
    fs::write(&file, parts.next().unwrap_or_default()).expect("it is written");
    fs::write(folder.join("m"), parts.next().unwrap_or_default()).expect("it is written");
    file
}

/// Checks the reader of maps.
pub(crate) fn map(data: &[u8]) {
    let file = written("map.yaml", data);
    if let Err(error) = World::parse("map = 'map.yaml'", file.with_file_name("world.toml"), 0) {
        assert!(!error.faults().is_empty(), "{error}");
    }
}

/// Checks the readers of worlds of other programs: a world that is converted is one that is read, unless a robot
/// starts where something stands.
pub(crate) fn import(data: &[u8]) {
    let file = written("world.txt", data);
    match jde_sim::import(&file, &[], "world") {
        Ok(worlds) => {
            for world in worlds {
                for (name, contents) in &world.files {
                    fs::write(file.with_file_name(name), contents).expect("it is written");
                }
                let read = World::parse(&world.text, file.with_file_name("world.toml"), 0);
                let error = read.err().map(|error| error.to_string()).unwrap_or_default();
                assert!(
                    !error.contains("unknown key") && !error.contains("TOML"),
                    "{error}\n{}",
                    world.text
                );
            }
        }
        Err(error) => assert!(!error.faults().is_empty(), "{error}"),
    }
}
