//! The layouts of values: how the bytes of a value become objects of Python, and objects its bytes.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock};

use jde_abi::describe::{Field, FieldKind, Form, RosNotation, Scalar, Type};
use parking_lot::Mutex;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBytes, PyList, PyString, PyType};

use crate::numbers;
use crate::views::Views;

/// Arrays and sequences of up to this many numbers become lists; longer ones become views of the memory.
const LONGEST_LIST: usize = 64;

/// The largest field, bytes: that of a definition.
const MOST_BYTES: usize = 256 << 20;

/// The layout of a type of value.
#[pyclass(frozen, module = "jde._jde")]
pub(crate) struct Layout {
    pub(crate) ty: Arc<Type>,
    fields: Vec<Part>,
    /// The class of its values; none for a type whose only field is its value.
    class: PyOnceLock<Py<PyType>>,
}

/// The layouts of the types that this process has met, by the hashes of the types.
static KNOWN: LazyLock<Mutex<HashMap<u64, Py<Layout>>>> = LazyLock::new(Mutex::default);

struct Part {
    /// The name of its attribute.
    name: Py<PyString>,
    /// The layout of its elements, unless they are numbers.
    layout: Option<Py<Layout>>,
}

#[pymethods]
impl Layout {
    /// Lays out the fields in their order, as C does: each a name, its doc, its unit, its elements (the name of a
    /// scalar, or a layout), its form (`one`, `array`, `sequence` or `text`) and its capacity.
    #[new]
    fn new(py: Python<'_>, name: &str, doc: &str, fields: Vec<FieldTuple<'_>>) -> PyResult<Self> {
        let (mut end, mut align) = (0, 1);
        let mut described = Vec::new();
        let mut parts = Vec::new();
        for (name, doc, unit, element, form, capacity) in fields {
            let layout = element.extract::<Py<Layout>>().ok();
            let kind = match &layout {
                Some(layout) => FieldKind::Struct(Arc::clone(&layout.get().ty)),
                None => FieldKind::Scalar(scalar(element.extract()?)?),
            };
            if capacity == 0 {
                return Err(PyValueError::new_err(format!(
                    "field `{name}` has no room: its capacity is 0"
                )));
            }
            if kind.bytes().saturating_mul(capacity) > MOST_BYTES {
                return Err(PyValueError::new_err(format!(
                    "field `{name}` has more than {} MiB",
                    MOST_BYTES >> 20
                )));
            }
            // A sequence or a text is a structure that begins with its length.
            let own_align = match &*form {
                "one" | "array" => kind.align(),
                _ => kind.align().max(4),
            };
            let length_offset = round_up(end, own_align);
            let (form, offset) = match &*form {
                "one" => (Form::One, round_up(end, kind.align())),
                "array" => (Form::Array(capacity), round_up(end, kind.align())),
                "text" => (
                    Form::Text {
                        capacity,
                        length_offset,
                    },
                    length_offset + 4,
                ),
                // As `Seq` of the Rust SDK, whose elements begin eight bytes after the length.
                _ => (
                    Form::Sequence {
                        capacity,
                        length_offset,
                    },
                    length_offset + 8,
                ),
            };
            let offset = round_up(offset, kind.align());
            align = align.max(own_align);
            end = round_up(offset + kind.bytes() * capacity, own_align);
            parts.push(Part {
                name: PyString::intern(py, &name).unbind(),
                layout,
            });
            described.push(Field {
                name: field_of(py, &name)?.to_owned(),
                doc,
                unit,
                kind,
                form,
                offset,
                notation: RosNotation::default(),
            });
        }
        let ty = Type {
            name: name.to_owned(),
            doc: doc.to_owned(),
            bytes: round_up(end, align),
            align,
            fields: described,
        };
        Ok(Self {
            ty: Arc::new(ty),
            fields: parts,
            class: PyOnceLock::new(),
        })
    }

    /// The layouts of all standard types by their names.
    #[staticmethod]
    fn standard(py: Python<'_>) -> PyResult<HashMap<String, Py<Layout>>> {
        let standard = jde_types::standard().into_iter();
        standard
            .map(|ty| Ok((ty.name.clone(), Self::of(py, &Arc::new(ty))?)))
            .collect()
    }

    /// Makes the values objects of a class, whose instances have the fields as attributes. From now on, values of the
    /// type are objects of this class everywhere.
    fn bind(slf: Py<Self>, py: Python<'_>, class: Py<PyType>) {
        let layout = slf.get();
        // A class is bound once, by its own definition.
        drop(layout.class.set(py, class));
        let replaced = KNOWN.lock().insert(layout.ty.hash(), slf.clone_ref(py));
        drop(replaced);
    }

    /// The name of the type.
    #[getter]
    fn name(&self) -> &str {
        &self.ty.name
    }

    /// The number of bytes of a value.
    #[getter]
    fn size(&self) -> usize {
        self.ty.bytes
    }

    /// Returns the bytes of a value.
    #[pyo3(name = "encode")]
    fn encode_to_bytes<'py>(&self, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyBytes>> {
        PyBytes::new_with(value.py(), self.ty.bytes, |bytes| self.encode(value, bytes))
    }

    /// Returns the value of some bytes.
    #[pyo3(name = "decode")]
    fn decode_bytes(&self, py: Python<'_>, bytes: &[u8]) -> PyResult<Py<PyAny>> {
        if bytes.len() != self.ty.bytes {
            let message = format!(
                "a {} has {} bytes, not {}",
                self.ty.name,
                self.ty.bytes,
                bytes.len()
            );
            return Err(PyValueError::new_err(message));
        }
        Ok(self.decode(py, &Views::copying(py, bytes)?, 0)?.unbind())
    }
}

/// What [`Layout::new`] takes for a field.
type FieldTuple<'py> = (String, String, String, Bound<'py, PyAny>, String, usize);

impl Layout {
    /// Returns the layout of a type.
    pub(crate) fn of(py: Python<'_>, ty: &Arc<Type>) -> PyResult<Py<Self>> {
        let hash = ty.hash();
        if let Some(layout) = KNOWN.lock().get(&hash) {
            return Ok(layout.clone_ref(py));
        }
        let part = |field: &Field| {
            let layout = match &field.kind {
                FieldKind::Scalar(_) => None,
                FieldKind::Struct(inner) => Some(Self::of(py, inner)?),
            };
            let name = attribute_of(py, &field.name)?.unbind();
            Ok(Part { name, layout })
        };
        let layout = Self {
            fields: ty.fields.iter().map(part).collect::<PyResult<_>>()?,
            ty: Arc::clone(ty),
            class: PyOnceLock::new(),
        };
        let layout = Py::new(py, layout)?;
        KNOWN.lock().insert(hash, layout.clone_ref(py));
        Ok(layout)
    }

    /// Whether its only field is its value: a number or a text by itself.
    fn is_plain(&self, py: Python<'_>) -> bool {
        matches!(&self.ty.fields[..], [field] if field.name == "data") && self.class.get(py).is_none()
    }

    /// Returns the value at an offset.
    pub(crate) fn decode<'py>(
        &self,
        py: Python<'py>,
        views: &Views<'py>,
        at: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let field = |index: usize| {
            let (field, part): (&Field, &Part) = (&self.ty.fields[index], &self.fields[index]);
            decode_field(py, field, part, views, at)
        };
        if self.is_plain(py) {
            return field(0);
        }
        let class = self.class(py)?;
        let value = class.call_method1(pyo3::intern!(py, "__new__"), (class,))?;
        for index in 0..self.fields.len() {
            value.setattr(&self.fields[index].name, field(index)?)?;
        }
        Ok(value)
    }

    /// Writes a value. All bytes are written, also those of no field.
    pub(crate) fn encode(&self, value: &Bound<'_, PyAny>, bytes: &mut [u8]) -> PyResult<()> {
        bytes.fill(0);
        self.encode_into(value, bytes)
    }

    fn encode_into(&self, value: &Bound<'_, PyAny>, bytes: &mut [u8]) -> PyResult<()> {
        if self.is_plain(value.py()) {
            return encode_field(&self.ty.fields[0], &self.fields[0], value, bytes);
        }
        let class = self.class(value.py())?;
        if !value.is_instance(class)? {
            let message = format!("this takes a {}, not {}", class.name()?, kind_of(value));
            return Err(PyTypeError::new_err(message));
        }
        for (field, part) in self.ty.fields.iter().zip(&self.fields) {
            encode_field(field, part, &value.getattr(&part.name)?, bytes)?;
        }
        Ok(())
    }

    /// Returns the class of the values, which is made for a type that has none.
    fn class<'py>(&self, py: Python<'py>) -> PyResult<&Bound<'py, PyType>> {
        let class = self.class.get_or_try_init(py, || {
            let names = PyList::new(py, self.fields.iter().map(|part| &part.name))?;
            let made = py
                .import("jde._values")?
                .call_method1("make", (&self.ty.name, &self.ty.doc, names))?;
            Ok::<_, PyErr>(made.cast_into::<PyType>()?.unbind())
        })?;
        Ok(class.bind(py))
    }
}

/// Returns the attribute for a field. That of a field named by a keyword of Python, such as `lambda`, or by one and any
/// number of `_`, has one more `_` at its end.
pub(crate) fn attribute_of<'py>(py: Python<'py>, field: &str) -> PyResult<Bound<'py, PyString>> {
    let end = if is_keyword(py, field)? { "_" } else { "" };
    Ok(PyString::intern(py, &format!("{field}{end}")))
}

/// Returns the field of an attribute.
pub(crate) fn field_of<'a>(py: Python<'_>, attribute: &'a str) -> PyResult<&'a str> {
    match attribute.strip_suffix('_') {
        Some(field) if is_keyword(py, field)? => Ok(field),
        Some(_) | None => Ok(attribute),
    }
}

/// Whether a word is a keyword of Python, with any number of `_` at its end.
fn is_keyword(py: Python<'_>, word: &str) -> PyResult<bool> {
    py.import("keyword")?
        .call_method1("iskeyword", (word.trim_end_matches('_'),))?
        .extract()
}

fn decode_field<'py>(
    py: Python<'py>,
    field: &Field,
    part: &Part,
    views: &Views<'py>,
    at: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let start = at + field.offset;
    let count = match field.form {
        Form::One | Form::Array(_) => field.form.capacity(),
        Form::Sequence {
            capacity,
            length_offset,
        }
        | Form::Text {
            capacity,
            length_offset,
        } => (views.length(at + length_offset) as usize).min(capacity),
    };
    if let Form::Text { .. } = field.form {
        let text = String::from_utf8_lossy(views.bytes(start, count));
        return Ok(PyString::new(py, &text).into_any());
    }
    let size = field.kind.bytes();
    match (&field.kind, &part.layout) {
        (FieldKind::Scalar(scalar), _) if field.form == Form::One => {
            numbers::decode(py, *scalar, views.bytes(start, size))
        }
        (FieldKind::Scalar(scalar), _) if field.form.capacity() > LONGEST_LIST => {
            views.view(py, start, count * size, numbers::format(*scalar))
        }
        (FieldKind::Scalar(scalar), _) => {
            let number = |index| numbers::decode(py, *scalar, views.bytes(start + index * size, size));
            list(py, count, number)
        }
        (FieldKind::Struct(_), Some(layout)) if field.form == Form::One => {
            layout.get().decode(py, views, start)
        }
        (FieldKind::Struct(_), Some(layout)) => list(py, count, |index| {
            layout.get().decode(py, views, start + index * size)
        }),
        (FieldKind::Struct(ty), None) => Err(PyTypeError::new_err(format!("{} has no layout", ty.name))),
    }
}

fn list<'py>(
    py: Python<'py>,
    count: usize,
    item: impl Fn(usize) -> PyResult<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let items = (0..count).map(item).collect::<PyResult<Vec<_>>>()?;
    Ok(PyList::new(py, items)?.into_any())
}

fn encode_field(field: &Field, part: &Part, value: &Bound<'_, PyAny>, bytes: &mut [u8]) -> PyResult<()> {
    let of_field = |error: PyErr| in_field(value.py(), &field.name, error);
    let size = field.kind.bytes();
    match field.form {
        Form::One => encode_element(field, part, value, &mut bytes[field.offset..][..size]).map_err(of_field),
        Form::Text {
            capacity,
            length_offset,
        } => {
            let text: &str = &value.extract::<String>().map_err(of_field)?;
            if text.len() > capacity {
                return Err(too_many(field, text.len(), "bytes"));
            }
            bytes[field.offset..][..text.len()].copy_from_slice(text.as_bytes());
            bytes[length_offset..][..4].copy_from_slice(&(text.len() as u32).to_ne_bytes());
            Ok(())
        }
        Form::Array(capacity) | Form::Sequence { capacity, .. } => {
            let count = value.len().map_err(of_field)?;
            if count > capacity {
                return Err(too_many(field, count, "elements"));
            }
            if let (Form::Array(_), true) = (field.form, count < capacity) {
                let message = format!("`{}` has {capacity} elements, not {count}", field.name);
                return Err(PyValueError::new_err(message));
            }
            if let Some(length_offset) = field.form.length_offset() {
                bytes[length_offset..][..4].copy_from_slice(&(count as u32).to_ne_bytes());
            }
            let room = &mut bytes[field.offset..][..count * size];
            if let FieldKind::Scalar(scalar) = &field.kind
                && numbers::copy_buffer(*scalar, value, room)?
            {
                return Ok(());
            }
            // The iterator of a class in Python may disagree with its length.
            let mut items = value.try_iter().map_err(of_field)?;
            for given in 0..count {
                let item = items.next().ok_or_else(|| miscounted(field, count, given))?;
                let element = &mut room[given * size..][..size];
                encode_element(field, part, &item.map_err(of_field)?, element).map_err(of_field)?;
            }
            match items.next() {
                Some(_) => Err(miscounted(field, count, count + 1)),
                None => Ok(()),
            }
        }
    }
}

fn encode_element(field: &Field, part: &Part, value: &Bound<'_, PyAny>, bytes: &mut [u8]) -> PyResult<()> {
    match (&field.kind, &part.layout) {
        (FieldKind::Scalar(scalar), _) => numbers::encode(*scalar, value, bytes),
        (FieldKind::Struct(_), Some(layout)) => layout.get().encode_into(value, bytes),
        (FieldKind::Struct(ty), None) => Err(PyTypeError::new_err(format!("{} has no layout", ty.name))),
    }
}

/// Names the field in an error.
fn in_field(py: Python<'_>, name: &str, error: PyErr) -> PyErr {
    let message = format!("`{name}`: {}", error.value(py));
    if error.is_instance_of::<PyTypeError>(py) {
        PyTypeError::new_err(message)
    } else {
        PyValueError::new_err(message)
    }
}

fn miscounted(field: &Field, count: usize, given: usize) -> PyErr {
    let more = if given > count { " or more" } else { "" };
    PyValueError::new_err(format!(
        "`{}` has {count} elements by its length, and its iterator gives {given}{more}",
        field.name
    ))
}

fn too_many(field: &Field, count: usize, what: &str) -> PyErr {
    PyValueError::new_err(format!(
        "`{}` holds at most {} {what}, not {count}",
        field.name,
        field.form.capacity()
    ))
}

/// Returns the kind of an object, for messages: `a str`.
pub(crate) fn kind_of(value: &Bound<'_, PyAny>) -> String {
    let name = value.get_type().name().map(|name| name.to_string());
    format!("a {}", name.as_deref().unwrap_or("value"))
}

fn scalar(name: &str) -> PyResult<Scalar> {
    let all = [
        Scalar::Bool,
        Scalar::U8,
        Scalar::U16,
        Scalar::U32,
        Scalar::U64,
        Scalar::I8,
        Scalar::I16,
        Scalar::I32,
        Scalar::I64,
        Scalar::F32,
        Scalar::F64,
    ];
    let found = all.into_iter().find(|scalar| scalar.ros_name() == name);
    found.ok_or_else(|| PyValueError::new_err(format!("there is no scalar `{name}`")))
}

fn round_up(offset: usize, align: usize) -> usize {
    offset.div_ceil(align) * align
}
