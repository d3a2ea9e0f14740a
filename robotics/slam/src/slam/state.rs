//! What came of a scan, in numbers and in words.

use core::fmt;

/// What came of a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    /// There is no scan yet from which a map could begin.
    Empty,
    /// The scan fits what is known; the number is the share of its points that do.
    Fits(f64),
    /// It shows what was not seen before, and contradicts nothing; the pose is that of the odometry.
    New(f64),
    /// It contradicts what is known; the pose is that of the odometry.
    Differs(f64),
    /// It has too few points; the pose is that of the odometry.
    Blind,
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("no scan yet"),
            Self::Fits(share) => write!(f, "{:.0} % of the points are on known surfaces", 100.0 * share),
            Self::New(share) => write!(
                f,
                "only {:.0} % of the points are on known surfaces, the others are new: the odometry says where the robot is",
                100.0 * share
            ),
            Self::Differs(share) => write!(
                f,
                "only {:.0} % of the points are on known surfaces: the odometry says where the robot is",
                100.0 * share
            ),
            Self::Blind => f.write_str("the scan has too few points: the odometry says where the robot is"),
        }
    }
}

/// How far the place of the robot is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Certainty {
    /// The robot may have been moved without the odometry, by 0.3 m and 0.2 rad.
    #[default]
    Doubted,
    /// A scan fitted, and none differed since.
    Sure,
    /// The last scan that could be compared differed: places that look alike may be taken for each other.
    Lost,
}
