//! The transforms that change: the base in the frame of its odometry, and frames whose poses are published.

use jde_ros_node::{Quality, Topic};
use jde_schema::prelude::*;
use jde_schema::{Imports, ListedImport};

use super::publication::is_of;
use super::settings::Publication;
use crate::connection::RosConnection;
use crate::messages::{Codec, measured, typed};
use crate::tf::{Placed, Transforms, message};

/// The topic of the transforms.
pub(super) struct TransformPublisher {
    number: usize,
    codec: Codec<Transforms>,
    /// What each entry is, and the sequence number of its last value.
    entries: Vec<(Option<Transformed>, u64)>,
}

/// What a transform is made of.
#[derive(Clone, Copy)]
enum Transformed {
    /// An odometry: the base in its frame.
    Base,
    /// The pose of a frame.
    Pose,
}

impl TransformPublisher {
    /// Adds the topic to those of the node; `None` if nothing that is published is a transform.
    pub(super) fn new(
        topic: String,
        publish: &Imports<Publication>,
        topics: &mut Vec<Topic>,
    ) -> Option<Self> {
        let entries: Vec<_> = publish.iter().map(|import| (transformed(import), 0)).collect();
        entries.iter().find(|(transformed, _)| transformed.is_some())?;
        let codec = Codec::new();
        topics.push(codec.topic(topic, Quality::DEFAULT));
        Some(Self {
            number: topics.len() - 1,
            codec,
            entries,
        })
    }

    /// Publishes the transform of each new value, if somebody subscribes to them.
    pub(super) fn publish(
        &mut self,
        cx: &Context,
        connection: &RosConnection,
        publish: &Imports<Publication>,
    ) {
        if !connection.node.has_subscribers(self.number) {
            return;
        }
        for (import, (transformed, sent)) in publish.iter().zip(&mut self.entries) {
            let Some(transformed) = transformed else { continue };
            let Some(value) = import.get(cx).filter(|value| value.sequence() != *sent) else {
                continue;
            };
            let (header, mut placed) = match transformed {
                Transformed::Base => {
                    let odometry = typed::<Odometry>(&value);
                    (odometry.header, Placed::base(&odometry))
                }
                Transformed::Pose => {
                    let pose = typed::<PoseStamped>(&value);
                    (pose.header, Placed::new(&pose, import.settings().child))
                }
            };
            let stated = import.settings().frame;
            if !stated.is_empty() {
                placed.parent = Frame::truncated(stated.as_str());
            }
            *sent = value.sequence();
            let stamp = connection.clock.stamp(measured(&header, value.time()));
            let message = self.codec.encode(&message([placed], stamp));
            connection.node.append(self.number, message);
        }
    }
}

/// Whether an entry is an odometry that is the transform of its base.
pub(super) fn is_base(import: &ListedImport<Publication>) -> bool {
    import.settings().transform.get() && is_of::<Odometry>(import.value_type())
}

/// Returns of what an entry is the transform, if it is one.
fn transformed(import: &ListedImport<Publication>) -> Option<Transformed> {
    let is_pose = || !import.settings().child.is_empty() && is_of::<PoseStamped>(import.value_type());
    if is_base(import) {
        Some(Transformed::Base)
    } else {
        is_pose().then_some(Transformed::Pose)
    }
}
