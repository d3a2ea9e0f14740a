//! The child's side of an inspection (`jde.inspect`): an instance that never awakes, at the child's table.
//! Requests of the plugin go to the host, which returns modulations and refuses everything else.

#![allow(unsafe_code)]

use std::ffi::CString;

use jde_abi::inspect::Problem;
use jde_abi::raw;

use super::launch::PortAbout;
use super::limits;
use super::memory::Port;
use super::table::{HOST, Present, Session};
use super::wire::{CHANGES_NOTHING, Frame, Kind, Wire};
use crate::app::Isolation;
use crate::instance::Here;
use crate::plugin::Functions;

/// A status of the ABI, and the problems found.
pub(crate) type Inspected = (i32, Result<Vec<Problem>, String>);

/// Removes this process's rights to write files and to use the network, for good. If the system does not
/// support that, the rights stay: an inspection changes nothing by its contract.
pub(crate) fn only_look() {
    drop(limits::apply(Isolation {
        memory: None,
        cpu: None,
        network: false,
        read_only: true,
    }));
}

/// Inspects what the modulations of a type of schema with `ports` ports name. Returns the wire again.
pub(crate) fn inspected(wire: Wire, table: Functions, ports: usize, name: &str) -> (Wire, Inspected) {
    let about = vec![PortAbout::default(); ports];
    let mut session = Session {
        wire,
        name: CString::new(name.replace('\0', "")).unwrap_or_default(),
        application: 0,
        seed: 0,
        real_time: true,
        ports: Port::all(&about, Vec::new()).unwrap_or_default(),
        call: Present::of(&Frame {
            flags: CHANGES_NOTHING,
            ..Frame::new(Kind::Start)
        }),
    };
    // SAFETY: the table was checked when its plugin was loaded.
    let inspected = match unsafe { Here::create(table, &HOST, session.context()) } {
        Some(mut instance) => instance.inspect(session.context()),
        None => (raw::FAILED, Ok(Vec::new())),
    };
    (session.wire, inspected)
}
