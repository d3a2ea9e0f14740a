//! Evaluates compiled expressions. It allocates nothing.

use super::{ExpressionNode, Fold, List, Number};
use crate::expression::BoundInput;

/// The present element and result of a fold, and those of the folds around it.
struct FoldState<'a> {
    element: Number,
    result: Option<Number>,
    outer: Option<&'a FoldState<'a>>,
}

impl ExpressionNode {
    /// Evaluates it for these values of the inputs. `None` is CEL's error, and an input without a value.
    pub(crate) fn evaluate(&self, inputs: &[BoundInput]) -> Option<Number> {
        self.within(inputs, None)
    }

    fn within(&self, inputs: &[BoundInput], fold: Option<&FoldState<'_>>) -> Option<Number> {
        match self {
            Self::Constant(number) => Some(*number),
            Self::Field {
                input,
                offset,
                scalar,
            } => Number::decode(*scalar, bytes(inputs, *input)?.get(*offset..)?),
            Self::Unary(function, one) => function(one.within(inputs, fold)?),
            Self::Binary(function, both) => {
                let [one, other] = &**both;
                function(one.within(inputs, fold)?, other.within(inputs, fold)?)
            }
            Self::And(both) => connect(both, false, |node| node.within(inputs, fold)),
            Self::Or(both) => connect(both, true, |node| node.within(inputs, fold)),
            Self::If(parts) => {
                let [condition, yes, no] = &**parts;
                match condition.within(inputs, fold)? {
                    Number::Bool(true) => yes.within(inputs, fold),
                    Number::Bool(false) => no.within(inputs, fold),
                    Number::Int(_) | Number::UInt(_) | Number::Double(_) => None,
                }
            }
            Self::NotFalse(one) => Some(Number::Bool(
                one.within(inputs, fold) != Some(Number::Bool(false)),
            )),
            Self::Size(list) => list
                .elements(inputs)
                .map(|elements| Number::Int(elements.len() as i64)),
            Self::Element(list, index) => {
                let index = match index.within(inputs, fold)? {
                    Number::Int(index) => usize::try_from(index).ok()?,
                    Number::UInt(index) => usize::try_from(index).ok()?,
                    Number::Bool(_) | Number::Double(_) => return None,
                };
                Number::decode(list.scalar, list.elements(inputs)?.nth(index)?)
            }
            Self::Extreme(list, function) => {
                let mut elements = list.numbers(inputs)?;
                let first = elements.next()?;
                elements.try_fold(first, function)
            }
            Self::Fold(fold_over) => fold_over.within(inputs, fold),
            Self::FoldElement(outwards) => fold?.outwards(*outwards).map(|fold| fold.element),
            Self::FoldResult(outwards) => fold?.outwards(*outwards)?.result,
        }
    }
}

/// `&&` or `||`: `deciding` on either side decides, even if the other side has no value.
fn connect(
    both: &[ExpressionNode; 2],
    deciding: bool,
    evaluate: impl Fn(&ExpressionNode) -> Option<Number>,
) -> Option<Number> {
    let deciding = Some(Number::Bool(deciding));
    let one = evaluate(&both[0]);
    if one == deciding {
        return one;
    }
    let other = evaluate(&both[1]);
    let are_bools = matches!((one, other), (Some(Number::Bool(_)), Some(Number::Bool(_))));
    (other == deciding || are_bools).then_some(other)?
}

fn bytes(inputs: &[BoundInput], input: usize) -> Option<&[u8]> {
    inputs.get(input)?.bytes()
}

impl List {
    fn elements<'v>(&self, inputs: &'v [BoundInput]) -> Option<std::slice::ChunksExact<'v, u8>> {
        let bytes = bytes(inputs, self.input)?;
        // A length beyond the capacity counts as the capacity.
        let count = match self.length_offset {
            Some(length) => u32::from_ne_bytes(*bytes.get(length..)?.first_chunk()?) as usize,
            None => self.capacity,
        };
        let size = self.scalar.bytes();
        let elements = bytes.get(self.offset..)?.get(..count.min(self.capacity) * size)?;
        Some(elements.chunks_exact(size))
    }

    fn numbers<'v>(&self, inputs: &'v [BoundInput]) -> Option<impl Iterator<Item = Number> + use<'v>> {
        let scalar = self.scalar;
        Some(
            self.elements(inputs)?
                .filter_map(move |bytes| Number::decode(scalar, bytes)),
        )
    }
}

impl Fold {
    fn within(&self, inputs: &[BoundInput], outer: Option<&FoldState<'_>>) -> Option<Number> {
        let mut state = FoldState {
            element: Number::Bool(false),
            result: self.initial.within(inputs, outer),
            outer,
        };
        for element in self.list.numbers(inputs)? {
            if self.goes_on.within(inputs, Some(&state)) != Some(Number::Bool(true)) {
                break;
            }
            state.element = element;
            state.result = self.step.within(inputs, Some(&state));
        }
        self.result.within(inputs, Some(&state))
    }
}

impl FoldState<'_> {
    fn outwards(&self, folds: usize) -> Option<&Self> {
        let mut state = self;
        for _ in 0..folds {
            state = state.outer?;
        }
        Some(state)
    }
}
