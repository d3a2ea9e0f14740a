//! The transforms between a robot's frames, in the format of ROS 2. RViz and Nav2 need them to place a scan.
//! Static frames are published together with the moving one.

use jde_ros_node::Clock;
use jde_schema::prelude::*;

use crate::messages::measured;

/// Most transforms: the base, a scanner, and a ring of 32 sonars.
const MAX_TRANSFORMS: usize = 34;

/// Translation and rotation from one frame to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/Transform")]
pub(crate) struct Transform {
    pub(crate) translation: Vector3,
    pub(crate) rotation: Quaternion,
}

/// The transform from the header's frame to the child frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/TransformStamped")]
pub(crate) struct TransformStamped {
    pub(crate) header: Header,
    pub(crate) child_frame_id: Frame,
    pub(crate) transform: Transform,
}

/// Several transforms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "tf2_msgs/msg/TFMessage")]
pub(crate) struct Transforms {
    pub(crate) transforms: Seq<TransformStamped, MAX_TRANSFORMS>,
}

impl Transforms {
    /// The transform of the base, from an odometry measured at its stamp, or at `time` if it has none.
    pub(crate) fn of(odometry: &Odometry, time: Duration, clock: &Clock) -> Self {
        let pose = odometry.pose.pose;
        let mut this = Self::default();
        let stamp = clock.stamp(measured(&odometry.header, time));
        this.push(TransformStamped {
            header: Header {
                stamp,
                frame_id: odometry.header.frame_id,
            },
            child_frame_id: odometry.child_frame_id,
            transform: Transform {
                translation: Vector3 {
                    x: pose.position.x,
                    y: pose.position.y,
                    z: pose.position.z,
                },
                rotation: pose.orientation,
            },
        });
        this
    }

    /// Adds a frame that is fixed on the base.
    pub(crate) fn mount(&mut self, frame: Frame, pose: Pose2D) {
        let Some(base) = self.transforms.first().copied() else {
            return;
        };
        if frame.is_empty() || frame == base.child_frame_id {
            return;
        }
        self.push(TransformStamped {
            header: Header {
                stamp: base.header.stamp,
                frame_id: base.child_frame_id,
            },
            child_frame_id: frame,
            transform: Transform {
                translation: Vector3 {
                    x: pose.x,
                    y: pose.y,
                    z: 0.0,
                },
                rotation: Quaternion::from_yaw(pose.theta),
            },
        });
    }

    fn push(&mut self, step: TransformStamped) {
        // A ring has at most 32 sonars, so the list has room.
        let _ = self.transforms.push(step);
    }
}

/// Converts a ring of sonars to the messages of ROS 2: one per sonar, each in its own frame.
pub(crate) fn range_messages(ring: &RangeRing) -> impl Iterator<Item = (Range, Pose2D)> + '_ {
    let sonars = ring.ranges.iter().zip(&ring.poses).enumerate();
    sonars.map(|(number, (range, pose))| {
        let message = Range {
            header: Header {
                stamp: ring.header.stamp,
                frame_id: Frame::truncated(&format!("sonar_{number}")),
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
    fn mounted_frames_have_the_stamp_and_the_frame_of_the_base() {
        let mut clock = Clock::default();
        clock.compare(Duration::ZERO, Duration::from_secs(100));
        let odometry = Odometry::planar(Duration::from_secs(2), Pose2D::new(1.0, 2.0, 1.0), Twist::ZERO);
        let mut tree = Transforms::of(&odometry, Duration::from_secs(3), &clock);
        tree.mount(Frame::new("laser"), Pose2D::new(0.1, 0.0, 0.5));
        tree.mount(Frame::new("base_link"), Pose2D::ORIGIN);
        tree.mount(Frame::EMPTY, Pose2D::ORIGIN);
        let steps: Vec<_> = tree
            .transforms
            .iter()
            .map(|step| {
                (
                    step.header.frame_id.as_str(),
                    step.child_frame_id.as_str(),
                    step.header.stamp.sec,
                )
            })
            .collect();
        assert_eq!(steps, [("odom", "base_link", 102), ("base_link", "laser", 102)]);
        let base = tree.transforms[0].transform;
        assert_eq!((base.translation.x, base.translation.y), (1.0, 2.0));
        assert!((base.rotation.yaw() - 1.0).abs() < 1e-12);
        let laser = tree.transforms[1].transform;
        assert_eq!(laser.translation.x, 0.1);
        assert!((laser.rotation.yaw() - 0.5).abs() < 1e-12);
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
        let range_messages: Vec<_> = range_messages(&ring).collect();
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
