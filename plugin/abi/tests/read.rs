//! Invalid tables of a plugin are refused with a message that names the place.
//!
//! Each test builds a valid plugin, changes one value in it, and compares the message.

#![allow(unsafe_code)]

mod tables;

use core::ptr;

use jde_abi::describe::{Form, Kind, Role};
use jde_abi::raw;
use tables::{Tables, assert_refused, field, read_changed};

#[test]
fn a_valid_plugin_is_read_completely() {
    let plugin = read_changed(|_| {}).expect("it is valid");
    assert_eq!(
        (&*plugin.name, &*plugin.version, &*plugin.doc),
        ("demo", "1.2.3", "")
    );
    let schema = &plugin.schemas[0];
    assert_eq!(
        (&*schema.name, schema.kind, schema.period_ns, schema.budget_ns),
        ("goon", Kind::Motor, 75, None)
    );
    assert_eq!(schema.ports[4].role, Role::ChildModulation { child: 0 });
    let fields = &schema.ports[0].value_type.fields;
    let names: Vec<&str> = fields.iter().map(|field| &*field.name).collect();
    assert_eq!(names, ["kind", "count", "points", "note"], "padding is omitted");
    assert_eq!(
        fields[2].form,
        Form::Sequence {
            capacity: 1,
            length_offset: 8
        }
    );
}

#[test]
fn a_missing_mark_or_another_major_version_is_refused_first() {
    assert_refused("does not begin with the mark", |t| t.plugin.magic = 7);
    assert_refused("built for ABI 2.9, newer than this host's 1.9", |t| {
        t.plugin.abi_major = raw::ABI_MAJOR + 1
    });
    assert_refused("built for ABI 0.9, older than this host's 1.9", |t| {
        t.plugin.abi_major = 0
    });
    for minor in [0, raw::ABI_MINOR + 1, u32::MAX] {
        let plugin = read_changed(|t| t.plugin.abi_minor = minor).expect("every minor version is read");
        assert_eq!(plugin.abi, (raw::ABI_MAJOR, minor));
    }
    assert_refused("panic = \"abort\"", |t| t.plugin.flags = raw::PLUGIN_ABORTS);
    assert_refused("ABI 9", |t| {
        t.plugin.abi_major = 9;
        t.plugin.size = 0;
        t.plugin.schemas = ptr::dangling();
    });
}

#[test]
fn tables_smaller_than_the_abi_are_refused() {
    assert_refused("a table says it has 8 bytes", |t| t.plugin.size = 8);
    assert_refused("plugin `demo`: a table says it has 8 bytes", |t| {
        t.schema.size = 8
    });
    assert_refused("schema `goon`: a table says it has 4 bytes", |t| {
        t.ports[0].size = 4
    });
    assert_refused("port `laser`: a table says it has 0 bytes", |t| t.ty.size = 0);
    assert_refused("type `demo/msg/Value`: a table says it has 4 bytes", |t| {
        t.fields[0].size = 4
    });
    assert_refused("schema `goon`: a table says it has 4 bytes", |t| {
        t.children[0].size = 4
    });
}

#[test]
fn tables_that_grew_in_a_later_minor_version_are_read_by_their_stride() {
    #[repr(C)]
    struct Grown {
        field: raw::Field,
        later: u64,
    }
    let grown = |field: raw::Field| Grown {
        field: raw::Field {
            size: size_of::<Grown>() as u32,
            ..field
        },
        later: u64::MAX,
    };
    let fields = [
        grown(field(c"a", raw::F64, raw::ARRAY, 3, 0, 0)),
        grown(field(c"b", raw::F64, raw::ONE, 1, 24, 0)),
    ];
    let plugin = read_changed(|t| {
        t.ty.fields = fields.as_ptr().cast();
        t.ty.field_count = 2;
    });
    let ty = plugin.expect("it is valid").schemas[0].ports[0]
        .value_type
        .clone();
    assert_eq!(ty.fields[1].name, "b");
    assert_refused("breaks their alignment", |t| t.fields[0].size += 4);
}

#[test]
fn invalid_counts_and_pointers_are_refused() {
    assert_refused("it holds no schema", |t| t.plugin.schema_count = 0);
    assert_refused("4000000000 schemas", |t| t.plugin.schema_count = 4_000_000_000);
    assert_refused("pointer to its schemas is null", |t| {
        t.plugin.schemas = ptr::null()
    });
    assert_refused("pointer to its ports is null or not aligned", |t| {
        t.schema.ports = ptr::without_provenance(1)
    });
    assert_refused("pointer to its table is null", |t| {
        t.ports[1].value_type = ptr::null()
    });
    assert_refused("create or iterate is null", |t| t.schema.iterate = None);
    assert_refused("create or iterate is null", |t| t.schema.create = None);
}

#[test]
fn invalid_texts_and_names_are_refused() {
    assert_refused("a schema's name is not UTF-8", |t| {
        t.schema.name = c"\xff".as_ptr()
    });
    assert_refused("schema `goon`, port `laser`: doc is not UTF-8", |t| {
        t.ports[0].doc = c"\xc3".as_ptr()
    });
    assert_refused("name is ``", |t| t.plugin.name = ptr::null());
    assert_refused("a port's name is `a b`", |t| t.ports[0].name = c"a b".as_ptr());
    assert_refused("a child's name is `a/b`", |t| {
        t.children[0].name = c"a/b".as_ptr()
    });
    assert_refused("a type has no name", |t| t.ty.name = ptr::null());
}

#[test]
fn ambiguous_names_are_refused() {
    assert_refused("two ports are called `pose`", |t| {
        t.ports[2].name = c"pose".as_ptr()
    });
    assert_refused("two children are called `brake`", |t| {
        t.children[1].name = c"brake".as_ptr()
    });
    assert_refused("two fields are called `kind`", |t| {
        t.fields[2].name = c"kind".as_ptr()
    });
    assert_refused("a meaning of its own", |t| t.ports[2].name = c"children".as_ptr());
    read_changed(|t| t.ports[0].name = c"pose".as_ptr()).expect("an import may have the name of an export");
    read_changed(|t| t.ports[4].name = c"speed".as_ptr())
        .expect("a child's modulation may have the name of an own modulation");
}

#[test]
fn schemas_that_cannot_run_are_refused() {
    assert_refused("kind is 3, and only 0 to 2 exist", |t| t.schema.kind = 3);
    assert_refused("period_ns is 0", |t| t.schema.period_ns = 0);
    assert_refused("only a motor schema commands actuators", |t| {
        t.schema.kind = raw::DRIVER
    });
    assert_refused("only a motor schema may have motor children", |t| {
        t.schema.kind = raw::PERCEPTIVE;
        t.ports[3].kind = raw::EXPORT;
    });
}

#[test]
fn ports_that_cannot_work_are_refused() {
    assert_refused("port `laser`: kind is 6", |t| t.ports[0].kind = 6);
    assert_refused("`initial` is null", |t| t.ports[2].initial = ptr::null());
    assert_refused("only a driver takes commands", |t| t.ports[2].kind = raw::COMMAND);
    assert_refused("it names child 2 of 2", |t| t.ports[4].child = 2);
    let driver = |t: &mut Tables| {
        t.schema.kind = raw::DRIVER;
        t.schema.child_count = 0;
        t.schema.port_count = 3;
        t.ports[2].kind = raw::COMMAND;
    };
    assert_refused("validity_ns is 0", driver);
    read_changed(|t| {
        driver(t);
        t.ports[2].validity_ns = 1;
    })
    .expect("a driver may take a command");
}

#[test]
fn children_that_cannot_work_are_refused() {
    assert_refused("a child is perceptive (0) or motor (1)", |t| {
        t.children[0].kind = raw::DRIVER
    });
    assert_refused("competes in a group, and `group` is empty", |t| {
        t.children[0].group = ptr::null()
    });
    assert_refused("a role that any number of children have is the last one", |t| {
        t.children[0].flags = raw::MANY;
    });
    assert_refused("and without modulations", |t| {
        t.children[1].flags = raw::MANY;
        t.ports[4].child = 1;
    });
}

#[test]
fn bytes_of_no_field_or_of_two_are_refused() {
    assert_refused("bytes 4 to 8 before field `points` belong to no field", |t| {
        t.fields[2].form = raw::PADDING;
        t.fields[2].kind = raw::U8;
        t.fields[2].offset = 0;
        t.fields[2].capacity = 1;
        t.fields[0].offset = 1;
        t.fields[1].offset = 2;
        t.fields[1].capacity = 2;
    });
    assert_refused("bytes 1 to 4 before field `count`", |t| {
        t.fields[1] = field(c"_", raw::U8, raw::PADDING, 1, 31, 0)
    });
    assert_refused("overlaps the one before it, which ends at 4", |t| {
        t.fields[1].capacity = 3;
        t.fields[2].kind = raw::U8;
        t.fields[2].offset = 3;
    });
    assert_refused("the fields end at byte 32, the type has 40", |t| t.ty.bytes = 40);
    assert_refused("field `note` ends at byte 28, the type has 24", |t| {
        t.ty.bytes = 24
    });
    assert_refused("is not aligned to 8", |t| {
        t.fields[3].offset = 12;
        t.fields[4].length_offset = 20;
        t.fields[4].offset = 24;
        t.fields[4].capacity = 8;
    });
}

#[test]
fn unused_bytes_after_a_length_are_allowed_only_before_its_own_elements() {
    assert_refused("overlaps", |t| {
        t.fields[4] = field(c"note", raw::U32, raw::ONE, 1, 12, 0)
    });
}

#[test]
fn types_of_an_impossible_size_are_refused() {
    assert_refused("0 bytes; a value has 1 to", |t| t.ty.bytes = 0);
    assert_refused("bytes; a value has 1 to", |t| t.ty.bytes = u64::MAX);
    assert_refused("alignment 3", |t| t.ty.align = 3);
    assert_refused("alignment 32", |t| t.ty.align = 32);
    assert_refused("field `points` needs alignment 8, the type has 4", |t| {
        t.ty.align = 4
    });
    assert_refused("capacity is 0", |t| t.fields[3].capacity = 0);
    assert_refused("is past any value", |t| t.fields[0].offset = u64::MAX);
    assert_refused("ends at byte", |t| t.fields[3].capacity = u32::MAX);
}

#[test]
fn fields_of_an_unknown_kind_are_refused() {
    assert_refused("field `kind`: kind is 12", |t| t.fields[0].kind = 12);
    assert_refused("field `kind`: form is 5", |t| t.fields[0].form = 5);
    assert_refused("a text and padding are made of bytes", |t| {
        t.fields[4].kind = raw::I8
    });
    assert_refused("a text and padding are made of bytes", |t| {
        t.fields[1].kind = raw::BOOL
    });
    assert_refused("pointer to its table is null", |t| t.fields[0].kind = raw::STRUCT);
}

#[test]
fn a_type_that_contains_itself_is_refused_at_once() {
    assert_refused("contains itself", |t| {
        t.fields[0].kind = raw::STRUCT;
        t.fields[0].value_type = &raw const t.ty;
        t.ty.field_count = 1;
    });
    // Expanded to the last level, this would be 5^17 fields.
    assert_refused("a part of 32 bytes in a type of 32", |t| {
        for field in &mut t.fields {
            field.kind = raw::STRUCT;
            field.value_type = &raw const t.ty;
        }
    });
}

#[test]
fn types_are_equal_by_name_and_layout_only() {
    let ty = |change: fn(&mut Tables)| {
        read_changed(change).expect("valid").schemas[0].ports[0]
            .value_type
            .clone()
    };
    let plain = ty(|_| {});
    assert!(plain.same_as(&ty(|t| t.ty.doc = c"Another text.".as_ptr())));
    assert!(plain.same_as(&ty(|t| t.fields[2].unit = c"m".as_ptr())));
    assert!(!plain.same_as(&ty(|t| t.fields[2].name = c"number".as_ptr())));
    assert!(!plain.same_as(&ty(|t| t.fields[2].kind = raw::F32)));
    assert!(!plain.same_as(&ty(|t| t.ty.name = c"demo/msg/Other".as_ptr())));
}
