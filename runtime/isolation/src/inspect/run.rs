//! The child's side of an inspection (`jde.inspect`): an instance that never awakes, with the child's table.
//! Requests of the plugin go to the host, which returns modulations and refuses everything else.

#![allow(unsafe_code)]

use std::ffi::CString;

use jde_abi::inspect::Problem;
use jde_abi::lists::ListedPort;
use jde_abi::raw;
use jde_app::Isolation;
use jde_loader::SchemaFunctions;
use jde_loader::instance::InProcessInstance;

use crate::launch::PortInfo;
use crate::limits;
use crate::memory::IsolatedPort;
use crate::table::{CallState, ChildSession, HOST};
use crate::wire::Wire;

/// A status of the ABI, and the problems found.
pub(crate) type InspectionOutcome = (i32, Result<Vec<Problem>, String>);

/// Removes this process's rights to write files and to use the network, permanently. If the system does not
/// support that, the rights remain: an inspection changes nothing by its contract.
pub(crate) fn restrict_to_reading() {
    drop(limits::apply(Isolation {
        memory: None,
        cpu: None,
        network: false,
        read_only: true,
    }));
}

/// Inspects the resources that the modulations of a type of schema with `own` ports and those `listed` name. Also returns the
/// wire.
pub(crate) fn run_inspection(
    wire: Wire,
    table: SchemaFunctions,
    (own, listed): (usize, &[ListedPort]),
    name: &str,
) -> (Wire, InspectionOutcome) {
    let infos = vec![PortInfo::default(); own + listed.len()];
    let mut session = ChildSession {
        wire,
        name: CString::new(name.replace('\0', "")).unwrap_or_default(),
        application: 0,
        seed: 0,
        real_time: true,
        ports: IsolatedPort::open_all(&infos, &mut Vec::new().into_iter()).unwrap_or_default(),
        authority: None,
        call: CallState::inspection(),
    };
    // SAFETY: the table was checked when its plugin was loaded.
    let inspected = match unsafe { InProcessInstance::create(table, &HOST, session.context(), listed, own) } {
        Ok(mut instance) => instance.inspect(session.context()),
        Err(_) => (raw::FAILED, Ok(Vec::new())),
    };
    (session.wire, inspected)
}
