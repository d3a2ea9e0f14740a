//! The entries of lists of ports, on the bench.

#![allow(unsafe_code)]

use std::sync::Arc;

use jde_abi::describe::{Attributes, ListKind, Port, Role, Schema, Type};
use jde_abi::lists;
use jde_abi::lists::ListedPort;
use jde_types::Value;

use super::{Bench, Failure, names};
use crate::schema::Schema as Described;

/// An entry of a list, as an application file states it.
#[derive(Clone, Debug)]
pub struct Entry {
    list: String,
    label: String,
    name: String,
    value_type: Type,
    settings: Option<Vec<u8>>,
}

impl<S: Described> Bench<S> {
    /// Creates an instance with these entries in its lists of ports.
    ///
    /// # Panics
    /// If the creation fails.
    #[must_use]
    pub fn with_lists(entries: &[Entry]) -> Self {
        // SAFETY: as in `try_new`.
        match unsafe { Self::of(const { &S::TABLE }, entries) } {
            Ok(bench) => bench,
            Err(failure) => panic!("{failure}"),
        }
    }
}

impl<S> Bench<S> {
    /// Gives the instance the ports of its lists.
    pub(super) fn set_lists(&mut self, listed: &[ListedPort]) -> Result<(), Failure> {
        // SAFETY: the bench has read and validated this table.
        let lists = unsafe { lists::of(&self.table) }.unwrap_or_default();
        let Some(set) = lists.and_then(|lists| lists.set) else {
            return Ok(());
        };
        let ports = lists::tables(listed, self.own_ports);
        // SAFETY: the table's own function, instance and context, and tables that live until it returns.
        self.call(|instance, cx| unsafe { set(instance, cx, ports.as_ptr(), ports.len() as u32) })
    }
}

impl Entry {
    /// An entry of a list, whose values are `T`s. An export or a command has the name of the entry, unless [`Self::named`] states
    /// another one.
    #[must_use]
    pub fn new<T: Value>(list: &str, label: &str) -> Self {
        Self {
            list: list.to_owned(),
            label: label.to_owned(),
            name: label.to_owned(),
            value_type: T::describe(),
            settings: None,
        }
    }

    /// The name of the port.
    #[must_use]
    pub fn named(self, name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..self
        }
    }

    /// The settings of the entry, instead of those of the list.
    #[must_use]
    pub fn settings<S: Value>(self, settings: &S) -> Self {
        Self {
            settings: Some(settings.as_bytes().to_vec()),
            ..self
        }
    }

    /// Returns the port, as the host describes it and as the schema receives it.
    pub(super) fn port(&self, schema: &Schema) -> (Port, ListedPort) {
        let Some(number) = schema.lists.iter().position(|list| list.name == self.list) else {
            names::unknown("list", &self.list, schema.lists.iter().map(|list| &*list.name));
        };
        let list = &schema.lists[number];
        let value_type = Arc::new(self.value_type.clone());
        let listed = ListedPort {
            list: number,
            label: self.label.clone(),
            value_type: Arc::clone(&value_type),
            settings: self.settings.clone().unwrap_or_else(|| list.initial.clone()),
        };
        let port = Port {
            name: self.name.clone(),
            doc: String::new(),
            unit: String::new(),
            value_type: Arc::clone(&value_type),
            role: match list.kind {
                ListKind::Imports => Role::Import,
                ListKind::Exports { validity } => Role::Export { validity },
                ListKind::Commands { validity_ns } => Role::Command {
                    neutral: vec![0; value_type.bytes],
                    validity_ns,
                },
            },
            attributes: Attributes::default(),
            former_name: None,
        };
        (port, listed)
    }
}
