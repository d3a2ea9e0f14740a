//! The kinds of values that operators and functions accept and return. Arithmetic needs two numbers of the
//! same kind, as in CEL. Comparison accepts numbers of all kinds.

use cel::common::ast::operators;
use jde_nearest::nearest;

use crate::condition::Reason;
use crate::kind::ValueKind;

/// The functions that are not operators, to suggest one for a misspelt name.
const FUNCTIONS: [&str; 20] = [
    "size",
    "int",
    "uint",
    "double",
    "string",
    "contains",
    "startsWith",
    "endsWith",
    "math.abs",
    "math.ceil",
    "math.floor",
    "math.greatest",
    "math.isFinite",
    "math.isInf",
    "math.isNaN",
    "math.least",
    "math.round",
    "math.sign",
    "math.sqrt",
    "math.trunc",
];

/// Returns the kind of the result of an operator or a function for values of these kinds.
///
/// # Errors
/// It does not accept these kinds, or it does not exist.
pub(super) fn kind(name: &str, kinds: &[ValueKind]) -> Result<ValueKind, Reason> {
    let mismatch = |what: &str| {
        let kinds: Vec<_> = kinds.iter().map(ValueKind::to_string).collect();
        Reason::Kinds(format!("{what}, not {}", kinds.join(" and ")))
    };
    let all =
        |fits: &dyn Fn(&ValueKind) -> bool| kinds.iter().all(|kind| *kind == ValueKind::Any || fits(kind));
    let first = kinds.first().cloned().unwrap_or(ValueKind::Any);
    match name {
        operators::LOGICAL_AND | operators::LOGICAL_OR | operators::LOGICAL_NOT => {
            let sign = name.trim_matches('_');
            all(&|kind| *kind == ValueKind::Bool)
                .then_some(ValueKind::Bool)
                .ok_or_else(|| mismatch(&format!("`{sign}` takes bools")))
        }
        operators::NOT_STRICTLY_FALSE => Ok(ValueKind::Bool),
        operators::CONDITIONAL => match kinds {
            [ValueKind::Bool | ValueKind::Any, yes, no] if yes == no => Ok(yes.clone()),
            [
                ValueKind::Bool | ValueKind::Any,
                ValueKind::List(first),
                ValueKind::List(second),
            ] => {
                let known = if **first == ValueKind::Any { second } else { first };
                Ok(ValueKind::List(known.clone()))
            }
            [ValueKind::Bool | ValueKind::Any, _, _] => Ok(ValueKind::Any),
            _ => Err(mismatch("`?` takes a bool")),
        },
        operators::LESS
        | operators::LESS_EQUALS
        | operators::GREATER
        | operators::GREATER_EQUALS
        | operators::EQUALS
        | operators::NOT_EQUALS => {
            let same_kind = all(&ValueKind::is_number) || all(&|kind| *kind == first);
            let sign = name.trim_matches('_');
            let comparable = all(&|kind| !matches!(kind, ValueKind::Struct(_)));
            (same_kind && comparable)
                .then_some(ValueKind::Bool)
                .ok_or_else(|| mismatch(&format!("`{sign}` compares numbers, or texts")))
        }
        operators::ADD if matches!(kinds, [ValueKind::List(_), ValueKind::List(_)]) => {
            let known = kinds
                .iter()
                .find(|kind| **kind != ValueKind::List(Box::new(ValueKind::Any)));
            Ok(known.cloned().unwrap_or(first))
        }
        operators::ADD if all(&|kind| *kind == ValueKind::Text) => Ok(first),
        operators::ADD
        | operators::SUBSTRACT
        | operators::MULTIPLY
        | operators::DIVIDE
        | operators::MODULO => {
            let sign = name.trim_matches('_');
            let known = kinds.iter().find(|kind| **kind != ValueKind::Any).cloned();
            let known = known.unwrap_or(ValueKind::Any);
            all(&|kind| kind.is_number() && *kind == known)
                .then(|| known.clone())
                .ok_or_else(|| {
                    mismatch(&format!(
                        "`{sign}` takes two numbers of one kind (write 2.0 for a double, 2u for a uint)"
                    ))
                })
        }
        operators::NEGATE => all(&|kind| matches!(kind, ValueKind::Int | ValueKind::Double))
            .then_some(first)
            .ok_or_else(|| mismatch("`-` takes an int or a double")),
        operators::INDEX => match kinds {
            [
                ValueKind::List(element),
                ValueKind::Int | ValueKind::UInt | ValueKind::Any,
            ] => Ok((**element).clone()),
            [ValueKind::Any, _] => Ok(ValueKind::Any),
            _ => Err(mismatch("`[]` takes a list and a whole number")),
        },
        operators::IN => match kinds {
            [_, ValueKind::List(_) | ValueKind::Any] => Ok(ValueKind::Bool),
            _ => Err(mismatch("`in` takes a value and a list")),
        },
        "size" => match kinds {
            [ValueKind::List(_) | ValueKind::Text | ValueKind::Any] => Ok(ValueKind::Int),
            _ => Err(mismatch("`size` takes a list or a text")),
        },
        "int" | "uint" | "double" => match kinds {
            [ValueKind::Int | ValueKind::UInt | ValueKind::Double | ValueKind::Text | ValueKind::Any] => {
                Ok(match name {
                    "int" => ValueKind::Int,
                    "uint" => ValueKind::UInt,
                    _ => ValueKind::Double,
                })
            }
            _ => Err(mismatch(&format!("`{name}` takes a number"))),
        },
        "string" => Ok(ValueKind::Text),
        "contains" | "startsWith" | "endsWith" => (kinds.len() == 2 && all(&|kind| *kind == ValueKind::Text))
            .then_some(ValueKind::Bool)
            .ok_or_else(|| mismatch(&format!("`{name}` takes two texts"))),
        "math.abs" | "math.sign" => (kinds.len() == 1 && all(&ValueKind::is_number))
            .then_some(first)
            .ok_or_else(|| mismatch(&format!("`{name}` takes a number"))),
        "math.sqrt" => (kinds.len() == 1 && all(&ValueKind::is_number))
            .then_some(ValueKind::Double)
            .ok_or_else(|| mismatch("`math.sqrt` takes a number")),
        "math.ceil" | "math.floor" | "math.round" | "math.trunc" => (kinds.len() == 1
            && all(&|kind| *kind == ValueKind::Double))
        .then_some(ValueKind::Double)
        .ok_or_else(|| mismatch(&format!("`{name}` takes a double"))),
        "math.isNaN" | "math.isInf" | "math.isFinite" => (kinds.len() == 1
            && all(&|kind| *kind == ValueKind::Double))
        .then_some(ValueKind::Bool)
        .ok_or_else(|| mismatch(&format!("`{name}` takes a double"))),
        "math.@max" | "math.@min" => match kinds {
            [ValueKind::List(element)] if element.is_number() || **element == ValueKind::Any => {
                Ok((**element).clone())
            }
            [_] | [] => all(&ValueKind::is_number)
                .then_some(first)
                .ok_or_else(|| mismatch("`math.greatest` and `math.least` take numbers, or a list of them")),
            _ if all(&|kind| kind.is_number() && *kind == first) => Ok(first),
            _ if all(&ValueKind::is_number) => Ok(ValueKind::Double),
            _ => Err(mismatch(
                "`math.greatest` and `math.least` take numbers, or a list of them",
            )),
        },
        name => Err(Reason::Unknown {
            what: "function",
            name: name.to_owned(),
            nearest: suggest_function(name).map(str::to_owned),
        }),
    }
}

/// Returns the function that the author probably intended.
fn suggest_function(name: &str) -> Option<&'static str> {
    let of_math = FUNCTIONS
        .into_iter()
        .find(|known| known.strip_prefix("math.") == Some(name));
    of_math.or_else(|| nearest(name, FUNCTIONS))
}
