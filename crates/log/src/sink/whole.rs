//! One file, from the beginning of the recording to its end, or to where the disk takes no more.

use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use jde_board::Nanos;

use super::{Begun, Channel, Says, Sink};
use crate::lane::{Shared, lock};
use crate::recorder::OnTrouble;
use crate::trigger::Firing;
use crate::writer::Times;

/// Everything goes to one file.
pub(crate) struct Whole {
    shared: Arc<Shared>,
    /// None once the disk takes no more.
    file: Option<Begun>,
    channels: Vec<Channel>,
    on_trouble: OnTrouble,
}

impl Whole {
    pub(crate) fn new(shared: &Arc<Shared>, file: Begun, on_trouble: OnTrouble) -> Self {
        Self {
            shared: Arc::clone(shared),
            file: Some(file),
            channels: Vec::new(),
            on_trouble,
        }
    }

    /// Does something with the file; the first thing that fails is the last that is tried.
    fn write(&mut self, act: impl FnOnce(&mut Begun) -> io::Result<()>) {
        let Some(file) = &mut self.file else {
            return;
        };
        let done = act(file);
        let (kept, unflushed, bytes) = (file.kept(), file.unflushed(), file.bytes());
        self.shared.bytes.store(bytes, Ordering::Relaxed);
        self.shared.kept.store(kept, Ordering::Release);
        if let Err(error) = done {
            // What is in no chunk yet goes nowhere.
            self.file = None;
            self.shared.dropped.fetch_add(unflushed, Ordering::Relaxed);
            let words = error.to_string();
            *lock(&self.shared.trouble) = Some(words.clone());
            (self.on_trouble)(&words);
        }
    }
}

impl Sink for Whole {
    fn open(&mut self, channel: Channel) {
        self.write(|file| file.open(&channel));
        self.channels.push(channel);
    }

    fn message(&mut self, channel: usize, times: Times, data: &[u8], _: Says) {
        if self.file.is_none() {
            self.channels[channel].lose(1, &self.shared);
        }
        self.write(|file| file.message(channel, times, data));
    }

    fn fired(&mut self, _: &Firing, _: &str) {}

    fn round(&mut self, _: Nanos) -> bool {
        self.write(Begun::flush_in_time);
        false
    }

    fn finish(&mut self) {
        let lost = self.shared.lost_of();
        self.write(|file| file.finish(&lost));
        // Waits until the disk has it.
        self.file = None;
    }
}
