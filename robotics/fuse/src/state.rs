//! What the filter estimates, and how it moves on without a measurement.

use core::f64::consts::{PI, TAU};

use crate::matrix::Matrix;

/// How many numbers the filter estimates.
pub(crate) const SIZE: usize = 10;
pub(crate) const X: usize = 0;
pub(crate) const Y: usize = 1;
pub(crate) const YAW: usize = 2;
pub(crate) const VX: usize = 3;
pub(crate) const VY: usize = 4;
pub(crate) const RATE: usize = 5;
pub(crate) const BIAS: usize = 6;
pub(crate) const WAY_SCALE: usize = 7;
pub(crate) const TURN_SCALE: usize = 8;
pub(crate) const DRIFT: usize = 9;

pub(crate) type Numbers = [f64; SIZE];
pub(crate) type Covariance = Matrix<SIZE, SIZE>;

/// The motion of the base, and the constant errors of its sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Position along x, m.
    pub x: f64,
    /// Position along y, m.
    pub y: f64,
    /// Heading in (−π, π], rad.
    pub yaw: f64,
    /// Speed ahead in the measure of the wheels, m/s: were it the true one, its error would be that of the scale, and every
    /// change of speed would seem to say something of the scale.
    pub vx: f64,
    /// Speed to the left in the measure of the wheels, m/s.
    pub vy: f64,
    /// Turn rate, rad/s.
    pub rate: f64,
    /// What the gyro shows at rest, rad/s.
    pub bias: f64,
    /// How much too long the wheels measure a way, as a fraction.
    pub way_scale: f64,
    /// How much too large the wheels measure a turn, as a fraction.
    pub turn_scale: f64,
    /// The turn that the wheels measure and that is none, for each metre ahead, rad/m.
    pub drift: f64,
}

/// Standard deviations of the constant errors before anything is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Initial {
    /// Of x and y, m.
    pub position: f64,
    /// Of the heading, rad.
    pub yaw: f64,
    /// Of the gyro's bias, rad/s.
    pub bias: f64,
    /// Of the scale of ways.
    pub way_scale: f64,
    /// Of the scale of turns.
    pub turn_scale: f64,
    /// Of the drift of the wheels, rad/m.
    pub drift: f64,
}

/// The growth of variances with time, and where it stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProcessNoise {
    /// Of x and y beside the motion, m²/s.
    pub position: f64,
    /// Of the heading beside the motion, rad²/s.
    pub yaw: f64,
    /// Of the speed ahead, (m/s)²/s.
    pub vx: f64,
    /// Of the speed to the left, (m/s)²/s.
    pub vy: f64,
    /// Of the turn rate, (rad/s)²/s.
    pub rate: f64,
    /// Of the gyro's bias, (rad/s)²/s.
    pub bias: f64,
    /// How long a base that stands does so after its wheels have measured last, s. The growth is small meanwhile.
    pub standstill: f64,
}

impl State {
    /// Returns the true speeds ahead and to the left, m/s, and the turn rate, rad/s.
    #[must_use]
    pub fn twist(&self) -> [f64; 3] {
        [self.scale() * self.vx, self.scale() * self.vy, self.rate]
    }

    /// What a metre of the wheels is, m.
    pub(crate) fn scale(&self) -> f64 {
        1.0 / (1.0 + self.way_scale)
    }

    pub(crate) fn numbers(&self) -> Numbers {
        let Self {
            x,
            y,
            yaw,
            vx,
            vy,
            rate,
            bias,
            way_scale,
            turn_scale,
            drift,
        } = *self;
        [x, y, yaw, vx, vy, rate, bias, way_scale, turn_scale, drift]
    }

    pub(crate) fn of([x, y, yaw, vx, vy, rate, bias, way_scale, turn_scale, drift]: Numbers) -> Self {
        Self {
            x,
            y,
            yaw: normalize(yaw),
            vx,
            vy,
            rate,
            bias,
            way_scale,
            turn_scale,
            drift,
        }
    }

    /// Returns the state after `time` s at constant velocity, and its derivative by this one.
    pub(crate) fn after(&self, time: f64) -> (Self, Covariance) {
        // The mean heading: exact to the second order.
        let (sin, cos) = libm::sincos(self.yaw + self.rate * time / 2.0);
        let scale = self.scale();
        let (dx, dy) = (
            time * scale * (self.vx * cos - self.vy * sin),
            time * scale * (self.vx * sin + self.vy * cos),
        );
        let next = Self {
            x: self.x + dx,
            y: self.y + dy,
            yaw: normalize(self.yaw + self.rate * time),
            ..*self
        };
        let mut by = identity();
        (by[X][YAW], by[Y][YAW]) = (-dy, dx);
        (by[X][VX], by[X][VY]) = (time * scale * cos, -time * scale * sin);
        (by[Y][VX], by[Y][VY]) = (time * scale * sin, time * scale * cos);
        (by[X][RATE], by[Y][RATE]) = (-dy * time / 2.0, dx * time / 2.0);
        (by[X][WAY_SCALE], by[Y][WAY_SCALE]) = (-dx * scale, -dy * scale);
        by[YAW][RATE] = time;
        (next, by)
    }
}

pub(crate) fn identity() -> Covariance {
    let mut identity = [[0.0; SIZE]; SIZE];
    for (at, row) in identity.iter_mut().enumerate() {
        row[at] = 1.0;
    }
    identity
}

/// The angle in (−π, π].
pub(crate) fn normalize(angle: f64) -> f64 {
    let turned = angle.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}
