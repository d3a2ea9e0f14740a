//! Helpers that poll a port until a condition holds.

use core::time::Duration;
use std::thread;

use jde_device::port::{Address, Backoff, Port, PortState};
use jde_watchdog::Watchdog;

/// Attempts follow each other without a delay, so that no test waits.
pub(crate) const NO_DELAY: Backoff = Backoff {
    initial: Duration::ZERO,
    max: Duration::ZERO,
};

pub(crate) fn port(address: &str) -> Port {
    Port::new(Address::parse(address).expect("an address"), NO_DELAY)
}

/// Polls with a constant time until its state satisfies a condition.
pub(crate) fn until(port: &mut Port, mut condition: impl FnMut(&PortState) -> bool) -> PortState {
    let _watchdog = Watchdog::for_test();
    loop {
        if condition(port.poll(Duration::ZERO)) {
            return port.state().clone();
        }
        thread::yield_now();
    }
}

pub(crate) fn connected(port: &mut Port) {
    until(port, PortState::is_connected);
}

/// Reads until the connection is lost. Returns the reason, and the bytes that arrived before.
pub(crate) fn read_until_lost(port: &mut Port) -> (String, Vec<u8>) {
    let _watchdog = Watchdog::for_test();
    let mut received = Vec::new();
    loop {
        port.read(&mut received);
        if let PortState::Lost { reason, .. } = port.state() {
            return (reason.clone(), received);
        }
        thread::yield_now();
    }
}

/// Reads until `count` bytes have arrived.
pub(crate) fn read(port: &mut Port, count: usize) -> Vec<u8> {
    let _watchdog = Watchdog::for_test();
    let mut received = Vec::new();
    while received.len() < count {
        port.poll(Duration::ZERO);
        port.read(&mut received);
        assert!(port.state().is_connected(), "{:?}", port.state());
        thread::yield_now();
    }
    received
}

pub(crate) fn reason(state: &PortState) -> &str {
    match state {
        PortState::Lost { reason, .. } => reason,
        PortState::Idle | PortState::Connecting { .. } | PortState::Connected { .. } => {
            panic!("not lost: {state:?}")
        }
    }
}
