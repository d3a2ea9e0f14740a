//! What is known of the pose, in words.

use core::fmt;

/// Why an estimate is not sure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// There is no estimate, because nobody has said where the robot is, and it was not searched.
    Nowhere,
    /// No scan has been compared with the map since the start.
    Unseen,
    /// This share of the beams agrees with the map.
    Disagrees(f64),
    /// Clusters of particles are at several places; this share is in the heaviest.
    Ambiguous(usize, f64),
    /// The standard deviation of the position, m, and of the heading, rad, is too large.
    Wide(f64, f64),
    /// The robot must go this way before the result of a search is sure, m.
    Unconfirmed(f64),
    /// So many other places explain the scans about as well; 0 if a search found too many to compare them all.
    Rivalled(usize),
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Nowhere => f.write_str("nothing says where the robot is"),
            Self::Unseen => f.write_str("the scan has not been compared with the map"),
            Self::Disagrees(share) => {
                write!(f, "only {:.0} % of the beams agree with the map", 100.0 * share)
            }
            Self::Ambiguous(clusters, share) => write!(
                f,
                "it may be at {clusters} places, at one of them with {:.0} %",
                100.0 * share
            ),
            Self::Wide(way, turn) => write!(
                f,
                "the place is known to {way:.2} m and {:.0} degrees only",
                turn.to_degrees()
            ),
            Self::Unconfirmed(way) => write!(f, "the robot must move by another {way:.1} m to be sure"),
            Self::Rivalled(0) => {
                f.write_str("other places may explain the scans as well: the robot must move")
            }
            Self::Rivalled(1) => f.write_str("another place explains the scans as well: the robot must move"),
            Self::Rivalled(places) => write!(
                f,
                "{places} other places explain the scans as well: the robot must move"
            ),
        }
    }
}

/// What is known of the pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    /// The estimate is sure.
    Sure,
    /// There may be an estimate, but it is not sure.
    Unsure(Doubt),
    /// The robot is searched, and there is no estimate. The number is the share that is done.
    Searching(f64),
}
