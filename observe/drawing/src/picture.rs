//! A drawing as a PNG file. Draws nothing itself.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::Drawing;
use crate::map::{self, DriveMap};

/// A picture.
pub struct Picture {
    drawing: Drawing,
    /// Pixels per unit of the drawing.
    scale: f32,
}

/// Why a picture could not be encoded or saved.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file or its folder is not writable.
    #[error("cannot write the picture `{}`: {error}; name a file in a folder that can be written", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        error: io::Error,
    },
    /// The picture cannot be encoded as PNG.
    #[error("cannot encode the picture as PNG: {0}")]
    Encode(String),
}

impl Picture {
    /// Draws a drive from above, 1600 pixels wide; narrower for a world that is higher than wide. The same
    /// drive gives the same picture.
    #[must_use]
    pub fn of_drive(drive: &DriveMap) -> Self {
        Self::new(map::draw(drive, true), 1.0)
    }

    /// A picture of a drawing, of `scale` pixels per unit.
    #[must_use]
    pub fn new(drawing: Drawing, scale: f32) -> Self {
        Self { drawing, scale }
    }

    /// Encodes the picture as PNG.
    ///
    /// # Errors
    /// [`PictureError::Encode`].
    pub fn png(&self) -> Result<Vec<u8>, PictureError> {
        let pixels = self.drawing.pixels(self.scale);
        pixels
            .encode_png()
            .map_err(|error| PictureError::Encode(error.to_string()))
    }

    /// Writes the picture to a PNG file, and creates its folder if necessary.
    ///
    /// # Errors
    /// [`PictureError`].
    pub fn save(&self, path: &Path) -> Result<(), PictureError> {
        let encoded = self.png()?;
        let folder = path.parent().unwrap_or(Path::new(""));
        jde_files::create_folder(folder)
            .and_then(|()| jde_files::replace(path, |file| file.write_all(&encoded)))
            .map_err(|error| PictureError::Write {
                path: path.to_owned(),
                error,
            })
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::map::{PathPoint, RobotPath};

    fn drive() -> DriveMap {
        let at = |time: f64| PathPoint {
            time,
            x: time,
            y: 2.0,
            heading: 0.0,
            winner: Some(0),
        };
        DriveMap {
            title: "a line".to_owned(),
            paths: vec![RobotPath {
                points: vec![at(0.0), at(4.0)],
                ..RobotPath::default()
            }],
            schema_names: vec!["goon".to_owned()],
            ..DriveMap::default()
        }
    }

    #[test]
    fn a_picture_is_saved_into_a_new_folder_and_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("demo/path.png");
        let picture = Picture::of_drive(&drive());
        picture.save(&path).unwrap();
        let read = tiny_skia::Pixmap::decode_png(&fs::read(&path).unwrap()).unwrap();
        assert_eq!(read.data(), picture.drawing.pixels(1.0).data());
    }

    #[test]
    fn a_folder_that_cannot_be_created_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let picture = Picture::of_drive(&drive());
        let error = picture.save(&file.join("path.png")).unwrap_err().to_string();
        assert!(
            error.contains("path.png") && error.contains("cannot write"),
            "{error}"
        );
    }
}
