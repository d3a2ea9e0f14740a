//! Sensors that repeat what they measured.

use jde_types::Pose2D;

/// Notices a sensor that repeats its last measurement although the base moves.
#[derive(Clone, Copy, Debug, Default)]
pub struct Frozen {
    /// The pose of the base when the measurement changed last.
    changed_at: Pose2D,
}

impl Frozen {
    /// Takes a measurement at a pose of the base, which `differs` from the one before or is the same to the bit. Returns
    /// whether the base has moved by more than `most`, m or rad, since the last change.
    pub fn is_frozen(&mut self, differs: bool, base: &Pose2D, most: f64) -> bool {
        if differs {
            self.changed_at = *base;
        }
        let moved = self.changed_at.localize(base);
        libm::hypot(moved.x, moved.y) > most || moved.theta.abs() > most
    }

    /// The odometry jumped from one pose to another without a motion of the base.
    pub fn jump(&mut self, from: &Pose2D, to: &Pose2D) {
        self.changed_at = to.transform(&from.localize(&self.changed_at));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_measurement_is_no_new_one_after_a_motion_and_a_jump_is_none() {
        let mut frozen = Frozen::default();
        let mut is_frozen = |differs, at: &Pose2D, x, theta| {
            frozen.is_frozen(differs, &at.transform(&Pose2D::new(x, 0.0, theta)), 0.1)
        };
        let start = Pose2D::new(3.0, 1.0, 2.0);
        assert!(!is_frozen(true, &start, 0.0, 0.0));
        assert!(!is_frozen(false, &start, 0.09, 0.09));
        assert!(is_frozen(false, &start, 0.11, 0.0) && is_frozen(false, &start, 0.0, -0.11));
        let elsewhere = Pose2D::new(-5.0, 4.0, -1.0);
        frozen.jump(&start, &elsewhere);
        let mut is_frozen =
            |differs, x| frozen.is_frozen(differs, &elsewhere.transform(&Pose2D::new(x, 0.0, 0.0)), 0.1);
        assert!(!is_frozen(false, 0.09) && is_frozen(false, 0.11));
        assert!(!is_frozen(true, 0.11) && !is_frozen(false, 0.2));
    }
}
