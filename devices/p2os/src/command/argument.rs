//! The argument of a command on the wire, and the types that it can hold. `command` defines which command has
//! which type.

/// The bytes after the number of a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Argument {
    /// No argument.
    None,
    /// Type `3B` and a magnitude.
    Positive(u16),
    /// Type `1B` and a magnitude.
    Negative(u16),
    /// Type `2B`, a length and that many bytes.
    Text(Vec<u8>),
    /// Any other bytes.
    Raw(Vec<u8>),
}

/// Type byte of a positive number. Simulators also expect it before their own numbers.
pub(crate) const POSITIVE: u8 = 0x3B;
const NEGATIVE_NUMBER: u8 = 0x1B;
const TEXT_ARGUMENT: u8 = 0x2B;

/// Whether OPEN, CLOSE or CONFIG has the argument 1. Robots accept both forms; without argument the packet is
/// also a step of synchronisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// No argument.
    Bare,
    /// With the argument 1.
    One,
}

/// Wheel speeds of the VEL2 command, in units of 20 mm/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wheels {
    /// Left wheel.
    pub left: i8,
    /// Right wheel.
    pub right: i8,
}

/// A number with the laser of a simulator that it is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ForLaser {
    /// The number.
    pub value: i16,
    /// The laser, from 0.
    pub laser: u8,
}

/// A pose for a simulator's robot, in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SimPose {
    /// East, mm.
    pub x: i32,
    /// North, mm.
    pub y: i32,
    /// Heading, degrees counter-clockwise.
    pub th: i32,
}

/// A request to a simulator: 1 loads a map, 6 asks for information about the simulator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SimControl {
    /// The request.
    pub code: u16,
    /// Its data; at most 190 bytes.
    pub data: Vec<u8>,
}

/// A type that an argument can hold.
pub(super) trait ArgumentType: Sized {
    fn encode(&self) -> Argument;
    /// Returns `None` if the argument is not of this type.
    fn decode(argument: &Argument) -> Option<Self>;
}

impl Argument {
    pub(super) fn write(&self, output: &mut Vec<u8>) {
        match self {
            Self::None => {}
            Self::Positive(value) => {
                output.push(POSITIVE);
                output.extend(value.to_le_bytes());
            }
            Self::Negative(value) => {
                output.push(NEGATIVE_NUMBER);
                output.extend(value.to_le_bytes());
            }
            Self::Text(bytes) => {
                output.extend([TEXT_ARGUMENT, bytes.len() as u8]);
                output.extend(bytes);
            }
            Self::Raw(bytes) => output.extend(bytes),
        }
    }

    pub(super) fn read(bytes: &[u8]) -> Self {
        match bytes {
            [] => Self::None,
            [POSITIVE, low, high] => Self::Positive(u16::from_le_bytes([*low, *high])),
            [NEGATIVE_NUMBER, low, high] => Self::Negative(u16::from_le_bytes([*low, *high])),
            [TEXT_ARGUMENT, length, text @ ..] if usize::from(*length) == text.len() => {
                Self::Text(text.to_vec())
            }
            _ => Self::Raw(bytes.to_vec()),
        }
    }

    fn raw(&self) -> &[u8] {
        match self {
            Self::Raw(bytes) => bytes,
            Self::None | Self::Positive(_) | Self::Negative(_) | Self::Text(_) => &[],
        }
    }
}

impl ArgumentType for i16 {
    fn encode(&self) -> Argument {
        if *self < 0 {
            Argument::Negative(self.unsigned_abs())
        } else {
            Argument::Positive(self.unsigned_abs())
        }
    }

    fn decode(argument: &Argument) -> Option<Self> {
        match argument {
            // Some clients send a negative number as the positive one with the same bits.
            Argument::Positive(value) => Some(value.cast_signed()),
            Argument::Negative(value) => Self::try_from(-i32::from(*value)).ok(),
            Argument::None | Argument::Text(_) | Argument::Raw(_) => None,
        }
    }
}

impl ArgumentType for u16 {
    fn encode(&self) -> Argument {
        Argument::Positive(*self)
    }

    fn decode(argument: &Argument) -> Option<Self> {
        match argument {
            Argument::Positive(value) => Some(*value),
            Argument::None | Argument::Negative(_) | Argument::Text(_) | Argument::Raw(_) => None,
        }
    }
}

impl ArgumentType for bool {
    fn encode(&self) -> Argument {
        Argument::Positive(u16::from(*self))
    }

    fn decode(argument: &Argument) -> Option<Self> {
        u16::decode(argument).map(|value| value != 0)
    }
}

impl ArgumentType for Form {
    fn encode(&self) -> Argument {
        match self {
            Self::Bare => Argument::None,
            Self::One => Argument::Positive(1),
        }
    }

    fn decode(argument: &Argument) -> Option<Self> {
        match argument {
            Argument::None => Some(Self::Bare),
            Argument::Positive(_) | Argument::Negative(_) => Some(Self::One),
            Argument::Text(_) | Argument::Raw(_) => None,
        }
    }
}

impl ArgumentType for Vec<u8> {
    fn encode(&self) -> Argument {
        Argument::Text(self.clone())
    }

    fn decode(argument: &Argument) -> Option<Self> {
        match argument {
            Argument::Text(bytes) => Some(bytes.clone()),
            Argument::None | Argument::Positive(_) | Argument::Negative(_) | Argument::Raw(_) => None,
        }
    }
}

impl ArgumentType for Wheels {
    fn encode(&self) -> Argument {
        Argument::Positive(u16::from_le_bytes([
            self.right.cast_unsigned(),
            self.left.cast_unsigned(),
        ]))
    }

    fn decode(argument: &Argument) -> Option<Self> {
        let [right, left] = i16::decode(argument)?.to_le_bytes().map(u8::cast_signed);
        Some(Self { left, right })
    }
}

/// No argument. A number is accepted too.
impl ArgumentType for () {
    fn encode(&self) -> Argument {
        Argument::None
    }

    fn decode(argument: &Argument) -> Option<Self> {
        match argument {
            Argument::None | Argument::Positive(_) | Argument::Negative(_) => Some(()),
            Argument::Text(_) | Argument::Raw(_) => None,
        }
    }
}

/// No argument for the origin, else x mm, y mm, th degrees. It is sent with the type byte: without it, one
/// old robot reads past the end.
impl ArgumentType for Option<[i16; 3]> {
    fn encode(&self) -> Argument {
        let numbers = self.iter().flatten().flat_map(|number| number.to_le_bytes());
        Argument::Raw(core::iter::once(POSITIVE).chain(numbers).collect())
    }

    fn decode(argument: &Argument) -> Option<Self> {
        match (argument, argument.raw()) {
            (Argument::None | Argument::Positive(_) | Argument::Negative(_), _) | (_, [_]) => Some(None),
            (_, [_, a, b, c, d, e, f]) => Some(Some([[*a, *b], [*c, *d], [*e, *f]].map(i16::from_le_bytes))),
            _ => None,
        }
    }
}

impl ArgumentType for ForLaser {
    fn encode(&self) -> Argument {
        let mut bytes = Vec::with_capacity(4);
        self.value.encode().write(&mut bytes);
        bytes.push(self.laser);
        Argument::Raw(bytes)
    }

    fn decode(argument: &Argument) -> Option<Self> {
        if let Some(value) = i16::decode(argument) {
            return Some(Self { value, laser: 0 });
        }
        let (laser, number) = argument.raw().split_last()?;
        let value = i16::decode(&Argument::read(number))?;
        Some(Self { value, laser: *laser })
    }
}

impl ArgumentType for SimPose {
    fn encode(&self) -> Argument {
        let numbers = [self.x, self.y, self.th].into_iter().flat_map(i32::to_le_bytes);
        Argument::Raw(core::iter::once(POSITIVE).chain(numbers).collect())
    }

    fn decode(argument: &Argument) -> Option<Self> {
        let (numbers, []) = argument.raw().get(1..)?.as_chunks::<4>() else {
            return None;
        };
        let [x, y, th] = *numbers else { return None };
        let [x, y, th] = [x, y, th].map(i32::from_le_bytes);
        Some(Self { x, y, th })
    }
}

impl ArgumentType for SimControl {
    fn encode(&self) -> Argument {
        let mut bytes = Vec::with_capacity(3 + self.data.len());
        self.code.encode().write(&mut bytes);
        bytes.extend(&self.data);
        // Without data the bytes are a plain number, so that reading returns the same argument.
        Argument::read(&bytes)
    }

    fn decode(argument: &Argument) -> Option<Self> {
        if let Some(code) = u16::decode(argument) {
            return Some(Self {
                code,
                data: Vec::new(),
            });
        }
        match argument.raw() {
            [POSITIVE, low, high, data @ ..] => Some(Self {
                code: u16::from_le_bytes([*low, *high]),
                data: data.to_vec(),
            }),
            _ => None,
        }
    }
}
