//! What distinguishes types of ROS 2 whose values are alike.

use serde::{Deserialize, Serialize};

/// What the interface of ROS 2 states of a field and its values do not show. Only the hash of its type depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RosNotation {
    /// Its elements are a `byte`, which is a [`Scalar::U8`](super::Scalar::U8) here.
    pub is_byte: bool,
    /// Its capacity is a bound in ROS 2 too. Otherwise a text or a sequence has none there.
    pub is_bounded: bool,
}
