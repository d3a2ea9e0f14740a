//! The limits of a command: no number of it exceeds that of the driver's limits in magnitude, whoever gives it.
//!
//! All speeds of a command are lessened by one factor, so that an arc stays its arc; any other number, such as a position of
//! a joint, is lessened alone. Sequences of elements have no limits.

use jde_abi::describe::{FieldKind, Form, Scalar, Type};

/// The limits of one command.
pub(crate) struct CommandLimits {
    /// What states them, for messages.
    pub(crate) stated_by: String,
    speeds: Vec<LimitedNumber>,
    others: Vec<LimitedNumber>,
}

/// A number of a command, with its limit.
#[derive(Clone, Copy)]
struct LimitedNumber {
    /// Its first byte in the command.
    at: usize,
    is_double: bool,
    /// The largest magnitude, above 0; infinite for what has no limit.
    limit: f64,
}

impl CommandLimits {
    /// The limits that a value of the command's type states: its magnitudes; a 0 limits nothing.
    pub(crate) fn new(stated_by: String, value_type: &Type, stated: &[u8]) -> Self {
        let mut limits = Self {
            stated_by,
            speeds: Vec::new(),
            others: Vec::new(),
        };
        limits.add(value_type, stated, 0, false);
        limits
    }

    /// Adds the numbers of a part of the command. `of_speed` is whether its unit, which the field that contains it
    /// states, is one of a speed.
    fn add(&mut self, value_type: &Type, stated: &[u8], base: usize, of_speed: bool) {
        for field in &value_type.fields {
            let (count, base) = match field.form {
                Form::One => (1, base + field.offset),
                Form::Array(count) => (count, base + field.offset),
                Form::Sequence { .. } | Form::Text { .. } => continue,
            };
            let is_speed = of_speed || field.unit.ends_with("/s");
            for place in 0..count {
                let scalar = match &field.kind {
                    FieldKind::Scalar(scalar) => *scalar,
                    FieldKind::Struct(inner) => {
                        self.add(inner, stated, base + place * inner.bytes, is_speed);
                        continue;
                    }
                };
                let is_double = match scalar {
                    Scalar::F64 => true,
                    Scalar::F32 => false,
                    _ => continue,
                };
                let at = base
                    + place
                        * if is_double {
                            size_of::<f64>()
                        } else {
                            size_of::<f32>()
                        };
                let limit = match read(stated, at, is_double).abs() {
                    0.0 => f64::INFINITY,
                    limit => limit,
                };
                let numbers = if is_speed {
                    &mut self.speeds
                } else {
                    &mut self.others
                };
                numbers.push(LimitedNumber { at, is_double, limit });
            }
        }
    }

    /// Limits a command in place. Returns whether that changed it. A NaN stays, and is refused as one.
    pub(super) fn apply(&self, command: &mut [u8]) -> bool {
        let speeds = self.speeds.iter().map(|number| number.excess(command));
        let excess = speeds.fold(1.0, f64::max);
        let mut has_changed = excess > 1.0;
        if has_changed {
            for number in &self.speeds {
                number.set(command, number.get(command) / excess);
            }
        }
        for number in &self.others {
            if number.excess(command) > 1.0 {
                number.set(command, number.get(command));
                has_changed = true;
            }
        }
        has_changed
    }
}

impl LimitedNumber {
    fn get(&self, command: &[u8]) -> f64 {
        read(command, self.at, self.is_double)
    }

    /// Replaces the number, and keeps it within its limit whatever the rounding of a division did.
    fn set(&self, command: &mut [u8], value: f64) {
        // `clamp` keeps a NaN.
        let value = value.clamp(-self.limit, self.limit);
        if self.is_double {
            command[self.at..self.at + size_of::<f64>()].copy_from_slice(&value.to_ne_bytes());
        } else {
            command[self.at..self.at + size_of::<f32>()].copy_from_slice(&(value as f32).to_ne_bytes());
        }
    }

    /// The ratio of the number to its limit, finite, so that no division by it makes a NaN.
    fn excess(&self, command: &[u8]) -> f64 {
        (self.get(command).abs() / self.limit).min(f64::MAX)
    }
}

fn read(bytes: &[u8], at: usize, is_double: bool) -> f64 {
    let part = &bytes[at..];
    if is_double {
        f64::from_ne_bytes(*part.first_chunk().expect("a field is within its value"))
    } else {
        f32::from_ne_bytes(*part.first_chunk().expect("a field is within its value")).into()
    }
}

#[cfg(test)]
mod tests {
    use jde_types::{Twist, Value as _, Vector3};

    use super::*;

    fn limited(command: Twist) -> (bool, Twist) {
        let stated = Twist {
            linear: Vector3 {
                x: 1.2,
                y: 0.0,
                z: 0.0,
            },
            ..Twist::planar(0.0, 2.0)
        };
        let limits = CommandLimits::new(String::new(), &Twist::describe(), stated.as_bytes());
        let mut command = command;
        let changed = limits.apply(command.as_bytes_mut());
        (changed, command)
    }

    #[test]
    fn r7_no_number_exceeds_its_limit_in_either_direction() {
        assert_eq!(
            limited(Twist::planar(1.2, -2.0)),
            (false, Twist::planar(1.2, -2.0))
        );
        assert_eq!(
            limited(Twist::planar(f64::MAX, f64::MIN)),
            (true, Twist::planar(1.2, -1.2))
        );
        let (changed, command) = limited(Twist::planar(f64::INFINITY, 0.5));
        assert!(changed && command.linear.x == 1.2 && command.angular.z < 1e-300);
    }

    #[test]
    fn r7_an_arc_stays_its_arc() {
        assert_eq!(
            limited(Twist::planar(-2.4, 1.0)),
            (true, Twist::planar(-1.2, 0.5))
        );
        assert_eq!(limited(Twist::planar(1.0, 4.0)), (true, Twist::planar(0.5, 2.0)));
        let sideways = |x: f64, y: f64| {
            let mut twist = Twist::planar(x, 0.0);
            twist.linear.y = y;
            twist
        };
        assert_eq!(
            limited(sideways(2.4, 1.0)),
            (true, sideways(1.2, 0.5)),
            "a speed without a limit takes part"
        );
    }

    #[test]
    fn r7_a_number_that_is_no_speed_is_limited_alone() {
        let stated = Vector3 {
            x: 1.0,
            y: 1.0,
            z: 1.0,
        };
        let limits = CommandLimits::new(String::new(), &Vector3::describe(), stated.as_bytes());
        let mut position = Vector3 {
            x: -3.0,
            y: 0.5,
            z: 0.0,
        };
        assert!(limits.apply(position.as_bytes_mut()));
        assert_eq!(
            position,
            Vector3 {
                x: -1.0,
                y: 0.5,
                z: 0.0
            }
        );
    }

    #[test]
    fn a_limit_of_zero_limits_nothing() {
        let mut sideways = Twist::ZERO;
        sideways.linear.y = 1e6;
        assert_eq!(limited(sideways), (false, sideways));
    }

    #[test]
    fn what_is_not_a_number_is_left_for_the_check_of_the_command() {
        let (changed, command) = limited(Twist::planar(f64::NAN, f64::INFINITY));
        assert!(changed && command.linear.x.is_nan());
        assert_eq!(command.angular.z, 2.0);
    }
}
