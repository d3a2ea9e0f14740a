//! The attributes of a node. What no reader took is a fault: it would change what the node computes.

use std::cell::RefCell;

use crate::model::{Attribute, Node};
use crate::tensor::Tensor;

/// The attributes of a node, and which were read.
pub(crate) struct Attributes<'a> {
    node: &'a Node,
    read: RefCell<Vec<String>>,
}

impl<'a> Attributes<'a> {
    pub(crate) fn of(node: &'a Node) -> Self {
        Self {
            node,
            read: RefCell::default(),
        }
    }

    fn get(&self, name: &str, kind: i64) -> Result<Option<&'a Attribute>, String> {
        self.read.borrow_mut().push(name.to_owned());
        let mut found = self
            .node
            .attributes
            .iter()
            .filter(|attribute| attribute.name == name);
        match (found.next(), found.next()) {
            (_, Some(_)) => Err(format!("`{name}` is stated twice")),
            // Files of long ago state no kind.
            (Some(attribute), None) if attribute.kind != kind && attribute.kind != 0 => {
                Err(format!("`{name}` has another form than ONNX defines"))
            }
            (attribute, None) => Ok(attribute),
        }
    }

    pub(crate) fn float(&self, name: &str, default: f32) -> Result<f32, String> {
        match self.get(name, 1)?.map_or(default, |attribute| attribute.float) {
            number if number.is_finite() => Ok(number),
            number => Err(format!("`{name}` is {number}")),
        }
    }

    pub(crate) fn stated_float(&self, name: &str) -> Result<Option<f32>, String> {
        Ok(self.get(name, 1)?.map(|attribute| attribute.float))
    }

    pub(crate) fn integer(&self, name: &str, default: i64) -> Result<i64, String> {
        Ok(self.stated(name)?.unwrap_or(default))
    }

    pub(crate) fn stated(&self, name: &str) -> Result<Option<i64>, String> {
        Ok(self.get(name, 2)?.map(|attribute| attribute.integer))
    }

    pub(crate) fn integers(&self, name: &str) -> Result<Option<&'a [i64]>, String> {
        Ok(self.get(name, 7)?.map(|attribute| attribute.integers.as_slice()))
    }

    pub(crate) fn floats(&self, name: &str) -> Result<Option<&'a [f32]>, String> {
        Ok(self.get(name, 6)?.map(|attribute| attribute.floats.as_slice()))
    }

    pub(crate) fn text(&self, name: &str, default: &'a str) -> Result<&'a str, String> {
        let text = self
            .get(name, 3)?
            .map(|attribute| core::str::from_utf8(&attribute.text));
        text.unwrap_or(Ok(default))
            .map_err(|_| format!("`{name}` is no text"))
    }

    pub(crate) fn texts(&self, name: &str) -> Result<Option<Vec<String>>, String> {
        let texts = self.get(name, 8)?.map(|attribute| attribute.texts.iter());
        Ok(texts.map(|texts| {
            texts
                .map(|text| String::from_utf8_lossy(text).into_owned())
                .collect()
        }))
    }

    pub(crate) fn tensor(&self, name: &str) -> Result<Option<Tensor>, String> {
        let stored = self.get(name, 4)?.and_then(|attribute| attribute.tensor.as_ref());
        stored
            .map(|stored| match stored.is_external {
                true => Err(format!("`{name}` is in another file, where only weights may be")),
                false => stored.tensor(None).map_err(|error| format!("`{name}`: {error}")),
            })
            .transpose()
    }

    /// Accepts an attribute of this value only.
    pub(crate) fn only(&self, name: &str, value: i64, why: &str) -> Result<(), String> {
        match self.integer(name, value)? {
            stated if stated == value => Ok(()),
            stated => Err(format!("`{name}` is {stated}, and only {value} is run: {why}")),
        }
    }

    /// Reads attributes that change nothing.
    pub(crate) fn ignore(&self, names: &[&str]) {
        self.read
            .borrow_mut()
            .extend(names.iter().map(|name| (*name).to_owned()));
    }

    /// Refuses what was not read.
    pub(crate) fn finish(&self) -> Result<(), String> {
        let read = self.read.borrow();
        let unknown = self
            .node
            .attributes
            .iter()
            .find(|attribute| !read.contains(&attribute.name));
        match unknown {
            Some(attribute) => Err(format!(
                "its attribute `{}` is not run in this version of the operator; export the network without it",
                attribute.name
            )),
            None => Ok(()),
        }
    }
}
