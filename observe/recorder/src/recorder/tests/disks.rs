//! Disks that are full or fail: what is kept, what is reported, and how a recording goes on.

use std::fs::File;
use std::io::{self, Write};
use std::sync::mpsc::channel;

use jde_log::Recording;
use jde_types::{LaserScan, Value};
use jde_watchdog::Watchdog;

use super::{Fixture, options};
use crate::Stamps;
use crate::recorder::*;
use crate::sink::{Disk, PartSequence};
use crate::writer::Output;

/// Far longer than any of these tests takes.
const WATCHDOG: std::time::Duration = std::time::Duration::from_secs(60);

/// About three chunks, in bytes.
const DISK_SPACE: usize = 3_500_000;

/// A disk with limited space.
pub(crate) struct LimitedFile {
    pub(crate) file: File,
    pub(crate) space: usize,
}

impl Write for LimitedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.space == 0 {
            return Err(io::Error::from_raw_os_error(28));
        }
        let written = self.file.write(&bytes[..bytes.len().min(self.space)])?;
        self.space -= written;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Returns options whose recorder sends what hinders it.
fn reporting(lossless: bool) -> (RecorderOptions<'static>, Receiver<Trouble>) {
    let (report, reported) = channel();
    let options = RecorderOptions {
        on_trouble: Box::new(move |trouble| report.send(trouble.clone()).unwrap()),
        ..options(lossless)
    };
    (options, reported)
}

/// Starts a recording into a pipe, whose disk may fail.
fn into_pipe(output: Output, disk: Option<Disk>, options: RecorderOptions<'_>) -> Recorder {
    let begin = |origin: Origin| Ok((None, OpenFile::new(output, disk, &origin, None).unwrap()));
    Recorder::create_continuous(options, begin).unwrap()
}

fn stamps(number: u64) -> Stamps {
    Stamps {
        published: number,
        measured: number,
        sequence: number,
    }
}

#[test]
fn a_recording_in_one_file_goes_on_in_another_when_the_disk_has_room_again() {
    let _watchdog = Watchdog::for_test();
    let fixture = Fixture::new();
    let (path, further) = (fixture.file(), fixture.folder.path().join("run-001.mcap"));
    let disk = LimitedFile {
        file: File::create(&path).unwrap(),
        space: 20_000,
    };
    let (options, reported) = reporting(true);
    let recorder = Recorder::create_continuous(options, |origin| {
        let (whole, file) = PartSequence::of_whole(&path, Box::new(disk), None, origin, true)?;
        Ok((Some(whole), file))
    })
    .unwrap();
    let topic = recorder.topic("/a/b", Arc::new(<[u64; 128]>::describe()), BTreeMap::new());
    let mut last = 0;
    let mut put = || {
        last += 1;
        let noise = (1..=128_u64).map(|place| (last * place).wrapping_mul(0x5851_f42d_4c95_7f2d));
        let bytes: Vec<u8> = noise
            .flat_map(|number| number.rotate_left(29).to_ne_bytes())
            .collect();
        assert!(topic.put(&bytes, stamps(last)));
        last
    };
    let interrupted = loop {
        put();
        if let Ok(trouble) = reported.try_recv() {
            break trouble;
        }
    };
    assert!(
        matches!(&interrupted, Trouble::Interrupted { reason, .. } if reason.contains("space")),
        "{interrupted:?}"
    );
    while recorder.status().parts.is_none_or(|parts| parts.count < 2) {
        std::thread::yield_now();
    }
    let last = put();
    let status = recorder.finish();
    let parts = status.parts.expect("two files");
    assert_eq!((&parts.first, &parts.last), (&path, &further));
    let gap = &parts.gaps[0];
    assert_eq!((status.error, status.lost), (None, gap.lost));
    assert_eq!(status.written + status.lost, last);
    for opened in [&path, &further] {
        let recording = Recording::open(opened).unwrap();
        assert_eq!(recording.files().collect::<Vec<_>>(), [&path, &further]);
        assert_eq!(recording.gaps(), parts.gaps);
        let reason = &recording.damage().expect("the first file is cut off").reason;
        assert!(reason.starts_with("run.mcap: "), "{reason}");
        let messages: Vec<_> = recording.messages().unwrap().map(Result::unwrap).collect();
        assert_eq!(messages.len() as u64, status.written);
        assert_eq!(
            messages.last().map(|message| u64::from(message.sequence)),
            Some(last)
        );
    }

    let overwrite = || RecorderOptions {
        overwrite: true,
        ..self::options(true)
    };
    let split = SplitOptions {
        part_size: PartSize::Bytes(1 << 20),
        max_total_bytes: Some(1),
    };
    Recorder::create_split(&path, overwrite(), split)
        .unwrap()
        .finish();
    assert!(path.exists() && further.exists(), "they are of another recording");
    let status = Recorder::create(&path, overwrite()).unwrap().finish();
    assert_eq!(status.parts, None);
    assert!(!further.exists(), "it belonged to the overwritten recording");
    assert_eq!(Recording::open(&path).unwrap().first_part(), None);
}

#[test]
fn a_full_pipe_is_reported_once_and_does_not_block_the_writer() {
    let fixture = Fixture::new();
    let laser = fixture.declare::<LaserScan>("laser");
    let disk = LimitedFile {
        file: File::create(fixture.file()).unwrap(),
        space: DISK_SPACE,
    };
    let (options, reported) = reporting(true);
    let recorder = into_pipe(Box::new(disk), None, options);
    recorder.watch(&laser, fixture.clock());
    let mut writer = laser.writer(1, "test").unwrap();
    // Incompressible numbers fill the disk.
    let mut noise = 1_u64;
    for number in 1..=1000_u64 {
        fixture.time.store(number, Ordering::Relaxed);
        let value = writer.loan();
        value.fill(0);
        // A length beyond the capacity counts as the capacity.
        value.chunks_exact_mut(8).for_each(|bytes| {
            noise = noise.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            bytes.copy_from_slice(&noise.rotate_left(29).to_ne_bytes());
        });
        writer.publish(number, number).unwrap();
    }
    let status = recorder.finish();
    assert_eq!(status.written + status.lost, 1000);
    assert!(status.error.unwrap().contains("space"));
    assert_eq!(reported.iter().count(), 1);
    let recording = Recording::open(&fixture.file()).unwrap();
    let damage = recording.damage().unwrap();
    assert!(damage.offset.unwrap() <= DISK_SPACE as u64, "{damage:?}");
    let read = recording.messages().unwrap().map(Result::unwrap).count() as u64;
    assert!(read > 0 && read >= status.written, "{read} of {}", status.written);
}

/// Returns a disk that fails once, after `good` requests, and a receiver of a message for each request.
fn failing(mut good: u64) -> (Disk, Receiver<()>) {
    let (request, requests) = channel();
    let disk = move || {
        let fails = good == 0;
        good = good.wrapping_sub(1);
        request.send(()).unwrap();
        if fails {
            return Err(io::Error::from_raw_os_error(5));
        }
        Ok(())
    };
    (Box::new(disk), requests)
}

/// Records `flushes` flushes of one message each on a disk that fails after `good` of them.
fn record_on_failing_disk(good: u64, flushes: u64) -> Status {
    let (options, reported) = reporting(false);
    let (disk, requests) = failing(good);
    let recorder = into_pipe(Box::new(io::sink()), Some(disk), options);
    let topic = recorder.topic("/a/b", Arc::new(u64::describe()), BTreeMap::new());
    for number in 1..=flushes {
        assert!(topic.put(&number.to_ne_bytes(), stamps(number)));
        if number < flushes {
            requests.recv_timeout(WATCHDOG).expect("the disk gets a request");
        }
    }
    let status = recorder.finish();
    assert_eq!(status.written + status.lost, flushes);
    assert_eq!(reported.iter().count(), 1, "the error is reported once");
    assert!(status.error.is_some());
    status
}

#[test]
fn a_disk_error_at_the_end_is_reported() {
    let status = record_on_failing_disk(0, 1);
    assert_eq!((status.written, status.lost), (0, 1));
}

#[test]
fn messages_before_a_disk_error_are_kept_and_the_rest_is_lost() {
    let status = record_on_failing_disk(2, 3);
    assert_eq!((status.written, status.lost), (2, 1));
}
