//! The steady diffusion equation −∇·(D∇φ) + σ_a φ = Q on a box of cells with Marshak's boundary.
//!
//! Finite volumes as in the textbooks: what flows through a face is the difference of the two cells' fluence over the
//! resistance between their centres, h/2D each; at the boundary the second half is 2A instead. Solved by conjugate
//! gradients, preconditioned by the diagonal, until rounding ends the progress.

/// A box of cells and what is in them, x fastest.
pub struct Diffusion {
    /// Cells per axis.
    pub dims: [usize; 3],
    /// Edges of a cell.
    pub spacing: [f64; 3],
    /// A of Marshak's condition per axis; infinite at a mirror.
    pub reflection: [f64; 3],
    /// σ_a per cell.
    pub absorption: Vec<f64>,
    /// D per cell.
    pub diffusivity: Vec<f64>,
}

/// Where a source's power goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Absorbed in the cells.
    pub absorbed: f64,
    /// Through the boundary.
    pub escaped: f64,
}

impl Diffusion {
    /// Fluence for a source per volume.
    pub fn solve(&self, source: &[f64]) -> Vec<f64> {
        let volume = self.volume();
        let power: Vec<f64> = source.iter().map(|q| q * volume).collect();
        let inverse: Vec<f64> = self.diagonal().into_iter().map(|d| 1.0 / d).collect();
        let mut phi = vec![0.0; power.len()];
        let mut residual = power;
        let mut direction = vec![0.0; phi.len()];
        let first = dot(&residual, &residual);
        let mut before = f64::INFINITY;
        // In exact arithmetic there are no more iterations than cells; rounding may double them.
        for _ in 0..2 * phi.len() + 8 {
            if dot(&residual, &residual) <= 1e-28 * first {
                break;
            }
            let ahead: Vec<f64> = residual.iter().zip(&inverse).map(|(r, d)| r * d).collect();
            let numerator = dot(&residual, &ahead);
            let turn = numerator / before;
            direction = ahead.iter().zip(&direction).map(|(z, p)| z + turn * p).collect();
            let leaving = self.apply(&direction);
            let step = numerator / dot(&direction, &leaving);
            for i in 0..phi.len() {
                phi[i] += step * direction[i];
                residual[i] -= step * leaving[i];
            }
            before = numerator;
        }
        phi
    }

    /// ‖Q − Aφ‖ / ‖Q‖.
    pub fn residual(&self, phi: &[f64], source: &[f64]) -> f64 {
        let volume = self.volume();
        let missing: Vec<f64> =
            source.iter().zip(self.apply(phi)).map(|(q, leaving)| q - leaving / volume).collect();
        (dot(&missing, &missing) / dot(source, source)).sqrt()
    }

    /// Where the power goes that a fluence loses.
    pub fn balance(&self, phi: &[f64]) -> Balance {
        let volume = self.volume();
        let mut balance = Balance { absorbed: 0.0, escaped: 0.0 };
        for (i, phi) in phi.iter().enumerate() {
            balance.absorbed += self.absorption[i] * volume * phi;
            balance.escaped += self.boundary(i) * phi;
        }
        balance
    }

    /// What leaves each cell: absorbed, through its faces, through the boundary.
    fn apply(&self, phi: &[f64]) -> Vec<f64> {
        let volume = self.volume();
        let lost = |i: usize| (self.absorption[i] * volume + self.boundary(i)) * phi[i];
        let mut leaving: Vec<f64> = (0..phi.len()).map(lost).collect();
        self.faces(|i, j, conductance| {
            let flux = conductance * (phi[i] - phi[j]);
            leaving[i] += flux;
            leaving[j] -= flux;
        });
        leaving
    }

    fn diagonal(&self) -> Vec<f64> {
        let volume = self.volume();
        let own = |i: usize| self.absorption[i] * volume + self.boundary(i);
        let mut diagonal: Vec<f64> = (0..self.absorption.len()).map(own).collect();
        self.faces(|i, j, conductance| {
            diagonal[i] += conductance;
            diagonal[j] += conductance;
        });
        diagonal
    }

    /// Every face between two cells with its conductance.
    fn faces(&self, mut face: impl FnMut(usize, usize, f64)) {
        let distance = [1, self.dims[0], self.dims[0] * self.dims[1]];
        for i in 0..self.absorption.len() {
            let cell = self.cell(i);
            for axis in (0..3).filter(|&axis| cell[axis] + 1 < self.dims[axis]) {
                let j = i + distance[axis];
                let half = |cell: usize| self.spacing[axis] / (2.0 * self.diffusivity[cell]);
                face(i, j, self.area(axis) / (half(i) + half(j)));
            }
        }
    }

    /// Conductance from a cell to the outside.
    fn boundary(&self, i: usize) -> f64 {
        let cell = self.cell(i);
        let side = |axis: usize| {
            let half = self.spacing[axis] / (2.0 * self.diffusivity[i]);
            self.area(axis) / (2.0 * self.reflection[axis] + half)
        };
        let sides = |axis: usize| {
            [cell[axis] == 0, cell[axis] + 1 == self.dims[axis]].map(|at| f64::from(u8::from(at)))
        };
        (0..3).map(|axis| sides(axis).iter().sum::<f64>() * side(axis)).sum()
    }

    fn cell(&self, i: usize) -> [usize; 3] {
        let [nx, ny, _] = self.dims;
        [i % nx, i / nx % ny, i / nx / ny]
    }

    fn area(&self, axis: usize) -> f64 {
        self.volume() / self.spacing[axis]
    }

    fn volume(&self) -> f64 {
        self.spacing.iter().product()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A column of cells between mirrors, open at its ends.
    fn column(cells: usize, absorption: f64, diffusivity: impl Fn(usize) -> f64) -> Diffusion {
        Diffusion {
            dims: [1, 1, cells],
            spacing: [1.0, 1.0, 1.0 / cells as f64],
            reflection: [f64::INFINITY, f64::INFINITY, 1.0],
            absorption: vec![absorption; cells],
            diffusivity: (0..cells).map(diffusivity).collect(),
        }
    }

    #[test]
    fn a_slab_without_absorption_is_a_parabola() {
        // φ(z) = QH + Qz(H − z)/2D at the cells' centres, and Qh²/8D more: the scheme's own error.
        let (cells, d, q) = (24, 0.05, 3.0);
        let phi = column(cells, 0.0, |_| d).solve(&vec![q; cells]);
        let h = 1.0 / cells as f64;
        for (i, phi) in phi.into_iter().enumerate() {
            let z = (i as f64 + 0.5) * h;
            let exact = q + q * z * (1.0 - z) / (2.0 * d) + q * h * h / (8.0 * d);
            assert!((phi - exact).abs() < 1e-11 * exact, "{z}: {phi} {exact}");
        }
    }

    #[test]
    fn power_is_accounted_for() {
        let slab = column(17, 0.7, |i| 0.01 + 0.1 * i as f64);
        let source: Vec<f64> = (0..17).map(|i| f64::from(i % 3)).collect();
        let phi = slab.solve(&source);
        let Balance { absorbed, escaped } = slab.balance(&phi);
        let power = source.iter().sum::<f64>() / 17.0;
        assert!((absorbed + escaped - power).abs() < 1e-12 * power, "{absorbed} {escaped} {power}");
        assert!(slab.residual(&phi, &source) < 1e-12);
    }
}
