//! The writing thread. Every few milliseconds it processes everything that has arrived, in one round. It
//! continues to empty the queues whatever the disk does, so that no queue stays full for long. The sink
//! decides where messages are written.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::Receiver;
use std::thread;
use std::time::Duration;

use jde_board::{Nanos, Reader};
use jde_conditions::{Firing, Triggers};
use jde_log::{TURNS_TOPIC, log_line, record};
use jde_records::event::What;
use jde_records::{RecordBuilder, RecordKind, RunRecord};
use jde_ros::cdr;

use crate::pre_trigger_buffer::StateKey;
use crate::sink::{Effect, Sink, SinkChannel};
use crate::subscriber::{SequenceTracker, ValueChange, retraction_notice};
use crate::topic::{Notice, Shared, Slot, SlotForm, TopicContent, TopicQueue};
use crate::writer::Times;

/// The longest time between two rounds. A publisher may wake the thread earlier.
const ROUND_INTERVAL: Duration = Duration::from_millis(20);

/// Writes a recording.
pub(crate) struct WriterThread {
    shared: Arc<Shared>,
    sink: Box<dyn Sink>,
    triggers: Option<Triggers>,
    records: Option<RecordBuilder>,
    notices: Receiver<(u64, Notice)>,
    topics: Vec<OpenTopic>,
    /// The number of the sink's channels so far.
    channels: usize,
    /// The first channel of records. The channels of all kinds are consecutive.
    record_channel: Option<usize>,
    /// The application's time: that of the newest message, or that of its clock.
    now: Nanos,
    /// Items that have arrived and are not yet processed.
    pending: Vec<(u64, PendingItem)>,
    /// A buffer that is reused.
    message: Vec<u8>,
    fired: Vec<Firing>,
}

/// A topic with its channel.
struct OpenTopic {
    queue: Arc<TopicQueue>,
    /// `None` if no file contains the topic.
    channel: Option<usize>,
    /// The subject of the topic's messages.
    state_key: StateKey,
    fetch: Option<(Reader, SequenceTracker)>,
    /// The variable's name, if a condition names it.
    variable: Option<String>,
}

enum PendingItem {
    /// A value of the topic with this number.
    Value(usize, Box<Slot>),
    Notice(Box<Notice>),
}

impl WriterThread {
    pub(crate) fn new(
        shared: &Arc<Shared>,
        sink: Box<dyn Sink>,
        triggers: Option<Triggers>,
        records: Option<RecordBuilder>,
        notices: Receiver<(u64, Notice)>,
    ) -> Self {
        Self {
            shared: Arc::clone(shared),
            sink,
            triggers,
            records,
            notices,
            topics: Vec::new(),
            channels: 0,
            record_channel: None,
            now: 0,
            pending: Vec::new(),
            message: Vec::new(),
            fired: Vec::new(),
        }
    }

    pub(crate) fn run(mut self) {
        if self.records.is_some() {
            self.open_record_channels();
        }
        loop {
            // Read before the round: everything published before it was set is then part of that round.
            let closed = self.shared.closed.load(Ordering::Acquire);
            self.open_topics();
            self.process(closed);
            for number in 0..self.topics.len() {
                self.fetch(number);
            }
            self.advance_clock();
            let more = self.sink.poll(self.now);
            if closed {
                return self.finish();
            }
            if !more {
                thread::park_timeout(ROUND_INTERVAL);
            }
        }
    }

    fn open(&mut self, channel: SinkChannel) -> usize {
        self.sink.open(channel);
        self.channels += 1;
        self.channels - 1
    }

    /// Returns the first channel of records. The first call creates the channels.
    fn open_record_channels(&mut self) -> usize {
        if let Some(channel) = self.record_channel {
            return channel;
        }
        let first = self.channels;
        for kind in RecordKind::ALL {
            self.open(SinkChannel::Records(kind));
        }
        *self.record_channel.insert(first)
    }

    fn open_topics(&mut self) {
        let new: Vec<_> = self
            .shared
            .topics
            .lock()
            .iter()
            .skip(self.topics.len())
            .cloned()
            .collect();
        for queue in new {
            let channel = queue
                .is_recorded
                .then(|| self.open(SinkChannel::Topic(Arc::clone(&queue))));
            let fetch = queue.fetch_flag.as_ref().map(|flag| {
                (
                    flag.variable.reader("recording"),
                    SequenceTracker::starting_at(flag.first),
                )
            });
            let variable = queue.metadata.get("variable");
            let named = |variable: &&String| {
                let triggers = self.triggers.as_ref();
                triggers.is_some_and(|triggers| triggers.variables().contains(variable.as_str()))
            };
            self.topics.push(OpenTopic {
                variable: variable.filter(named).cloned(),
                // A turn and a line of the log are events: they leave nothing in force.
                state_key: if [TURNS_TOPIC, log_line::TOPIC].contains(&queue.name.as_str()) {
                    StateKey::Stateless
                } else {
                    StateKey::Value
                },
                queue,
                channel,
                fetch,
            });
        }
    }

    /// Processes everything that has arrived, in its order. If it comes from a single thread, as in virtual
    /// time, that order is always the same: an item that may have overtaken another waits for the next
    /// round.
    fn process(&mut self, closed: bool) {
        let limit = if closed {
            u64::MAX
        } else {
            self.shared.next_order()
        };
        let mut round = std::mem::take(&mut self.pending);
        for (number, open) in self.topics.iter().enumerate() {
            // A busy publisher must not delay the other topics: later values wait for the next round.
            let count = open.queue.full.len();
            let values = (0..count).map_while(|_| open.queue.full.pop());
            round.extend(values.map(|slot| (slot.order, PendingItem::Value(number, slot))));
        }
        while let Ok((order, notice)) = self.notices.try_recv() {
            round.push((order, PendingItem::Notice(Box::new(notice))));
        }
        round.sort_by_key(|(order, _)| *order);
        let complete = round.partition_point(|(order, _)| *order < limit);
        for (_, item) in round.drain(..complete) {
            match item {
                PendingItem::Value(number, slot) => {
                    self.process_slot(number, &slot);
                    self.topics[number].queue.recycle(slot);
                }
                PendingItem::Notice(notice) => self.process_notice(*notice),
            }
        }
        self.pending = round;
        self.shared.notify_room();
    }

    fn process_slot(&mut self, number: usize, slot: &Slot) {
        let times = Times {
            log: slot.stamps.published,
            publish: slot.stamps.measured,
            sequence: slot.stamps.sequence,
        };
        match slot.form {
            SlotForm::Value => self.write_value(number, times, &slot.bytes),
            SlotForm::Message => {
                let open = &self.topics[number];
                if let Some(channel) = open.channel {
                    let effect = Effect::State(open.state_key.clone());
                    self.sink.write_message(channel, times, &slot.bytes, effect);
                }
                if open.variable.is_some()
                    && let TopicContent::Values(value_type) = &open.queue.content
                    && let Ok(value) = cdr::decode(value_type, &slot.bytes)
                {
                    self.check_conditions(number, times.log, Some(&value));
                }
                self.advance_to(times.log);
            }
        }
    }

    /// Takes the newest large value, if there is a new one, without copying it first.
    fn fetch(&mut self, number: usize) {
        let open = &mut self.topics[number];
        let Some(flag) = open
            .queue
            .fetch_flag
            .as_ref()
            .filter(|flag| flag.is_new.swap(false, Ordering::AcqRel))
        else {
            return;
        };
        let log = flag.published.load(Ordering::Relaxed);
        let Some((mut reader, mut seen)) = open.fetch.take() else {
            return;
        };
        let latched = reader.latch(log);
        match seen.update(latched.map(|latched| latched.stamp.sequence)) {
            ValueChange::Unchanged => {}
            ValueChange::Value(missed) => {
                open.queue.lost.fetch_add(missed, Ordering::Relaxed);
                if let Some(latched) = latched {
                    let times = Times {
                        log,
                        publish: latched.stamp.time,
                        sequence: latched.stamp.sequence,
                    };
                    self.write_value(number, times, latched.bytes);
                }
            }
            ValueChange::Retracted => {
                let notice = retraction_notice(log, &open.queue);
                self.process_notice(notice);
            }
        }
        reader.release();
        self.topics[number].fetch = Some((reader, seen));
    }

    fn write_value(&mut self, number: usize, times: Times, bytes: &[u8]) {
        let open = &self.topics[number];
        if let Some(channel) = open.channel
            && let TopicContent::Values(value_type) = &open.queue.content
        {
            cdr::encode(value_type, bytes, &mut self.message);
            let effect = Effect::State(open.state_key.clone());
            self.sink.write_message(channel, times, &self.message, effect);
        }
        self.check_conditions(number, times.log, Some(bytes));
        self.advance_to(times.log);
    }

    fn process_notice(&mut self, notice: Notice) {
        match notice {
            Notice::Event(event) => {
                let records = self.records.as_mut().map(|builder| builder.process(&event));
                for record in records.unwrap_or_default() {
                    self.write_record(&record, None);
                }
                if let Some(triggers) = &mut self.triggers {
                    triggers.process_event(&event, &mut self.fired);
                }
                self.report_fired();
            }
            Notice::EarlierRecord(record, beginning) => {
                self.write_record_at(&record, beginning, None);
                if let Some(triggers) = &mut self.triggers {
                    triggers.process_record(&record, &mut self.fired);
                }
                // Records from before the recording do not fire conditions.
                self.fired.clear();
            }
            Notice::Record(record) => {
                self.write_record(&record, None);
                if let Some(triggers) = &mut self.triggers {
                    triggers.process_record(&record, &mut self.fired);
                }
                self.report_fired();
            }
            Notice::Retracted { time, variable } => {
                let is_of_variable =
                    |open: &OpenTopic| open.queue.metadata.get("variable") == Some(&variable);
                let number = self.topics.iter().position(is_of_variable);
                let channel = number.and_then(|number| self.topics[number].channel);
                // Without events there are no channels of records. A variable that no file contains needs no
                // record of its retraction.
                if (self.records.is_some() || self.record_channel.is_some()) && channel.is_some() {
                    self.write_record(&RunRecord::retracted(time, &variable), channel);
                }
                if let Some(number) = number {
                    self.check_conditions(number, time, None);
                }
            }
        }
    }

    /// Writes a record. `retracts` is the channel whose value the message retracts.
    fn write_record(&mut self, record: &RunRecord, retracts: Option<usize>) {
        self.write_record_at(record, record.time(), retracts);
    }

    fn write_record_at(&mut self, record: &RunRecord, log: Nanos, retracts: Option<usize>) {
        let channel = self.open_record_channels() + record.kind() as usize;
        let times = Times {
            log,
            publish: record.time(),
            sequence: 0,
        };
        let effect = match (retracts, record) {
            (Some(of), _) => Effect::Retracts(of),
            (None, RunRecord::Decision(decision)) => {
                Effect::State(StateKey::Named(decision.group.as_str().into()))
            }
            (None, RunRecord::State(change)) => Effect::State(StateKey::Named(change.schema.as_str().into())),
            (None, RunRecord::Other(_)) => Effect::State(StateKey::Stateless),
        };
        record::encode(record.clone(), &mut self.message);
        self.sink.write_message(channel, times, &self.message, effect);
        self.advance_to(log);
    }

    /// Passes a value, or its retraction, to the conditions that name it.
    fn check_conditions(&mut self, number: usize, time: Nanos, value: Option<&[u8]>) {
        let (Some(variable), Some(triggers)) = (&self.topics[number].variable, &mut self.triggers) else {
            return;
        };
        match value {
            Some(bytes) => triggers.process_value(time, variable, bytes, &mut self.fired),
            None => triggers.process_retraction(time, variable, &mut self.fired),
        }
        self.report_fired();
    }

    /// Advances the application's time to at least `time`.
    fn advance_to(&mut self, time: Nanos) {
        if time <= self.now {
            return;
        }
        self.now = time;
        if let Some(triggers) = &mut self.triggers {
            triggers.advance(time, &mut self.fired);
            self.report_fired();
        }
    }

    /// Advances the time while nothing arrives. In virtual time it does not advance then.
    fn advance_clock(&mut self) {
        if let Some(clock) = self.shared.clock.get().filter(|_| !self.shared.lossless) {
            self.advance_to(clock());
        }
    }

    /// Reports the conditions that became true, first as records and then to the sink.
    fn report_fired(&mut self) {
        for firing in std::mem::take(&mut self.fired) {
            let condition = firing.text.clone();
            let record = What::Triggered { condition }.at(firing.time);
            self.write_record(&record.into(), None);
            let triggers = self.triggers.as_ref();
            let condition = triggers.and_then(|triggers| triggers.condition(firing.condition));
            self.sink.fired(&firing, condition.unwrap_or_default());
        }
    }

    fn finish(mut self) {
        let last = self.records.take().map(|mut records| records.finish());
        for record in last.unwrap_or_default() {
            self.write_record(&record, None);
        }
        self.sink.finish();
    }
}
