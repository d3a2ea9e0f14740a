//! The descriptions of schemas: what a class states in its attribute `__jde__`, as the plugin's tables.

use std::sync::Arc;

use jde_abi::describe::{Attribute, Attributes, Child, Kind, Limits, Plugin, Port, Role, Schema, Validity};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::layout::Layout;

/// What a class states of itself (`jde._schema.SchemaSpec`).
#[derive(FromPyObject)]
struct SchemaSpec {
    name: String,
    doc: String,
    kind: String,
    period_ns: u64,
    budget_ns: Option<u64>,
    ports: Vec<PortSpec>,
    children: Vec<ChildSpec>,
    /// The names of the functions that it has.
    functions: Vec<String>,
}

/// A port (`jde._schema.PortSpec`).
#[derive(FromPyObject)]
struct PortSpec {
    role: String,
    name: String,
    doc: String,
    unit: String,
    layout: Py<Layout>,
    initial: Option<Py<PyAny>>,
    least: Option<f64>,
    greatest: Option<f64>,
    choices: Vec<String>,
    validity_ns: u64,
    /// The names of its options that are set. Those that the ABI lists are its attributes.
    attributes: Vec<String>,
    former_name: String,
    child: usize,
}

/// A role for a child (`jde._schema.ChildSpec`).
#[derive(FromPyObject)]
struct ChildSpec {
    name: String,
    doc: String,
    motor: bool,
    group: String,
    optional: bool,
    many: bool,
}

/// Returns the description of a plugin of these classes.
pub(crate) fn plugin(
    py: Python<'_>,
    (name, version, doc): (String, String, String),
    classes: &[Py<PyType>],
) -> PyResult<Plugin> {
    let schemas = classes
        .iter()
        .map(|class| schema(py, class.bind(py).getattr("__jde__")?.extract()?));
    Ok(Plugin {
        name,
        version,
        doc,
        abi: (jde_abi::raw::ABI_MAJOR, jde_abi::raw::ABI_MINOR),
        throws: false,
        isolated: true,
        schemas: schemas.collect::<PyResult<_>>()?,
    })
}

fn schema(py: Python<'_>, spec: SchemaSpec) -> PyResult<Schema> {
    let has = |function: &str| spec.functions.iter().any(|name| name == function);
    let child = |child: ChildSpec| Child {
        name: child.name,
        doc: child.doc,
        motor: child.motor,
        group: child.group,
        optional: child.optional,
        many: child.many,
    };
    Ok(Schema {
        kind: match &*spec.kind {
            "perceptive" => Kind::Perceptive,
            "motor" => Kind::Motor,
            _ => Kind::Driver,
        },
        period_ns: spec.period_ns,
        budget_ns: spec.budget_ns,
        arbitrates: has("arbitrate"),
        panel: has("draw"),
        touch: has("touched"),
        memory: has("save"),
        inspects: has("inspect"),
        guard: None,
        lists: Vec::new(),
        ports: spec
            .ports
            .into_iter()
            .map(|port| self::port(py, port))
            .collect::<PyResult<_>>()?,
        children: spec.children.into_iter().map(child).collect(),
        name: spec.name,
        doc: spec.doc,
    })
}

fn port(py: Python<'_>, spec: PortSpec) -> PyResult<Port> {
    let layout = spec.layout.get();
    let initial = || -> PyResult<Vec<u8>> {
        let mut bytes = vec![0; layout.ty.bytes];
        if let Some(initial) = &spec.initial {
            let of_port =
                |error: PyErr| PyValueError::new_err(format!("port `{}`: {}", spec.name, error.value(py)));
            layout.encode(initial.bind(py), &mut bytes).map_err(of_port)?;
        }
        Ok(bytes)
    };
    let role = match &*spec.role {
        "import" => Role::Import,
        "modulation" => Role::Modulation {
            default: initial()?,
            limits: Limits {
                least: spec.least,
                greatest: spec.greatest,
                choices: spec.choices.clone(),
            },
        },
        "command" => Role::Command {
            neutral: initial()?,
            validity_ns: spec.validity_ns,
        },
        "actuator" => Role::Actuator,
        "modulates" => Role::ChildModulation { child: spec.child },
        _ => Role::Export {
            validity: Validity::from_ns(spec.validity_ns),
        },
    };
    let flags = spec
        .attributes
        .iter()
        .fold(0, |flags, name| flags | Attribute::flag(name));
    Ok(Port {
        attributes: Attributes::of(role.kind(), flags),
        name: spec.name,
        doc: spec.doc,
        unit: spec.unit,
        value_type: Arc::clone(&layout.ty),
        role,
        former_name: (!spec.former_name.is_empty()).then_some(spec.former_name),
    })
}
