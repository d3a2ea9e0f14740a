//! The server information packet: a robot's state, sent about ten times a second, in the robot's own units.

use crate::wire::{Encoded, Reader};
use crate::{Error, Packet};

/// A server information packet.
///
/// Later firmware appended fields: a field that an old firmware lacks is `None`, and encoding ends at the
/// first `None`. Units of distance and speed are those of the robot's [`Model`](crate::Model).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sip {
    /// Whether the robot is moving.
    pub moving: bool,
    /// Position ahead of the origin, in the robot's units of distance, wrapping.
    pub x: u16,
    /// Position to the left of the origin, in the robot's units of distance, wrapping.
    pub y: u16,
    /// Heading, angular units counter-clockwise.
    pub th: i16,
    /// Speed of the left wheel.
    pub left_velocity: i16,
    /// Speed of the right wheel.
    pub right_velocity: i16,
    /// Battery, 0.1 V, up to 25.5 V.
    pub battery: u8,
    /// Low byte: bit 0 a stall of the left wheel, bits 1 to 7 rear bumpers. High byte: bit 0 a stall of the
    /// right wheel, bits 1 to 7 front bumpers. Bumpers are counted from the left, as seen from the middle of
    /// the robot in their direction.
    pub stall_bumpers: u16,
    /// Set point of the server's heading controller, degrees.
    pub control: i16,
    /// Bit 0 motors on, bits 1 to 4 sonar arrays on, bit 5 as in [`Flags`]; the other bits are not used.
    pub flags: u16,
    /// Compass heading, in units of 2 degrees.
    pub compass: u8,
    /// New sonar readings since the last packet.
    pub sonars: Vec<SonarReading>,
    /// The gripper's state.
    pub gripper: Option<u8>,
    /// The selected analog port.
    pub analog_port: Option<u8>,
    /// Level of the analog port.
    pub analog: Option<u8>,
    /// Digital inputs.
    pub digital_in: Option<u8>,
    /// Digital outputs.
    pub digital_out: Option<u8>,
    /// Battery, 0.1 V, without the limit of [`battery`](Self::battery).
    pub battery_tenths: Option<u16>,
    /// Charging: 0 none, 1 bulk, 2 overcharge, 3 float; `0xFF` unknown.
    pub charge: Option<u8>,
    /// Turn rate, 0.1 degrees/s counter-clockwise.
    pub rotation: Option<i16>,
    /// Faults.
    pub faults: Option<u16>,
    /// Speed to the left, mm/s.
    pub lateral: Option<i16>,
    /// Temperature, °C; −127 if there is no measurement.
    pub temperature: Option<i8>,
    /// State of charge, percent; 0 if the battery does not measure it.
    pub state_of_charge: Option<u8>,
}

/// The reading of one sonar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SonarReading {
    /// The sonar, counted from the front left.
    pub index: u8,
    /// The range, in the robot's units of range.
    pub range: u16,
}

/// Bits of [`Sip::flags`].
#[derive(Clone, Copy, Debug)]
pub struct Flags;

impl Flags {
    /// The motors are on.
    pub const MOTORS: u16 = 1;
    /// All four sonar arrays are on.
    pub const SONARS: u16 = 0b1_1110;
    /// The emergency button is pressed.
    pub const ESTOP: u16 = 1 << 5;
}

/// Kind of a SIP of a robot at rest.
pub(crate) const STOPPED: u8 = 0x32;
/// Kind of a SIP of a moving robot.
pub(crate) const MOVING: u8 = 0x33;

/// Bytes of one sonar's reading.
const SONAR_BYTES: usize = 3;
/// Bytes of all fields after the sonars.
const TAIL_BYTES: usize = 16;

impl Sip {
    /// Encodes the SIP as a packet.
    ///
    /// # Errors
    /// If it has more sonars than fit, which is 54 with every field of the tail.
    pub fn to_packet(&self) -> Result<Packet, Error> {
        let mut payload = vec![if self.moving { MOVING } else { STOPPED }];
        self.x.write(&mut payload);
        self.y.write(&mut payload);
        self.th.write(&mut payload);
        self.left_velocity.write(&mut payload);
        self.right_velocity.write(&mut payload);
        self.battery.write(&mut payload);
        self.stall_bumpers.write(&mut payload);
        self.control.write(&mut payload);
        self.flags.write(&mut payload);
        self.compass.write(&mut payload);
        payload.push(u8::try_from(self.sonars.len()).unwrap_or(u8::MAX));
        for sonar in &self.sonars {
            sonar.index.write(&mut payload);
            sonar.range.write(&mut payload);
        }
        self.write_tail(&mut payload);
        Packet::new(&payload)
    }

    /// Decodes a packet of any firmware's length.
    ///
    /// # Errors
    /// If it is not a SIP, or ends before its sonars do.
    pub fn from_packet(packet: &Packet) -> Result<Self, Error> {
        let moving = match packet.id() {
            STOPPED => false,
            MOVING => true,
            have => return Err(Error::Kind { what: "SIP", have }),
        };
        let mut reader = Reader::new("SIP", packet.data());
        let mut sip = Self {
            moving,
            x: reader.get()?,
            y: reader.get()?,
            th: reader.get()?,
            left_velocity: reader.get()?,
            right_velocity: reader.get()?,
            battery: reader.get()?,
            stall_bumpers: reader.get()?,
            control: reader.get()?,
            flags: reader.get()?,
            compass: reader.get()?,
            ..Self::default()
        };
        let count = usize::from(reader.get::<u8>()?);
        // One simulator counts its sonars but omits their readings while they are off.
        let omitted = reader.remaining() < SONAR_BYTES * count && reader.remaining() <= TAIL_BYTES;
        for _ in 0..if omitted { 0 } else { count } {
            let (index, range) = (reader.get()?, reader.get()?);
            sip.sonars.push(SonarReading { index, range });
        }
        sip.read_tail(&mut reader);
        Ok(sip)
    }

    /// Returns the battery voltage, V, from the better of its two fields.
    #[must_use]
    pub fn volts(&self) -> f64 {
        f64::from(self.battery_tenths.unwrap_or_else(|| self.battery.into())) / 10.0
    }

    /// Returns whether the motors are on.
    #[must_use]
    pub fn motors(&self) -> bool {
        self.flags & Flags::MOTORS != 0
    }

    /// Returns whether a wheel is blocked while it should turn.
    #[must_use]
    pub fn stalled(&self) -> bool {
        self.stall_bumpers & 0x0101 != 0
    }

    /// Returns whether the front bumper of this number, from 0, is pressed. There are at most seven.
    #[must_use]
    pub fn front_bumper(&self, number: usize) -> bool {
        number < 7 && self.stall_bumpers >> (9 + number) & 1 != 0
    }

    /// Returns whether the rear bumper of this number, from 0, is pressed. There are at most seven.
    #[must_use]
    pub fn rear_bumper(&self, number: usize) -> bool {
        number < 7 && self.stall_bumpers >> (1 + number) & 1 != 0
    }
}

/// The fields of the tail, in the order in which firmware added them.
macro_rules! tail {
    ($($field:ident),*) => {
        impl Sip {
            fn write_tail(&self, to: &mut Vec<u8>) {
                $(let Some(value) = self.$field else { return };
                value.write(to);)*
            }

            fn read_tail(&mut self, from: &mut Reader<'_>) {
                $(self.$field = from.optional();
                if self.$field.is_none() {
                    return;
                })*
            }
        }
    };
}
tail!(
    gripper,
    analog_port,
    analog,
    digital_in,
    digital_out,
    battery_tenths,
    charge,
    rotation,
    faults,
    lateral,
    temperature,
    state_of_charge
);
