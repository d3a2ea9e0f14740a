//! Clouds of points, whose fields the cloud itself describes.

use crate::{Flag, Header, Padding, Seq, Text, Value};

/// What a point of a cloud has, and where.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/PointField")]
pub struct PointField {
    /// Name: "x", "y" and "z" are the position, m.
    pub name: Text<28>,
    /// Bytes from the start of the point.
    pub offset: u32,
    /// 1 and 2 for int8 and uint8, 3 and 4 of 16 bits, 5 and 6 of 32 bits, 7 float32, 8 float64.
    pub datatype: u8,
    /// Unused bytes.
    pub padding: Padding<3>,
    /// Number of elements; 0 counts as 1.
    pub count: u32,
}

/// A cloud of points, of up to 9 830 400 bytes: 640 × 480 points of 32 bytes. Bytes that a cloud does not have cost no
/// memory. A stack has no room for this type: fill a loan, or memory of the heap.
#[derive(Clone, Copy, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/PointCloud2")]
pub struct PointCloud2 {
    /// Time, and the frame of the points.
    pub header: Header,
    /// Rows; 1 without an order.
    pub height: u32,
    /// Points of a row.
    pub width: u32,
    /// What each point has.
    pub fields: Seq<PointField, 32>,
    /// Whether numbers begin with the most significant byte.
    pub is_bigendian: Flag,
    /// Unused bytes.
    pub padding: Padding<3>,
    /// Size of a point in bytes.
    pub point_step: u32,
    /// Size of a row in bytes.
    pub row_step: u32,
    /// The points, row by row.
    pub data: Seq<u8, { 640 * 480 * 32 }>,
    /// Whether all points are valid.
    pub is_dense: Flag,
    /// Unused bytes.
    pub tail: Padding<3>,
}

impl PointField {
    /// Datatype: single precision.
    pub const FLOAT32: u8 = 7;
    /// Datatype: double precision.
    pub const FLOAT64: u8 = 8;

    /// Returns the bytes of one element; `None` for a datatype that does not exist.
    const fn element(&self) -> Option<u64> {
        match self.datatype {
            1 | 2 => Some(1),
            3 | 4 => Some(2),
            5 | 6 | Self::FLOAT32 => Some(4),
            Self::FLOAT64 => Some(8),
            _ => None,
        }
    }
}

impl PointCloud2 {
    /// Checks that each field has a datatype and is within a point, each point within a row, and each row within the bytes.
    ///
    /// # Errors
    /// What is not.
    pub fn check(&self) -> Result<(), &'static str> {
        let [height, width, step, row] =
            [self.height, self.width, self.point_step, self.row_step].map(u64::from);
        for field in &self.fields {
            let element = field.element().ok_or("a field has no datatype from 1 to 8")?;
            if u64::from(field.offset) + element * u64::from(field.count.max(1)) > step {
                return Err("a field ends behind its point");
            }
        }
        if width * step > row {
            Err("a row is shorter than its points")
        } else if row * height > self.data.len() as u64 {
            Err("a cloud with bytes missing")
        } else {
            Ok(())
        }
    }

    /// Returns the positions of the points, m, row by row. Those that are not finite are left out.
    ///
    /// # Errors
    /// As [`Self::check`]; or if the fields `x`, `y` and `z` are not floating-point numbers.
    pub fn points(&self) -> Result<impl Iterator<Item = [f64; 3]> + '_, &'static str> {
        self.check()?;
        let [x, y, z] = ["x", "y", "z"].map(|name| self.number(name));
        let axes = [x?, y?, z?];
        let rows = self.data.chunks_exact(self.row_step.max(1) as usize);
        let row = move |row| {
            let points = <[u8]>::chunks_exact(row, self.point_step.max(1) as usize);
            points.take(self.width as usize)
        };
        let points = rows.take(self.height as usize).flat_map(row);
        let points = points.map(move |point| axes.map(|axis| self.read(axis, point)));
        Ok(points.filter(|point| point.iter().all(|axis| axis.is_finite())))
    }

    /// Returns where a floating-point number is in a point, and whether it has double precision.
    fn number(&self, name: &str) -> Result<(usize, bool), &'static str> {
        let field = self.fields.iter().find(|field| field.name == name);
        match field {
            Some(field) if field.datatype == PointField::FLOAT32 => Ok((field.offset as usize, false)),
            Some(field) if field.datatype == PointField::FLOAT64 => Ok((field.offset as usize, true)),
            _ => Err("x, y and z are not fields of floating-point numbers"),
        }
    }

    fn read(&self, (offset, is_double): (usize, bool), point: &[u8]) -> f64 {
        let (mut bytes, size) = ([0; 8], if is_double { 8 } else { 4 });
        bytes[..size].copy_from_slice(&point[offset..][..size]);
        if self.is_bigendian.get() {
            bytes[..size].reverse();
        }
        let bits = u64::from_le_bytes(bytes);
        if is_double {
            f64::from_bits(bits)
        } else {
            f32::from_bits(bits as u32).into()
        }
    }
}

impl core::fmt::Debug for PointCloud2 {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "PointCloud2({} x {} points)", self.width, self.height)
    }
}
