//! Writes all messages, from the beginning of the recording to its end or until the disk accepts no more, to
//! one file or to parts.

use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use jde_board::Nanos;

use super::file::{ClosedFile, OpenFile};
use super::{Effect, PartSequence, Sink, SinkChannel};
use crate::recorder::OnError;
use crate::topic::{Shared, lock};
use crate::writer::Times;
use jde_conditions::Firing;

/// The sink of a recording of everything, in one file or in parts.
pub(crate) struct ContinuousSink {
    shared: Arc<Shared>,
    /// `None` once the disk accepts no more.
    file: Option<OpenFile>,
    channels: Vec<SinkChannel>,
    on_error: OnError,
    split: Option<PartSequence>,
    /// Ended parts that the disk has not confirmed yet.
    ending: Vec<ClosedFile>,
    /// The numbers of messages and bytes of the parts that the disk has confirmed.
    confirmed: (u64, u64),
    is_error_reported: bool,
}

impl ContinuousSink {
    pub(crate) fn new(
        shared: &Arc<Shared>,
        file: OpenFile,
        split: Option<PartSequence>,
        on_error: OnError,
    ) -> Self {
        let sink = Self {
            shared: Arc::clone(shared),
            file: Some(file),
            channels: Vec::new(),
            on_error,
            split,
            ending: Vec::new(),
            confirmed: (0, 0),
            is_error_reported: false,
        };
        sink.update_status();
        sink
    }

    /// Performs an operation on the file. After the first error there are no further operations.
    fn write(&mut self, operation: impl FnOnce(&mut OpenFile) -> io::Result<()>) {
        let Some(file) = &mut self.file else {
            return;
        };
        let result = operation(file);
        self.update_status();
        self.handle_result(result);
    }

    /// Ends the recording if the operation failed.
    fn handle_result(&mut self, result: io::Result<()>) {
        let Err(error) = result else {
            return;
        };
        // Messages that are in no chunk, or that the disk has not stored, are lost.
        self.ending.extend(self.file.take().map(OpenFile::into_closed));
        let mut lost = 0;
        for mut ended in self.ending.drain(..) {
            let _ = ended.wait();
            lost += ended.unwritten();
            self.confirmed.0 += ended.written();
            self.confirmed.1 += ended.bytes();
        }
        self.shared.dropped.fetch_add(lost, Ordering::Relaxed);
        self.update_status();
        if !std::mem::replace(&mut self.is_error_reported, true) {
            let message = error.to_string();
            *lock(&self.shared.error) = Some(message.clone());
            (self.on_error)(&message);
        }
    }

    /// Starts the next part at this time.
    fn part(&mut self, time: Nanos) {
        let (Some(split), Some(mut file)) = (&mut self.split, self.file.take()) else {
            return;
        };
        let closed = file.close(&split.take_lost(self.shared.lost_by_topic()));
        let ended = file.into_closed();
        let next = closed.and_then(|()| split.next(&ended, &self.channels, time));
        self.ending.push(ended);
        let result = next.map(|next| self.file = Some(next));
        self.update_status();
        self.handle_result(result);
    }

    /// Collects the results of the disk for ended parts, and deletes parts beyond the limit.
    fn poll_parts(&mut self) -> io::Result<()> {
        let mut result = Ok(());
        for mut ended in std::mem::take(&mut self.ending) {
            match ended.poll() {
                Some(Ok(())) => {
                    self.confirmed.0 += ended.written();
                    self.confirmed.1 += ended.bytes();
                }
                None => self.ending.push(ended),
                Some(Err(error)) => {
                    result = Err(error);
                    self.ending.push(ended);
                }
            }
        }
        let current_bytes = self.file.as_ref().map_or(0, OpenFile::bytes);
        result.and_then(|()| {
            self.split
                .as_mut()
                .map_or(Ok(()), |split| split.prune(current_bytes))
        })
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

    fn update_parts(&self) {
        if let Some(split) = &self.split {
            lock(&self.shared.parts).clone_from(split.parts());
        }
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
        if self.file.is_none() {
            return self.channels[channel].add_lost(1, &self.shared);
        }
        if let Some(split) = &mut self.split {
            split.update_in_force(channel, times, data, effect);
        }
        self.write(|file| file.write_message(channel, times, data));
    }

    fn fired(&mut self, _: &Firing, _: &str) {}

    fn poll(&mut self, _: Nanos) -> bool {
        self.write(OpenFile::flush_if_due);
        if self.split.is_some() && self.file.is_some() {
            let result = self.poll_parts();
            self.handle_result(result);
            self.update_parts();
        }
        false
    }

    fn finish(&mut self) {
        let mut lost = self.shared.lost_by_topic();
        if let Some(split) = &mut self.split {
            lost = split.take_lost(lost);
        }
        // This waits until the disk has stored the file.
        self.write(|file| file.finish(&lost));
        let ended: Vec<_> = self.ending.iter_mut().map(ClosedFile::wait).collect();
        self.handle_result(ended.into_iter().collect());
        if self.file.is_some() {
            let result = self.poll_parts();
            self.handle_result(result);
        }
        self.update_parts();
        self.file = None;
    }
}
