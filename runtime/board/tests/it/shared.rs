//! Values that other processes can map: the same values, at the stated offsets, and no access to other
//! memory.

#![allow(
    unsafe_code,
    reason = "mapped memory is read and written through raw pointers"
)]

use std::fs::{File, OpenOptions};
use std::os::fd::{AsFd, AsRawFd};
use std::os::unix::fs::MetadataExt;
use std::os::unix::process::CommandExt;
use std::process::Command;
use std::sync::Arc;

use jde_board::{Board, Mapping, Variable};

use crate::common::{EXPORT, declaration, float64, word_array};

/// Words of a value: enough that it is borrowed, and that a multiple of it does not end on a page boundary.
const WORDS: usize = 700;

fn image() -> Arc<Variable> {
    let declared = declaration("image", &word_array(WORDS), EXPORT);
    Board::new().declare_shared(declared).expect("a shared variable")
}

fn mapped_bytes(mapped: &Mapping, offset: usize) -> Vec<u8> {
    let first = mapped
        .at(offset, WORDS * 8)
        .expect("an offset inside the mapping");
    // SAFETY: the mapping has these bytes, and nothing writes to them meanwhile.
    unsafe { std::slice::from_raw_parts(first, WORDS * 8) }.to_vec()
}

#[test]
fn a_published_value_can_be_read_in_the_mapping() {
    let variable = image();
    let shared = variable.shared().expect("shared memory");
    let file = shared.readable_file().expect("a file");
    let mapped = Mapping::new(file.as_fd(), shared.extent(), false).expect("a mapping");
    let (mut writer, mut reader) = (variable.writer(1, "camera").unwrap(), variable.reader("eye"));
    for value in [3_u8, 5, 8, 13, 21] {
        writer.loan().fill(value);
        writer.publish(1, 1).expect("a publication");
        let latched = reader.latch(0).expect("a value");
        let offset = variable.offset_of(latched.bytes).expect("borrowed in place");
        assert_eq!(mapped_bytes(&mapped, offset), vec![value; WORDS * 8]);
        reader.release();
    }
}

#[test]
fn a_value_written_in_the_mapping_can_be_published() {
    let variable = image();
    let shared = variable.shared().expect("shared memory");
    let file = shared.writable_file().expect("a file");
    let mapped = Mapping::new(file.as_fd(), shared.extent(), true).expect("a mapping");
    let (mut writer, mut reader) = (variable.writer(1, "camera").unwrap(), variable.reader("eye"));
    let offset = variable.offset_of(writer.loan()).expect("loaned in place");
    let first = mapped
        .at(offset, WORDS * 8)
        .expect("an offset inside the mapping");
    // SAFETY: the mapping has these bytes, and the loan guarantees that no other thread accesses them.
    unsafe { first.write_bytes(34, WORDS * 8) };
    writer.publish(1, 1).expect("a publication");
    assert_eq!(reader.latch(0).expect("a value").bytes, vec![34; WORDS * 8]);
}

#[test]
fn a_read_only_file_cannot_be_mapped_for_writing() {
    let variable = image();
    let shared = variable.shared().expect("shared memory");
    let file = shared.readable_file().expect("a file");
    assert!(Mapping::new(file.as_fd(), shared.extent(), true).is_err());
}

#[test]
fn the_shared_memory_cannot_be_resized() {
    let variable = image();
    let file = variable.shared().expect("shared memory").writable_file();
    let file = std::fs::File::from(file.expect("a file"));
    assert!(file.set_len(0).is_err());
    assert!(file.set_len(1 << 30).is_err());
}

#[test]
fn addresses_outside_the_mapping_have_no_offset() {
    let variable = image();
    let shared = variable.shared().expect("shared memory");
    let (_, bytes) = shared.extent();
    let file = shared.readable_file().expect("a file");
    let mapped = Mapping::new(file.as_fd(), shared.extent(), false).expect("a mapping");
    assert!(mapped.at(bytes, 1).is_none());
    assert!(mapped.at(usize::MAX, 2).is_none());
    assert!(variable.offset_of(&[0; WORDS * 8]).is_none());
}

#[test]
fn small_exports_and_variables_not_declared_shared_cannot_be_mapped() {
    let board = Board::new();
    let small = board.declare_shared(declaration("pose", &float64(), EXPORT));
    assert!(small.expect("a declaration").shared().is_none());
    let own = board.declare(declaration("image", &word_array(WORDS), EXPORT));
    assert!(own.expect("a declaration").shared().is_none());
}

/// The id of an unprivileged user.
const NOBODY: u32 = 65_534;

#[test]
fn only_its_own_user_can_open_the_memory() {
    let variable = image();
    let shared = variable.shared().expect("shared memory");
    let file = File::from(shared.readable_file().expect("a file"));
    assert_eq!(file.metadata().expect("metadata").mode() & 0o777, 0o400);
    let name = format!("/proc/{}/fd/{}", std::process::id(), file.as_raw_fd());
    assert!(File::open(&name).is_ok(), "its own user can read it");
    // The superuser has access whatever the mode, and can change to another user.
    if file.metadata().expect("metadata").uid() == 0 {
        let other = Command::new("head")
            .args(["-c", "1", &name])
            .uid(NOBODY)
            .gid(NOBODY)
            .output();
        let other = other.expect("head is installed");
        assert!(!other.status.success() && other.stdout.is_empty(), "{other:?}");
    } else {
        let reopened = OpenOptions::new().write(true).open(&name);
        assert!(
            reopened.is_err(),
            "a read-only file cannot be opened again for writing"
        );
    }
}
