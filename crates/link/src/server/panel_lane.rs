//! The panel of one schema on its way, at one rate: drawn while the lane is there, and sent when it was drawn anew.

use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_host::MOST_RATE;
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;

use super::inbox::Want;
use super::lanes::{Yard, period};
use super::subject::{Looking, Subject};
use crate::attachment::PanelTag;

/// A panel on its way.
pub(super) struct PanelLane {
    looking: Box<dyn Looking>,
    publisher: Publisher<'static>,
    period: Option<Duration>,
    /// The next is sent no sooner.
    soonest: Instant,
    /// When it is looked at next, if not when it was drawn.
    due: Option<Instant>,
    /// Number of the one that was sent last.
    sent: Option<u64>,
}

impl PanelLane {
    pub(super) fn open(want: &Want, schema: &str, yard: &Yard<'_>) -> Option<Self> {
        let publisher = yard
            .session(want.origin)?
            .declare_publisher(yard.keys.panel(schema, want.rate))
            .congestion_control(CongestionControl::Drop)
            .wait()
            .inspect_err(|error| tracing::warn!("the panel of {schema} cannot be sent: {error}"))
            .ok()?;
        let period = period(want);
        let rate = period.map_or(MOST_RATE, |period| 1.0 / period.as_secs_f64());
        let inbox = Arc::clone(yard.inbox);
        let looking = yard
            .subject
            .look(schema, rate, Arc::new(move || inbox.freshen()))
            .inspect_err(|refusal| tracing::warn!("{}", refusal.error))
            .ok()?;
        let now = Instant::now();
        Some(Self {
            looking,
            publisher,
            period,
            soonest: now,
            due: Some(now),
            sent: None,
        })
    }

    pub(super) fn begin_again(&mut self) {
        let now = Instant::now();
        (self.sent, self.soonest, self.due) = (None, now, Some(now));
    }

    /// Sends the newest drawing if it is new and not too soon; answers when to look again.
    pub(super) fn serve(&mut self, subject: &dyn Subject, now: Instant, fresh: bool) -> Option<Instant> {
        if !fresh && self.due.is_none_or(|due| due > now) {
            return self.due;
        }
        self.due = None;
        let newest = self.looking.newest();
        let newest = newest.filter(|newest| self.sent != Some(newest.sequence))?;
        if now < self.soonest {
            self.due = Some(self.soonest);
            return self.due;
        }
        self.sent = Some(newest.sequence);
        self.soonest = now + self.period.unwrap_or_default();
        let tag = PanelTag {
            sequence: newest.sequence,
            time: newest.time,
            age: subject.now().saturating_sub(newest.time),
            nothing: newest.list.is_err(),
        };
        let message = match &newest.list {
            Ok(list) => ZBytes::from(jde_panel::encode(list)),
            Err(reason) => ZBytes::from(reason.as_str()),
        };
        if let Err(error) = self.publisher.put(message).attachment(tag.bytes()).wait() {
            tracing::debug!("{} was not sent: {error}", self.publisher.key_expr());
        }
        None
    }
}
