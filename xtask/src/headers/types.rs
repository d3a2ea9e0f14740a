//! Writes `jde_types.h` and `jde/types.hpp` from the descriptions of the standard types. Each type becomes a C
//! structure of the same bytes and a table that describes it, and a value with a name in C++.

use std::fmt::Write;

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};

use super::names::{block, structure};

pub(super) fn header() -> String {
    let mut out = String::from(
        "/*\n * The standard types of sensors and actuators, with the fields of their ROS 2 interfaces: SI units, axes of REP-103.\n \
         * Each has a structure, and a description `<structure>_type` for tables of ports.\n *\n \
         * Texts are UTF-8 without a NUL. Elements beyond a length are ignored; a length beyond the capacity is invalid.\n *\n \
         * Generated from plugin/types; `cargo xtask headers` renews it.\n */\n\
         #ifndef JDE_TYPES_H\n#define JDE_TYPES_H\n\n#include \"jde.h\"\n\n\
         #ifdef __cplusplus\nextern \"C\" {\n#endif\n\n\
         /** A jde_field at the offset `element`, for the tables below. */\n\
         #define JDE_FIELD(name, element, length, kind, form, capacity, doc, unit, type) \\\n    \
         {(uint32_t)sizeof(jde_field), kind, form, capacity, name, doc, unit, element, length, type, 0u, 0u}\n",
    );
    for ty in jde_types::standard() {
        write_type(&ty, &mut out);
    }
    out.push_str("\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n");
    out
}

/// The header that names the types in C++.
pub(super) fn cplusplus() -> String {
    let types = jde_types::standard();
    let mut out = String::from(
        "/*\n * The standard types of sensors and actuators, as values in C++: the structures of jde_types.h.\n *\n \
         * Generated from plugin/types; `cargo xtask headers` renews it.\n */\n\
         #ifndef JDE_TYPES_HPP\n#define JDE_TYPES_HPP\n\n#include \"value.hpp\"\n\n",
    );
    for ty in &types {
        let _ = writeln!(out, "JDE_DESCRIBED({0}, {0}_type);", c_name(ty));
    }
    out.push_str("\nnamespace jde {\n\n");
    for ty in &types {
        let _ = writeln!(out, "using {} = {};", short_name(ty), c_name(ty));
    }
    out.push_str("\n} // namespace jde\n\n#endif\n");
    out
}

/// A member of a C structure: a field, or padding.
enum Member<'a> {
    Field(&'a Field),
    Padding { offset: usize, bytes: usize },
}

fn write_type(ty: &Type, out: &mut String) {
    let name = c_name(ty);
    let members = members(ty);
    let _ = write!(
        out,
        "\n{}typedef struct {name} {{\n",
        block(&format!("{}: {}", ty.name, ty.doc), "")
    );
    for member in &members {
        match member {
            Member::Field(field) => {
                let unit = if field.unit.is_empty() {
                    String::new()
                } else {
                    format!(" [{}]", field.unit)
                };
                if !field.doc.is_empty() || !unit.is_empty() {
                    out.push_str(&block(&format!("{}{unit}", field.doc), "    "));
                }
                let _ = writeln!(out, "    {};", declare(field));
            }
            Member::Padding { offset, bytes } => {
                let _ = writeln!(out, "    uint8_t padding_{offset}[{bytes}];");
            }
        }
    }
    let _ = writeln!(out, "}} {name};\n");
    let _ = writeln!(
        out,
        "typedef char {name}_has_its_size[sizeof({name}) == {} ? 1 : -1];\n",
        ty.bytes
    );
    let _ = writeln!(out, "static const jde_field {name}_fields[] = {{");
    for member in &members {
        let _ = writeln!(out, "    {},", table(&name, member));
    }
    let _ = writeln!(out, "}};");
    let _ = writeln!(
        out,
        "static const jde_type {name}_type = {{\n    (uint32_t)sizeof(jde_type), JDE_COUNT({name}_fields), {:?}, {:?},\n    \
         sizeof({name}), {}u, {name}_fields}};",
        ty.name, ty.doc, ty.align
    );
}

/// Returns the fields in the order of their offsets, with the gaps between them as padding.
fn members(ty: &Type) -> Vec<Member<'_>> {
    let mut fields: Vec<&Field> = ty.fields.iter().collect();
    fields.sort_by_key(|field| member_offset(field));
    let mut members = Vec::new();
    let mut reached = 0;
    for field in fields {
        if member_offset(field) > reached {
            members.push(Member::Padding {
                offset: reached,
                bytes: member_offset(field) - reached,
            });
        }
        reached = field.offset + field.kind.bytes() * field.form.capacity();
        members.push(Member::Field(field));
    }
    if ty.bytes > reached {
        members.push(Member::Padding {
            offset: reached,
            bytes: ty.bytes - reached,
        });
    }
    members
}

fn member_offset(field: &Field) -> usize {
    field.form.length_offset().unwrap_or(field.offset)
}

fn declare(field: &Field) -> String {
    let (element, name) = (element(field), &field.name);
    match field.form {
        Form::One => format!("{element} {name}"),
        Form::Array(capacity) => format!("{element} {name}[{capacity}]"),
        Form::Sequence {
            capacity,
            length_offset,
        } => {
            let spare = if field.offset == length_offset + 8 {
                " uint32_t spare;"
            } else {
                ""
            };
            format!("struct {{ uint32_t length;{spare} {element} items[{capacity}]; }} {name}")
        }
        Form::Text { capacity, .. } => {
            format!("struct {{ uint32_t length; char bytes[{capacity}]; }} {name}")
        }
    }
}

fn table(of: &str, member: &Member<'_>) -> String {
    let field = match member {
        Member::Field(field) => field,
        Member::Padding { offset, bytes } => {
            return format!(
                "JDE_FIELD(\"_\", offsetof({of}, padding_{offset}), 0u, JDE_U8, JDE_PADDING, {bytes}u, \"\", \"\", NULL)"
            );
        }
    };
    let name = &field.name;
    let (form, element, length) = match field.form {
        Form::One => ("ONE", name.clone(), None),
        Form::Array(_) => ("ARRAY", name.clone(), None),
        Form::Sequence { .. } => (
            "SEQUENCE",
            format!("{name}.items"),
            Some(format!("{name}.length")),
        ),
        Form::Text { .. } => ("TEXT", format!("{name}.bytes"), Some(format!("{name}.length"))),
    };
    let length = length.map_or_else(|| "0u".to_owned(), |length| format!("offsetof({of}, {length})"));
    let ty = match &field.kind {
        FieldKind::Scalar(_) => "NULL".to_owned(),
        FieldKind::Struct(ty) => format!("&{}_type", c_name(ty)),
    };
    format!(
        "JDE_FIELD({name:?}, offsetof({of}, {element}), {length}, {}, JDE_{form}, {}u,\n              {:?}, {:?}, {ty})",
        kind(&field.kind),
        field.form.capacity(),
        field.doc,
        field.unit
    )
}

fn element(field: &Field) -> String {
    match &field.kind {
        FieldKind::Struct(ty) => c_name(ty),
        FieldKind::Scalar(scalar) => match scalar {
            Scalar::Bool | Scalar::U8 => "uint8_t",
            Scalar::U16 => "uint16_t",
            Scalar::U32 => "uint32_t",
            Scalar::U64 => "uint64_t",
            Scalar::I8 => "int8_t",
            Scalar::I16 => "int16_t",
            Scalar::I32 => "int32_t",
            Scalar::I64 => "int64_t",
            Scalar::F32 => "float",
            Scalar::F64 => "double",
        }
        .to_owned(),
    }
}

fn kind(kind: &FieldKind) -> &'static str {
    match kind {
        FieldKind::Struct(_) => "JDE_STRUCT",
        FieldKind::Scalar(scalar) => match scalar {
            Scalar::Bool => "JDE_BOOL",
            Scalar::U8 => "JDE_U8",
            Scalar::U16 => "JDE_U16",
            Scalar::U32 => "JDE_U32",
            Scalar::U64 => "JDE_U64",
            Scalar::I8 => "JDE_I8",
            Scalar::I16 => "JDE_I16",
            Scalar::I32 => "JDE_I32",
            Scalar::I64 => "JDE_I64",
            Scalar::F32 => "JDE_F32",
            Scalar::F64 => "JDE_F64",
        },
    }
}

/// Returns the C name of a type: `jde_laser_scan` for `sensor_msgs/msg/LaserScan`.
fn c_name(ty: &Type) -> String {
    structure(short_name(ty))
}

/// Returns the name of a type without its package.
fn short_name(ty: &Type) -> &str {
    ty.name.rsplit('/').next().unwrap_or(&ty.name)
}
