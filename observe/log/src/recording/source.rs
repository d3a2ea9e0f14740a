//! The form of a file with messages: MCAP, or the SQLite database of a bag of ROS 2; each perhaps packed by Zstandard as a
//! whole, as rosbag2 does on request. A packed file is unpacked beside other temporary files and deleted with the recording.

use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use tempfile::TempPath;

use super::{ReadError, failed, scan};

/// The first bytes of a frame of Zstandard.
pub(super) const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];
/// The first bytes of an SQLite database.
const SQLITE_MAGIC: &[u8] = b"SQLite format 3\0";

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    Mcap,
    Sqlite,
}

/// A file with messages.
#[derive(Debug)]
pub(super) struct Source {
    pub(super) form: Form,
    path: PathBuf,
    /// The file that the packed one was unpacked to.
    unpacked: Option<TempPath>,
}

impl Source {
    /// Recognizes a file by its first bytes, and unpacks it if it is packed.
    ///
    /// # Errors
    /// [`ReadError::File`], [`ReadError::NotRecording`].
    pub(super) fn new(path: &Path) -> Result<Self, ReadError> {
        let mut source = Self {
            form: Form::Mcap,
            path: path.to_owned(),
            unpacked: None,
        };
        let mut file = jde_files::open(path).map_err(failed(path))?;
        let mut head = read_head(&mut file).map_err(failed(path))?;
        if head.starts_with(&ZSTD) {
            let unpacked = unpack(&mut file).map_err(|error| {
                let folder = std::env::temp_dir();
                let reason = format!(
                    "unpacked into {} (TMPDIR names another folder): {error}",
                    folder.display()
                );
                failed(path)(io::Error::new(error.kind(), reason))
            })?;
            head = read_head(&mut File::open(&unpacked).map_err(failed(path))?).map_err(failed(path))?;
            source.unpacked = Some(unpacked);
        }
        if head.starts_with(SQLITE_MAGIC) {
            source.form = Form::Sqlite;
        } else if !head.starts_with(mcap::MAGIC) {
            return Err(ReadError::NotRecording(path.to_owned()));
        }
        Ok(source)
    }

    /// Returns the path of the file, or of the unpacked one.
    pub(super) fn path(&self) -> &Path {
        self.unpacked.as_deref().unwrap_or(&self.path)
    }
}

/// Whether a file that begins like that is a database or packed, as files of bags are.
pub(crate) fn is_of_bag(head: &[u8]) -> bool {
    head.starts_with(&ZSTD) || head.starts_with(&SQLITE_MAGIC[..mcap::MAGIC.len()])
}

fn read_head(file: &mut File) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    file.take(SQLITE_MAGIC.len() as u64).read_to_end(&mut head)?;
    Ok(head)
}

/// Unpacks a file. One that was cut off is unpacked up to there.
fn unpack(file: &mut File) -> io::Result<TempPath> {
    file.seek(SeekFrom::Start(0))?;
    let most = scan::most_unpacked(
        usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX),
        usize::MAX,
    ) as u64;
    let mut whole = tempfile::Builder::new().prefix("jde-").tempfile()?;
    let mut unpacking = zstd::Decoder::with_buffer(BufReader::new(file))?.take(most.saturating_add(1));
    let copied = match io::copy(&mut unpacking, &mut whole) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => 0,
        copied => copied?,
    };
    if copied > most {
        let reason = format!("it would have more than {} MB", most >> 20);
        return Err(io::Error::new(ErrorKind::FileTooLarge, reason));
    }
    Ok(whole.into_temp_path())
}
