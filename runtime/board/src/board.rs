//! The board: all shared variables of an application by name. It does not interpret them.

use std::collections::HashMap;
use std::sync::Arc;

use jde_nearest::nearest;
use parking_lot::RwLock;

use crate::{Declaration, Error, Variable};

/// All shared variables of an application. Each schema has its own name space: `owner.name`. Any thread may
/// call it.
#[derive(Default)]
pub struct Board {
    variables: RwLock<Variables>,
}

#[derive(Default)]
struct Variables {
    declared: Vec<Arc<Variable>>,
    by_name: HashMap<String, usize>,
}

impl Board {
    /// Returns an empty board.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a variable.
    ///
    /// # Errors
    /// The name is in use or empty, the initial value has the wrong size, is not finite or is outside of the
    /// limits, or there are more readers and writers than a cell can have.
    pub fn declare(&self, declaration: Declaration) -> Result<Arc<Variable>, Error> {
        self.add(declaration, false)
    }

    /// Adds a variable as [`Self::declare`] does. Other processes can map its values, unless they are small:
    /// small values are copied and cannot be mapped.
    ///
    /// # Errors
    /// As [`Self::declare`], and if the system has no memory that can be mapped.
    pub fn declare_shared(&self, declaration: Declaration) -> Result<Arc<Variable>, Error> {
        self.add(declaration, true)
    }

    fn add(&self, declaration: Declaration, shared: bool) -> Result<Arc<Variable>, Error> {
        let name = declaration.full_name();
        let variable = Arc::new(Variable::new(declaration, shared)?);
        let mut variables = self.variables.write();
        if variables.by_name.contains_key(&name) {
            return Err(Error::Duplicate(name));
        }
        let index = variables.declared.len();
        variables.by_name.insert(name, index);
        variables.declared.push(variable.clone());
        Ok(variable)
    }

    /// Returns the variable with this full name, if there is one.
    #[must_use]
    pub fn find(&self, full_name: &str) -> Option<Arc<Variable>> {
        let variables = self.variables.read();
        let index = *variables.by_name.get(full_name)?;
        Some(variables.declared[index].clone())
    }

    /// Returns the variable with this full name.
    ///
    /// # Errors
    /// [`Error::Unknown`], with the nearest existing name.
    pub fn get(&self, full_name: &str) -> Result<Arc<Variable>, Error> {
        self.find(full_name).ok_or_else(|| {
            let names: Vec<String> = self
                .list()
                .map(|variable| variable.describe().full_name())
                .collect();
            Error::Unknown {
                name: full_name.to_owned(),
                nearest: nearest(full_name, names.iter().map(String::as_str)).map(str::to_owned),
            }
        })
    }

    /// Returns all variables that exist now, in the order of their declarations.
    pub fn list(&self) -> impl Iterator<Item = Arc<Variable>> + use<> {
        let variables = self.variables.read();
        variables.declared.clone().into_iter()
    }
}
