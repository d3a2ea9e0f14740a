//! A value that several plugins share. They depend on this crate; it depends on no plugin.

use jde_types::{Header, Pose2D, Value};

/// Position of an object, seen from the robot.
///
/// Its name in applications and tools is `__crate__/msg/__Name__`. A value is plain data of fixed size: numbers, `Flag`,
/// `Text<N>`, `Seq<T, N>`, arrays, and other values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
pub struct __Name__ {
    /// Time of the measurement, and the frame of the bearing.
    pub header: Header,
    /// Distance to the object.
    #[value(unit = "m")]
    pub distance: f64,
    /// Direction to the object; positive is to the left.
    #[value(unit = "rad")]
    pub bearing: f64,
}

impl __Name__ {
    /// Returns the position in the frame of the bearing.
    #[must_use]
    pub fn place(&self) -> Pose2D {
        let (sin, cos) = self.bearing.sin_cos();
        Pose2D::new(self.distance * cos, self.distance * sin, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_fields_are_described_with_their_units() {
        let described = __Name__::describe();
        assert_eq!(described.name, "__crate__/msg/__Name__");
        let fields = described.fields.iter().map(|field| (&*field.name, &*field.unit));
        assert_eq!(fields.collect::<Vec<_>>(), [("header", ""), ("distance", "m"), ("bearing", "rad")]);
    }

    #[test]
    fn an_object_on_the_left_has_a_positive_y() {
        let left = __Name__ { distance: 2.0, bearing: core::f64::consts::FRAC_PI_2, ..__Name__::default() };
        assert!(left.place().distance_to(&Pose2D::new(0.0, 2.0, 0.0)) < 1e-9);
    }
}
