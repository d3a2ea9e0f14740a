//! The host reads the whole table that `export!` exports.

#![allow(unsafe_code)]

use jde_abi::{raw, read};
use jde_schema::prelude::*;

/// Retracts its export, and requires real time.
#[derive(Describe)]
#[schema(perceptive, period = "1s")]
struct Modern {
    #[export]
    out: Export<f64>,
}

impl Schema for Modern {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.out.retract(cx);
        Ok(())
    }
}

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
    assert_eq!(jde_plugin.flags, 0, "tests are built to unwind");
}

#[test]
fn a_linked_in_plugin_has_the_same_table_as_an_exported_one() {
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
fn no_instance_is_created_for_a_host_of_another_version() {
    let table = Idle::TABLE;
    let create = table.create.expect("create");
    let heads: [[u32; 4]; 3] = [
        [size_of::<raw::Host>() as u32, raw::ABI_MAJOR + 1, 0, 0],
        [127, raw::ABI_MAJOR, 0, 0],
        [0, 0, 0, 0],
    ];
    let mut place = 0_u64;
    for head in &heads {
        // SAFETY: the function reads size and version, and no further because these are wrong.
        let instance = unsafe { create(&table, head.as_ptr().cast(), (&raw mut place).cast()) };
        assert!(instance.is_null());
    }
    // SAFETY: null is checked.
    let instance = unsafe { create(&table, std::ptr::null(), (&raw mut place).cast()) };
    assert!(instance.is_null());
}

/// A host's table of ABI 1.0. The functions after its end must not be called.
#[repr(C)]
struct OldHost {
    head: [u32; 4],
    functions: [unsafe extern "C" fn(); 14],
    beyond: [unsafe extern "C" fn(); 4],
}

unsafe extern "C" fn abort() {
    std::process::abort()
}

unsafe extern "C" fn fail(cx: *mut raw::Context, text: *const std::ffi::c_char, length: u64) {
    // SAFETY: the context of the test, and the schema's text.
    unsafe {
        let text = std::slice::from_raw_parts(text.cast::<u8>(), length as usize);
        *cx.cast::<String>() = String::from_utf8_lossy(text).into_owned();
    }
}

#[test]
fn a_function_that_an_older_host_lacks_is_a_fault_with_a_message_and_is_not_called() {
    let mut functions: [unsafe extern "C" fn(); 14] = [abort; 14];
    // SAFETY: the function is called with its true type.
    functions[12] = unsafe { std::mem::transmute::<*const (), unsafe extern "C" fn()>(fail as *const ()) };
    let old = OldHost {
        head: [128, raw::ABI_MAJOR, 0, 0],
        functions,
        beyond: [abort; 4],
    };
    let mut reason = String::new();
    let cx = (&raw mut reason).cast();
    let table = Modern::TABLE;
    // SAFETY: the table's own functions, a host of the size that it states, and a context of the test.
    unsafe {
        let instance = table.create.expect("create")(&raw const table, (&raw const old).cast(), cx);
        assert!(!instance.is_null());
        assert_eq!(table.awake.expect("awake")(instance, cx), raw::FAILED);
        assert_eq!(
            reason,
            "this host, of ABI 1.0, does not know whether time is real; use a newer one"
        );
        assert_eq!(table.iterate.expect("iterate")(instance, cx), raw::PANICKED);
        assert!(
            reason.contains("`out` cannot be taken back: this host, of ABI 1.0,"),
            "{reason}"
        );
        table.destroy.expect("destroy")(instance);
    }
    let _ = old.beyond;
}
