//! The sonars of a ROS 2 robot: a topic for each of them, as one ring.

use jde_schema::prelude::*;
use jde_schema::types::Route;

use crate::connection::{RosConnection, TopicSubscription};

/// The names in a list with commas between.
pub(super) fn names(list: &str) -> impl Iterator<Item = &str> {
    list.split(',').map(str::trim).filter(|name| !name.is_empty())
}

/// Returns the places of as many sonars as topics are listed.
pub(super) fn check(list: &str, mounts: &Route) -> Result<Seq<Pose2D, 32>, String> {
    let (topics, places) = (names(list).count(), mounts.poses.as_slice());
    if topics != places.len() {
        return Err(format!(
            "{} places for {topics} topics in sonar_topics; state one for each, as in {{ poses = [[0.1, 0, 0]] }}",
            places.len()
        ));
    }
    Seq::from_slice(places).map_err(|_| format!("{topics} sonars, and room for 32"))
}

/// The topics, and the ring that they give.
pub(super) struct Sonars {
    topics: Vec<TopicSubscription<Range>>,
    ring: RangeRing,
}

impl Sonars {
    pub(super) fn new(topics: Vec<TopicSubscription<Range>>, poses: Seq<Pose2D, 32>) -> Self {
        let mut ring = RangeRing {
            poses,
            ..RangeRing::default()
        };
        ring.ranges.resize(topics.len()).fill(f32::NAN);
        Self { topics, ring }
    }

    /// Whether a range is fresh.
    pub(super) fn has_received(&self) -> bool {
        self.topics.iter().any(TopicSubscription::has_received)
    }

    /// Exports the ring when a range is new. That of a sonar that is silent for `stale` is not a number; a ring of such
    /// is retracted.
    pub(super) fn publish(
        &mut self,
        cx: &Context,
        connection: &mut RosConnection,
        export: &mut Export<RangeRing>,
        stale: Duration,
    ) {
        let (mut newest, mut is_silent) = (None, false);
        for (topic, range) in self.topics.iter_mut().zip(self.ring.ranges.as_mut_slice()) {
            let mut message = Range::default();
            if let Some(arrived) = connection.receive(cx, topic, &mut message) {
                let time = connection.stamp(cx, topic, &mut message.header, arrived);
                if !connection.is_fresh(cx, topic.topic(), (time, arrived), Some(stale)) {
                    continue;
                }
                topic.mark_received(arrived);
                newest = newest.max(Some(time));
                *range = message.range;
                self.ring.radiation_type = message.radiation_type;
                self.ring.field_of_view = message.field_of_view;
                (self.ring.min_range, self.ring.max_range) = (message.min_range, message.max_range);
            } else if topic.falls_silent(cx, connection, stale) {
                (*range, is_silent) = (f32::NAN, true);
            }
        }
        if let Some(time) = newest.or(is_silent.then_some(cx.now())) {
            if self.has_received() {
                self.ring.header = Header::new(time, "base_link");
                export.write_at(cx, self.ring, time);
            } else {
                export.retract(cx);
            }
        }
    }
}
