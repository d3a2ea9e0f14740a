//! Numbers with a shape, and how a file stores them. Numbers of 16 bits, of 8 bits and of 64 bits are refused: their
//! results would differ from those of the network that was trained.

use crate::model::Stored;
use crate::{MAX_BYTES, OnnxError};

/// Numbers with a shape, the last dimension fastest.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tensor {
    pub(crate) shape: Vec<usize>,
    pub(crate) data: Data,
}

/// The numbers. Whole ones are shapes, axes and indices, which are known before the first run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Data {
    Float(Vec<f32>),
    Integer(Vec<i64>),
}

/// ONNX's numbers of the types that are read.
pub(crate) const TYPE_FLOAT: i64 = 1;
pub(crate) const TYPE_INT32: i64 = 6;
pub(crate) const TYPE_INT64: i64 = 7;

impl Default for Tensor {
    fn default() -> Self {
        Self {
            shape: vec![0],
            data: Data::Float(Vec::new()),
        }
    }
}

impl Tensor {
    /// Returns whole numbers in a row.
    pub(crate) fn integers(numbers: Vec<i64>) -> Self {
        Self {
            shape: vec![numbers.len()],
            data: Data::Integer(numbers),
        }
    }

    pub(crate) fn zeros(shape: Vec<usize>) -> Result<Self, String> {
        let count = count(&shape)?;
        Ok(Self {
            shape,
            data: Data::Float(vec![0.0; count]),
        })
    }

    /// Returns the numbers; an error if they are whole ones.
    pub(crate) fn floats(&self) -> Result<&[f32], String> {
        match &self.data {
            Data::Float(numbers) => Ok(numbers),
            Data::Integer(_) => Err("it takes numbers of 32 bits here, not whole numbers".to_owned()),
        }
    }

    /// Returns the whole numbers.
    pub(crate) fn whole(&self) -> Result<&[i64], String> {
        match &self.data {
            Data::Integer(numbers) => Ok(numbers),
            Data::Float(_) => Err("it takes whole numbers here".to_owned()),
        }
    }

    /// Becomes numbers of this shape and returns their room, whose content is undefined.
    pub(crate) fn room(&mut self, shape: &[usize]) -> Result<&mut [f32], String> {
        let count = count(shape)?;
        self.shape.clear();
        self.shape.extend_from_slice(shape);
        if let Data::Integer(_) = self.data {
            self.data = Data::Float(Vec::new());
        }
        match &mut self.data {
            Data::Float(numbers) => {
                numbers.resize(count, 0.0);
                Ok(numbers)
            }
            Data::Integer(_) => Err("it has no numbers".to_owned()),
        }
    }

    /// Becomes a copy with another shape of as many numbers.
    pub(crate) fn copy_from(&mut self, other: &Self, shape: &[usize]) -> Result<(), String> {
        if count(shape)? != other.shape.iter().product::<usize>() {
            return Err(format!("{:?} cannot have the shape {shape:?}", other.shape));
        }
        match &other.data {
            Data::Float(numbers) => self.room(shape)?.copy_from_slice(numbers),
            Data::Integer(numbers) => {
                self.shape = shape.to_vec();
                self.data = Data::Integer(numbers.clone());
            }
        }
        Ok(())
    }
}

/// Returns how many numbers a shape has.
pub(crate) fn count(shape: &[usize]) -> Result<usize, String> {
    let product = shape
        .iter()
        .try_fold(1_usize, |product, side| product.checked_mul(*side));
    match product {
        Some(count) if count as u64 <= MAX_BYTES / 4 => Ok(count),
        _ => Err(format!("a tensor of the shape {shape:?} is too large")),
    }
}

impl Stored {
    /// Returns the numbers. `raw` are those of another file.
    pub(crate) fn tensor(&self, raw: Option<&[u8]>) -> Result<Tensor, OnnxError> {
        let wrong = |message: String| OnnxError::tensor(&self.name, message);
        if self.is_segment {
            return Err(wrong(
                "it is one segment of several, which are not read".to_owned(),
            ));
        }
        let sides = self.shape.iter().map(|side| usize::try_from(*side).ok());
        let shape: Option<Vec<usize>> = sides.collect();
        let shape = shape.ok_or_else(|| wrong(format!("its shape is {:?}", self.shape)))?;
        let expected = count(&shape).map_err(wrong)?;
        let raw = raw.or(self.raw.as_deref());
        let data = match (self.data_type, raw) {
            (TYPE_FLOAT, None) => Data::Float(self.floats.clone()),
            (TYPE_FLOAT, Some(raw)) => Data::Float(chunks(raw).map(f32::from_le_bytes).collect()),
            (TYPE_INT64 | TYPE_INT32, None) => Data::Integer(self.integers.clone()),
            (TYPE_INT64, Some(raw)) => Data::Integer(chunks(raw).map(i64::from_le_bytes).collect()),
            (TYPE_INT32, Some(raw)) => {
                Data::Integer(chunks(raw).map(i32::from_le_bytes).map(i64::from).collect())
            }
            (other, _) => return Err(wrong(refusal(other))),
        };
        let bytes = raw.map(<[u8]>::len);
        let (given, size) = match &data {
            Data::Float(numbers) => (numbers.len(), 4),
            Data::Integer(numbers) => (numbers.len(), if self.data_type == TYPE_INT64 { 8 } else { 4 }),
        };
        if given != expected || bytes.is_some_and(|bytes| bytes != expected * size) {
            return Err(wrong(format!(
                "its shape {shape:?} needs {expected} numbers, and it has {given}"
            )));
        }
        if let Data::Float(numbers) = &data
            && let Some(at) = numbers.iter().position(|number| !number.is_finite())
        {
            return Err(wrong(format!(
                "number {at} is {}: weights must be finite; train or export the network again",
                numbers[at]
            )));
        }
        Ok(Tensor { shape, data })
    }
}

fn chunks<const N: usize>(raw: &[u8]) -> impl Iterator<Item = [u8; N]> {
    raw.as_chunks::<N>().0.iter().copied()
}

/// Says what to do about a type of numbers that is not run.
pub(crate) fn refusal(data_type: i64) -> String {
    let name = match data_type {
        2 => "UINT8",
        3 => "INT8",
        4 => "UINT16",
        5 => "INT16",
        8 => "STRING",
        9 => "BOOL",
        10 => "FLOAT16",
        11 => "DOUBLE",
        12 => "UINT32",
        13 => "UINT64",
        16 => "BFLOAT16",
        _ => {
            return format!(
                "its type of numbers, ONNX's {data_type}, is not run: export the network with float32"
            );
        }
    };
    format!("its numbers are {name}, which are not run: export the network with float32, not quantized")
}
