//! The writing thread. Every few milliseconds it processes everything that has arrived, in one round. It
//! continues to empty the queues whatever the disk does, so that no queue stays full for long. The sink
//! decides where messages are written.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::Receiver;
use std::thread;
use std::time::Duration;

use jde_board::{Nanos, Reader};
use jde_host::story::{Happening, Kind, Line, Story};
use jde_ros::cdr;

use crate::lane::{Holds, Lane, Shared, Slot, SlotForm, Told, lock};
use crate::ring::About;
use crate::sink::{Channel, Says, Sink};
use crate::tap::{News, Seen, retracted};
use crate::trigger::{Firing, Triggers};
use crate::turns;
use crate::writer::Times;

/// The longest time between two rounds. A publisher may wake the thread earlier.
const ROUND: Duration = Duration::from_millis(20);

/// Writes a recording.
pub(crate) struct Scribe {
    shared: Arc<Shared>,
    sink: Box<dyn Sink>,
    triggers: Option<Triggers>,
    story: Option<Story>,
    told: Receiver<(u64, Told)>,
    lanes: Vec<Open>,
    /// The number of the sink's channels so far.
    channels: usize,
    /// The first channel of the story. The channels of its kinds are consecutive.
    story_channel: Option<usize>,
    /// The application's time: that of the newest message, or that of its clock.
    now: Nanos,
    /// Items that have arrived and are not yet processed.
    round: Vec<(u64, Item)>,
    /// A buffer that is reused.
    message: Vec<u8>,
    fired: Vec<Firing>,
}

/// A topic with its channel.
struct Open {
    lane: Arc<Lane>,
    /// `None` if no file contains the topic.
    channel: Option<usize>,
    /// The subject of the topic's messages.
    about: About,
    fetch: Option<(Reader, Seen)>,
    /// The variable's name, if a condition names it.
    variable: Option<String>,
}

enum Item {
    /// A value of the topic with this number.
    Value(usize, Box<Slot>),
    Told(Box<Told>),
}

impl Scribe {
    pub(crate) fn new(
        shared: &Arc<Shared>,
        sink: Box<dyn Sink>,
        triggers: Option<Triggers>,
        story: Option<Story>,
        told: Receiver<(u64, Told)>,
    ) -> Self {
        Self {
            shared: Arc::clone(shared),
            sink,
            triggers,
            story,
            told,
            lanes: Vec::new(),
            channels: 0,
            story_channel: None,
            now: 0,
            round: Vec::new(),
            message: Vec::new(),
            fired: Vec::new(),
        }
    }

    pub(crate) fn run(mut self) {
        if self.story.is_some() {
            self.story_channel();
        }
        loop {
            // Read before the round: everything published before it was set is then part of that round.
            let closed = self.shared.closed.load(Ordering::Acquire);
            self.open_lanes();
            self.take(closed);
            for number in 0..self.lanes.len() {
                self.fetch(number);
            }
            self.pass();
            let more = self.sink.round(self.now);
            if closed {
                return self.finish();
            }
            if !more {
                thread::park_timeout(ROUND);
            }
        }
    }

    fn open(&mut self, channel: Channel) -> usize {
        self.sink.open(channel);
        self.channels += 1;
        self.channels - 1
    }

    /// Returns the first channel of the story. The first call creates the channels.
    fn story_channel(&mut self) -> usize {
        if let Some(channel) = self.story_channel {
            return channel;
        }
        let first = self.channels;
        for kind in Kind::ALL {
            self.open(Channel::Story(kind));
        }
        *self.story_channel.insert(first)
    }

    fn open_lanes(&mut self) {
        let new: Vec<_> = lock(&self.shared.lanes)
            .iter()
            .skip(self.lanes.len())
            .cloned()
            .collect();
        for lane in new {
            let channel = lane.kept.then(|| self.open(Channel::Lane(Arc::clone(&lane))));
            let fetch = lane
                .note
                .as_ref()
                .map(|note| (note.variable.reader("recording"), Seen::since(note.since)));
            let variable = lane.about.get("variable");
            let named = |variable: &&String| {
                let triggers = self.triggers.as_ref();
                triggers.is_some_and(|triggers| triggers.variables().contains(variable.as_str()))
            };
            self.lanes.push(Open {
                variable: variable.filter(named).cloned(),
                // A turn is an event: it leaves nothing in force.
                about: if lane.name == turns::TOPIC {
                    About::Nothing
                } else {
                    About::Value
                },
                lane,
                channel,
                fetch,
            });
        }
    }

    /// Processes everything that has arrived, in its order. If it comes from a single thread, as in virtual
    /// time, that order is always the same: an item that may have overtaken another is left for the next
    /// round.
    fn take(&mut self, closed: bool) {
        let given = if closed { u64::MAX } else { self.shared.given() };
        let mut round = std::mem::take(&mut self.round);
        for (number, open) in self.lanes.iter().enumerate() {
            // Only those that are there now: a busy publisher must not delay the other topics.
            let come = open.lane.full.len();
            let values = (0..come).map_while(|_| open.lane.full.pop());
            round.extend(values.map(|slot| (slot.order, Item::Value(number, slot))));
        }
        while let Ok((order, told)) = self.told.try_recv() {
            round.push((order, Item::Told(Box::new(told))));
        }
        round.sort_by_key(|(order, _)| *order);
        let here = round.partition_point(|(order, _)| *order < given);
        for (_, item) in round.drain(..here) {
            match item {
                Item::Value(number, slot) => {
                    self.slot(number, &slot);
                    self.lanes[number].lane.give_back(slot);
                }
                Item::Told(told) => self.tell(*told),
            }
        }
        self.round = round;
        self.shared.made_room();
    }

    fn slot(&mut self, number: usize, slot: &Slot) {
        let times = Times {
            log: slot.stamps.published,
            publish: slot.stamps.measured,
            sequence: slot.stamps.sequence,
        };
        match slot.form {
            SlotForm::Value => self.value(number, times, &slot.bytes),
            SlotForm::Message => {
                let open = &self.lanes[number];
                if let Some(channel) = open.channel {
                    let says = Says::State(open.about.clone());
                    self.sink.message(channel, times, &slot.bytes, says);
                }
                if open.variable.is_some()
                    && let Holds::Values(value_type) = &open.lane.holds
                    && let Ok(value) = cdr::decode(value_type, &slot.bytes)
                {
                    self.look(number, times.log, Some(&value));
                }
                self.at(times.log);
            }
        }
    }

    /// Takes the newest large value, if there is a new one, without copying it first.
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
                self.tell(told);
            }
        }
        reader.release();
        self.lanes[number].fetch = Some((reader, seen));
    }

    fn value(&mut self, number: usize, times: Times, bytes: &[u8]) {
        let open = &self.lanes[number];
        if let Some(channel) = open.channel
            && let Holds::Values(value_type) = &open.lane.holds
        {
            cdr::encode(value_type, bytes, &mut self.message);
            let says = Says::State(open.about.clone());
            self.sink.message(channel, times, &self.message, says);
        }
        self.look(number, times.log, Some(bytes));
        self.at(times.log);
    }

    fn tell(&mut self, told: Told) {
        match told {
            Told::Event(event) => {
                let lines = self.story.as_mut().map(|story| story.hear(&event));
                for line in lines.unwrap_or_default() {
                    self.line(&line, None);
                }
                if let Some(triggers) = &mut self.triggers {
                    triggers.event(&event, &mut self.fired);
                }
                self.fire();
            }
            Told::Earlier(line, beginning) => {
                self.line_at(&line, beginning, None);
                if let Some(triggers) = &mut self.triggers {
                    triggers.line(&line, &mut self.fired);
                }
                // Conditions do not fire by what occurred before the recording.
                self.fired.clear();
            }
            Told::Line(line) => {
                self.line(&line, None);
                if let Some(triggers) = &mut self.triggers {
                    triggers.line(&line, &mut self.fired);
                }
                self.fire();
            }
            Told::Retracted { time, variable } => {
                let of = |open: &Open| open.lane.about.get("variable") == Some(&variable);
                let number = self.lanes.iter().position(of);
                let channel = number.and_then(|number| self.lanes[number].channel);
                // Without events there is no story to record the retraction in. A variable that no file
                // contains needs no record of it.
                if (self.story.is_some() || self.story_channel.is_some()) && channel.is_some() {
                    self.line(&Line::retracted(time, &variable), channel);
                }
                if let Some(number) = number {
                    self.look(number, time, None);
                }
            }
        }
    }

    /// Writes a message of the story. `retracts` is the channel whose value the message retracts.
    fn line(&mut self, line: &Line, retracts: Option<usize>) {
        self.line_at(line, line.time(), retracts);
    }

    fn line_at(&mut self, line: &Line, log: Nanos, retracts: Option<usize>) {
        let channel = self.story_channel() + line.kind() as usize;
        let times = Times {
            log,
            publish: line.time(),
            sequence: 0,
        };
        let says = match (retracts, line) {
            (Some(of), _) => Says::Retracts(of),
            (None, Line::Decision(decision)) => Says::State(About::Named(decision.group.as_str().into())),
            (None, Line::Change(change)) => Says::State(About::Named(change.schema.as_str().into())),
            (None, Line::Happening(_)) => Says::State(About::Nothing),
        };
        self.sink.message(channel, times, &line.json(), says);
        self.at(log);
    }

    /// Passes a value, or its retraction, to the conditions that name it.
    fn look(&mut self, number: usize, time: Nanos, value: Option<&[u8]>) {
        let (Some(variable), Some(triggers)) = (&self.lanes[number].variable, &mut self.triggers) else {
            return;
        };
        match value {
            Some(bytes) => triggers.value(time, variable, bytes, &mut self.fired),
            None => triggers.retracted(time, variable, &mut self.fired),
        }
        self.fire();
    }

    /// Advances the application's time to at least `time`.
    fn at(&mut self, time: Nanos) {
        if time <= self.now {
            return;
        }
        self.now = time;
        if let Some(triggers) = &mut self.triggers {
            triggers.pass(time, &mut self.fired);
            self.fire();
        }
    }

    /// Advances the time while nothing arrives. In virtual time it does not advance then.
    fn pass(&mut self) {
        if let Some(clock) = self.shared.clock.get().filter(|_| !self.shared.lossless) {
            self.at(clock());
        }
    }

    /// Reports the conditions that became true, first in the story and then to the sink.
    fn fire(&mut self) {
        for firing in std::mem::take(&mut self.fired) {
            let text = firing.text.clone();
            let line = Line::Happening(Happening {
                time_s: firing.time as f64 / 1e9,
                kind: "trigger".to_owned(),
                text,
                ..Happening::default()
            });
            self.line(&line, None);
            let triggers = self.triggers.as_ref();
            let condition = triggers.and_then(|triggers| triggers.condition(firing.condition));
            self.sink.fired(&firing, condition.unwrap_or_default());
        }
    }

    fn finish(mut self) {
        let last = self.story.take().map(Story::finish);
        for line in last.unwrap_or_default() {
            self.line(&line, None);
        }
        self.sink.finish();
    }
}
