//! XDR (RFC 4506) as Player uses it: big-endian, each item a multiple of four bytes. An integer below 32 bits
//! takes four bytes. An array is preceded by its count twice: as a field of the structure, and as part of the
//! array.

use crate::{Device, Error};

/// Reads the fields of a message in order. Bytes after the last field are ignored, because later versions
/// append fields.
#[derive(Clone, Debug)]
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
    device: Device,
}

/// A value of fixed size.
pub(crate) trait FixedValue: Sized {
    /// Bytes on the wire.
    const SIZE: usize;

    fn read(bytes: &[u8]) -> Self;
}

macro_rules! number {
    ($($type:ty),*) => { $(
        impl FixedValue for $type {
            const SIZE: usize = size_of::<Self>();

            fn read(bytes: &[u8]) -> Self {
                bytes.try_into().map_or_else(|_| Self::default(), Self::from_be_bytes)
            }
        }
    )* };
}
number!(u32, i32, f32, f64);

impl<'a> Reader<'a> {
    /// Reads a body; `device` names its sender in errors.
    pub(crate) fn new(device: Device, body: &'a [u8]) -> Self {
        Self { rest: body, device }
    }

    pub(crate) fn get<T: FixedValue>(&mut self, what: &'static str) -> Result<T, Error> {
        self.take(T::SIZE, what).map(T::read)
    }

    pub(crate) fn flag(&mut self, what: &'static str) -> Result<bool, Error> {
        Ok(self.get::<u32>(what)? != 0)
    }

    pub(crate) fn array<T: FixedValue>(&mut self, what: &'static str) -> Result<Vec<T>, Error> {
        let count = self.count(what)?;
        let size = count.saturating_mul(T::SIZE);
        Ok(self
            .take(size, what)?
            .chunks_exact(T::SIZE)
            .map(T::read)
            .collect())
    }

    pub(crate) fn bytes(&mut self, what: &'static str) -> Result<&'a [u8], Error> {
        let count = self.count(what)?;
        let padded = self.take(count.next_multiple_of(4), what)?;
        Ok(&padded[..count])
    }

    fn count(&mut self, what: &'static str) -> Result<usize, Error> {
        let (first, second): (u32, u32) = (self.get(what)?, self.get(what)?);
        if first != second {
            let device = self.device;
            return Err(Error::Count {
                device,
                what,
                first,
                second,
            });
        }
        Ok(first as usize)
    }

    fn take(&mut self, size: usize, what: &'static str) -> Result<&'a [u8], Error> {
        let device = self.device;
        let (bytes, rest) = self
            .rest
            .split_at_checked(size)
            .ok_or(Error::Short { device, what })?;
        self.rest = rest;
        Ok(bytes)
    }
}
