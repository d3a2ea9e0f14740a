//! Reads the text of a file, or reports why that is impossible. Does not parse it.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use jde_nearest::nearest;

use super::fault::Faults;
use super::report::{FaultReport, quote};

/// The largest file: enough for forty thousand schemas, or things of a world. Nobody writes a larger one.
pub const MAX_BYTES: u64 = 4 << 20;

/// Returns the text of a file, without the byte order mark. `what` names its kind in messages: "an application file".
///
/// # Errors
/// It cannot be read, is too large, or is not UTF-8.
pub fn read(path: &Path, what: &str) -> Result<String, Faults> {
    let text = String::from_utf8(bytes(path, what)?).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let text = String::from_utf8_lossy(&error.as_bytes()[..good]);
        let mut report = FaultReport::new(path, &text);
        report
            .fault(
                &(good..good + 1),
                format!("this byte is not UTF-8, which {what} must be"),
            )
            .advise("save the file as UTF-8");
        report.into_faults()
    })?;
    Ok(match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}

fn bytes(path: &Path, what: &str) -> Result<Vec<u8>, Faults> {
    let error = match jde_files::read(path, MAX_BYTES) {
        Ok(bytes) => return Ok(bytes),
        Err(error) => error,
    };
    let mut report = FaultReport::new(path, "");
    if error.kind() == ErrorKind::NotFound {
        let fault = report.file_fault("there is no such file");
        if let Some(near) = similar_file(path) {
            fault.advise(format!("did you mean {}?", quote(&near.to_string_lossy())));
        }
    } else if path.is_dir() {
        report
            .file_fault("this is a folder")
            .advise(format!("give the path of {what} in it"));
    } else if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::InvalidData) {
        report
            .file_fault(format!("{error}, so this is not {what}"))
            .advise(format!("give the path of {what}"));
    } else {
        report.file_fault(format!("the file cannot be read: {error}"));
    }
    Err(report.into_faults())
}

/// Returns the file in the same folder with the same extension and the most similar name.
fn similar_file(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let extension = path.extension();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let names: Vec<String> = std::fs::read_dir(folder.unwrap_or(Path::new(".")))
        .ok()?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| Path::new(name).extension() == extension)
        .collect();
    let near = nearest(name, names.iter().map(String::as_str))?;
    Some(folder.map_or_else(|| PathBuf::from(near), |folder| folder.join(near)))
}
