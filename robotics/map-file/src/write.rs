//! Writes a map as the files of a map server. It replaces older ones only when the new ones are whole.

use std::ffi::OsStr;
use std::io::{self, Write};
use std::path::Path;

use jde_document::{FaultReport, MAX_BYTES};
use jde_files::{read_text, replace};

use crate::{MapCell, MapFile, yaml};

/// The shades of an image for free, unknown and occupied cells.
const SHADES: [u8; 3] = [254, 205, 0];

/// Whether a map can be saved to a path: that of a YAML file, by its name.
#[must_use]
pub fn is_yaml(path: &Path) -> bool {
    path.to_str().is_some()
        && path
            .extension()
            .is_some_and(|extension| extension == "yaml" || extension == "yml")
}

impl MapFile {
    /// Writes the map to this YAML file, and its image beside it as PGM. The image of the older map stays, so that whoever
    /// has read the older YAML file finds it: two names take turns, `office.yaml.pgm` and `office.yaml.2.pgm`. The names of
    /// two maps in a folder are never equal.
    ///
    /// # Errors
    /// If a file cannot be written, or the path is not that of a YAML file; the older map stays then.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        let own = path.file_name().and_then(OsStr::to_str).filter(|_| is_yaml(path));
        let own = own.ok_or_else(|| {
            let message = "expected the path of a file such as office.yaml, whose name is Unicode";
            io::Error::new(io::ErrorKind::InvalidInput, message)
        })?;
        let [first, second] = [format!("{own}.pgm"), format!("{own}.2.pgm")];
        let older = read_text(path, MAX_BYTES)
            .ok()
            .and_then(|older| yaml::read(&mut FaultReport::new(path, &older), &older).0);
        let is_first = older.is_some_and(|image| image.ends_with(&first));
        let name = if is_first { second } else { first };
        replace(&path.with_file_name(&name), |file| file.write_all(&self.image()))?;
        replace(path, |file| file.write_all(self.yaml(&name).as_bytes()))
    }

    /// Returns the text of a YAML file that names an image as [`Self::image`] gives it.
    #[must_use]
    pub fn yaml(&self, image: &str) -> String {
        let [x, y, heading] = self.origin;
        format!(
            "image: {image:?}\nmode: trinary\nresolution: {:?}\norigin: [{x:?}, {y:?}, {heading:?}]\nnegate: 0\n\
             occupied_thresh: 0.65\nfree_thresh: 0.196\n",
            self.resolution
        )
    }

    /// Returns the image as PGM. Probabilities are written as what they are decided to be.
    #[must_use]
    pub fn image(&self) -> Vec<u8> {
        let mut pixels = format!("P5\n{} {}\n255\n", self.width, self.height).into_bytes();
        for row in self.cells.chunks_exact(self.width.max(1)).rev() {
            pixels.extend(row.iter().map(|cell| match cell.decided() {
                MapCell::Free => SHADES[0],
                MapCell::Unknown | MapCell::Likely(_) => SHADES[1],
                MapCell::Occupied => SHADES[2],
            }));
        }
        pixels
    }
}

#[cfg(test)]
mod tests {
    use jde_files::LeftOut;

    use super::*;

    fn map() -> MapFile {
        MapFile {
            width: 3,
            height: 2,
            resolution: 0.05,
            origin: [-1.25, 0.1 + 0.2, 0.0],
            cells: vec![
                MapCell::Free,
                MapCell::Occupied,
                MapCell::Unknown,
                MapCell::Unknown,
                MapCell::Free,
                MapCell::Free,
            ],
            left_out: LeftOut::default(),
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
        assert_eq!(names, 3, "the YAML file and two images");
    }

    #[test]
    fn whoever_has_read_the_older_yaml_file_finds_its_image() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("office.yaml");
        map().save(&path).expect("it is written");
        for (width, height) in [(2, 3), (6, 1), (1, 6)] {
            let older = (std::fs::read_to_string(&path), MapFile::load(&path));
            let text = older.0.expect("it is there");
            let newer = MapFile {
                width,
                height,
                ..map()
            };
            newer.save(&path).expect("it is written");
            assert_eq!(MapFile::parse(&path, &text), older.1);
            assert_eq!(MapFile::load(&path), Ok(newer));
        }
    }

    #[test]
    fn an_image_that_another_file_names_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("office.yaml");
        let by_hand = folder.path().join("by hand.yaml");
        map().save(&path).expect("it is written");
        let text = std::fs::read_to_string(&path).expect("it is there");
        std::fs::rename(
            folder.path().join("office.yaml.pgm"),
            folder.path().join("office.pgm"),
        )
        .expect("it is renamed");
        std::fs::write(&by_hand, text.replace("office.yaml.pgm", "office.pgm")).expect("it is written");
        let mut other = map();
        (other.width, other.height) = (2, 3);
        (0..3).for_each(|_| other.save(&path).expect("it is written"));
        assert_eq!(MapFile::load(&by_hand), Ok(map()));
    }

    #[test]
    fn a_save_that_fails_half_way_leaves_the_older_map() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("office.yaml");
        map().save(&path).expect("it is written");
        let mut other = map();
        (other.width, other.height) = (2, 3);
        // The image is the first file that is written.
        let image = folder.path().join("office.yaml.2.pgm");
        std::fs::create_dir(&image).expect("a folder");
        assert!(other.save(&path).is_err());
        assert_eq!(MapFile::load(&path), Ok(map()));
        std::fs::remove_dir(&image).expect("it is empty");
        other.save(&path).expect("it is written");
        assert_eq!(MapFile::load(&path), Ok(other));
    }

    #[test]
    fn maps_whose_names_are_alike_keep_their_images() {
        let folder = tempfile::tempdir().expect("a folder");
        let names = ["office.yaml", "office.yml", "office.2.yaml", "office.yaml.2.yaml"];
        let maps = [1, 2, 3, 6].map(|width| MapFile {
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
    fn a_name_that_is_not_of_a_yaml_file_is_no_path_for_a_map() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["m.pgm", "office", ".yaml", "office.yaml.2", ".."] {
            assert!(map().save(&folder.path().join(name)).is_err(), "{name}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
    }

    #[test]
    fn where_nothing_can_be_written_an_error_says_so() {
        let folder = tempfile::tempdir().expect("a folder");
        let missing = folder.path().join("missing/map.yaml");
        assert!(map().save(&missing).is_err() && map().save(Path::new("/")).is_err());
    }
}
