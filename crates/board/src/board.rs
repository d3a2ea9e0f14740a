//! The board: all shared variables of an application by name. Does not know what they are for.

use std::collections::HashMap;
use std::sync::{Arc, PoisonError, RwLock};

use crate::nearest::nearest;
use crate::{Declaration, Error, Variable};

/// All shared variables of an application. Each schema is a name space of its own: `owner.name`. Any thread may call it.
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
    /// An empty board.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a variable.
    ///
    /// # Errors
    /// A name in use or empty; an initial value of the wrong size or not finite; more readers and writers than a cell can have.
    pub fn declare(&self, declaration: Declaration) -> Result<Arc<Variable>, Error> {
        self.add(declaration, false)
    }

    /// As [`Self::declare`]; other processes can map its values, unless they are copied rather than borrowed because they are small.
    ///
    /// # Errors
    /// As [`Self::declare`]; and when the system has no such memory.
    pub fn declare_shared(&self, declaration: Declaration) -> Result<Arc<Variable>, Error> {
        self.add(declaration, true)
    }

    fn add(&self, declaration: Declaration, shared: bool) -> Result<Arc<Variable>, Error> {
        let name = declaration.full_name();
        let variable = Arc::new(Variable::new(declaration, shared)?);
        let mut variables = self.variables.write().unwrap_or_else(PoisonError::into_inner);
        if variables.by_name.contains_key(&name) {
            return Err(Error::Duplicate(name));
        }
        let place = variables.declared.len();
        variables.by_name.insert(name, place);
        variables.declared.push(variable.clone());
        Ok(variable)
    }

    /// The variable of that full name, if there is one.
    #[must_use]
    pub fn find(&self, full_name: &str) -> Option<Arc<Variable>> {
        let variables = self.variables.read().unwrap_or_else(PoisonError::into_inner);
        let place = *variables.by_name.get(full_name)?;
        Some(variables.declared[place].clone())
    }

    /// The variable of that full name.
    ///
    /// # Errors
    /// [`Error::Unknown`], which names the nearest there is.
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

    /// All variables as they are now, in the order in which they were declared.
    pub fn list(&self) -> impl Iterator<Item = Arc<Variable>> + use<> {
        let variables = self.variables.read().unwrap_or_else(PoisonError::into_inner);
        variables.declared.clone().into_iter()
    }
}
