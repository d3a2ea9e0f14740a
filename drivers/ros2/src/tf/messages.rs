//! The messages of transforms that a jde robot publishes. RViz and Nav2 need them to place a scan.

use jde_schema::prelude::*;
use jde_schema::types::{Transform, TransformStamped};

/// Most transforms of a message. A robot with arms has some hundred.
const MAX_TRANSFORMS: usize = 1024;

/// Several transforms. A stack has no room for them.
#[derive(Clone, Copy, Debug, PartialEq, Value)]
#[repr(C)]
#[value(name = "tf2_msgs/msg/TFMessage")]
pub(crate) struct Transforms {
    pub(crate) transforms: Seq<TransformStamped, MAX_TRANSFORMS>,
}

/// Where something is: `child` in `parent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placed {
    pub(crate) parent: Frame,
    pub(crate) child: Frame,
    pub(crate) transform: Transform,
}

impl Placed {
    /// The base in the frame of the odometry.
    pub(crate) fn base(odometry: &Odometry) -> Self {
        Self {
            parent: odometry.header.frame_id,
            child: odometry.child_frame_id,
            transform: odometry.pose.pose.into(),
        }
    }

    /// A frame at a pose.
    pub(crate) fn new(pose: &PoseStamped, child: Frame) -> Self {
        Self {
            parent: pose.header.frame_id,
            child,
            transform: pose.pose.into(),
        }
    }
}

/// Returns the message of these transforms at a stamp. Frames without a name, and those of their parent itself, are left out.
pub(crate) fn message(placed: impl IntoIterator<Item = Placed>, stamp: Time) -> Box<Transforms> {
    let mut message = Transforms::boxed();
    for Placed {
        parent,
        child,
        transform,
    } in placed
    {
        if child.is_empty() || child == parent {
            continue;
        }
        let step = TransformStamped {
            header: Header {
                stamp,
                frame_id: parent,
            },
            child_frame_id: child,
            transform,
        };
        // A robot that has more is not published completely.
        let _ = message.transforms.push(step);
    }
    message
}

/// Converts a ring of sonars to the messages of ROS 2: one per sonar, each in its own frame, which begins with `frame`, or
/// with `sonar` if that is empty.
pub(crate) fn range_messages<'r>(
    ring: &'r RangeRing,
    frame: &'r str,
) -> impl Iterator<Item = (Range, Pose2D)> + 'r {
    let frame = if frame.is_empty() { "sonar" } else { frame };
    let sonars = ring.ranges.iter().zip(&ring.poses).enumerate();
    sonars.map(move |(number, (range, pose))| {
        let message = Range {
            header: Header {
                stamp: ring.header.stamp,
                frame_id: Frame::truncated(&format!("{frame}_{number}")),
            },
            radiation_type: ring.radiation_type,
            field_of_view: ring.field_of_view,
            min_range: ring.min_range,
            max_range: ring.max_range,
            range: *range,
            ..Range::default()
        };
        (message, *pose)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_has_each_frame_in_its_parent_at_the_stamp() {
        let odometry = Odometry::planar(Duration::from_secs(2), Pose2D::new(1.0, 2.0, 1.0), Twist::ZERO);
        let correction = PoseStamped {
            header: Header::new(Time::default(), "map"),
            pose: Pose2D::new(5.0, 0.0, 0.5).into(),
        };
        let parent = Frame::new("base_link");
        let mounted = |child, pose: Pose2D| Placed {
            parent,
            child,
            transform: Pose::from(pose).into(),
        };
        let placed = [
            Placed::new(&correction, odometry.header.frame_id),
            Placed::base(&odometry),
            mounted(Frame::new("laser"), Pose2D::new(0.1, 0.0, 0.5)),
            mounted(parent, Pose2D::ORIGIN),
            mounted(Frame::EMPTY, Pose2D::ORIGIN),
        ];
        let message = message(placed, Time { sec: 102, nanosec: 5 });
        let steps: Vec<_> = message
            .transforms
            .iter()
            .map(|step| {
                let stamp = (step.header.stamp.sec, step.header.stamp.nanosec);
                assert_eq!(stamp, (102, 5));
                let Transform {
                    translation,
                    rotation,
                } = step.transform;
                let yaw = (100.0 * rotation.yaw()).round();
                let frames = (step.header.frame_id.as_str(), step.child_frame_id.as_str());
                (frames, translation.x, translation.y, yaw)
            })
            .collect();
        let expected = [
            (("map", "odom"), 5.0, 0.0, 50.0),
            (("odom", "base_link"), 1.0, 2.0, 100.0),
            (("base_link", "laser"), 0.1, 0.0, 50.0),
        ];
        assert_eq!(steps, expected);
    }

    #[test]
    fn a_ring_is_one_message_per_sonar_each_in_its_own_frame() {
        let mut ring = RangeRing {
            max_range: 5.0,
            ..RangeRing::default()
        };
        ring.ranges.extend_from_slice(&[1.0, f32::INFINITY]).unwrap();
        let mount = Pose2D::new(0.2, 0.1, 0.3);
        ring.poses.extend_from_slice(&[Pose2D::ORIGIN, mount]).unwrap();
        let range_messages: Vec<_> = range_messages(&ring, "").collect();
        assert_eq!(range_messages.len(), 2);
        let (message, pose) = &range_messages[1];
        assert_eq!(
            (message.header.frame_id.as_str(), message.range, message.max_range),
            ("sonar_1", f32::INFINITY, 5.0)
        );
        assert_eq!(*pose, mount);
    }

    #[test]
    fn the_tree_has_the_type_name_and_hash_of_ros() {
        let topic = crate::messages::Codec::<Transforms>::new()
            .topic("/tf".to_owned(), jde_ros_node::Quality::DEFAULT);
        assert_eq!(topic.type_name, "tf2_msgs/msg/TFMessage");
        // From ROS 2 Jazzy, as computed by `rosbags` 0.11.9.
        assert_eq!(
            topic.hash,
            "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"
        );
    }
}
