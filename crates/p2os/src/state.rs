//! What a simulator knows of its robot and no robot does: true pose and odometry's errors. No control may
//! rest on it.

use crate::wire::{packet, record, record_of};
use crate::{Error, Packet};

/// Kind of the packet.
const KIND: u8 = 0x62;

record! {
    /// What a simulator answers to SIM_STAT.
    #[derive(Clone, Debug, Default, PartialEq, Eq)]
    SimState {
        /// Nothing any more.
        reserved_name: String,
        /// Nothing any more.
        reserved_version: String,
        /// Bit 1: the place on the earth is known. Bit 2: the errors of the odometry are known.
        flags: u32,
        /// Simulated time of a step, ms.
        simulated_interval: u16,
        /// Real time of a step, ms.
        real_interval: u16,
        /// Real time of the last step, ms.
        last_interval: u16,
        /// True place, mm.
        x: i32,
        /// True place, mm.
        y: i32,
        /// True height, mm.
        z: i32,
        /// True heading, degrees.
        th: i32,
        /// Latitude, 1e-7 degrees.
        latitude: i32,
        /// Longitude, 1e-7 degrees.
        longitude: i32,
        /// Altitude, cm.
        altitude: i32,
        /// Quality of the place on the earth, 0.01; −1 none.
        gps: i32,
        /// Error of the odometry, 1e-7.
        error_x: i32,
        /// Error of the odometry, 1e-7.
        error_y: i32,
        /// Error of the odometry, 1e-7.
        error_th: i32,
    }
}

impl SimState {
    /// The packet that says it.
    ///
    /// # Errors
    /// If its strings are too long for a packet.
    pub fn to_packet(&self) -> Result<Packet, Error> {
        packet(KIND, self)
    }

    /// Understands a packet.
    ///
    /// # Errors
    /// If it is no simulator's state, or ends too early.
    pub fn from_packet(packet: &Packet) -> Result<Self, Error> {
        record_of("simulator's state", KIND, packet)
    }
}
