//! Where the numbers of a trace come from: a field of a variable, or an expression over variables in the language of
//! conditions. It keeps no history.

use std::sync::Arc;

use jde_conditions::{Expression, Names};
use jde_link::message::VariableInfo;

use super::field::{self, FieldPath};

/// Signs that names of fields do not have, and expressions do.
const OPERATORS: [char; 12] = ['+', '*', '/', '(', ')', '<', '>', '=', '!', '&', '|', ' '];

/// The source of a number over time.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    /// A number in a variable.
    Field { variable: String, place: FieldPath },
    /// An expression, with the newest values of its variables.
    Expression(Expression),
}

impl Source {
    /// Finds a number by its name, as in `pioneer.odometry.pose.pose.position.x`, or reads an expression.
    ///
    /// # Errors
    /// Why there is no such number, with the nearest existing name.
    pub(crate) fn parse(text: &str, variables: &[VariableInfo]) -> Result<Self, String> {
        let field = Self::field(text, variables);
        if field.is_ok() || !text.contains(OPERATORS) {
            return field;
        }
        let typed =
            |variable: &VariableInfo| Some((variable.name.clone(), Arc::new(variable.value_type().ok()?)));
        let names = Names {
            variables: variables.iter().filter_map(typed).collect(),
            ..Names::default()
        };
        let expression = Expression::new(text, &names).map_err(|mistake| mistake.to_string())?;
        let is_variable = |input: &&str| names.variables.contains_key(*input);
        if let Some(input) = expression.inputs().find(|input| !is_variable(input)) {
            return Err(format!("a trace reads variables, and `{input}` is none"));
        }
        Ok(Self::Expression(expression))
    }

    fn field(name: &str, variables: &[VariableInfo]) -> Result<Self, String> {
        let fits = |variable: &&VariableInfo| {
            name.strip_prefix(&variable.name)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        // The longest match, as one variable's name may be the prefix of another's.
        let variable = variables
            .iter()
            .filter(fits)
            .max_by_key(|variable| variable.name.len());
        let variable = variable.ok_or_else(|| {
            let start: Vec<_> = name.splitn(3, '.').take(2).collect();
            let names = variables.iter().map(|variable| variable.name.as_str());
            let nearest = jde_nearest::nearest(&start.join("."), names);
            let nearest = nearest.map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
            format!("there is no variable `{name}`{nearest}")
        })?;
        let value_type = variable.value_type().map_err(|error| error.to_string())?;
        let path = name[variable.name.len()..].trim_start_matches('.');
        let mut place = field::find(&value_type, path)?;
        if place.unit.is_empty() {
            place.unit.clone_from(&variable.unit);
        }
        Ok(Self::Field {
            variable: variable.name.clone(),
            place,
        })
    }

    /// The variables that it reads.
    pub(crate) fn variables(&self) -> Vec<String> {
        match self {
            Self::Field { variable, .. } => vec![variable.clone()],
            Self::Expression(expression) => expression.inputs().map(str::to_owned).collect(),
        }
    }

    /// The unit; empty for none, and for an expression.
    pub(super) fn unit(&self) -> &str {
        match self {
            Self::Field { place, .. } => &place.unit,
            Self::Expression(_) => "",
        }
    }

    /// Takes a value of a variable, or the fact that there is none. Returns the number then; NaN for none, which is a gap.
    /// `None` if it does not read the variable.
    pub(crate) fn take(&mut self, name: &str, bytes: Option<&[u8]>) -> Option<f64> {
        let value = match self {
            Self::Field { variable, place } if variable == name => bytes.and_then(|bytes| place.read(bytes)),
            Self::Field { .. } => return None,
            Self::Expression(expression) => {
                let place = expression.inputs().position(|input| input == name)?;
                expression.set(place, bytes);
                expression.value()
            }
        };
        Some(value.unwrap_or(f64::NAN))
    }
}
