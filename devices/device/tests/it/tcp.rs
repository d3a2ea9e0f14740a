//! Real connections on the loopback: peers that vanish, return, refuse, flood and do not read.

use core::time::Duration;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread;

use crate::common::{connected, port, read, read_until_lost, reason, until};
use jde_device::port::{Address, Backoff, Port, PortState};

fn listen() -> (TcpListener, String) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = format!("tcp:{}", listener.local_addr().expect("a bound address"));
    (listener, address)
}

fn pair() -> (Port, TcpStream) {
    let (listener, address) = listen();
    let mut port = port(&address);
    connected(&mut port);
    (port, listener.accept().expect("a connection").0)
}

fn is_lost(state: &PortState) -> bool {
    matches!(state, PortState::Lost { .. })
}

#[test]
fn nothing_is_opened_before_the_first_poll() {
    let (listener, address) = listen();
    let port = port(&address);
    assert_eq!(port.state(), &PortState::Idle);
    listener.set_nonblocking(true).expect("a listener");
    assert!(listener.accept().is_err());
}

#[test]
fn closing_during_an_attempt_closes_its_connection() {
    let (listener, address) = listen();
    let mut port = port(&address);
    assert!(matches!(port.poll(Duration::ZERO), PortState::Connecting { .. }));
    let (mut device, _) = listener.accept().expect("a connection");
    port.close();
    device
        .set_read_timeout(Some(Duration::from_secs(60)))
        .expect("an option of TCP");
    assert_eq!(device.read(&mut [0; 1]).expect("the end of the connection"), 0);
    // The same port reconnects, once the old attempt has ended.
    until(&mut port, PortState::is_connected);
    listener.accept().expect("a connection");
}

#[test]
fn bytes_pass_in_both_directions_however_they_are_split() {
    let (mut port, mut device) = pair();
    let sent: Vec<u8> = (0..=255).cycle().take(3000).collect();
    let bytes = sent.clone();
    let device = thread::spawn(move || {
        for chunk in bytes.chunks(7) {
            device.write_all(chunk).expect("an open connection");
        }
        let mut received = [0; 11];
        device.read_exact(&mut received).expect("an open connection");
        received
    });
    assert_eq!(read(&mut port, sent.len()), sent);
    assert!(port.write(b"hello "));
    assert!(port.write(b"world"));
    assert!(port.flush(Duration::from_secs(60)));
    assert_eq!(&device.join().expect("the device thread"), b"hello world");
}

#[test]
fn a_peer_that_closes_is_lost_with_a_reason_and_can_be_reconnected() {
    let (listener, address) = listen();
    let mut port = port(&address);
    for _ in 0..3 {
        connected(&mut port);
        let (mut device, _) = listener.accept().expect("a connection");
        device.write_all(b"last bytes").expect("an open connection");
        drop(device);
        let (reason, received) = read_until_lost(&mut port);
        assert_eq!(
            received, b"last bytes",
            "bytes that arrived before the end are read"
        );
        assert!(
            reason.ends_with("the other side closed the connection")
                && reason.starts_with(&address["tcp:".len()..]),
            "{reason}"
        );
        assert!(!port.write(b"anybody?"));
    }
}

#[test]
fn a_connection_that_is_reset_is_lost() {
    let (mut port, device) = pair();
    // Closing a socket with unread bytes resets the connection.
    assert!(port.write(b"unread"));
    assert!(port.flush(Duration::from_secs(60)));
    device.peek(&mut [0]).expect("the bytes");
    drop(device);
    let (reason, _) = read_until_lost(&mut port);
    assert!(
        reason.ends_with("the other side reset the connection"),
        "{reason}"
    );
}

#[test]
fn attempts_are_delayed_and_counted_until_a_byte_arrives() {
    let (listener, address) = listen();
    drop(listener);
    let backoff = Backoff {
        initial: Duration::from_secs(1),
        max: Duration::from_secs(4),
    };
    let mut port = Port::new(Address::parse(&address).expect("an address"), backoff);
    let mut now = Duration::ZERO;
    let mut waits = Vec::new();
    for attempt in 1..=4 {
        let PortState::Lost { reason, retry_at } = (loop {
            if is_lost(port.poll(now)) {
                break port.state().clone();
            }
            thread::yield_now();
        }) else {
            unreachable!("the port is lost")
        };
        assert!(reason.contains("nothing listens there"), "{reason}");
        assert_eq!(port.attempts(), attempt);
        waits.push((retry_at - now).as_secs());
        assert!(
            is_lost(port.poll(retry_at - Duration::from_nanos(1))),
            "no attempt before its time"
        );
        now = retry_at;
    }
    assert_eq!(waits, [1, 2, 4, 4]);

    let listener = TcpListener::bind(&address["tcp:".len()..]).expect("the port is free again");
    // The time is constant: an attempt that timed out would leave a connection that is accepted first.
    while !port.poll(now).is_connected() {
        thread::yield_now();
    }
    assert_eq!(
        port.attempts(),
        5,
        "the port is connected, but no byte has arrived"
    );
    let (mut device, _) = listener.accept().expect("a connection");
    device.write_all(b"!").expect("an open connection");
    let mut received = Vec::new();
    while port.read(&mut received) == 0 {
        thread::yield_now();
    }
    assert_eq!(port.attempts(), 0);
    port.disconnect_with("it is silent");
    let PortState::Lost { retry_at, reason } = port.state() else {
        panic!("the port is not lost")
    };
    assert!(reason.ends_with(": it is silent"));
    assert!(
        *retry_at <= now + Duration::from_secs(1),
        "the delays start again"
    );
}

#[test]
fn a_peer_that_does_not_read_is_lost_before_bytes_are_skipped() {
    let (mut port, mut device) = pair();
    let frame = [7; 1000];
    let mut accepted = 0;
    while port.write(&frame) {
        accepted += frame.len();
    }
    assert!(
        reason(port.state()).contains("it does not receive"),
        "{:?}",
        port.state()
    );
    let mut received = Vec::new();
    device.read_to_end(&mut received).expect("the remaining bytes");
    assert!(received.len() <= accepted + frame.len() && received.iter().all(|byte| *byte == 7));
}

#[test]
fn a_flood_is_read_in_bounded_portions() {
    let (mut port, mut device) = pair();
    let flood = thread::spawn(move || device.write_all(&vec![1; 4 << 20]).is_ok());
    let (mut total, mut portion) = (0, Vec::new());
    while total < 4 << 20 {
        portion.clear();
        total += port.read(&mut portion);
        assert!(portion.len() <= 70_000, "{} bytes at once", portion.len());
        thread::yield_now();
    }
    assert!(flood.join().expect("the flood thread"));
}

#[test]
fn flushing_to_a_peer_that_does_not_read_ends_after_the_timeout() {
    let (mut port, _device) = pair();
    // Fill the system's buffers, so that bytes wait.
    while port.flush(Duration::ZERO) {
        assert!(port.write(&[0; 60_000]));
    }
    assert!(!port.flush(Duration::from_millis(1)));
    assert!(port.state().is_connected(), "a slow peer is not lost");
}

#[test]
fn a_closed_port_is_reopened_by_the_next_poll() {
    let (listener, address) = listen();
    let mut port = port(&address);
    connected(&mut port);
    let (mut device, _) = listener.accept().expect("a connection");
    port.close();
    assert_eq!(port.state(), &PortState::Idle);
    assert_eq!(device.read(&mut [0]).expect("an orderly end"), 0);
    connected(&mut port);
}

#[test]
fn an_unknown_host_is_named_in_the_reason() {
    // Names under .invalid never resolve (RFC 2606).
    let mut port = port("tcp:scanner.invalid:10940");
    let state = until(&mut port, is_lost);
    assert!(
        reason(&state).starts_with("scanner.invalid:10940: no such host"),
        "{state:?}"
    );
}

#[test]
fn an_attempt_that_takes_too_long_ends_by_the_owners_clock() {
    let (_listener, address) = listen();
    let mut port = port(&address);
    assert!(matches!(port.poll(Duration::ZERO), PortState::Connecting { .. }));
    let state = port.poll(Duration::from_secs(60)).clone();
    // Either the attempt was faster than this call, or it has timed out: no attempt may last a minute.
    assert!(
        state.is_connected() || reason(&state).contains("no answer in time"),
        "{state:?}"
    );
}
