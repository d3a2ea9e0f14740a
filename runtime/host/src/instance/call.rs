//! One call into an instance, and all that the plugin may request of the host during it, wherever the plugin
//! runs.
//!
//! Results are statuses of the ABI. Requests arrive through [`super::host_table`] or
//! [`super::isolated`].
//!
//! A call that was given up can neither read values nor change state: these requests are refused. Its name,
//! its seed and the time remain available: it may wait for a time, and plugins do not expect the other two to
//! be missing.

use std::ffi::CStr;
use std::sync::Arc;

use jde_abi::raw;
use jde_app::RoleId;
use jde_board::Variable;
use jde_core::{Nanos, SchemaId};
use jde_isolation::launch::Acceptance;
use jde_loader::build::{Build, PortMapping};

use super::Scratch;
use super::bound_port::{Guarded, PortError};
use super::command_limits::CommandLimits;
use super::guard::{CommandInForce, UnjudgedCommand};
use super::port_access::PortAccess;
use super::ports::Ports;
use super::view::View;
use crate::engine::Engine;

/// A call in progress; a [`raw::Context`] points to it.
pub(crate) struct CallContext<'a> {
    pub(crate) engine: &'a Arc<Engine>,
    pub(crate) number: SchemaId,
    pub(crate) name: &'a CStr,
    pub(crate) build: &'a Build,
    pub(super) port_access: &'a PortAccess,
    pub(super) scratch: &'a mut Scratch,
    /// The reason that the plugin set.
    pub(crate) failure: Option<String>,
    /// The result of its first query of the time.
    pub(crate) first_time: Option<Nanos>,
    pub(super) permissions: Permissions,
}

/// What a call may change.
pub(super) enum Permissions {
    /// Whatever its authority allows.
    All,
    /// Its exports: it is put to sleep or woken up while it is replaced.
    ExportsOnly,
    /// Nothing; with the first change that it tried.
    ReadOnly(Option<String>),
}

/// Ports and roles have the numbers of the build.
impl CallContext<'_> {
    /// Shows the value of an input, the same until the ports are released.
    pub(super) fn show<R>(&mut self, port: u32, show: impl FnOnce(&View<'_>) -> R) -> Result<R, i32> {
        let engine = &**self.engine;
        let read = self.port_access.with_ports(|ports| {
            let view = view(self.build, ports, port, || engine.clock.now());
            let shown = view.map(|view| show(&view)).map_err(|error| status(&error));
            (shown, ports.take_refusal())
        });
        let (shown, refusal) = read.ok_or(raw::REFUSED)?;
        if let Some(refusal) = refusal {
            engine.report_refusal(&refusal);
        }
        shown
    }

    /// Like [`Self::show`], before the plugin reads the input. `None` if it must not be shown early.
    pub(super) fn show_early<R>(
        &mut self,
        port: u32,
        show: impl FnOnce(&View<'_>) -> R,
    ) -> Option<Result<R, i32>> {
        let engine = &**self.engine;
        let shown = self.port_access.with_ports(|ports| {
            let can = match self.build.mapping(port) {
                Some(PortMapping::Bound(port)) => ports.can_show_early(*port),
                Some(PortMapping::Unbound | PortMapping::Fixed { .. }) => true,
                Some(PortMapping::Discarded(_)) | None => false,
            };
            can.then(|| {
                ports.without_record(|ports| {
                    let view = view(self.build, ports, port, || engine.clock.now());
                    view.map(|view| show(&view)).map_err(|error| status(&error))
                })
            })
        });
        shown.flatten()
    }

    /// Ends what [`Self::show_early`] began: the plugin has read the input, or it has not.
    pub(super) fn end_early(&self, port: u32, was_read: bool) {
        if let Some(PortMapping::Bound(port)) = self.build.mapping(port) {
            self.port_access
                .with_ports(|ports| ports.end_early(*port, was_read));
        }
    }

    /// Returns what it takes for a value of an output to be published.
    pub(super) fn acceptance(&self, port: u32) -> Acceptance {
        let acceptance = match self.build.mapping(port) {
            Some(PortMapping::Bound(port)) => self.port_access.with_ports(|ports| ports.acceptance(*port)),
            Some(PortMapping::Discarded(_)) => Some(Acceptance::Always),
            Some(PortMapping::Unbound | PortMapping::Fixed { .. }) | None => None,
        };
        acceptance.unwrap_or_default()
    }

    /// Shows the memory for the next value of an output.
    pub(super) fn lend<R>(&mut self, port: u32, show: impl FnOnce(&mut [u8]) -> R) -> Result<R, i32> {
        if let Some(PortMapping::Bound(port)) = self.build.mapping(port) {
            // A missing authority is reported at the publication.
            if self.refuses_all(|call| format!("write `{}`", call.port_name(*port))) {
                return Err(raw::REFUSED);
            }
        }
        let loaned = self.port_access.with_ports(|ports| {
            let buffer = match self.build.mapping(port) {
                Some(PortMapping::Bound(port)) => ports.loan(*port),
                Some(PortMapping::Unbound) => Err(PortError::Unbound),
                Some(PortMapping::Discarded(bytes)) => Ok(self.scratch.buffer(port, *bytes)),
                Some(PortMapping::Fixed { .. }) | None => Err(PortError::WrongPort),
            };
            buffer.map(show).map_err(|error| status(&error))
        });
        loaned.unwrap_or(Err(raw::REFUSED))
    }

    /// Judges a command that guards judge, and reports what was limited or refused.
    #[cold]
    pub(super) fn finish_publication(
        &self,
        port: usize,
        published: Result<u64, PortError>,
        exceeded: Option<Arc<CommandLimits>>,
        [time, now, least]: [Nanos; 3],
    ) -> i32 {
        if let Some(limits) = exceeded {
            let quiet = self.engine.retry_of(self.number);
            let is_first = |ports: &mut Ports| ports.record_limited(port, now, quiet);
            if self.port_access.with_ports(is_first) == Some(true) {
                self.engine.report_limits(self.number, &limits.stated_by);
            }
        }
        let published = match published {
            Err(PortError::Guarded(guarded)) => match *guarded {
                Guarded::Unjudged(command) => self.publish_guarded(port, command, time, now, least),
                refused @ Guarded::Refused(_) => Some(Err(PortError::Guarded(Box::new(refused)))),
            },
            published => Some(published),
        };
        let error = match published {
            None => return raw::REFUSED,
            Some(Ok(_)) => return raw::OK,
            Some(Err(error)) => error,
        };
        match &error {
            PortError::Refused { why, first } => {
                self.engine.report_refused_write(self.number, port, why, *first);
            }
            PortError::Guarded(guarded) => {
                if let Guarded::Refused(refusal) = &**guarded {
                    self.engine.report_refusal(refusal);
                }
            }
            PortError::NotAValue { why, first } => {
                self.engine.report_no_value(self.number, port, why, *first);
            }
            PortError::Unbound | PortError::NoValue | PortError::WrongPort | PortError::NothingLoaned => {}
        }
        match status(&error) {
            // A build for an older ABI does not know that status.
            raw::OUT_OF_RANGE if self.build.plugin.description.abi.1 < 4 => raw::NOT_FINITE,
            status => status,
        }
    }

    /// Lets guards judge a copy of a command, while no port is in use, and publishes what they let take effect.
    /// `None` if the call was given up meanwhile.
    fn publish_guarded(
        &self,
        port: usize,
        unjudged: UnjudgedCommand,
        time: Nanos,
        now: Nanos,
        least: Nanos,
    ) -> Option<Result<u64, PortError>> {
        let (engine, commander) = (self.engine, self.number);
        let guards = Arc::clone(&unjudged.guards);
        let judged = match engine.judge(commander, unjudged, now) {
            Ok(judged) => judged,
            Err(refusal) => {
                self.port_access.with_ports(|ports| ports.refuse(port))?;
                return Some(Err(PortError::Guarded(Box::new(Guarded::Refused(refusal)))));
            }
        };
        let quiet = engine.retry_of(commander);
        let (published, variable, is_first) = self.port_access.with_ports(|ports| {
            let published = ports.publish_judged(port, &judged.bytes, time, now, least);
            let variable = ports.variable(port).map(|(variable, _)| Arc::clone(variable));
            let is_limited = published.is_ok() && judged.limit.is_some();
            (
                published,
                variable,
                is_limited && ports.record_limited(port, now, quiet),
            )
        })?;
        if let (true, Some((guard, reason))) = (is_first, &judged.limit) {
            engine.report_limit(commander, *guard, reason);
        }
        if let (Ok(sequence), Some(variable)) = (&published, variable) {
            let bytes = judged.bytes.clone();
            let in_force = CommandInForce {
                variable,
                sequence: *sequence,
                commander,
            };
            engine.judge_if_changed(UnjudgedCommand { guards, bytes }, &judged, in_force);
        }
        Some(published)
    }

    /// A mock answers no commands.
    pub(super) fn expect_no_motion(&self) {
        self.port_access
            .with_ports(|ports| ports.measurements.expect_no_motion());
    }

    /// Ends what the schema exported if its iteration ended because an input has no value (R19).
    pub(crate) fn end_iteration(&mut self, status: i32) {
        if status == raw::NO_VALUE {
            self.port_access.with_ports(Ports::retract_expiring);
        }
    }

    /// Returns the variable behind a port, if there is one; and whether the port writes it.
    pub(crate) fn variable(&self, port: u32) -> Option<(Arc<Variable>, bool)> {
        let Some(PortMapping::Bound(port)) = self.build.mapping(port) else {
            return None;
        };
        let variable = self.port_access.with_ports(|ports| {
            let (variable, writes) = ports.variable(*port)?;
            Some((Arc::clone(variable), writes))
        });
        variable.flatten()
    }

    /// Returns the number of releases of its ports. A value read before a release is not shown after it.
    pub(crate) fn releases(&self) -> u64 {
        self.port_access
            .with_ports(|ports| ports.releases())
            .unwrap_or_default()
    }

    /// Whether the call may do all that its authority allows.
    pub(crate) fn may_do_all(&self) -> bool {
        matches!(self.permissions, Permissions::All)
    }

    /// Whether the call may change nothing.
    pub(crate) fn is_read_only(&self) -> bool {
        matches!(self.permissions, Permissions::ReadOnly(_))
    }

    /// Whether this call may not act on other schemas.
    pub(super) fn refuses(&mut self, action: impl FnOnce(&Self) -> String) -> bool {
        match self.permissions {
            Permissions::All => false,
            Permissions::ExportsOnly => true,
            Permissions::ReadOnly(_) => self.refuses_all(action),
        }
    }

    /// Whether this call may not even write its exports.
    pub(super) fn refuses_all(&mut self, action: impl FnOnce(&Self) -> String) -> bool {
        if let Permissions::ReadOnly(None) = self.permissions {
            let action = action(self);
            self.permissions = Permissions::ReadOnly(Some(action));
        }
        self.is_read_only()
    }

    /// Whether this call may not write that port of the application.
    pub(super) fn refuses_port(&mut self, port: usize) -> bool {
        if let Permissions::All = self.permissions {
            return false;
        }
        let action = |call: &Self| format!("write `{}`", call.port_name(port));
        match self.port_access.with_ports(|ports| ports.is_foreign_output(port)) {
            None => true,
            Some(true) => self.refuses(action),
            Some(false) => self.refuses_all(action),
        }
    }

    pub(super) fn port_name(&self, port: usize) -> &str {
        let ports = &self.engine.application.instances[self.number].schema.ports;
        ports.get(port).map_or("a port", |port| &port.name)
    }

    /// Returns the role of the application that corresponds to a role of the build.
    fn role(&self, role: u32) -> Result<RoleId, i32> {
        self.build
            .role(role)
            .ok_or(raw::BAD_ARGUMENT)?
            .ok_or(raw::UNBOUND)
    }

    /// Returns the status of a write to an export that the application does not have.
    pub(super) fn discarded_status(&self) -> i32 {
        self.port_access.with_ports(|_| raw::OK).unwrap_or(raw::REFUSED)
    }

    /// Asks the rules about a child; refused if the call was given up. It cannot be given up until this function
    /// returns.
    pub(super) fn with_child<R>(&self, child: u32, ask: impl FnOnce(RoleId) -> R) -> Result<R, i32> {
        let asked = self.port_access.with_ports(|_| self.role(child).map(ask));
        asked.unwrap_or(Err(raw::REFUSED))
    }
}

/// Returns what a port shows. Calls `now` only if it is needed, because it may read the system's clock.
fn view<'a>(
    build: &'a Build,
    ports: &'a mut Ports,
    port: u32,
    now: impl Fn() -> Nanos,
) -> Result<View<'a>, PortError> {
    match build.mapping(port) {
        Some(PortMapping::Bound(port)) => ports.read(*port, now),
        Some(PortMapping::Unbound) => Err(PortError::Unbound),
        Some(PortMapping::Fixed { value, neutral }) => Ok(View {
            bytes: value.bytes(),
            time: if *neutral { now() } else { 0 },
            sequence: 0,
            writer: u32::MAX,
            neutral: *neutral,
        }),
        Some(PortMapping::Discarded(_)) | None => Err(PortError::WrongPort),
    }
}

pub(super) fn status(error: &PortError) -> i32 {
    match error {
        PortError::Unbound => raw::UNBOUND,
        PortError::NoValue => raw::NO_VALUE,
        PortError::WrongPort | PortError::NothingLoaned => raw::BAD_ARGUMENT,
        PortError::Refused {
            why: jde_board::Refused::NotFinite,
            ..
        } => raw::NOT_FINITE,
        PortError::Refused {
            why: jde_board::Refused::OutOfRange,
            ..
        } => raw::OUT_OF_RANGE,
        PortError::Refused { .. } | PortError::Guarded(_) => raw::REFUSED,
        // As when an operator lets it fail: its schema has published what it has.
        PortError::NotAValue { .. } => raw::OK,
    }
}
