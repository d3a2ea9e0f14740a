//! The commands of a client: one enum over all of them, from and to packets. It does not execute them.
//!
//! Numbers are the raw ones of the protocol: mm, mm/s, degrees. Some numbers of simulator commands are also
//! rarely used commands of robots: 35 selects an analog port, 36 is the gripper's pressure, 67 reads the
//! second serial port. This module uses the simulator's names; the bytes are the same.

mod argument;

use crate::{Error, Packet};

use argument::ArgumentType;
pub use argument::{Argument, ForLaser, Form, SimControl, SimPose, Wheels};

macro_rules! commands {
    ($($(#[$doc:meta])* $name:ident $(($type:ty))? = $id:literal,)*) => {
        /// A command of a client.
        #[derive(Clone, Debug, PartialEq, Eq)]
        pub enum Command {
            $($(#[$doc])* $name $(($type))?,)*
            /// Any other command, or one of the above with an argument that it does not take.
            Other {
                /// Its number.
                id: u8,
                /// The bytes after the number.
                argument: Argument,
            },
        }

        impl Command {
            /// Decodes a packet; every packet is a command.
            #[must_use]
            pub fn from_packet(packet: &Packet) -> Self {
                let (id, argument) = (packet.id(), Argument::read(packet.data()));
                $(if id == $id && let Some(_value) = <commands!(@argument_type $($type)?) as ArgumentType>::decode(&argument) {
                    return commands!(@make $name _value $($type)?);
                })*
                Self::Other { id, argument }
            }

            fn parts(&self) -> (u8, Argument) {
                match self {
                    $(commands!(@match $name value $($type)?) =>
                        ($id, commands!(@encode value $($type)?)),)*
                    Self::Other { id, argument } => (*id, argument.clone()),
                }
            }
        }
    };
    (@argument_type $type:ty) => { $type };
    (@argument_type) => { () };
    (@make $name:ident $value:ident $type:ty) => { Self::$name($value) };
    (@make $name:ident $value:ident) => { Self::$name };
    (@match $name:ident $value:ident $type:ty) => { Self::$name($value) };
    (@match $name:ident $value:ident) => { Self::$name };
    (@encode $value:ident $type:ty) => { <$type as ArgumentType>::encode($value) };
    (@encode $value:ident) => { ().encode() };
}

commands! {
    /// Shows that the client is alive, which resets the watchdog.
    Pulse = 0,
    /// Starts the robot's servers: the robot starts to send SIPs.
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
    /// Defines the present pose as the origin, or as this pose: mm, mm, degrees.
    SetOrigin(Option<[i16; 3]>) = 7,
    /// Drives a distance, mm.
    Move(i16) = 8,
    /// Turns at a speed, degrees/s, like [`RotVelocity`](Self::RotVelocity).
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
    /// Requests a [`Config`](crate::Config).
    Config(Form) = 18,
    /// Requests [`Encoders`](crate::Encoders): 0 stops them, 1 requests one packet, 2 one with every SIP.
    Encoder(u16) = 19,
    /// Turn rate, degrees/s counter-clockwise.
    RotVelocity(i16) = 21,
    /// Turns by an angle from the heading last commanded, degrees.
    CompassHeading(i16) = 22,
    /// Angular acceleration if positive, deceleration if negative, degrees/s².
    RotAcceleration(i16) = 23,
    /// Sonars: bit 0 on or off, bits 1 to 4 the array, or 0 for all.
    Sonar(u16) = 28,
    /// Stops; the motors stay on.
    Stop = 29,
    /// Digital outputs: high byte the mask, low byte the levels.
    DigitalOut(u16) = 30,
    /// Speeds of the wheels.
    Velocities2(Wheels) = 32,
    /// The commands of the gripper.
    Gripper(u16) = 33,
    /// A simulator's laser: 0 off, 1 on, 2 on with reflectances. On a robot: the analog port to report in the
    /// SIP.
    LaserOn35(u16) = 35,
    /// First angle of a simulator's laser, degrees.
    LaserStart36(i16) = 36,
    /// Last angle of a simulator's laser, degrees.
    LaserEnd37(i16) = 37,
    /// Angle between readings of a simulator's laser, 0.01 degrees.
    LaserIncrement38(u16) = 38,
    /// Requests input-output packets: 0 stops them, 1 requests one, 2 a continuous stream.
    IoRequest(u16) = 40,
    /// Position of a servo: high byte the servo, low byte the position.
    ServoPosition(u16) = 41,
    /// Bytes for the device at the first auxiliary port.
    Tty2(Vec<u8>) = 42,
    /// Requests this many bytes from the device at the first auxiliary port; 0 discards received bytes.
    GetAux(u16) = 43,
    /// Effect of the bumpers: 0 none, 1 front bumpers stop the robot, 2 rear bumpers, 3 both.
    BumpStall(u16) = 44,
    /// The commands of the compass.
    Compass(u16) = 45,
    /// The joystick at the robot drives it (1) or not (0).
    JoyDrive(u16) = 47,
    /// Speed of the serial line to the client: 0 is 9600, 1 19200, 2 38400, 3 57600, 4 115200.
    HostBaud(u16) = 50,
    /// Stops at the greatest deceleration.
    EStop = 55,
    /// Stops at the greatest deceleration; the number of ARCOS.
    QStop = 57,
    /// Gyroscope: 0 off, 1 on.
    Gyro(u16) = 58,
    /// Bytes for the device at the third auxiliary port.
    Tty4(Vec<u8>) = 60,
    /// Requests this many bytes from the device at the third auxiliary port.
    GetAux3(u16) = 61,
    /// Requests the state of the battery. One old simulator exits on it; no other simulator may.
    BatteryInfo(u16) = 62,
    /// Bytes for the device at the second auxiliary port; 66 with a number is
    /// [`SetOriginX`](Self::SetOriginX).
    Tty3(Vec<u8>) = 66,
    /// Sets the x of a simulator's robot, mm.
    SetOriginX(i16) = 66,
    /// Sets the y of a simulator's robot, mm.
    SetOriginY(i16) = 67,
    /// Sets the heading of a simulator's robot, degrees.
    SetOriginTh(i16) = 68,
    /// Returns a simulator's robot to its start.
    Reset69 = 69,
    /// Plays a stored sound.
    Sound(u16) = 90,
    /// Plays a stored list of sounds.
    PlayList(u16) = 91,
    /// Switches the sound on or off.
    SoundToggle(bool) = 92,
    /// Speed to the left, mm/s, for robots that support it.
    LatVelocity(i16) = 110,
    /// Acceleration sideways if positive, deceleration if negative, mm/s².
    LatAcceleration(i16) = 113,
    /// Sets the pose of a simulator's robot.
    SimSetPose(SimPose) = 224,
    /// Returns a simulator's robot to its start.
    SimReset = 225,
    /// A simulator's laser: 0 off, 1 on, 2 on with reflectances.
    LrfEnable(ForLaser) = 230,
    /// First angle of a simulator's laser, degrees.
    LrfStart(ForLaser) = 231,
    /// Last angle of a simulator's laser, degrees.
    LrfEnd(ForLaser) = 232,
    /// Angle between readings of a simulator's laser, 0.01 degrees.
    LrfResolution(ForLaser) = 233,
    /// A request to a simulator.
    SimCtrl(SimControl) = 236,
    /// Requests a simulator's [`SimState`](crate::SimState): 0 stops it, 1 requests one packet, 2 one with
    /// every SIP.
    SimStat(u16) = 237,
    /// A text for the display of a simulator.
    Message(Vec<u8>) = 238,
    /// Ends a simulator with this exit status.
    Exit(u16) = 239,
}

impl Command {
    /// Encodes the command as a packet.
    ///
    /// # Errors
    /// If its text is too long for a packet.
    pub fn to_packet(&self) -> Result<Packet, Error> {
        let (id, argument) = self.parts();
        let mut payload = vec![id];
        argument.write(&mut payload);
        Packet::new(&payload)
    }

    /// Returns whether the robot moves on this command. A client may send such a command only if motion was
    /// requested.
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
