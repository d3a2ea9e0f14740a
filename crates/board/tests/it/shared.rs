//! Values that other processes can map: the same values, at the stated places, and no access to anything
//! else.

#![allow(unsafe_code, reason = "mapped memory is looked at through raw pointers")]

use std::fs::{File, OpenOptions};
use std::os::fd::{AsFd, AsRawFd};
use std::os::unix::fs::MetadataExt;
use std::os::unix::process::CommandExt;
use std::process::Command;
use std::sync::Arc;

use jde_board::{Access, Board, Mapping, Variable};

use crate::common::{declaration, float64, words};

/// Words of a value: enough that it is borrowed, and that a multiple of it does not end on a page boundary.
const WORDS: usize = 700;

fn image() -> Arc<Variable> {
    let declared = declaration("image", &words(WORDS), Access::Export);
    Board::new().declare_shared(declared).expect("there is memory")
}

fn seen(mapped: &Mapping, place: usize) -> Vec<u8> {
    let first = mapped.at(place, WORDS * 8).expect("it is inside");
    // SAFETY: the mapping has these bytes, and nothing writes to them meanwhile.
    unsafe { std::slice::from_raw_parts(first, WORDS * 8) }.to_vec()
}

#[test]
fn what_is_published_is_seen_where_the_file_is_mapped() {
    let variable = image();
    let shared = variable.shared().expect("it can be mapped");
    let file = shared.readable_file().expect("a file");
    let mapped = Mapping::new(file.as_fd(), shared.extent(), false).expect("it is mapped");
    let (mut writer, mut reader) = (variable.writer(1, "camera").unwrap(), variable.reader("eye"));
    for value in [3_u8, 5, 8, 13, 21] {
        writer.loan().fill(value);
        writer.publish(1, 1).expect("it is published");
        let latched = reader.latch().expect("a value");
        let place = variable
            .offset_of(latched.bytes)
            .expect("it is borrowed in place");
        assert_eq!(seen(&mapped, place), vec![value; WORDS * 8]);
        reader.release();
    }
}

#[test]
fn what_is_written_where_the_file_is_mapped_is_published() {
    let variable = image();
    let shared = variable.shared().expect("it can be mapped");
    let file = shared.writable_file().expect("a file");
    let mapped = Mapping::new(file.as_fd(), shared.extent(), true).expect("it is mapped");
    let (mut writer, mut reader) = (variable.writer(1, "camera").unwrap(), variable.reader("eye"));
    let place = variable.offset_of(writer.loan()).expect("it is loaned in place");
    let first = mapped.at(place, WORDS * 8).expect("it is inside");
    // SAFETY: the mapping has these bytes, and the loan guarantees that no other thread accesses them.
    unsafe { first.write_bytes(34, WORDS * 8) };
    writer.publish(1, 1).expect("it is published");
    assert_eq!(reader.latch().expect("a value").bytes, vec![34; WORDS * 8]);
}

#[test]
fn who_may_only_read_cannot_map_it_to_write() {
    let variable = image();
    let shared = variable.shared().expect("it can be mapped");
    let file = shared.readable_file().expect("a file");
    assert!(Mapping::new(file.as_fd(), shared.extent(), true).is_err());
}

#[test]
fn nobody_can_take_memory_away_beneath_the_others() {
    let variable = image();
    let file = variable.shared().expect("it can be mapped").writable_file();
    let file = std::fs::File::from(file.expect("a file"));
    assert!(file.set_len(0).is_err());
    assert!(file.set_len(1 << 30).is_err());
}

#[test]
fn what_lies_outside_is_at_no_place() {
    let variable = image();
    let shared = variable.shared().expect("it can be mapped");
    let (_, bytes) = shared.extent();
    let file = shared.readable_file().expect("a file");
    let mapped = Mapping::new(file.as_fd(), shared.extent(), false).expect("it is mapped");
    assert!(mapped.at(bytes, 1).is_none());
    assert!(mapped.at(usize::MAX, 2).is_none());
    assert!(variable.offset_of(&[0; WORDS * 8]).is_none());
}

#[test]
fn small_exports_and_variables_not_declared_so_are_not_given_out() {
    let board = Board::new();
    let small = board.declare_shared(declaration("pose", &float64(), Access::Export));
    assert!(small.expect("it is declared").shared().is_none());
    let own = board.declare(declaration("image", &words(WORDS), Access::Export));
    assert!(own.expect("it is declared").shared().is_none());
}

/// An ordinary user other than the present one.
const NOBODY: u32 = 65_534;

#[test]
fn the_memory_is_its_users_alone() {
    let variable = image();
    let shared = variable.shared().expect("it can be mapped");
    let file = File::from(shared.readable_file().expect("a file"));
    assert_eq!(file.metadata().expect("about it").mode() & 0o777, 0o400);
    let name = format!("/proc/{}/fd/{}", std::process::id(), file.as_raw_fd());
    assert!(File::open(&name).is_ok(), "its own user reads it");
    // The superuser has access whatever the mode, and can change to another user.
    if file.metadata().expect("about it").uid() == 0 {
        let other = Command::new("head")
            .args(["-c", "1", &name])
            .uid(NOBODY)
            .gid(NOBODY)
            .output();
        let other = other.expect("head is installed");
        assert!(!other.status.success() && other.stdout.is_empty(), "{other:?}");
    } else {
        let again = OpenOptions::new().write(true).open(&name);
        assert!(again.is_err(), "who may read cannot help himself to more");
    }
}
