//! The description of a plugin as the inspecting process sends it: the structures of [`describe`], field
//! by field. Both ends are the same build; the format is never stored.

use std::sync::Arc;

use jde_abi::describe;
use serde::{Deserialize, Serialize};

/// [`describe::Plugin`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Plugin")]
pub(super) struct Plugin {
    name: String,
    version: String,
    doc: String,
    abi: (u32, u32),
    throws: bool,
    isolated: bool,
    #[serde(with = "schemas")]
    schemas: Vec<describe::Schema>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Schema")]
struct Schema {
    name: String,
    doc: String,
    #[serde(with = "Kind")]
    kind: describe::Kind,
    period_ns: u64,
    budget_ns: Option<u64>,
    #[serde(with = "ports")]
    ports: Vec<describe::Port>,
    #[serde(with = "children")]
    children: Vec<describe::Child>,
    arbitrates: bool,
    panel: bool,
    inspects: bool,
    #[serde(with = "optional")]
    guard: Option<describe::Guard>,
    #[serde(with = "lists")]
    lists: Vec<describe::PortList>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::PortList")]
struct PortList {
    name: String,
    doc: String,
    #[serde(with = "ListKind")]
    kind: describe::ListKind,
    #[serde(with = "shared")]
    settings: Arc<describe::Type>,
    initial: Vec<u8>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::ListKind")]
enum ListKind {
    Imports,
    Exports {
        #[serde(with = "Validity")]
        validity: describe::Validity,
    },
    Commands {
        validity_ns: u64,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "jde_abi::lists::ListedPort")]
struct ListedPort {
    list: usize,
    label: String,
    #[serde(with = "shared")]
    value_type: Arc<describe::Type>,
    settings: Vec<u8>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Guard")]
struct Guard {
    state: usize,
    #[serde(with = "shared")]
    command: Arc<describe::Type>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Kind")]
enum Kind {
    Perceptive,
    Motor,
    Driver,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Port")]
struct Port {
    name: String,
    doc: String,
    unit: String,
    #[serde(with = "shared")]
    value_type: Arc<describe::Type>,
    #[serde(with = "Role")]
    role: describe::Role,
    optional: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Role")]
enum Role {
    Import {
        trigger: bool,
    },
    Export {
        #[serde(with = "Validity")]
        validity: describe::Validity,
    },
    Modulation {
        default: Vec<u8>,
        #[serde(with = "Limits")]
        limits: describe::Limits,
        fixed: bool,
    },
    Command {
        neutral: Vec<u8>,
        validity_ns: u64,
        trigger: bool,
    },
    Actuator,
    ChildModulation {
        child: usize,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Validity")]
enum Validity {
    Periods,
    Time(u64),
    Lasting,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Limits")]
struct Limits {
    least: Option<f64>,
    greatest: Option<f64>,
    choices: Vec<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Child")]
struct Child {
    name: String,
    doc: String,
    motor: bool,
    group: String,
    optional: bool,
    many: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Type")]
struct Type {
    name: String,
    doc: String,
    bytes: usize,
    align: usize,
    #[serde(with = "fields")]
    fields: Vec<describe::Field>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Field")]
struct Field {
    name: String,
    doc: String,
    unit: String,
    #[serde(with = "FieldKind")]
    kind: describe::FieldKind,
    #[serde(with = "Form")]
    form: describe::Form,
    offset: usize,
    #[serde(with = "RosNotation")]
    notation: describe::RosNotation,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::RosNotation")]
struct RosNotation {
    is_byte: bool,
    is_bounded: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::FieldKind")]
enum FieldKind {
    Scalar(#[serde(with = "Scalar")] describe::Scalar),
    Struct(#[serde(with = "shared")] Arc<describe::Type>),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Scalar")]
enum Scalar {
    Bool,
    U8,
    U16,
    U32,
    U64,
    I8,
    I16,
    I32,
    I64,
    F32,
    F64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "describe::Form")]
enum Form {
    One,
    Array(usize),
    Sequence { capacity: usize, length_offset: usize },
    Text { capacity: usize, length_offset: usize },
}

/// A type that several ports or fields may share.
mod shared {
    use std::cell::Cell;
    use std::sync::Arc;

    use jde_abi::describe;
    use serde::de::Error;
    use serde::{Deserializer, Serializer};

    use super::Type;

    /// More than the ABI lets types nest; a damaged process could send any depth.
    const MAX_DEPTH: usize = 32;
    thread_local! {
        /// The types around the one that is read.
        static DEPTH: Cell<usize> = const { Cell::new(0) };
    }

    pub(super) fn serialize<S: Serializer>(ty: &Arc<describe::Type>, to: S) -> Result<S::Ok, S::Error> {
        Type::serialize(ty, to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<describe::Type>, D::Error> {
        let depth = DEPTH.get();
        if depth == MAX_DEPTH {
            return Err(D::Error::custom("its type nests too deeply"));
        }
        DEPTH.set(depth + 1);
        let read = Type::deserialize(from);
        DEPTH.set(depth);
        read.map(Arc::new)
    }
}

/// What a guard judges, if the schema is one.
mod optional {
    use jde_abi::describe;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::Guard;

    #[derive(Serialize, Deserialize)]
    struct Item(#[serde(with = "Guard")] describe::Guard);

    pub(super) fn serialize<S: Serializer>(
        guard: &Option<describe::Guard>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        guard.clone().map(Item).serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<describe::Guard>, D::Error> {
        let item = Option::<Item>::deserialize(from)?;
        Ok(item.map(|Item(guard)| guard))
    }
}

/// Lists of the structures above.
macro_rules! lists {
    ($($visible:vis $name:ident: $module:path, $form:ident as $with:literal;)*) => {$(
        $visible mod $name {
            use $module as module;
            use serde::{Deserialize, Deserializer, Serialize, Serializer};

            use super::$form;

            pub(crate) fn serialize<S: Serializer>(list: &[module::$form], to: S) -> Result<S::Ok, S::Error> {
                #[derive(Serialize)]
                struct Item<'a>(#[serde(with = $with)] &'a module::$form);
                to.collect_seq(list.iter().map(Item))
            }

            pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<module::$form>, D::Error> {
                #[derive(Deserialize)]
                struct Item(#[serde(with = $with)] module::$form);
                let list = Vec::<Item>::deserialize(from)?;
                Ok(list.into_iter().map(|Item(item)| item).collect())
            }
        }
    )*};
}

lists! {
    schemas: jde_abi::describe, Schema as "Schema";
    ports: jde_abi::describe, Port as "Port";
    children: jde_abi::describe, Child as "Child";
    fields: jde_abi::describe, Field as "Field";
    lists: jde_abi::describe, PortList as "PortList";
    pub(crate) listed: jde_abi::lists, ListedPort as "ListedPort";
}
