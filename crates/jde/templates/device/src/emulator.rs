//! The device in software, by its manual.

use jde_device::emulate::Emulator;

/// A thermometer. It answers every `?` with a line.
pub struct EmulatedThermometer {
    /// How warm it is.
    pub celsius: f64,
}

impl Emulator for EmulatedThermometer {
    fn receive(&mut self, bytes: &[u8], _baud: u32) -> Vec<u8> {
        let questions = bytes.iter().filter(|byte| **byte == b'?');
        questions.flat_map(|_| format!("{}\n", self.celsius).into_bytes()).collect()
    }

    /// It sends nothing that nobody asked for.
    fn poll_output(&mut self) -> Vec<u8> {
        Vec::new()
    }
}
