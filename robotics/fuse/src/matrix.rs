//! Matrices of a fixed size. They have what the filter needs and no more; its largest inverse is of 3 × 3 numbers.

/// Rows of a matrix.
pub(crate) type Matrix<const R: usize, const C: usize> = [[f64; C]; R];

pub(crate) fn product<const R: usize, const N: usize, const C: usize>(
    a: &Matrix<R, N>,
    b: &Matrix<N, C>,
) -> Matrix<R, C> {
    let mut product = [[0.0; C]; R];
    for (row, to) in a.iter().zip(&mut product) {
        for (factor, other) in row.iter().zip(b) {
            // Jacobians are mostly zeros.
            if *factor != 0.0 {
                for (to, other) in to.iter_mut().zip(other) {
                    *to += factor * other;
                }
            }
        }
    }
    product
}

pub(crate) fn transpose<const R: usize, const C: usize>(a: &Matrix<R, C>) -> Matrix<C, R> {
    core::array::from_fn(|row| core::array::from_fn(|column| a[column][row]))
}

/// The mean of a matrix and its transpose: rounding makes products differ from it in the last bits.
pub(crate) fn symmetric<const N: usize>(a: &Matrix<N, N>) -> Matrix<N, N> {
    core::array::from_fn(|row| core::array::from_fn(|column| f64::midpoint(a[row][column], a[column][row])))
}

pub(crate) fn times<const R: usize, const C: usize>(a: &Matrix<R, C>, x: &[f64; C]) -> [f64; R] {
    core::array::from_fn(|row| a[row].iter().zip(x).map(|(a, x)| a * x).sum())
}

/// The lower triangle whose product with its transpose is `a` (Cholesky); `None` if `a` is not positive definite.
pub(crate) fn cholesky<const N: usize>(a: &Matrix<N, N>) -> Option<Matrix<N, N>> {
    let mut lower = [[0.0; N]; N];
    for row in 0..N {
        for column in 0..=row {
            let sum: f64 = (0..column)
                .map(|inner| lower[row][inner] * lower[column][inner])
                .sum();
            let rest = a[row][column] - sum;
            lower[row][column] = if row != column {
                rest / lower[column][column]
            } else if rest > 0.0 && rest.is_finite() {
                rest.sqrt()
            } else {
                return None;
            };
        }
    }
    Some(lower)
}

/// The inverse of a symmetric, positive definite matrix; `None` if it is not.
pub(crate) fn invert<const N: usize>(a: &Matrix<N, N>) -> Option<Matrix<N, N>> {
    let lower = cholesky(a)?;
    let mut inverse = [[0.0; N]; N];
    for unit in 0..N {
        let mut x = [0.0; N];
        for row in 0..N {
            let sum: f64 = (0..row).map(|inner| lower[row][inner] * x[inner]).sum();
            x[row] = (f64::from(u8::from(row == unit)) - sum) / lower[row][row];
        }
        for row in (0..N).rev() {
            let sum: f64 = (row + 1..N).map(|inner| lower[inner][row] * x[inner]).sum();
            x[row] = (x[row] - sum) / lower[row][row];
        }
        for (row, x) in inverse.iter_mut().zip(x) {
            row[unit] = x;
        }
    }
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_undoes_a_matrix_and_singular_ones_have_none() {
        let a = [[4.0, 1.0, -0.5], [1.0, 3.0, 0.25], [-0.5, 0.25, 2.0]];
        let one = product(&a, &invert(&a).expect("positive definite"));
        for (row, numbers) in one.iter().enumerate() {
            for (column, number) in numbers.iter().enumerate() {
                assert!((number - f64::from(u8::from(row == column))).abs() < 1e-12);
            }
        }
        for bad in [
            [[0.0; 2]; 2],
            [[1.0, 2.0], [2.0, 1.0]],
            [[f64::NAN, 0.0], [0.0, 1.0]],
            [[f64::INFINITY, 0.0], [0.0, 1.0]],
        ] {
            assert_eq!(invert(&bad), None, "{bad:?}");
        }
    }
}
