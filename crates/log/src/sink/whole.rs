//! Writes all messages, from the beginning of the recording to its end or until the disk accepts no more, to
//! one file or to parts.

use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use jde_board::Nanos;

use super::file::{Begun, Ended};
use super::{Channel, Says, Sink, Split};
use crate::lane::{Shared, lock};
use crate::recorder::OnTrouble;
use crate::trigger::Firing;
use crate::writer::Times;

/// The sink of a recording of everything, in one file or in parts.
pub(crate) struct Whole {
    shared: Arc<Shared>,
    /// `None` once the disk accepts no more.
    file: Option<Begun>,
    channels: Vec<Channel>,
    on_trouble: OnTrouble,
    split: Option<Split>,
    /// Ended parts that the disk has not confirmed yet.
    ending: Vec<Ended>,
    /// The numbers of messages and bytes of the parts that the disk has confirmed.
    done: (u64, u64),
    told: bool,
}

impl Whole {
    pub(crate) fn new(
        shared: &Arc<Shared>,
        file: Begun,
        split: Option<Split>,
        on_trouble: OnTrouble,
    ) -> Self {
        let whole = Self {
            shared: Arc::clone(shared),
            file: Some(file),
            channels: Vec::new(),
            on_trouble,
            split,
            ending: Vec::new(),
            done: (0, 0),
            told: false,
        };
        whole.note();
        whole
    }

    /// Performs an operation on the file. After the first error there are no further operations.
    fn write(&mut self, act: impl FnOnce(&mut Begun) -> io::Result<()>) {
        let Some(file) = &mut self.file else {
            return;
        };
        let done = act(file);
        self.note();
        self.go_on(done);
    }

    /// Ends the recording if the operation failed.
    fn go_on(&mut self, done: io::Result<()>) {
        let Err(error) = done else {
            return;
        };
        // What is in no chunk yet is lost, and so is what the disk had not stored when it failed.
        self.ending.extend(self.file.take().map(Begun::ended));
        let mut lost = 0;
        for mut ended in self.ending.drain(..) {
            let _ = ended.wait();
            lost += ended.unkept();
            self.done.0 += ended.kept();
            self.done.1 += ended.bytes();
        }
        self.shared.dropped.fetch_add(lost, Ordering::Relaxed);
        self.note();
        if !std::mem::replace(&mut self.told, true) {
            let words = error.to_string();
            *lock(&self.shared.trouble) = Some(words.clone());
            (self.on_trouble)(&words);
        }
    }

    /// Starts the next part at this time.
    fn part(&mut self, time: Nanos) {
        let (Some(split), Some(mut file)) = (&mut self.split, self.file.take()) else {
            return;
        };
        let closed = file.close(&split.lost(self.shared.lost_of()));
        let ended = file.ended();
        let next = closed.and_then(|()| split.next(&ended, &self.channels, time));
        self.ending.push(ended);
        let done = next.map(|next| self.file = Some(next));
        self.note();
        self.go_on(done);
    }

    /// Collects the results of the disk for ended parts, and deletes parts beyond the limit.
    fn tend(&mut self) -> io::Result<()> {
        let mut said = Ok(());
        for mut ended in std::mem::take(&mut self.ending) {
            match ended.poll() {
                Some(Ok(())) => {
                    self.done.0 += ended.kept();
                    self.done.1 += ended.bytes();
                }
                None => self.ending.push(ended),
                Some(Err(error)) => {
                    said = Err(error);
                    self.ending.push(ended);
                }
            }
        }
        let under_way = self.file.as_ref().map_or(0, Begun::bytes);
        said.and_then(|()| self.split.as_mut().map_or(Ok(()), |split| split.prune(under_way)))
    }

    /// Updates the status.
    fn note(&self) {
        let (mut kept, mut bytes) = self.done;
        for ended in &self.ending {
            kept += ended.kept();
            bytes += ended.bytes();
        }
        if let Some(file) = &self.file {
            kept += file.kept();
            bytes += file.bytes();
        }
        self.shared.bytes.store(bytes, Ordering::Relaxed);
        self.shared.kept.store(kept, Ordering::Release);
    }

    fn note_parts(&self) {
        if let Some(split) = &self.split {
            lock(&self.shared.parts).clone_from(split.parts());
        }
    }
}

impl Sink for Whole {
    fn open(&mut self, channel: Channel) {
        self.write(|file| file.open(&channel));
        self.channels.push(channel);
    }

    fn message(&mut self, channel: usize, times: Times, data: &[u8], says: Says) {
        if let (Some(split), Some(file)) = (&mut self.split, &self.file)
            && split.is_over(times.log, file.bytes())
        {
            self.part(times.log);
        }
        if self.file.is_none() {
            return self.channels[channel].lose(1, &self.shared);
        }
        if let Some(split) = &mut self.split {
            split.take(channel, times, data, says);
        }
        self.write(|file| file.message(channel, times, data));
    }

    fn fired(&mut self, _: &Firing, _: &str) {}

    fn round(&mut self, _: Nanos) -> bool {
        self.write(Begun::flush_in_time);
        if self.split.is_some() && self.file.is_some() {
            let tended = self.tend();
            self.go_on(tended);
            self.note_parts();
        }
        false
    }

    fn finish(&mut self) {
        let mut lost = self.shared.lost_of();
        if let Some(split) = &mut self.split {
            lost = split.lost(lost);
        }
        // This waits until the disk has stored the file.
        self.write(|file| file.finish(&lost));
        let ended: Vec<_> = self.ending.iter_mut().map(Ended::wait).collect();
        self.go_on(ended.into_iter().collect());
        if self.file.is_some() {
            let tended = self.tend();
            self.go_on(tended);
        }
        self.note_parts();
        self.file = None;
    }
}
