//! The table of the lists of ports, and the function that receives their entries.

#![allow(unsafe_code)]

use core::ffi::{CStr, c_void};
use core::ptr;

use jde_abi::{raw, table};

use super::calls::call;
use crate::schema::Schema;

/// Builds the table of a list.
#[must_use]
pub const fn list<S>(
    kind: u32,
    name: &'static CStr,
    doc: &'static CStr,
    settings: *const raw::Type,
    initial: &'static S,
    validity_ns: u64,
) -> raw::PortList {
    raw::PortList {
        size: size_of::<raw::PortList>() as u32,
        kind,
        name: name.as_ptr(),
        doc: doc.as_ptr(),
        settings,
        initial: ptr::from_ref(initial).cast(),
        validity_ns,
    }
}

/// Builds the table of all lists of a type; `None` if it has none.
#[must_use]
pub const fn lists<S: Schema>(lists: &'static [raw::PortList]) -> Option<raw::Lists> {
    if lists.is_empty() {
        return None;
    }
    Some(raw::Lists {
        size: size_of::<raw::Lists>() as u32,
        count: lists.len() as u32,
        lists: lists.as_ptr(),
        set: Some(set::<S>),
    })
}

/// # Safety
/// As for [`raw::Lists::set`].
unsafe extern "C" fn set<S: Schema>(
    instance: *mut c_void,
    cx: *mut raw::Context,
    ports: *const raw::ListedPort,
    count: u32,
) -> i32 {
    if ports.is_null() && count > 0 {
        return raw::BAD_ARGUMENT;
    }
    let set = |schema: &mut S, _: &crate::context::Context<'_>| {
        let mut next = ports;
        for _ in 0..count {
            // SAFETY: the host's array, whose stride is the size of its tables.
            unsafe {
                let port = table::read(next).map_err(|unreadable| unreadable.to_string())?;
                next = next.byte_add((*next).size as usize);
                schema.add_listed(&port);
            }
        }
        Ok(())
    };
    // SAFETY: the host's pointers.
    unsafe { call::<S>(instance, cx, set) }
}
