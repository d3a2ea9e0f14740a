//! Expressions over variables and signals: their text, their inputs and their value. It decides nothing about
//! when to evaluate.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, LazyLock};

use cel::{Context, Env, Program, Value, extensions};
use jde_abi::describe::Type;

use crate::check::check;
use crate::compiled::{self, ExpressionNode, Number};
use crate::condition::{BadCondition, Mistake, Reason};
use crate::kind::ValueKind;
use crate::words::replace_words;
use crate::{Names, value_view};

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

/// An expression over variables and signals, parsed and checked once and evaluated many times, with the
/// newest values of its inputs. It can read only the inputs that it names.
#[derive(Clone)]
pub struct Expression {
    text: Arc<str>,
    evaluator: Evaluator,
    inputs: Vec<BoundInput>,
}

#[derive(Clone)]
enum Evaluator {
    Compiled(Arc<ExpressionNode>),
    /// What cannot be compiled.
    Interpreted(Arc<Program>),
}

/// An input of an expression, with its value.
#[derive(Clone)]
pub(crate) struct BoundInput {
    name: String,
    /// Its name within the expression.
    alias: String,
    value_type: Arc<Type>,
    value: Vec<u8>,
    has_value: bool,
}

/// The kinds of results that a user of an expression accepts.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Expected {
    Bool,
    Number,
    BoolOrNumber,
}

impl Expression {
    /// Parses and checks an expression whose result is a bool or a number.
    ///
    /// # Errors
    /// [`BadCondition`] with the first mistake and its column.
    pub fn new(text: &str, names: &Names) -> Result<Self, BadCondition> {
        Self::parse(text, names, Expected::BoolOrNumber).map_err(|mistake| BadCondition::new(text, mistake))
    }

    /// Parses and checks an expression whose result is a bool.
    ///
    /// # Errors
    /// [`BadCondition`] with the first mistake and its column.
    pub fn condition(text: &str, names: &Names) -> Result<Self, BadCondition> {
        Self::parse(text, names, Expected::Bool).map_err(|mistake| BadCondition::new(text, mistake))
    }

    /// Parses and checks an expression whose result is a number.
    ///
    /// # Errors
    /// [`BadCondition`] with the first mistake and its column.
    pub fn number(text: &str, names: &Names) -> Result<Self, BadCondition> {
        Self::parse(text, names, Expected::Number).map_err(|mistake| BadCondition::new(text, mistake))
    }

    /// Parses and checks a condition without making an error of its mistake.
    pub(crate) fn parse_condition(text: &str, names: &Names) -> Result<Self, Mistake> {
        Self::parse(text, names, Expected::Bool)
    }

    fn parse(text: &str, names: &Names, expected: Expected) -> Result<Self, Mistake> {
        check_limits(text)?;
        let known = names.inputs();
        let (source, renamed) = rename_inputs(text, &known);
        let source = replace_words(&source);
        let program = compile(&source)?;
        let input = |written: &str| {
            let name = renamed
                .iter()
                .find(|(_, safe)| safe == written)
                .map_or(written, |(name, _)| name);
            let found = known.get_key_value(name);
            found.map(|(name, value_type)| (name.as_str(), value_type))
        };
        let (kind, used) = check(&program, &input, &known)?;
        expected.check(&kind)?;
        let inputs: Vec<_> = used
            .into_iter()
            .filter_map(|written| {
                let (name, value_type) = input(&written)?;
                Some(BoundInput {
                    name: name.to_owned(),
                    value_type: Arc::clone(value_type),
                    value: Vec::new(),
                    has_value: false,
                    alias: written,
                })
            })
            .collect();
        if inputs.is_empty() {
            return Err((
                1,
                Reason::Syntax("it names no variable, so it would never change".to_owned()),
            ));
        }
        let place = |name: &str| {
            let place = inputs.iter().position(|input| input.alias == name)?;
            Some((place, &*inputs[place].value_type))
        };
        let evaluator = match compiled::compile(program.expression(), &place) {
            Some(node) => Evaluator::Compiled(Arc::new(node)),
            None => Evaluator::Interpreted(Arc::new(program)),
        };
        Ok(Self {
            text: text.trim().into(),
            evaluator,
            inputs,
        })
    }

    /// Returns the text of the expression.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the full names of the variables and signals that it reads, each once, in an order that does not
    /// change.
    pub fn inputs(&self) -> impl Iterator<Item = &str> {
        self.inputs.iter().map(|input| input.name.as_str())
    }

    /// Sets or removes the value of an input, by its place in [`Self::inputs`]. The value has all bytes of the
    /// input's type. A place that does not exist has no effect.
    pub fn set(&mut self, input: usize, value: Option<&[u8]>) {
        let Some(input) = self.inputs.get_mut(input) else {
            return;
        };
        input.has_value = value.is_some();
        if let Some(value) = value {
            input.value.clear();
            input.value.extend_from_slice(value);
        }
    }

    /// Returns whether the expression is true for the present values. It is false if a value is missing or if
    /// the evaluation fails.
    #[must_use]
    pub fn is_true(&self) -> bool {
        self.evaluate() == Some(Number::Bool(true))
    }

    /// Returns the value of the expression for the present values; a bool is 0 or 1. `None` if a value is
    /// missing, if the evaluation fails, and instead of a NaN.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        self.evaluate()
            .map(Number::as_f64)
            .filter(|value| !value.is_nan())
    }

    fn evaluate(&self) -> Option<Number> {
        match &self.evaluator {
            Evaluator::Compiled(node) => node.evaluate(&self.inputs),
            Evaluator::Interpreted(program) => interpret(program, &self.inputs),
        }
    }
}

impl BoundInput {
    pub(crate) fn bytes(&self) -> Option<&[u8]> {
        self.has_value.then_some(self.value.as_slice())
    }
}

impl fmt::Debug for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Expression").field(&self.text).finish()
    }
}

impl Expected {
    fn check(self, kind: &ValueKind) -> Result<(), Mistake> {
        let (fits, reason): (_, fn(String) -> Reason) = match self {
            Self::Bool => (*kind == ValueKind::Bool, Reason::NotBoolean),
            Self::Number => (kind.is_number(), Reason::NotNumber),
            Self::BoolOrNumber => (*kind == ValueKind::Bool || kind.is_number(), Reason::NotNumeric),
        };
        if fits || *kind == ValueKind::Any {
            Ok(())
        } else {
            Err((1, reason(kind.to_string())))
        }
    }
}

/// Parses an expression in CEL.
fn compile(source: &str) -> Result<Program, Mistake> {
    LANGUAGE.compile(source).map_err(|errors| {
        let error = errors
            .errors
            .into_iter()
            .min_by_key(|error| (error.msg.starts_with("Incomplete"), error.pos));
        error.map_or_else(
            || (1, Reason::Syntax("it cannot be parsed".to_owned())),
            |error| {
                let reason = Reason::Syntax(shorten_message(&error.msg));
                (column(source, error.pos), reason)
            },
        )
    })
}

/// Evaluates an expression with CEL's interpreter.
fn interpret(program: &Program, inputs: &[BoundInput]) -> Option<Number> {
    let mut context = Context::with_env(Arc::clone(&LANGUAGE));
    for input in inputs {
        if let Some(bytes) = input.bytes() {
            context.add_variable_as_val(input.alias.as_str(), value_view::of(&input.value_type, bytes));
        }
    }
    match program.execute(&context).ok()? {
        Value::Bool(value) => Some(Number::Bool(value)),
        Value::Int(value) => Some(Number::Int(value)),
        Value::UInt(value) => Some(Number::UInt(value)),
        Value::Float(value) => Some(Number::Double(value)),
        _ => None,
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
fn rename_inputs(text: &str, inputs: &BTreeMap<String, Arc<Type>>) -> (String, Vec<(String, String)>) {
    let is_special = |letter: char| !(letter.is_ascii_alphanumeric() || letter == '_' || letter == '.');
    let mut known: Vec<_> = inputs
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
            .find(|safe| !inputs.contains_key(safe) && !source.contains(safe.as_str()));
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

#[cfg(test)]
mod equivalence;
