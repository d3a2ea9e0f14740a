//! Numbers and strings of a payload: little-endian, strings terminated by a zero byte. It does not interpret
//! them.

use crate::Error;

/// Reads a payload from its start.
#[derive(Clone, Debug)]
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
    record: &'static str,
}

/// A value with a fixed encoding in a payload.
pub(crate) trait Encoded: Sized {
    fn read(from: &mut Reader<'_>) -> Result<Self, Error>;
    fn write(&self, to: &mut Vec<u8>);
}

impl<'a> Reader<'a> {
    /// Creates a reader of `bytes`; `what` names them in errors.
    pub(crate) fn new(what: &'static str, bytes: &'a [u8]) -> Self {
        Self {
            rest: bytes,
            record: what,
        }
    }

    pub(crate) fn get<T: Encoded>(&mut self) -> Result<T, Error> {
        T::read(self)
    }

    /// Returns the next value, if the payload contains all of it.
    pub(crate) fn optional<T: Encoded>(&mut self) -> Option<T> {
        let mut lookahead = self.clone();
        let value = T::read(&mut lookahead).ok()?;
        *self = lookahead;
        Some(value)
    }

    /// Returns the number of bytes that were not read.
    pub(crate) fn remaining(&self) -> usize {
        self.rest.len()
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let (bytes, rest) = self
            .rest
            .split_first_chunk()
            .ok_or(Error::Short { what: self.record })?;
        self.rest = rest;
        Ok(*bytes)
    }
}

macro_rules! number {
    ($($type:ty),*) => { $(
        impl Encoded for $type {
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

/// One byte a character (ISO 8859-1), so that every received name is preserved. A character outside becomes a
/// question mark when written.
impl Encoded for String {
    fn read(from: &mut Reader<'_>) -> Result<Self, Error> {
        let end = from.rest.iter().position(|byte| *byte == 0);
        let end = end.ok_or(Error::Short { what: from.record })?;
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

/// Defines a structure whose fields follow each other, with its decoding and encoding.
macro_rules! record {
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $field:ident: $type:ty,)* }) => {
        $(#[$about])*
        pub struct $name {
            $($(#[$doc])* pub $field: $type,)*
        }

        impl crate::wire::Encoded for $name {
            fn read(from: &mut crate::wire::Reader<'_>) -> Result<Self, crate::Error> {
                Ok(Self { $($field: from.get()?,)* })
            }

            fn write(&self, to: &mut Vec<u8>) {
                $(crate::wire::Encoded::write(&self.$field, to);)*
            }
        }
    };
}
pub(crate) use record;

/// Returns the packet of an id and a record.
///
/// # Errors
/// If its strings make it too long for a packet.
pub(crate) fn packet(id: u8, fields: &impl Encoded) -> Result<crate::Packet, Error> {
    let mut payload = vec![id];
    fields.write(&mut payload);
    crate::Packet::new(&payload)
}

/// Decodes the record of a packet that must have the id. Bytes after it are reserved for later versions of
/// the protocol and ignored.
pub(crate) fn record_of<T: Encoded>(what: &'static str, id: u8, packet: &crate::Packet) -> Result<T, Error> {
    if packet.id() != id {
        return Err(Error::Kind {
            what,
            have: packet.id(),
        });
    }
    Reader::new(what, packet.data()).get()
}
