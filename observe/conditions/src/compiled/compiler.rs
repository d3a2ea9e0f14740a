//! Compiles the syntax tree of CEL. It refuses what is not over numbers and bools.

use cel::common::ast::{CallExpr, ComprehensionExpr, Expr, IdedExpr, LiteralValue, SelectExpr, operators};
use jde_abi::describe::{Field, FieldKind, Form, Type};

use super::number::{self, Number};
use super::{ExpressionNode, FindInput, Fold, List};

/// A part of an input.
enum Part<'a> {
    Struct {
        input: usize,
        offset: usize,
        value_type: &'a Type,
    },
    Scalar(ExpressionNode),
    List(List),
}

/// Compiles an expression that was checked; `None` if that is not possible.
pub(crate) fn compile<'a>(expression: &IdedExpr, input: &'a FindInput<'a>) -> Option<ExpressionNode> {
    Compiler {
        input,
        folds: Vec::new(),
    }
    .node(expression)
}

struct Compiler<'a> {
    input: &'a FindInput<'a>,
    /// The names of the element and the result of each fold around the present part, outermost first.
    folds: Vec<(String, String)>,
}

impl<'a> Compiler<'a> {
    fn node(&mut self, expression: &IdedExpr) -> Option<ExpressionNode> {
        match &expression.expr {
            Expr::Literal(literal) => Some(ExpressionNode::Constant(match literal {
                LiteralValue::Boolean(value) => Number::Bool(*value.inner()),
                LiteralValue::Int(value) => Number::Int(*value.inner()),
                LiteralValue::UInt(value) => Number::UInt(*value.inner()),
                LiteralValue::Double(value) => Number::Double(*value.inner()),
                LiteralValue::String(_) | LiteralValue::Bytes(_) | LiteralValue::Null => return None,
            })),
            Expr::Ident(_) | Expr::Select(_) => match self.part(expression)? {
                Part::Scalar(node) => Some(node),
                Part::Struct { .. } | Part::List(_) => None,
            },
            Expr::Call(call) => self.call(call),
            Expr::Comprehension(comprehension) => self.fold(comprehension),
            Expr::List(_) | Expr::Map(_) | Expr::Struct(_) | Expr::Unspecified => None,
        }
    }

    fn boxed(&mut self, expression: &IdedExpr) -> Option<Box<ExpressionNode>> {
        self.node(expression).map(Box::new)
    }

    fn call(&mut self, call: &CallExpr) -> Option<ExpressionNode> {
        let (namespace, receiver) = match call.target.as_deref() {
            Some(target) if matches!(&target.expr, Expr::Ident(name) if name == "math") => ("math.", None),
            target => ("", target),
        };
        let name = format!("{namespace}{}", call.func_name);
        let arguments: Vec<_> = receiver.into_iter().chain(&call.args).collect();
        match *arguments {
            [one] if name == operators::NOT_STRICTLY_FALSE => self.boxed(one).map(ExpressionNode::NotFalse),
            [one] if name == "size" => self.list(one).map(ExpressionNode::Size),
            [one] => match (number::unary(&name), number::binary(&name)) {
                (Some(function), _) => Some(ExpressionNode::Unary(function, self.boxed(one)?)),
                // The greatest or least of a list; of one number, it is that number.
                (None, Some(function)) => Some(ExpressionNode::Extreme(self.list(one)?, function)),
                (None, None) => None,
            },
            [list, index] if name == operators::INDEX => {
                Some(ExpressionNode::Element(self.list(list)?, self.boxed(index)?))
            }
            [one, other] => {
                let both = Box::new([self.node(one)?, self.node(other)?]);
                match name.as_str() {
                    operators::LOGICAL_AND => Some(ExpressionNode::And(both)),
                    operators::LOGICAL_OR => Some(ExpressionNode::Or(both)),
                    name => Some(ExpressionNode::Binary(number::binary(name)?, both)),
                }
            }
            [condition, yes, no] if name == operators::CONDITIONAL => Some(ExpressionNode::If(Box::new([
                self.node(condition)?,
                self.node(yes)?,
                self.node(no)?,
            ]))),
            _ => None,
        }
    }

    fn fold(&mut self, comprehension: &ComprehensionExpr) -> Option<ExpressionNode> {
        let list = self.list(&comprehension.iter_range)?;
        if comprehension.iter_var2.is_some() {
            return None;
        }
        let initial = self.node(&comprehension.accu_init)?;
        let names = (comprehension.iter_var.clone(), comprehension.accu_var.clone());
        self.folds.push(names);
        let inner = [
            &comprehension.loop_cond,
            &comprehension.loop_step,
            &comprehension.result,
        ]
        .map(|part| self.node(part));
        self.folds.pop();
        let [goes_on, step, result] = inner;
        Some(ExpressionNode::Fold(Box::new(Fold {
            list,
            initial,
            goes_on: goes_on?,
            step: step?,
            result: result?,
        })))
    }

    fn list(&mut self, expression: &IdedExpr) -> Option<List> {
        match self.part(expression)? {
            Part::List(list) => Some(list),
            Part::Struct { .. } | Part::Scalar(_) => None,
        }
    }

    fn part(&self, expression: &IdedExpr) -> Option<Part<'a>> {
        match &expression.expr {
            Expr::Ident(name) => self.bound(name).map(Part::Scalar).or_else(|| self.whole(name)),
            Expr::Select(SelectExpr {
                operand,
                field,
                test: false,
            }) => {
                if let Expr::Ident(owner) = &operand.expr {
                    let is_bound = self.bound(owner).is_some();
                    return (!is_bound).then(|| self.whole(&format!("{owner}.{field}")))?;
                }
                let Part::Struct {
                    input,
                    offset,
                    value_type,
                } = self.part(operand)?
                else {
                    return None;
                };
                let found = value_type.fields.iter().find(|known| known.name == *field)?;
                field_part(input, offset, found)
            }
            _ => None,
        }
    }

    /// Returns the whole value of an input.
    fn whole(&self, name: &str) -> Option<Part<'a>> {
        let (input, value_type) = (self.input)(name)?;
        match value_type.as_number() {
            Some(_) => field_part(input, 0, value_type.fields.first()?),
            None => Some(Part::Struct {
                input,
                offset: 0,
                value_type,
            }),
        }
    }

    /// Returns the element or the result of a fold, by its name.
    fn bound(&self, name: &str) -> Option<ExpressionNode> {
        self.folds
            .iter()
            .rev()
            .enumerate()
            .find_map(|(outwards, (element, result))| {
                if element == name {
                    Some(ExpressionNode::FoldElement(outwards))
                } else {
                    (result == name).then_some(ExpressionNode::FoldResult(outwards))
                }
            })
    }
}

fn field_part<'a>(input: usize, offset: usize, field: &'a Field) -> Option<Part<'a>> {
    let start = offset;
    let offset = offset + field.offset;
    match (&field.kind, field.form) {
        (FieldKind::Struct(value_type), Form::One) => Some(Part::Struct {
            input,
            offset,
            value_type,
        }),
        (FieldKind::Scalar(scalar), Form::One) => {
            let scalar = *scalar;
            Some(Part::Scalar(ExpressionNode::Field {
                input,
                offset,
                scalar,
            }))
        }
        (FieldKind::Scalar(scalar), Form::Array(_) | Form::Sequence { .. }) => Some(Part::List(List {
            input,
            offset,
            length_offset: field.form.length_offset().map(|length| start + length),
            capacity: field.form.capacity(),
            scalar: *scalar,
        })),
        (FieldKind::Struct(_), Form::Array(_) | Form::Sequence { .. }) | (_, Form::Text { .. }) => None,
    }
}
