//! The table that `export!` exports passes the host's door, whole.

#![allow(unsafe_code)]

use jde_abi::{raw, read};
use jde_schema::prelude::*;

/// Does nothing.
#[derive(Describe)]
#[schema(perceptive, period = "1s")]
struct Idle {}

impl Schema for Idle {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

jde_schema::export!("idle", "Nothing at all.", [Idle]);

#[test]
fn an_exported_plugin_is_read_by_the_host() {
    // SAFETY: a table made by the macro.
    let plugin = unsafe { read::plugin(&raw const jde_plugin) }.expect("a plugin");
    assert_eq!((&*plugin.name, &*plugin.doc), ("idle", "Nothing at all."));
    assert_eq!(plugin.version, env!("CARGO_PKG_VERSION"));
    assert_eq!(plugin.schemas.len(), 1);
    assert_eq!(jde_plugin.flags, 0, "tests unwind");
}

#[test]
fn a_linked_in_plugin_is_the_same_table() {
    static LINKED: raw::Plugin = jde_schema::plugin!("idle", "Nothing at all.", [Idle]);
    // SAFETY: tables made by the macro.
    let (linked, exported) = unsafe {
        (
            read::plugin(&raw const LINKED),
            read::plugin(&raw const jde_plugin),
        )
    };
    assert_eq!(linked, exported);
}

#[test]
fn an_instance_is_not_made_for_a_host_of_another_version() {
    let table = Idle::TABLE;
    let create = table.create.expect("create");
    let heads: [[u32; 4]; 3] = [
        [size_of::<raw::Host>() as u32, raw::ABI_MAJOR + 1, 0, 0],
        [size_of::<raw::Host>() as u32 - 1, raw::ABI_MAJOR, 0, 0],
        [0, 0, 0, 0],
    ];
    let mut place = 0_u64;
    for head in &heads {
        // SAFETY: the function reads size and version, and no further because these are wrong.
        let instance = unsafe { create(&table, head.as_ptr().cast(), (&raw mut place).cast()) };
        assert!(instance.is_null());
    }
    // SAFETY: null is looked at.
    let instance = unsafe { create(&table, std::ptr::null(), (&raw mut place).cast()) };
    assert!(instance.is_null());
}
