//! No motion without somebody who may move: the simulated robot slows down as its brakes allow from the instant at which no
//! command is in force any more, and stands.

use std::collections::BTreeMap;

use jde_core::Nanos;
use jde_host::Handle;
use jde_types::{Truth, Value};

use super::commands::Commands;
use super::{Known, Tamper};
use crate::case::Clock;

/// What a P3-DX of the simulator loses of its speed in a second, m/s (`jde describe sim`).
const BRAKE: f64 = 0.3;
/// The same of turning, rad/s: 100 degrees.
const TURN_BRAKE: f64 = 1.745;
/// Two periods of the robot's driver: until one has carried out what is in force now.
const CARRIES_OUT: Nanos = 100_000_000;
/// Two periods of the device.
const DEVICE_CARRIES_OUT: Nanos = 40_000_000;
/// More, where others need the processor too.
const SLACK: Nanos = 250_000_000;
/// What counts as standing, m/s and rad/s: wheels slip by less.
const STANDS: f64 = 0.02;

/// A speed that nothing has, m/s: for a lie.
const UNSEEN: f64 = 9.0;

/// How everything that moves was when it was last driven.
#[derive(Default)]
pub(super) struct Motion {
    last: BTreeMap<&'static str, Driven>,
}

#[derive(Clone, Copy, Default)]
struct Driven {
    at: Nanos,
    linear: f64,
    angular: f64,
}

impl Motion {
    pub(super) fn judge(&mut self, known: &mut Known, commands: &Commands, handle: &Handle, now: Nanos) {
        let slack = if known.clock == Clock::Lockstep { 0 } else { SLACK };
        let last = self.last.entry("pioneer").or_default();
        let driven = commands.is_driven("pioneer", now);
        if driven {
            last.at = now;
        }
        if let Some(truth) = fresh::<Truth>(handle, "pioneer.truth", now, CARRIES_OUT + slack) {
            let (mut linear, angular) = (truth.twist.linear.x.abs(), truth.twist.angular.z.abs());
            if driven {
                (last.linear, last.angular) = (linear, angular);
            } else {
                let idle = now.saturating_sub(last.at);
                let braked = idle.saturating_sub(CARRIES_OUT + slack) as f64 / 1e9;
                // What it went on to be in the meantime, by the last command: at most what it can gain.
                let gained = CARRIES_OUT.saturating_add(slack) as f64 / 1e9;
                let may = (last.linear + BRAKE * gained - BRAKE * braked).max(0.0) + STANDS;
                let may_turn = (last.angular + TURN_BRAKE * gained - TURN_BRAKE * braked).max(0.0) + STANDS;
                if known.tampers(Tamper::Motion) {
                    linear += UNSEEN;
                }
                if linear > may || angular > may_turn {
                    known.tell(format!(
                        "motion: the robot moves at {linear:.2} m/s and {angular:.2} rad/s, {:.3} s after its last command, at {:.6} s",
                        idle as f64 / 1e9,
                        now as f64 / 1e9
                    ));
                }
            }
        }
        for device in ["arm", "gripper"] {
            let last = self.last.entry(device).or_default();
            if commands.is_driven(device, now) {
                last.at = now;
                continue;
            }
            let age = DEVICE_CARRIES_OUT + slack;
            let moves = fresh::<f64>(handle, &format!("{device}.moves"), now, age).unwrap_or(0.0);
            if moves.abs() > STANDS && now.saturating_sub(last.at) > age {
                known.tell(format!(
                    "motion: `{device}` moves at {moves:.2} although no command is in force, at {:.6} s",
                    now as f64 / 1e9
                ));
            }
        }
    }
}

/// What a driver says, unless it is old: the world of a driver that sleeps stands still, and so does what it last said.
fn fresh<T: Value>(handle: &Handle, variable: &str, now: Nanos, age: Nanos) -> Option<T> {
    let mut reader = handle.board().find(variable)?.reader("faults");
    let latched = reader.latch().filter(|latched| latched.stamp.time + age >= now)?;
    T::from_bytes(latched.bytes)
}
