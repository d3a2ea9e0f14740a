//! Writes a map as the files of a map server. It replaces older ones only when the new ones are whole.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::{Cell, MapFile, yaml};

/// The shades of an image for free, unknown and occupied cells.
const SHADES: [u8; 3] = [254, 205, 0];

impl MapFile {
    /// Writes the map to this YAML file, and its image beside it as PGM of the same name. The image of an older map stays
    /// until the YAML file names the new one, so two names take turns: `office.pgm` and `office.yaml.pgm`.
    ///
    /// # Errors
    /// If a file cannot be written, or the path is that of an image; the older map stays then.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        let is_image = path.extension().is_some_and(|extension| extension == "pgm");
        let own = path.file_name().and_then(OsStr::to_str).filter(|_| !is_image);
        let own = own.ok_or_else(|| {
            let message = "expected the path of a YAML file whose name is Unicode";
            io::Error::new(io::ErrorKind::InvalidInput, message)
        })?;
        let images = [
            path.with_extension("pgm"),
            path.with_file_name(format!("{own}.pgm")),
        ];
        // Which of them the older map has.
        let older = std::fs::read_to_string(path).ok();
        let used = older.and_then(|older| yaml::image(path, &older));
        let used = images.iter().position(|image| used.as_ref() == Some(image));
        let image = &images[usize::from(used == Some(0))];
        let name = image.file_name().and_then(OsStr::to_str).unwrap_or_default();
        let [x, y, heading] = self.origin;
        let text = format!(
            "image: {name:?}\nmode: trinary\nresolution: {:?}\norigin: [{x:?}, {y:?}, {heading:?}]\nnegate: 0\n\
             occupied_thresh: 0.65\nfree_thresh: 0.196\n",
            self.resolution
        );
        let mut pixels = format!("P5\n{} {}\n255\n", self.width, self.height).into_bytes();
        for row in self.cells.chunks_exact(self.width.max(1)).rev() {
            pixels.extend(row.iter().map(|cell| match cell {
                Cell::Free => SHADES[0],
                Cell::Unknown => SHADES[1],
                Cell::Occupied => SHADES[2],
            }));
        }
        replace(image, &pixels)?;
        replace(path, text.as_bytes())?;
        match used.map(|used| std::fs::remove_file(&images[used])) {
            Some(Err(error)) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

/// Writes a file beside an older one, and gives it that one's name when it is on the disk.
fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut name = path.file_name().map(OsString::from).unwrap_or_default();
    name.push(".new");
    let new: PathBuf = path.with_file_name(name);
    let mut file = File::create(&new)?;
    file.write_all(bytes)?;
    file.sync_all()?;
    std::fs::rename(&new, path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> MapFile {
        MapFile {
            width: 3,
            height: 2,
            resolution: 0.05,
            origin: [-1.25, 0.1 + 0.2, 0.0],
            cells: vec![
                Cell::Free,
                Cell::Occupied,
                Cell::Unknown,
                Cell::Unknown,
                Cell::Free,
                Cell::Free,
            ],
        }
    }

    #[test]
    fn what_is_saved_is_read_as_it_was() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("my house.yaml");
        for _ in 0..3 {
            map().save(&path).expect("it is written");
            assert_eq!(MapFile::load(&path), Ok(map()));
        }
        let names = std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(names, 2, "nothing else is left");
    }

    #[test]
    fn a_save_that_fails_half_way_leaves_the_older_map() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("office.yaml");
        map().save(&path).expect("it is written");
        // The image can be written, and the YAML file cannot.
        std::fs::create_dir(folder.path().join("office.yaml.new")).expect("a folder");
        let mut other = map();
        (other.width, other.height) = (2, 3);
        assert!(other.save(&path).is_err());
        assert_eq!(MapFile::load(&path), Ok(map()));
        std::fs::remove_dir(folder.path().join("office.yaml.new")).expect("it is empty");
        other.save(&path).expect("it is written");
        assert_eq!(MapFile::load(&path), Ok(other));
    }

    #[test]
    fn maps_whose_names_are_alike_keep_their_images() {
        let folder = tempfile::tempdir().expect("a folder");
        let names = ["office.yaml", "office.2.yaml", "my office.yaml"];
        let maps = [1, 2, 3].map(|width| MapFile {
            width,
            height: 6 / width,
            ..map()
        });
        for _ in 0..3 {
            for (name, map) in names.iter().zip(&maps) {
                map.save(&folder.path().join(name)).expect("it is written");
            }
            for (name, map) in names.iter().zip(&maps) {
                assert_eq!(
                    MapFile::load(&folder.path().join(name)).as_ref(),
                    Ok(map),
                    "{name}"
                );
            }
        }
    }

    #[test]
    fn an_image_is_no_path_for_a_map() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(map().save(&folder.path().join("m.pgm")).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
    }

    #[test]
    fn where_nothing_can_be_written_an_error_says_so() {
        let folder = tempfile::tempdir().expect("a folder");
        let missing = folder.path().join("missing/map.yaml");
        assert!(map().save(&missing).is_err() && map().save(Path::new("/")).is_err());
    }
}
