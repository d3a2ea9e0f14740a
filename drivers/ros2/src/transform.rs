//! Where a frame of ROS 2 is in another one, for schemas: the pose of a robot on the map of AMCL, or the laser at the
//! time of a scan.

use std::collections::VecDeque;

use jde_ros_node::{NodeConfig, Quality, Settings, names};
use jde_schema::prelude::*;
use jde_schema::types::{Transform as Tf, TransformStamped};

use crate::clock_source::{ClockSource, FollowedClock};
use crate::connection::RosConnection;
use crate::messages::{Codec, measured};
use crate::settings::node_schema;
use crate::tf::{Listener, LookupError, Transforms, to_nanos, to_stamp};

/// The qualities of tf2's subscriptions.
const MOVING_QUALITY: Quality = Quality {
    depth: 100,
    ..Quality::DEFAULT
};
const STATIC_QUALITY: Quality = Quality {
    latched: true,
    ..MOVING_QUALITY
};
/// Most scans that wait for their transform.
const MAX_SCANS: usize = 32;

node_schema! {
    /// Exports where the frame `source` is in the frame `target`, from `/tf` and `/tf_static`.
    ///
    /// The transform is the newest that all frames between them have or, if `laser` is bound, that of the time of
    /// each scan. It is interpolated between two times, and never extrapolated. The exports are retracted while there
    /// is no transform, and `state` gives the reason.
    #[schema(driver, period = "20ms", budget = "20ms")]
    pub struct Transform {
        /// The clock of the stamps: `wall`, or `follow` for that of `/clock`, which a simulator of ROS 2 publishes.
        #[modulation(default = FollowedClock::Wall)]
        clock: Modulation<FollowedClock>,
        /// Topic of the transforms that change.
        #[modulation(default = "/tf", fixed)]
        tf_topic: Modulation<Text<128>>,
        /// Topic of the transforms that do not.
        #[modulation(default = "/tf_static", fixed)]
        tf_static_topic: Modulation<Text<128>>,
        /// The frame in which the other one is stated.
        #[modulation(default = "map")]
        target: Modulation<Frame>,
        /// The frame that is looked up; empty for that of the scan if `laser` is bound, and "base_link" otherwise.
        #[modulation(default = "")]
        source: Modulation<Frame>,
        /// Greatest age of an exported transform.
        #[modulation(default = 1.0, unit = "s", min = 0.01, max = 3600.0)]
        stale: Modulation<f64>,
        /// Scans, for whose times the transform is exported.
        #[import(optional)]
        laser: Import<LaserScan>,
        /// The odometry whose velocity `pose` has.
        #[import(optional)]
        odometry: Import<Odometry>,
        /// Where `source` is in `target`, stamped with the time at which it was there.
        #[export]
        transform: Export<TransformStamped>,
        /// The same as a pose, with the velocity of `odometry`, if that is bound. Its covariance is unknown: zeros.
        #[export]
        pose: Export<Odometry>,
        /// The age of the newest transform, or the reason why there is none.
        #[export]
        state: Export<Text<160>>,
        /// Whether the router or other nodes are connected.
        #[export(lasting)]
        connection: Export<Connection>,
        active: Option<ActiveTransform>,
        /// The newest `state`.
        stated: Text<160>,
    }
}

/// The node, and what it has heard.
struct ActiveTransform {
    connection: RosConnection,
    listener: Listener,
    /// The times of the scans that wait for their transform.
    scans: VecDeque<Duration>,
    /// Sequence number of the newest scan.
    scan_number: u64,
    exported: Option<Exported>,
    /// When it awoke, or had a transform.
    known_at: Duration,
    /// The newest error that was reported since then.
    reported: Option<core::mem::Discriminant<LookupError>>,
}

/// What is exported: a transform, its frames `target` and `source`, and its time; `None` if it is valid at all times.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Exported {
    frames: [Frame; 2],
    transform: Tf,
    time: Option<Duration>,
}

impl Schema for Transform {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.active.is_none() {
            self.active = Some(self.with_settings(cx, |settings| self.start_with(cx, &settings))?);
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(active) = &mut self.active else {
            return Err("it is not awake".into());
        };
        active.begin(cx, self.clock.get(cx).into());
        let laser = self.laser.get(cx);
        let frames = [self.target.get(cx), source(self.source.get(cx), laser)];
        let stale = Duration::from_secs_f64(self.stale.get(cx));
        let is_fresh = |found: &Exported| found.time.is_none_or(|time| time + stale >= cx.now());
        let found = if self.laser.is_bound(cx) {
            active.at_scan(frames, laser, |time| time + stale >= cx.now())
        } else {
            active.newest(cx, frames).map(Some)
        };
        // A scan is often newer than the transforms at its time.
        let waits = self.laser.is_bound(cx) && matches!(found, Err(LookupError::TooNew { .. }));
        let previous = active.exported;
        active.exported = match &found {
            Ok(Some(found)) => Some(*found),
            Ok(None) => previous,
            Err(_) if waits => previous,
            Err(_) => None,
        };
        active.exported = active
            .exported
            .filter(|found| is_fresh(found) && found.frames == frames);
        match active.exported {
            Some(new) if previous != Some(new) => {
                let time = new.time.unwrap_or(cx.now());
                let (frame_id, child_frame_id) = (frames[0], frames[1]);
                let stamp = time.into();
                let header = Header { stamp, frame_id };
                let stamped = TransformStamped {
                    header,
                    child_frame_id,
                    transform: new.transform,
                };
                self.transform.write_at(cx, stamped, time);
                match self.odometry.get(cx) {
                    Some(odometry) => {
                        let pose = Odometry {
                            header,
                            child_frame_id,
                            pose: PoseWithCovariance {
                                pose: new.transform.into(),
                                ..PoseWithCovariance::default()
                            },
                            twist: odometry.twist,
                        };
                        self.pose.write_at(cx, pose, time);
                    }
                    None => self.pose.retract(cx),
                }
            }
            Some(_) => {}
            None if previous.is_some() => {
                self.transform.retract(cx);
                self.pose.retract(cx);
            }
            None => {}
        }
        let state = active.state(cx, &found, stale);
        if self.stated != state {
            self.stated = state;
            self.state.write(cx, state);
        }
        active
            .connection
            .export_connection(cx, &mut self.connection, None);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(active) = self.active.take() {
            active.connection.close(cx, &mut self.connection);
            self.transform.retract(cx);
            self.pose.retract(cx);
            self.state.retract(cx);
            self.stated = Text::EMPTY;
        }
    }
}

impl Inspect for Transform {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let topics = [&self.tf_topic, &self.tf_static_topic];
        self.inspect_node(cx, &topics, problems);
        for topic in topics {
            if topic.get(cx).is_empty() {
                problems.wrong(topic, "a name is missing, as in \"/tf\"");
            }
        }
        if self.target.get(cx).is_empty() {
            problems.wrong(&self.target, "the name of a frame is missing, as in \"map\"");
        }
    }
}

impl Transform {
    fn start_with(&self, cx: &Context, settings: &Settings<'_>) -> Result<ActiveTransform> {
        let node = settings.node_config()?;
        let topic = |topic: &Modulation<Text<128>>| {
            names::topic(&node.name.namespace, topic.get(cx).as_str()).map(Option::unwrap_or_default)
        };
        let topics = [topic(&self.tf_topic)?, topic(&self.tf_static_topic)?];
        let codec = Codec::<Transforms>::new();
        let qualities = [MOVING_QUALITY, STATIC_QUALITY].into_iter().zip(topics.clone());
        let config = NodeConfig {
            subscriptions: qualities
                .map(|(quality, topic)| codec.topic(topic, quality))
                .collect(),
            ..node
        };
        Ok(ActiveTransform {
            connection: RosConnection::start(config, self.clock.get(cx).into())?,
            listener: Listener::new(topics),
            scans: VecDeque::new(),
            scan_number: 0,
            exported: None,
            known_at: cx.now(),
            reported: None,
        })
    }
}

impl ActiveTransform {
    /// Takes what arrived.
    fn begin(&mut self, cx: &Context, clock: ClockSource) {
        if self.connection.begin(cx, clock) {
            info!(cx, "the time of ROS 2 has jumped: only static transforms stay");
            self.listener.tree.forget_moving();
            self.scans.clear();
        }
        self.listener.listen(cx, &mut self.connection);
    }

    /// Returns the newest transform that all frames between these have.
    fn newest(&self, cx: &Context, frames: [Frame; 2]) -> Result<Exported, LookupError> {
        let found = self
            .listener
            .tree
            .lookup(frames[0].as_str(), frames[1].as_str(), None)?;
        // Localizers stamp the transforms of a map ahead of time.
        let time = |stamp| self.connection.clock.time(to_stamp(stamp)).min(cx.now());
        Ok(Exported {
            frames,
            transform: found.transform,
            time: found.stamp.map(time),
        })
    }

    /// Returns the transform of the newest scan that has one, if it was not returned yet; otherwise why the newest has none.
    fn at_scan(
        &mut self,
        frames: [Frame; 2],
        laser: Option<Sample<'_, LaserScan>>,
        is_fresh: impl Fn(Duration) -> bool,
    ) -> Result<Option<Exported>, LookupError> {
        if let Some(laser) = laser
            && core::mem::replace(&mut self.scan_number, laser.sequence()) != laser.sequence()
        {
            self.scans.push_back(measured(&laser.header, laser.time()));
        }
        self.scans.retain(|time| is_fresh(*time));
        let excess = self.scans.len().saturating_sub(MAX_SCANS);
        self.scans.drain(..excess);
        let mut error = None;
        for (place, time) in self.scans.iter().enumerate().rev() {
            let stamp = to_nanos(self.connection.clock.stamp(*time));
            let tree = &self.listener.tree;
            match tree.lookup(frames[0].as_str(), frames[1].as_str(), Some(stamp)) {
                Ok(found) => {
                    let exported = Exported {
                        frames,
                        transform: found.transform,
                        time: Some(*time),
                    };
                    self.scans.drain(..=place);
                    return Ok(Some(exported));
                }
                Err(reason) => error = error.or(Some(reason)),
            }
        }
        error.map_or(Ok(None), Err)
    }

    /// Returns the state in words, and reports an error that lasts.
    fn state(
        &mut self,
        cx: &Context,
        found: &Result<Option<Exported>, LookupError>,
        stale: Duration,
    ) -> Text<160> {
        let now = cx.now();
        if let Some(exported) = &self.exported {
            (self.known_at, self.reported) = (now, None);
            let [target, source] = exported.frames;
            let age = exported.time.map_or("is static".to_owned(), |time| {
                format!("is {:.1} s old", now.saturating_sub(time).as_secs_f64())
            });
            return Text::truncated(&format!("`{source}` in `{target}` {age}"));
        }
        match found {
            Ok(None) => Text::new("no scan is new"),
            Ok(Some(found)) => {
                let [target, source] = found.frames;
                Text::truncated(&format!(
                    "`{source}` in `{target}` is older than {} s",
                    stale.as_secs_f64()
                ))
            }
            Err(error) => {
                let kind = core::mem::discriminant(error);
                if now > self.known_at + stale && self.reported.replace(kind) != Some(kind) {
                    warn!(cx, "{error}");
                }
                Text::truncated(&error.to_string())
            }
        }
    }
}

/// The frame that is looked up.
fn source(named: Frame, laser: Option<Sample<'_, LaserScan>>) -> Frame {
    match (named.is_empty(), laser) {
        (false, _) => named,
        (true, Some(laser)) => laser.header.frame_id,
        (true, None) => Frame::new("base_link"),
    }
}
