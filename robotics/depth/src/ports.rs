//! The keys by which a schema knows what counts and where its sensor is.

use jde_schema::prelude::*;
use jde_schema::types::Frame;

use crate::floor::{FloorScan, Limits, LimitsError};
use crate::level::Level;

/// Where a sensor of depths is, and what counts of its points. The names are those of ROS's `pointcloud_to_laserscan`.
#[derive(PortBundle)]
pub struct FloorPorts {
    /// How high the sensor is above the floor.
    #[modulation(default = 0.3, unit = "m", min = 0.02, max = 10.0)]
    height: Modulation<f64>,
    /// How far the sensor looks down.
    #[modulation(default = 0.0, unit = "rad", min = -1.57, max = 1.57)]
    pitch: Modulation<f64>,
    /// How far the sensor leans to the right.
    #[modulation(default = 0.0, unit = "rad", min = -3.15, max = 3.15)]
    roll: Modulation<f64>,
    /// Least height of an obstacle above the floor. What is lower is floor.
    #[modulation(default = 0.05, unit = "m", min = 0.005, max = 10.0)]
    min_height: Modulation<f64>,
    /// Greatest height of an obstacle: the robot passes below what is higher.
    #[modulation(default = 1.0, unit = "m", min = 0.01, max = 100.0)]
    max_height: Modulation<f64>,
    /// How much deeper than the floor is a cliff.
    #[modulation(default = 0.05, unit = "m", min = 0.005, max = 10.0)]
    max_drop: Modulation<f64>,
    /// From where on the floor must be seen for a direction to be free. The scan says nothing of what is nearer.
    #[modulation(default = 0.8, unit = "m", min = 0.0, max = 100.0)]
    range_min: Modulation<f64>,
    /// How far the scan reaches.
    #[modulation(default = 3.0, unit = "m", min = 0.1, max = 100.0)]
    range_max: Modulation<f64>,
    /// First direction of the scan.
    #[modulation(default = -0.5, unit = "rad", min = -3.15, max = 3.15)]
    angle_min: Modulation<f64>,
    /// Last direction of the scan.
    #[modulation(default = 0.5, unit = "rad", min = -3.15, max = 3.15)]
    angle_max: Modulation<f64>,
    /// From direction to direction.
    #[modulation(default = 0.00872664626, unit = "rad", min = 0.001, max = 0.05)]
    angle_increment: Modulation<f64>,
    /// The frame of the scan: level, with its origin on the floor below the sensor, x where that looks. Empty is the name of
    /// the schema.
    #[modulation(default = "", fixed)]
    frame_id: Modulation<Frame>,
}

impl FloorPorts {
    /// Returns where the sensor is.
    #[must_use]
    pub fn level(&self, cx: &Context) -> Level {
        Level {
            height: self.height.get(cx),
            pitch: self.pitch.get(cx),
            roll: self.roll.get(cx),
        }
    }

    /// Returns the header of a scan of what was measured at a time. The frame is never that of the sensor, which is not level.
    #[must_use]
    pub fn header(&self, cx: &Context, measured: &Header) -> Header {
        let stated = self.frame_id.get(cx);
        let frame_id = if stated.is_empty() {
            Frame::truncated(cx.name())
        } else {
            stated
        };
        Header {
            frame_id,
            ..*measured
        }
    }

    /// Returns the scan of a sensor that has seen nothing.
    ///
    /// # Errors
    /// The limits contradict each other.
    pub fn scan(&self, cx: &Context) -> Result<FloorScan, LimitsError> {
        FloorScan::new(Limits {
            height: self.height.get(cx),
            min_height: self.min_height.get(cx),
            max_height: self.max_height.get(cx),
            max_drop: self.max_drop.get(cx),
            range_min: self.range_min.get(cx),
            range_max: self.range_max.get(cx),
            angle_min: self.angle_min.get(cx),
            angle_max: self.angle_max.get(cx),
            angle_increment: self.angle_increment.get(cx),
        })
    }

    /// Returns what to tell of a sensor that sees the floor only beyond `range_min`, by the directions in which it looks:
    /// in the level frame, from the sensor.
    pub fn blind(&self, cx: &Context, rays: impl Iterator<Item = [f64; 3]>) -> Option<String> {
        let (height, range_min) = (self.height.get(cx), self.range_min.get(cx));
        let mut floor = self.scan(cx).ok()?;
        let down = rays.filter(|[_, _, z]| *z < 0.0);
        down.for_each(|[x, y, z]| floor.add([x * height / -z, y * height / -z, 0.0]));
        match floor.floor_from() {
            Some(from) if from <= range_min => None,
            Some(from) => Some(format!(
                "the floor is seen from {from:.2} m on in all directions, and `range_min` is {range_min:.2} m"
            )),
            None => Some("no floor is in view up to `range_max`".to_owned()),
        }
    }

    /// Reports limits that contradict each other.
    pub fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.range_max, self.scan(cx));
    }
}
