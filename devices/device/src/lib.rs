//! The common part of drivers for devices. A [`port`] is a byte stream that reconnects, a [`Device`] runs a
//! protocol over a port, a [`ConnectionReport`] exports the state of the connection, and [`emulate`] emulates
//! devices in tests. It knows no particular device: the driver defines the protocol and its exports.
//!
//! A driver for another device at a serial line or behind TCP can start from this example, a thermometer that
//! replies to `?` with a line:
//!
//! ```
//! use core::time::Duration;
//! use jde_device::emulate::{EmulatedDevice, Emulator, DriverTest};
//! use jde_device::{Protocol, Device, Event};
//! use jde_device::port::{Address, Backoff, Port};
//! use jde_schema::prelude::*;
//!
//! /// A thermometer.
//! #[derive(Describe)]
//! #[schema(driver, period = "10ms")]
//! struct Thermometer {
//!     /// The address: "serial:/dev/ttyUSB0@9600", or "tcp:HOST:PORT".
//!     #[modulation(default = "", fixed)]
//!     port: Modulation<Text<256>>,
//!     /// The temperature, in degrees Celsius.
//!     #[export]
//!     temperature: Export<f64>,
//!     /// The state of the connection.
//!     #[export]
//!     connection: Export<Connection>,
//!     device: Option<Device<Session>>,
//! }
//!
//! impl Schema for Thermometer {
//!     fn awake(&mut self, cx: &Context) -> Result {
//!         cx.require_real_time()?;
//!         let address = Address::parse(self.port.get(cx).as_str())?;
//!         self.device = Some(Device::new(Port::new(address, Backoff::default()), ()));
//!         Ok(())
//!     }
//!
//!     fn iterate(&mut self, cx: &Context) -> Result {
//!         let Some(device) = &mut self.device else {
//!             return Err("the driver is not awake".into());
//!         };
//!         for celsius in device.step(cx) {
//!             self.temperature.write(cx, celsius);
//!         }
//!         if !device.is_ready() {
//!             self.temperature.retract(cx);
//!         }
//!         device.export_connection(cx, &mut self.connection);
//!         Ok(())
//!     }
//!
//!     fn sleep(&mut self, cx: &Context) {
//!         if let Some(device) = self.device.take() {
//!             device.close(cx, &mut self.connection);
//!             self.temperature.retract(cx);
//!         }
//!     }
//! }
//!
//! /// The protocol. It does no I/O, so that it can be tested without a wire.
//! struct Session {
//!     line: Vec<u8>,
//!     ready: bool,
//!     queried: Duration,
//! }
//!
//! impl Protocol for Session {
//!     const DEVICE: &'static str = "thermometer";
//!     type Config = ();
//!     type Data = f64;
//!
//!     fn start((): (), now: Duration, events: &mut Vec<Event<f64>>) -> Self {
//!         events.push(Event::Send(b"?".to_vec()));
//!         Self { line: Vec::new(), ready: false, queried: now }
//!     }
//!
//!     fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event<f64>>) {
//!         self.line.extend_from_slice(bytes);
//!         if let Some(end) = self.line.iter().position(|byte| *byte == b'\n') {
//!             let line: Vec<u8> = self.line.drain(..=end).collect();
//!             match String::from_utf8_lossy(&line).trim().parse() {
//!                 Ok(celsius) => {
//!                     if !self.ready {
//!                         self.ready = true;
//!                         events.push(Event::Ready("a thermometer".to_owned()));
//!                     }
//!                     events.push(Event::Data(celsius));
//!                 }
//!                 Err(error) => events.push(Event::Warn(format!("the reply is not a number: {error}"))),
//!             }
//!             self.queried = now;
//!             events.push(Event::Send(b"?".to_vec()));
//!         } else if now > self.queried + Duration::from_secs(3) {
//!             events.push(Event::Disconnect("no reply within 3 s".to_owned()));
//!         }
//!     }
//!
//!     fn is_ready(&self) -> bool {
//!         self.ready
//!     }
//!
//!     fn closing_bytes() -> Vec<u8> {
//!         Vec::new()
//!     }
//! }
//!
//! // Its test, with an emulated thermometer at a pseudo-terminal.
//! struct FakeThermometer(f64);
//!
//! impl Emulator for FakeThermometer {
//!     fn receive(&mut self, bytes: &[u8], _baud: u32) -> Vec<u8> {
//!         bytes.iter().flat_map(|_| format!("{}\n", self.0).into_bytes()).collect()
//!     }
//!
//!     fn poll_output(&mut self) -> Vec<u8> {
//!         Vec::new()
//!     }
//! }
//!
//! let (thermometer, path) = EmulatedDevice::at_pty(FakeThermometer(21.5));
//! let mut test = DriverTest::<Thermometer>::with_port(&format!("serial:{}@9600", path.display()));
//! test.awake();
//! test.run_until(|bench| bench.exported("temperature") == Some(21.5));
//! assert_eq!(test.connection(), (Connection::CONNECTED, "a thermometer".to_owned()));
//! drop(thermometer);
//! test.run_until(|bench| bench.exported::<f64>("temperature").is_none());
//! ```

mod device;
pub mod emulate;
mod inspect;
pub mod port;
mod report;

pub use device::{Device, Event, Protocol};
pub use inspect::inspect_port;
pub use report::{ConnectionReport, ConnectionState};
