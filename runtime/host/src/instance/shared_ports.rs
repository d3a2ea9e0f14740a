//! The ports of an instance in a process of its own, as its child learns of them, and the memory that it may map.

use std::os::fd::OwnedFd;

use jde_isolation::launch::{Acceptance, PortInfo};
use jde_loader::build::PortMapping;

use super::CallContext;

/// Describes the ports to a child. Also returns the files of their memory.
pub(super) fn describe_ports(call: &CallContext<'_>) -> std::io::Result<(Vec<PortInfo>, Vec<OwnedFd>)> {
    let mut files = Vec::new();
    let mut ports = Vec::new();
    for port in 0..call.build.ports() {
        let port = port as u32;
        let Some((variable, writes)) = call.variable(port) else {
            ports.push(match call.build.mapping(port) {
                Some(PortMapping::Discarded(bytes)) => PortInfo {
                    writes: true,
                    bytes: *bytes,
                    memory: None,
                    acceptance: call.acceptance(port),
                },
                Some(PortMapping::Bound(_) | PortMapping::Unbound | PortMapping::Fixed { .. }) | None => {
                    PortInfo::default()
                }
            });
            continue;
        };
        let acceptance = call.acceptance(port);
        // What it writes of others it sends: their memory has the values of other writers too, and a value must not change
        // once it was checked and judged. The host publishes a copy.
        let is_sent = writes && acceptance != Acceptance::Always;
        let memory = variable.shared().filter(|_| !is_sent);
        if let Some(shared) = memory {
            let file = if writes {
                shared.writable_file()
            } else {
                shared.readable_file()
            };
            files.push(file?);
        }
        ports.push(PortInfo {
            writes,
            bytes: variable.describe().value_type.bytes,
            memory: memory.map(|shared| shared.extent()),
            acceptance,
        });
    }
    if let Some(authority) = &call.engine.authority {
        files.push(authority.file()?);
    }
    files.extend(call.build.plugin.held_copy()?);
    Ok((ports, files))
}
