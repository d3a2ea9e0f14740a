//! What instances request of the host during a call: their children, their names, their log.

use std::collections::BTreeSet;
use std::sync::atomic::Ordering;

use jde_abi::describe::Role;
use jde_abi::raw;
use jde_app::{Application, Binding, ChildTarget, RoleId};
use jde_board::Refused;
use jde_core::{GroupId, Policy, SchemaId, State};
use jde_records::event::What;
use jde_records::turn::{FatherOperation, Moment, Turn, TurnKind};
use parking_lot::MutexGuard;

use super::Engine;
use crate::instance::NoValue;

/// A father's request for a child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ChildRequest {
    pub(crate) father: SchemaId,
    pub(crate) role: RoleId,
    pub(crate) child: SchemaId,
    pub(crate) awake: bool,
}

/// What a father does within a call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FatherAction {
    /// It wakes a child or puts it to sleep.
    Child(ChildRequest),
    /// It changes the policy of a group.
    Policy {
        father: SchemaId,
        group: GroupId,
        policy: Policy,
    },
}

impl FatherAction {
    /// Returns the action as turns have it.
    pub(crate) fn operation(&self) -> FatherOperation {
        match *self {
            Self::Child(ChildRequest {
                child, awake: true, ..
            }) => FatherOperation::Woke {
                child: child.0.into(),
            },
            Self::Child(ChildRequest {
                child, awake: false, ..
            }) => FatherOperation::PutToSleep {
                child: child.0.into(),
            },
            Self::Policy { group, .. } => FatherOperation::ChangedPolicy {
                group: group.0.into(),
            },
        }
    }
}

impl Engine {
    /// Wakes a child or puts it to sleep for its father. Returns a status of the ABI.
    pub(crate) fn request_child(&self, father: SchemaId, role: RoleId, awake: bool) -> i32 {
        let child = match self.child_of_role(father, role) {
            Ok(child) => child,
            Err(status) => return status,
        };
        let request = ChildRequest {
            father,
            role,
            child,
            awake,
        };
        if let Some(deferred) = &mut *self.deferred_actions() {
            deferred.push(FatherAction::Child(request));
            let may = self.rules.read(|rules| rules.hierarchy.has_authority(father));
            return if may { raw::OK } else { raw::REFUSED };
        }
        self.apply_child_request(request)
    }

    /// Carries out a father's request for a child at once.
    pub(crate) fn apply_child_request(&self, request: ChildRequest) -> i32 {
        let ChildRequest {
            father,
            role,
            child,
            awake,
        } = request;
        let (result, moment) = self.rules.transact_if_any(|transaction| {
            if awake {
                transaction.wake(father, child)
            } else {
                transaction.sleep(father, child)
            }
        });
        self.record_father_action(father, &FatherAction::Child(request), moment);
        match result {
            Ok(()) => {
                self.refused_requests().remove(&(father, role));
                raw::OK
            }
            // The request is kept, and takes effect when the operator releases the child (R14).
            Err(jde_core::Refused::Stopped { .. }) => raw::REFUSED,
            Err(refused) => {
                let first = self.refused_requests().insert((father, role));
                self.count_refusal(father, first, || refused.to_string());
                raw::REFUSED
            }
        }
    }

    /// From now on, requests of fathers are collected.
    pub(crate) fn defer_actions(&self) {
        *self.deferred_actions() = Some(Vec::new());
    }

    /// Returns the collected requests. From now on they are carried out at once again.
    pub(crate) fn take_deferred_actions(&self) -> Vec<FatherAction> {
        self.deferred_actions().take().unwrap_or_default()
    }

    /// State of a child, and whether it is faulted.
    pub(crate) fn child_status(&self, father: SchemaId, role: RoleId) -> Result<(State, bool), i32> {
        let child = self.child_of_role(father, role)?;
        let requested = self.deferred_actions().as_ref().and_then(|deferred| {
            let mut requested = deferred.iter().rev();
            requested.find_map(|action| match action {
                FatherAction::Child(request) if request.child == child => Some(request.awake),
                FatherAction::Child(_) | FatherAction::Policy { .. } => None,
            })
        });
        let (current, faulted) = self.rules.read(|rules| {
            let faulted = matches!(rules.hierarchy.health(child), jde_core::Health::Faulted(_));
            (rules.hierarchy.state(child), faulted)
        });
        let state = match (requested, current) {
            // The father sees the result of its collected request.
            (Some(true), State::Slept) if !faulted => State::Checking,
            (Some(false), _) => State::Slept,
            (Some(true) | None, state) => state,
        };
        Ok((state, faulted))
    }

    fn deferred_actions(&self) -> MutexGuard<'_, Option<Vec<FatherAction>>> {
        self.deferred_actions.lock()
    }

    /// Changes the policy of the group in which that child competes, for the father.
    pub(crate) fn set_policy(&self, father: SchemaId, role: RoleId, policy: Policy) -> i32 {
        if let Err(status) = self.child_of_role(father, role) {
            return status;
        }
        let Some(Some(group)) = self.application.instances[father].child_groups.get(role).copied() else {
            return raw::BAD_ARGUMENT;
        };
        let action = FatherAction::Policy {
            father,
            group,
            policy,
        };
        if let Some(deferred) = &mut *self.deferred_actions() {
            deferred.push(action);
            return raw::OK;
        }
        self.apply_father_action(action)
    }

    /// Carries out a father's request at once. Returns a status of the ABI.
    pub(crate) fn apply_father_action(&self, action: FatherAction) -> i32 {
        let (father, group, policy) = match action {
            FatherAction::Child(request) => return self.apply_child_request(request),
            FatherAction::Policy {
                father,
                group,
                policy,
            } => (father, group, policy),
        };
        let (changed, moment) = self
            .rules
            .transact_if_any(|transaction| transaction.set_policy(group, policy));
        self.record_father_action(father, &action, moment);
        if changed.is_err() {
            return raw::BAD_ARGUMENT;
        }
        self.rules.renew_contract(group);
        raw::OK
    }

    /// Records a father's request as a turn, if it had effects.
    fn record_father_action(&self, father: SchemaId, action: &FatherAction, moment: Moment) {
        if let Some(journal) = self.journal.as_ref().filter(|_| moment.order > 0) {
            let mut turn = Turn::new(TurnKind::FatherActed(action.operation()), father);
            turn.checked = moment;
            journal.forward(&turn);
        }
    }

    /// Reports a refused command (R7), or a command or a child's modulation that was not finite or out of
    /// range.
    pub(crate) fn report_refused_write(&self, instance: SchemaId, port: usize, why: &Refused, first: bool) {
        self.count_refusal(instance, first, || {
            let field = matches!(why, Refused::NotFinite).then(|| self.not_finite_at(instance, port));
            let port = &self.application.instances[instance].schema.ports[port];
            let kind = match port.role {
                Role::ChildModulation { .. } => "modulation",
                Role::Import
                | Role::Export { .. }
                | Role::Modulation { .. }
                | Role::Command { .. }
                | Role::Actuator => "command",
            };
            let field = field.flatten().map(|field| format!(": `{field}`"));
            format!(
                "{kind} `{}` refused: {why}{}",
                port.name,
                field.unwrap_or_default()
            )
        });
    }

    /// Reports an export whose published value is none.
    pub(crate) fn report_no_value(&self, instance: SchemaId, port: usize, why: &NoValue, first: bool) {
        self.count_refusal(instance, first, || {
            let port = &self.application.instances[instance].schema.ports[port];
            format!("export `{}` retracted: {why}", port.name)
        });
    }

    /// The field that was not finite in the last write of a port.
    fn not_finite_at(&self, instance: SchemaId, port: usize) -> Option<String> {
        let target = match self.application.instances[instance].bindings[port] {
            Binding::Actuator { target } => target,
            Binding::ChildModulation {
                target: Some(ChildTarget::Port(modulation)),
            } => Some(modulation),
            Binding::ChildModulation { .. }
            | Binding::Import { .. }
            | Binding::Export
            | Binding::Modulation { .. }
            | Binding::Command => None,
        };
        let target = target?;
        self.variables.of(target)?.not_finite_at()
    }

    /// A number that depends only on the application's seed and the instance's name.
    pub(crate) fn seed_of(&self, instance: SchemaId) -> u64 {
        seed_of(&self.application, instance)
    }

    /// Logs a plugin's message under the instance's name.
    pub(crate) fn log(&self, instance: SchemaId, level: u32, text: &str) {
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
    fn count_refusal(&self, instance: SchemaId, first: bool, what: impl FnOnce() -> String) {
        self.metrics[instance].refused.fetch_add(1, Ordering::Relaxed);
        if !first {
            return;
        }
        let what = what();
        tracing::debug!(schema = self.name(instance), "{what}");
        self.rules.report_now(What::Refused {
            schema: instance,
            description: what,
            retry: None,
        });
    }

    fn refused_requests(&self) -> MutexGuard<'_, BTreeSet<(SchemaId, RoleId)>> {
        self.refused_requests.lock()
    }

    fn child_of_role(&self, father: SchemaId, role: RoleId) -> Result<SchemaId, i32> {
        let children = &self.application.instances[father].children;
        children.get(role).ok_or(raw::BAD_ARGUMENT)?.ok_or(raw::UNBOUND)
    }
}

/// A number that depends only on the application's seed and the instance's name (FNV-1a, Fowler, Noll, Vo).
pub(super) fn seed_of(application: &Application, instance: SchemaId) -> u64 {
    let start = 0xcbf2_9ce4_8422_2325_u64;
    let name = application.instances[instance].name.bytes();
    let bytes = application.seed.to_le_bytes().into_iter().chain(name);
    bytes.fold(start, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
