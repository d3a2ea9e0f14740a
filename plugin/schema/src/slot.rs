//! The position of a port: its number, and the type of schema that it belongs to. In a call of another type,
//! the same number would mean another port, with values of another size. Each use refuses that with one
//! comparison.

use core::fmt;
use core::ptr;

use jde_abi::raw;

/// A port of a type of schema.
#[derive(Clone, Copy)]
pub(crate) struct Slot {
    /// The first port table of its type. Its address identifies the type.
    brand: &'static raw::Port,
    number: u32,
    pub(crate) name: &'static str,
}

impl Slot {
    /// Refers to port `number` of the type with these ports.
    pub(crate) const fn new(ports: &'static [raw::Port], number: u32, name: &'static str) -> Self {
        assert!((number as usize) < ports.len(), "a port has a table");
        Self {
            brand: &ports[0],
            number,
            name,
        }
    }

    /// Refers to a port of a list of the type with these ports.
    pub(crate) const fn listed(ports: &'static [raw::Port], number: u32, name: &'static str) -> Self {
        Self {
            brand: &ports[0],
            number,
            name,
        }
    }

    /// Returns the port's number in a call of the type whose ports start at `ports`.
    ///
    /// # Panics
    /// If the port belongs to another type.
    pub(crate) fn number(&self, ports: *const raw::Port) -> u32 {
        if !ptr::eq(self.brand, ports) {
            panic_foreign_port(self.name)
        }
        self.number
    }

    /// Returns the number of a port that this call has loaned already, so its type is not compared again.
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
fn panic_foreign_port(name: &str) -> ! {
    panic!("`{name}` is a port of another schema than the one that is called; use it in calls of its own")
}
