//! Real pseudo-terminals: lines that appear, disappear, change their speed and belong to one program at a
//! time.

use core::time::Duration;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::os::unix::fs::symlink;
use std::thread;

use crate::common::{connected, port, read, read_until_lost, reason, until};
use jde_device::port::{Port, PortState, Pty};

fn port_at(pty: &Pty, line: &str) -> Port {
    port(&format!("serial:{}@{line}", pty.path().display()))
}

fn loss_reason(port: &mut Port) -> String {
    reason(&until(port, |state| matches!(state, PortState::Lost { .. }))).to_owned()
}

#[test]
fn every_byte_passes_unchanged() {
    let pty = Pty::open().expect("a pseudo-terminal");
    let mut port = port_at(&pty, "19200");
    connected(&mut port);
    // All bytes, including line ends, XON, XOFF and interrupts.
    let all: Vec<u8> = (0..=255).collect();
    pty.master().write_all(&all).expect("an open line");
    assert_eq!(read(&mut port, 256), all);
    assert!(port.write(&all));
    assert!(port.flush(Duration::from_secs(60)));
    let mut received = [0; 256];
    pty.master().read_exact(&mut received).expect("an open line");
    assert_eq!(received, *all);
}

#[test]
fn the_speed_of_the_address_applies_until_it_is_changed() {
    let pty = Pty::open().expect("a pseudo-terminal");
    let mut port = port_at(&pty, "9600");
    connected(&mut port);
    assert_eq!(pty.baud().expect("a line"), 9600);
    for baud in [500_000, 38_400, 19_200] {
        assert!(port.set_baud(baud));
        assert_eq!(pty.baud().expect("a line"), baud);
    }
    port.close();
    connected(&mut port);
    assert_eq!(
        pty.baud().expect("a line"),
        9600,
        "a new connection starts with the speed of the address"
    );
}

#[test]
fn an_unplugged_device_is_lost_and_found_again_when_it_returns() {
    let folder = tempfile::tempdir().expect("a folder");
    // As with udev, a constant name refers to the node that the device gets.
    let name = folder.path().join("laser");
    let mut port = port(&format!("serial:{}@9600", name.display()));
    assert!(loss_reason(&mut port).contains("there is no such device: is it plugged in"));
    for _ in 0..3 {
        let pty = Pty::open().expect("a pseudo-terminal");
        symlink(pty.path(), &name).expect("a name");
        connected(&mut port);
        pty.master().write_all(b"hello").expect("an open line");
        assert_eq!(read(&mut port, 5), b"hello");
        fs::remove_file(&name).expect("a symlink");
        drop(pty);
        let (reason, _) = read_until_lost(&mut port);
        assert!(reason.contains("was it unplugged?"), "{reason}");
    }
}

#[test]
fn a_line_belongs_to_one_program() {
    let pty = Pty::open().expect("a pseudo-terminal");
    let (mut first, mut second) = (port_at(&pty, "9600"), port_at(&pty, "9600"));
    connected(&mut first);
    let reason = loss_reason(&mut second);
    assert!(reason.contains("another program has it open"), "{reason}");
    first.close();
    connected(&mut second);
}

#[test]
fn a_path_that_is_not_a_serial_line_is_refused() {
    for (path, expected) in [
        ("/dev/null", "/dev/null: this is not a serial line"),
        ("/", "/: this is not a serial line"),
        ("/dev/no-such-line", "/dev/no-such-line: there is no such device"),
    ] {
        let reason = loss_reason(&mut port(&format!("serial:{path}@9600")));
        assert!(reason.starts_with(expected), "{reason}");
    }
}

#[test]
fn bytes_from_before_the_opening_are_discarded() {
    let pty = Pty::open().expect("a pseudo-terminal");
    let guard = File::open(pty.path()).expect("a line");
    pty.master().write_all(b"long ago").expect("an open line");
    let mut port = port_at(&pty, "9600");
    connected(&mut port);
    pty.master().write_all(b"now").expect("an open line");
    assert_eq!(read(&mut port, 3), b"now");
    drop(guard);
}

#[test]
fn a_device_that_does_not_read_is_lost_before_bytes_are_skipped() {
    let pty = Pty::open().expect("a pseudo-terminal");
    let mut port = port_at(&pty, "9600");
    connected(&mut port);
    while port.write(&[1; 1000]) {
        thread::yield_now();
    }
    assert!(reason(port.state()).contains("it does not receive"));
}
