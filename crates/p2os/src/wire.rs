//! Numbers and strings of a payload: little-endian, strings ended by a zero byte. No field has a meaning
//! here.

use crate::Error;

/// Reads a payload from its beginning.
#[derive(Clone, Debug)]
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
    what: &'static str,
}

/// A value of a fixed form in a payload.
pub(crate) trait Field: Sized {
    fn read(from: &mut Reader<'_>) -> Result<Self, Error>;
    fn write(&self, to: &mut Vec<u8>);
}

impl<'a> Reader<'a> {
    /// Reads `bytes`, which are a `what`.
    pub(crate) fn new(what: &'static str, bytes: &'a [u8]) -> Self {
        Self { rest: bytes, what }
    }

    pub(crate) fn get<T: Field>(&mut self) -> Result<T, Error> {
        T::read(self)
    }

    /// The next value if all of it is there.
    pub(crate) fn optional<T: Field>(&mut self) -> Option<T> {
        let mut ahead = self.clone();
        let value = T::read(&mut ahead).ok()?;
        *self = ahead;
        Some(value)
    }

    /// How many bytes are left.
    pub(crate) fn left(&self) -> usize {
        self.rest.len()
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let (bytes, rest) = self
            .rest
            .split_first_chunk()
            .ok_or(Error::Short { what: self.what })?;
        self.rest = rest;
        Ok(*bytes)
    }
}

macro_rules! number {
    ($($type:ty),*) => { $(
        impl Field for $type {
            fn read(from: &mut Reader<'_>) -> Result<Self, Error> {
                from.take().map(Self::from_le_bytes)
            }

            fn write(&self, to: &mut Vec<u8>) {
                to.extend(self.to_le_bytes());
            }
        }
    )* };
}
number!(u8, i8, u16, i16, u32, i32);

/// One character a byte (ISO 8859-1), so that every name survives; what a byte cannot hold becomes a question
/// mark.
impl Field for String {
    fn read(from: &mut Reader<'_>) -> Result<Self, Error> {
        let end = from.rest.iter().position(|byte| *byte == 0);
        let end = end.ok_or(Error::Short { what: from.what })?;
        let text = from.rest[..end].iter().map(|byte| char::from(*byte)).collect();
        from.rest = &from.rest[end + 1..];
        Ok(text)
    }

    fn write(&self, to: &mut Vec<u8>) {
        let bytes = self.chars().filter(|c| *c != '\0');
        to.extend(bytes.map(|c| u8::try_from(c).unwrap_or(b'?')));
        to.push(0);
    }
}

/// A structure whose fields follow each other, with its reading and writing.
macro_rules! record {
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $field:ident: $type:ty,)* }) => {
        $(#[$about])*
        pub struct $name {
            $($(#[$doc])* pub $field: $type,)*
        }

        impl crate::wire::Field for $name {
            fn read(from: &mut crate::wire::Reader<'_>) -> Result<Self, crate::Error> {
                Ok(Self { $($field: from.get()?,)* })
            }

            fn write(&self, to: &mut Vec<u8>) {
                $(crate::wire::Field::write(&self.$field, to);)*
            }
        }
    };
}
pub(crate) use record;

/// The packet of an id and a record.
///
/// # Errors
/// If its strings make it longer than a packet.
pub(crate) fn packet(id: u8, fields: &impl Field) -> Result<crate::Packet, Error> {
    let mut payload = vec![id];
    fields.write(&mut payload);
    crate::Packet::new(&payload)
}

/// The record of a packet that must have the id; what follows it is left to later versions of the protocol.
pub(crate) fn record_of<T: Field>(what: &'static str, id: u8, packet: &crate::Packet) -> Result<T, Error> {
    if packet.id() != id {
        return Err(Error::Kind {
            what,
            have: packet.id(),
        });
    }
    Reader::new(what, packet.data()).get()
}
