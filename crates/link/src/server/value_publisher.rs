//! Publishes the values of one variable at one rate. It polls the variable when a value is due. Only at full
//! rate does the writer wake it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bytes::Bytes;
use jde_abi::describe::Type;
use jde_board::{Reader, Variable, Watch};
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;

use super::inbox::Demand;
use super::publications::{PublishContext, period};
use super::repeats::Repeats;
use super::subject::Subject;
use crate::attachment::Tag;

/// The publisher of one variable.
pub(super) struct ValuePublisher {
    reader: Reader,
    publisher: Publisher<'static>,
    period: Option<Duration>,
    /// When the variable is read next; none at full rate, where the writer wakes the publishing thread.
    due: Option<Instant>,
    /// Sequence number of the last value sent, and whether there was a value.
    sent: Option<(u64, bool)>,
    repeats: Repeats,
    message: Message,
    _watch: Option<Watch>,
}

/// The message of a value. Its memory is used again once Zenoh has sent it.
#[derive(Clone, Default)]
pub(super) struct Message(Arc<Vec<u8>>);

impl ValuePublisher {
    pub(super) fn open(
        demand: &Demand,
        variable: &Arc<Variable>,
        context: &PublishContext<'_>,
    ) -> Option<Self> {
        let declared = variable.describe();
        let key = context.keys.values(&declared.owner, &declared.name, demand.rate);
        let publisher = context
            .session(demand.origin)?
            .declare_publisher(key)
            .congestion_control(CongestionControl::Drop)
            .wait()
            .inspect_err(|error| tracing::warn!("{} cannot be sent: {error}", declared.full_name()))
            .ok()?;
        let period = period(demand);
        let watch = period.is_none().then(|| {
            let inbox = Arc::clone(context.inbox);
            variable.watch(move || inbox.mark_fresh())
        });
        Some(Self {
            reader: variable.reader("link"),
            publisher,
            period,
            due: Some(Instant::now()),
            sent: None,
            repeats: Repeats::new(),
            message: Message::default(),
            _watch: watch,
        })
    }

    pub(super) fn resend(&mut self) {
        (self.sent, self.due) = (None, Some(Instant::now()));
    }

    /// Sends the newest value if it is due; returns when the next is due.
    pub(super) fn serve(&mut self, subject: &dyn Subject, now: Instant, fresh: bool) -> Option<Instant> {
        let repeat = self.repeats.take_due(now);
        if repeat || self.due.is_some_and(|due| due <= now) || (fresh && self.period.is_none()) {
            self.send(subject, now, repeat);
            // The next is due a period after now, not after the due time: the rate is an upper bound.
            self.due = self.period.map(|period| now + period);
        }
        self.due.into_iter().chain(self.repeats.due()).min()
    }

    fn send(&mut self, subject: &dyn Subject, now: Instant, repeat: bool) {
        let known = self.sent.filter(|_| !repeat);
        let (tag, value) = newest(&mut self.reader, &mut self.message, subject, known);
        let Some(tag) = tag else { return };
        let this = (tag.sequence, !tag.retracted);
        if self.sent.replace(this) != Some(this) {
            self.repeats.restart(now);
        }
        if let Err(error) = self.publisher.put(value).attachment(tag.bytes()).wait() {
            tracing::debug!("a value of {} was not sent: {error}", self.publisher.key_expr());
        }
    }
}

impl Message {
    /// Replaces it by that of a value, and returns it.
    fn encode(&mut self, value_type: &Type, value: &[u8]) -> ZBytes {
        if Arc::get_mut(&mut self.0).is_none() {
            self.0 = Arc::default();
        }
        if let Some(message) = Arc::get_mut(&mut self.0) {
            jde_ros::cdr::encode(value_type, value, message);
        }
        ZBytes::from(Bytes::from_owner(self.clone()))
    }
}

impl AsRef<[u8]> for Message {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

/// The newest value with its attachment; none if it was sent before.
pub(super) fn newest(
    reader: &mut Reader,
    message: &mut Message,
    subject: &dyn Subject,
    sent: Option<(u64, bool)>,
) -> (Option<Tag>, ZBytes) {
    if sent.is_some_and(|(sequence, had_value)| had_value && sequence == reader.newest())
        && !reader.variable().is_retracted()
    {
        return (None, ZBytes::new());
    }
    let newest = reader.newest();
    let value_type = Arc::clone(&reader.variable().describe().value_type);
    let (tag, value) = match reader.latch() {
        Some(latched) => {
            let stamp = latched.stamp;
            let value = message.encode(&value_type, latched.bytes);
            let tag = Tag {
                sequence: stamp.sequence,
                time: stamp.time,
                age: subject.now().saturating_sub(stamp.time),
                valid_until: stamp.valid_until,
                retracted: false,
                writer: subject.writer(stamp.writer),
            };
            (tag, value)
        }
        None => {
            let now = subject.now();
            let tag = Tag {
                sequence: newest,
                time: now,
                age: 0,
                valid_until: u64::MAX,
                retracted: true,
                writer: String::new(),
            };
            (tag, ZBytes::new())
        }
    };
    reader.release();
    if sent == Some((tag.sequence, !tag.retracted)) {
        return (None, ZBytes::new());
    }
    (Some(tag), value)
}
