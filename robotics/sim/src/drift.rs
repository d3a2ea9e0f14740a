//! How far the odometry may be from the true motion: its covariance by the wheels' errors, which the robot's
//! file states.
//!
//! The errors are propagated to first order along the measured motion (Kelly, "Linearized error propagation in
//! odometry", 2004). The scale error of a wheel stays the same, so its effect on the pose is summed up before
//! it is squared; the slip of each step is independent.

use crate::config::RobotConfig;

/// Rows of three: x, y, and the heading.
pub type Covariance = [[f64; 3]; 3];

/// The wheels: left, right, and the one that rolls to the left.
const WHEELS: usize = 3;

/// What the errors of the wheels have done to the pose since the odometry was zero.
#[derive(Debug, Default)]
pub(crate) struct Drift {
    /// The error of x, y and the heading for a scale error of 1, for each wheel.
    by_scale: [[f64; 3]; WHEELS],
    /// The covariance by slip of 1 m after one metre.
    by_slip: Covariance,
    last: MeasuredMotion,
}

/// The measured motion in a step of the world.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MeasuredMotion {
    /// The pose's heading in the middle of the step.
    pub(crate) heading: f64,
    /// The pose's change along x and y.
    pub(crate) moved: [f64; 2],
    /// Metres of each wheel.
    pub(crate) ways: [f64; WHEELS],
    /// Duration in seconds.
    pub(crate) dt: f64,
}

impl Drift {
    pub(crate) fn reset(&mut self) {
        (self.by_scale, self.by_slip) = Default::default();
    }

    pub(crate) fn add(&mut self, track: f64, step: MeasuredMotion) {
        self.last = step;
        if step.ways == [0.0; WHEELS] {
            return;
        }
        let effects = effects(track, step.heading);
        for ((error, effect), way) in self.by_scale.iter_mut().zip(&effects).zip(step.ways) {
            *error = turned(*error, step.moved);
            add_scaled(error, effect, way);
        }
        let rows = self.by_slip.map(|row| turned(row, step.moved));
        self.by_slip = transposed(transposed(rows).map(|column| turned(column, step.moved)));
        for (effect, way) in effects.iter().zip(step.ways) {
            add_square(&mut self.by_slip, effect, way.abs());
        }
    }

    /// Of the pose, in m², m rad and rad².
    pub(crate) fn pose(&self, config: &RobotConfig) -> Covariance {
        let mut covariance = self
            .by_slip
            .map(|row| row.map(|value| value * square(config.slip_sigma)));
        for error in &self.by_scale {
            add_square(&mut covariance, error, square(config.wheel_scale_sigma));
        }
        covariance
    }

    /// Of the speeds ahead, to the left and of the turn, in the robot's frame; m²/s², m rad/s² and rad²/s².
    pub(crate) fn twist(&self, config: &RobotConfig) -> Covariance {
        let mut covariance = Covariance::default();
        if self.last.dt > 0.0 {
            // A count of ticks is rounded at both ends of the step.
            let rounding = 1.0 / (6.0 * square(config.ticks_per_meter));
            for (effect, way) in effects(config.track, 0.0).iter().zip(self.last.ways) {
                let variance =
                    square(config.wheel_scale_sigma * way) + square(config.slip_sigma) * way.abs() + rounding;
                add_square(&mut covariance, effect, variance / square(self.last.dt));
            }
        }
        covariance
    }
}

/// The motion of the pose for one metre of each wheel.
fn effects(track: f64, heading: f64) -> [[f64; 3]; WHEELS] {
    let (sin, cos) = libm::sincos(heading);
    let (along, turn) = ([cos / 2.0, sin / 2.0], 1.0 / track);
    [
        [along[0], along[1], -turn],
        [along[0], along[1], turn],
        [-sin, cos, 0.0],
    ]
}

/// The error of a pose after it moved: one in heading turns the motion.
fn turned([x, y, heading]: [f64; 3], moved: [f64; 2]) -> [f64; 3] {
    [x - heading * moved[1], y + heading * moved[0], heading]
}

fn transposed(rows: Covariance) -> Covariance {
    [0, 1, 2].map(|column| rows.map(|row| row[column]))
}

fn add_scaled(sum: &mut [f64; 3], values: &[f64; 3], scale: f64) {
    for (sum, value) in sum.iter_mut().zip(values) {
        *sum += scale * value;
    }
}

/// Adds `scale` times the product of a column and its row.
fn add_square(sum: &mut Covariance, column: &[f64; 3], scale: f64) {
    for (row, value) in sum.iter_mut().zip(column) {
        add_scaled(row, column, scale * value);
    }
}

fn square(value: f64) -> f64 {
    value * value
}
