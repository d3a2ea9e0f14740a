//! A condition as text: a keyword, or an expression over variables. It is refused before anything runs if it
//! can never become true: if it uses an unknown name, or if an expression has no boolean result.

use jde_nearest::nearest;

use super::Names;
use super::expression::Expression;

/// The keywords, to suggest one for a misspelt word.
const KEYWORDS: [&str; 7] = [
    "conflict", "absence", "chatter", "overrun", "fault", "refused", "operator",
];

/// A condition that can become true in the application against which it was checked.
///
/// It is `conflict`, `absence` or `chatter>N`, each optionally with `:GROUP`; `overrun` or `fault`,
/// optionally with `:SCHEMA`; `refused`; `operator`; or an expression in CEL, the Common Expression Language,
/// such as `pioneer.laser.ranges.exists(r, r < 0.3)`.
#[derive(Clone, Debug)]
pub struct Condition {
    /// The text of the condition.
    pub(crate) text: String,
    pub(crate) kind: ConditionKind,
}

#[derive(Clone, Debug)]
pub(crate) enum ConditionKind {
    /// Two or more candidates are READY.
    Conflict(Option<String>),
    /// A schema of the group is awake, and none is WINNER.
    Absence(Option<String>),
    /// More switches than this number occur within a second.
    Chatter { more_than: usize, group: Option<String> },
    /// A schema misses a deadline or exceeds its budget.
    Overrun(Option<String>),
    /// A schema is Faulted or does not return.
    Fault(Option<String>),
    /// A command or a wake is refused.
    Refused,
    /// An operator acts.
    Operator,
    /// An expression over variables and signals.
    Expression(Expression),
}

/// Why a condition is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{condition}`, column {column}: {reason}")]
pub struct BadCondition {
    /// The text of the condition.
    pub condition: String,
    /// The column of the mistake, counted in characters from 1.
    pub column: usize,
    /// The mistake.
    pub reason: Reason,
}

/// A mistake in a condition.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// The text cannot be parsed.
    #[error("{0}")]
    Syntax(String),
    /// A name does not exist.
    #[error("no {what} is called `{name}`{}", .nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
    Unknown {
        /// "variable", "group", "schema", "function".
        what: &'static str,
        /// The name.
        name: String,
        /// The most similar name, if one is similar.
        nearest: Option<String>,
    },
    /// A value does not have this field.
    #[error("{of} has no field `{field}`{}", .nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
    Field {
        /// The value's type with its article: "a nav_msgs/Odometry".
        of: String,
        /// The field.
        field: String,
        /// The most similar field, if one is similar.
        nearest: Option<String>,
    },
    /// An operation does not accept values of these kinds.
    #[error("{0}")]
    Kinds(String),
    /// The result is not a number.
    #[error("the result is {0}, not a number")]
    NotNumber(String),
    /// The result is not a boolean and not a number.
    #[error("the result is {0}, not a bool or a number")]
    NotNumeric(String),
    /// The result is not a boolean.
    #[error("the result is {0}, not a bool: compare it with something, as in `> 0.5`")]
    NotBoolean(String),
}

impl BadCondition {
    pub(crate) fn new(text: &str, (column, reason): Mistake) -> Self {
        Self {
            condition: text.to_owned(),
            column,
            reason,
        }
    }
}

impl Condition {
    /// Parses a condition, and checks it against the names of an application.
    ///
    /// # Errors
    /// [`BadCondition`] with the first mistake and its column.
    pub fn new(text: &str, names: &Names) -> Result<Self, BadCondition> {
        let kind = read(text, names).map_err(|mistake| BadCondition::new(text, mistake))?;
        Ok(Self {
            text: text.trim().to_owned(),
            kind,
        })
    }

    /// Returns the text of the condition.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// A mistake and its column.
pub(crate) type Mistake = (usize, Reason);

fn read(text: &str, names: &Names) -> Result<ConditionKind, Mistake> {
    let (head, of) = match text.split_once(':') {
        Some((head, of)) => (head, Some(of)),
        None => (text, None),
    };
    let (word, number) = match head.split_once('>') {
        Some((word, number)) => (word, Some(number)),
        None => (head, None),
    };
    let word = word.trim();
    // `refused` is a condition, and in `refused > 3` a signal.
    let is_compared = number.is_some() && word == "refused";
    if !KEYWORDS.contains(&word) || is_compared || names.variables.contains_key(text.trim()) {
        return parse_expression(text, names);
    }
    let column = |part: &str| {
        // Both are slices of the same text.
        let before = part.as_ptr() as usize - text.as_ptr() as usize + (part.len() - part.trim_start().len());
        text[..before].chars().count() + 1
    };
    let group = || resolve_name(of, "group", &names.groups, column);
    let schema = || resolve_name(of, "schema", &names.schemas, column);
    match (word, number) {
        ("chatter", Some(number)) => match number.trim().parse() {
            Ok(more_than) => Ok(ConditionKind::Chatter {
                more_than,
                group: group()?,
            }),
            Err(_) => Err((
                column(number),
                Reason::Syntax(
                    "the number of switches in a second must be a whole number, as in `chatter>5`".to_owned(),
                ),
            )),
        },
        ("chatter", None) => Err((
            column(head) + word.len(),
            Reason::Syntax("write how many switches in a second are allowed, as in `chatter>5`".to_owned()),
        )),
        (_, Some(number)) => Err((
            column(number) - 1,
            Reason::Syntax(format!("`{word}` takes no number")),
        )),
        ("conflict", None) => Ok(ConditionKind::Conflict(group()?)),
        ("absence", None) => Ok(ConditionKind::Absence(group()?)),
        ("overrun", None) => Ok(ConditionKind::Overrun(schema()?)),
        ("fault", None) => Ok(ConditionKind::Fault(schema()?)),
        (word, None) => match of {
            Some(of) => Err((column(of), Reason::Syntax(format!("`{word}` takes no name")))),
            None if word == "refused" => Ok(ConditionKind::Refused),
            None => Ok(ConditionKind::Operator),
        },
    }
}

fn resolve_name(
    name: Option<&str>,
    what: &'static str,
    known: &[String],
    column: impl Fn(&str) -> usize,
) -> Result<Option<String>, Mistake> {
    let Some(given) = name else {
        return Ok(None);
    };
    let name = given.trim();
    if known.iter().any(|known| known == name) {
        return Ok(Some(name.to_owned()));
    }
    Err((
        column(given),
        Reason::Unknown {
            what,
            name: name.to_owned(),
            nearest: nearest(name, known.iter().map(String::as_str)).map(str::to_owned),
        },
    ))
}

fn parse_expression(text: &str, names: &Names) -> Result<ConditionKind, Mistake> {
    Expression::parse_condition(text, names)
        .map(ConditionKind::Expression)
        .map_err(|(column, reason)| match reason {
            // A misspelt keyword is parsed as the name of a variable.
            Reason::Unknown {
                what: "variable",
                name,
                nearest: None,
            } if !name.contains('.') => {
                let nearest = nearest(&name, KEYWORDS).map(str::to_owned);
                let what = "condition or variable";
                (column, Reason::Unknown { what, name, nearest })
            }
            reason => (column, reason),
        })
}
