//! A condition as it is written: one of a few words, or an expression over variables. Refuses what can never come true before
//! anything runs: names nobody has, and expressions that are no yes or no.

use jde_board::nearest;

use super::Names;
use super::expression::Expression;

/// The words, for those who mean one of them.
const WORDS: [&str; 7] = [
    "collision",
    "absence",
    "chatter",
    "overrun",
    "fault",
    "refused",
    "operator",
];

/// A condition that can come true in the application it was checked against.
///
/// `collision`, `absence`, `chatter>N` and each of them with `:GROUP`; `overrun` and `fault`, and with `:SCHEMA`; `refused`;
/// `operator`; or an expression in CEL, the Common Expression Language, as in `pioneer.laser.ranges.exists(r, r < 0.3)`.
#[derive(Clone, Debug)]
pub struct Condition {
    /// As it was written.
    pub(super) text: String,
    pub(super) what: What,
}

#[derive(Clone, Debug)]
pub(super) enum What {
    /// Two or more are ready.
    Collision(Option<String>),
    /// Somebody is awake and nobody wins.
    Absence(Option<String>),
    /// More switches than that in a second.
    Chatter { more_than: usize, group: Option<String> },
    /// A deadline was missed, or a budget passed.
    Overrun(Option<String>),
    /// It faulted, or does not return.
    Fault(Option<String>),
    /// A command or a wake was refused.
    Refused,
    /// An operator acted.
    Operator,
    /// An expression over variables.
    Expression(Expression),
}

/// Why a condition is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{condition}`, column {column}: {reason}")]
pub struct BadCondition {
    /// As it was written.
    pub condition: String,
    /// Where, counted in letters from 1.
    pub column: usize,
    /// Why.
    pub reason: Reason,
}

/// What is wrong with a condition.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// It cannot be read.
    #[error("{0}")]
    Syntax(String),
    /// It names something that is not there.
    #[error("no {what} is called `{name}`{}", .nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
    Unknown {
        /// "variable", "group", "schema", "function".
        what: &'static str,
        /// The name.
        name: String,
        /// The nearest there is.
        nearest: Option<String>,
    },
    /// It asks for a field that a value does not have.
    #[error("{of} has no field `{field}`{}", .nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
    Field {
        /// "a nav_msgs/Odometry".
        of: String,
        /// The field.
        field: String,
        /// The nearest there is.
        nearest: Option<String>,
    },
    /// Values of these kinds do not go together.
    #[error("{0}")]
    Kinds(String),
    /// It is no yes or no.
    #[error("it is {0}, not a yes or no: compare it with something, as in `> 0.5`")]
    NotBoolean(String),
}

impl Condition {
    /// Reads a condition, and checks it against the names of an application.
    ///
    /// # Errors
    /// [`BadCondition`], with the first thing that is wrong and where.
    pub fn new(text: &str, names: &Names) -> Result<Self, BadCondition> {
        let what = read(text, names).map_err(|(column, reason)| BadCondition {
            condition: text.to_owned(),
            column,
            reason,
        })?;
        Ok(Self {
            text: text.trim().to_owned(),
            what,
        })
    }

    /// As it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// What is wrong, and in which column.
pub(super) type Wrong = (usize, Reason);

fn read(text: &str, names: &Names) -> Result<What, Wrong> {
    let (head, of) = match text.split_once(':') {
        Some((head, of)) => (head, Some(of)),
        None => (text, None),
    };
    let (word, number) = match head.split_once('>') {
        Some((word, number)) => (word, Some(number)),
        None => (head, None),
    };
    let word = word.trim();
    if !WORDS.contains(&word) || names.variables.contains_key(text.trim()) {
        return expression(text, names);
    }
    let column = |part: &str| {
        // Parts of the text they are cut from.
        let before = part.as_ptr() as usize - text.as_ptr() as usize + (part.len() - part.trim_start().len());
        text[..before].chars().count() + 1
    };
    let group = || named(of, "group", &names.groups, column);
    let schema = || named(of, "schema", &names.schemas, column);
    match (word, number) {
        ("chatter", Some(number)) => match number.trim().parse() {
            Ok(more_than) => Ok(What::Chatter {
                more_than,
                group: group()?,
            }),
            Err(_) => Err((
                column(number),
                Reason::Syntax(
                    "how many switches in a second is a whole number, as in `chatter>5`".to_owned(),
                ),
            )),
        },
        ("chatter", None) => Err((
            column(head) + word.len(),
            Reason::Syntax("say how many switches in a second are too many, as in `chatter>5`".to_owned()),
        )),
        (_, Some(number)) => Err((
            column(number) - 1,
            Reason::Syntax(format!("`{word}` takes no number")),
        )),
        ("collision", None) => Ok(What::Collision(group()?)),
        ("absence", None) => Ok(What::Absence(group()?)),
        ("overrun", None) => Ok(What::Overrun(schema()?)),
        ("fault", None) => Ok(What::Fault(schema()?)),
        (word, None) => match of {
            Some(of) => Err((
                column(of),
                Reason::Syntax(format!("`{word}` is of nobody in particular")),
            )),
            None if word == "refused" => Ok(What::Refused),
            None => Ok(What::Operator),
        },
    }
}

fn named(
    name: Option<&str>,
    what: &'static str,
    known: &[String],
    column: impl Fn(&str) -> usize,
) -> Result<Option<String>, Wrong> {
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

fn expression(text: &str, names: &Names) -> Result<What, Wrong> {
    Expression::new(text, names)
        .map(What::Expression)
        .map_err(|(column, reason)| match reason {
            // A slip in one of the words reads as the name of a variable.
            Reason::Unknown {
                what: "variable",
                name,
                nearest: None,
            } if !name.contains('.') => {
                let nearest = nearest(&name, WORDS).map(str::to_owned);
                let what = "condition or variable";
                (column, Reason::Unknown { what, name, nearest })
            }
            reason => (column, reason),
        })
}
