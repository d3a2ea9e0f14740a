//! Disks that are full before or while a file is written.

use std::collections::BTreeMap;
use std::sync::mpsc::sync_channel;
use std::time::SystemTime;

use jde_log::Recording;
use jde_types::Value;
use parking_lot::Mutex;

use super::*;
use crate::pre_trigger_buffer::StateKey;
use crate::recorder::tests::disks::LimitedFile;
use crate::topic::{TopicContent, TopicQueue};
use crate::writer;

const SECOND: Nanos = 1_000_000_000;

/// The number of files that were created.
static CREATED: Mutex<usize> = Mutex::new(0);

/// Creates a file that is limited if it is the second, and gets no byte if it is the third.
fn create_limited(path: &Path, overwrite: bool) -> Result<(Output, Option<Disk>), Error> {
    let mut created = CREATED.lock();
    *created += 1;
    let file = writer::create(path, overwrite)?;
    let space = match *created {
        2 => 20_000,
        3 => 0,
        _ => usize::MAX,
    };
    Ok((Box::new(LimitedFile { file, space }), None))
}

/// Returns a sink for `drive.mcap` in a folder, which creates its files with `create_file`.
fn sink(folder: &Path, create_file: CreateFile, on_file: OnFile) -> TriggeredSink {
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
    sink.create_file = create_file;
    sink
}

#[test]
fn a_file_that_cannot_be_opened_is_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let existing = folder.path().join("drive-001.mcap");
    std::fs::write(&existing, "precious").unwrap();
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
    assert!(sink.shared.files.lock()[0].error.is_some());
    assert_eq!(std::fs::read_to_string(existing).unwrap(), "precious");
}

#[test]
fn a_full_disk_is_reported_once_and_the_next_firing_starts_a_new_file() {
    let folder = tempfile::tempdir().unwrap();
    let file_events: Arc<Mutex<Vec<_>>> = Arc::default();
    let events = Arc::clone(&file_events);
    let on_file: OnFile = Box::new(move |event, file| {
        let name = file.path.file_name().unwrap().to_string_lossy().into_owned();
        events.lock().push((event, name));
    });
    let mut sink = sink(folder.path(), create_limited, on_file);
    let shared = Arc::clone(&sink.shared);
    let value_type = Arc::new(<[u64; 16]>::describe());
    let queue = TopicQueue::new(
        "/bench/noise".to_owned(),
        TopicContent::Values(value_type),
        BTreeMap::new(),
        None,
        true,
    );
    sink.open(SinkChannel::Topic(Arc::new(queue)));

    // Ten values a second for 200 s, and a firing every 40 s. The values are incompressible, to fill the
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

    let file_events = file_events.lock();
    let file_events: Vec<_> = file_events
        .iter()
        .map(|(event, name)| (*event, name.as_str()))
        .collect();
    assert_eq!(
        file_events,
        [
            (FileEvent::Started, "drive-001.mcap"),
            (FileEvent::Ended, "drive-001.mcap"),
            (FileEvent::Started, "drive-002.mcap"),
            (FileEvent::Failed, "drive-002.mcap"),
            // The third file cannot be started, which is not reported again. The fourth gets its name.
            (FileEvent::Started, "drive-003.mcap"),
            (FileEvent::Ended, "drive-003.mcap"),
            (FileEvent::Started, "drive-004.mcap"),
            (FileEvent::Ended, "drive-004.mcap"),
        ]
    );
    let files = shared.files.lock().clone();
    // 10 s before, 5 s after, the firing, and the value in force at the beginning.
    let complete = 10 * 15 + 2;
    for (index, file) in files.iter().enumerate() {
        // The file that could not be started does not count the value in force.
        let expected = complete - u64::from(index == 2);
        assert_eq!(file.written + file.lost, expected, "{file:?}");
        assert_eq!(file.error.is_some(), [1, 2].contains(&index), "{file:?}");
    }
    assert_eq!((files[2].written, files[3].written), (0, complete));
    let lost: u64 = files.iter().map(|file| file.lost).sum();
    assert_eq!(shared.dropped.load(Ordering::Relaxed), lost);
    assert_eq!(
        shared.written.load(Ordering::Relaxed),
        files.iter().map(|file| file.written).sum::<u64>()
    );
    let damaged = Recording::open(&files[1].path).unwrap();
    assert!(damaged.damage().unwrap().offset.unwrap() <= 20_000);
    assert_eq!(Recording::open(&files[3].path).unwrap().damage(), None);
}
