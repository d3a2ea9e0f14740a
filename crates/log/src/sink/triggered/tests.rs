//! Disks that become full before or while a file is written.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::sync::Mutex;
use std::sync::mpsc::sync_channel;
use std::time::SystemTime;

use jde_types::Value;

use super::*;
use crate::Recording;
use crate::pre_trigger_buffer::StateKey;
use crate::topic::{TopicContent, TopicQueue};
use crate::writer;

const SECOND: Nanos = 1_000_000_000;

/// A disk that accepts a limited number of bytes of the second file and none of the third.
struct FailingDisk {
    file: File,
    room: usize,
}

impl Write for FailingDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.room == 0 {
            return Err(io::Error::from_raw_os_error(28));
        }
        let written = self.file.write(&bytes[..bytes.len().min(self.room)])?;
        self.room -= written;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// The number of files that were created.
static MADE: Mutex<usize> = Mutex::new(0);

fn small(path: &Path, overwrite: bool) -> Result<(Output, Option<Disk>), Error> {
    let mut made = MADE.lock().unwrap();
    *made += 1;
    let file = writer::create(path, overwrite)?;
    let room = match *made {
        2 => 20_000,
        3 => 0,
        _ => usize::MAX,
    };
    Ok((Box::new(FailingDisk { file, room }), None))
}

/// Returns a sink for `drive.mcap` in a folder, which creates its files by `make`.
fn sink(folder: &Path, make: CreateFile, on_file: OnFile) -> TriggeredSink {
    let shared = Arc::new(Shared::new(sync_channel(1).0, true));
    let origin = Origin {
        application: "bench".to_owned(),
        seed: 0,
        started: SystemTime::UNIX_EPOCH,
        folder: None,
        file: None,
        hierarchy: None,
    };
    let plan = Plan {
        path: folder.join("drive.mcap"),
        overwrite: false,
        before: 10 * SECOND,
        after: 5 * SECOND,
        memory: 1 << 20,
    };
    let mut sink = TriggeredSink::new(&shared, origin, plan, on_file).unwrap();
    sink.create_file = make;
    sink
}

#[test]
fn a_file_that_cannot_be_opened_is_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let theirs = folder.path().join("drive-001.mcap");
    std::fs::write(&theirs, "precious").unwrap();
    let refused: CreateFile = |path, _| {
        Err(Error::Create {
            path: path.to_owned(),
            error: io::ErrorKind::PermissionDenied.into(),
        })
    };
    let mut sink = sink(folder.path(), refused, Box::new(|_, _| {}));
    let firing = Firing {
        time: 0,
        condition: 0,
        text: "now".to_owned(),
    };
    sink.fired(&firing, "operator");
    sink.finish();
    assert!(lock(&sink.shared.files)[0].error.is_some());
    assert_eq!(std::fs::read_to_string(theirs).unwrap(), "precious");
}

#[test]
fn a_full_disk_is_told_once_and_the_next_firing_tries_again() {
    let folder = tempfile::tempdir().unwrap();
    let told: Arc<Mutex<Vec<_>>> = Arc::default();
    let tell = Arc::clone(&told);
    let on_file: OnFile = Box::new(move |happened, written| {
        let name = written.path.file_name().unwrap().to_string_lossy().into_owned();
        tell.lock().unwrap().push((happened, name));
    });
    let mut sink = sink(folder.path(), small, on_file);
    let shared = Arc::clone(&sink.shared);
    let value_type = Arc::new(<[u64; 16]>::describe());
    let lane = TopicQueue::new(
        "/bench/noise".to_owned(),
        TopicContent::Values(value_type),
        BTreeMap::new(),
        None,
        true,
    );
    sink.open(SinkChannel::Topic(Arc::new(lane)));

    // Ten values a second for 200 s, and a firing every 40 s. The values do not compress, so they fill the
    // disk.
    let mut noise = 1_u64;
    for number in 0..2000 {
        let mut data = vec![0, 1, 0, 0];
        for _ in 0..16 {
            noise = noise.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            data.extend(noise.rotate_left(29).to_le_bytes());
        }
        let time = number * SECOND / 10;
        let times = Times {
            log: time,
            publish: time,
            sequence: number,
        };
        sink.write_message(0, times, &data, Effect::State(StateKey::Value));
        if number % 400 == 200 {
            let firing = Firing {
                time,
                condition: 0,
                text: format!("firing at {time}"),
            };
            sink.fired(&firing, "operator");
        }
        sink.poll(time);
    }
    sink.finish();

    let told = told.lock().unwrap();
    let told: Vec<_> = told
        .iter()
        .map(|(happened, name)| (*happened, name.as_str()))
        .collect();
    assert_eq!(
        told,
        [
            (FileEvent::Started, "drive-001.mcap"),
            (FileEvent::Ended, "drive-001.mcap"),
            (FileEvent::Started, "drive-002.mcap"),
            (FileEvent::Failed, "drive-002.mcap"),
            // The third file cannot even be started, which is not reported again. The fourth takes its name.
            (FileEvent::Started, "drive-003.mcap"),
            (FileEvent::Ended, "drive-003.mcap"),
            (FileEvent::Started, "drive-004.mcap"),
            (FileEvent::Ended, "drive-004.mcap"),
        ]
    );
    let files = lock(&shared.files).clone();
    // 10 s before, 5 s after, the firing, and the value in force at the beginning.
    let whole = 10 * 15 + 2;
    for (place, file) in files.iter().enumerate() {
        // A file that was never started does not count the value in force.
        let known = whole - u64::from(place == 2);
        assert_eq!(file.written + file.lost, known, "{file:?}");
        assert_eq!(file.error.is_some(), [1, 2].contains(&place), "{file:?}");
    }
    assert_eq!((files[2].written, files[3].written), (0, whole));
    let lost: u64 = files.iter().map(|file| file.lost).sum();
    assert_eq!(shared.dropped.load(Ordering::Relaxed), lost);
    assert_eq!(
        shared.written.load(Ordering::Relaxed),
        files.iter().map(|file| file.written).sum::<u64>()
    );
    let damaged = Recording::open(&files[1].path).unwrap();
    assert!(damaged.damage().unwrap().offset <= 20_000);
    assert_eq!(Recording::open(&files[3].path).unwrap().damage(), None);
}
