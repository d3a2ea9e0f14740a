//! Values of variables as Python objects, and Python objects as values. NumPy arrays are used if NumPy is
//! installed, and memoryviews otherwise. All are read-only copies: a value never changes.

use std::sync::Arc;

use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};
use jde_board::value::{self, Value};
use pyo3::exceptions::{PyAttributeError, PyTypeError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBool, PyBytes, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};

use crate::numbers;

/// A value with fields, which are attributes. Fields of numbers are read-only arrays.
#[pyclass(frozen, module = "jde", name = "Value")]
pub(crate) struct StructValue {
    value_type: Arc<Type>,
    /// The bytes of the whole value, of which this one may be a part.
    bytes: Py<PyBytes>,
    offset: usize,
}

#[pymethods]
impl StructValue {
    /// The name of its type: `sensor_msgs/msg/LaserScan`.
    #[getter]
    fn type_name(&self) -> &str {
        &self.value_type.name
    }

    fn __getattr__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let fields = &self.value_type.fields;
        match fields.iter().find(|field| field.name == name) {
            Some(field) => read_field(field, self.bytes.bind(py), self.offset),
            None => {
                let known: Vec<_> = fields.iter().map(|field| field.name.as_str()).collect();
                let (type_name, known) = (&self.value_type.name, known.join(", "));
                Err(PyAttributeError::new_err(format!(
                    "a {type_name} has no field `{name}`; it has {known}"
                )))
            }
        }
    }

    fn __dir__(&self) -> Vec<&str> {
        let own = ["type_name", "to_dict"].into_iter();
        own.chain(self.value_type.fields.iter().map(|field| field.name.as_str()))
            .collect()
    }

    /// Returns the fields by name, with lists in place of arrays.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.decode(py))
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        format!("{} {}", self.value_type.name, self.decode(py))
    }

    fn __eq__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| {
            let other = other.get();
            self.value_type.same_as(&other.value_type) && self.decode(py) == other.decode(py)
        })
    }
}

impl StructValue {
    fn decode(&self, py: Python<'_>) -> Value {
        value::decode(&self.value_type, &self.bytes.as_bytes(py)[self.offset..])
    }
}

/// Returns the value in `bytes`; that of the only field for a type with one field.
pub(crate) fn to_python<'py>(
    py: Python<'py>,
    value_type: &Arc<Type>,
    bytes: &[u8],
) -> PyResult<Bound<'py, PyAny>> {
    let bytes = PyBytes::new(py, bytes);
    match value_type.fields.as_slice() {
        [field] => read_field(field, &bytes, 0),
        _ => structure(value_type, &bytes, 0),
    }
}

/// Returns a decoded value as numbers, texts, lists and dictionaries.
pub(crate) fn plain<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Bool(value) => PyBool::new(py, *value).to_owned().into_any(),
        Value::Int(value) => value.into_pyobject(py)?.into_any(),
        Value::UInt(value) => value.into_pyobject(py)?.into_any(),
        Value::Float(value) => value.into_pyobject(py)?.into_any(),
        Value::Text(value) => value.into_pyobject(py)?.into_any(),
        Value::List(values) => {
            let list = PyList::empty(py);
            for value in values {
                list.append(plain(py, value)?)?;
            }
            list.into_any()
        }
        Value::Map(fields) => {
            let dictionary = PyDict::new(py);
            for (name, value) in fields {
                dictionary.set_item(name, plain(py, value)?)?;
            }
            dictionary.into_any()
        }
    })
}

/// Reads a Python object: a number, a text, a sequence, a mapping, a dataclass, an array or a value.
pub(crate) fn from_python(object: &Bound<'_, PyAny>) -> PyResult<Value> {
    let py = object.py();
    if object.is_instance_of::<PyBool>() {
        return Ok(Value::Bool(object.extract()?));
    }
    if object.is_instance_of::<PyInt>() {
        return match object.extract::<i64>() {
            Ok(number) => Ok(Value::Int(number)),
            Err(_) => object.extract().map(Value::UInt),
        };
    }
    if object.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(object.extract()?));
    }
    if object.is_instance_of::<PyString>() {
        return Ok(Value::Text(object.extract()?));
    }
    if let Ok(value) = object.cast::<StructValue>() {
        return Ok(value.get().decode(py));
    }
    if let Ok(fields) = object.cast::<PyDict>() {
        let fields = fields.iter();
        let read = fields.map(|(name, value)| Ok((name.extract()?, from_python(&value)?)));
        return read.collect::<PyResult<_>>().map(Value::Map);
    }
    if object.is_instance_of::<PyList>() || object.is_instance_of::<PyTuple>() {
        let values = object.try_iter()?;
        return values
            .map(|value| from_python(&value?))
            .collect::<PyResult<_>>()
            .map(Value::List);
    }
    if let Ok(fields) = object.getattr("__dataclass_fields__") {
        let mut read = Vec::new();
        for name in fields.try_iter()? {
            let name: String = name?.extract()?;
            let value = from_python(&object.getattr(name.as_str())?)?;
            read.push((name, value));
        }
        return Ok(Value::Map(read));
    }
    // Arrays and numbers of NumPy.
    match object.call_method0("tolist") {
        Ok(list) => from_python(&list),
        Err(_) => Err(PyTypeError::new_err(format!(
            "a {} is no value: give a number, a text, a list, a dictionary or a value",
            object.get_type().name()?
        ))),
    }
}

/// Returns the text of a value as an application file states it. A text alone stands without quotes.
pub(crate) fn as_text(value: &Value) -> String {
    match value {
        Value::Text(text) => text.clone(),
        other => as_toml(other),
    }
}

fn as_toml(value: &Value) -> String {
    match value {
        Value::Bool(value) => value.to_string(),
        Value::Int(value) => value.to_string(),
        Value::UInt(value) => value.to_string(),
        Value::Float(value) => format!("{value:?}"),
        Value::Text(value) => toml::Value::from(value.as_str()).to_string(),
        Value::List(values) => format!("[{}]", Vec::from_iter(values.iter().map(as_toml)).join(", ")),
        Value::Map(fields) => {
            let fields = fields.iter();
            let fields = fields
                .map(|(name, value)| format!("{} = {}", toml::Value::from(name.as_str()), as_toml(value)));
            format!("{{ {} }}", Vec::from_iter(fields).join(", "))
        }
    }
}

/// Returns the `dtype` of NumPy for a type, as the dictionary from which NumPy makes it. Sequences and texts have
/// the length of their capacity; the field `NAME.length` is the number of elements in use.
pub(crate) fn dtype<'py>(py: Python<'py>, value_type: &Type) -> PyResult<Bound<'py, PyDict>> {
    let (names, formats, offsets) = (PyList::empty(py), PyList::empty(py), PyList::empty(py));
    for field in &value_type.fields {
        let element = match &field.kind {
            FieldKind::Scalar(scalar) => dtype_code(*scalar).into_pyobject(py)?.into_any(),
            FieldKind::Struct(inner) => dtype(py, inner)?.into_any(),
        };
        let format = match field.form {
            Form::One => element,
            Form::Array(count) => (element, count).into_pyobject(py)?.into_any(),
            Form::Sequence { capacity, .. } => (element, capacity).into_pyobject(py)?.into_any(),
            Form::Text { capacity, .. } => format!("S{capacity}").into_pyobject(py)?.into_any(),
        };
        names.append(&field.name)?;
        formats.append(format)?;
        offsets.append(field.offset)?;
        if let Some(offset) = field.form.length_offset() {
            names.append(format!("{}.length", field.name))?;
            formats.append("u4")?;
            offsets.append(offset)?;
        }
    }
    let described = PyDict::new(py);
    described.set_item("names", names)?;
    described.set_item("formats", formats)?;
    described.set_item("offsets", offsets)?;
    described.set_item("itemsize", value_type.bytes)?;
    Ok(described)
}

/// Returns the number of elements of a field of the structure at the start of `bytes`.
pub(crate) fn length(form: Form, bytes: &[u8]) -> usize {
    let stated = form
        .length_offset()
        .and_then(|offset| bytes[offset..].first_chunk());
    let capacity = form.capacity();
    stated.map_or(capacity, |stated| {
        capacity.min(u32::from_ne_bytes(*stated) as usize)
    })
}

fn structure<'py>(
    value_type: &Arc<Type>,
    bytes: &Bound<'py, PyBytes>,
    offset: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let value = StructValue {
        value_type: Arc::clone(value_type),
        bytes: bytes.clone().unbind(),
        offset,
    };
    Ok(Bound::new(bytes.py(), value)?.into_any())
}

/// Reads a field of the structure at `offset`.
fn read_field<'py>(field: &Field, bytes: &Bound<'py, PyBytes>, offset: usize) -> PyResult<Bound<'py, PyAny>> {
    let py = bytes.py();
    let count = length(field.form, &bytes.as_bytes()[offset..]);
    let start = offset + field.offset;
    match (&field.form, &field.kind) {
        (Form::One, FieldKind::Scalar(scalar)) => read_scalar(py, *scalar, &bytes.as_bytes()[start..]),
        (Form::One, FieldKind::Struct(inner)) => structure(inner, bytes, start),
        (Form::Text { .. }, _) => {
            let text = String::from_utf8_lossy(&bytes.as_bytes()[start..][..count]);
            Ok(text.into_pyobject(py)?.into_any())
        }
        (Form::Array(_) | Form::Sequence { .. }, FieldKind::Scalar(scalar)) => {
            array(*scalar, bytes, start, count)
        }
        (Form::Array(_) | Form::Sequence { .. }, FieldKind::Struct(inner)) => {
            let list = PyList::empty(py);
            for index in 0..count {
                list.append(structure(inner, bytes, start + index * inner.bytes)?)?;
            }
            Ok(list.into_any())
        }
    }
}

/// Returns a read-only array over numbers in `bytes`.
fn array<'py>(
    scalar: Scalar,
    bytes: &Bound<'py, PyBytes>,
    start: usize,
    count: usize,
) -> PyResult<Bound<'py, PyAny>> {
    static FROM_BUFFER: PyOnceLock<Option<Py<PyAny>>> = PyOnceLock::new();
    let py = bytes.py();
    let from_buffer = FROM_BUFFER.get_or_init(py, || {
        let numpy = py.import("numpy").ok()?;
        numpy.getattr("frombuffer").ok().map(Bound::unbind)
    });
    if let Some(from_buffer) = from_buffer {
        return from_buffer
            .bind(py)
            .call1((bytes, dtype_code(scalar), count, start));
    }
    let part = PyBytes::new(py, &bytes.as_bytes()[start..][..count * scalar.bytes()]);
    let view = py.import("builtins")?.call_method1("memoryview", (part,))?;
    view.call_method1("cast", (numbers::format(scalar),))
}

fn read_scalar<'py>(py: Python<'py>, scalar: Scalar, bytes: &[u8]) -> PyResult<Bound<'py, PyAny>> {
    plain(py, &value::decode_scalar(scalar, bytes))
}

/// The code of a scalar in NumPy.
pub(crate) fn dtype_code(scalar: Scalar) -> &'static str {
    match scalar {
        Scalar::Bool => "?",
        Scalar::U8 => "u1",
        Scalar::U16 => "u2",
        Scalar::U32 => "u4",
        Scalar::U64 => "u8",
        Scalar::I8 => "i1",
        Scalar::I16 => "i2",
        Scalar::I32 => "i4",
        Scalar::I64 => "i8",
        Scalar::F32 => "f4",
        Scalar::F64 => "f8",
    }
}
