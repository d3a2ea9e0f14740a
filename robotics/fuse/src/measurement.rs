//! What is measured, as the numbers that the filter compares: what it expects, and how that depends on the state.

use core::time::Duration;

use crate::filter::SLIP_LEVER;
use crate::matrix::Matrix;
use crate::state::{BIAS, DRIFT, RATE, SIZE, State, TURN_SCALE, VX, VY, X, Y, YAW, normalize};

/// A measurement of one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measurement {
    /// A gyro about the axis up.
    Turn(Turn),
    /// The velocity by the wheels.
    Wheels(Wheels),
    /// A measured heading.
    Heading(Heading),
    /// A measured position.
    Position(Position),
    /// A measured position and heading.
    Place(Place),
}

/// The turn rate of a gyro, with its bias.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// rad/s.
    pub rate: f64,
    /// (rad/s)².
    pub variance: f64,
}

/// The mean velocity of the base by its wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheels {
    /// Ahead and to the left, m/s.
    pub velocity: [f64; 2],
    /// Turn rate, rad/s.
    pub rate: f64,
    /// Covariance of the three.
    pub covariance: Matrix<3, 3>,
    /// The time before that of the measurement of which the velocity is the mean; 0 if it is that of the instant. The turn
    /// is compared with that of a gyro in this time.
    pub lasts: Duration,
    /// Whether the base stands: the wheels have not moved for a while.
    pub is_standing: bool,
}

/// A heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heading {
    /// rad.
    pub yaw: f64,
    /// rad².
    pub variance: f64,
}

/// A position of an antenna.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// m.
    pub position: [f64; 2],
    /// m².
    pub covariance: Matrix<2, 2>,
    /// Where the antenna is on the base, m.
    pub antenna: [f64; 2],
}

/// A position and a heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// x, y and heading: m, m, rad.
    pub pose: [f64; 3],
    /// Their covariance.
    pub covariance: Matrix<3, 3>,
}

/// The Mahalanobis distance from which on a measurement is refused, for each kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Of a gyro's turn rate.
    pub turn: f64,
    /// Of the velocity of the wheels, and of their turn rate.
    pub wheels: f64,
    /// Of a heading.
    pub heading: f64,
    /// Of a position.
    pub position: f64,
    /// Of a position with a heading.
    pub place: f64,
}

/// What was measured, less what was expected, with the noise and the derivative by the state.
pub(crate) struct Innovation<const M: usize> {
    pub(crate) difference: [f64; M],
    pub(crate) covariance: Matrix<M, M>,
    pub(crate) by_state: Matrix<M, SIZE>,
}

impl Turn {
    pub(crate) fn innovation(&self, state: &State) -> Innovation<1> {
        let mut by_state = [[0.0; SIZE]];
        (by_state[0][RATE], by_state[0][BIAS]) = (1.0, 1.0);
        Innovation {
            difference: [self.rate - state.rate - state.bias],
            covariance: [[self.variance]],
            by_state,
        }
    }
}

/// By how much wheels slip, rad/s, where nothing would notice it.
const UNSEEN_SLIP: f64 = 0.3;

impl Wheels {
    /// The same wheels where a gyro measures, but not at the time at which these may have slipped.
    pub(crate) fn unseen(mut self) -> Self {
        let turn = UNSEEN_SLIP * UNSEEN_SLIP;
        self.covariance[0][0] += SLIP_LEVER * SLIP_LEVER * turn;
        self.covariance[2][2] += turn;
        self
    }

    pub(crate) fn speeds(&self, state: &State, covariance: Matrix<2, 2>) -> Innovation<2> {
        let mut by_state = [[0.0; SIZE]; 2];
        (by_state[0][VX], by_state[1][VY]) = (1.0, 1.0);
        Innovation {
            difference: [self.velocity[0] - state.vx, self.velocity[1] - state.vy],
            covariance,
            by_state,
        }
    }

    /// The turn of the wheels, where no gyro measures it.
    pub(crate) fn turn(&self, state: &State) -> Innovation<1> {
        let scale = 1.0 + state.turn_scale;
        let mut by_state = [[0.0; SIZE]];
        (by_state[0][RATE], by_state[0][TURN_SCALE]) = (scale, state.rate);
        (by_state[0][VX], by_state[0][DRIFT]) = (state.drift, state.vx);
        Innovation {
            difference: [self.rate - scale * state.rate - state.drift * state.vx],
            covariance: [[self.covariance[2][2]]],
            by_state,
        }
    }

    /// The turn of the wheels beside that of a gyro in the same time: how the base turned is not in it, so that it says
    /// of the constant errors alone.
    pub(crate) fn turn_beside(&self, state: &State, gyro: f64, variance: f64) -> Innovation<1> {
        let (scale, turned) = (1.0 + state.turn_scale, gyro - state.bias);
        let mut by_state = [[0.0; SIZE]];
        by_state[0][BIAS] = -scale;
        by_state[0][TURN_SCALE] = turned;
        (by_state[0][VX], by_state[0][DRIFT]) = (state.drift, state.vx);
        Innovation {
            difference: [self.rate - scale * turned - state.drift * state.vx],
            covariance: [[self.covariance[2][2] + scale * scale * variance]],
            by_state,
        }
    }

    /// A base that stands: no velocity, to these deviations in m/s and rad/s.
    pub(crate) fn standstill(state: &State, speed: f64, rate: f64) -> Innovation<3> {
        let mut by_state = [[0.0; SIZE]; 3];
        for (row, at) in by_state.iter_mut().zip([VX, VY, RATE]) {
            row[at] = 1.0;
        }
        let (speed, rate) = (speed * speed, rate * rate);
        Innovation {
            difference: [-state.vx, -state.vy, -state.rate],
            covariance: [[speed, 0.0, 0.0], [0.0, speed, 0.0], [0.0, 0.0, rate]],
            by_state,
        }
    }
}

impl Heading {
    pub(crate) fn innovation(&self, state: &State) -> Innovation<1> {
        let mut by_state = [[0.0; SIZE]];
        by_state[0][YAW] = 1.0;
        Innovation {
            difference: [normalize(self.yaw - state.yaw)],
            covariance: [[self.variance]],
            by_state,
        }
    }
}

impl Position {
    pub(crate) fn innovation(&self, state: &State) -> Innovation<2> {
        let (sin, cos) = libm::sincos(state.yaw);
        let [ahead, left] = self.antenna;
        let (dx, dy) = (cos * ahead - sin * left, sin * ahead + cos * left);
        let mut by_state = [[0.0; SIZE]; 2];
        (by_state[0][X], by_state[0][YAW]) = (1.0, -dy);
        (by_state[1][Y], by_state[1][YAW]) = (1.0, dx);
        Innovation {
            difference: [self.position[0] - state.x - dx, self.position[1] - state.y - dy],
            covariance: self.covariance,
            by_state,
        }
    }
}

impl Place {
    pub(crate) fn innovation(&self, state: &State) -> Innovation<3> {
        let mut by_state = [[0.0; SIZE]; 3];
        for (row, at) in by_state.iter_mut().zip([X, Y, YAW]) {
            row[at] = 1.0;
        }
        let [x, y, yaw] = self.pose;
        Innovation {
            difference: [x - state.x, y - state.y, normalize(yaw - state.yaw)],
            covariance: self.covariance,
            by_state,
        }
    }
}
