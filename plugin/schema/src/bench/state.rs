//! The simulated application around the schema on the bench: values, children, time, authority.

use core::time::Duration;

use jde_abi::describe::{Role, Schema, Type};
use jde_abi::finite::Finite;
use jde_abi::raw;
use jde_core::Policy;
use jde_types::{Checks, Value};

use super::bytes::Bytes;
use super::names::unknown;
use crate::child::State;
use crate::context::Severity;
use crate::level::Case;
use crate::schema::Precondition;

pub(super) struct BenchState {
    pub(super) ports: Vec<PortState>,
    pub(super) children: Vec<ChildState>,
    pub(super) now: Duration,
    pub(super) authority: bool,
    pub(super) real_time: bool,
    pub(super) log: Vec<(Severity, String)>,
    pub(super) reason: Option<String>,
    /// What a call that must change nothing (drawing, saving, restoring, inspecting) tried to change. `None`
    /// outside such calls.
    pub(super) drawing: Option<Vec<&'static str>>,
}

pub(super) struct PortState {
    pub(super) port: jde_abi::describe::Port,
    pub(super) bound: bool,
    /// The newest value and its time. `None` before the first value and after a retraction.
    pub(super) newest: Option<(Bytes, Duration)>,
    pub(super) sequence: u64,
    /// The default or neutral value.
    pub(super) initial: Option<Bytes>,
    pub(super) loan: Bytes,
    pub(super) loaned: bool,
}

pub(super) struct ChildState {
    pub(super) motor: bool,
    pub(super) bound: bool,
    pub(super) state: State,
    pub(super) precondition: Precondition,
    pub(super) faulted: bool,
    pub(super) policy: Option<Policy>,
}

/// The input of an arbitration.
pub(super) struct Snapshot {
    pub(super) case: Case,
    pub(super) candidates: Vec<raw::Candidate>,
    pub(super) winner: i32,
}

impl BenchState {
    pub(super) fn new(about: &Schema) -> Self {
        let port = |port: &jde_abi::describe::Port| PortState {
            bound: true,
            newest: None,
            sequence: 0,
            initial: match &port.role {
                Role::Modulation { default: initial, .. } | Role::Command { neutral: initial, .. } => {
                    Some(Bytes::copy(&port.value_type, initial))
                }
                Role::Import | Role::Export { .. } | Role::Actuator | Role::ChildModulation { .. } => None,
            },
            loan: Bytes::zeros(port.value_type.bytes),
            loaned: false,
            port: port.clone(),
        };
        Self {
            ports: about.ports.iter().map(port).collect(),
            children: Self::sleeping_children(about),
            now: Duration::ZERO,
            authority: true,
            real_time: true,
            log: Vec::new(),
            reason: None,
            drawing: None,
        }
    }

    /// The children of the schema, all asleep.
    pub(super) fn sleeping_children(about: &Schema) -> Vec<ChildState> {
        let child = |child: &jde_abi::describe::Child| ChildState {
            motor: child.motor,
            bound: true,
            state: State::Slept,
            precondition: false.into(),
            faulted: false,
            policy: None,
        };
        about.children.iter().map(child).collect()
    }

    /// Returns the reason why every host refuses a value of an input, as an `Err`. A measurement may be anything.
    pub(super) fn check_value(&self, port: usize, bytes: &[u8]) -> Result<(), String> {
        let port = &self.ports[port].port;
        let (what, limits) = match &port.role {
            Role::Modulation { limits, .. } => ("a modulation", Some(limits)),
            Role::Command { .. } => ("a command", None),
            Role::Import | Role::Export { .. } | Role::Actuator | Role::ChildModulation { .. } => {
                return Ok(());
            }
        };
        if !is_finite(&port.value_type, bytes) {
            return Err(format!("is not finite, and {what} is"));
        }
        let checked = limits.map_or(Ok(()), |limits| limits.check(&port.value_type, bytes));
        checked.map_err(|not_allowed| not_allowed.words(&port.unit))
    }

    pub(super) fn put(&mut self, port: usize, value: &[u8]) {
        let now = self.now;
        let port = &mut self.ports[port];
        port.bound = true;
        let value = Bytes::copy(&port.port.value_type, value);
        // As in an application, what is no measurement ends the value before it, and that is said.
        let checks = Checks::of(&port.port.value_type);
        if let Some(Err(why)) = checks.map(|checks| (checks.measured)(value.as_slice())) {
            port.newest = None;
            let words = format!("import `{}` has no value: {why}", port.port.name);
            self.log.push((Severity::Warn, words));
            return;
        }
        port.newest = Some((value, now));
        port.sequence += 1;
    }

    /// Refuses a change if the present call must change nothing, and records the attempt.
    pub(super) fn refuse(&mut self, what: &'static str) -> Result<(), i32> {
        let drawing = self.drawing.as_mut().map(|tried| tried.push(what));
        drawing.map_or(Ok(()), |()| Err(raw::REFUSED))
    }

    pub(super) fn unbind(&mut self, port: usize) {
        self.ports[port].bound = false;
    }

    /// Unbinds a child and its modulations.
    pub(super) fn unbind_child(&mut self, unbound: usize) {
        self.children[unbound].bound = false;
        for port in &mut self.ports {
            if matches!(port.port.role, Role::ChildModulation { child } if child == unbound) {
                port.bound = false;
            }
        }
    }

    /// Returns a child, or the code of a refusal.
    pub(super) fn bound_child(&mut self, child: u32) -> Result<&mut ChildState, i32> {
        let child = self.children.get_mut(child as usize).ok_or(raw::BAD_ARGUMENT)?;
        if child.bound { Ok(child) } else { Err(raw::UNBOUND) }
    }

    /// Returns a child that the schema is about to change, or the code of a refusal.
    pub(super) fn child_to_change(&mut self, child: u32, what: &'static str) -> Result<&mut ChildState, i32> {
        self.refuse(what)?;
        let authority = self.authority;
        let child = self.bound_child(child)?;
        if authority { Ok(child) } else { Err(raw::REFUSED) }
    }

    pub(super) fn written<T: Value>(&self, port: usize) -> Option<T> {
        self.written_in_place(port).copied()
    }

    pub(super) fn written_in_place<T: Value>(&self, port: usize) -> Option<&T> {
        self.ports[port]
            .newest
            .as_ref()
            .map(|(bytes, _)| bytes.as_value())
    }

    pub(super) fn written_at(&self, port: usize) -> Option<Duration> {
        self.ports[port].newest.as_ref().map(|(_, time)| *time)
    }

    pub(super) fn set_child(&mut self, child: usize, state: State) {
        let child = &mut self.children[child];
        child.state = state;
        child.precondition.ready = matches!(state, State::Ready | State::Winner);
    }

    pub(super) fn forget_commands(&mut self) {
        for port in self
            .ports
            .iter_mut()
            .filter(|port| matches!(port.port.role, Role::Actuator))
        {
            port.newest = None;
        }
    }

    pub(super) fn drop_loans(&mut self) {
        self.ports.iter_mut().for_each(|port| port.loaned = false);
    }

    /// Retracts the newest value of an export.
    pub(super) fn retract_export(&mut self, port: usize) -> Result<(), i32> {
        match self.ports.get_mut(port) {
            Some(port) if matches!(port.port.role, Role::Export { .. }) => {
                port.newest = None;
                Ok(())
            }
            _ => Err(raw::BAD_ARGUMENT),
        }
    }

    /// Publishes the loaned value as the newest one.
    pub(super) fn publish_loan(&mut self, port: usize, time_ns: u64) -> Result<(), i32> {
        let (now, authority) = (self.now, self.authority);
        let port = self.ports.get_mut(port).filter(|port| port.loaned);
        let port = port.ok_or(raw::BAD_ARGUMENT)?;
        port.loaned = false;
        let guarded = !matches!(port.port.role, Role::Export { .. });
        if guarded && !authority {
            return Err(raw::REFUSED);
        }
        if guarded && !is_finite(&port.port.value_type, port.loan.as_slice()) {
            return Err(raw::NOT_FINITE);
        }
        let time = if time_ns == 0 {
            now
        } else {
            Duration::from_nanos(time_ns)
        };
        port.newest = Some((Bytes::copy(&port.port.value_type, port.loan.as_slice()), time));
        port.sequence += 1;
        Ok(())
    }

    pub(super) fn snapshot(&self, about: &Schema, group: &str) -> Snapshot {
        let roles = about.children.iter().zip(&self.children).enumerate();
        let members: Vec<_> = roles
            .filter(|(_, (role, _))| role.motor && role.group == group)
            .collect();
        if members.is_empty() {
            let groups = about.children.iter().filter(|role| role.motor);
            unknown("group", group, groups.map(|role| &*role.group));
        }
        let awake = members
            .iter()
            .filter(|(_, (_, child))| child.state != State::Slept);
        let candidates: Vec<_> = awake
            .map(|&(index, (_, child))| raw::Candidate {
                size: size_of::<raw::Candidate>() as u32,
                child: index as u32,
                state: child.state.code(),
                ready: u32::from(child.precondition.ready),
                urgency: child.precondition.urgency,
            })
            .collect();
        let case = match candidates.iter().filter(|candidate| candidate.ready != 0).count() {
            0 => Case::Absence,
            1 => panic!("exactly one child of `{group}` is ready, so the host does not arbitrate"),
            _ => Case::Collision,
        };
        let winner = candidates.iter().find(|candidate| candidate.state == raw::WINNER);
        Snapshot {
            case,
            winner: winner.map_or(-1, |winner| winner.child.cast_signed()),
            candidates,
        }
    }
}

/// Whether every float of a value is finite.
fn is_finite(value_type: &Type, bytes: &[u8]) -> bool {
    Finite::new(value_type).first_not_finite(bytes).is_none()
}
