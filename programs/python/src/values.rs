//! Values of variables as Python objects, which are copies, and Python objects as values.

use std::sync::Arc;

use jde_abi::describe::{FieldKind, Form, Scalar, Type};
use jde_board::value::Value;
use jde_files::{Budget, Exceeded};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};

use crate::layout::{Layout, attribute_of, field_of};
use crate::views::Views;

/// Returns the value in `bytes` as a schema reads it.
pub(crate) fn to_python<'py>(
    py: Python<'py>,
    value_type: &Arc<Type>,
    bytes: &[u8],
) -> PyResult<Bound<'py, PyAny>> {
    let layout = Layout::of(py, value_type)?;
    layout.get().decode(py, &Views::copying(py, bytes)?, 0)
}

/// Returns the part of a value that a path of its type names, such as `pose` or `places[2]`.
pub(crate) fn part_of<'py>(value: Bound<'py, PyAny>, path: &str) -> PyResult<Bound<'py, PyAny>> {
    let mut steps = path.split(['.', '[']).filter(|step| !step.is_empty());
    steps.try_fold(value, |value, step| match step.strip_suffix(']') {
        Some(index) => value.get_item(index.parse::<usize>()?),
        None => {
            let attribute = attribute_of(value.py(), step)?;
            // The value of a type whose only field is `data` is that of the field.
            Ok(value.getattr_opt(attribute)?.unwrap_or(value))
        }
    })
}

/// Returns a number, a `bool` or a text; `None` for a value with parts.
pub(crate) fn plain<'py>(py: Python<'py>, value: &Value) -> PyResult<Option<Bound<'py, PyAny>>> {
    Ok(Some(match value {
        Value::Bool(value) => PyBool::new(py, *value).to_owned().into_any(),
        Value::Int(value) => value.into_pyobject(py)?.into_any(),
        Value::UInt(value) => value.into_pyobject(py)?.into_any(),
        Value::Float(value) => value.into_pyobject(py)?.into_any(),
        Value::Text(value) => value.into_pyobject(py)?.into_any(),
        Value::List(_) | Value::Map(_) => return Ok(None),
    }))
}

/// Why an object is no value.
enum Refusal {
    Python(PyErr),
    Exceeded(Exceeded),
}

impl From<PyErr> for Refusal {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<Exceeded> for Refusal {
    fn from(exceeded: Exceeded) -> Self {
        Self::Exceeded(exceeded)
    }
}

/// Reads a Python object: a number, a text, a sequence, a mapping, a dataclass, an array or a value. One that contains
/// itself, or more than fits into a value, is a `ValueError`.
pub(crate) fn from_python(object: &Bound<'_, PyAny>) -> PyResult<Value> {
    read(object, &mut Budget::default()).map_err(|refusal| match refusal {
        Refusal::Python(error) => error,
        Refusal::Exceeded(exceeded) => PyValueError::new_err(format!("this is not a value: {exceeded}")),
    })
}

fn read(object: &Bound<'_, PyAny>, budget: &mut Budget) -> Result<Value, Refusal> {
    budget.hold(size_of::<Value>())?;
    if object.is_instance_of::<PyBool>() {
        return Ok(Value::Bool(object.extract()?));
    }
    if object.is_instance_of::<PyInt>() {
        return match object.extract::<i64>() {
            Ok(number) => Ok(Value::Int(number)),
            Err(_) => Ok(Value::UInt(object.extract()?)),
        };
    }
    if object.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(object.extract()?));
    }
    if object.is_instance_of::<PyString>() {
        budget.hold(object.len()?)?;
        return Ok(Value::Text(object.extract()?));
    }
    budget.descend(|budget| read_parts(object, budget))
}

/// Reads an object that has others in it.
fn read_parts(object: &Bound<'_, PyAny>, budget: &mut Budget) -> Result<Value, Refusal> {
    if let Ok(fields) = object.cast::<PyDict>() {
        let read = fields.iter().map(|(name, value)| {
            budget.hold(name.len()?)?;
            Ok((name.extract()?, read(&value, budget)?))
        });
        return read.collect::<Result<_, Refusal>>().map(Value::Map);
    }
    if object.is_instance_of::<PyList>() || object.is_instance_of::<PyTuple>() {
        let values = object.try_iter()?;
        return values
            .map(|value| read(&value?, budget))
            .collect::<Result<_, Refusal>>()
            .map(Value::List);
    }
    if let Ok(fields) = object.getattr("__dataclass_fields__") {
        let mut parts = Vec::new();
        for name in fields.try_iter()? {
            let name: String = name?.extract()?;
            let value = read(&object.getattr(name.as_str())?, budget)?;
            parts.push((field_of(object.py(), &name)?.to_owned(), value));
        }
        return Ok(Value::Map(parts));
    }
    // Arrays and numbers of NumPy.
    match object.call_method0("tolist") {
        Ok(list) => read(&list, budget),
        Err(_) => Err(PyTypeError::new_err(format!(
            "a {} is not a value: give a number, a text, a list, a dictionary or a value",
            object.get_type().name()?
        ))
        .into()),
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
