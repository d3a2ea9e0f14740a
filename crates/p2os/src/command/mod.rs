//! What a client asks of a robot: one enum over every command, from and to packets. What the robot makes of
//! it is not decided here.
//!
//! Numbers are the raw ones of the protocol: mm, mm/s, degrees. A simulator's own commands share some numbers
//! with commands of robots that are hardly used (35 also selects an analog port, 36 is the gripper's
//! pressure, 67 asks the second serial port); the simulator's have the name here, and the bytes are the same.

mod argument;

use crate::{Error, Packet};

use argument::Held;
pub use argument::{Argument, ForLaser, Form, SimControl, SimPose, Wheels};

macro_rules! commands {
    ($($(#[$doc:meta])* $name:ident $(($type:ty))? = $id:literal,)*) => {
        /// A command of a client.
        #[derive(Clone, Debug, PartialEq, Eq)]
        pub enum Command {
            $($(#[$doc])* $name $(($type))?,)*
            /// Any other, or one of the above with an argument that it does not take.
            Other {
                /// Its number.
                id: u8,
                /// What follows it.
                argument: Argument,
            },
        }

        impl Command {
            /// Understands a packet; every packet is some command.
            #[must_use]
            pub fn from_packet(packet: &Packet) -> Self {
                let (id, argument) = (packet.id(), Argument::read(packet.data()));
                $(if id == $id && let Some(_value) = <commands!(@held $($type)?) as Held>::take(&argument) {
                    return commands!(@make $name _value $($type)?);
                })*
                Self::Other { id, argument }
            }

            fn parts(&self) -> (u8, Argument) {
                match self {
                    $(commands!(@match $name value $($type)?) =>
                        ($id, commands!(@put value $($type)?)),)*
                    Self::Other { id, argument } => (*id, argument.clone()),
                }
            }
        }
    };
    (@held $type:ty) => { $type };
    (@held) => { () };
    (@make $name:ident $value:ident $type:ty) => { Self::$name($value) };
    (@make $name:ident $value:ident) => { Self::$name };
    (@match $name:ident $value:ident $type:ty) => { Self::$name($value) };
    (@match $name:ident $value:ident) => { Self::$name };
    (@put $value:ident $type:ty) => { <$type as Held>::put($value) };
    (@put $value:ident) => { ().put() };
}

commands! {
    /// Only says that the client is there, which resets the watchdog.
    Pulse = 0,
    /// Starts the robot's servers: it begins to send SIPs.
    Open(Form) = 1,
    /// Ends the session.
    Close(Form) = 2,
    /// The order in which the sonars ping.
    Polling(Vec<u8>) = 3,
    /// Motors on or off.
    Enable(bool) = 4,
    /// Acceleration if positive, deceleration if negative, mm/s².
    Acceleration(i16) = 5,
    /// Greatest speed of MOVE, mm/s.
    MaxVelocity(u16) = 6,
    /// Calls where it is the origin, or this pose: mm, mm, degrees.
    SetOrigin(Option<[i16; 3]>) = 7,
    /// Drives a distance, mm.
    Move(i16) = 8,
    /// Turns at a speed, degrees/s, as [`RotVelocity`](Self::RotVelocity) does.
    Rotate(i16) = 9,
    /// Greatest speed of turns, degrees/s.
    MaxRotVelocity(u16) = 10,
    /// Speed ahead, mm/s.
    Velocity(i16) = 11,
    /// Turns to a heading, degrees.
    Heading(i16) = 12,
    /// Turns by an angle, degrees.
    DeltaHeading(i16) = 13,
    /// Plays notes: pairs of a duration of 20 ms and a half-cycle.
    Say(Vec<u8>) = 15,
    /// Asks for a [`Config`](crate::Config).
    Config(Form) = 18,
    /// Asks for [`Encoders`](crate::Encoders): 0 stops, 1 one packet, 2 one with every SIP.
    Encoder(u16) = 19,
    /// Speed of turning, degrees/s counter-clockwise.
    RotVelocity(i16) = 21,
    /// Turns by an angle from the heading last asked for, degrees.
    CompassHeading(i16) = 22,
    /// Angular acceleration if positive, deceleration if negative, degrees/s².
    RotAcceleration(i16) = 23,
    /// Sonars: bit 0 on or off, bits 1 to 4 the array if not all.
    Sonar(u16) = 28,
    /// Stops, motors stay on.
    Stop = 29,
    /// Digital outputs: high byte the mask, low byte the levels.
    DigitalOut(u16) = 30,
    /// Speeds of the wheels.
    Velocities2(Wheels) = 32,
    /// The gripper's commands.
    Gripper(u16) = 33,
    /// A simulator's laser: 0 off, 1 on, 2 on with reflectances. To a robot: which analog port the SIP tells.
    LaserOn35(u16) = 35,
    /// A simulator's laser begins at this angle, degrees.
    LaserStart36(i16) = 36,
    /// A simulator's laser ends at this angle, degrees.
    LaserEnd37(i16) = 37,
    /// From one reading of a simulator's laser to the next, 0.01 degrees.
    LaserIncrement38(u16) = 38,
    /// Asks for an input-output packet: 0 stops, 1 one, 2 continually.
    IoRequest(u16) = 40,
    /// Position of a servo: high byte which, low byte where.
    ServoPosition(u16) = 41,
    /// Bytes for the device at the first auxiliary port.
    Tty2(Vec<u8>) = 42,
    /// Asks for as many bytes from the device at the first auxiliary port; 0 forgets what it said.
    GetAux(u16) = 43,
    /// What bumpers do: 0 nothing, 1 front stops, 2 rear, 3 both.
    BumpStall(u16) = 44,
    /// The compass's commands.
    Compass(u16) = 45,
    /// The joystick on the robot drives (1) or not (0).
    JoyDrive(u16) = 47,
    /// Speed of the serial line to the client: 0 is 9600, 1 19200, 2 38400, 3 57600, 4 115200.
    HostBaud(u16) = 50,
    /// Stops at the greatest deceleration.
    EStop = 55,
    /// Stops at the greatest deceleration, as ARCOS numbers it.
    QStop = 57,
    /// Gyroscope: 0 off, 1 on.
    Gyro(u16) = 58,
    /// Bytes for the device at the third auxiliary port.
    Tty4(Vec<u8>) = 60,
    /// Asks for as many bytes from the device at the third auxiliary port.
    GetAux3(u16) = 61,
    /// Asks about the battery; to one simulator of old it meant to exit, so nothing may end by it.
    BatteryInfo(u16) = 62,
    /// Bytes for the device at the second auxiliary port; 66 with a number is
    /// [`SetOriginX`](Self::SetOriginX).
    Tty3(Vec<u8>) = 66,
    /// Puts a simulator's robot at x, mm.
    SetOriginX(i16) = 66,
    /// Puts a simulator's robot at y, mm.
    SetOriginY(i16) = 67,
    /// Turns a simulator's robot to a heading, degrees.
    SetOriginTh(i16) = 68,
    /// Puts a simulator's robot back to its start.
    Reset69 = 69,
    /// Plays a stored sound.
    Sound(u16) = 90,
    /// Plays a stored list of sounds.
    PlayList(u16) = 91,
    /// Sound on or off.
    SoundToggle(bool) = 92,
    /// Speed to the left, mm/s, for robots that can.
    LatVelocity(i16) = 110,
    /// Acceleration sideways if positive, deceleration if negative, mm/s².
    LatAcceleration(i16) = 113,
    /// Puts a simulator's robot somewhere.
    SimSetPose(SimPose) = 224,
    /// Puts a simulator's robot back to its start.
    SimReset = 225,
    /// A simulator's laser: 0 off, 1 on, 2 on with reflectances.
    LrfEnable(ForLaser) = 230,
    /// A simulator's laser begins at this angle, degrees.
    LrfStart(ForLaser) = 231,
    /// A simulator's laser ends at this angle, degrees.
    LrfEnd(ForLaser) = 232,
    /// From one reading of a simulator's laser to the next, 0.01 degrees.
    LrfResolution(ForLaser) = 233,
    /// A request to a simulator.
    SimCtrl(SimControl) = 236,
    /// Asks a simulator for its [`SimState`](crate::SimState): 0 stops, 1 one packet, 2 one with every SIP.
    SimStat(u16) = 237,
    /// Words for whoever watches a simulator.
    Message(Vec<u8>) = 238,
    /// Ends a simulator, with this status.
    Exit(u16) = 239,
}

impl Command {
    /// The packet that says it.
    ///
    /// # Errors
    /// If its text is too long for a packet.
    pub fn to_packet(&self) -> Result<Packet, Error> {
        let (id, argument) = self.parts();
        let mut payload = vec![id];
        argument.write(&mut payload);
        Packet::new(&payload)
    }

    /// Whether the robot would move by it: what a client may send only because somebody asked for motion.
    #[must_use]
    pub fn moves(&self) -> bool {
        match self {
            Self::Velocity(speed)
            | Self::RotVelocity(speed)
            | Self::Rotate(speed)
            | Self::LatVelocity(speed) => *speed != 0,
            Self::Velocities2(wheels) => *wheels != Wheels::default(),
            Self::Move(distance) => *distance != 0,
            Self::Heading(_) | Self::DeltaHeading(_) | Self::CompassHeading(_) => true,
            _ => false,
        }
    }
}
