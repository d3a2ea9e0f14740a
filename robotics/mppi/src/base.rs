//! The motion of a base, eight at once: differential, omnidirectional, or with a least turning radius.

use wide::f32x8;

use crate::Command;

/// What a base can do. One without sideways speed is differential, or a car if it has a turning radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Base {
    /// Greatest speed ahead, m/s.
    pub fast: f32,
    /// Greatest speed backward, m/s; 0 if it must not drive backward.
    pub reverse: f32,
    /// Greatest speed to each side, m/s; 0 if it cannot.
    pub sideways: f32,
    /// Greatest turn rate, rad/s.
    pub turn: f32,
    /// Least turning radius, m; 0 if it can turn on the spot.
    pub turning_radius: f32,
    /// Greatest change of each speed, m/s².
    pub acceleration: f32,
    /// Greatest change of the turn rate, rad/s².
    pub turn_acceleration: f32,
    /// Time constant by which the velocity follows what the limits permit, as a first-order system, s; 0 if it follows
    /// at once.
    pub lag: f32,
}

/// Where a base is and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Position and heading, m and rad.
    pub pose: [f32; 3],
    /// Velocity in the frame of the base.
    pub velocity: Command,
    /// What the velocity lacks of the one that a lagging base strives for.
    pub lead: Command,
}

/// A disc of the robot, in the frame of the base. Together the discs cover its footprint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Ahead, m.
    pub x: f32,
    /// To the left, m.
    pub y: f32,
    /// Radius, m.
    pub radius: f32,
}

/// Eight motions at once.
#[derive(Clone, Copy)]
pub(crate) struct Lanes {
    pub(crate) x: f32x8,
    pub(crate) y: f32x8,
    pub(crate) cos: f32x8,
    pub(crate) sin: f32x8,
    pub(crate) velocity: [f32x8; 3],
    /// What the base strives for.
    pub(crate) target: [f32x8; 3],
}

impl Lanes {
    pub(crate) fn all(motion: &Motion) -> Self {
        let [x, y, heading] = motion.pose;
        let (sin, cos) = libm::sincosf(heading);
        Self {
            x: f32x8::splat(x),
            y: f32x8::splat(y),
            cos: f32x8::splat(cos),
            sin: f32x8::splat(sin),
            velocity: motion.velocity.map(f32x8::splat),
            target: core::array::from_fn(|part| f32x8::splat(motion.velocity[part] + motion.lead[part])),
        }
    }
}

impl Base {
    /// Returns the nearest command that the base accepts.
    pub(crate) fn clamp(&self, [ahead, left, turn]: [f32x8; 3]) -> [f32x8; 3] {
        let within = |value: f32x8, low: f32, high: f32| {
            value.fast_max(f32x8::splat(low)).fast_min(f32x8::splat(high))
        };
        let ahead = within(ahead, -self.reverse, self.fast);
        [
            ahead,
            within(left, -self.sideways, self.sideways),
            self.bend(ahead, within(turn, -self.turn, self.turn)),
        ]
    }

    /// The turn rate that the turning radius permits.
    fn bend(&self, ahead: f32x8, turn: f32x8) -> f32x8 {
        if self.turning_radius > 0.0 {
            let most = ahead.abs() * f32x8::splat(1.0 / self.turning_radius);
            turn.fast_max(-most).fast_min(most)
        } else {
            turn
        }
    }

    /// Moves on for `step` s, in which what the base strives for approaches the command within the limits, and the
    /// velocity follows by the lag. The position follows the chord of the mean heading, with an error of third order in
    /// the angle of the step.
    pub(crate) fn advance(&self, lanes: &mut Lanes, command: &[f32x8; 3], step: f32) {
        let limits = [self.acceleration, self.acceleration, self.turn_acceleration].map(|limit| limit * step);
        for ((target, command), limit) in lanes.target.iter_mut().zip(command).zip(limits) {
            let limit = f32x8::splat(limit);
            *target += (*command - *target).fast_max(-limit).fast_min(limit);
        }
        let follows = f32x8::splat(self.follows(step));
        for (velocity, target) in lanes.velocity.iter_mut().zip(&lanes.target) {
            *velocity += (*target - *velocity) * follows;
        }
        let [ahead, left, turn] = lanes.velocity;
        let turn = self.bend(ahead, turn);
        lanes.velocity[2] = turn;
        // Sine and cosine of half the angle: exact to the last bits up to 0.3 rad, which no step exceeds.
        let half = turn * f32x8::splat(0.5 * step);
        let square = half * half;
        let sin =
            half * (f32x8::ONE - square * (f32x8::splat(1.0 / 6.0) - square * f32x8::splat(1.0 / 120.0)));
        let cos = f32x8::ONE - square * (f32x8::splat(0.5) - square * f32x8::splat(1.0 / 24.0));
        let rotate = |c: f32x8, s: f32x8| (c * cos - s * sin, s * cos + c * sin);
        let (mean_cos, mean_sin) = rotate(lanes.cos, lanes.sin);
        let step = f32x8::splat(step);
        lanes.x += (ahead * mean_cos - left * mean_sin) * step;
        lanes.y += (ahead * mean_sin + left * mean_cos) * step;
        (lanes.cos, lanes.sin) = rotate(mean_cos, mean_sin);
    }

    /// The share of its lack that a velocity makes up for in `step` s.
    fn follows(&self, step: f32) -> f32 {
        if self.lag > 0.0 {
            1.0 - libm::expf(-step / self.lag)
        } else {
            1.0
        }
    }

    /// The places that commands lead to, one after each step of `step` s, m.
    pub(crate) fn places(
        &self,
        start: &Motion,
        step: f32,
        commands: impl Iterator<Item = Command>,
    ) -> impl Iterator<Item = (f32, f32)> {
        let (base, mut lanes) = (*self, Lanes::all(start));
        commands.map(move |command| {
            base.advance(&mut lanes, &command.map(f32x8::splat), step);
            (lanes.x.to_array()[0], lanes.y.to_array()[0])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: Base = Base {
        fast: 1.0,
        reverse: 0.2,
        sideways: 0.0,
        turn: 1.5,
        turning_radius: 0.0,
        acceleration: 100.0,
        turn_acceleration: 100.0,
        lag: 0.0,
    };

    fn drive(base: &Base, command: Command, steps: usize) -> (f32, f32, f32) {
        let mut lanes = Lanes::all(&Motion::default());
        let command = base.clamp(command.map(f32x8::splat));
        (0..steps).for_each(|_| base.advance(&mut lanes, &command, 0.05));
        let first = |value: f32x8| value.to_array()[0];
        (
            first(lanes.x),
            first(lanes.y),
            libm::atan2f(first(lanes.sin), first(lanes.cos)),
        )
    }

    #[test]
    fn half_a_circle_of_1_m_radius_ends_2_m_to_the_left() {
        let turn = core::f32::consts::PI / 3.0;
        let (x, y, heading) = drive(&Base { fast: 2.0, ..BASE }, [turn, 0.0, turn], 60);
        // The chord of each step is shorter than its arc by a part in 9000.
        assert!(x.abs() < 1e-3 && (y - 2.0).abs() < 1e-3, "{x} {y}");
        assert!((heading.abs() - core::f32::consts::PI).abs() < 1e-4);
    }

    #[test]
    fn no_velocity_exceeds_its_limits() {
        let (x, y, heading) = drive(&BASE, [9.0, 9.0, 0.0], 20);
        assert!((x - 1.0).abs() < 1e-5 && y == 0.0 && heading == 0.0);
        let (x, ..) = drive(&BASE, [-9.0, 0.0, 0.0], 20);
        assert!((x + 0.2).abs() < 1e-5);
        let slow = Base {
            acceleration: 0.5,
            ..BASE
        };
        // 0.025 m/s more in each of 20 steps.
        let (x, ..) = drive(&slow, [1.0, 0.0, 0.0], 20);
        assert!((x - 0.05 * 0.025 * 210.0).abs() < 1e-5, "{x}");
        let omnidirectional = Base {
            sideways: 0.3,
            ..BASE
        };
        assert!((drive(&omnidirectional, [0.0, 9.0, 0.0], 20).1 - 0.3).abs() < 1e-5);
    }

    #[test]
    fn a_lagging_base_stays_behind_by_its_lag_times_its_speed_and_goes_on_by_as_much() {
        let lagging = Base { lag: 0.2, ..BASE };
        // The velocity of a step is that of its end: half a step less.
        let (x, ..) = drive(&lagging, [1.0, 0.0, 0.0], 40);
        assert!((x - (2.0 - 0.2 + 0.025)).abs() < 2e-3, "{x}");
        let moving = Motion {
            velocity: [1.0, 0.0, 0.0],
            lead: [-1.0, 0.0, 0.0],
            ..Motion::default()
        };
        let stop = lagging
            .places(&moving, 0.05, core::iter::repeat_n([0.0; 3], 60))
            .last();
        let (x, _) = stop.expect("60 places");
        assert!((x - (0.2 - 0.025)).abs() < 2e-3, "{x}");
    }

    #[test]
    fn a_car_turns_no_tighter_than_its_radius_and_not_on_the_spot() {
        let car = Base {
            turning_radius: 2.0,
            ..BASE
        };
        assert_eq!(drive(&car, [0.0, 0.0, 1.5], 40), (0.0, 0.0, 0.0));
        let (_, _, heading) = drive(&car, [1.0, 0.0, 1.5], 20);
        assert!((heading - 0.5).abs() < 1e-4, "{heading} rad after 1 m");
    }
}
