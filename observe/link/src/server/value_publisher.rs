//! Publishes the values of one variable at one rate. It polls the variable when a value is due. Only at full
//! rate does the writer wake it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_board::{Access, Nanos, Variable, Watch};
use zenoh::Wait;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;

use super::inbox::Demand;
use super::publications::{PublishContext, period};
use super::repeats::Repeats;
use super::subject::Subject;
use super::value_reader::ValueReader;

/// How long to wait for the end of a command whose validity should be over.
const RECHECK_AFTER: Duration = Duration::from_millis(20);

/// The publisher of one variable.
pub(super) struct ValuePublisher {
    reader: ValueReader,
    publisher: Publisher<'static>,
    period: Option<Duration>,
    /// When the variable is read next; none at full rate, where the writer wakes the publishing thread.
    due: Option<Instant>,
    /// Sequence number of the last value sent, and whether there was a value.
    sent: Option<(u64, bool)>,
    is_command: bool,
    /// When the command that was sent last ends.
    ends: Option<Instant>,
    repeats: Repeats,
    _watch: Option<Watch>,
}

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
            reader: ValueReader::new(variable),
            publisher,
            period,
            due: Some(Instant::now()),
            sent: None,
            is_command: matches!(declared.access, Access::Command { .. }),
            ends: None,
            repeats: Repeats::new(),
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
            self.due = self.period.map(|period| now + period).or(self.ends);
        }
        self.due.into_iter().chain(self.repeats.due()).min()
    }

    fn send(&mut self, subject: &dyn Subject, now: Instant, repeat: bool) {
        let known = self.sent.filter(|_| !repeat);
        let Some((tag, value)) = self.reader.newest(subject, known) else {
            // The application's time may pass more slowly than this thread's.
            self.ends = self.ends.map(|ends| ends.max(now + RECHECK_AFTER));
            return;
        };
        let this = (tag.sequence, !tag.retracted);
        // Nothing wakes this thread when the validity of a command is over.
        let rest = tag.valid_until.saturating_sub(subject.now()).saturating_add(1);
        let ends = self.is_command && !tag.retracted && tag.valid_until < Nanos::MAX;
        self.ends = ends.then(|| now + Duration::from_nanos(rest));
        if self.sent.replace(this) != Some(this) {
            self.repeats.restart(now);
        }
        if let Err(error) = self.publisher.put(value).attachment(tag.bytes()).wait() {
            tracing::debug!("a value of {} was not sent: {error}", self.publisher.key_expr());
        }
    }
}
