//! The transforms that do not change: sensors on the base. A subscription that begins later gets them too.

use jde_ros_node::{Quality, Topic};
use jde_schema::prelude::*;
use jde_schema::{Imports, ListedImport};

use super::publication::is_of;
use super::settings::Publication;
use super::transforms::is_base;
use crate::connection::RosConnection;
use crate::messages::{Codec, typed};
use crate::tf::{Placed, Transforms, message, range_messages};

/// The topic of the static transforms. All of them are in each message, because it keeps the newest only.
pub(super) struct MountPublisher {
    number: usize,
    codec: Codec<Transforms>,
    /// The place of the entry that names the base.
    base: Option<usize>,
    /// What each entry is.
    sensors: Vec<Option<Sensor>>,
    /// Each frame, and the key of its entry.
    placed: Vec<(Placed, &'static str)>,
}

/// A sensor on the base.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sensor {
    Laser,
    Sonars,
    Camera,
}

impl MountPublisher {
    /// Adds the topic to those of the node; `None` if nothing that is published is on a base.
    pub(super) fn new(
        topic: String,
        publish: &Imports<Publication>,
        topics: &mut Vec<Topic>,
    ) -> Option<Self> {
        let sensors: Vec<_> = publish.iter().map(sensor).collect();
        sensors.iter().flatten().next()?;
        let codec = Codec::new();
        topics.push(codec.topic(topic, Quality::LATCHED));
        Some(Self {
            number: topics.len() - 1,
            codec,
            base: publish.iter().position(is_base),
            sensors,
            placed: Vec::new(),
        })
    }

    /// Publishes the transforms when one is new. A base whose odometry has no value yet has no name.
    pub(super) fn publish(
        &mut self,
        cx: &Context,
        connection: &mut RosConnection,
        publish: &Imports<Publication>,
    ) {
        let base = match self.base {
            Some(place) => publish[place]
                .get(cx)
                .map(|value| typed::<Odometry>(&value).child_frame_id),
            None => Some(Frame::new("base_link")),
        };
        let Some(base) = base else { return };
        let before = self.placed.len();
        for (place, import) in publish.iter().enumerate() {
            let Some(sensor) = self.sensors[place] else {
                continue;
            };
            let Some(value) = import.get(cx) else { continue };
            let settings = import.settings();
            let mut place = |child, pose: Pose| {
                let (parent, transform) = (base, pose.into());
                let placed = Placed {
                    parent,
                    child,
                    transform,
                };
                if let Err(message) = self.add(placed, import.label()) {
                    connection.warn_once(cx, message);
                }
            };
            if sensor == Sensor::Sonars {
                for (range, pose) in range_messages(&typed(&value), settings.frame.as_str()) {
                    place(range.header.frame_id, pose.into());
                }
            } else {
                let stated = Frame::truncated(settings.frame.as_str());
                let own = typed::<Header>(&value[..size_of::<Header>()]).frame_id;
                let child = if stated.is_empty() { own } else { stated };
                let pose = if sensor == Sensor::Camera {
                    camera(settings)
                } else {
                    settings.mount.into()
                };
                place(child, pose);
            }
        }
        if self.placed.len() > before {
            let stamp = connection.clock.stamp(cx.now());
            let message = message(self.placed.iter().map(|(placed, _)| *placed), stamp);
            connection
                .node
                .publish(self.number, vec![self.codec.encode(&message)]);
        }
    }

    /// Adds a frame of the entry with that key, unless it has no name or one of its name is there.
    ///
    /// # Errors
    /// If that is elsewhere, and of another entry.
    fn add(&mut self, new: Placed, label: &'static str) -> Result<(), String> {
        if new.child.is_empty() {
            return Ok(());
        }
        match self.placed.iter().find(|(known, _)| known.child == new.child) {
            Some((known, owner)) if *owner != label && *known != new => Err(format!(
                "`{label}` and `{owner}` in `publish` are both in the frame `{}`, which is where `{owner}` is mounted: state a \
                 `frame` of its own for one of them",
                new.child
            )),
            Some(_) => Ok(()),
            None => {
                self.placed.push((new, label));
                Ok(())
            }
        }
    }
}

/// Returns which sensor on the base an entry is.
fn sensor(import: &ListedImport<Publication>) -> Option<Sensor> {
    let value_type = import.value_type();
    if is_of::<LaserScan>(value_type) {
        Some(Sensor::Laser)
    } else if is_of::<RangeRing>(value_type) {
        Some(Sensor::Sonars)
    } else if is_of::<Image>(value_type) {
        Some(Sensor::Camera)
    } else {
        None
    }
}

/// The pose of the frame of a camera: x to the right of the picture, y down, z into it.
fn camera(settings: &Publication) -> Pose {
    let ((sin, cos), (sin_tilt, cos_tilt)) =
        (libm::sincos(settings.mount.theta), libm::sincos(settings.tilt));
    let right = [sin, -cos, 0.0];
    let down = [-sin_tilt * cos, -sin_tilt * sin, -cos_tilt];
    let into = [cos_tilt * cos, cos_tilt * sin, -sin_tilt];
    Pose {
        position: Point {
            x: settings.mount.x,
            y: settings.mount.y,
            z: settings.height,
        },
        orientation: Quaternion::from_axes([right, down, into]),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn a_camera_looks_where_its_angles_say() {
        let pose = |theta, tilt| {
            camera(&Publication {
                mount: Pose2D::new(0.1, 0.0, theta),
                height: 0.3,
                tilt,
                ..Publication::DEFAULT
            })
        };
        let looks = |theta, tilt| {
            let into = pose(theta, tilt).orientation.rotate([0.0, 0.0, 1.0]);
            into.map(|axis| (1e6 * axis).round() / 1e6)
        };
        assert_eq!(looks(0.0, 0.0), [1.0, 0.0, 0.0]);
        assert_eq!(looks(FRAC_PI_2, 0.0), [0.0, 1.0, 0.0]);
        assert_eq!(looks(0.0, FRAC_PI_2), [0.0, 0.0, -1.0]);
        let level = pose(0.3, 0.2);
        assert_eq!((level.position.x, level.position.z), (0.1, 0.3));
        let [row, column] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|axis| level.orientation.rotate(axis)[2]);
        assert!(row.abs() < 1e-12, "the rows of the picture are level");
        assert!(column < -0.9, "and its columns point down");
    }
}
