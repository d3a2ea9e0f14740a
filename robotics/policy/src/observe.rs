//! From the values of variables to the numbers of a network, with what it saw before.

use jde_abi::describe::Type;
use jde_types::{Image, LaserScan, Odometry, Path, Pose2D, Value};

use crate::file::{Axis, Input, Kind, PolicyFile, Source};
use crate::numbers::{Numbers, collect};
use crate::pixels::pixels;
use crate::sources;

/// The values of one step.
pub trait Values {
    /// Returns the value of a role, by its number in [`Policy::roles`](crate::Policy::roles); `None` if it has none.
    fn role(&self, role: usize) -> Option<&[u8]>;

    /// Returns the target, in the frame of the odometry; `None` if there is none.
    fn target(&self) -> Option<Pose2D>;
}

/// Turns values into numbers for a network. It keeps those of the last steps, and the last command.
#[derive(Clone, Debug)]
pub struct Observer {
    parts: Vec<Part>,
    roles: Vec<String>,
    numbers: Vec<f32>,
    /// The last command: ahead, to the left, and the turn rate.
    last: [f64; 3],
    is_new: bool,
}

#[derive(Clone, Debug)]
struct Part {
    input: Input,
    /// Those of a field.
    fields: Vec<Numbers>,
    raw: Vec<f64>,
    /// Its first number in the observation.
    start: usize,
}

impl Observer {
    /// Checks that the roles are of the right types. `types` are those of the roles, in their order.
    ///
    /// # Errors
    /// Each role that does not fit, with what is wrong.
    pub(crate) fn new(file: &PolicyFile, types: &[&Type]) -> Result<Self, Vec<(String, String)>> {
        let mut wrong = Vec::new();
        for (role, value_type) in file.roles.iter().zip(types) {
            if let Some(expected) = role.kind.expected()
                && let Some(difference) = value_type.difference(&expected)
            {
                wrong.push((
                    role.name.clone(),
                    format!("it must be a {}: {difference}", expected.name),
                ));
            }
        }
        let mut parts = Vec::new();
        let mut start = 0;
        for input in &file.inputs {
            let mut fields = Vec::new();
            if let Source::Field { role, path } = &input.source {
                match fields_of(types[*role], path, input.count) {
                    Ok(found) => fields = found,
                    Err(message) => wrong.push((file.roles[*role].name.clone(), message)),
                }
            }
            let raw = vec![0.0; input.count];
            parts.push(Part {
                input: input.clone(),
                fields,
                raw,
                start,
            });
            start += input.count * input.stack;
        }
        if !wrong.is_empty() {
            return Err(wrong);
        }
        Ok(Self {
            parts,
            roles: file.roles.iter().map(|role| role.name.clone()).collect(),
            numbers: vec![0.0; start],
            last: [0.0; 3],
            is_new: true,
        })
    }

    /// Forgets what was before. The next step fills the stacks with its own values.
    pub fn reset(&mut self) {
        self.is_new = true;
        self.last = [0.0; 3];
    }

    /// Keeps the last command: ahead and to the left, m/s, and the turn rate, rad/s.
    pub fn commanded(&mut self, command: [f64; 3]) {
        self.last = command;
    }

    /// Returns the numbers of this step, in the order of the file, each part with its stack. Without a value of any part
    /// nothing is kept.
    ///
    /// # Errors
    /// What is missing.
    pub fn observe(&mut self, values: &impl Values) -> Result<&[f32], String> {
        for part in &mut self.parts {
            part.sense(values, &self.roles, &self.last)?;
        }
        for part in &self.parts {
            let (count, stack) = (part.input.count, part.input.stack);
            let room = &mut self.numbers[part.start..][..count * stack];
            room.copy_within(count.., 0);
            let newest = room.len() - count;
            for (place, (to, raw)) in room[newest..].iter_mut().zip(&part.raw).enumerate() {
                *to = part.input.scale.apply(place, *raw);
            }
            if self.is_new {
                (0..stack - 1).for_each(|before| room.copy_within(newest.., before * count));
            }
        }
        self.is_new = false;
        Ok(&self.numbers)
    }

    /// Returns the numbers of the last step.
    #[must_use]
    pub fn numbers(&self) -> &[f32] {
        &self.numbers
    }

    /// Returns the least and the greatest value of each number of an observation.
    #[must_use]
    pub fn bounds(&self) -> Vec<(f32, f32)> {
        let of = |part: &Part| vec![part.input.scale.bounds(); part.input.count * part.input.stack];
        self.parts.iter().flat_map(of).collect()
    }
}

impl Kind {
    fn expected(self) -> Option<Type> {
        match self {
            Self::Any => None,
            Self::Scan => Some(LaserScan::describe()),
            Self::Path => Some(Path::describe()),
            Self::Odometry => Some(Odometry::describe()),
            Self::Image => Some(Image::describe()),
        }
    }
}

fn fields_of(value_type: &Type, path: &str, count: usize) -> Result<Vec<Numbers>, String> {
    let fields = collect(value_type, path)?;
    let varies = fields.iter().any(|field| field.form.length_offset().is_some());
    let most: usize = fields.iter().map(|field| field.form.capacity()).sum();
    match most == count || varies && most > count {
        true => Ok(fields),
        false => Err(format!(
            "`{path}` has {most} numbers, and the policy's file states {count}"
        )),
    }
}

impl Part {
    /// Reads the numbers of its source.
    fn sense(&mut self, values: &impl Values, roles: &[String], last: &[f64; 3]) -> Result<(), String> {
        let bytes = |role: usize| {
            values
                .role(role)
                .ok_or_else(|| format!("`{}` has no value", roles[role]))
        };
        let of = |role: usize| move |wrong: String| format!("`{}`: {wrong}", roles[role]);
        match &self.input.source {
            Source::Field { role, .. } => {
                let bytes = bytes(*role)?;
                let mut written = 0;
                for number in self.fields.iter().flat_map(|field| field.read(bytes)) {
                    if let Some(to) = self.raw.get_mut(written) {
                        *to = number;
                    }
                    written += 1;
                }
                if written != self.raw.len() {
                    return Err(of(*role)(format!(
                        "it has {written} numbers, not {}",
                        self.raw.len()
                    )));
                }
                if let Some(number) = self.raw.iter().find(|number| !number.is_finite()) {
                    return Err(of(*role)(format!("a number of it is {number}")));
                }
            }
            Source::Rays {
                role,
                from,
                to,
                unknown,
            } => {
                let scan: &LaserScan = view(bytes(*role)?).map_err(of(*role))?;
                sources::rays(scan, *from, *to, *unknown, &mut self.raw).map_err(of(*role))?;
            }
            Source::Path {
                role,
                pose,
                ahead,
                reach,
            } => {
                let here = sources::pose(view(bytes(*pose)?).map_err(of(*pose))?).map_err(of(*pose))?;
                let path: &Path = view(bytes(*role)?).map_err(of(*role))?;
                let point = sources::ahead_on(path, &here, *ahead).map_err(of(*role))?;
                self.raw.copy_from_slice(&sources::local(&here, &point, *reach));
            }
            Source::Target { pose, reach } => {
                let here = sources::pose(view(bytes(*pose)?).map_err(of(*pose))?).map_err(of(*pose))?;
                let target = values.target().ok_or("there is no target")?;
                self.raw.copy_from_slice(&sources::local(&here, &target, *reach));
            }
            Source::Pixels {
                role,
                width,
                height,
                colours,
                white,
            } => {
                let image: &Image = view(bytes(*role)?).map_err(of(*role))?;
                pixels(image, (*width, *height), *colours, *white, &mut self.raw).map_err(of(*role))?;
            }
            Source::Command(axis) => self.raw[0] = last[axis.index()],
        }
        Ok(())
    }
}

fn view<T: Value>(bytes: &[u8]) -> Result<&T, String> {
    T::view(bytes).ok_or_else(|| "its bytes are not those of its type".to_owned())
}

impl Axis {
    /// Its place in a command.
    pub(crate) fn index(self) -> usize {
        self as usize
    }
}
