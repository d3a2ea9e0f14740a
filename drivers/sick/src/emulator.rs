//! An emulated scanner by the manual, for tests: modes, password, speeds, configuration, scans and faults. It
//! does no I/O. It parses telegrams independently of the driver, so that it does not share the driver's
//! mistakes.

use jde_device::emulate::Emulator;

use crate::telegram::framed;

/// The scanner.
#[derive(Debug)]
pub(crate) struct EmulatedScanner {
    pub(crate) baud: u32,
    pub(crate) streaming: bool,
    pub(crate) installing: bool,
    pub(crate) block: Vec<u8>,
    pub(crate) view: u16,
    pub(crate) step: u16,
    /// Every value of the next scans.
    pub(crate) value: u16,
    pub(crate) status: u8,
    /// How many of the next telegrams it rejects with NACK, except the command to stop sending.
    pub(crate) nacks: u32,
    /// A command that it refuses.
    pub(crate) refuses: Option<u8>,
    pub(crate) silent: bool,
    /// Whether noise precedes its scans.
    pub(crate) noisy: bool,
    /// How often its configuration was written.
    pub(crate) writes: u32,
    pub(crate) received: Vec<u8>,
}

impl EmulatedScanner {
    /// The factory's settings: 9600 baud, 1 degree, centimetres.
    pub(crate) fn new() -> Self {
        let mut block = vec![0; 32];
        block[2] = 70;
        Self {
            baud: 9600,
            streaming: false,
            installing: false,
            block,
            view: 180,
            step: 100,
            value: 1500,
            status: 0x10,
            nacks: 0,
            refuses: None,
            silent: false,
            noisy: false,
            writes: 0,
            received: Vec::new(),
        }
    }

    fn reply_to(&mut self, telegram: &[u8]) -> Vec<u8> {
        let payload = &telegram[4..telegram.len() - 2];
        assert_eq!(
            telegram,
            framed(0x00, payload),
            "a telegram to a scanner is complete"
        );
        if self.nacks > 0 && payload != [0x20, 0x25] {
            self.nacks -= 1;
            return vec![0x15];
        }
        let mut reply = vec![0x06];
        let refused = self.refuses == Some(payload[0]);
        let mut respond = |data: &[u8]| {
            let payload = [&[payload[0] | 0x80], data, &[self.status]].concat();
            reply.extend(framed(0x80, &payload));
        };
        match payload {
            [0x20, ..] if refused => respond(&[0x02]),
            [0x20, 0x00, password @ ..] => {
                self.installing = password == b"SICK_LMS";
                self.streaming = false;
                respond(&[u8::from(!self.installing)]);
            }
            [0x20, 0x24] => {
                self.streaming = true;
                self.installing = false;
                respond(&[0]);
            }
            [0x20, 0x25] => {
                self.streaming = false;
                self.installing = false;
                respond(&[0]);
            }
            [0x20, speed] => {
                respond(&[0]);
                self.baud = match speed {
                    0x40 => 38_400,
                    0x41 => 19_200,
                    0x42 => 9600,
                    0x48 => 500_000,
                    _ => panic!("no speed: {speed:#x}"),
                };
            }
            [0x3a] => respond(b"LMS200;30106;V02.10 "),
            &[0x3b, view, 0, step, 0] => {
                let accepted = !refused && self.installing;
                respond(&[u8::from(accepted), view, 0, step, 0]);
                if accepted {
                    (self.view, self.step) = (view.into(), step.into());
                }
            }
            [0x74] => respond(&self.block.clone()),
            [0x77, block @ ..] => {
                let accepted = !refused && self.installing;
                respond(&[&[u8::from(accepted)], block].concat());
                if accepted {
                    self.block = block.to_vec();
                    self.writes += 1;
                }
            }
            _ => panic!("no scanner knows this telegram: {payload:02x?}"),
        }
        reply
    }

    /// Switches it off and on, and returns its message.
    pub(crate) fn restart(&mut self) -> Vec<u8> {
        (self.baud, self.streaming, self.installing) = (9600, false, false);
        framed(
            0x80,
            &[&[0x90], &b"LMS200;30106;V02.10 "[..], &[self.status]].concat(),
        )
    }
}

impl Emulator for EmulatedScanner {
    fn receive(&mut self, bytes: &[u8], baud: u32) -> Vec<u8> {
        if self.silent {
            return Vec::new();
        }
        if baud != self.baud {
            // Bytes at the wrong speed are noise in both directions.
            self.received.clear();
            return vec![0x00, 0x15, 0xfe, 0x02, 0x80];
        }
        self.received.extend_from_slice(bytes);
        let mut replies = Vec::new();
        while let Some(start) = self.received.iter().position(|byte| *byte == 0x02) {
            self.received.drain(..start);
            let [_, _, low, high, ..] = *self.received else {
                break;
            };
            let size = 6 + usize::from(low) + 256 * usize::from(high);
            if self.received.len() < size {
                break;
            }
            let telegram: Vec<u8> = self.received.drain(..size).collect();
            replies.extend(self.reply_to(&telegram));
        }
        replies
    }

    fn poll_output(&mut self) -> Vec<u8> {
        if !self.streaming || self.silent {
            return Vec::new();
        }
        let count = self.view * 100 / self.step + 1;
        let head = count | u16::from(self.block[6]) << 14;
        let mut payload = vec![0xb0];
        payload.extend(head.to_le_bytes());
        (0..count).for_each(|_| payload.extend(self.value.to_le_bytes()));
        payload.push(self.status);
        let noise: &[u8] = if self.noisy {
            &[0x02, 0x80, 0x10, 0x00, 0x15, 0x77]
        } else {
            &[]
        };
        [noise, &framed(0x80, &payload)].concat()
    }
}
