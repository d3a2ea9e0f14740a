//! The checked description of a plugin as owned values, which the host, the tools and the recordings use.
//!
//! [`crate::read`] creates it; only tests create it otherwise. It contains no pointer into a plugin.

mod attributes;
mod differs;
mod guard;
mod limits;
mod lists;
mod modulations;
mod notation;
pub(crate) mod shared;
mod validity;

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use attributes::{ATTRIBUTES, Attribute, Attributes};
pub use guard::Guard;
pub use limits::{Limits, NotAllowed};
pub use lists::{ListKind, PortList};
pub use notation::RosNotation;
pub use validity::Validity;

/// A plugin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plugin {
    /// Name, the first half of a type's full name.
    pub name: String,
    /// Version, in the author's own numbering.
    pub version: String,
    /// One sentence about it.
    pub doc: String,
    /// Its ABI version.
    pub abi: (u32, u32),
    /// Whether a C++ exception may leave its functions: it uses the C++ library and does not declare that it
    /// catches exceptions.
    pub throws: bool,
    /// Whether each of its schemas runs in a process of its own, whatever the application states: it is not a
    /// library.
    pub isolated: bool,
    /// Its types of schema.
    pub schemas: Vec<Schema>,
}

/// A type of schema.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Schema {
    /// Name, the second half of its full name.
    pub name: String,
    /// What it does.
    pub doc: String,
    /// Its kind.
    pub kind: Kind,
    /// Default period, ns.
    pub period_ns: u64,
    /// Longest iteration, ns. `None` if it is the period that the application sets.
    pub budget_ns: Option<u64>,
    /// Inputs and outputs. The number of a port is its index.
    pub ports: Vec<Port>,
    /// Roles of children. The number of a child is its index.
    pub children: Vec<Child>,
    /// Whether it has an arbitration function.
    pub arbitrates: bool,
    /// Whether it has a panel.
    pub panel: bool,
    /// Whether that panel receives gestures.
    pub touch: bool,
    /// Whether another build of it continues from its memory.
    pub memory: bool,
    /// Whether it inspects what its modulations name.
    pub inspects: bool,
    /// What it judges, if it is a guard (R18).
    pub guard: Option<Guard>,
    /// Its lists of ports, whose entries the application states.
    pub lists: Vec<PortList>,
}

/// Kinds of schema.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// Turns data into better data.
    #[default]
    Perceptive,
    /// Has a precondition and competes.
    Motor,
    /// Exports sensors and takes commands.
    Driver,
}

/// An input or output of a type of schema.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Port {
    /// Name.
    pub name: String,
    /// What it means.
    pub doc: String,
    /// Unit of a plain number; empty if it has none.
    pub unit: String,
    /// Type of its value.
    #[serde(with = "shared")]
    pub value_type: Arc<Type>,
    /// Its direction, with the data of that direction.
    pub role: Role,
    /// What it has besides.
    pub attributes: Attributes,
    /// The name that a modulation had before.
    pub former_name: Option<String>,
}

/// The direction of a port.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Role {
    /// Reads another schema's variable.
    Import,
    /// Writes a variable.
    Export {
        /// How long a value is valid (R19).
        validity: Validity,
    },
    /// Input that the father or an operator writes.
    Modulation {
        /// The value until the first write.
        default: Vec<u8>,
        /// The allowed values.
        limits: Limits,
    },
    /// Input of a driver that reaches an actuator.
    Command {
        /// Value that stops the actuator.
        neutral: Vec<u8>,
        /// How long a command is in force, ns.
        validity_ns: u64,
    },
    /// Writes a driver's command.
    Actuator,
    /// Writes a modulation of a child.
    ChildModulation {
        /// The child's number.
        child: usize,
    },
}

/// A role for a child.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Child {
    /// Name of the role.
    pub name: String,
    /// What the child is for.
    pub doc: String,
    /// Whether the child is a motor schema, which competes. Otherwise it is a perceptive one.
    pub motor: bool,
    /// Group in which it competes.
    pub group: String,
    /// Whether the application may leave it unbound.
    pub optional: bool,
    /// Whether the application may name any number of children for this role. It stays true for each named
    /// child.
    pub many: bool,
}

/// A type of value. Two types are equal if their names and layouts are. Units and docs may differ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Type {
    /// Name, in the notation of ROS 2.
    pub name: String,
    /// What it means.
    pub doc: String,
    /// Bytes of a value.
    pub bytes: usize,
    /// Alignment of a value.
    pub align: usize,
    /// Its fields, in the order of their ROS interface.
    pub fields: Vec<Field>,
}

/// A field of a type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Field {
    /// Name.
    pub name: String,
    /// What it means.
    pub doc: String,
    /// Unit; empty for none.
    pub unit: String,
    /// Kind of its elements.
    pub kind: FieldKind,
    /// How many elements.
    pub form: Form,
    /// Bytes from the start of the value to the first element.
    pub offset: usize,
    /// How the interface of ROS 2 differs.
    pub notation: RosNotation,
}

/// Kind of a field's elements.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum FieldKind {
    /// A number or a bool.
    Scalar(Scalar),
    /// A structure.
    Struct(#[serde(with = "shared")] Arc<Type>),
}

/// Kinds of scalars.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are self-explanatory")]
pub enum Scalar {
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

/// How many elements a field has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Form {
    /// One.
    One,
    /// A fixed number.
    Array(usize),
    /// Up to a capacity. Their number is a `u32` at the offset.
    Sequence {
        /// Most elements.
        capacity: usize,
        /// The offset of their number.
        length_offset: usize,
    },
    /// UTF-8 up to a capacity. The number of bytes is a `u32` at the offset.
    Text {
        /// Most bytes.
        capacity: usize,
        /// The offset of their number.
        length_offset: usize,
    },
}

impl Schema {
    /// Returns the schema with these ports after its own.
    #[must_use]
    pub fn with_ports(&self, listed: impl IntoIterator<Item = Port>) -> Self {
        let mut ports = self.ports.clone();
        ports.extend(listed);
        Self {
            ports,
            ..self.clone()
        }
    }

    /// Returns the schema with these children, each with its group, instead of the role for any number of
    /// children.
    #[must_use]
    pub fn with_children<'n>(&self, named: impl IntoIterator<Item = (&'n str, &'n str)>) -> Self {
        let (many, mut children): (Vec<Child>, Vec<Child>) =
            self.children.iter().cloned().partition(|child| child.many);
        if let Some(role) = many.into_iter().next() {
            children.extend(named.into_iter().map(|(name, group)| Child {
                name: name.to_owned(),
                group: group.to_owned(),
                ..role.clone()
            }));
        }
        Self {
            children,
            ..self.clone()
        }
    }
}

impl Scalar {
    /// Returns its size in bytes.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Self::Bool | Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// Returns its name in ROS 2 interface definitions.
    #[must_use]
    pub fn ros_name(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::U8 => "uint8",
            Self::U16 => "uint16",
            Self::U32 => "uint32",
            Self::U64 => "uint64",
            Self::I8 => "int8",
            Self::I16 => "int16",
            Self::I32 => "int32",
            Self::I64 => "int64",
            Self::F32 => "float32",
            Self::F64 => "float64",
        }
    }
}

impl FieldKind {
    /// Returns the size of one element in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match self {
            Self::Scalar(scalar) => scalar.bytes(),
            Self::Struct(ty) => ty.bytes,
        }
    }

    /// Returns the alignment of one element.
    #[must_use]
    pub fn align(&self) -> usize {
        match self {
            Self::Scalar(scalar) => scalar.bytes(),
            Self::Struct(ty) => ty.align,
        }
    }
}

impl Field {
    /// Returns how many of its elements are present in a value, at most its capacity.
    ///
    /// # Panics
    /// If the value has fewer bytes than its type.
    #[must_use]
    pub fn length(&self, value: &[u8]) -> usize {
        let capacity = self.form.capacity();
        self.form.length_offset().map_or(capacity, |offset| {
            let mut bytes = [0; 4];
            bytes.copy_from_slice(&value[offset..][..4]);
            capacity.min(u32::from_ne_bytes(bytes) as usize)
        })
    }
}

impl Form {
    /// Returns the largest number of elements.
    #[must_use]
    pub fn capacity(self) -> usize {
        match self {
            Self::One => 1,
            Self::Array(capacity) | Self::Sequence { capacity, .. } | Self::Text { capacity, .. } => capacity,
        }
    }

    /// Returns the offset of the number of elements, if that number varies.
    #[must_use]
    pub fn length_offset(self) -> Option<usize> {
        match self {
            Self::One | Self::Array(_) => None,
            Self::Sequence { length_offset, .. } | Self::Text { length_offset, .. } => Some(length_offset),
        }
    }
}

impl Type {
    /// Returns a number that identifies the name and the layout. Others have the same number with a
    /// probability of 2^-64.
    ///
    /// FNV-1a (Fowler, Noll, Vo) over the name and each field's name, kind, form and offset.
    #[must_use]
    pub fn hash(&self) -> u64 {
        let mut hash = Fnv::new();
        self.feed(&mut hash);
        hash.0
    }

    /// Returns whether the two have the same name and layout.
    #[must_use]
    pub fn same_as(&self, other: &Self) -> bool {
        self.name == other.name && self.hash() == other.hash()
    }

    /// Returns the scalar, if the type is a plain number: one scalar as its only field.
    #[must_use]
    pub fn as_number(&self) -> Option<Scalar> {
        match self.fields.as_slice() {
            [
                Field {
                    kind: FieldKind::Scalar(scalar),
                    form: Form::One,
                    ..
                },
            ] => Some(*scalar),
            _ => None,
        }
    }

    /// Returns a copy of a value, with zeros in place of the elements of its sequences that are not present.
    ///
    /// # Panics
    /// If it has not as many bytes as the type.
    #[must_use]
    pub fn copy(&self, value: &[u8]) -> Vec<u8> {
        // Memory of the system is zero and costs nothing until it is written: most of a large value is empty.
        let mut copy = vec![0; self.bytes];
        self.copy_into(value, &mut copy);
        copy
    }

    /// Copies a value without the elements of its sequences that are not present. Their bytes in `to` stay as they
    /// are.
    ///
    /// # Panics
    /// If one of the two has not as many bytes as the type.
    pub fn copy_into(&self, value: &[u8], to: &mut [u8]) {
        assert_eq!(
            (value.len(), to.len()),
            (self.bytes, self.bytes),
            "a `{}`",
            self.name
        );
        let mut copied = 0;
        for field in &self.fields {
            let Form::Sequence { capacity, .. } = field.form else {
                continue;
            };
            let end = field.offset + field.length(value) * field.kind.bytes();
            // A field that lies before others of the list is copied with them.
            if end >= copied {
                to[copied..end].copy_from_slice(&value[copied..end]);
                copied = field.offset + capacity * field.kind.bytes();
            }
        }
        to[copied..].copy_from_slice(&value[copied..]);
    }

    fn feed(&self, hash: &mut Fnv) {
        hash.text(&self.name);
        hash.number(self.bytes as u64);
        hash.number(self.align as u64);
        for field in &self.fields {
            hash.text(&field.name);
            hash.number(field.offset as u64);
            hash.number(field.form.capacity() as u64);
            hash.number(match field.form {
                Form::One => 0,
                Form::Array(_) => 1,
                Form::Sequence { .. } => 2,
                Form::Text { .. } => 3,
            });
            hash.number(
                field
                    .form
                    .length_offset()
                    .map_or(u64::MAX, |offset| offset as u64),
            );
            match &field.kind {
                FieldKind::Scalar(scalar) => hash.text(scalar.ros_name()),
                FieldKind::Struct(ty) => ty.feed(hash),
            }
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Perceptive => "perceptive",
            Self::Motor => "motor",
            Self::Driver => "driver",
        })
    }
}

struct Fnv(u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn text(&mut self, text: &str) {
        self.number(text.len() as u64);
        text.bytes().for_each(|byte| self.byte(byte));
    }

    fn number(&mut self, number: u64) {
        number.to_le_bytes().into_iter().for_each(|byte| self.byte(byte));
    }

    fn byte(&mut self, byte: u8) {
        self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
}
