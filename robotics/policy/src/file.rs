//! What a text file of a policy states.

use std::ops::Range;

use crate::choices::Choices;
use crate::chunk::ChunkRule;
use crate::scale::Scale;

/// A number of a velocity that a policy commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Ahead, m/s.
    LinearX,
    /// To the left, m/s.
    LinearY,
    /// The turn rate to the left, rad/s.
    AngularZ,
}

/// The numbers of a velocity, by their names in files.
pub const COMMAND_AXES: [(&str, Axis); 3] = [
    ("linear.x", Axis::LinearX),
    ("linear.y", Axis::LinearY),
    ("angular.z", Axis::AngularZ),
];

/// A text file of a policy. Indices of roles are those of `roles`.
#[derive(Clone, Debug)]
pub(crate) struct PolicyFile {
    pub(crate) network: String,
    pub(crate) network_span: Range<usize>,
    /// The time of a step, s.
    pub(crate) period: f64,
    pub(crate) roles: Vec<Role>,
    pub(crate) inputs: Vec<Input>,
    pub(crate) outputs: Vec<Output>,
    pub(crate) choices: Option<Choices>,
    pub(crate) value: Option<Pick>,
    pub(crate) scores: Option<Pick>,
    pub(crate) memory: Vec<Memory>,
    pub(crate) doubt: Option<Doubt>,
    pub(crate) chunk: Option<ChunkRule>,
}

/// A variable that the application binds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Role {
    pub(crate) name: String,
    pub(crate) kind: Kind,
}

/// What a role must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Any type that has the fields.
    Any,
    Scan,
    Path,
    Odometry,
    Image,
}

/// Numbers that go into the network, in the order of the file.
#[derive(Clone, Debug)]
pub(crate) struct Input {
    pub(crate) span: Range<usize>,
    pub(crate) source: Source,
    /// How many numbers the source gives.
    pub(crate) count: usize,
    pub(crate) scale: Scale,
    /// How many of the last values go in, the oldest first.
    pub(crate) stack: usize,
    /// The name of the network's input; the only one if left out.
    pub(crate) into: Option<(String, Range<usize>)>,
}

/// Where numbers come from.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    /// Fields of a variable.
    Field { role: usize, path: String },
    /// The least distance in each of several sectors of a scan, between two angles, rad. A sector without a measurement is
    /// `unknown`, m, or else leaves the policy without a value.
    Rays {
        role: usize,
        from: f64,
        to: f64,
        unknown: Option<f64>,
    },
    /// The point of a path that is `ahead` m along it, in the frame of the base, at most `reach` m away.
    Path {
        role: usize,
        pose: usize,
        ahead: f64,
        reach: f64,
    },
    /// The target, in the frame of the base, at most `reach` m away.
    Target { pose: usize, reach: f64 },
    /// A picture, resampled, channel after channel; a white pixel is `white`.
    Pixels {
        role: usize,
        width: usize,
        height: usize,
        colours: Colours,
        white: f64,
    },
    /// The last command of the policy.
    Command(Axis),
}

/// The channels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Colours {
    /// One, how bright it is.
    Grey,
    /// Red, green and blue.
    Rgb,
}

/// One number of the network's outputs, or all of one.
#[derive(Clone, Debug)]
pub(crate) struct Pick {
    pub(crate) span: Range<usize>,
    /// The name of the output; the only one if left out.
    pub(crate) of: Option<(String, Range<usize>)>,
    pub(crate) index: usize,
}

/// A number of the command.
#[derive(Clone, Debug)]
pub(crate) struct Output {
    pub(crate) axis: Axis,
    pub(crate) pick: Pick,
    pub(crate) bounds: (f64, f64),
    /// Whether −1 and 1 are the bounds. Otherwise the network gives the command itself.
    pub(crate) is_scaled: bool,
}

/// An output that is an input of the next step.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    pub(crate) input: (String, Range<usize>),
    pub(crate) output: (String, Range<usize>),
}

/// How unsure the policy is.
#[derive(Clone, Debug)]
pub(crate) struct Doubt {
    pub(crate) pick: Pick,
    pub(crate) kind: DoubtKind,
    /// Up to this doubt it is sure.
    pub(crate) certain: f64,
    /// From this doubt on it does not know.
    pub(crate) unsure: f64,
}

/// What tells the doubt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DoubtKind {
    /// How much the members of an ensemble differ: the output has a row for each.
    Spread,
    /// A number of the network.
    Number,
}
