//! An owner that polls its port until a condition holds.

use core::time::Duration;
use std::thread;

use jde_port::{Address, Backoff, Port, PortState};
use jde_watchdog::Watchdog;

/// Attempts follow each other without a wait, so that no test waits.
pub(crate) const AT_ONCE: Backoff = Backoff {
    initial: Duration::ZERO,
    max: Duration::ZERO,
};

pub(crate) fn port(address: &str) -> Port {
    Port::new(Address::parse(address).expect("an address"), AT_ONCE)
}

/// Polls with a constant time until the link satisfies a condition.
pub(crate) fn until(port: &mut Port, mut good: impl FnMut(&PortState) -> bool) -> PortState {
    let _watchdog = Watchdog::for_test();
    loop {
        if good(port.poll(Duration::ZERO)) {
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
    let mut heard = Vec::new();
    loop {
        port.read(&mut heard);
        if let PortState::Lost { reason, .. } = port.state() {
            return (reason.clone(), heard);
        }
        thread::yield_now();
    }
}

/// Reads until `count` bytes have arrived.
pub(crate) fn read(port: &mut Port, count: usize) -> Vec<u8> {
    let _watchdog = Watchdog::for_test();
    let mut heard = Vec::new();
    while heard.len() < count {
        port.poll(Duration::ZERO);
        port.read(&mut heard);
        assert!(port.state().is_connected(), "{:?}", port.state());
        thread::yield_now();
    }
    heard
}

pub(crate) fn reason(link: &PortState) -> &str {
    match link {
        PortState::Lost { reason, .. } => reason,
        PortState::Idle | PortState::Connecting { .. } | PortState::Connected { .. } => {
            panic!("not lost: {link:?}")
        }
    }
}
