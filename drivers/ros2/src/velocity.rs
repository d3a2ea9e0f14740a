//! Velocities on a topic: plain ones, and stamped ones where the other side has those, such as Nav2 since
//! Kilted.

use jde_ros_node::{Announced, Quality, Topic};
use jde_schema::prelude::*;

use crate::connection::{RosConnection, TopicSubscription};
use crate::messages::Codec;

/// A velocity with its time and frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/TwistStamped")]
pub(crate) struct TwistStamped {
    pub(crate) header: Header,
    pub(crate) twist: Twist,
}

/// The two topics of a name: plain, then stamped. Tools show the type that other nodes have, and the plain one without any.
pub(crate) fn topics(name: &str, quality: Quality) -> [Topic; 2] {
    let plain = Codec::<Twist>::new().topic(name.to_owned(), quality);
    let stamped = Codec::<TwistStamped>::new().topic(name.to_owned(), quality);
    [(plain, Announced::Preferably), (stamped, Announced::OnceMet)].map(|(topic, announced)| Topic {
        announced,
        is_command: true,
        ..topic
    })
}

/// A subscription to the topics of a name.
pub(crate) struct VelocitySubscription {
    plain: TopicSubscription<Twist>,
    stamped: TopicSubscription<TwistStamped>,
}

impl VelocitySubscription {
    /// The subscriptions of numbers `first` and the next.
    pub(crate) fn new(first: usize, topic: &str) -> Self {
        Self {
            plain: TopicSubscription::new(first, topic.to_owned(), Codec::new()),
            stamped: TopicSubscription::new(first + 1, topic.to_owned(), Codec::new()),
        }
    }

    /// Takes the newest velocity, and the time of its arrival. One that is not finite is reported and ignored.
    pub(crate) fn receive(
        &mut self,
        cx: &Context,
        connection: &mut RosConnection,
    ) -> Option<(Twist, Duration)> {
        let (mut twist, mut stamped) = (Twist::ZERO, TwistStamped::default());
        let plain_at = connection.receive(cx, &self.plain, &mut twist);
        let stamped_at = connection.receive(cx, &self.stamped, &mut stamped);
        if stamped_at > plain_at {
            twist = stamped.twist;
        }
        let arrived = stamped_at.max(plain_at)?;
        if !is_finite(&twist) {
            let message = format!("{}: a velocity that is not finite is ignored", self.plain.topic());
            connection.warn_once(cx, message);
            return None;
        }
        Some((twist, arrived))
    }
}

/// Whether all its numbers are finite.
pub(crate) fn is_finite(twist: &Twist) -> bool {
    [twist.linear, twist.angular]
        .iter()
        .all(|part| part.x.is_finite() && part.y.is_finite() && part.z.is_finite())
}

/// A publication to the topics of a name.
pub(crate) struct VelocityPublisher {
    first: usize,
    plain: Codec<Twist>,
    stamped: Codec<TwistStamped>,
}

impl VelocityPublisher {
    /// The publications of numbers `first` and the next.
    pub(crate) fn new(first: usize) -> Self {
        Self {
            first,
            plain: Codec::new(),
            stamped: Codec::new(),
        }
    }

    /// Publishes a velocity of this instant in each form to which somebody subscribes.
    pub(crate) fn publish(&self, cx: &Context, connection: &RosConnection, twist: &Twist) {
        let node = &connection.node;
        if node.has_subscribers(self.first) {
            node.publish(self.first, vec![self.plain.encode(twist)]);
        }
        if node.has_subscribers(self.first + 1) {
            let stamped = TwistStamped {
                header: Header {
                    stamp: connection.clock.stamp(cx.now()),
                    frame_id: Frame::new("base_link"),
                },
                twist: *twist,
            };
            node.publish(self.first + 1, vec![self.stamped.encode(&stamped)]);
        }
    }
}
