//! The ports of an instance behind the [`Gate`] that every use of a port during a call passes. A call that
//! does not return may be given up by another thread, and a successor of the instance gets ports of its own.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use jde_core::{Nanos, SchemaId};
use jde_gate::Gate;

use super::ports::Ports;
use super::retained::RetainedValues;

/// The ports of an instance, as long as its calls are not given up.
pub(crate) struct PortAccess {
    gate: Gate<Ports, RetainedValues>,
    /// Whether calls may have read values since the last release.
    has_reads: AtomicBool,
    /// Whether the call may have unpublished loans.
    has_loans: AtomicBool,
    /// Whether reads are recorded.
    is_recorded: bool,
    /// The guard that answers for a call that was given up because its judgement did not return.
    answering_guard: OnceLock<SchemaId>,
}

impl PortAccess {
    pub(crate) fn new(ports: Ports) -> Self {
        Self {
            is_recorded: ports.read_log().is_some(),
            gate: Gate::new(ports),
            has_reads: AtomicBool::new(true),
            has_loans: AtomicBool::new(true),
            answering_guard: OnceLock::new(),
        }
    }

    /// Makes a guard answer for the call, which is about to be given up.
    pub(crate) fn blame(&self, guard: SchemaId) {
        // Of one call only one judgement can be the last.
        let _ = self.answering_guard.set(guard);
    }

    /// The guard that answers for the call that was given up, if its judgement did not return.
    pub(super) fn answering_guard(&self) -> Option<SchemaId> {
        self.answering_guard.get().copied()
    }

    /// Uses the ports exclusively. Returns `None` if the call was given up.
    pub(crate) fn with_ports<R>(&self, body: impl FnOnce(&mut Ports) -> R) -> Option<R> {
        self.gate.with(|ports| {
            let result = body(ports);
            self.update_flags(ports);
            result
        })
    }

    /// Starts a call. Returns the last transaction, if turns are recorded.
    pub(super) fn begin_call(&self, now: Nanos) -> Option<u64> {
        if self.gate.enter(now) && self.is_recorded {
            self.with_ports(Ports::enter).flatten()
        } else {
            None
        }
    }

    /// Ends a call and tidies its ports. From now on it cannot be given up. Returns false if it was
    /// given up before.
    pub(super) fn end_call(&self, tidy: impl FnOnce(&mut Ports)) -> bool {
        let is_tidy = !self.is_recorded && !self.has_loans.load(Ordering::Acquire);
        if is_tidy && self.gate.try_finish() {
            return true;
        }
        self.gate.finish(|ports| {
            tidy(ports);
            self.update_flags(ports);
        })
    }

    /// Releases the values that calls have read, if there are any.
    pub(super) fn release(&self) {
        if self.has_reads.load(Ordering::Acquire) {
            self.with_ports(Ports::release);
        }
    }

    /// Latches anew the values that stay while the schema is awake. Called at its awakening.
    pub(super) fn relatch(&self) {
        self.with_ports(Ports::relatch);
    }

    /// Time of the newest value that calls have read since the last release; 0 if they read none.
    pub(super) fn newest(&self) -> Nanos {
        if !self.has_reads.load(Ordering::Acquire) {
            return 0;
        }
        self.with_ports(|ports| ports.newest()).unwrap_or_default()
    }

    /// Whether a call was given up.
    pub(super) fn is_closed(&self) -> bool {
        self.gate.is_closed()
    }

    /// Gives up the call that runs since `since`, and returns ports for a successor. Returns `None` if the
    /// call has returned, if a port is in use at this instant, or if a loan cannot be separated yet; a later
    /// attempt may succeed. `report` receives the bytes that the call keeps, while the call can neither
    /// return nor use a port.
    pub(crate) fn give_up(&self, since: Nanos, report: impl FnOnce(u64)) -> Option<Ports> {
        let given_up = self
            .gate
            .give_up(since, Ports::split_off, |remains| report(remains.bytes() as u64));
        given_up.unwrap_or_else(|error| {
            tracing::warn!("a call that hangs cannot be given up yet: {error}");
            None
        })
    }

    /// Records whether a later call must release or tidy the ports.
    fn update_flags(&self, ports: &Ports) {
        self.has_reads.store(ports.has_reads(), Ordering::Release);
        self.has_loans.store(ports.has_loans(), Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use jde_board::{Access, Board, Declaration};
    use jde_types::Value as _;

    use super::*;
    use crate::instance::BoundPort;

    /// A port access with one export, in a call that began at 7.
    fn access_in_call() -> PortAccess {
        let declared = Board::new().declare(Declaration {
            owner: String::from("goon"),
            name: String::from("speed"),
            doc: String::new(),
            unit: String::new(),
            value_type: Arc::new(f64::describe()),
            access: Access::Export {
                validity: jde_board::LASTING,
            },
            limits: jde_abi::describe::Limits::default(),
            initial: None,
            writers: 1,
            readers: 1,
        });
        let writer = declared.unwrap().writer(0, "goon").unwrap();
        let access = PortAccess::new(Ports::new(vec![BoundPort::Output(writer)], Arc::default()));
        access.begin_call(7);
        access
    }

    /// Ends the call. Returns the result, and whether the ports were tidied.
    fn end_call(access: &PortAccess) -> (bool, bool) {
        let mut tidied = false;
        let returned = access.end_call(|ports| {
            ports.discard_loans();
            tidied = true;
        });
        (returned, tidied)
    }

    fn loan(access: &PortAccess) {
        let bytes = access.with_ports(|ports| ports.loan(0).ok().map(|buffer| buffer.len()));
        assert_eq!(bytes, Some(Some(8)));
    }

    fn publish(access: &PortAccess) -> bool {
        access
            .with_ports(|ports| ports.publish(0, 7, 7, 1).is_ok())
            .unwrap()
    }

    #[test]
    fn a_call_that_published_its_loans_needs_no_tidying() {
        let access = access_in_call();
        loan(&access);
        loan(&access);
        assert!(publish(&access));
        assert!(!publish(&access), "two loans of one port count as one");
        assert_eq!(end_call(&access), (true, false));
    }

    #[test]
    fn an_unpublished_loan_is_discarded_when_the_call_returns() {
        let access = access_in_call();
        loan(&access);
        assert!(publish(&access));
        loan(&access);
        assert_eq!(end_call(&access), (true, true));
        access.begin_call(8);
        assert!(!publish(&access), "the loan was discarded");
        assert_eq!(end_call(&access), (true, false));
    }

    #[test]
    fn an_abandoned_call_neither_returns_nor_uses_a_port() {
        let access = access_in_call();
        loan(&access);
        let mut kept_bytes = 0;
        assert!(access.give_up(8, |_| ()).is_none(), "no call runs since 8");
        assert!(access.give_up(7, |bytes| kept_bytes = bytes).is_some());
        assert_eq!(kept_bytes, 8, "the abandoned call keeps the loan");
        assert!(access.is_closed());
        assert!(access.with_ports(|_| ()).is_none());
        assert_eq!(end_call(&access), (false, false));
        assert_eq!(access.begin_call(9), None);
        assert!(access.is_closed(), "no call can begin any more");
    }
}
