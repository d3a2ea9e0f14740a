//! An emulation of the device.

use jde_device::emulate::Emulator;

/// A thermometer that replies to each `?` with a line.
pub struct EmulatedThermometer {
    /// The temperature.
    pub celsius: f64,
}

impl Emulator for EmulatedThermometer {
    fn receive(&mut self, bytes: &[u8], _baud: u32) -> Vec<u8> {
        let requests = bytes.iter().filter(|byte| **byte == b'?');
        requests.flat_map(|_| format!("{}\n", self.celsius).into_bytes()).collect()
    }

    /// It sends nothing without a request.
    fn poll_output(&mut self) -> Vec<u8> {
        Vec::new()
    }
}
