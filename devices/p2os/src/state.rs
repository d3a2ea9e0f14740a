//! The state that only a simulator knows: the robot's true pose and the errors of its odometry. No control
//! may depend on it.

use crate::wire::{packet, record, record_of};
use crate::{Error, Packet};

/// Kind of the packet.
const STATE_PACKET: u8 = 0x62;

record! {
    /// The reply of a simulator to SIM_STAT.
    #[derive(Clone, Debug, Default, PartialEq, Eq)]
    SimState {
        /// No longer used.
        reserved_name: String,
        /// No longer used.
        reserved_version: String,
        /// Bit 1: the geographic position is known. Bit 2: the errors of the odometry are known.
        flags: u32,
        /// Simulated time of a step, ms.
        simulated_interval: u16,
        /// Real time of a step, ms.
        real_interval: u16,
        /// Real time of the last step, ms.
        last_interval: u16,
        /// True x, mm.
        x: i32,
        /// True y, mm.
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
        /// Quality of the geographic position, 0.01; −1 for none.
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
    /// Encodes the state as a packet.
    ///
    /// # Errors
    /// If its strings are too long for a packet.
    pub fn to_packet(&self) -> Result<Packet, Error> {
        packet(STATE_PACKET, self)
    }

    /// Decodes a packet.
    ///
    /// # Errors
    /// If it is not a simulator's state, or is too short.
    pub fn from_packet(packet: &Packet) -> Result<Self, Error> {
        record_of("simulator's state", STATE_PACKET, packet)
    }
}
