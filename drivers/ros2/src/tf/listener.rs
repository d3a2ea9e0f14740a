//! The tree of frames from the topics of other nodes.

use jde_ros_node::Measured;
use jde_schema::prelude::*;
use jde_schema::types::TransformStamped;

use super::{Published, Transforms, Tree};
use crate::connection::{RosConnection, TopicSubscription};

/// The subscriptions to `/tf` and `/tf_static`, and the tree that they give.
pub(crate) struct Listener {
    pub(crate) tree: Tree,
    moving: TopicSubscription<Transforms>,
    fixed: TopicSubscription<Transforms>,
    /// Buffer for messages, which are too large for a stack.
    message: Box<Transforms>,
}

impl Listener {
    pub(crate) fn new(moving: TopicSubscription<Transforms>, fixed: TopicSubscription<Transforms>) -> Self {
        Self {
            tree: Tree::default(),
            moving,
            fixed,
            message: Transforms::boxed(),
        }
    }

    /// Takes the messages that arrived into the tree. What contradicts it is reported and ignored.
    pub(crate) fn listen(&mut self, cx: &Context, connection: &mut RosConnection) {
        for (subscription, is_static) in [(&self.moving, false), (&self.fixed, true)] {
            let tree = &mut self.tree;
            connection.receive_each(cx, subscription, &mut self.message, |connection, message, arrived| {
                if !is_static && !connection.clock.is_known() {
                    return;
                }
                for step in &message.transforms {
                    let is_ours = is_static || is_of_this_clock(connection, step, arrived);
                    let published = Published {
                        parent: step.header.frame_id.as_str(),
                        child: step.child_frame_id.as_str(),
                        stamp: to_nanos(step.header.stamp),
                        transform: step.transform,
                        is_static,
                    };
                    let inserted = match is_ours {
                        true => tree.insert(&published),
                        false => Err(format!(
                            "`{}` in `{}` is stamped more than 10 s from this clock and is ignored: synchronise the clocks, or \
                             follow that of a simulator with clock = \"follow\"",
                            published.child, published.parent
                        )),
                    };
                    if let Err(reason) = inserted {
                        connection.warn_once(cx, format!("{}: {reason}", subscription.topic()));
                    }
                }
            });
        }
    }
}

fn is_of_this_clock(connection: &RosConnection, step: &TransformStamped, arrived: Duration) -> bool {
    let measured = connection.clock.measured(step.header.stamp, arrived);
    matches!(measured, Measured::At(_))
}

/// A stamp as ns.
pub(crate) fn to_nanos(stamp: Time) -> i64 {
    i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec)
}

/// The stamp of a time in ns. Seconds beyond those of a stamp are cut.
pub(crate) fn to_stamp(nanos: i64) -> Time {
    let limits = (i64::from(i32::MIN), i64::from(i32::MAX));
    Time {
        sec: nanos.div_euclid(1_000_000_000).clamp(limits.0, limits.1) as i32,
        nanosec: nanos.rem_euclid(1_000_000_000) as u32,
    }
}
