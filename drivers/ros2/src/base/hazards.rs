//! What an iRobot Create 3, the base of a TurtleBot 4, touches: its hazards, as bumpers.

use jde_schema::prelude::*;

/// A hazard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "irobot_create_msgs/msg/HazardDetection")]
pub(crate) struct HazardDetection {
    /// Time, and the frame of the sensor.
    pub(crate) header: Header,
    pub(crate) r#type: u8,
    pub(crate) padding: Padding<3>,
}

/// The hazards that are detected at present.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "irobot_create_msgs/msg/HazardDetectionVector")]
pub(crate) struct HazardDetectionVector {
    pub(crate) header: Header,
    pub(crate) detections: Seq<HazardDetection, 32>,
}

/// Types of hazards.
pub(crate) const BUMP: u8 = 1;
pub(crate) const STALL: u8 = 3;

/// The frames of the bumper's zones, from left to right.
const ZONES: [&str; 5] = [
    "bump_left",
    "bump_front_left",
    "bump_front_center",
    "bump_front_right",
    "bump_right",
];

impl From<&HazardDetectionVector> for Bumpers {
    /// A bump whose zone is unknown is one of all zones.
    fn from(hazards: &HazardDetectionVector) -> Self {
        let of = |kind| {
            hazards
                .detections
                .iter()
                .filter(move |hazard| hazard.r#type == kind)
        };
        let is_known = |frame: &Frame| ZONES.iter().any(|zone| frame == zone);
        let is_pressed = |zone: &str| {
            of(BUMP).any(|bump| bump.header.frame_id == zone || !is_known(&bump.header.frame_id))
        };
        Self {
            header: hazards.header,
            front: ZONES.into_iter().map(|zone| is_pressed(zone).into()).collect(),
            stalled: (of(STALL).count() > 0).into(),
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use jde_ros_node::Quality;

    use super::*;
    use crate::messages::Codec;

    #[test]
    fn hazards_have_the_type_of_the_create() {
        let topic = Codec::<HazardDetectionVector>::new().topic("/h".to_owned(), Quality::SENSOR_DATA);
        // As `rosbags` 0.11.9 computes it from the definitions of irobot_create_msgs.
        assert_eq!(
            topic.hash,
            "RIHS01_90913822b0a9155a64b12352ba73b2ca9248d73874ebf7700ed277b2dca57edd"
        );
    }

    #[test]
    fn bumps_are_where_their_frames_say() {
        let pressed = |frames: &[(u8, &str)]| {
            let detections = frames.iter().map(|(kind, frame)| HazardDetection {
                header: Header::new(Time::default(), frame),
                r#type: *kind,
                ..HazardDetection::default()
            });
            let bumpers = Bumpers::from(&HazardDetectionVector {
                detections: detections.collect(),
                ..HazardDetectionVector::default()
            });
            assert!(bumpers.rear.is_empty(), "it has none");
            let front = bumpers.front.iter().map(|pressed| u8::from(pressed.get()));
            (Vec::from_iter(front), bumpers.stalled.get())
        };
        assert_eq!(pressed(&[]), (vec![0; 5], false));
        assert_eq!(
            pressed(&[
                (BUMP, "bump_front_left"),
                (BUMP, "bump_right"),
                (2, "cliff_front_left")
            ]),
            (vec![0, 1, 0, 0, 1], false)
        );
        assert_eq!(pressed(&[(BUMP, "bumper")]), (vec![1; 5], false));
        assert_eq!(pressed(&[(STALL, "base_link")]), (vec![0; 5], true));
    }
}
