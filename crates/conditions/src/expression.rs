//! An expression over variables, parsed and checked once, and evaluated many times. It can read only the
//! variables that it names, and their fields.

use std::fmt;
use std::sync::{Arc, LazyLock};

use cel::{Context, Env, Program, Value, extensions};
use jde_abi::describe::Type;

use super::check::check;
use super::condition::{Mistake, Reason};
use super::kind::Kind;
use super::{Names, value_view};

/// The largest length of an expression, in bytes. A longer one would be hard to read.
const MAX_LENGTH: usize = 1000;
/// The deepest nesting of brackets: far more than an author writes, and far less than would exhaust the
/// stack.
const MAX_DEPTH: usize = 50;
/// Replacements for characters that are allowed in names of an application and not in an expression.
const REPLACEMENTS: [char; 4] = ['_', 'x', 'y', 'z'];

/// The functions of CEL and of its extension `math`.
static LANGUAGE: LazyLock<Arc<Env>> = LazyLock::new(|| {
    let mut env = Env::stdlib();
    // A new environment contains no function with which the extension's functions could collide.
    let _ = env.add_extension(extensions::math);
    Arc::new(env)
});

/// An expression with the newest values of its variables.
#[derive(Clone)]
pub(crate) struct Expression {
    program: Arc<Program>,
    variables: Vec<BoundVariable>,
}

#[derive(Clone)]
struct BoundVariable {
    name: String,
    /// Its name within the expression.
    alias: String,
    value_type: Arc<Type>,
    value: Vec<u8>,
    has_value: bool,
}

impl Expression {
    /// Parses and checks an expression.
    pub(crate) fn new(text: &str, names: &Names) -> Result<Self, Mistake> {
        check_limits(text)?;
        let (source, renamed) = rename_variables(text, names);
        let program = LANGUAGE.compile(&source).map_err(|errors| {
            let error = errors
                .errors
                .into_iter()
                .min_by_key(|error| (error.msg.starts_with("Incomplete"), error.pos));
            error.map_or_else(
                || (1, Reason::Syntax("it cannot be parsed".to_owned())),
                |error| {
                    (
                        column(&source, error.pos),
                        Reason::Syntax(shorten_message(&error.msg)),
                    )
                },
            )
        })?;
        let variable = |written: &str| {
            let name = renamed
                .iter()
                .find(|(_, safe)| safe == written)
                .map_or(written, |(name, _)| name);
            names
                .variables
                .get_key_value(name)
                .map(|(name, value_type)| (name.as_str(), value_type))
        };
        let (kind, used) = check(&program, &variable, &names.variables)?;
        match kind {
            Kind::Bool | Kind::Any => {}
            kind => return Err((1, Reason::NotBoolean(kind.to_string()))),
        }
        let variables: Vec<_> = used
            .into_iter()
            .filter_map(|written| {
                let (name, value_type) = variable(&written)?;
                Some(BoundVariable {
                    name: name.to_owned(),
                    value_type: Arc::clone(value_type),
                    value: Vec::new(),
                    has_value: false,
                    alias: written,
                })
            })
            .collect();
        if variables.is_empty() {
            return Err((
                1,
                Reason::Syntax("it names no variable, so it would never change".to_owned()),
            ));
        }
        Ok(Self {
            program: Arc::new(program),
            variables,
        })
    }

    /// Returns the full names of the variables that it reads.
    pub(crate) fn variables(&self) -> impl Iterator<Item = &str> {
        self.variables.iter().map(|variable| variable.name.as_str())
    }

    /// Sets or removes the value of a variable. Returns whether the expression reads that variable.
    pub(crate) fn set_value(&mut self, variable: &str, value: Option<&[u8]>) -> bool {
        let Some(bound) = self.variables.iter_mut().find(|bound| bound.name == variable) else {
            return false;
        };
        bound.has_value = value.is_some();
        if let Some(value) = value {
            bound.value.clear();
            bound.value.extend_from_slice(value);
        }
        true
    }

    /// Returns whether the expression is true for the present values. It is false if a value is missing or if
    /// the evaluation fails.
    pub(crate) fn is_true(&self) -> bool {
        let mut context = Context::with_env(Arc::clone(&LANGUAGE));
        for bound in self.variables.iter().filter(|bound| bound.has_value) {
            context.add_variable_as_val(
                bound.alias.as_str(),
                value_view::of(&bound.value_type, &bound.value),
            );
        }
        self.program.execute(&context) == Ok(Value::Bool(true))
    }
}

impl fmt::Debug for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.variables()).finish()
    }
}

/// Refuses expressions that would overload the parser.
fn check_limits(text: &str) -> Result<(), Mistake> {
    if text.len() > MAX_LENGTH {
        let message = format!("it has {} letters; at most {MAX_LENGTH} are possible", text.len());
        return Err((1, Reason::Syntax(message)));
    }
    let mut depth = 0_usize;
    for (index, letter) in text.chars().enumerate() {
        match letter {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > MAX_DEPTH {
            return Err((index + 1, Reason::Syntax("too many nested brackets".to_owned())));
        }
    }
    Ok(())
}

/// Replaces names that CEL cannot parse, such as `left-eye.image`, by others of the same length, so that
/// columns do not change. Returns the expression, and each name with its replacement.
fn rename_variables(text: &str, names: &Names) -> (String, Vec<(String, String)>) {
    let is_special = |letter: char| !(letter.is_ascii_alphanumeric() || letter == '_' || letter == '.');
    let mut known: Vec<_> = names
        .variables
        .keys()
        .filter(|name| name.contains(is_special) && text.contains(name.as_str()))
        .collect();
    // A name that is a prefix of another must not be replaced inside it.
    known.sort_by_key(|name| std::cmp::Reverse(name.len()));
    let mut source = text.to_owned();
    let mut renamed = Vec::new();
    for name in known {
        let with = |letter: char| name.replace(is_special, &letter.to_string());
        let free = REPLACEMENTS
            .into_iter()
            .map(with)
            .find(|safe| !names.variables.contains_key(safe) && !source.contains(safe.as_str()));
        if let Some(safe) = free {
            source = source.replace(name.as_str(), &safe);
            renamed.push((name.clone(), safe));
        }
    }
    (source, renamed)
}

/// Converts the parser's line and column to a column from the beginning, in characters.
fn column(source: &str, (line, column): (isize, isize)) -> usize {
    let lines = source
        .split_inclusive('\n')
        .take(usize::try_from(line - 1).unwrap_or(0));
    let before: usize = lines.map(|line| line.chars().count()).sum();
    before + usize::try_from(column).unwrap_or(1).max(1)
}

/// Shortens a message of the parser: it omits the list of expected tokens.
fn shorten_message(message: &str) -> String {
    let message = message.strip_prefix("Syntax error: ").unwrap_or(message);
    let message = message.split(" expecting ").next().unwrap_or(message);
    message.replace("'<EOF>'", "the end")
}
