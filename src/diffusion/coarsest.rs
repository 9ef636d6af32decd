//! The inverse of the coarsest level's matrix, in double precision.

use super::grid::Grid;
use crate::{Error, Result};

/// Conductances per axis and loss of a level, as read from the device.
pub(super) struct Coarsest<'a> {
    pub grid: &'a Grid,
    pub conductance: [Vec<f32>; 3],
    pub loss: Vec<f32>,
}

impl Coarsest<'_> {
    /// The elements of all cells, x fastest.
    pub fn elements(&self) -> Vec<u32> {
        cells(self.grid.dims).map(|cell| self.grid.element(cell) as u32).collect()
    }

    /// The inverse, row by row in the order of [`Coarsest::elements`].
    ///
    /// # Errors
    /// [`Error::Input`] when there is none: nothing is absorbed and nothing leaves.
    pub fn inverse(&self) -> Result<Vec<f32>> {
        let order = self.grid.dims.iter().product();
        let factor = cholesky(self.matrix(), order).ok_or_else(|| {
            Error::Input(
                "diffusion: next to nothing is absorbed and nothing leaves the box, so light has no steady state; \
                 open a boundary or let the medium absorb"
                    .into(),
            )
        })?;
        let mut inverse = vec![0.0; order * order];
        for column in 0..order {
            for (row, value) in solve(&factor, order, column).into_iter().enumerate() {
                inverse[row * order + column] += 0.5 * value;
                inverse[column * order + row] += 0.5 * value;
            }
        }
        Ok(inverse.into_iter().map(|value| value as f32).collect())
    }

    fn matrix(&self) -> Vec<f64> {
        let dims = self.grid.dims;
        let order: usize = dims.iter().product();
        let distance = [1, dims[0], dims[0] * dims[1]];
        let mut matrix = vec![0.0; order * order];
        for (i, cell) in cells(dims).enumerate() {
            let element = self.grid.element(cell);
            matrix[i * order + i] += f64::from(self.loss[element]);
            for axis in (0..3).filter(|&axis| cell[axis] + 1 < dims[axis]) {
                let conductance = f64::from(self.conductance[axis][element]);
                let j = i + distance[axis];
                matrix[i * order + i] += conductance;
                matrix[j * order + j] += conductance;
                matrix[i * order + j] = -conductance;
                matrix[j * order + i] = -conductance;
            }
        }
        matrix
    }
}

fn cells([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..nx * ny * nz).map(move |i| [i % nx, i / nx % ny, i / nx / ny])
}

/// L of L·Lᵀ, row by row; none where the matrix is not positive definite.
fn cholesky(mut matrix: Vec<f64>, order: usize) -> Option<Vec<f64>> {
    for i in 0..order {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| matrix[i * order + k] * matrix[j * order + k]).sum();
            let rest = matrix[i * order + j] - known;
            // A pivot that is all rounding has no digit left.
            let least = matrix[i * order + i] * 1e-14;
            matrix[i * order + j] = match i == j {
                true if rest > least => rest.sqrt(),
                true => return None,
                false => rest / matrix[j * order + j],
            };
        }
    }
    Some(matrix)
}

/// The solution for a right side that is 1 at `column`.
fn solve(factor: &[f64], order: usize, column: usize) -> Vec<f64> {
    let mut x = vec![0.0; order];
    for i in column..order {
        let known: f64 = (column..i).map(|k| factor[i * order + k] * x[k]).sum();
        x[i] = (f64::from(u8::from(i == column)) - known) / factor[i * order + i];
    }
    for i in (0..order).rev() {
        let known: f64 = (i + 1..order).map(|k| factor[k * order + i] * x[k]).sum();
        x[i] = (x[i] - known) / factor[i * order + i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_inverse() {
        // Second differences: the inverse is min(i, j) (n + 1 - max(i, j)) / (n + 1).
        let order = 5;
        let entry = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        };
        let matrix = (0..order * order).map(|k| entry(k / order, k % order)).collect();
        let factor = cholesky(matrix, order).unwrap();
        for column in 0..order {
            for (row, value) in solve(&factor, order, column).into_iter().enumerate() {
                let (low, high) = (row.min(column) + 1, row.max(column) + 1);
                let exact = (low * (order + 1 - high)) as f64 / (order + 1) as f64;
                assert!((value - exact).abs() < 16.0 * f64::EPSILON, "{row} {column}: {value} {exact}");
            }
        }
    }

    #[test]
    fn a_singular_matrix_has_none() {
        assert!(cholesky(vec![1.0, -1.0, -1.0, 1.0], 2).is_none());
    }
}
