//! Numbers with a shape, and how a file stores them. Numbers of 16 bits, of 8 bits and of 64 bits are refused: their
//! results would differ from those of the network that was trained.

use crate::model::Stored;
use crate::{MAX_BYTES, MAX_OPERATIONS, OnnxError};

/// The most numbers that a node gives, 64 MB of them: a picture of 256 x 256 has 100 channels then.
const MAX_NUMBERS: usize = 1 << 24;
/// The most whole numbers that a node gives. They are shapes, axes and indices.
const MAX_WHOLE: usize = 1 << 16;

/// Numbers with a shape, the last dimension fastest.
#[derive(Clone, Debug)]
pub(crate) struct Tensor {
    pub(crate) shape: Vec<usize>,
    pub(crate) data: Data,
    /// What their computation takes, in multiplications of a product of matrices.
    pub(crate) operations: u64,
}

/// The numbers. Whole ones are shapes, axes and indices, which are known before the first run, and what an `ArgMax` chose.
#[derive(Clone, Debug)]
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
        Self::new(vec![0], Data::Float(Vec::new()))
    }
}

impl Tensor {
    /// Returns numbers that nothing computes.
    pub(crate) fn new(shape: Vec<usize>, data: Data) -> Self {
        Self {
            shape,
            data,
            operations: 0,
        }
    }

    /// Returns whole numbers in a row.
    pub(crate) fn integers(numbers: Vec<i64>) -> Self {
        Self::new(vec![numbers.len()], Data::Integer(numbers))
    }

    pub(crate) fn zeros(shape: Vec<usize>) -> Result<Self, String> {
        let count = count(&shape, MAX_NUMBERS)?;
        Ok(Self::new(shape, Data::Float(vec![0.0; count])))
    }

    /// Returns the numbers; an error if they are whole ones.
    pub(crate) fn floats(&self) -> Result<&[f32], String> {
        match &self.data {
            Data::Float(numbers) => Ok(numbers),
            Data::Integer(_) => Err("it takes numbers of 32 bits here, not whole numbers".to_owned()),
        }
    }

    /// Returns the numbers to change them.
    pub(crate) fn floats_mut(&mut self) -> Result<&mut [f32], String> {
        match &mut self.data {
            Data::Float(numbers) => Ok(numbers),
            Data::Integer(_) => Err("it has whole numbers".to_owned()),
        }
    }

    /// Returns the whole numbers.
    pub(crate) fn whole(&self) -> Result<&[i64], String> {
        match &self.data {
            Data::Integer(numbers) => Ok(numbers),
            Data::Float(_) => Err("it takes whole numbers here".to_owned()),
        }
    }

    /// Becomes numbers of this shape and returns their room, whose content is undefined. Each of them takes `each` operations,
    /// and nothing is reserved for more of them than a network may have.
    pub(crate) fn room(&mut self, shape: &[usize], each: usize) -> Result<&mut [f32], String> {
        let count = count(shape, MAX_NUMBERS)?;
        self.operations = (count as u64).saturating_mul(each as u64);
        if self.operations > MAX_OPERATIONS {
            return Err(format!(
                "its result of the shape {shape:?} takes {} operations, and {MAX_OPERATIONS} are the most of a network",
                self.operations
            ));
        }
        self.shape.clear();
        self.shape.extend_from_slice(shape);
        if let Data::Integer(_) = self.data {
            self.data = Data::Float(Vec::new());
        }
        if let Data::Float(numbers) = &mut self.data {
            numbers.resize(count, 0.0);
        }
        self.floats_mut()
    }

    /// Becomes these whole numbers, of which there must be as many as the shape has. Each of them takes one operation.
    pub(crate) fn put_whole(
        &mut self,
        shape: &[usize],
        numbers: impl Iterator<Item = i64>,
    ) -> Result<(), String> {
        let count = count(shape, MAX_WHOLE)?;
        *self = Self::new(shape.to_vec(), Data::Integer(numbers.take(count).collect()));
        self.operations = count as u64;
        Ok(())
    }

    /// Becomes a copy with another shape of as many numbers.
    pub(crate) fn copy_from(&mut self, other: &Self, shape: &[usize]) -> Result<(), String> {
        let sides = other.shape.iter().product::<usize>();
        if shape.iter().try_fold(1_usize, |all, side| all.checked_mul(*side)) != Some(sides) {
            return Err(format!("{:?} cannot have the shape {shape:?}", other.shape));
        }
        match &other.data {
            Data::Float(numbers) => self.room(shape, 1)?.copy_from_slice(numbers),
            Data::Integer(numbers) => self.put_whole(shape, numbers.iter().copied())?,
        }
        Ok(())
    }
}

/// Returns how many numbers a shape has, which are `most` at most.
pub(crate) fn count(shape: &[usize], most: usize) -> Result<usize, String> {
    // A side of 0 beside long ones would make loops over nothing long.
    let all = shape
        .iter()
        .try_fold(1_usize, |product, side| product.checked_mul((*side).max(1)));
    match all {
        Some(all) if all <= most => Ok(if shape.contains(&0) { 0 } else { all }),
        _ => Err(format!(
            "a tensor of the shape {shape:?} is too large: {most} numbers are the most"
        )),
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
        let expected = count(&shape, MAX_BYTES as usize / 4).map_err(wrong)?;
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
        Ok(Tensor::new(shape, data))
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
