//! The configuration packet: a robot's limits and settings, its reply to CONFIG.

use crate::wire::{Encoded, Reader, packet, record};
use crate::{Error, Packet};

/// Kind of the packet.
pub(crate) const KIND: u8 = 0x20;

record! {
    /// The reply of a robot to CONFIG, in the robot's own units: mm, mm/s, degrees, degrees/s.
    #[derive(Clone, Debug, Default, PartialEq, Eq)]
    Config {
        /// Class: `Pioneer`.
        class: String,
        /// Subclass, which is the model: `p3dx`.
        subclass: String,
        /// Serial number; `SIM` for a simulator.
        serial: String,
        /// 1 if the robot is an old model with four motors.
        four_motors: u8,
        /// Upper limit of the turn rate setting.
        rot_vel_top: u16,
        /// Upper limit of the speed setting.
        trans_vel_top: u16,
        /// Upper limit of the angular acceleration setting.
        rot_acc_top: u16,
        /// Upper limit of the acceleration setting.
        trans_acc_top: u16,
        /// Greatest pulse width of the motors.
        pwm_max: u16,
        /// The robot's name; `MobileSim` or similar for a simulator.
        name: String,
        /// Time between SIPs, ms.
        sip_cycle: u8,
        /// Speed of the serial line to the client.
        host_baud: u8,
        /// Speed of the first auxiliary port.
        aux1_baud: u8,
        /// Whether there is a gripper.
        gripper: u16,
        /// Whether there are front sonars.
        front_sonar: u16,
        /// Whether there are rear sonars.
        rear_sonar: u8,
        /// Battery voltage at which the robot beeps, 0.1 V.
        low_battery: u16,
        /// Encoder ticks in half a turn on the spot.
        rev_count: u16,
        /// Time without a command after which the robot stops, ms.
        watchdog: u16,
        /// Whether the alternative SIP is sent.
        p2_mpacs: u8,
        /// Pulse width at which a wheel counts as stalled.
        stall_value: u16,
        /// Pause after a stall, ms.
        stall_count: u16,
        /// Greatest speed with the joystick.
        joy_vel: u16,
        /// Greatest turn rate with the joystick.
        joy_rot_vel: u16,
        /// Present greatest turn rate.
        rot_vel_max: u16,
        /// Present greatest speed.
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
        /// Front bumpers.
        front_bumpers: u8,
        /// Rear bumpers.
        rear_bumpers: u8,
        /// Kind of charger.
        charger: u8,
        /// Time of a sonar's ping, ms.
        sonar_cycle: u8,
        /// 1 if the speed of the line can be changed, 2 if the robot detects it.
        auto_baud: u8,
        /// Whether there is a gyroscope.
        has_gyro: u8,
        /// Correction for unequal wheels, 1/8192.
        drift_factor: i16,
        /// Speed of the second auxiliary port.
        aux2_baud: u8,
        /// Speed of the third auxiliary port.
        aux3_baud: u8,
        /// Encoder ticks for each mm; 0 if unknown.
        ticks_per_mm: u16,
        /// Battery voltage at which the robot shuts down, 0.1 V.
        shutdown_volts: u16,
        /// Version of the firmware.
        firmware: String,
        /// Clockwise error of the gyroscope.
        gyro_cw: u16,
        /// Counter-clockwise error of the gyroscope.
        gyro_ccw: u16,
        /// Delay of the kinematics, ms.
        kinematics_delay: u8,
        /// Upper limit of the lateral speed setting.
        lat_vel_top: u16,
        /// Upper limit of the lateral acceleration setting.
        lat_acc_top: u16,
        /// Present greatest lateral speed.
        lat_vel_max: u16,
        /// Lateral acceleration.
        lat_acc: u16,
        /// Lateral deceleration.
        lat_dec: u16,
        /// Battery level at which charging ends.
        charge_threshold: u16,
    }
}

impl Config {
    /// Encodes every field as a packet.
    ///
    /// # Errors
    /// If its strings are too long for a packet.
    pub fn to_packet(&self) -> Result<Packet, Error> {
        packet(KIND, self)
    }

    /// Decodes a packet. Fields that an older firmware does not send are 0 or empty. Bytes after the last
    /// field are ignored.
    ///
    /// # Errors
    /// If it is not a configuration, or one of its first three names is not terminated.
    pub fn from_packet(packet: &Packet) -> Result<Self, Error> {
        const RECORD_NAME: &str = "configuration";
        if packet.id() != KIND {
            let (what, have) = (RECORD_NAME, packet.id());
            return Err(Error::Kind { what, have });
        }
        let mut names = Reader::new(RECORD_NAME, packet.data());
        for _ in 0..3 {
            names.get::<String>()?;
        }
        // Zeros decode as zeros and as empty strings, so that zeros can replace the fields that an old
        // firmware lacks.
        let mut padded = packet.data().to_vec();
        padded.resize(padded.len() + 200, 0);
        Self::read(&mut Reader::new(RECORD_NAME, &padded))
    }

    /// Returns whether this is the configuration of a simulator.
    #[must_use]
    pub fn is_simulator(&self) -> bool {
        self.serial.eq_ignore_ascii_case("SIM") || is_simulators_name(&self.name)
    }
}

/// Returns whether a name is that of a known simulator.
pub(crate) fn is_simulators_name(name: &str) -> bool {
    ["MobileSim", "AMRISim", "SRIsim"]
        .iter()
        .any(|known| name.eq_ignore_ascii_case(known))
}
