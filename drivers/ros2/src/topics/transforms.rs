//! The transforms of what is published: the base in the frame of its odometry, and the laser and the sonars on it.

use jde_ros_node::{Quality, Topic};
use jde_schema::prelude::*;
use jde_schema::{Imports, ListedImport};

use super::publication::{is_of, typed};
use super::settings::Publication;
use crate::connection::RosConnection;
use crate::messages::Codec;
use crate::tf::{Transforms, range_messages};

/// The topic of the transforms.
pub(super) struct TransformPublisher {
    number: usize,
    codec: Codec<Transforms>,
    /// The sequence number of the last value of each entry.
    sent: Vec<u64>,
}

impl TransformPublisher {
    /// Adds the topic to those of the node; `None` if no odometry is published.
    pub(super) fn new(
        topic: String,
        publish: &Imports<Publication>,
        topics: &mut Vec<Topic>,
    ) -> Option<Self> {
        publish.iter().find(|import| is_transform(import))?;
        let codec = Codec::new();
        topics.push(codec.topic(topic, Quality::DEFAULT));
        Some(Self {
            number: topics.len() - 1,
            codec,
            sent: vec![0; publish.len()],
        })
    }

    /// Publishes the transforms of each new odometry, if somebody subscribes to them.
    pub(super) fn publish(
        &mut self,
        cx: &Context,
        connection: &RosConnection,
        publish: &Imports<Publication>,
    ) {
        if !connection.node.has_subscribers(self.number) {
            return;
        }
        let mut messages = Vec::new();
        for (import, sent) in publish
            .iter()
            .zip(&mut self.sent)
            .filter(|(import, _)| is_transform(import))
        {
            let Some(value) = import.get(cx).filter(|value| value.sequence() != *sent) else {
                continue;
            };
            *sent = value.sequence();
            let mut tree = Transforms::of(&typed(&value), value.time(), &connection.clock);
            publish.iter().for_each(|import| mount(cx, import, &mut tree));
            messages.push(self.codec.encode(&tree));
        }
        if !messages.is_empty() {
            connection.node.publish(self.number, messages);
        }
    }
}

fn is_transform(import: &ListedImport<Publication>) -> bool {
    import.settings().transform.get() && is_of::<Odometry>(import.value_type())
}

/// Adds the frames of a sensor.
fn mount(cx: &Context, import: &ListedImport<Publication>, tree: &mut Transforms) {
    let Some(value) = import.get(cx) else { return };
    if is_of::<LaserScan>(import.value_type()) {
        let stated = Frame::truncated(import.settings().frame.as_str());
        let own = typed_header(&value).frame_id;
        tree.mount(
            if stated.is_empty() { own } else { stated },
            import.settings().mount,
        );
    } else if is_of::<RangeRing>(import.value_type()) {
        range_messages(&typed(&value)).for_each(|(range, pose)| tree.mount(range.header.frame_id, pose));
    }
}

/// The header with which a value begins.
fn typed_header(value: &[u8]) -> Header {
    typed(&value[..size_of::<Header>()])
}
