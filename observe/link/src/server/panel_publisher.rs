//! Publishes the panel of one schema at one rate. The panel is drawn while the publisher exists, and each new
//! drawing is sent.

use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_panel::MAX_RATE;
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;

use super::inbox::Demand;
use super::publications::{PublishContext, period};
use super::repeats::Repeats;
use super::subject::{PanelViewer, Subject};
use crate::attachment::PanelTag;

/// The publisher of one panel.
pub(super) struct PanelPublisher {
    viewer: Box<dyn PanelViewer>,
    publisher: Publisher<'static>,
    period: Option<Duration>,
    /// Earliest time of the next message.
    earliest: Instant,
    /// When to check again without waiting for a new drawing.
    due: Option<Instant>,
    /// Sequence number of the last drawing sent.
    sent: Option<u64>,
    repeats: Repeats,
}

impl PanelPublisher {
    pub(super) fn open(demand: &Demand, schema: &str, context: &PublishContext<'_>) -> Option<Self> {
        let publisher = context
            .session(demand.origin)?
            .declare_publisher(context.keys.panel(schema, demand.rate))
            .congestion_control(CongestionControl::Drop)
            .wait()
            .inspect_err(|error| tracing::warn!("the panel of {schema} cannot be sent: {error}"))
            .ok()?;
        let period = period(demand);
        let rate = period.map_or(MAX_RATE, |period| 1.0 / period.as_secs_f64());
        let inbox = Arc::clone(context.inbox);
        let viewer = context
            .subject
            .view_panel(schema, rate, Arc::new(move || inbox.mark_fresh()))
            .inspect_err(|refusal| tracing::warn!("{}", refusal.error))
            .ok()?;
        let now = Instant::now();
        Some(Self {
            viewer,
            publisher,
            period,
            earliest: now,
            due: Some(now),
            sent: None,
            repeats: Repeats::new(),
        })
    }

    pub(super) fn resend(&mut self) {
        let now = Instant::now();
        (self.sent, self.earliest, self.due) = (None, now, Some(now));
    }

    /// Sends the newest drawing if it is new and not too early; returns when to check again.
    pub(super) fn serve(&mut self, subject: &dyn Subject, now: Instant, fresh: bool) -> Option<Instant> {
        let repeat = self.repeats.take_due(now);
        if repeat || fresh || self.due.is_some_and(|due| due <= now) {
            self.due = None;
            self.send(subject, now, repeat);
        }
        self.due.into_iter().chain(self.repeats.due()).min()
    }

    fn send(&mut self, subject: &dyn Subject, now: Instant, repeat: bool) {
        let Some(newest) = self.viewer.newest() else {
            return;
        };
        let is_new = self.sent != Some(newest.sequence);
        if !is_new && !repeat {
            return;
        }
        if now < self.earliest {
            self.due = Some(self.earliest);
            return;
        }
        self.sent = Some(newest.sequence);
        if is_new {
            self.repeats.restart(now);
        }
        self.earliest = now + self.period.unwrap_or_default();
        let tag = PanelTag {
            sequence: newest.sequence,
            time: newest.time,
            age: subject.now().saturating_sub(newest.time),
            is_error: newest.list.is_err(),
        };
        let message = match &newest.list {
            Ok(list) => ZBytes::from(jde_panel::encode(list)),
            Err(reason) => ZBytes::from(reason.as_str()),
        };
        if let Err(error) = self.publisher.put(message).attachment(tag.bytes()).wait() {
            tracing::debug!("{} was not sent: {error}", self.publisher.key_expr());
        }
    }
}
