//! Real pseudo-terminals: lines that appear, disappear, change their speed and belong to one program at a
//! time.

use core::time::Duration;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::os::unix::fs::symlink;
use std::thread;

use crate::common::{connected, port, read, read_until_lost, reason, until};
use jde_port::{Port, PortState, Pty};

fn at(pty: &Pty, line: &str) -> Port {
    port(&format!("serial:{}@{line}", pty.path().display()))
}

fn lost(port: &mut Port) -> String {
    reason(&until(port, |link| matches!(link, PortState::Lost { .. }))).to_owned()
}

#[test]
fn every_byte_goes_through_as_it_is() {
    let pty = Pty::open().expect("a pseudo-terminal");
    let mut port = at(&pty, "19200");
    connected(&mut port);
    // All bytes, including line ends, XON, XOFF and interrupts.
    let all: Vec<u8> = (0..=255).collect();
    pty.master().write_all(&all).expect("it is open");
    assert_eq!(read(&mut port, 256), all);
    assert!(port.write(&all));
    assert!(port.flush(Duration::from_secs(60)));
    let mut heard = [0; 256];
    pty.master().read_exact(&mut heard).expect("it is open");
    assert_eq!(heard, *all);
}

#[test]
fn the_speed_is_that_of_the_address_until_it_is_changed() {
    let pty = Pty::open().expect("a pseudo-terminal");
    let mut port = at(&pty, "9600");
    connected(&mut port);
    assert_eq!(pty.baud().expect("a line"), 9600);
    for baud in [500_000, 38_400, 19_200] {
        port.set_baud(baud);
        assert_eq!(pty.baud().expect("a line"), baud);
    }
    port.close();
    connected(&mut port);
    assert_eq!(
        pty.baud().expect("a line"),
        9600,
        "a new conversation begins as the address says"
    );
}

#[test]
fn a_plug_that_is_pulled_is_lost_and_met_again_where_it_comes_back() {
    let folder = tempfile::tempdir().expect("a folder");
    // As with udev: a constant name for whatever node the device gets.
    let name = folder.path().join("laser");
    let mut port = port(&format!("serial:{}@9600", name.display()));
    assert!(lost(&mut port).contains("there is no such device: is it plugged in"));
    for _ in 0..3 {
        let pty = Pty::open().expect("a pseudo-terminal");
        symlink(pty.path(), &name).expect("a name");
        connected(&mut port);
        pty.master().write_all(b"hello").expect("it is open");
        assert_eq!(read(&mut port, 5), b"hello");
        fs::remove_file(&name).expect("it is there");
        drop(pty);
        let (reason, _) = read_until_lost(&mut port);
        assert!(reason.contains("was it unplugged?"), "{reason}");
    }
}

#[test]
fn a_line_belongs_to_one_program() {
    let pty = Pty::open().expect("a pseudo-terminal");
    let (mut first, mut second) = (at(&pty, "9600"), at(&pty, "9600"));
    connected(&mut first);
    let reason = lost(&mut second);
    assert!(reason.contains("another program has it open"), "{reason}");
    first.close();
    connected(&mut second);
}

#[test]
fn what_is_no_line_is_refused_by_its_name() {
    for (path, words) in [
        ("/dev/null", "/dev/null: this is no serial line"),
        ("/", "/: this is no serial line"),
        ("/dev/no-such-line", "/dev/no-such-line: there is no such device"),
    ] {
        let reason = lost(&mut port(&format!("serial:{path}@9600")));
        assert!(reason.starts_with(words), "{reason}");
    }
}

#[test]
fn what_was_sent_before_anybody_listened_is_forgotten() {
    let pty = Pty::open().expect("a pseudo-terminal");
    let keep = File::open(pty.path()).expect("a line");
    pty.master().write_all(b"long ago").expect("it is open");
    let mut port = at(&pty, "9600");
    connected(&mut port);
    pty.master().write_all(b"now").expect("it is open");
    assert_eq!(read(&mut port, 3), b"now");
    drop(keep);
}

#[test]
fn a_device_that_does_not_read_is_lost_before_anything_is_left_out() {
    let pty = Pty::open().expect("a pseudo-terminal");
    let mut port = at(&pty, "9600");
    connected(&mut port);
    while port.write(&[1; 1000]) {
        thread::yield_now();
    }
    assert!(reason(port.state()).contains("it does not listen"));
}
