//! Checks that nothing moves without authority, and that a guarded robot touches nothing (R18). When no command is in force any more, the simulated robot
//! must slow down at its braking rate and stop.

use std::collections::BTreeMap;

use jde_core::Nanos;
use jde_host::Handle;
use jde_types::{Truth, Value};

use super::commands::Commands;
use super::{ObserverState, Tamper};
use crate::case::RunMode;

/// Deceleration of the simulator's P3-DX, m/s² (`jde describe sim`).
const DECELERATION: f64 = 0.3;
/// Angular deceleration, rad/s²: 100 degrees per second squared.
const TURN_BRAKE: f64 = 1.745;
/// Two periods of the robot's driver, ns: until the current command has taken effect.
const ROBOT_DELAY: Nanos = 100_000_000;
/// Two periods of the device, ns.
const DEVICE_DELAY: Nanos = 40_000_000;
/// Additional time under load, ns.
const LOAD_SLACK: Nanos = 250_000_000;
/// Speed that counts as standing, m/s and rad/s: wheels slip by less.
const STANDSTILL_SPEED: f64 = 0.02;

/// An impossible speed, m/s, for a test of the observer.
const FALSE_SPEED: f64 = 9.0;

/// The state of each robot and device when it was last driven.
#[derive(Default)]
pub(super) struct Motion {
    /// The contacts of the robot so far.
    collisions: u64,
    last: BTreeMap<&'static str, LastSpeeds>,
}

#[derive(Clone, Copy, Default)]
struct LastSpeeds {
    at: Nanos,
    linear: f64,
    angular: f64,
}

impl Motion {
    pub(super) fn judge(
        &mut self,
        state: &mut ObserverState,
        commands: &Commands,
        handle: &Handle,
        now: Nanos,
    ) {
        let slack = if state.clock == RunMode::Lockstep {
            0
        } else {
            LOAD_SLACK
        };
        let last = self.last.entry("pioneer").or_default();
        let driven = commands.is_driven("pioneer", now);
        if driven {
            last.at = now;
        }
        if let Some(truth) = fresh::<Truth>(handle, "pioneer.truth", now, ROBOT_DELAY + slack) {
            let collisions = truth.collisions + u64::from(state.take_tamper(Tamper::Collision));
            let is_guarded = handle
                .application()
                .groups
                .iter()
                .any(|group| group.guard.is_some());
            if is_guarded && collisions > self.collisions {
                state.report(format!(
                    "R18: the robot is guarded, and touches something at {:.2} m, {:.2} m, at {:.6} s",
                    truth.pose.x,
                    truth.pose.y,
                    now as f64 / 1e9
                ));
            }
            self.collisions = collisions;
            let (mut linear, angular) = (truth.twist.linear.x.abs(), truth.twist.angular.z.abs());
            if driven {
                (last.linear, last.angular) = (linear, angular);
            } else {
                let idle = now.saturating_sub(last.at);
                let braking_time = idle.saturating_sub(ROBOT_DELAY + slack) as f64 / 1e9;
                // The last command may have increased the speed in the meantime, by at most the acceleration.
                let acceleration_time = ROBOT_DELAY.saturating_add(slack) as f64 / 1e9;
                let allowed = (last.linear + DECELERATION * acceleration_time - DECELERATION * braking_time)
                    .max(0.0)
                    + STANDSTILL_SPEED;
                let allowed_turn =
                    (last.angular + TURN_BRAKE * acceleration_time - TURN_BRAKE * braking_time).max(0.0)
                        + STANDSTILL_SPEED;
                if state.take_tamper(Tamper::Motion) {
                    linear += FALSE_SPEED;
                }
                if linear > allowed || angular > allowed_turn {
                    state.report(format!(
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
            let age = DEVICE_DELAY + slack;
            let moves = fresh::<f64>(handle, &format!("{device}.moves"), now, age).unwrap_or(0.0);
            if moves.abs() > STANDSTILL_SPEED && now.saturating_sub(last.at) > age {
                state.report(format!(
                    "motion: `{device}` moves at {moves:.2} although no command is in force, at {:.6} s",
                    now as f64 / 1e9
                ));
            }
        }
    }
}

/// Returns the value of a driver's export, unless it is old: while a driver sleeps, neither its world nor its
/// export changes.
fn fresh<T: Value>(handle: &Handle, variable: &str, now: Nanos, age: Nanos) -> Option<T> {
    let mut reader = handle.board().find(variable)?.reader("faults");
    let latched = reader
        .latch(now)
        .filter(|latched| latched.stamp.time + age >= now)?;
    T::from_bytes(latched.bytes)
}
