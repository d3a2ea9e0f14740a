//! Values on their way to those who want them: one lane for each variable and rate, and none for what nobody wants. Variables
//! are looked at when a value is due; only where every value is wanted does the writer ring. They have a thread of their own, so
//! that nobody who asks and does not listen holds them up.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_board::{Reader, Variable, Watch};
use zenoh::bytes::ZBytes;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::{Session, Wait};

use super::inbox::{Inbox, Origin, Want};
use super::subject::Subject;
use crate::attachment::Tag;
use crate::keys::Keys;

/// Serves all lanes until the link stops.
pub(super) fn run(inbox: &Arc<Inbox>, subject: &dyn Subject, sessions: &[(Origin, Session)], keys: &Keys) {
    let mut lanes = Lanes::default();
    while !inbox.stopping() {
        let fresh = inbox.take_fresh();
        if let Some(wants) = inbox.wants() {
            lanes.follow(&wants, subject, sessions, keys, inbox);
        }
        match lanes.serve(subject, fresh) {
            Some(due) => std::thread::park_timeout(due.saturating_duration_since(Instant::now())),
            None => std::thread::park(),
        }
    }
}

/// All lanes.
#[derive(Default)]
struct Lanes {
    lanes: BTreeMap<Want, Lane>,
}

struct Lane {
    reader: Reader,
    publisher: Publisher<'static>,
    period: Option<Duration>,
    /// When it is looked at next; where every value is wanted, when the writer rings.
    due: Option<Instant>,
    /// Number of the value that was sent last, and whether there was one to see.
    sent: Option<(u64, bool)>,
    /// How many had come for it when it was sent.
    joined: u64,
    _watch: Option<Watch>,
}

impl Lanes {
    /// Opens and closes lanes, so that there is one for each want.
    fn follow(
        &mut self,
        wants: &BTreeMap<Want, u64>,
        subject: &dyn Subject,
        sessions: &[(Origin, Session)],
        keys: &Keys,
        inbox: &Arc<Inbox>,
    ) {
        self.lanes.retain(|want, _| wants.contains_key(want));
        for (want, joined) in wants {
            if let Some(lane) = self.lanes.get_mut(want) {
                if lane.joined != *joined {
                    lane.joined = *joined;
                    // Whoever came late gets the newest value at once, however old it is.
                    (lane.sent, lane.due) = (None, Some(Instant::now()));
                }
                continue;
            }
            let opened = subject
                .board()
                .list()
                .find(|variable| is_at(variable, &want.place))
                .and_then(|variable| Lane::open(want, *joined, &variable, sessions, keys, inbox));
            if let Some(lane) = opened {
                self.lanes.insert(want.clone(), lane);
            }
        }
    }

    /// Sends what is due; answers when the next value is.
    fn serve(&mut self, subject: &dyn Subject, fresh: bool) -> Option<Instant> {
        let now = Instant::now();
        for lane in self.lanes.values_mut() {
            if lane.due.is_some_and(|due| due <= now) || (fresh && lane.period.is_none()) {
                lane.send(subject);
                // From now on, not from when it was due: it is a bound, not a rhythm.
                lane.due = lane.period.map(|period| now + period);
            }
        }
        self.lanes.values().filter_map(|lane| lane.due).min()
    }
}

/// Whether it is found there below `var/`.
fn is_at(variable: &Variable, place: &str) -> bool {
    let declared = variable.describe();
    crate::keys::place(&declared.owner, &declared.name) == place
}

impl Lane {
    fn open(
        want: &Want,
        joined: u64,
        variable: &Arc<Variable>,
        sessions: &[(Origin, Session)],
        keys: &Keys,
        inbox: &Arc<Inbox>,
    ) -> Option<Self> {
        let declared = variable.describe();
        let (_, session) = sessions.iter().find(|(origin, _)| *origin == want.origin)?;
        let key = keys.values(&declared.owner, &declared.name, want.rate);
        let publisher = session
            .declare_publisher(key)
            .congestion_control(CongestionControl::Drop)
            .wait()
            .inspect_err(|error| tracing::warn!("{} cannot be sent: {error}", declared.full_name()))
            .ok()?;
        let period = want.rate.period_ns().map(Duration::from_nanos);
        let watch = period.is_none().then(|| {
            let inbox = Arc::clone(inbox);
            variable.watch(move || inbox.freshen())
        });
        Some(Self {
            reader: variable.reader("link"),
            publisher,
            period,
            due: Some(Instant::now()),
            sent: None,
            joined,
            _watch: watch,
        })
    }

    fn send(&mut self, subject: &dyn Subject) {
        let (tag, value) = newest(&mut self.reader, subject, self.sent);
        let Some(tag) = tag else { return };
        self.sent = Some((tag.sequence, !tag.retracted));
        if let Err(error) = self.publisher.put(value).attachment(tag.bytes()).wait() {
            tracing::debug!("a value of {} was not sent: {error}", self.publisher.key_expr());
        }
    }
}

/// The newest value with what goes beside it; none if it was sent before.
pub(super) fn newest(
    reader: &mut Reader,
    subject: &dyn Subject,
    sent: Option<(u64, bool)>,
) -> (Option<Tag>, ZBytes) {
    if sent.is_some_and(|(sequence, shown)| shown && sequence == reader.newest())
        && !reader.variable().is_retracted()
    {
        return (None, ZBytes::new());
    }
    let newest = reader.newest();
    let value_type = Arc::clone(&reader.variable().describe().value_type);
    let (tag, value) = match reader.latch() {
        Some(latched) => {
            let stamp = latched.stamp;
            let mut message = Vec::new();
            jde_ros::cdr::encode(&value_type, latched.bytes, &mut message);
            let tag = Tag {
                sequence: stamp.sequence,
                time: stamp.time,
                age: subject.now().saturating_sub(stamp.time),
                valid_until: stamp.valid_until,
                retracted: false,
                writer: subject.writer(stamp.writer),
            };
            (tag, ZBytes::from(message))
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
