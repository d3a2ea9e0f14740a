//! Joins the tables of the ports of a type with those of its bundles, and compares them, as constants.

#![allow(unsafe_code)]

use core::ptr;

use jde_abi::raw;

use super::judgement::{bytes, is_same};

/// Takes the place of each port until it is known.
const NONE: raw::Port = raw::Port {
    size: 0,
    kind: 0,
    name: ptr::null(),
    doc: ptr::null(),
    unit: ptr::null(),
    value_type: ptr::null(),
    initial: ptr::null(),
    min: f64::NAN,
    max: f64::NAN,
    validity_ns: 0,
    flags: 0,
    child: 0,
    choices: ptr::null(),
    choice_count: 0,
    reserved: 0,
    former_name: ptr::null(),
};

/// Joins the tables of a type of schema of this kind.
#[must_use]
pub const fn ports<const N: usize>(kind: u32, parts: &[&[raw::Port]]) -> [raw::Port; N] {
    let ports = join(parts);
    let mut next = 0;
    while next < N {
        let port: &raw::Port = &ports[next];
        assert!(
            port.kind != raw::COMMAND || kind == raw::DRIVER,
            "a bundle has a command, and only a driver takes commands"
        );
        assert!(
            port.kind != raw::ACTUATOR || kind == raw::MOTOR,
            "a bundle has an actuator, and only a motor schema commands actuators"
        );
        next += 1;
    }
    ports
}

/// Joins the tables of a bundle.
#[must_use]
pub const fn join<const N: usize>(parts: &[&[raw::Port]]) -> [raw::Port; N] {
    let mut joined = [NONE; N];
    let (mut part, mut next) = (0, 0);
    while part < parts.len() {
        let mut own = 0;
        while own < parts[part].len() {
            joined[next] = parts[part][own];
            assert!(
                !is_in(&joined[next], &joined, next),
                "two ports of a schema and its bundles have one name"
            );
            (own, next) = (own + 1, next + 1);
        }
        part += 1;
    }
    joined
}

/// Returns whether one of the first `count` ports has the name of this one, where names must be unique.
const fn is_in(port: &raw::Port, ports: &[raw::Port], count: usize) -> bool {
    let mut next = 0;
    while next < count {
        let other = &ports[next];
        let is_same_space = space(port) == space(other) && port.child == other.child;
        if is_same_space && is_same(bytes(port.name), bytes(other.name)) {
            return true;
        }
        next += 1;
    }
    false
}

/// Returns a number for the names among which that of the port is unique: a schema's own variables have one name each.
const fn space(port: &raw::Port) -> u32 {
    match port.kind {
        raw::EXPORT | raw::COMMAND => raw::MODULATION,
        kind => kind,
    }
}
