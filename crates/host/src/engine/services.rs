//! What instances request of the host during a call: their children, their names, their log.

use std::sync::atomic::Ordering;
use std::sync::{MutexGuard, PoisonError};

use jde_abi::describe::Role;
use jde_abi::raw;
use jde_board::Refused;
use jde_core::{Policy, State};

use super::{Engine, schema};
use crate::event::Event;
use crate::turn::{Moment, Turn};

/// A father's request for a child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lead {
    pub(crate) father: usize,
    pub(crate) role: usize,
    pub(crate) child: usize,
    pub(crate) awake: bool,
}

/// What a father does within a call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Led {
    /// It wakes a child or puts it to sleep.
    Child(Lead),
    /// It changes the policy of a group.
    Policy {
        father: usize,
        group: usize,
        policy: Policy,
    },
}

impl Led {
    /// The encoding in turns: the way, and the number of the child or group.
    pub(crate) fn told(&self) -> (u8, u64) {
        match *self {
            Self::Child(Lead {
                child, awake: true, ..
            }) => (Turn::WOKE, child as u64),
            Self::Child(Lead {
                child, awake: false, ..
            }) => (Turn::LAID_DOWN, child as u64),
            Self::Policy { group, .. } => (Turn::CHANGED_POLICY, group as u64),
        }
    }
}

impl Engine {
    /// Wakes a child or puts it to sleep for its father. Returns a status of the ABI.
    pub(crate) fn child_wakes(&self, father: usize, role: usize, awake: bool) -> i32 {
        let child = match self.role(father, role) {
            Ok(child) => child,
            Err(status) => return status,
        };
        let lead = Lead {
            father,
            role,
            child,
            awake,
        };
        if let Some(later) = &mut *self.later() {
            later.push(Led::Child(lead));
            let may = self.lock().hierarchy.has_authority(schema(father));
            return if may { raw::OK } else { raw::REFUSED };
        }
        self.lead(lead)
    }

    /// Carries out a father's request for a child at once.
    pub(crate) fn lead(&self, lead: Lead) -> i32 {
        let Lead {
            father,
            role,
            child,
            awake,
        } = lead;
        let (result, moment) = self.transact_if_any(|hierarchy, now, out| {
            if awake {
                hierarchy.wake(now, schema(father), schema(child), out)
            } else {
                hierarchy.sleep(now, schema(father), schema(child), out)
            }
        });
        self.tell_led(father, &Led::Child(lead), moment);
        match result {
            Ok(()) => {
                self.lock().unheard.remove(&(father, role));
                raw::OK
            }
            Err(refused) => {
                let first = self.lock().unheard.insert((father, role));
                self.count_refusal(father, first, || refused.to_string());
                raw::REFUSED
            }
        }
    }

    /// From now on, requests of fathers are collected.
    pub(crate) fn put_off(&self) {
        *self.later() = Some(Vec::new());
    }

    /// Returns the collected requests. From now on they are carried out at once again.
    pub(crate) fn taken_on(&self) -> Vec<Led> {
        self.later().take().unwrap_or_default()
    }

    /// State of a child, and whether it is faulted.
    pub(crate) fn child(&self, father: usize, role: usize) -> Result<(State, bool), i32> {
        let number = self.role(father, role)?;
        let child = schema(number);
        let asked = self.later().as_ref().and_then(|later| {
            let mut asked = later.iter().rev();
            asked.find_map(|led| match led {
                Led::Child(lead) if lead.child == number => Some(lead.awake),
                Led::Child(_) | Led::Policy { .. } => None,
            })
        });
        let rules = self.lock();
        let faulted = matches!(rules.hierarchy.health(child), jde_core::Health::Faulted(_));
        let state = match (asked, rules.hierarchy.state(child)) {
            // The father sees the result of its collected request.
            (Some(true), State::Slept) if !faulted => State::Checking,
            (Some(false), _) => State::Slept,
            (Some(true) | None, state) => state,
        };
        Ok((state, faulted))
    }

    fn later(&self) -> MutexGuard<'_, Option<Vec<Led>>> {
        self.put_off.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the policy of the group in which that child competes, for the father.
    pub(crate) fn set_policy(&self, father: usize, role: usize, policy: Policy) -> i32 {
        if let Err(status) = self.role(father, role) {
            return status;
        }
        let Some(Some(group)) = self.application.instances[father].child_groups.get(role).copied() else {
            return raw::BAD_ARGUMENT;
        };
        let led = Led::Policy {
            father,
            group,
            policy,
        };
        if let Some(later) = &mut *self.later() {
            later.push(led);
            return raw::OK;
        }
        self.carry_on(led)
    }

    /// Carries out a father's request at once. Returns a status of the ABI.
    pub(crate) fn carry_on(&self, led: Led) -> i32 {
        let (father, group, policy) = match led {
            Led::Child(lead) => return self.lead(lead),
            Led::Policy {
                father,
                group,
                policy,
            } => (father, group, policy),
        };
        let (changed, moment) = self.transact_if_any(|hierarchy, now, out| {
            hierarchy.set_policy(now, jde_core::GroupId(group as u32), policy, out)
        });
        self.tell_led(father, &led, moment);
        if changed.is_err() {
            return raw::BAD_ARGUMENT;
        }
        self.renew_contract(jde_core::GroupId(group as u32));
        raw::OK
    }

    /// Records a father's request as a turn, if it had effects.
    fn tell_led(&self, father: usize, led: &Led, moment: Moment) {
        if let Some(journal) = self.journal.as_ref().filter(|_| moment.order > 0) {
            let (way, detail) = led.told();
            journal.tell(&Turn {
                way,
                detail,
                checked: moment,
                ..Turn::of(Turn::LED, father)
            });
        }
    }

    /// Reports a refused command (R7), or a command or a child's modulation that was not finite or out of
    /// range.
    pub(crate) fn write_refused(&self, instance: usize, port: usize, why: &Refused, first: bool) {
        self.count_refusal(instance, first, || {
            let port = &self.application.instances[instance].schema.ports[port];
            let kind = match port.role {
                Role::ChildModulation { .. } => "modulation",
                Role::Import { .. }
                | Role::Export
                | Role::Modulation { .. }
                | Role::Command { .. }
                | Role::Actuator => "command",
            };
            format!("{kind} `{}` refused: {why}", port.name)
        });
    }

    /// A number that depends only on the application's seed and the instance's name (FNV-1a, Fowler, Noll,
    /// Vo).
    pub(crate) fn seed_of(&self, instance: usize) -> u64 {
        let start = 0xcbf2_9ce4_8422_2325_u64;
        let seed = self.application.seed.to_le_bytes();
        seed.into_iter()
            .chain(self.name(instance).bytes())
            .fold(start, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            })
    }

    /// Logs a plugin's message under the instance's name.
    pub(crate) fn log(&self, instance: usize, level: u32, text: &str) {
        let schema = self.name(instance);
        match level {
            raw::TRACE => tracing::trace!(target: "jde::schema", schema, "{text}"),
            raw::DEBUG => tracing::debug!(target: "jde::schema", schema, "{text}"),
            raw::INFO => tracing::info!(target: "jde::schema", schema, "{text}"),
            raw::WARN => tracing::warn!(target: "jde::schema", schema, "{text}"),
            _ => tracing::error!(target: "jde::schema", schema, "{text}"),
        }
    }

    /// Counts a refusal, and reports only the first of consecutive ones.
    fn count_refusal(&self, instance: usize, first: bool, what: impl FnOnce() -> String) {
        self.meters[instance].refused.fetch_add(1, Ordering::Relaxed);
        if !first {
            return;
        }
        let what = what();
        tracing::debug!(schema = self.name(instance), "{what}");
        let mut rules = self.lock();
        let time = self.clock.now();
        self.tell(
            &mut rules,
            &Event::Refused {
                time,
                schema: instance,
                what,
            },
        );
    }

    fn role(&self, father: usize, role: usize) -> Result<usize, i32> {
        let children = &self.application.instances[father].children;
        children.get(role).ok_or(raw::BAD_ARGUMENT)?.ok_or(raw::UNBOUND)
    }
}
