//! Checks an expression before its first evaluation: all names must exist, and the kinds of values must fit.
//! Mistakes that depend on values, such as an index past the end of a list, cannot be detected here.

mod calls;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use cel::Program;
use cel::common::ast::{ComprehensionExpr, Expr, IdedExpr, LiteralValue, SelectExpr};
use jde_abi::describe::Type;
use jde_nearest::nearest;

use crate::condition::{Mistake, Reason};
use crate::kind::ValueKind;

/// Finds a variable or signal by its name in an expression. Returns its full name and its type.
pub(super) type FindInput<'a, 'n> = dyn Fn(&str) -> Option<(&'n str, &'n Arc<Type>)> + 'a;

/// Returns the kind of an expression's value, and the names of its variables and signals as the expression
/// writes them.
///
/// # Errors
/// The first mistake.
pub(super) fn check<'n>(
    program: &Program,
    input: &FindInput<'_, 'n>,
    known: &BTreeMap<String, Arc<Type>>,
) -> Result<(ValueKind, BTreeSet<String>), Mistake> {
    let mut checker = Checker {
        program,
        input,
        known,
        bound: Vec::new(),
        used: BTreeSet::new(),
    };
    let kind = checker.kind(program.expression())?;
    Ok((kind, checker.used))
}

struct Checker<'a, 'n> {
    program: &'a Program,
    input: &'a FindInput<'a, 'n>,
    known: &'a BTreeMap<String, Arc<Type>>,
    /// The names of a list's elements within `exists` and similar macros, innermost last.
    bound: Vec<(String, ValueKind)>,
    used: BTreeSet<String>,
}

impl Checker<'_, '_> {
    fn kind(&mut self, expression: &IdedExpr) -> Result<ValueKind, Mistake> {
        match &expression.expr {
            Expr::Literal(literal) => Ok(match literal {
                LiteralValue::Boolean(_) => ValueKind::Bool,
                LiteralValue::Double(_) => ValueKind::Double,
                LiteralValue::Int(_) => ValueKind::Int,
                LiteralValue::UInt(_) => ValueKind::UInt,
                LiteralValue::String(_) => ValueKind::Text,
                LiteralValue::Bytes(_) | LiteralValue::Null => ValueKind::Any,
            }),
            Expr::Ident(name) => match self.bound(name) {
                Some(kind) => Ok(kind),
                None => self.input(expression.id, name.clone()),
            },
            Expr::Select(select) => self.select(expression.id, select),
            Expr::Call(call) => {
                let namespace = call.target.as_ref().and_then(|target| match &target.expr {
                    Expr::Ident(name) if name == "math" => Some("math."),
                    _ => None,
                });
                let name = format!("{}{}", namespace.unwrap_or_default(), call.func_name);
                let target = call.target.iter().filter(|_| namespace.is_none());
                let arguments = target.map(|target| &**target).chain(&call.args);
                let kinds = arguments
                    .map(|argument| self.kind(argument))
                    .collect::<Result<Vec<_>, _>>()?;
                calls::kind(&name, &kinds).map_err(|reason| self.mistake(expression.id, reason))
            }
            Expr::Comprehension(comprehension) => self.comprehension(comprehension),
            Expr::List(list) => {
                let mut element = None;
                for each in &list.elements {
                    let kind = self.kind(each)?;
                    element = match element {
                        None => Some(kind),
                        Some(other) if other == kind => Some(other),
                        Some(_) => Some(ValueKind::Any),
                    };
                }
                Ok(ValueKind::List(Box::new(element.unwrap_or(ValueKind::Any))))
            }
            Expr::Map(_) | Expr::Struct(_) | Expr::Unspecified => Err(self.mistake(
                expression.id,
                Reason::Syntax("a condition cannot contain maps and structures".to_owned()),
            )),
        }
    }

    /// Checks the name of a variable or signal.
    fn input(&mut self, id: u64, name: String) -> Result<ValueKind, Mistake> {
        let Some((_, value_type)) = (self.input)(&name) else {
            return Err(self.unknown(id, "variable", &name));
        };
        let kind = ValueKind::of(value_type);
        self.used.insert(name);
        Ok(kind)
    }

    fn bound(&self, name: &str) -> Option<ValueKind> {
        let found = self.bound.iter().rev().find(|(bound, _)| bound == name);
        found.map(|(_, kind)| kind.clone())
    }

    /// Checks a variable, `owner.name`, or a field of the operand.
    fn select(&mut self, id: u64, select: &SelectExpr) -> Result<ValueKind, Mistake> {
        if let Expr::Ident(owner) = &select.operand.expr
            && self.bound(owner).is_none()
        {
            return self.input(select.operand.id, format!("{owner}.{}", select.field));
        }
        let of = self.kind(&select.operand)?;
        let ValueKind::Struct(value_type) = &of else {
            return match of {
                ValueKind::Any => Ok(ValueKind::Any),
                ValueKind::List(_) => Err(self.mistake(
                    id,
                    Reason::Kinds(format!(
                        "a list has no field `{}`; choose an element, as in `[0]`, or test all of them with `exists`",
                        select.field
                    )),
                )),
                other => Err(self.mistake(
                    id,
                    Reason::Kinds(format!("{other} has no fields, so no `{}`", select.field)),
                )),
            };
        };
        let field = value_type.fields.iter().find(|field| field.name == select.field);
        match field {
            Some(_) if select.test => Ok(ValueKind::Bool),
            Some(field) => Ok(ValueKind::field(field)),
            None => {
                let names = value_type.fields.iter().map(|field| field.name.as_str());
                Err(self.mistake(
                    id,
                    Reason::Field {
                        of: of.to_string(),
                        field: select.field.clone(),
                        nearest: nearest(&select.field, names).map(str::to_owned),
                    },
                ))
            }
        }
    }

    /// Checks `exists`, `all`, `map` and similar macros.
    fn comprehension(&mut self, comprehension: &ComprehensionExpr) -> Result<ValueKind, Mistake> {
        let range = self.kind(&comprehension.iter_range)?;
        let element = match range {
            ValueKind::List(element) => *element,
            ValueKind::Any => ValueKind::Any,
            other => {
                return Err(self.mistake(
                    comprehension.iter_range.id,
                    Reason::Kinds(format!("{other} is not a list")),
                ));
            }
        };
        let result = self.kind(&comprehension.accu_init)?;
        let outer = self.bound.len();
        self.bound.push((comprehension.iter_var.clone(), element));
        self.bound.push((comprehension.accu_var.clone(), result));
        let kind = self.inside(comprehension);
        self.bound.truncate(outer);
        kind
    }

    fn inside(&mut self, comprehension: &ComprehensionExpr) -> Result<ValueKind, Mistake> {
        self.kind(&comprehension.loop_cond)?;
        let result = self.kind(&comprehension.loop_step)?;
        self.bound.push((comprehension.accu_var.clone(), result));
        self.kind(&comprehension.result)
    }

    fn unknown(&self, id: u64, what: &'static str, name: &str) -> Mistake {
        let nearest = nearest(name, self.known.keys().map(String::as_str));
        let reason = Reason::Unknown {
            what,
            name: name.to_owned(),
            nearest: nearest.map(str::to_owned),
        };
        self.mistake(id, reason)
    }

    fn mistake(&self, id: u64, reason: Reason) -> Mistake {
        let offset = self.program.source_info().offset_for(id);
        (offset.map_or(1, |(start, _)| start as usize + 1), reason)
    }
}
