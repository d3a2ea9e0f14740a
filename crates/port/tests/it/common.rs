//! An owner that polls its port until a condition holds.

use core::time::Duration;
use std::thread;

use jde_port::{Address, Backoff, Link, Port};
use jde_watchdog::Watchdog;

/// Attempts follow each other without a wait, so that no test waits.
pub(crate) const AT_ONCE: Backoff = Backoff {
    first: Duration::ZERO,
    most: Duration::ZERO,
};

pub(crate) fn port(address: &str) -> Port {
    Port::new(Address::parse(address).expect("an address"), AT_ONCE)
}

/// Polls with a constant time until the link satisfies a condition.
pub(crate) fn until(port: &mut Port, mut good: impl FnMut(&Link) -> bool) -> Link {
    let _watchdog = Watchdog::of_a_test();
    loop {
        if good(port.poll(Duration::ZERO)) {
            return port.link().clone();
        }
        thread::yield_now();
    }
}

pub(crate) fn connected(port: &mut Port) {
    until(port, Link::is_connected);
}

/// Reads until the connection is lost. Returns the reason, and the bytes that arrived before.
pub(crate) fn read_until_lost(port: &mut Port) -> (String, Vec<u8>) {
    let _watchdog = Watchdog::of_a_test();
    let mut heard = Vec::new();
    loop {
        port.read(&mut heard);
        if let Link::Lost { reason, .. } = port.link() {
            return (reason.clone(), heard);
        }
        thread::yield_now();
    }
}

/// Reads until `count` bytes have arrived.
pub(crate) fn read(port: &mut Port, count: usize) -> Vec<u8> {
    let _watchdog = Watchdog::of_a_test();
    let mut heard = Vec::new();
    while heard.len() < count {
        port.poll(Duration::ZERO);
        port.read(&mut heard);
        assert!(port.link().is_connected(), "{:?}", port.link());
        thread::yield_now();
    }
    heard
}

pub(crate) fn reason(link: &Link) -> &str {
    match link {
        Link::Lost { reason, .. } => reason,
        Link::Idle | Link::Connecting { .. } | Link::Connected { .. } => panic!("not lost: {link:?}"),
    }
}
