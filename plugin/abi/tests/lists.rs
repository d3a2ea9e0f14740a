//! Invalid lists of ports are refused with a message that names the place.

#![allow(unsafe_code)]

mod tables;

use core::cell::Cell;
use core::ffi::{c_char, c_void};
use core::ptr;
use std::sync::Arc;

use jde_abi::describe::{ListKind, Type, Validity};
use jde_abi::lists::ListedPort;
use jde_abi::{lists, raw};
use tables::{Tables, ZEROS, assert_refused, field, read_changed};

thread_local! {
    /// The table that the ability returns.
    static LISTS: Cell<*const raw::Lists> = const { Cell::new(ptr::null()) };
}

unsafe extern "C" fn ability(id: *const c_char) -> *const c_void {
    // SAFETY: the host's text.
    match unsafe { core::ffi::CStr::from_ptr(id) } == c"jde.lists" {
        true => LISTS.get().cast(),
        false => ptr::null(),
    }
}

unsafe extern "C" fn set(_: *mut c_void, _: *mut raw::Context, _: *const raw::ListedPort, _: u32) -> i32 {
    raw::OK
}

/// Gives the type a list `publish` with the setting `period`, in which `change` changes a value.
fn with_list(tables: &mut Tables, change: impl FnOnce(&mut raw::Lists, &mut raw::PortList, &mut raw::Field)) {
    let mut period = field(c"period", raw::F64, raw::ONE, 1, 0, 0);
    let mut list = raw::PortList {
        size: size_of::<raw::PortList>() as u32,
        kind: raw::IMPORT,
        name: c"publish".as_ptr(),
        doc: c"What to publish.".as_ptr(),
        settings: ptr::null(),
        initial: ptr::from_ref(&ZEROS).cast(),
        validity_ns: 0,
    };
    let mut lists = raw::Lists {
        size: size_of::<raw::Lists>() as u32,
        count: 1,
        lists: ptr::null(),
        set: Some(set),
    };
    change(&mut lists, &mut list, &mut period);
    list.settings = Box::leak(Box::new(raw::Type {
        size: size_of::<raw::Type>() as u32,
        field_count: 1,
        name: c"demo/msg/Topic".as_ptr(),
        doc: ptr::null(),
        bytes: 8,
        align: 8,
        fields: Box::leak(Box::new(period)),
    }));
    lists.lists = Box::leak(Box::new(list));
    LISTS.set(Box::leak(Box::new(lists)));
    tables.schema.ability = Some(ability);
}

#[test]
fn a_list_is_read_with_the_type_and_the_default_of_its_settings() {
    let plugin = read_changed(|tables| with_list(tables, |_, _, _| {})).expect("it is valid");
    let [list] = &plugin.schemas[0].lists[..] else {
        panic!("one list")
    };
    assert_eq!(
        (&*list.name, list.kind, list.initial.len()),
        ("publish", ListKind::Imports, 8)
    );
    assert_eq!(list.settings.fields[0].name, "period");
}

/// Makes the type a driver with one modulation and a list of commands.
fn with_commands(tables: &mut Tables, validity_ns: u64) {
    with_list(tables, |_, list, _| {
        (list.kind, list.validity_ns) = (raw::COMMAND, validity_ns);
    });
    tables.schema.kind = raw::DRIVER;
    tables.schema.child_count = 0;
    // The first three are an import, an export and a modulation.
    tables.schema.port_count = 3;
}

#[test]
fn a_list_of_commands_belongs_to_a_driver_and_states_a_validity() {
    let plugin = read_changed(|tables| with_commands(tables, 7)).expect("it is valid");
    let kind = ListKind::Commands { validity_ns: 7 };
    assert_eq!(plugin.schemas[0].lists[0].kind, kind);
    assert_refused("validity_ns is 0", |tables| with_commands(tables, 0));
    // A plugin of minor version 7 has smaller tables.
    let small = |tables: &mut Tables, kind| {
        with_commands(tables, 7);
        // SAFETY: tables that live for ever, which only this test uses.
        unsafe {
            let list = (*LISTS.get()).lists.cast_mut();
            (*list).size = core::mem::offset_of!(raw::PortList, validity_ns) as u32;
            (*list).kind = kind;
        }
    };
    assert_refused("validity_ns is 0", |tables| small(tables, raw::COMMAND));
    let plugin = read_changed(|tables| small(tables, raw::EXPORT)).expect("it is valid");
    assert_eq!(
        plugin.schemas[0].lists[0].kind,
        ListKind::Exports {
            validity: Validity::Periods
        }
    );
}

#[test]
fn invalid_lists_are_refused() {
    let refused = |message: &str, change: fn(&mut raw::Lists, &mut raw::PortList, &mut raw::Field)| {
        assert_refused(message, |tables| with_list(tables, change));
    };
    refused("its `set` is null", |lists, _, _| lists.set = None);
    refused("it has 0 lists of ports", |lists, _, _| lists.count = 0);
    refused("kind is 2", |_, list, _| list.kind = raw::MODULATION);
    refused("kind is 9", |_, list, _| list.kind = 9);
    refused("only drivers have lists of commands", |_, list, _| {
        list.kind = raw::COMMAND;
    });
    refused("`initial` is null", |_, list, _| list.initial = ptr::null());
    refused("setting `from` has the name of another key", |_, _, setting| {
        setting.name = c"from".as_ptr();
    });
    refused("`speed` has the name of another key", |_, list, _| {
        list.name = c"speed".as_ptr();
    });
    refused("`imports` has the name of another key", |_, list, _| {
        list.name = c"imports".as_ptr();
    });
}

#[test]
fn listed_ports_follow_the_own_ones_in_number() {
    let plugin = read_changed(|tables| with_list(tables, |_, _, _| {})).expect("it is valid");
    let list = &plugin.schemas[0].lists[0];
    let port = |label: &str| lists::ListedPort {
        list: 0,
        label: label.to_owned(),
        value_type: list.settings.clone(),
        settings: list.initial.clone(),
    };
    let found = lists::tables(&[port("/a"), port("/b")], 5);
    assert_eq!(found.iter().map(|port| port.port).collect::<Vec<_>>(), [5, 6]);
    // SAFETY: a text that lives for ever.
    assert_eq!(unsafe { core::ffi::CStr::from_ptr(found[1].label) }, c"/b");
}

#[test]
fn the_tables_of_the_same_ports_are_written_once() {
    let value_type = |name: &str| {
        Arc::new(Type {
            name: name.to_owned(),
            doc: String::new(),
            bytes: 8,
            align: 8,
            fields: Vec::new(),
        })
    };
    let port = |label: &str, name: &str| ListedPort {
        list: 1,
        label: label.to_owned(),
        value_type: value_type(name),
        settings: vec![1; 8],
    };
    let ports = [port("/a", "test_msgs/msg/A"), port("/a", "test_msgs/msg/B")];
    let parts = |first: usize| {
        lists::tables(&ports, first)
            .iter()
            .map(|table| (table.port, table.label, table.value_type, table.settings))
            .collect::<Vec<_>>()
    };
    let (once, again) = (parts(3), parts(3));
    assert_eq!(once, again);
    assert_eq!([once[0].0, once[1].0], [3, 4]);
    assert_ne!(once[0].2, once[1].2);
    assert_eq!(parts(7)[1], (8, once[1].1, once[1].2, once[1].3));
}
