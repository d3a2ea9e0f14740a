//! Whether what an export is about to publish is a value: what measures nothing or contradicts itself is none, and
//! neither is what a sensor repeats while its base moves, or an odometry while its base should. It ends the value before
//! it; it never changes one.

use std::f64::consts::FRAC_PI_2;
use std::fmt;
use std::sync::Arc;

use jde_board::{Nanos, Reader, Variable};
use jde_types::{Checks, Odometry, Pose2D, Repeats, Unmeasured, Value};

use super::bound_port::{BoundPort, PortError};
use super::ports::Ports;
use super::unmoved::Unmoved;

/// A motion of the base after which a sensor of the surroundings measures something else, m and rad: many times the
/// errors of an odometry over the time of a few measurements.
pub(super) const MOVED: f64 = 0.1;
/// A step of the odometry from one publication to the next that is no motion, m; and neither is more than a quarter turn.
const MAX_STEP: f64 = 1.0;

/// The exports of an instance that measure something, by port.
#[derive(Default)]
pub(crate) struct Measurements(Vec<(usize, Measurement)>);

struct Measurement {
    checks: Checks,
    repetition: Option<Repetition>,
    /// Of the odometry of a driver.
    unmoved: Option<Unmoved>,
    /// Whether the last publication was no value.
    is_none: bool,
}

/// Compares what a sensor of the surroundings publishes with what it published before.
struct Repetition {
    repeats: Repeats,
    /// The variable itself.
    before: Reader,
    odometry: Reader,
    /// What it repeats, while that is no value.
    repeated: Option<Vec<u8>>,
    /// The pose of the base at the last publication, and when the content changed last.
    poses: Option<(Pose2D, Pose2D)>,
}

/// Why a publication is no value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NoValue {
    Unmeasured(Unmeasured),
    /// Of a sensor of the surroundings.
    Repeated,
    /// Of an odometry, which states a velocity.
    Stated,
    /// Of an odometry, while the base is commanded to move.
    Unanswered,
}

/// For people, after the name of the export.
impl fmt::Display for NoValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unmeasured(why) => why.fmt(f),
            Self::Repeated => f.write_str("it repeats itself although the base moves"),
            Self::Stated => f.write_str("it repeats itself although it states a velocity"),
            Self::Unanswered => f.write_str(
                "it repeats itself although the base is commanded to move: the base is blocked or off, or the odometry is frozen",
            ),
        }
    }
}

impl Measurements {
    /// Adds an export, if its type is one of measurements. `odometry` is that of the base on which the sensor is. If the
    /// export itself is that, `commands` are those of its driver.
    pub(crate) fn add<'a>(
        &mut self,
        port: usize,
        variable: &Arc<Variable>,
        odometry: Option<&Arc<Variable>>,
        commands: impl Iterator<Item = &'a Arc<Variable>>,
    ) {
        let Some(checks) = Checks::of(&variable.describe().value_type) else {
            return;
        };
        let repetition = checks
            .repeats
            .zip(odometry)
            .map(|(repeats, odometry)| Repetition {
                repeats,
                before: variable.reader("host"),
                odometry: odometry.reader("host"),
                repeated: None,
                poses: None,
            });
        let is_odometry = odometry.is_some_and(|odometry| Arc::ptr_eq(odometry, variable));
        self.0.push((
            port,
            Measurement {
                checks,
                repetition,
                unmoved: is_odometry.then(|| Unmoved::new(commands)),
                is_none: false,
            },
        ));
    }

    /// Whether an instance exports nothing of the kind.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Expects no motion any more: a mock answers no commands.
    pub(super) fn expect_no_motion(&mut self) {
        for (_, measurement) in &mut self.0 {
            measurement.unmoved = None;
        }
    }

    fn of(&mut self, port: usize) -> Option<&mut Measurement> {
        let mut all = self.0.iter_mut();
        all.find(|(number, _)| *number == port).map(|(_, of)| of)
    }
}

impl Ports {
    /// Retracts an export whose loan is no value.
    pub(super) fn judge_measurement(
        &mut self,
        port: usize,
        time: Nanos,
        now: Nanos,
    ) -> Result<(), PortError> {
        let Some(measurement) = self.measurements.of(port) else {
            return Ok(());
        };
        let Some(BoundPort::Output(writer)) = self.ports.get_mut(port) else {
            return Ok(());
        };
        if !writer.is_loaned() {
            return Ok(());
        }
        let Some((why, first)) = measurement.judge(writer.loan(), time, now) else {
            return Ok(());
        };
        writer.discard();
        self.loan_count -= 1;
        self.retract(port)?;
        Err(PortError::NotAValue { why, first })
    }
}

impl Measurement {
    /// Judges what the export is about to publish. Returns why it is no value, and whether that is new.
    fn judge(&mut self, bytes: &[u8], time: Nanos, now: Nanos) -> Option<(NoValue, bool)> {
        let why = match (self.checks.measured)(bytes) {
            Err(why) => Some(NoValue::Unmeasured(why)),
            Ok(()) => {
                let repetition = self.repetition.as_mut();
                let is_frozen = repetition.is_some_and(|repetition| repetition.is_frozen(bytes));
                let unmoved = self.unmoved.as_mut();
                let is_unmoved = unmoved.and_then(|unmoved| unmoved.judge(bytes, time, now));
                is_frozen.then_some(NoValue::Repeated).or(is_unmoved)
            }
        };
        let was_none = std::mem::replace(&mut self.is_none, why.is_some());
        why.map(|why| (why, !was_none))
    }
}

impl Repetition {
    fn is_frozen(&mut self, bytes: &[u8]) -> bool {
        let repeats = match &self.repeated {
            Some(repeated) => (self.repeats)(bytes, repeated),
            None => {
                let before = self.before.latch_newest(0);
                before.is_some_and(|before| (self.repeats)(bytes, before.bytes))
            }
        };
        self.before.release();
        if !repeats {
            self.repeated = None;
        }
        let pose = self.pose();
        let Some(pose) = pose else {
            return self.repeated.is_some();
        };
        let changed_at = match self.poses {
            Some((last, changed_at)) if repeats && is_jump(&last, &pose) => {
                pose.transform(&last.localize(&changed_at))
            }
            Some((_, changed_at)) if repeats => changed_at,
            Some(_) | None => pose,
        };
        self.poses = Some((pose, changed_at));
        let moved = changed_at.localize(&pose);
        if libm::hypot(moved.x, moved.y) > MOVED || moved.theta.abs() > MOVED {
            self.repeated.get_or_insert_with(|| bytes.to_vec());
        }
        self.repeated.is_some()
    }

    fn pose(&mut self) -> Option<Pose2D> {
        let odometry = self.odometry.latch_newest(0);
        let pose = odometry.and_then(|odometry| Some(Odometry::view(odometry.bytes)?.pose2d()));
        self.odometry.release();
        pose
    }
}

fn is_jump(from: &Pose2D, to: &Pose2D) -> bool {
    let step = from.localize(to);
    libm::hypot(step.x, step.y) > MAX_STEP || step.theta.abs() > FRAC_PI_2
}
