//! The transforms of one frame in its parent, and those between them.

use std::collections::VecDeque;

use jde_schema::types::{Quaternion, Transform, Vector3};

/// How long a transform is kept, ns: as long as in tf2.
pub(crate) const KEPT_NS: i64 = 10_000_000_000;
/// Most transforms of one frame: a thousand a second.
const MAX_KEPT: usize = 10_000;

/// Where a frame is in its parent. Times are ns.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum History {
    /// At all times.
    Fixed(Transform),
    /// At these times, in their order, and between them.
    Moving(VecDeque<(i64, Transform)>),
}

/// The newest or the oldest time of a history, which does not reach the one that was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Beyond {
    Newest(i64),
    Oldest(i64),
}

impl History {
    /// The time of its newest transform; `None` if it has none, or is valid at all times.
    pub(super) fn newest(&self) -> Option<i64> {
        match self {
            Self::Fixed(_) => None,
            Self::Moving(kept) => kept.back().map(|(stamp, _)| *stamp),
        }
    }

    /// Adds a transform. Returns whether it is within the time that is kept. A second one of the same time is
    /// ignored.
    pub(super) fn insert(&mut self, stamp: i64, transform: Transform) -> bool {
        let kept = match self {
            Self::Fixed(fixed) => {
                *fixed = transform;
                return true;
            }
            Self::Moving(kept) => kept,
        };
        let newest = kept.back().map_or(stamp, |(newest, _)| stamp.max(*newest));
        if stamp < newest.saturating_sub(KEPT_NS) {
            return false;
        }
        let place = kept.partition_point(|(earlier, _)| *earlier < stamp);
        if kept.get(place).is_none_or(|(other, _)| *other != stamp) {
            kept.insert(place, (stamp, transform));
        }
        while kept.len() > MAX_KEPT
            || kept
                .front()
                .is_some_and(|(oldest, _)| *oldest < newest.saturating_sub(KEPT_NS))
        {
            kept.pop_front();
        }
        true
    }

    /// Returns the transform at a time. Between two it is interpolated as in tf2.
    pub(super) fn at(&self, stamp: i64) -> Result<Transform, Beyond> {
        let kept = match self {
            Self::Fixed(fixed) => return Ok(*fixed),
            Self::Moving(kept) => kept,
        };
        let place = kept.partition_point(|(earlier, _)| *earlier < stamp);
        let Some((after, later)) = kept.get(place) else {
            return Err(Beyond::Newest(self.newest().unwrap_or(i64::MIN)));
        };
        if *after == stamp {
            return Ok(*later);
        }
        let Some((before, earlier)) = place.checked_sub(1).and_then(|place| kept.get(place)) else {
            return Err(Beyond::Oldest(*after));
        };
        let share = (stamp - before) as f64 / (after - before) as f64;
        Ok(between(earlier, later, share))
    }
}

/// The transform that is `share` of the way from one to another.
fn between(from: &Transform, to: &Transform, share: f64) -> Transform {
    let part = |from: f64, to: f64| from + share * (to - from);
    let (a, b) = (from.translation, to.translation);
    Transform {
        translation: Vector3 {
            x: part(a.x, b.x),
            y: part(a.y, b.y),
            z: part(a.z, b.z),
        },
        rotation: slerp(from.rotation, to.rotation, share),
    }
}

/// The rotation that is `share` of the shorter way from one to another, at a constant rate.
fn slerp(from: Quaternion, to: Quaternion, share: f64) -> Quaternion {
    let dot = from.x * to.x + from.y * to.y + from.z * to.z + from.w * to.w;
    let angle = libm::acos(dot.abs().min(1.0));
    let (a, b) = if angle < 1e-6 {
        // Sines of so small angles are as their angles.
        (1.0 - share, share)
    } else {
        (
            libm::sin((1.0 - share) * angle) / libm::sin(angle),
            libm::sin(share * angle) / libm::sin(angle),
        )
    };
    let b = b.copysign(dot);
    normalized(Quaternion {
        x: a * from.x + b * to.x,
        y: a * from.y + b * to.y,
        z: a * from.z + b * to.z,
        w: a * from.w + b * to.w,
    })
}

/// A quaternion of length 1 in the same direction.
pub(super) fn normalized(Quaternion { x, y, z, w }: Quaternion) -> Quaternion {
    let length = (x * x + y * y + z * z + w * w).sqrt();
    Quaternion {
        x: x / length,
        y: y / length,
        z: z / length,
        w: w / length,
    }
}
