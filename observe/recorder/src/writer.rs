//! Writes one MCAP file: channels, messages, chunks. It has no thread and no queue: its caller waits for the
//! disk.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use jde_log::part::{Mark, PART};
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, McapError, WriteOptions};

use crate::{Error, Origin};

/// The quality of service with which `ros2 bag play` offers each topic, as rosbag2 stores it: keep last, reliable,
/// transient-local. A value holds until the next one, so a late subscriber gets the newest. Numbers instead of names,
/// because all versions of rosbag2 read those.
const OFFERED_QOS: &str = "\
- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: 1
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false
";

/// The destination of a recording's bytes.
pub(crate) type Output = Box<dyn Write + Send>;

/// A recording that is being written.
pub(crate) struct Writer {
    // Each chunk is assembled in memory and written in one piece, so no reader ever finds a chunk with an
    // unfinished header.
    mcap: mcap::Writer<NoSeek<BufWriter<CountingOutput>>>,
    /// The time at which the application's clock was 0, in ns since 1970.
    start: u64,
    bytes: Arc<AtomicU64>,
}

/// The times of a message, in ns of the application's clock, and its sequence number.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Times {
    pub(crate) log: u64,
    pub(crate) publish: u64,
    pub(crate) sequence: u64,
}

struct CountingOutput {
    output: Output,
    bytes: Arc<AtomicU64>,
}

/// Returns whether a folder belongs to this user. In other folders, such as one for temporary files, only
/// this user may read a recording and its images.
fn is_own(folder: &Path) -> bool {
    let owner = |path: &Path| fs::metadata(path).map(|metadata| metadata.uid());
    matches!((owner(folder), owner(Path::new("/proc/self"))), (Ok(a), Ok(b)) if a == b)
}

/// Creates the file of a recording, and its folder. In a folder that does not belong to this user,
/// only this user may read the file. The file is locked while it is open, so that no other recording
/// overwrites or deletes it.
pub(crate) fn create(path: &Path, overwrite: bool) -> Result<File, Error> {
    let failed = |error| Error::Create {
        path: path.to_owned(),
        error,
    };
    // A name without a folder is in the working folder.
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    jde_files::create_folder(folder).map_err(failed)?;
    let mut options = OpenOptions::new();
    options.write(true);
    if !is_own(folder) {
        options.mode(0o600);
    }
    // A pipe or a device contains nothing that could be lost.
    let is_file = fs::metadata(path).map_or(true, |metadata| metadata.is_file());
    match (is_file, overwrite) {
        (true, true) => options.create(true).truncate(false),
        (true, false) => options.create_new(true),
        (false, _) => &mut options,
    };
    let file = options.open(path).map_err(|error| {
        if error.kind() == ErrorKind::AlreadyExists {
            Error::Exists(path.to_owned())
        } else {
            failed(error)
        }
    })?;
    if is_file {
        // On a file system without locks, every file may be written.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(Error::Written(path.to_owned()));
        }
        if overwrite {
            file.set_len(0).map_err(failed)?;
        }
    }
    Ok(file)
}

impl Writer {
    /// Starts a recording, or a part of one. When it returns, the system has received the header.
    pub(crate) fn begin(output: Output, origin: &Origin, part: Option<&Mark>) -> io::Result<Self> {
        let bytes = Arc::new(AtomicU64::new(0));
        let counted = CountingOutput {
            output,
            bytes: Arc::clone(&bytes),
        };
        let options = WriteOptions::new()
            .profile("ros2")
            .compression(Some(Compression::Lz4))
            .library(concat!("jde ", env!("CARGO_PKG_VERSION")))
            // A chunk ends with a flush, so that it is known which messages the system has.
            .chunk_size(None)
            .disable_seeking(true);
        let mcap = options
            .create(NoSeek::new(BufWriter::new(counted)))
            .map_err(plain)?;
        let start = origin.start();
        let mut writer = Self { mcap, start, bytes };
        writer.metadata("jde", origin.metadata())?;
        if let Some(part) = part {
            writer.metadata(PART, part.to_metadata())?;
        }
        if let Some((name, text)) = &origin.file {
            let attachment = Attachment {
                log_time: start,
                create_time: start,
                name: name.clone(),
                media_type: "application/toml".to_owned(),
                data: Cow::Borrowed(text),
            };
            writer.mcap.attach(&attachment).map_err(plain)?;
        }
        writer.flush()?;
        Ok(writer)
    }

    /// Adds a channel of CDR messages, of a type with this name and definition. Calls with the same arguments
    /// return the same channel.
    pub(crate) fn channel(
        &mut self,
        topic: &str,
        (type_name, definition): (&str, &str),
        mut metadata: BTreeMap<String, String>,
    ) -> io::Result<u16> {
        metadata.insert("offered_qos_profiles".to_owned(), OFFERED_QOS.to_owned());
        let schema = self.mcap.add_schema(type_name, "ros2msg", definition.as_bytes());
        let schema = schema.map_err(plain)?;
        self.mcap
            .add_channel(schema, topic, "cdr", &metadata)
            .map_err(plain)
    }

    /// Adds a message to the present chunk.
    pub(crate) fn write_message(&mut self, channel_id: u16, times: Times, data: &[u8]) -> io::Result<()> {
        let header = MessageHeader {
            channel_id,
            // The format has 32 bits for it. The number restarts at 0 after the largest.
            sequence: times.sequence as u32,
            log_time: self.start.saturating_add(times.log),
            publish_time: self.start.saturating_add(times.publish),
        };
        self.mcap.write_to_known_channel(&header, data).map_err(plain)
    }

    /// Adds metadata of the whole recording.
    pub(crate) fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> io::Result<()> {
        let record = Metadata {
            name: name.to_owned(),
            metadata,
        };
        self.mcap.write_metadata(&record).map_err(plain)
    }

    /// Ends the present chunk and passes everything to the system. It then survives the end of this process,
    /// but not a power cut.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.mcap.flush().map_err(plain)
    }

    /// Writes the index and the end of the file.
    pub(crate) fn finish(&mut self) -> io::Result<()> {
        self.mcap.finish().map_err(plain)?;
        Ok(())
    }

    /// Returns the number of bytes that the system has received.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }
}

impl Write for CountingOutput {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.output.write(bytes)?;
        self.bytes.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}

fn plain(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}
