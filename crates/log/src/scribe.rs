//! The thread that writes: a round every few milliseconds over all that has come, and twice a second everything to the disk.
//! Whatever the disk does, it goes on emptying the queues, so that nobody who publishes ever meets a full one for long.

use std::fs::File;
use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, Builder, JoinHandle};
use std::time::{Duration, Instant};

use jde_board::Reader;
use jde_host::story::{Kind, Line, Story};
use jde_ros::cdr;

use crate::lane::{Lane, Shared, Slot, Told, lock};
use crate::recorder::OnTrouble;
use crate::tap::{News, Seen, retracted};
use crate::writer::{Times, Writer};

/// Time between two rounds if nobody asks for one earlier.
const ROUND: Duration = Duration::from_millis(20);
/// Time between two flushes: half of the second that may be lost.
const FLUSH: Duration = Duration::from_millis(500);

/// Writes a recording.
pub(crate) struct Scribe {
    shared: Arc<Shared>,
    /// None once the disk takes no more.
    writer: Option<Writer>,
    story: Option<Story>,
    story_channels: Vec<u16>,
    told: Receiver<Told>,
    lanes: Vec<Open>,
    syncer: Option<Syncer>,
    on_trouble: Option<OnTrouble>,
    flushed: Instant,
    /// Messages since then.
    unflushed: u64,
    /// Kept for its room.
    message: Vec<u8>,
    round: Vec<(usize, Box<Slot>)>,
}

/// A topic with its channel.
struct Open {
    lane: Arc<Lane>,
    channel: u16,
    fetch: Option<(Reader, Seen)>,
}

/// Asks the disk to have what the system was given. It may take its time, so it has a thread of its own.
pub(crate) struct Syncer {
    ask: Option<SyncSender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Scribe {
    pub(crate) fn new(
        shared: &Arc<Shared>,
        writer: Writer,
        story: Option<Story>,
        told: Receiver<Told>,
        syncer: Option<Syncer>,
        on_trouble: OnTrouble,
    ) -> Self {
        Self {
            shared: Arc::clone(shared),
            writer: Some(writer),
            story,
            story_channels: Vec::new(),
            told,
            lanes: Vec::new(),
            syncer,
            on_trouble: Some(on_trouble),
            flushed: Instant::now(),
            unflushed: 0,
            message: Vec::new(),
            round: Vec::new(),
        }
    }

    pub(crate) fn run(mut self) {
        self.open_story();
        loop {
            // Looked at before the round: what was put before it was set is in that round.
            let closed = self.shared.closed.load(Ordering::Acquire);
            self.open_lanes();
            self.values();
            self.events();
            if closed {
                return self.finish();
            }
            if self.flushed.elapsed() >= FLUSH {
                self.flush();
            }
            thread::park_timeout(ROUND);
        }
    }

    /// Does something with the file; the first thing that fails is the last that is tried.
    fn write<T>(&mut self, act: impl FnOnce(&mut Writer) -> io::Result<T>) -> Option<T> {
        let writer = self.writer.as_mut()?;
        match act(writer) {
            Ok(done) => Some(done),
            Err(error) => {
                // What is in no chunk yet goes nowhere, and neither does what the file can no longer tell of.
                self.writer = None;
                let lost = std::mem::take(&mut self.unflushed);
                self.shared.dropped.fetch_add(lost, Ordering::Relaxed);
                let words = error.to_string();
                *lock(&self.shared.trouble) = Some(words.clone());
                if let Some(tell) = self.on_trouble.take() {
                    tell(&words);
                }
                None
            }
        }
    }

    fn open_story(&mut self) {
        if self.story.is_none() {
            return;
        }
        for kind in Kind::ALL {
            let (name, schema) = kind.schema();
            if let Some(channel) = self.write(|writer| writer.json(kind.topic(), name, schema)) {
                self.story_channels.push(channel);
            }
        }
    }

    fn open_lanes(&mut self) {
        let new: Vec<_> = lock(&self.shared.lanes)
            .iter()
            .skip(self.lanes.len())
            .cloned()
            .collect();
        for lane in new {
            let channel = self.write(|writer| writer.variable(&lane.name, &lane.value_type, &lane.about));
            let fetch = lane
                .note
                .as_ref()
                .map(|note| (note.variable.reader("recording"), Seen::since(note.since)));
            self.lanes.push(Open {
                // Without a file no channel is used.
                channel: channel.unwrap_or_default(),
                lane,
                fetch,
            });
        }
    }

    /// Everything that was put since the last round, in the order of its times, and then what is to be fetched.
    fn values(&mut self) {
        let mut round = std::mem::take(&mut self.round);
        for (number, open) in self.lanes.iter().enumerate() {
            // No more than there were: a busy publisher must not keep the others waiting.
            let come = open.lane.full.len();
            round.extend((0..come).map_while(|_| Some((number, open.lane.full.pop()?))));
        }
        round.sort_by_key(|(_, slot)| slot.stamps.published);
        for (number, slot) in round.drain(..) {
            let times = Times {
                log: slot.stamps.published,
                publish: slot.stamps.measured,
                sequence: slot.stamps.sequence,
            };
            self.value(number, times, &slot.bytes);
            // It came from there.
            let _ = self.lanes[number].lane.free.push(slot);
        }
        self.round = round;
        self.shared.made_room();
        for number in 0..self.lanes.len() {
            self.fetch(number);
        }
    }

    /// Takes the newest of a large value, if there is a new one, without copying it.
    fn fetch(&mut self, number: usize) {
        let open = &mut self.lanes[number];
        let Some(note) = open
            .lane
            .note
            .as_ref()
            .filter(|note| note.new.swap(false, Ordering::AcqRel))
        else {
            return;
        };
        let log = note.published.load(Ordering::Relaxed);
        let Some((mut reader, mut seen)) = open.fetch.take() else {
            return;
        };
        let latched = reader.latch();
        match seen.news(latched.map(|latched| latched.stamp.sequence)) {
            News::None => {}
            News::Value(missed) => {
                open.lane.lost.fetch_add(missed, Ordering::Relaxed);
                if let Some(latched) = latched {
                    let times = Times {
                        log,
                        publish: latched.stamp.time,
                        sequence: latched.stamp.sequence,
                    };
                    self.value(number, times, latched.bytes);
                }
            }
            News::Retracted => {
                let told = retracted(log, &open.lane);
                self.tell(&told);
            }
        }
        reader.release();
        self.lanes[number].fetch = Some((reader, seen));
    }

    fn value(&mut self, number: usize, times: Times, bytes: &[u8]) {
        let open = &self.lanes[number];
        if self.writer.is_none() {
            open.lane.lost.fetch_add(1, Ordering::Relaxed);
            return;
        }
        let channel = open.channel;
        let mut message = std::mem::take(&mut self.message);
        cdr::encode(&open.lane.value_type, bytes, &mut message);
        self.message(channel, times, &message);
        self.message = message;
    }

    fn events(&mut self) {
        while let Ok(told) = self.told.try_recv() {
            self.tell(&told);
        }
    }

    fn tell(&mut self, told: &Told) {
        let lines = self.story.as_mut().map(|story| match told {
            Told::Event(event) => story.hear(event),
            Told::Retracted { time, variable } => vec![Line::retracted(*time, variable)],
        });
        self.lines(lines.unwrap_or_default());
    }

    fn lines(&mut self, lines: Vec<Line>) {
        for line in lines {
            let times = Times {
                log: line.time(),
                publish: line.time(),
                sequence: 0,
            };
            // Opened in the order of the kinds.
            match self.story_channels.get(line.kind() as usize).copied() {
                Some(channel) if self.writer.is_some() => self.message(channel, times, &line.json()),
                Some(_) | None => {
                    self.shared.lost_events.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
    }

    fn message(&mut self, channel: u16, times: Times, data: &[u8]) {
        // Counted before: if it fails, it is among those that are lost.
        self.unflushed += 1;
        self.write(|writer| writer.message(channel, times, data));
    }

    fn flush(&mut self) {
        self.flushed = Instant::now();
        if self.unflushed == 0 {
            return;
        }
        if self.write(Writer::flush).is_some() {
            self.flushed_all();
            if let Some(syncer) = &self.syncer {
                syncer.ask();
            }
        }
    }

    fn flushed_all(&mut self) {
        let bytes = self.writer.as_ref().map_or(0, Writer::bytes);
        self.shared.bytes.store(bytes, Ordering::Relaxed);
        let kept = std::mem::take(&mut self.unflushed);
        self.shared.kept.fetch_add(kept, Ordering::Release);
    }

    fn finish(mut self) {
        let last = self.story.take().map(Story::finish);
        self.lines(last.unwrap_or_default());
        let lost = self
            .lanes
            .iter()
            .map(|open| (&open.lane.name, open.lane.lost.load(Ordering::Relaxed)))
            .filter(|(_, lost)| *lost > 0)
            .map(|(name, lost)| (name.clone(), lost.to_string()))
            .collect();
        self.write(|writer| {
            writer.flush()?;
            writer.metadata("jde/lost", lost)?;
            writer.finish()
        });
        if self.writer.is_some() {
            self.flushed_all();
        }
        if let Some(syncer) = self.syncer.take() {
            syncer.ask();
        }
    }
}

impl Syncer {
    pub(crate) fn start(file: File) -> io::Result<Self> {
        let (ask, asked) = sync_channel(1);
        let thread = Builder::new().name("recording-sync".to_owned()).spawn(move || {
            while asked.recv().is_ok() {
                // What the disk cannot do the next write is told of.
                let _ = file.sync_data();
            }
        })?;
        Ok(Self {
            ask: Some(ask),
            thread: Some(thread),
        })
    }

    /// Asks for it, unless it has been asked for and not begun.
    fn ask(&self) {
        if let Some(ask) = &self.ask {
            let _ = ask.try_send(());
        }
    }
}

/// Waits until the disk has what it was asked to have.
impl Drop for Syncer {
    fn drop(&mut self) {
        drop(self.ask.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
