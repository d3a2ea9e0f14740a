//! An emulated scanner by the specification, for tests: speeds, the old protocol, the data sheet, scans and
//! faults. It does no I/O.

use jde_device::emulate::Emulator;

use crate::message::checksum;

/// The scanner.
#[derive(Clone, Debug)]
pub(crate) struct EmulatedScanner {
    pub(crate) baud: u32,
    /// Whether it still uses its old protocol, SCIP 1.
    pub(crate) scip1: bool,
    pub(crate) laser: bool,
    /// The request to which it sends scans, while it streams.
    pub(crate) streaming: Option<String>,
    pub(crate) sheet: &'static [&'static str],
    /// Every distance of its scans, mm.
    pub(crate) distance: u32,
    /// Its clock, ms.
    pub(crate) clock: u32,
    pub(crate) silent: bool,
    pub(crate) noisy: bool,
    /// A request that it refuses, and the status of the refusal.
    pub(crate) refuses: Option<(&'static str, &'static str)>,
    /// The status of its scans.
    pub(crate) status: &'static str,
    pub(crate) received: Vec<u8>,
}

/// Encodes a number in letters.
pub(crate) fn letters(value: u32, count: usize) -> Vec<u8> {
    (0..count)
        .rev()
        .map(|digit| (value >> (6 * digit) & 0x3f) as u8 + 0x30)
        .collect()
}

fn with_sum(line: &[u8]) -> Vec<u8> {
    [line, &[checksum(line)]].concat()
}

/// The lines of a scan, starting with the time stamp.
pub(crate) fn scan_lines(stamp: u32, values: &[u32], count: usize) -> Vec<Vec<u8>> {
    let data: Vec<u8> = values.iter().flat_map(|value| letters(*value, count)).collect();
    core::iter::once(with_sum(&letters(stamp, 4)))
        .chain(data.chunks(64).map(with_sum))
        .collect()
}

impl EmulatedScanner {
    /// A URG-04LX at a serial line, just switched on.
    pub(crate) fn urg() -> Self {
        Self {
            baud: 19_200,
            scip1: true,
            laser: false,
            streaming: None,
            sheet: &[
                "MODL:URG-04LX(Hokuyo Automatic Co., Ltd.)",
                "DMIN:20",
                "DMAX:5600",
                "ARES:1024",
                "AMIN:44",
                "AMAX:725",
                "AFRT:384",
                "SCAN:600",
            ],
            distance: 1500,
            clock: 0xff_fff0,
            silent: false,
            noisy: false,
            refuses: None,
            status: "99",
            received: Vec::new(),
        }
    }

    /// A UTM-30LX-EW, connected over Ethernet.
    pub(crate) fn utm() -> Self {
        Self {
            scip1: false,
            sheet: &[
                "MODL:UTM-30LX-EW",
                "DMIN:23",
                "DMAX:60000",
                "ARES:1440",
                "AMIN:0",
                "AMAX:1080",
                "AFRT:540",
                "SCAN:2400",
            ],
            distance: 12_345,
            ..Self::urg()
        }
    }

    fn reply_to(&mut self, request: &str) -> Vec<u8> {
        let (mut status, mut lines) = ("00", Vec::new());
        let checked = |line: &&str| format!("{line};{}", char::from(checksum(line.as_bytes())));
        if let Some((refused, refusal)) = self.refuses
            && request.starts_with(refused)
        {
            return reply(request, refusal, &[]);
        }
        if self.scip1 {
            self.scip1 = request != "SCIP2.0";
            // Replies of the old protocol have one digit and no checksum.
            return format!("{request}\n{}\n\n", if self.scip1 { "E" } else { "0" }).into_bytes();
        }
        match request.get(..2) {
            Some("QT") => (self.laser, self.streaming) = (false, None),
            Some("BM") => {
                status = if self.laser { "02" } else { "00" };
                self.laser = true;
            }
            Some("VV") => {
                lines = [
                    "VEND:Hokuyo Automatic Co., Ltd.",
                    "PROD:SOKUIKI Sensor",
                    "FIRM:3.4.03",
                    "PROT:SCIP 2.0",
                    "SERI:H0906091",
                ]
                .iter()
                .map(checked)
                .collect();
            }
            Some("PP") => lines = self.sheet.iter().map(checked).collect(),
            Some("II") => {
                lines = ["LASR:OFF", "STAT:Sensor works well."]
                    .iter()
                    .map(checked)
                    .collect()
            }
            Some("SS") => {
                let reply = reply(request, "00", &[]);
                self.baud = request[2..].parse().expect("six digits");
                assert_eq!(request.len(), 8);
                return reply;
            }
            Some("MD" | "MS") => {
                assert!(request.len() == 15 && request.ends_with("00"), "{request}");
                self.laser = true;
                self.streaming = Some(request.to_owned());
            }
            _ => status = "0E",
        }
        reply(request, status, &lines)
    }
}

impl Emulator for EmulatedScanner {
    fn receive(&mut self, bytes: &[u8], baud: u32) -> Vec<u8> {
        if self.silent {
            return Vec::new();
        }
        if baud != self.baud {
            self.received.clear();
            return vec![0xf8, 0x00, b'\n', b'\n', 0x8e];
        }
        self.received.extend_from_slice(bytes);
        let mut replies = Vec::new();
        while let Some(end) = self.received.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = self.received.drain(..=end).collect();
            let request = String::from_utf8(line[..end].to_vec()).expect("requests are letters");
            replies.extend(self.reply_to(&request));
        }
        replies
    }

    fn poll_output(&mut self) -> Vec<u8> {
        self.clock = (self.clock + 25) & 0xff_ffff;
        let Some(request) = self.streaming.as_ref().filter(|_| !self.silent) else {
            return Vec::new();
        };
        let step = |digits: core::ops::Range<usize>| request[digits].parse::<u32>().expect("digits");
        let count = (step(6..10) - step(2..6)) / step(10..12) + 1;
        let letters = if request.starts_with("MD") { 3 } else { 2 };
        let lines = match self.status {
            "99" => scan_lines(self.clock, &vec![self.distance; count as usize], letters),
            _ => Vec::new(),
        };
        let mut output = if self.noisy {
            b"\xff\x80noise\n\n".to_vec()
        } else {
            Vec::new()
        };
        output.extend(format!("{request}\n").bytes());
        output.extend(with_sum(self.status.as_bytes()));
        output.push(b'\n');
        lines
            .iter()
            .for_each(|line| output.extend([line, &b"\n"[..]].concat()));
        output.push(b'\n');
        output
    }
}

fn reply(request: &str, status: &str, lines: &[String]) -> Vec<u8> {
    let sum = char::from(checksum(status.as_bytes()));
    let lines: String = lines.iter().map(|line| format!("{line}\n")).collect();
    format!("{request}\n{status}{sum}\n{lines}\n").into_bytes()
}
