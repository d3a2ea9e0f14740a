//! One MCAP file on its way to the disk: channels, messages, chunks. Knows no thread and no queue; whoever calls it waits for
//! the disk.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use jde_abi::describe::Type;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, McapError, WriteOptions};

use jde_ros::definition;

use crate::part::{Mark, PART};
use crate::{Error, Origin, panel};

/// Where the bytes of a recording go.
pub(crate) type Output = Box<dyn Write + Send>;

/// A recording that is being written.
pub(crate) struct Writer {
    // A chunk is made in memory and written whole: no reader ever meets one whose head has yet to be filled in.
    mcap: mcap::Writer<NoSeek<BufWriter<Counted>>>,
    /// ns since 1970 when the application's clock was 0.
    start: u64,
    bytes: Arc<AtomicU64>,
}

/// When a message was made, in the application's time.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Times {
    pub(crate) log: u64,
    pub(crate) publish: u64,
    pub(crate) sequence: u64,
}

struct Counted {
    output: Output,
    bytes: Arc<AtomicU64>,
}

/// Whether a folder is this user's. In one that others share, such as that of temporary files, a recording and its pictures are for nobody else.
fn is_own(folder: &Path) -> bool {
    let owner = |path: &Path| fs::metadata(path).map(|there| there.uid());
    matches!((owner(folder), owner(Path::new("/proc/self"))), (Ok(one), Ok(other)) if one == other)
}

/// Makes the file of a recording, and the folders above it. In a folder that is not this user's, nobody else may read it. It is locked
/// for as long as it is open, so that no other recording writes over it or deletes it.
pub(crate) fn create(path: &Path, overwrite: bool) -> Result<File, Error> {
    let failed = |error| Error::Create {
        path: path.to_owned(),
        error,
    };
    // A name alone is one in the folder that one works in.
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(failed)?;
    let mut options = OpenOptions::new();
    options.write(true);
    if !is_own(folder) {
        options.mode(0o600);
    }
    // A pipe or a device holds nothing that could be lost.
    let is_file = fs::metadata(path).map_or(true, |there| there.is_file());
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
        // A file system without locks has every file.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(Error::Written(path.to_owned()));
        }
        file.set_len(0).map_err(failed)?;
    }
    Ok(file)
}

impl Writer {
    /// Begins a recording, or a part of one; its head has reached the system when this returns.
    pub(crate) fn begin(output: Output, origin: &Origin, part: Option<&Mark>) -> io::Result<Self> {
        let bytes = Arc::new(AtomicU64::new(0));
        let counted = Counted {
            output,
            bytes: Arc::clone(&bytes),
        };
        let options = WriteOptions::new()
            .compression(Some(Compression::Lz4))
            .library(concat!("jde ", env!("CARGO_PKG_VERSION")))
            .disable_seeking(true);
        let mcap = options
            .create(NoSeek::new(BufWriter::new(counted)))
            .map_err(plain)?;
        let start = origin.start();
        let mut writer = Self { mcap, start, bytes };
        writer.metadata("jde", origin.metadata())?;
        if let Some(part) = part {
            writer.metadata(PART, part.told())?;
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

    /// Adds a channel of CDR messages; those of the same topic, type and metadata are one.
    pub(crate) fn variable(
        &mut self,
        topic: &str,
        value_type: &Type,
        about: &BTreeMap<String, String>,
    ) -> io::Result<u16> {
        let text = definition::definition(value_type);
        self.channel(
            topic,
            &definition::name(value_type),
            ("ros2msg", text.as_bytes()),
            "cdr",
            about,
        )
    }

    /// Adds a channel of JSON messages.
    pub(crate) fn json(&mut self, topic: &str, name: &str, schema: &str) -> io::Result<u16> {
        let schema = ("jsonschema", schema.as_bytes());
        self.channel(topic, name, schema, "json", &BTreeMap::new())
    }

    /// Adds a channel of what a panel showed: CBOR, which needs no definition to be read.
    pub(crate) fn panel(&mut self, topic: &str, about: &BTreeMap<String, String>) -> io::Result<u16> {
        self.channel(topic, panel::TYPE, ("", &[]), panel::ENCODING, about)
    }

    fn channel(
        &mut self,
        topic: &str,
        name: &str,
        (encoding, schema): (&str, &[u8]),
        messages: &str,
        about: &BTreeMap<String, String>,
    ) -> io::Result<u16> {
        let schema = self.mcap.add_schema(name, encoding, schema).map_err(plain)?;
        self.mcap
            .add_channel(schema, topic, messages, about)
            .map_err(plain)
    }

    /// Adds a message to the present chunk.
    pub(crate) fn message(&mut self, channel_id: u16, times: Times, data: &[u8]) -> io::Result<()> {
        let header = MessageHeader {
            channel_id,
            // The format has no room for more; it counts on from 0.
            sequence: times.sequence as u32,
            log_time: self.start.saturating_add(times.log),
            publish_time: self.start.saturating_add(times.publish),
        };
        self.mcap.write_to_known_channel(&header, data).map_err(plain)
    }

    /// Says something of the recording as a whole.
    pub(crate) fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> io::Result<()> {
        let record = Metadata {
            name: name.to_owned(),
            metadata,
        };
        self.mcap.write_metadata(&record).map_err(plain)
    }

    /// Ends the present chunk and hands everything to the system: it is safe from the end of this process, not from a power
    /// cut.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.mcap.flush().map_err(plain)
    }

    /// Writes the index and the end.
    pub(crate) fn finish(&mut self) -> io::Result<()> {
        self.mcap.finish().map_err(plain)?;
        Ok(())
    }

    /// Bytes that have reached the system.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }
}

impl Write for Counted {
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
