//! Products of matrices. Each sum has a fixed order, whatever the processor, and rows are added as a whole so that a
//! processor adds several numbers at once.

use super::elementwise::broadcast;
use super::{Arity, Operator};
use crate::attributes::Attributes;
use crate::tensor::Tensor;

/// Partial sums of a product of rows, which a processor forms at once. Another number would be another order.
const DOT_LANES: usize = 8;

/// Compiles an operator of this family.
pub(super) fn compile(
    name: &str,
    attributes: &Attributes<'_>,
    opset: i64,
) -> Result<Option<(Arity, Operator)>, String> {
    Ok(Some(match name {
        "MatMul" => (
            (2, 1),
            Box::new(|inputs, outputs| matmul(inputs.get(0)?, inputs.get(1)?, &mut outputs[0])),
        ),
        "Gemm" => {
            let (alpha, beta) = (attributes.float("alpha", 1.0)?, attributes.float("beta", 1.0)?);
            let (trans_a, trans_b) = (
                attributes.integer("transA", 0)? != 0,
                attributes.integer("transB", 0)? != 0,
            );
            if trans_a {
                return Err("`transA` is not run".to_owned());
            }
            (
                (3, 1),
                Box::new(move |inputs, outputs| {
                    let (a, b) = (inputs.get(0)?, inputs.get(1)?);
                    let c = inputs.optional(2);
                    if c.is_none() && opset < 11 {
                        return Err("its input 2 is missing".to_owned());
                    }
                    gemm(a, b, c, (alpha, beta), trans_b, &mut outputs[0])
                }),
            )
        }
        _ => return Ok(None),
    }))
}

/// The sum of products of two rows.
pub(super) fn dot(a: &[f32], b: &[f32]) -> f32 {
    let (heads_a, tail_a) = a.as_chunks::<DOT_LANES>();
    let (heads_b, tail_b) = b.as_chunks::<DOT_LANES>();
    let mut sums = [0.0; DOT_LANES];
    for (a, b) in heads_a.iter().zip(heads_b) {
        for lane in 0..DOT_LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    for (lane, (a, b)) in tail_a.iter().zip(tail_b).enumerate() {
        sums[lane] += a * b;
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (b + f)) + ((c + g) + (d + h))
}

/// Adds the product of a row and a matrix with rows as long as `to`.
fn add_product(row: &[f32], matrix: &[f32], to: &mut [f32]) {
    for (factor, line) in row.iter().zip(matrix.chunks_exact(to.len().max(1))) {
        for (to, number) in to.iter_mut().zip(line) {
            *to += factor * number;
        }
    }
}

fn gemm(
    a: &Tensor,
    b: &Tensor,
    c: Option<&Tensor>,
    (alpha, beta): (f32, f32),
    trans_b: bool,
    to: &mut Tensor,
) -> Result<(), String> {
    let (&[rows, inner], &[b0, b1]) = (a.shape.as_slice(), b.shape.as_slice()) else {
        return Err(format!(
            "it takes two matrices, not {:?} and {:?}",
            a.shape, b.shape
        ));
    };
    let (b_inner, columns) = if trans_b { (b1, b0) } else { (b0, b1) };
    if inner != b_inner {
        return Err(format!("the matrices {:?} and {:?} do not fit", a.shape, b.shape));
    }
    let (a, b) = (a.floats()?, b.floats()?);
    let room = to.room(&[rows, columns], inner + 1)?;
    room.fill(0.0);
    if columns == 0 {
        return Ok(());
    }
    for (row, to) in room.chunks_exact_mut(columns).enumerate() {
        let line = &a[row * inner..][..inner];
        match trans_b {
            false => add_product(line, b, to),
            true => to
                .iter_mut()
                .enumerate()
                .for_each(|(at, to)| *to = dot(line, &b[at * inner..][..inner])),
        }
        if alpha != 1.0 {
            to.iter_mut().for_each(|to| *to *= alpha);
        }
    }
    let Some(c) = c else { return Ok(()) };
    let steps = match c.shape.as_slice() {
        _ if broadcast(&c.shape, &[rows, columns]).as_deref() != Ok(&[rows, columns]) => {
            return Err(format!(
                "its sum of the shape {:?} does not fit {:?}",
                c.shape,
                [rows, columns]
            ));
        }
        shape => super::elementwise::steps(shape, 2),
    };
    let c = c.floats()?;
    for (row, to) in room.chunks_exact_mut(columns).enumerate() {
        for (column, to) in to.iter_mut().enumerate() {
            let number = c[row * steps[0] + column * steps[1]];
            *to += if beta == 1.0 { number } else { beta * number };
        }
    }
    Ok(())
}

fn matmul(a: &Tensor, b: &Tensor, to: &mut Tensor) -> Result<(), String> {
    let unfit = || format!("the shapes {:?} and {:?} do not fit", a.shape, b.shape);
    // A vector is a matrix of one row or one column, which the result does not have.
    let (&[.., a_last], [_, ..]) = (a.shape.as_slice(), b.shape.as_slice()) else {
        return Err(unfit());
    };
    let rows = if a.shape.len() > 1 {
        a.shape[a.shape.len() - 2]
    } else {
        1
    };
    let (inner, columns) = match b.shape.as_slice() {
        [.., inner, columns] => (*inner, *columns),
        [inner] => (*inner, 1),
        [] => return Err(unfit()),
    };
    if inner != a_last {
        return Err(unfit());
    }
    let (batch_a, batch_b) = (
        &a.shape[..a.shape.len().saturating_sub(2)],
        &b.shape[..b.shape.len().saturating_sub(2)],
    );
    let batch = broadcast(batch_a, batch_b)?;
    let mut shape = batch.clone();
    if a.shape.len() > 1 {
        shape.push(rows);
    }
    if b.shape.len() > 1 {
        shape.push(columns);
    }
    let (numbers_a, numbers_b) = (a.floats()?, b.floats()?);
    let room = to.room(&shape, inner + 1)?;
    room.fill(0.0);
    if columns == 0 {
        return Ok(());
    }
    let (steps_a, steps_b) = (
        super::elementwise::steps(batch_a, batch.len()),
        super::elementwise::steps(batch_b, batch.len()),
    );
    for (index, block) in room.chunks_exact_mut((rows * columns).max(1)).enumerate() {
        let (mut left, mut right, mut rest) = (0, 0, index);
        for axis in (0..batch.len()).rev() {
            left += rest % batch[axis] * steps_a[axis];
            right += rest % batch[axis] * steps_b[axis];
            rest /= batch[axis];
        }
        let (left, right) = (
            &numbers_a[left * rows * inner..],
            &numbers_b[right * inner * columns..],
        );
        for (row, to) in block.chunks_exact_mut(columns).enumerate() {
            add_product(&left[row * inner..][..inner], &right[..inner * columns], to);
        }
    }
    Ok(())
}
