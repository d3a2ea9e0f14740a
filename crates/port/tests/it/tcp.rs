//! Real connections on the loopback: peers that vanish, return, refuse, flood and do not read.

use core::time::Duration;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread;

use crate::common::{connected, port, read, read_until_lost, reason, until};
use jde_port::{Address, Backoff, Port, PortState};

fn listen() -> (TcpListener, String) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = format!("tcp:{}", listener.local_addr().expect("it is bound"));
    (listener, address)
}

fn pair() -> (Port, TcpStream) {
    let (listener, address) = listen();
    let mut port = port(&address);
    connected(&mut port);
    (port, listener.accept().expect("it has connected").0)
}

fn is_lost(link: &PortState) -> bool {
    matches!(link, PortState::Lost { .. })
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
fn who_closes_while_connecting_leaves_no_connection_behind() {
    let (listener, address) = listen();
    let mut port = port(&address);
    assert!(matches!(port.poll(Duration::ZERO), PortState::Connecting { .. }));
    let (mut device, _) = listener.accept().expect("it connects");
    port.close();
    device
        .set_read_timeout(Some(Duration::from_secs(60)))
        .expect("an option of TCP");
    assert_eq!(device.read(&mut [0; 1]).expect("it is closed"), 0);
    // The same port reconnects, once the old attempt has ended.
    until(&mut port, PortState::is_connected);
    listener.accept().expect("it has connected");
}

#[test]
fn bytes_go_both_ways_however_they_are_cut() {
    let (mut port, mut device) = pair();
    let said: Vec<u8> = (0..=255).cycle().take(3000).collect();
    let words = said.clone();
    let device = thread::spawn(move || {
        for piece in words.chunks(7) {
            device.write_all(piece).expect("it listens");
        }
        let mut heard = [0; 11];
        device.read_exact(&mut heard).expect("it speaks");
        heard
    });
    assert_eq!(read(&mut port, said.len()), said);
    assert!(port.write(b"hello "));
    assert!(port.write(b"world"));
    assert!(port.flush(Duration::from_secs(60)));
    assert_eq!(&device.join().expect("it heard"), b"hello world");
}

#[test]
fn a_peer_that_goes_and_comes_back_is_lost_with_the_reason_and_met_again() {
    let (listener, address) = listen();
    let mut port = port(&address);
    for _ in 0..3 {
        connected(&mut port);
        let (mut device, _) = listener.accept().expect("it has connected");
        device.write_all(b"last words").expect("it listens");
        drop(device);
        let (reason, heard) = read_until_lost(&mut port);
        assert_eq!(
            heard, b"last words",
            "what came before the end is not lost with it"
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
    device.peek(&mut [0]).expect("they have come");
    drop(device);
    let (reason, _) = read_until_lost(&mut port);
    assert!(
        reason.ends_with("the other side broke the connection off"),
        "{reason}"
    );
}

#[test]
fn attempts_become_rarer_and_are_counted_until_a_byte_is_heard() {
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
        let PortState::Lost {
            reason,
            retry_at: again,
        } = (loop {
            if is_lost(port.poll(now)) {
                break port.state().clone();
            }
            thread::yield_now();
        })
        else {
            unreachable!("it is lost")
        };
        assert!(reason.contains("nothing listens there"), "{reason}");
        assert_eq!(port.attempts(), attempt);
        waits.push((again - now).as_secs());
        assert!(
            is_lost(port.poll(again - Duration::from_nanos(1))),
            "not before its time"
        );
        now = again;
    }
    assert_eq!(waits, [1, 2, 4, 4]);

    let listener = TcpListener::bind(&address["tcp:".len()..]).expect("the port is free again");
    // The time is constant: an attempt that timed out would leave a connection that is accepted first.
    while !port.poll(now).is_connected() {
        thread::yield_now();
    }
    assert_eq!(port.attempts(), 5, "it is connected, but nothing is heard");
    let (mut device, _) = listener.accept().expect("it has connected");
    device.write_all(b"!").expect("it listens");
    let mut heard = Vec::new();
    while port.read(&mut heard) == 0 {
        thread::yield_now();
    }
    assert_eq!(port.attempts(), 0);
    port.disconnect_with("it says nothing more");
    let PortState::Lost {
        retry_at: again,
        reason,
    } = port.state()
    else {
        panic!("it was given up")
    };
    assert!(reason.ends_with(": it says nothing more"));
    assert!(*again <= now + Duration::from_secs(1), "the waits begin anew");
}

#[test]
fn a_peer_that_does_not_listen_is_lost_before_anything_is_left_out() {
    let (mut port, mut device) = pair();
    let frame = [7; 1000];
    let mut taken = 0;
    while port.write(&frame) {
        taken += frame.len();
    }
    assert!(
        reason(port.state()).contains("it does not listen"),
        "{:?}",
        port.state()
    );
    let mut heard = Vec::new();
    device.read_to_end(&mut heard).expect("it can still be read");
    assert!(heard.len() <= taken + frame.len() && heard.iter().all(|byte| *byte == 7));
}

#[test]
fn a_flood_is_taken_in_bounded_bites() {
    let (mut port, mut device) = pair();
    let flood = thread::spawn(move || device.write_all(&vec![1; 4 << 20]).is_ok());
    let (mut total, mut bite) = (0, Vec::new());
    while total < 4 << 20 {
        bite.clear();
        total += port.read(&mut bite);
        assert!(bite.len() <= 70_000, "{} bytes at once", bite.len());
        thread::yield_now();
    }
    assert!(flood.join().expect("it ends"));
}

#[test]
fn a_peer_that_hears_nothing_keeps_flush_no_longer_than_said() {
    let (mut port, _device) = pair();
    // Fill the system's buffers, so that bytes wait.
    while port.flush(Duration::ZERO) {
        assert!(port.write(&[0; 60_000]));
    }
    assert!(!port.flush(Duration::from_millis(1)));
    assert!(port.state().is_connected(), "slow is not lost");
}

#[test]
fn closing_forgets_and_the_next_poll_opens_anew() {
    let (listener, address) = listen();
    let mut port = port(&address);
    connected(&mut port);
    let (mut device, _) = listener.accept().expect("it has connected");
    port.close();
    assert_eq!(port.state(), &PortState::Idle);
    assert_eq!(device.read(&mut [0]).expect("it is closed in order"), 0);
    connected(&mut port);
}

#[test]
fn a_host_that_nobody_knows_is_named() {
    // Names under .invalid never resolve (RFC 2606).
    let mut port = port("tcp:scanner.invalid:10940");
    let link = until(&mut port, is_lost);
    assert!(
        reason(&link).starts_with("scanner.invalid:10940: no such host"),
        "{link:?}"
    );
}

#[test]
fn an_attempt_that_takes_too_long_is_given_up_by_the_owners_clock() {
    let (_listener, address) = listen();
    let mut port = port(&address);
    assert!(matches!(port.poll(Duration::ZERO), PortState::Connecting { .. }));
    let link = port.poll(Duration::from_secs(60)).clone();
    // Either the attempt was faster than this call, or it has timed out: no attempt may last a minute.
    assert!(
        link.is_connected() || reason(&link).contains("no answer in time"),
        "{link:?}"
    );
}
