//! Writes all messages, from the beginning of the recording to its end, to one file or to parts. When the disk accepts no
//! more, a new part is tried until the disk accepts it, which states the gap. A recording into a pipe or a device ends.

use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use jde_board::Nanos;
use jde_conditions::Firing;
use jde_log::part::Gap;

use super::file::{ClosedFile, OpenFile};
use super::{Effect, PartSequence, Sink, SinkChannel};
use crate::recorder::{OnTrouble, Trouble};
use crate::topic::Shared;
use crate::writer::Times;

/// The time until a new part is tried for the first time. It doubles with each try.
const FIRST_WAIT: Duration = Duration::from_millis(100);
/// The longest time between two tries.
const MAX_WAIT: Duration = Duration::from_secs(8);
/// The time after a report of a gap during which further gaps are only counted.
const GAP_REPORT_PAUSE: Duration = Duration::from_secs(60);

/// The sink of a recording of everything.
pub(crate) struct ContinuousSink {
    shared: Arc<Shared>,
    /// `None` while the disk accepts no more.
    file: Option<OpenFile>,
    gap: Option<OpenGap>,
    channels: Vec<SinkChannel>,
    on_trouble: OnTrouble,
    /// `None` of a pipe or a device.
    split: Option<PartSequence>,
    /// Ended parts that the disk has not confirmed yet.
    ending: Vec<ClosedFile>,
    /// The numbers of messages and bytes of the parts that the disk has confirmed.
    confirmed: (u64, u64),
    /// Until then, gaps are only counted.
    quiet_until: Option<Instant>,
    /// The gaps that were only counted since.
    unreported: u64,
    is_undeleted_reported: bool,
}

/// A gap that lasts, or after which the disk has not accepted a message yet.
struct OpenGap {
    /// Its end is that at which the present part began.
    gap: Gap,
    next_try: Instant,
    wait: Duration,
    is_reported: bool,
}

impl ContinuousSink {
    pub(crate) fn new(
        shared: &Arc<Shared>,
        file: OpenFile,
        split: Option<PartSequence>,
        on_trouble: OnTrouble,
    ) -> Self {
        let sink = Self {
            shared: Arc::clone(shared),
            file: Some(file),
            gap: None,
            channels: Vec::new(),
            on_trouble,
            split,
            ending: Vec::new(),
            confirmed: (0, 0),
            quiet_until: None,
            unreported: 0,
            is_undeleted_reported: false,
        };
        sink.update_status();
        sink
    }

    /// Performs an operation on the file, if there is one.
    fn write(&mut self, operation: impl FnOnce(&mut OpenFile) -> io::Result<()>) {
        let Some(file) = &mut self.file else {
            return;
        };
        let result = operation(file);
        let has_messages = file.written() > 0;
        match result {
            Err(error) => self.interrupt(&error),
            Ok(()) if has_messages => self.end_gap(),
            Ok(()) => {}
        }
        self.update_status();
    }

    /// Ends the present file after an error of the disk. Messages that are in no chunk, or that the disk has not stored, are
    /// lost.
    fn interrupt(&mut self, error: &io::Error) {
        let Some(file) = self.file.take() else {
            return;
        };
        let mut ended = file.into_closed();
        // The error is known already. This determines how much of the file the disk has stored.
        let _ = ended.wait();
        self.collect(&ended, Ok(()));
        if let (Some(open), Some(split)) = (&mut self.gap, &mut self.split) {
            // The part has nothing but its beginning.
            split.discard_part();
            open.gap.lost += ended.unwritten();
            return open.postpone();
        }
        if let Some(split) = &mut self.split {
            split.end_part(ended.bytes());
        }
        let from = ended.missing().map(|(from, _)| from);
        let from = from.or_else(|| self.split.as_ref()?.began()).unwrap_or(0);
        self.begin_gap(from, ended.unwritten(), error);
    }

    fn begin_gap(&mut self, from: Nanos, lost: u64, error: &io::Error) {
        let reason = error.to_string();
        if self.split.is_none() {
            return self.end(reason);
        }
        let is_reported = self.may_report();
        if is_reported {
            (self.on_trouble)(&Trouble::Interrupted {
                reason: reason.clone(),
                unreported: std::mem::take(&mut self.unreported),
            });
        }
        self.gap = Some(OpenGap {
            gap: Gap {
                from,
                until: None,
                lost,
                reason,
                damaged: false,
            },
            next_try: Instant::now() + FIRST_WAIT,
            wait: FIRST_WAIT,
            is_reported,
        });
    }

    /// Ends the gap: the disk has accepted messages again, or the recording ends.
    fn end_gap(&mut self) {
        let (Some(open), Some(split)) = (self.gap.take(), &mut self.split) else {
            return;
        };
        split.add_gap(open.gap.clone());
        if open.is_reported && open.gap.until.is_some() {
            (self.on_trouble)(&Trouble::Resumed(open.gap));
        }
    }

    /// Ends the recording too early.
    fn end(&mut self, reason: String) {
        *self.shared.error.lock() = Some(reason.clone());
        (self.on_trouble)(&Trouble::Ended { reason });
    }

    /// Ends the present part, and starts the next one at this time.
    fn part(&mut self, time: Nanos) {
        let (Some(split), Some(mut file)) = (&mut self.split, self.file.take()) else {
            return;
        };
        let lost = self.shared.lost_by_topic();
        if let Err(error) = file.close(&split.lost_since_last_part(&lost)) {
            self.file = Some(file);
            self.interrupt(&error);
            return self.update_status();
        }
        split.report_lost(lost);
        let ended = file.into_closed();
        split.end_part(ended.bytes());
        self.ending.push(ended);
        self.start_part(time);
    }

    /// Starts the next part at this time, after a gap if there is one.
    fn start_part(&mut self, time: Nanos) {
        let Some(split) = &mut self.split else {
            return;
        };
        if let Some(open) = &mut self.gap {
            open.gap.until = Some(time);
        }
        match split.next(&self.channels, time, self.gap.as_ref().map(|open| &open.gap)) {
            Ok(file) => self.file = Some(file),
            Err(error) if split.is_exhausted() => {
                if let Some(open) = &mut self.gap {
                    open.gap.until = None;
                }
                self.end_gap();
                self.end(error.to_string());
            }
            Err(error) => match &mut self.gap {
                Some(open) => open.postpone(),
                None => self.begin_gap(time, 0, &error),
            },
        }
        self.update_status();
    }

    /// Collects the results of the disk for ended parts, and deletes parts beyond the limit.
    fn poll_parts(&mut self) {
        for mut ended in std::mem::take(&mut self.ending) {
            match ended.poll() {
                Some(result) => self.collect(&ended, result),
                None => self.ending.push(ended),
            }
        }
        let Some(split) = &mut self.split else {
            return;
        };
        let current_bytes = self.file.as_ref().map_or(0, OpenFile::bytes);
        if let Some((path, reason)) = split.prune(current_bytes)
            && !std::mem::replace(&mut self.is_undeleted_reported, true)
        {
            (self.on_trouble)(&Trouble::Undeleted { path, reason });
        }
        if let Some(parts) = split.parts() {
            self.shared.parts.lock().clone_from(parts);
        }
    }

    /// Adds what the disk has of a file that has ended, and counts the rest as lost.
    fn collect(&mut self, ended: &ClosedFile, result: io::Result<()>) {
        let lost = ended.unwritten();
        self.confirmed.0 += ended.written();
        self.confirmed.1 += ended.bytes();
        self.shared.dropped.fetch_add(lost, Ordering::Relaxed);
        if let (Err(error), Some((from, until)), Some(split)) = (result, ended.missing(), &mut self.split) {
            let gap = Gap {
                from,
                until: Some(until),
                lost,
                reason: error.to_string(),
                damaged: false,
            };
            split.add_gap(gap.clone());
            if self.may_report() {
                (self.on_trouble)(&Trouble::Resumed(gap));
            }
        }
    }

    /// Returns whether a gap is to be reported; otherwise it is counted.
    fn may_report(&mut self) -> bool {
        let now = Instant::now();
        let may = self.quiet_until.is_none_or(|until| until < now);
        if may {
            self.quiet_until = Some(now + GAP_REPORT_PAUSE);
        } else {
            self.unreported += 1;
        }
        may
    }

    /// Updates the status.
    fn update_status(&self) {
        let (mut kept, mut bytes) = self.confirmed;
        for ended in &self.ending {
            kept += ended.written();
            bytes += ended.bytes();
        }
        if let Some(file) = &self.file {
            kept += file.written();
            bytes += file.bytes();
        }
        self.shared.bytes.store(bytes, Ordering::Relaxed);
        self.shared.written.store(kept, Ordering::Release);
    }
}

impl OpenGap {
    /// Puts off the next try, after one that has failed.
    fn postpone(&mut self) {
        self.gap.until = None;
        self.wait = (self.wait * 2).min(MAX_WAIT);
        self.next_try = Instant::now() + self.wait;
    }
}

impl Sink for ContinuousSink {
    fn open(&mut self, channel: SinkChannel) {
        self.write(|file| file.open(&channel));
        self.channels.push(channel);
    }

    fn write_message(&mut self, channel: usize, times: Times, data: &[u8], effect: Effect) {
        if let (Some(split), Some(file)) = (&mut self.split, &self.file)
            && split.is_over(times.log, file.bytes())
        {
            self.part(times.log);
        }
        if let Some(split) = &mut self.split {
            split.update_in_force(channel, times, data, effect);
        }
        if self.file.is_none() {
            if let Some(open) = &mut self.gap {
                open.gap.lost += 1;
            }
            return self.channels[channel].add_lost(1, &self.shared);
        }
        self.write(|file| file.write_message(channel, times, data));
    }

    fn fired(&mut self, _: &Firing, _: &str) {}

    fn poll(&mut self, now: Nanos) -> bool {
        self.write(OpenFile::flush_if_due);
        // Old parts are deleted first: that may make the room.
        self.poll_parts();
        if let Some(open) = &self.gap
            && self.file.is_none()
            && open.next_try <= Instant::now()
        {
            self.start_part(now);
        }
        false
    }

    fn finish(&mut self) {
        let lost = self.shared.lost_by_topic();
        let lost = match &self.split {
            Some(split) => split.lost_since_last_part(&lost),
            None => lost,
        };
        // This waits until the disk has stored the file.
        self.write(|file| file.finish(&lost));
        for mut ended in std::mem::take(&mut self.ending) {
            let result = ended.wait();
            self.collect(&ended, result);
        }
        if self.file.is_none()
            && let Some(open) = &self.gap
        {
            *self.shared.error.lock() = Some(open.gap.reason.clone());
        }
        self.end_gap();
        self.poll_parts();
        self.update_status();
        self.file = None;
    }
}
