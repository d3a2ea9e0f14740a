//! A complete log, which is read once. Unreadable lines are counted and skipped, and the clock never goes back.

use core::time::Duration;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};

use flate2::bufread::MultiGzDecoder;
use jde_schema::types::Pose2D;

use crate::record::{self, Line, Scan};

/// Upper limit of a line, bytes; a longer one is split. A scan of 1088 ranges has a tenth of it.
const MAX_LINE: u64 = 256 << 10;
/// Most unreadable lines that are reported one by one.
const MAX_NOTES: usize = 3;

/// The records of a log, in order.
#[derive(Debug)]
pub(crate) struct LogFile {
    records: Vec<Record>,
    scans: usize,
    notes: Vec<String>,
}

/// A record of the log.
#[derive(Debug)]
pub(crate) struct Record {
    /// Time since the first record.
    pub(crate) time: Duration,
    pub(crate) pose: Pose2D,
    pub(crate) scan: Option<Scan>,
}

/// The reason why a file is not a usable log.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LogError {
    #[error("cannot read the log {path}: {error}")]
    Io { path: String, error: io::Error },
    #[error("{path} has no scan: not one of its {lines} lines is a FLASER line that can be read{}", first.as_ref().map(|first| format!("; {first}")).unwrap_or_default())]
    NoScan {
        path: String,
        lines: usize,
        first: Option<String>,
    },
}

impl LogFile {
    /// Reads a log, plain or gzip. If its clock does not advance, the scans are `interval` apart.
    pub(crate) fn read(path: &str, interval: Duration) -> Result<Self, LogError> {
        let io = |error| LogError::Io {
            path: path.to_owned(),
            error,
        };
        let mut file = BufReader::new(File::open(path).map_err(io)?);
        let is_gzip = file.fill_buf().map_err(io)?.starts_with(&[0x1f, 0x8b]);
        let mut log = if is_gzip {
            Reading::read(BufReader::new(MultiGzDecoder::new(file)))
        } else {
            Reading::read(file)
        };
        if log.lines.iter().all(|line| line.scan.is_none()) {
            // A read error explains the missing scans best.
            return match log.read_error.take() {
                Some(error) => Err(io(error)),
                None => Err(LogError::NoScan {
                    path: path.to_owned(),
                    lines: log.count,
                    first: log.notes.pop(),
                }),
            };
        }
        Ok(log.finish(interval))
    }

    pub(crate) fn records(&self) -> &[Record] {
        &self.records
    }

    pub(crate) fn scans(&self) -> usize {
        self.scans
    }

    pub(crate) fn duration(&self) -> Duration {
        self.records.last().map_or(Duration::ZERO, |record| record.time)
    }

    /// Warnings from reading it, for the operator.
    pub(crate) fn notes(&self) -> &[String] {
        &self.notes
    }
}

/// The lines read so far.
struct Reading {
    lines: Vec<Line>,
    count: usize,
    bad: usize,
    notes: Vec<String>,
    /// The error that ended the reading early.
    read_error: Option<io::Error>,
}

impl Reading {
    /// Reads to the end, or to the first unreadable byte: a log that is cut short is played up to there.
    fn read(mut file: impl BufRead) -> Self {
        let mut reading = Self {
            lines: Vec::new(),
            count: 0,
            bad: 0,
            notes: Vec::new(),
            read_error: None,
        };
        let mut bytes = Vec::new();
        loop {
            bytes.clear();
            match file.by_ref().take(MAX_LINE).read_until(b'\n', &mut bytes) {
                Ok(0) => return reading,
                Ok(_) => reading.line(&bytes),
                Err(error) => {
                    reading.read_error = Some(error);
                    return reading;
                }
            }
        }
    }

    fn line(&mut self, bytes: &[u8]) {
        self.count += 1;
        match record::parse(&String::from_utf8_lossy(bytes)) {
            None => {}
            Some(Ok(line)) => self.lines.push(line),
            Some(Err(error)) => {
                self.bad += 1;
                if self.notes.len() < MAX_NOTES {
                    self.notes
                        .push(format!("line {} is left out: {error}", self.count));
                }
            }
        }
    }

    fn finish(self, interval: Duration) -> LogFile {
        let mut notes = self.notes;
        if self.bad > notes.len() {
            notes.push(format!("{} lines in all are left out", self.bad));
        }
        if let Some(error) = self.read_error {
            notes.push(format!(
                "the file is cut short after line {}: {error}; only the part before is played",
                self.count
            ));
        }
        let clocks = self
            .lines
            .iter()
            .filter(|line| line.scan.is_some())
            .map(|line| line.clock);
        let (first, last) = clocks.fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), clock| {
            (first.min(clock), last.max(clock))
        });
        let scans = self.lines.iter().filter(|line| line.scan.is_some()).count();
        let is_stopped = last <= first && scans > 1;
        if is_stopped {
            let seconds = interval.as_secs_f64();
            notes.push(format!(
                "its clock stands still at {first} s; the scans are played {seconds} s apart"
            ));
        }
        let mut records = Vec::with_capacity(self.lines.len());
        let (mut start, mut now, mut played) = (None, Duration::ZERO, 0);
        for Line { pose, clock, scan } in self.lines {
            if is_stopped {
                now = interval * played;
            } else if clock > 0.0 {
                // A clock of 0 counts as missing, and one that goes back is ignored.
                let since = clock - *start.get_or_insert(clock);
                now = now.max(Duration::try_from_secs_f64(since).unwrap_or_default());
            }
            played += u32::from(scan.is_some());
            records.push(Record {
                time: now,
                pose,
                scan,
            });
        }
        LogFile {
            records,
            scans,
            notes,
        }
    }
}
