//! The limits of a command: no number of it exceeds that of the driver's limits in magnitude, whoever gives it. Sequences
//! of elements have none.

use jde_abi::describe::{FieldKind, Form, Scalar, Type};

/// The limits of one command.
pub(crate) struct CommandLimits {
    /// What states them, for messages.
    pub(crate) stated_by: String,
    f64s: Vec<(usize, f64)>,
    f32s: Vec<(usize, f32)>,
}

impl CommandLimits {
    /// The limits that a value of the command's type states: its magnitudes; a 0 limits nothing.
    pub(crate) fn new(stated_by: String, value_type: &Type, stated: &[u8]) -> Self {
        let mut limits = Self {
            stated_by,
            f64s: Vec::new(),
            f32s: Vec::new(),
        };
        limits.add(value_type, stated, 0);
        limits
    }

    fn add(&mut self, value_type: &Type, stated: &[u8], base: usize) {
        for field in &value_type.fields {
            let (count, base) = match field.form {
                Form::One => (1, base + field.offset),
                Form::Array(count) => (count, base + field.offset),
                Form::Sequence { .. } | Form::Text { .. } => continue,
            };
            for place in 0..count {
                match &field.kind {
                    FieldKind::Scalar(Scalar::F64) => {
                        let at = base + place * size_of::<f64>();
                        let limit = f64::from_ne_bytes(read(stated, at)).abs();
                        self.f64s.extend((limit > 0.0).then_some((at, limit)));
                    }
                    FieldKind::Scalar(Scalar::F32) => {
                        let at = base + place * size_of::<f32>();
                        let limit = f32::from_ne_bytes(read(stated, at)).abs();
                        self.f32s.extend((limit > 0.0).then_some((at, limit)));
                    }
                    FieldKind::Scalar(_) => {}
                    FieldKind::Struct(inner) => self.add(inner, stated, base + place * inner.bytes),
                }
            }
        }
    }

    /// Limits a command in place. Returns whether that changed it. A NaN stays, and is refused as one.
    pub(super) fn apply(&self, command: &mut [u8]) -> bool {
        let mut has_changed = false;
        for &(at, limit) in &self.f64s {
            let value = f64::from_ne_bytes(read(command, at));
            if value.abs() > limit {
                command[at..at + size_of::<f64>()].copy_from_slice(&limit.copysign(value).to_ne_bytes());
                has_changed = true;
            }
        }
        for &(at, limit) in &self.f32s {
            let value = f32::from_ne_bytes(read(command, at));
            if value.abs() > limit {
                command[at..at + size_of::<f32>()].copy_from_slice(&limit.copysign(value).to_ne_bytes());
                has_changed = true;
            }
        }
        has_changed
    }
}

fn read<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes[at..at + N].try_into().expect("a field is within its value")
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
    fn no_number_exceeds_its_limit_in_either_direction() {
        assert_eq!(
            limited(Twist::planar(1.2, -2.0)),
            (false, Twist::planar(1.2, -2.0))
        );
        assert_eq!(
            limited(Twist::planar(f64::MAX, -1e30)),
            (true, Twist::planar(1.2, -2.0))
        );
        assert_eq!(
            limited(Twist::planar(-50.0, 0.5)),
            (true, Twist::planar(-1.2, 0.5))
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
