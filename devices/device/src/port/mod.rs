//! Byte streams to devices: one address for a serial line or a TCP connection. The owner polls the port. It
//! never blocks (except in `flush`) and reconnects by itself. It knows no protocol, keeps no clock and prints
//! nothing.
//!
//! ```
//! use core::time::Duration;
//! use jde_device::port::{Address, Backoff, Port, Pty};
//!
//! # fn main() -> Result<(), Box<dyn core::error::Error>> {
//! let device = Pty::open()?;
//! let address = Address::parse(&format!("serial:{}@9600", device.path().display()))?;
//! let mut port = Port::new(address, Backoff::default());
//! # let start = std::time::Instant::now();
//! while !port.poll(start.elapsed()).is_connected() {
//!     // The owner's next iteration.
//! #   std::thread::yield_now();
//! }
//! let mut received = Vec::new();
//! port.write(b"who are you?");
//! port.read(&mut received);
//! # Ok(())
//! # }
//! ```

mod address;
mod backoff;
mod connect;
mod modem;
mod pty;
mod serial;
mod state;

pub use address::{Address, AddressError, Framing, Parity};
pub use backoff::Backoff;
pub use connect::configure_stream;
pub use pty::Pty;
pub use state::{Port, PortState};
