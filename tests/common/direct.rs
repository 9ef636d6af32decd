//! What the tests of direct light in light volumes share: runs, and how they are held against the truth.
//!
//! Each test file uses a part of this.
#![allow(dead_code)]

use crate::common::scattering::{family, of_values};
use crate::common::{Case, EPS, close, device, report};
use glam::DVec3;
use svetlo::irradiance::{Direct, DirectCost, LightGrid, LitMedium, STRATA};
use svetlo::reference::quadrature::gauss_legendre;
use svetlo::volume::Volume;

/// The direct light of a case, on the host.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    pub fluence: Vec<[f32; 4]>,
    pub reduced: Option<Vec<[f32; 4]>>,
    pub flow: Option<Vec<[f32; 4]>>,
    pub cost: DirectCost,
    pub exact: bool,
    pub passes: u32,
    /// RMS standard error over RMS fluence.
    pub error: f64,
    /// The cells' centres, scene units.
    pub centres: Vec<DVec3>,
}

/// How a run is made.
#[derive(Debug, Clone, Copy)]
pub struct How {
    pub coarsening: usize,
    pub passes: u32,
    /// Rays side by side, if not as the device likes it.
    pub lanes: Option<u32>,
    /// Blocks of cells per launch, at most.
    pub launch: u64,
}

impl How {
    pub fn passes(passes: u32) -> Self {
        Self { coarsening: 1, passes, lanes: None, launch: u64::MAX }
    }

    /// A cell per so many voxels along each axis.
    pub fn coarse(self, coarsening: usize) -> Self {
        Self { coarsening, ..self }
    }

    pub fn run(self, case: &Case) -> Run {
        let device = device();
        let plan = case.plan();
        let medium = LitMedium::new(&device, &plan, &plan.method).unwrap();
        let grid = LightGrid::new(&plan.local, self.coarsening);
        let phase = &case.scene.phase;
        let mut direct = match self.lanes {
            Some(lanes) => Direct::with_lanes(&device, &medium, &grid, phase, lanes).unwrap(),
            None => Direct::new(&device, &medium, &grid, phase).unwrap(),
        };
        direct.limit_launches(self.launch);
        while !direct.is_done(self.passes) {
            direct.step(&device, &medium, self.passes).unwrap();
        }
        let light = direct.means(&device).unwrap();
        let cost = direct.cost(&device).unwrap();
        assert_eq!(cost.above_majorant, 0);
        let [nx, ny, _] = grid.dims;
        let index = |i: usize| DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
        let centre = |i: usize| plan.local.origin + plan.local.unit * (index(i) + 0.5) * grid.cell;
        let run = Run {
            fluence: light.fluence.read(&device).unwrap(),
            reduced: light.reduced.as_ref().map(|buffer| buffer.read(&device).unwrap()),
            flow: light.flow.as_ref().map(|buffer| buffer.read(&device).unwrap()),
            cost,
            exact: direct.is_exact(),
            passes: direct.passes(),
            error: light.relative_error(&device).unwrap(),
            centres: (0..grid.cells()).map(centre).collect(),
        };
        let fields = [Some(&run.fluence), run.reduced.as_ref()];
        assert!(fields.into_iter().flatten().flatten().flatten().all(|v| *v >= 0.0), "a negative light");
        run
    }
}

/// A scene for direct light: single scattering, whose camera nobody looks through, in a box from the origin.
pub fn text(medium: &str, points: &str, rest: &str) -> String {
    format!(
        "[camera]\nposition = [0, 0, -9]\ntarget = [0, 0, 0]\n[volume]\norigin = [0, 0, 0]\n\
         window = {{ lo = 0, hi = 1 }}\n[medium]\n{medium}\n[transfer]\nresolution = 2\npoints = [{points}]\n{rest}\n\
         [method]\nkind = \"single-scattering\"\n"
    )
}

/// A box of one extinction.
pub struct Homogeneous {
    pub size: DVec3,
    pub sigma: [f64; 3],
}

impl Homogeneous {
    /// The box of a volume, with another spacing.
    pub fn new(volume: &Volume, spacing: DVec3, sigma: [f64; 3]) -> Self {
        Self { size: spacing * DVec3::from_array(volume.dims.map(|n| n as f64)), sigma }
    }

    /// From a point inside to the box's face.
    pub fn exit(&self, point: DVec3, direction: DVec3) -> f64 {
        let along = |axis: usize| {
            let (p, d) = (point[axis], direction[axis]);
            if d > 0.0 {
                (self.size[axis] - p) / d
            } else if d < 0.0 {
                -p / d
            } else {
                f64::INFINITY
            }
        };
        (0..3).map(along).fold(f64::INFINITY, f64::min)
    }

    /// Per channel, over a ray of at most this length.
    pub fn transmittance(&self, point: DVec3, direction: DVec3, most: f64) -> [f64; 3] {
        let length = self.exit(point, direction).min(most);
        self.sigma.map(|sigma| (-sigma * length).exp())
    }

    /// ∫ T dω over all directions: per face, four quadrants around the foot of the perpendicular (at distance h), in
    /// polar coordinates: ∫ dφ ∫ exp(−σ h / μ) dμ over cosines μ to the perpendicular, smooth between the corners.
    pub fn sphere(&self, point: DVec3, sigma: f64) -> f64 {
        let rule = gauss_legendre(16);
        let mut sum = 0.0;
        for (axis, far) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
            let to =
                |axis: usize, far: usize| if far == 1 { self.size[axis] - point[axis] } else { point[axis] };
            let height = to(axis, far);
            for quadrant in 0..4 {
                let [a, b] = [to((axis + 1) % 3, quadrant & 1), to((axis + 2) % 3, quadrant >> 1)];
                let corner = f64::atan2(b, a);
                for (from, until, edge, turned) in [
                    (0.0, corner, a, 0.0),
                    (corner, 0.5 * std::f64::consts::PI, b, 0.5 * std::f64::consts::PI),
                ] {
                    for &(x, weight) in &rule {
                        let angle: f64 = from + x * (until - from);
                        let reach = edge / (angle - turned).cos();
                        let least = height / height.hypot(reach);
                        let depth = |mu: f64| (-sigma * height / mu).exp();
                        let inner: f64 = rule
                            .iter()
                            .map(|&(y, w)| w * (1.0 - least) * depth(least + y * (1.0 - least)))
                            .sum();
                        sum += weight * (until - from) * inner;
                    }
                }
            }
        }
        sum
    }
}

/// Asserts that noise-free light is `exact` but for `ulps` roundings.
#[track_caller]
pub fn exactly(what: &str, found: &[[f32; 4]], exact: &[[f64; 3]], ulps: f64) {
    assert_eq!(found.len(), exact.len());
    let mut worst = 0.0_f64;
    for (cell, (found, exact)) in found.iter().zip(exact).enumerate() {
        assert_eq!(found[3], 0.0, "{what}: the variance of cell {cell}");
        for c in 0..3 {
            let bound = ulps * EPS * exact[c];
            close(&format!("{what}, cell {cell}"), found[c].into(), exact[c], bound);
            worst = worst.max((f64::from(found[c]) - exact[c]).abs() / bound);
        }
    }
    report(what, worst, 1.0);
}

/// Student's t that is exceeded as rarely as a normal number exceeds k (Cornish & Fisher's expansion).
pub fn student(k: f64, degrees: f64) -> f64 {
    k + (k.powi(3) + k) / (4.0 * degrees)
        + (5.0 * k.powi(5) + 16.0 * k.powi(3) + 3.0 * k) / (96.0 * degrees * degrees)
}

/// An estimate, its standard error, and the truth.
pub type Comparison = [f64; 3];

/// Holds independent estimates against the truth: each within the Student's t of as many comparisons, their sum within 4
/// standard errors (a few dozen such sums are made), and their squares, whose mean is known when the standard errors are
/// right, too. `degrees`: of freedom
/// of the standard errors.
#[track_caller]
pub fn compare(what: &str, cells: &[Comparison], degrees: f64) {
    let k = student(family(cells.len()), degrees);
    let (mut worst, mut squares, mut sum, mut variance) = (0.0_f64, 0.0, 0.0, 0.0);
    for (cell, &[found, sigma, exact]) in cells.iter().enumerate() {
        // A few dozen roundings are systematic.
        let error = found - exact;
        let z = (error.abs() - 32.0 * EPS * exact.abs()).max(0.0) / sigma.max(f64::MIN_POSITIVE);
        assert!(z <= k, "{what}, cell {cell}: found {found}, exact {exact}: {z:.2} σ > {k:.2} σ");
        worst = worst.max(z);
        squares += z * z;
        sum += error;
        variance += sigma * sigma;
    }
    // z² follows the F distribution of 1 and `degrees` degrees of freedom.
    let mean = degrees / (degrees - 2.0);
    let spread = mean * (2.0 * (degrees - 1.0) / (degrees - 4.0) / cells.len() as f64).sqrt();
    let squares = (squares / cells.len() as f64 - mean) / spread;
    let bias = sum / variance.sqrt();
    println!("{what}: worst {worst:.2} σ of {k:.2}, squares {squares:+.2} σ, sum {bias:+.2} σ");
    assert!(
        squares.abs() <= 4.0,
        "{what}: squares are {squares:+.2} σ off: the variances are wrong, or the light"
    );
    assert!(bias.abs() <= 4.0, "{what}: the sum is {bias:+.2} σ off");
}

/// Holds the fluence of a run against the truth by the run's own variances: the channels' mean of each cell.
#[track_caller]
pub fn agrees(what: &str, run: &Run, exact: &[[f64; 3]]) {
    assert_eq!(run.fluence.len(), exact.len());
    let mean = |rgb: [f64; 3]| rgb.into_iter().sum::<f64>() / 3.0;
    let comparison = |(found, exact): (&[f32; 4], &[f64; 3])| {
        let [r, g, b, variance] = found.map(f64::from);
        [mean([r, g, b]), variance.sqrt(), mean(*exact)]
    };
    let cells: Vec<Comparison> = run.fluence.iter().zip(exact).map(comparison).collect();
    compare(what, &cells, f64::from(run.passes / STRATA) - 1.0);
}

/// Seeds of which what has no variance of its own is held against the truth.
const SEEDS: u64 = 16;

/// Holds channels of what `of` takes from runs with several seeds against the truth, by their spread.
#[track_caller]
pub fn agrees_over_seeds(
    what: &str,
    case: &mut Case,
    how: How,
    of: impl Fn(&Run) -> Vec<[f32; 4]>,
    channels: &[usize],
    exact: &dyn Fn(DVec3, usize) -> f64,
) {
    let own = case.scene.seed;
    let mut runs = Vec::new();
    let mut centres = Vec::new();
    for seed in 0..SEEDS {
        case.scene.seed = 100 + seed;
        let run = how.run(case);
        runs.push(of(&run));
        centres = run.centres;
    }
    case.scene.seed = own;
    for &channel in channels {
        let comparison = |(cell, &centre): (usize, &DVec3)| {
            let values: Vec<f64> = runs.iter().map(|run| f64::from(run[cell][channel])).collect();
            let measured = of_values(&values);
            [measured.value, measured.error, exact(centre, channel)]
        };
        let cells: Vec<Comparison> = centres.iter().enumerate().map(comparison).collect();
        compare(&format!("{what}, channel {channel}"), &cells, SEEDS as f64 - 1.0);
    }
}
