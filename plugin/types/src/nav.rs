//! The estimated position of the robot, maps, and its targets.

use crate::{
    Flag, Frame, Header, Padding, Pose, Pose2D, PoseStamped, PoseWithCovariance, Quaternion, Seq, Time,
    Twist, TwistWithCovariance, Value,
};

/// Pose and velocity, as measured by the wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "nav_msgs/msg/Odometry")]
pub struct Odometry {
    /// Time, and the frame of the pose: "odom".
    pub header: Header,
    /// The frame of the velocity: "base_link".
    pub child_frame_id: Frame,
    /// Pose of the base, in the frame of the header.
    pub pose: PoseWithCovariance,
    /// Velocity of the base, in its own frame.
    pub twist: TwistWithCovariance,
}

/// Size, resolution and origin of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "nav_msgs/msg/MapMetaData")]
pub struct MapMetaData {
    /// Time at which the map was loaded.
    pub map_load_time: Time,
    /// Side of a cell.
    #[value(unit = "m")]
    pub resolution: f32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Unused bytes.
    pub padding: Padding<4>,
    /// Pose of the lower left corner of the first cell.
    pub origin: Pose,
}

/// A map of up to 4096 × 4096 cells: 200 m at 5 cm. Cells that a map does not have cost no memory. A stack has no
/// room for this type: fill a loan, or memory of the heap.
#[derive(Clone, Copy, PartialEq, Value)]
#[repr(C)]
#[value(name = "nav_msgs/msg/OccupancyGrid")]
pub struct OccupancyGrid {
    /// Time, and the frame of the origin.
    pub header: Header,
    /// Size, resolution and origin.
    pub info: MapMetaData,
    /// The cells, row by row from the origin: 0 to 100 is the probability of an obstacle in percent, -1
    /// unknown.
    pub data: Seq<i8, { 4096 * 4096 }>,
}

/// A path to follow, of up to 256 poses: ways through a building turn more often than 64 times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "nav_msgs/msg/Path")]
pub struct Path {
    /// Time and frame.
    pub header: Header,
    /// The poses, from first to last.
    pub poses: Seq<PoseStamped, 256>,
}

/// Targets in the plane, in a form for files; ROS tools draw a [`Path`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Route")]
pub struct Route {
    /// The targets, from first to last.
    pub poses: Seq<Pose2D, 64>,
}

/// An optional target: a place, or a pose if its heading counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Target")]
pub struct Target {
    /// The position and the heading, in the frame of the odometry.
    pub pose: Pose2D,
    /// Whether there is a target.
    pub set: Flag,
    /// Whether its heading counts. Otherwise the robot may face anywhere.
    pub has_heading: Flag,
    /// Unused bytes.
    pub padding: Padding<6>,
}

/// An optional pose at which a robot starts, in a form for files: `[[3.55, 1.6, "90 deg"]]`, or `[]` for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/Start")]
pub struct Start {
    /// The pose, in the frame of the world or of the map.
    pub pose: Seq<Pose2D, 1>,
}

impl core::fmt::Debug for OccupancyGrid {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "OccupancyGrid({:?}, {} cells)", self.info, self.data.len())
    }
}

impl OccupancyGrid {
    /// Returns a map drawn in rows of text, the first at the top, whose lower left corner is the origin: `#` is occupied, `?`
    /// unknown, all else free. For tests.
    ///
    /// # Panics
    /// If there are more cells than a map has.
    #[must_use]
    pub fn drawn(resolution: f32, rows: &[&str]) -> Box<Self> {
        let mut map = Self::boxed();
        map.info.resolution = resolution;
        (map.info.width, map.info.height) =
            (rows.first().map_or(0, |row| row.len()) as u32, rows.len() as u32);
        map.info.origin.orientation = Quaternion::IDENTITY;
        for symbol in rows.iter().rev().flat_map(|row| row.bytes()) {
            let percent = match symbol {
                b'#' => 100,
                b'?' => -1,
                _ => 0,
            };
            map.data.push(percent).expect("a map has room for the cells");
        }
        map
    }

    /// Returns the centres of the occupied cells, m, in the frame of the map; of more than `most`, an even selection. From 65 %
    /// on a cell is occupied, as for ROS's map server. Without places that are not finite.
    pub fn occupied(&self, most: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
        let (width, resolution) = (self.info.width.max(1) as usize, f64::from(self.info.resolution));
        let origin = Pose2D::from(self.info.origin);
        let cells = self.data.iter().enumerate();
        let cells = cells.filter(|(_, percent)| (65..=100).contains(*percent));
        let step = cells.clone().count().div_ceil(most.max(1)).max(1);
        let center = move |index: usize| {
            let side = |number: usize| (number as f64 + 0.5) * resolution;
            let place = origin.transform(&Pose2D::new(side(index % width), side(index / width), 0.0));
            (place.x, place.y)
        };
        let places = cells.step_by(step).map(move |(index, _)| center(index));
        places.filter(|(x, y)| x.is_finite() && y.is_finite())
    }
}

impl Target {
    /// No target.
    pub const NONE: Self = Self {
        pose: Pose2D::ORIGIN,
        set: Flag::FALSE,
        has_heading: Flag::FALSE,
        padding: Padding::ZERO,
    };

    /// Returns the target at this place, with any heading.
    #[must_use]
    pub const fn at(pose: Pose2D) -> Self {
        Self {
            pose,
            set: Flag::TRUE,
            has_heading: Flag::FALSE,
            padding: Padding::ZERO,
        }
    }

    /// Returns the target at this place with this heading.
    #[must_use]
    pub const fn facing(pose: Pose2D) -> Self {
        Self {
            has_heading: Flag::TRUE,
            ..Self::at(pose)
        }
    }

    /// Returns the pose of the target, if there is one.
    #[must_use]
    pub fn get(&self) -> Option<Pose2D> {
        self.set.get().then_some(self.pose)
    }
}

impl Start {
    /// No pose.
    pub const NONE: Self = Self { pose: Seq::new() };

    /// Returns a start at this pose.
    #[must_use]
    pub fn at(pose: Pose2D) -> Self {
        Self {
            pose: [pose].into_iter().collect(),
        }
    }

    /// Returns the pose, if there is one.
    #[must_use]
    pub fn get(&self) -> Option<Pose2D> {
        self.pose.first().copied()
    }
}

impl Odometry {
    /// Returns an odometry with zero covariance, between the frames "odom" and "base_link".
    #[must_use]
    pub fn planar(stamp: impl Into<crate::Time>, pose: Pose2D, twist: Twist) -> Self {
        Self {
            header: Header::new(stamp, "odom"),
            child_frame_id: Frame::new("base_link"),
            pose: PoseWithCovariance {
                pose: Pose::from(pose),
                ..Default::default()
            },
            twist: TwistWithCovariance {
                twist,
                ..Default::default()
            },
        }
    }

    /// Returns the position and heading in the plane.
    #[must_use]
    pub fn pose2d(&self) -> Pose2D {
        self.pose.pose.into()
    }
}

impl Path {
    /// Returns the path through points, m, as far as they fit. Each pose faces the next one, and the last faces as the one
    /// before it; all have the time and frame of `header`.
    #[must_use]
    pub fn through(header: Header, points: &[(f64, f64)]) -> Self {
        let mut path = Self {
            header,
            ..Self::default()
        };
        let mut heading = 0.0;
        for (at, &(x, y)) in points.iter().enumerate() {
            if let Some(&(next_x, next_y)) = points.get(at + 1) {
                heading = libm::atan2(next_y - y, next_x - x);
            }
            let pose = Pose2D::new(x, y, heading).into();
            if path.poses.push(PoseStamped { header, pose }).is_err() {
                break;
            }
        }
        path
    }
}

impl Route {
    /// A route without targets.
    pub const EMPTY: Self = Self { poses: Seq::new() };

    /// Returns the route as a path; all poses have the time and frame of `header`.
    #[must_use]
    pub fn to_path(&self, header: Header) -> Path {
        Path {
            header,
            poses: self
                .poses
                .iter()
                .map(|&pose| PoseStamped {
                    header,
                    pose: pose.into(),
                })
                .collect(),
        }
    }
}
