//! Shows files in place of a camera, at a constant rate by the application's clock, so that it also works in
//! lockstep.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use jde_picture::Picture;
use jde_schema::prelude::*;
use jde_schema::types::CameraInfo;

use crate::calibration;

/// Largest file that is read, bytes. A picture that fits has 0.9 MB uncompressed.
const LARGEST_FILE: u64 = 16 << 20;

/// Shows pictures from files: one PNG or JPEG, or all pictures of a folder in the order of their names.
#[derive(Describe)]
#[schema(driver, period = "20ms", budget = "100ms")]
pub struct Files {
    /// The file, or the folder.
    #[modulation(default = "", unit = "path", fixed)]
    path: Modulation<Text<1024>>,
    /// Pictures per second.
    #[modulation(default = 10.0, unit = "Hz", min = 0.001, max = 1000.0, fixed)]
    rate: Modulation<f64>,
    /// Whether it starts again after the last picture.
    #[modulation(default = Flag::TRUE, fixed)]
    repeat: Modulation<Flag>,
    /// The calibration file of the camera, as ROS's `camera_calibration` writes it; empty for none.
    #[modulation(default = "", unit = "file", fixed)]
    calibration: Modulation<Text<1024>>,
    /// The pictures, in rgb8.
    #[export]
    image: Export<Image>,
    /// The calibration of the file, with the time of the newest picture. None without `calibration`.
    #[export]
    camera_info: Export<CameraInfo>,
    /// Always connected. Its note names the pictures.
    #[export(lasting)]
    connection: Export<Connection>,
    sequence: Option<FileSequence>,
    info: Option<CameraInfo>,
}

/// The files, and the current position among them.
struct FileSequence {
    files: Vec<PathBuf>,
    bad: Vec<bool>,
    /// Time at which the first is due.
    start: Duration,
    /// How many were due so far.
    due: u64,
    /// The last one that was read.
    last: Option<(usize, Picture)>,
    ended: bool,
}

impl Schema for Files {
    fn awake(&mut self, cx: &Context) -> Result {
        if self.sequence.is_some() {
            return Ok(());
        }
        let files = self.files(cx)?;
        self.info = calibration::read(self.calibration.get(cx).as_str())?;
        let path = self.path.get(cx);
        let note = match &*files {
            [_] => format!("a picture of {path}"),
            files => format!("{} pictures of {path}", files.len()),
        };
        self.export_connection(cx, &note);
        self.sequence = Some(FileSequence {
            bad: vec![false; files.len()],
            files,
            start: cx.now(),
            due: 0,
            last: None,
            ended: false,
        });
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(mut sequence) = self.sequence.take() else {
            return Err("it has no pictures".into());
        };
        let due = (cx.now().saturating_sub(sequence.start).as_secs_f64() * self.rate.get(cx)) as u64 + 1;
        if due > sequence.due {
            // Skips pictures that are late, so that they do not accumulate.
            sequence.due = due;
            let count = sequence.files.len() as u64;
            if self.repeat.get(cx).get() || due <= count {
                self.show(cx, &mut sequence, ((due - 1) % count) as usize)?;
            } else if !sequence.ended {
                sequence.ended = true;
                self.export_connection(cx, "all pictures have been shown");
            }
        }
        self.sequence = Some(sequence);
        Ok(())
    }
}

impl Inspect for Files {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(
            &self.calibration,
            calibration::read(self.calibration.get(cx).as_str()),
        );
        let Some(files) = problems.expect(&self.path, self.files(cx)) else {
            return;
        };
        // Unreadable pictures are skipped, so one readable picture is enough.
        let mut bad = files.iter().map(|file| (file, read(file)));
        if let Some((file, Err(reason))) = bad.next()
            && bad.all(|(_, read)| read.is_err())
        {
            problems.wrong(&self.path, format!("{}: {reason}", file.display()));
        }
    }
}

impl Files {
    fn files(&self, cx: &Context) -> Result<Vec<PathBuf>> {
        let path = self.path.get(cx);
        if path.is_empty() {
            return Err("it has no pictures; give it a file or a folder: path = \"pictures\"".into());
        }
        let files = list(Path::new(path.as_str())).map_err(|error| format!("{path}: {error}"))?;
        if files.is_empty() {
            return Err(format!("{path} has no pictures: no file of it ends in .png, .jpg or .jpeg").into());
        }
        Ok(files)
    }

    fn show(&mut self, cx: &Context, sequence: &mut FileSequence, index: usize) -> Result {
        if sequence.bad[index] {
            return Ok(());
        }
        if sequence.last.as_ref().is_none_or(|(last, _)| *last != index) {
            let file = &sequence.files[index];
            match read(file) {
                Ok(picture) => sequence.last = Some((index, picture)),
                Err(reason) => {
                    let error = format!("{}: {reason}", file.display());
                    sequence.bad[index] = true;
                    if sequence.bad.iter().all(|bad| *bad) {
                        return Err(error.into());
                    }
                    warn!(cx, "a picture is left out: {error}");
                    return Ok(());
                }
            }
        }
        let Some((_, picture)) = &sequence.last else {
            return Ok(());
        };
        let mut image = self.image.loan(cx);
        image.header = Header::new(cx.now(), "camera");
        picture.write_to(&mut image)?;
        // Before the picture: whoever the picture wakes has both.
        calibration::publish(cx, &mut self.camera_info, self.info.as_ref(), &image.header);
        image.publish();
        Ok(())
    }

    fn export_connection(&mut self, cx: &Context, note: &str) {
        let connection = Connection {
            header: Header::new(cx.now(), ""),
            state: Connection::CONNECTED,
            note: Text::truncated(note),
            ..Connection::default()
        };
        self.connection.write(cx, connection);
    }
}

/// Lists the pictures of a folder in the order of their names. A file is its own list.
fn list(path: &Path) -> io::Result<Vec<PathBuf>> {
    if !fs::metadata(path)?.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let mut files = Vec::new();
    for entry in fs::read_dir(path)? {
        let file = entry?.path();
        let extension = file
            .extension()
            .map(|extension| extension.to_string_lossy().to_lowercase());
        if matches!(extension.as_deref(), Some("png" | "jpg" | "jpeg")) {
            files.push(file);
        }
    }
    files.sort();
    Ok(files)
}

fn read(file: &Path) -> Result<Picture, String> {
    let bytes = jde_files::read(file, LARGEST_FILE).map_err(|error| error.to_string())?;
    Picture::read(&bytes).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests;
