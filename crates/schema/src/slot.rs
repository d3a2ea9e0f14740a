//! Where a port is: its number, and the type of schema whose number that is. A port used in a call of another type would mean
//! that one's ports, of other sizes; it is refused at each use, by one comparison.

use core::fmt;
use core::ptr;

use jde_abi::raw;

/// A port of a type of schema.
#[derive(Clone, Copy)]
pub(crate) struct Slot {
    /// The first table of its type, whose place is the type's own.
    brand: &'static raw::Port,
    number: u32,
    pub(crate) name: &'static str,
}

impl Slot {
    /// Port `number` of the type with these ports.
    pub(crate) const fn new(ports: &'static [raw::Port], number: u32, name: &'static str) -> Self {
        assert!((number as usize) < ports.len(), "a port has a table");
        Self {
            brand: &ports[0],
            number,
            name,
        }
    }

    /// Its number in a call of the type whose ports begin there.
    ///
    /// # Panics
    /// If that is another type.
    pub(crate) fn number(&self, ports: *const raw::Port) -> u32 {
        if !ptr::eq(self.brand, ports) {
            stranger(self.name)
        }
        self.number
    }

    /// The same for what the present call has already loaned.
    pub(crate) fn number_loaned(&self) -> u32 {
        self.number
    }
}

impl fmt::Debug for Slot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.number, self.name)
    }
}

#[cold]
fn stranger(name: &str) -> ! {
    panic!("`{name}` is a port of another schema than the one that is called; use it in calls of its own")
}
