//! The tree of frames from the topics of other nodes.

use jde_ros::cdr::{Error, Reader};
use jde_ros_node::Measured;
use jde_schema::prelude::*;
use jde_schema::types::Transform;

use super::{Published, Tree};
use crate::connection::RosConnection;

/// The number of the subscription to transforms that do not change; that to the others has the one before.
const STATIC_NUMBER: usize = 1;

/// The subscriptions to `/tf` and `/tf_static`, the first two of the node, and the tree that they give.
pub(crate) struct Listener {
    pub(crate) tree: Tree,
    topics: [String; 2],
}

impl Listener {
    pub(crate) fn new(topics: [String; 2]) -> Self {
        Self {
            tree: Tree::default(),
            topics,
        }
    }

    /// Takes the messages that arrived into the tree. What contradicts it is reported and ignored.
    pub(crate) fn listen(&mut self, cx: &Context, connection: &mut RosConnection) {
        for (number, topic) in self.topics.iter().enumerate() {
            let is_static = number == STATIC_NUMBER;
            for (received, arrived) in connection.take_all(cx, number) {
                if !is_static && !connection.clock.is_known() {
                    continue;
                }
                let message = received.message.to_bytes();
                let steps = read(&message, is_static).unwrap_or_else(|error| {
                    connection.warn_once(cx, format!("{topic}: {error}"));
                    Vec::new()
                });
                for step in steps {
                    let is_ours = is_static || is_of_this_clock(connection, step.stamp, arrived);
                    let inserted = match is_ours {
                        true => self.tree.insert(&step),
                        false => Err(format!(
                            "`{}` in `{}` is stamped more than 10 s from this clock and is ignored: synchronise the clocks, or \
                             follow that of a simulator with clock = \"follow\"",
                            step.child, step.parent
                        )),
                    };
                    if let Err(reason) = inserted {
                        connection.warn_once(cx, format!("{topic}: {reason}"));
                    }
                }
            }
        }
    }
}

/// Returns the transforms of a `tf2_msgs/msg/TFMessage`. It is no value, because the names of its frames have no bounds.
fn read(message: &[u8], is_static: bool) -> Result<Vec<Published<'_>>, Error> {
    let mut reader = Reader::new(message)?;
    let count = reader.length("transforms")?;
    let mut steps = Vec::new();
    for _ in 0..count {
        let stamp = Time {
            sec: i32::from_le_bytes(reader.number("sec")?),
            nanosec: u32::from_le_bytes(reader.number("nanosec")?),
        };
        let (parent, child) = (reader.text("frame_id")?, reader.text("child_frame_id")?);
        let mut number = |field| reader.number(field).map(f64::from_le_bytes);
        let translation = Vector3 {
            x: number("x")?,
            y: number("y")?,
            z: number("z")?,
        };
        let rotation = Quaternion {
            x: number("x")?,
            y: number("y")?,
            z: number("z")?,
            w: number("w")?,
        };
        steps.push(Published {
            parent,
            child,
            stamp: to_nanos(stamp),
            transform: Transform {
                translation,
                rotation,
            },
            is_static,
        });
    }
    reader.finish()?;
    Ok(steps)
}

fn is_of_this_clock(connection: &RosConnection, stamp: i64, arrived: Duration) -> bool {
    matches!(
        connection.clock.measured(to_stamp(stamp), arrived),
        Measured::At(_)
    )
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
