//! The exports of an instance that an operator lets fail (R14): what a publication then publishes. An
//! instance without such exports pays one load per publication.

use std::collections::{BTreeMap, VecDeque};
use std::f64::consts::TAU;
use std::slice;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use jde_board::value;
use jde_board::{Nanos, Variable, Writer};
use parking_lot::{Mutex, MutexGuard};

use crate::sensor_fault::{SensorFault, limits, ranges};

/// The failing exports of an instance, by port.
#[derive(Default)]
pub(crate) struct ExportFaults {
    any: AtomicBool,
    /// Locked for a publication only while an export fails.
    active: Mutex<BTreeMap<usize, ActiveFault>>,
}

/// What a publication of a failing export does.
pub(super) enum Publication {
    /// It publishes the loan, measured at this time.
    Loan(Nanos),
    /// It retracts the value before.
    Retraction,
    /// Nothing.
    Nothing,
}

struct ActiveFault {
    fault: SensorFault,
    /// The last value before the failure.
    last: Option<Vec<u8>>,
    /// What was measured since, and when, of an export that is late.
    measured: VecDeque<(Nanos, Vec<u8>)>,
    noise: Noise,
}

/// A sequence of normal numbers, the same on every machine: SplitMix64 (Steele, Lea, Flood 2014) and the
/// transform of Box and Muller (1958).
struct Noise {
    state: u64,
}

impl ExportFaults {
    /// Lets an export fail from the next publication on.
    pub(crate) fn fail(&self, port: usize, variable: &Arc<Variable>, fault: SensorFault, seed: u64) {
        let value_type = &variable.describe().value_type;
        let last = variable
            .reader("host")
            .latch(0)
            .map(|latched| value_type.copy(latched.bytes));
        let noise = Noise { state: seed };
        let mut active = self.active();
        // A failure before it may have retracted the value.
        let before = active.remove(&port).and_then(|before| before.last);
        let last = last.or(before);
        let measured = VecDeque::new();
        active.insert(
            port,
            ActiveFault {
                fault,
                last,
                measured,
                noise,
            },
        );
        self.any.store(true, Ordering::Release);
    }

    /// Ends the failure of an export.
    pub(crate) fn repair(&self, port: usize) {
        let mut active = self.active();
        active.remove(&port);
        self.any.store(!active.is_empty(), Ordering::Release);
    }

    /// Whether any export fails.
    #[inline]
    pub(super) fn any(&self) -> bool {
        self.any.load(Ordering::Acquire)
    }

    /// Changes the value that an export is about to publish, measured at `time`.
    pub(super) fn apply(&self, port: usize, writer: &mut Writer, time: Nanos, now: Nanos) -> Publication {
        let mut active = self.active();
        let Some(ActiveFault {
            fault,
            last,
            measured,
            noise,
        }) = active.get_mut(&port)
        else {
            return Publication::Loan(time);
        };
        let variable = Arc::clone(writer.variable());
        let value_type = &variable.describe().value_type;
        match fault {
            SensorFault::Silent => return Publication::Retraction,
            SensorFault::Frozen => match last {
                Some(last) => value_type.copy_into(last, writer.loan()),
                None => return Publication::Nothing,
            },
            SensorFault::Contradictory => {
                if let Some([least, greatest]) = limits(value_type) {
                    let (head, tail) = writer.loan().split_at_mut(least.max(greatest));
                    head[least.min(greatest)..][..4].swap_with_slice(&mut tail[..4]);
                }
            }
            SensorFault::Late { by } => {
                measured.push_back((time, value_type.copy(writer.loan())));
                let is_old = |(measured_at, _): &(Nanos, Vec<u8>)| measured_at.saturating_add(*by) <= now;
                let late = measured.iter().take_while(|value| is_old(value)).count();
                // Those before it came too late for this publication.
                measured.drain(..late.saturating_sub(1));
                let Some((measured_at, bytes)) = measured.front().filter(|_| late > 0) else {
                    return Publication::Nothing;
                };
                value_type.copy_into(bytes, writer.loan());
                return Publication::Loan(*measured_at);
            }
            SensorFault::Noise { sigma } => {
                let beams = ranges(value_type);
                let fields = beams.map_or(&*value_type.fields, slice::from_ref);
                value::change_floats(fields, writer.loan(), &mut |_, number| {
                    let noisy = number + *sigma * noise.next();
                    match number.is_finite() {
                        true if beams.is_some() => noisy.max(0.0),
                        true => noisy,
                        false => number,
                    }
                });
            }
            SensorFault::Blocked { first, last, range } => {
                let beams = *first as usize..=*last as usize;
                let fields = ranges(value_type).map_or(&[][..], slice::from_ref);
                value::change_floats(fields, writer.loan(), &mut |beam, measured| {
                    if beams.contains(&beam) {
                        f64::from(*range)
                    } else {
                        measured
                    }
                });
            }
        }
        Publication::Loan(time)
    }

    fn active(&self) -> MutexGuard<'_, BTreeMap<usize, ActiveFault>> {
        self.active.lock()
    }
}

impl Noise {
    fn next(&mut self) -> f64 {
        // In (0, 1], so that the logarithm is finite.
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.uniform()));
        radius * libm::cos(TAU * self.uniform())
    }

    /// Returns a number in [0, 1).
    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::Noise;

    #[test]
    fn the_noise_is_normal() {
        let mut noise = Noise { state: 7 };
        let numbers: Vec<f64> = (0..10_000).map(|_| noise.next()).collect();
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / 10_000.0;
        assert!(mean(&mut numbers.iter().copied()).abs() < 0.04);
        assert!((mean(&mut numbers.iter().map(|number| number * number)) - 1.0).abs() < 0.05);
        let within = numbers.iter().filter(|number| number.abs() < 1.0).count();
        assert!(
            (6627..=7027).contains(&within),
            "{within} of 6827 within one sigma"
        );
    }
}
