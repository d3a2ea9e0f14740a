//! Matrices of 3 × 3 numbers, for poses in the plane: x, y, heading.

/// Rows of a matrix.
pub type Matrix = [[f64; 3]; 3];
pub(crate) type Vector = [f64; 3];

pub(crate) const ZERO: Matrix = [[0.0; 3]; 3];

/// Sweeps of rotations, each of which about squares what is left beside the diagonal.
const SWEEPS: usize = 5;

pub(crate) const fn diagonal(of: Vector) -> Matrix {
    [[of[0], 0.0, 0.0], [0.0, of[1], 0.0], [0.0, 0.0, of[2]]]
}

pub(crate) fn transpose(a: &Matrix) -> Matrix {
    core::array::from_fn(|row| core::array::from_fn(|column| a[column][row]))
}

pub(crate) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    core::array::from_fn(|row| {
        core::array::from_fn(|column| (0..3).map(|inner| a[row][inner] * b[inner][column]).sum())
    })
}

/// to − aᵀ b
pub(crate) fn subtract_product(to: &mut Matrix, a: &Matrix, b: &Matrix) {
    for inner in 0..3 {
        for row in 0..3 {
            for column in 0..3 {
                to[row][column] -= a[inner][row] * b[inner][column];
            }
        }
    }
}

/// aᵀ b
pub(crate) fn product_transposed(a: &Matrix, b: &Matrix) -> Matrix {
    core::array::from_fn(|row| {
        core::array::from_fn(|column| (0..3).map(|inner| a[inner][row] * b[inner][column]).sum())
    })
}

pub(crate) fn times(a: &Matrix, x: &Vector) -> Vector {
    core::array::from_fn(|row| dot(&a[row], x))
}

/// aᵀ x
pub(crate) fn times_transposed(a: &Matrix, x: &Vector) -> Vector {
    core::array::from_fn(|row| (0..3).map(|inner| a[inner][row] * x[inner]).sum())
}

pub(crate) fn dot(a: &Vector, b: &Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn add(to: &mut Matrix, factor: f64, other: &Matrix) {
    for (to, other) in to.iter_mut().flatten().zip(other.iter().flatten()) {
        *to += factor * other;
    }
}

/// to + factor x xᵀ
pub(crate) fn add_square(to: &mut Matrix, factor: f64, x: &Vector) {
    for (row, a) in to.iter_mut().zip(x) {
        for (to, b) in row.iter_mut().zip(x) {
            *to += factor * a * b;
        }
    }
}

/// A symmetric matrix with 0 in place of its negative eigenvalues, by Jacobi's rotations.
pub(crate) fn positive(a: &Matrix) -> Matrix {
    let (mut values, mut vectors) = (*a, diagonal([1.0; 3]));
    for _ in 0..SWEEPS {
        for (one, other) in [(0, 1), (0, 2), (1, 2)] {
            let angle = 0.5 * libm::atan2(2.0 * values[one][other], values[other][other] - values[one][one]);
            let (sin, cos) = libm::sincos(angle);
            let mut turn = diagonal([1.0; 3]);
            (turn[one][one], turn[other][other]) = (cos, cos);
            (turn[one][other], turn[other][one]) = (sin, -sin);
            values = product(&product(&transpose(&turn), &values), &turn);
            vectors = product(&vectors, &turn);
        }
    }
    let kept = diagonal([0, 1, 2].map(|at| values[at][at].max(0.0)));
    product(&product(&vectors, &kept), &transpose(&vectors))
}

/// xᵀ a x
pub(crate) fn square(a: &Matrix, x: &Vector) -> f64 {
    dot(x, &times(a, x))
}

/// The inverse of a symmetric, positive definite matrix; `None` if it is not.
pub(crate) fn invert(a: &Matrix) -> Option<Matrix> {
    let [[xx, xy, xt], [_, yy, yt], [_, _, tt]] = *a;
    let (first, second, third) = (yy * tt - yt * yt, xt * yt - xy * tt, xy * yt - xt * yy);
    let minor = xx * yy - xy * xy;
    let determinant = xx * first + xy * second + xt * third;
    if !(xx > 0.0 && minor > 0.0 && determinant > 0.0 && determinant.is_finite()) {
        return None;
    }
    let (fourth, fifth) = (xx * tt - xt * xt, xy * xt - xx * yt);
    let inverse = [
        [first, second, third],
        [second, fourth, fifth],
        [third, fifth, minor],
    ];
    Some(inverse.map(|row| row.map(|number| number / determinant)))
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
            ZERO,
            diagonal([1.0, 1.0, -1.0]),
            diagonal([1.0, 0.0, 1.0]),
            diagonal([f64::NAN, 1.0, 1.0]),
            [[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        ] {
            assert_eq!(invert(&bad), None, "{bad:?}");
        }
    }

    #[test]
    fn negative_eigenvalues_become_zero_and_others_stay() {
        let turn = {
            let ((a, b), (c, d)) = (libm::sincos(0.7), libm::sincos(-1.1));
            let flat = [[b, -a, 0.0], [a, b, 0.0], [0.0, 0.0, 1.0]];
            product(&flat, &[[d, 0.0, c], [0.0, 1.0, 0.0], [-c, 0.0, d]])
        };
        let of = |values: Vector| product(&product(&turn, &diagonal(values)), &transpose(&turn));
        for values in [[900.0, 4.0, 2.0], [900.0, -4.0, 2.0], [-1.0, -1.0, 3e4], [0.0; 3]] {
            let (found, expected) = (positive(&of(values)), of(values.map(|value: f64| value.max(0.0))));
            for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
                assert!((found - expected).abs() < 1e-9, "{values:?}");
            }
        }
    }
}
