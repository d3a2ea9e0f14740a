//! A laser's sweep in packets of 32 readings, as simulators send it beside the SIPs, and the reassembly of
//! sweeps from packets.

use crate::wire::{Encoded, Reader};
use crate::{Error, Packet};

/// Most readings in one packet.
pub const READINGS: usize = 32;

const PLAIN_PACKET: u8 = 0x60;
const EXTENDED_PACKET: u8 = 0x61;

/// One reading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Distance, mm.
    pub range: u16,
    /// The reflectance, in units of the device; 0 in a plain packet.
    pub reflectance: u8,
}

/// The data of a packet besides its readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaserForm {
    /// Kind 0x60: with the pose of the robot's odometry.
    Plain {
        /// Ahead of the origin, mm.
        x: i16,
        /// To the left of the origin, mm.
        y: i16,
        /// Heading, degrees counter-clockwise.
        th: i16,
    },
    /// Kind 0x61: with reflectances.
    Extended {
        /// The laser, from 0.
        device: u8,
        /// Bit 0: the robot was moved by hand since the last packet.
        flags: u8,
    },
}

/// A part of a sweep.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LaserPacket {
    /// Its kind, with the data of that kind.
    pub form: LaserForm,
    /// Number of readings in the whole sweep.
    pub total: u16,
    /// Index of the first reading in this packet, from 0 at the start angle, counter-clockwise.
    pub first: u16,
    /// The readings.
    pub readings: Vec<Reading>,
}

/// Reassembles sweeps from packets.
///
/// A sweep starts with the packet whose first reading has index 0. Packets that repeat known readings change
/// nothing. A packet after a gap discards the sweep.
#[derive(Clone, Debug, Default)]
pub struct Assembler {
    total: u16,
    readings: Vec<Reading>,
    incomplete: u64,
}

impl LaserPacket {
    /// Splits a sweep into packets, from the first reading.
    pub fn sweep(form: LaserForm, readings: &[Reading]) -> impl Iterator<Item = Self> + '_ {
        let readings = &readings[..readings.len().min(u16::MAX.into())];
        let chunks = readings.chunks(READINGS).enumerate();
        chunks.map(move |(number, chunk)| Self {
            form,
            total: readings.len() as u16,
            first: (number * READINGS) as u16,
            readings: chunk.to_vec(),
        })
    }

    /// Encodes the part as a packet.
    ///
    /// # Errors
    /// If it has more readings than fit. [`READINGS`] fit.
    pub fn to_packet(&self) -> Result<Packet, Error> {
        let mut payload = Vec::new();
        match self.form {
            LaserForm::Plain { x, y, th } => {
                payload.push(PLAIN_PACKET);
                x.write(&mut payload);
                y.write(&mut payload);
                th.write(&mut payload);
            }
            LaserForm::Extended { .. } => payload.push(EXTENDED_PACKET),
        }
        self.total.write(&mut payload);
        self.first.write(&mut payload);
        payload.push(u8::try_from(self.readings.len()).unwrap_or(u8::MAX));
        for reading in &self.readings {
            reading.range.write(&mut payload);
            if let LaserForm::Extended { .. } = self.form {
                payload.extend([reading.reflectance, 0, 0]);
            }
        }
        if let LaserForm::Extended { device, flags } = self.form {
            payload.extend([device, flags]);
        }
        Packet::new(&payload)
    }

    /// Returns whether a packet is one of a laser.
    #[must_use]
    pub fn is_laser_packet(packet: &Packet) -> bool {
        matches!(packet.id(), PLAIN_PACKET | EXTENDED_PACKET)
    }

    /// Decodes a packet. Device and flags are 0 if an old simulator does not send them.
    ///
    /// # Errors
    /// If it is of another kind, ends within its readings, or has readings beyond the end of the sweep.
    pub fn from_packet(packet: &Packet) -> Result<Self, Error> {
        let mut reader = Reader::new("packet of a laser", packet.data());
        let extended = match packet.id() {
            PLAIN_PACKET => false,
            EXTENDED_PACKET => true,
            have => {
                let what = "packet of a laser";
                return Err(Error::Kind { what, have });
            }
        };
        let mut form = LaserForm::Extended { device: 0, flags: 0 };
        if !extended {
            let (x, y, th) = (reader.get()?, reader.get()?, reader.get()?);
            form = LaserForm::Plain { x, y, th };
        }
        let (total, first) = (reader.get()?, reader.get()?);
        let count: u8 = reader.get()?;
        if u32::from(first) + u32::from(count) > u32::from(total) {
            let what = "number of readings";
            return Err(Error::Contradiction { what });
        }
        let mut readings = Vec::with_capacity(count.into());
        for _ in 0..count {
            let range = reader.get()?;
            let mut reflectance = 0;
            if extended {
                reflectance = reader.get()?;
                let _reserved: u16 = reader.get()?;
            }
            readings.push(Reading { range, reflectance });
        }
        if extended {
            let device = reader.optional().unwrap_or_default();
            let flags = reader.optional().unwrap_or_default();
            form = LaserForm::Extended { device, flags };
        }
        Ok(Self {
            form,
            total,
            first,
            readings,
        })
    }
}

impl Assembler {
    /// Adds a packet. Returns the sweep that it completes.
    pub fn add(&mut self, packet: &LaserPacket) -> Option<Vec<Reading>> {
        if packet.readings.is_empty() {
            return None;
        }
        let (known, first) = (self.readings.len(), usize::from(packet.first));
        let end = first + packet.readings.len();
        let fits = packet.total == self.total && first <= known;
        if fits && known > 0 && end <= known && self.readings[first..end] == packet.readings {
            return None;
        }
        if first == 0 {
            self.discard();
            self.total = packet.total;
        } else if !fits || first < known {
            self.discard();
            return None;
        }
        self.readings.extend(&packet.readings);
        (self.readings.len() >= usize::from(self.total)).then(|| core::mem::take(&mut self.readings))
    }

    /// Returns the number of sweeps that were started and not completed.
    #[must_use]
    pub fn incomplete(&self) -> u64 {
        self.incomplete
    }

    fn discard(&mut self) {
        self.incomplete += u64::from(!self.readings.is_empty());
        self.readings.clear();
    }
}
