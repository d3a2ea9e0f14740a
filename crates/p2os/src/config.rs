//! The configuration packet: a robot's limits and settings, which it tells when asked by CONFIG.

use crate::wire::{Field, Reader, packet, record};
use crate::{Error, Packet};

/// Kind of the packet.
pub(crate) const KIND: u8 = 0x20;

record! {
    /// What a robot answers to CONFIG, in the robot's own units: mm, mm/s, degrees, degrees/s.
    #[derive(Clone, Debug, Default, PartialEq, Eq)]
    Config {
        /// Class: `Pioneer`.
        class: String,
        /// Subclass, which is the model: `p3dx`.
        subclass: String,
        /// Serial number; `SIM` of a simulator.
        serial: String,
        /// 1 if the robot is an old one with four motors.
        four_motors: u8,
        /// Greatest speed of turning that can be set.
        rot_vel_top: u16,
        /// Greatest speed that can be set.
        trans_vel_top: u16,
        /// Greatest angular acceleration that can be set.
        rot_acc_top: u16,
        /// Greatest acceleration that can be set.
        trans_acc_top: u16,
        /// Greatest pulse width of the motors.
        pwm_max: u16,
        /// The robot's name; `MobileSim` or the like of a simulator.
        name: String,
        /// Time between SIPs, ms.
        sip_cycle: u8,
        /// Speed of the serial line to the client.
        host_baud: u8,
        /// Speed of the first auxiliary port.
        aux1_baud: u8,
        /// Whether there is a gripper.
        gripper: u16,
        /// Whether there are sonars ahead.
        front_sonar: u16,
        /// Whether there are sonars behind.
        rear_sonar: u8,
        /// Battery at which the robot beeps, 0.1 V.
        low_battery: u16,
        /// Encoder ticks in half a turn on the spot.
        rev_count: u16,
        /// Silence after which the robot stops, ms.
        watchdog: u16,
        /// Whether the alternative SIP is sent.
        p2_mpacs: u8,
        /// Pulse width at which a wheel counts as stalled.
        stall_value: u16,
        /// Rest after a stall, ms.
        stall_count: u16,
        /// Speed of the joystick.
        joy_vel: u16,
        /// Speed of turning of the joystick.
        joy_rot_vel: u16,
        /// Greatest speed of turning now.
        rot_vel_max: u16,
        /// Greatest speed now.
        trans_vel_max: u16,
        /// Angular acceleration.
        rot_acc: u16,
        /// Angular deceleration.
        rot_dec: u16,
        /// Proportional gain of turning.
        rot_kp: u16,
        /// Derivative gain of turning.
        rot_kv: u16,
        /// Integral gain of turning.
        rot_ki: u16,
        /// Acceleration.
        trans_acc: u16,
        /// Deceleration.
        trans_dec: u16,
        /// Proportional gain of driving.
        trans_kp: u16,
        /// Derivative gain of driving.
        trans_kv: u16,
        /// Integral gain of driving.
        trans_ki: u16,
        /// Bumpers ahead.
        front_bumpers: u8,
        /// Bumpers behind.
        rear_bumpers: u8,
        /// Kind of charger.
        charger: u8,
        /// Time of a sonar's ping, ms.
        sonar_cycle: u8,
        /// 1 if speeds of the line can be changed, 2 if it finds them by itself.
        auto_baud: u8,
        /// Whether there is a gyroscope.
        has_gyro: u8,
        /// Correction of the wheels' difference, 1/8192.
        drift_factor: i16,
        /// Speed of the second auxiliary port.
        aux2_baud: u8,
        /// Speed of the third auxiliary port.
        aux3_baud: u8,
        /// Encoder ticks a mm; 0 unknown.
        ticks_per_mm: u16,
        /// Battery at which the robot shuts down, 0.1 V.
        shutdown_volts: u16,
        /// Version of the firmware.
        firmware: String,
        /// Clockwise error of the gyroscope.
        gyro_cw: u16,
        /// Counter-clockwise error of the gyroscope.
        gyro_ccw: u16,
        /// Delay of the kinematics, ms.
        kinematics_delay: u8,
        /// Greatest speed sideways that can be set.
        lat_vel_top: u16,
        /// Greatest acceleration sideways that can be set.
        lat_acc_top: u16,
        /// Greatest speed sideways now.
        lat_vel_max: u16,
        /// Acceleration sideways.
        lat_acc: u16,
        /// Deceleration sideways.
        lat_dec: u16,
        /// Battery at which charging ends.
        charge_threshold: u16,
    }
}

impl Config {
    /// The packet that says it, every field of it.
    ///
    /// # Errors
    /// If its names are too long for a packet.
    pub fn to_packet(&self) -> Result<Packet, Error> {
        packet(KIND, self)
    }

    /// Understands a packet; fields that an older firmware does not send are 0 or empty, and what follows the
    /// last is left out.
    ///
    /// # Errors
    /// If it is no configuration, or its first three names do not end.
    pub fn from_packet(packet: &Packet) -> Result<Self, Error> {
        const WHAT: &str = "configuration";
        if packet.id() != KIND {
            let (what, have) = (WHAT, packet.id());
            return Err(Error::Kind { what, have });
        }
        let mut names = Reader::new(WHAT, packet.data());
        for _ in 0..3 {
            names.get::<String>()?;
        }
        // Zeros read as zeros and as empty strings: an old firmware's packet goes on with as many as are
        // missing.
        let mut longest = packet.data().to_vec();
        longest.resize(longest.len() + 200, 0);
        Self::read(&mut Reader::new(WHAT, &longest))
    }

    /// Whether a simulator says this.
    #[must_use]
    pub fn is_simulator(&self) -> bool {
        self.serial.eq_ignore_ascii_case("SIM") || is_simulators_name(&self.name)
    }
}

/// Whether a simulator calls itself so.
pub(crate) fn is_simulators_name(name: &str) -> bool {
    ["MobileSim", "AMRISim", "SRIsim"]
        .iter()
        .any(|known| name.eq_ignore_ascii_case(known))
}
