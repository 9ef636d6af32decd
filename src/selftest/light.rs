//! Checks of light volumes: direct light in their cells, by rays and carried upwind, and the diffusion of what is
//! scattered.

use super::workbench::{Case, EPS, K, Measurement, Workbench, maximum, noise, volume};
use crate::Result;
use crate::device::{Buffer, Device};
use crate::diffusion::{Boundary, Coefficients, Method, Settings, Solver};
use crate::irradiance::{
    Carrying, Cells, Convection, Direct, LightGrid, LitMedium, crossing_steps, steady_light,
};
use crate::render::local::LocalFrame;
use crate::scene::{Light, Phase};
use glam::DVec3;

/// Passes of direct light that is tracked.
const PASSES: u32 = 64;

/// Fluence of direct light in the cells of a case's volume, a voxel each, x fastest; and look-ups outside their bounds.
fn direct(bench: &Workbench, case: &Case) -> Result<(Vec<f64>, u64)> {
    let plan = case.plan()?;
    let device = Device::open(&bench.info)?.altering(bench.alter);
    let medium = LitMedium::new(&device, &plan, &plan.method)?;
    let mut direct = Direct::new(&device, &medium, &LightGrid::new(&plan.local, 1), &Phase::Isotropic)?;
    while !direct.is_done(PASSES) {
        direct.step(&device, &medium, PASSES)?;
    }
    let fluence = direct.means(&device)?.fluence.read(&device)?;
    let green = fluence.into_iter().map(|[_, green, ..]| f64::from(green)).collect();
    Ok((green, direct.cost(&device)?.above_majorant))
}

fn scene(medium: &str, light: &str) -> String {
    format!(
        "[camera]\nposition = [0, 0, -99]\ntarget = [0, 0, 0]\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n\
         [transfer]\nresolution = 2\n[medium]\n{medium}\n[[light]]\n{light}\n[method]\nkind = \"single-scattering\"\n"
    )
}

/// A sun over uneven layers by tracking, and a lamp in a constant medium in closed form.
pub fn direct_light(bench: &Workbench) -> Result<Vec<Measurement>> {
    let mut measurements = sun(bench)?;
    measurements.push(lamp(bench)?);
    Ok(measurements)
}

/// Light down the layers: e^-depth at their middles.
fn sun(bench: &Workbench) -> Result<Vec<Measurement>> {
    let (side, layers) = (16, 24);
    let heights: Vec<f64> = noise(layers, 41).iter().map(|v| f64::from(*v as f32)).collect();
    let text = scene("sigma_max = 0.2", "kind = \"directional\"\ndirection = [0, -1, 0]\nirradiance = 1");
    let values = (0..side * layers * side).map(|i| heights[i / side % layers]);
    let (fluence, above) = direct(bench, &Case::new(&text, volume([side, layers, side], values)?)?)?;
    let count = (side * side) as f64;
    let mut sums = vec![0.0; layers];
    for (i, fluence) in fluence.iter().enumerate() {
        sums[i / side % layers] += fluence;
    }
    let worst = (0..layers).map(|y| {
        // Constant in the outer half voxel, linear between the centres.
        let between: f64 = (y..layers - 1).map(|k| 0.5 * (heights[k] + heights[k + 1])).sum();
        let exact = f64::exp(-0.2 * (between + 0.5 * heights[layers - 1]));
        // What a ray brings lies between 0 and 1. Roundings: 8 in each cell of the way.
        let sigma = (exact * (1.0 - exact) / (count * f64::from(PASSES))).sqrt();
        ((sums[y] / count - exact).abs() - 8.0 * layers as f64 * EPS).max(0.0) / sigma
    });
    Ok(vec![
        Measurement::within(
            format!("sun over {layers} layers: largest error of a layer, in σ"),
            worst.fold(0.0, maximum),
            0.0,
            K,
            format!("binomial, {:.0} rays a layer", count * f64::from(PASSES)),
        ),
        Measurement::exact("look-ups above the majorant", above as f64, 0.0),
    ])
}

/// I / r² e^-σr within a constant medium.
fn lamp(bench: &Workbench) -> Result<Measurement> {
    let (dims, sigma, at) = ([9, 6, 7], 0.3, DVec3::new(3.2, 2.3, 10.4));
    let text = scene(
        &format!("sigma_max = {sigma}"),
        "kind = \"point\"\nposition = [3.2, 2.3, 10.4]\nintensity = 1",
    );
    let (fluence, _) = direct(bench, &Case::new(&text, volume(dims, vec![1.0; 9 * 6 * 7])?)?)?;
    let error = |(i, fluence): (usize, &f64)| {
        let cell = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])].map(|n| n as f64 + 0.5);
        let r = DVec3::from_array(cell).distance(at);
        // The lamp stands over the box: only this part of the way is in the medium.
        let inside = (dims[2] as f64 - cell[2]) / (at.z - cell[2]);
        (fluence / (f64::exp(-sigma * inside * r) / (r * r)) - 1.0).abs()
    };
    // Places up to 11 along each axis, beside distances of 3.9 and more, squared; the optical depth, and the exponential.
    let roundings = 2.0 * 3.0 * 11.0 / 3.9 + 8.0 * sigma * 13.0 + 16.0;
    Ok(Measurement::within(
        "lamp in a constant medium: largest relative error of a cell",
        fluence.iter().enumerate().map(error).fold(0.0, maximum),
        0.0,
        roundings * EPS,
        "4 roundings of places, depth and exponential",
    ))
}

/// Light of two suns that face each other, carried through uneven layers: each layer leaves a known share of it.
pub fn convection(bench: &Workbench) -> Result<Vec<Measurement>> {
    // The way of light in a step, of a layer.
    const COURANT: f64 = 0.5;
    let (dims, h) = ([5, 6, 24], 0.5);
    let layers = dims[2];
    let sigma: Vec<f32> = noise(layers, 17).iter().map(|u| 0.4 * *u as f32).collect();
    let local = LocalFrame::new(DVec3::ZERO, DVec3::new(1.0, 1.3, h), dims);
    let grid = LightGrid::new(&local, 1);
    let h = grid.cell.z;
    let lights =
        [DVec3::Z, DVec3::NEG_Z].map(|direction| Light::Directional { direction, irradiance: [1.0; 3] });
    let device = Device::open(&bench.info)?.altering(bench.alter);
    // A third of it scatters.
    let of_cells = |share: f32| -> Vec<[f32; 4]> {
        (0..grid.cells()).map(|i| [share * sigma[i / (dims[0] * dims[1])]; 4]).collect()
    };
    let cells = Cells {
        scattering: Buffer::from_slice(&device, &of_cells(1.0 / 3.0))?,
        absorption: Buffer::from_slice(&device, &of_cells(2.0 / 3.0))?,
        glow: None,
    };
    let carrying = Carrying { chromatic: false, mean_cosine: 0.0, directed: false };
    // What is left behind layer after layer, from both ends; the largest error of a cell.
    let error = |fluence: &[[f32; 4]], left: &dyn Fn(f64) -> f64| {
        let through = |k: usize| left(f64::from(sigma[k]) * h);
        let exact: Vec<f64> = (0..layers)
            .map(|k| (0..=k).map(through).product::<f64>() + (k..layers).map(through).product::<f64>())
            .collect();
        let of_cell = |(i, f): (usize, &[f32; 4])| (f64::from(f[1]) - exact[i / (dims[0] * dims[1])]).abs();
        fluence.iter().enumerate().map(of_cell).fold(0.0, maximum)
    };
    let settled =
        steady_light(&device, &grid, &cells, &lights, &local, carrying)?.direct.fluence.read(&device)?;
    let steps = 2 * crossing_steps(&grid, COURANT);
    let mut stepping = Convection::new(&device, &grid, &cells, &lights, &local, carrying, COURANT)?;
    stepping.advance(&device, steps)?;
    let stepped = stepping.direct(&device)?.fluence.read(&device)?;
    let resting = |depth: f64| {
        let decay = (-COURANT * depth).exp();
        COURANT * decay / (1.0 - (1.0 - COURANT) * decay)
    };
    Ok(vec![
        Measurement::within(
            format!("steady light through {layers} layers: largest error of a cell"),
            error(&settled, &|depth| 1.0 / (1.0 + depth)),
            0.0,
            2.0 * 54.0 * EPS * layers as f64,
            "54 roundings a layer, of both suns",
        ),
        Measurement::within(
            format!("after {steps} steps: largest error of a cell"),
            error(&stepped, &resting),
            0.0,
            2.0 * (40.0 * EPS * f64::from(steps) + f64::exp(-16.0)),
            "40 roundings a step, and what is still on its way",
        ),
    ])
}

/// Light that springs up evenly in uneven layers which absorb nothing: what flows through each face is known, and the
/// fluences follow from the layers' resistances in series, Marshak's boundaries at both ends.
pub fn diffusion(bench: &Workbench) -> Result<Vec<Measurement>> {
    let (dims, h) = ([3, 5, 32], 0.5);
    let layers = dims[2];
    let cells = dims.iter().product::<usize>();
    // Diffusivities over a factor of 30.
    let diffusivity: Vec<f32> =
        noise(layers, 13).iter().map(|u| (0.1 * f64::exp(u * f64::ln(30.0))) as f32).collect();
    let exact = in_series(&diffusivity, h);
    let brightest = exact.iter().copied().fold(0.0, f64::max);
    let device = Device::open(&bench.info)?;
    let of_cells: Vec<f32> = (0..cells).map(|i| diffusivity[i / (dims[0] * dims[1])]).collect();
    let [absorption, diffusivity, source] =
        [vec![0.0; cells], of_cells, vec![1.0; cells]].map(|values| Buffer::from_slice(&device, &values));
    let (absorption, diffusivity, source) = (absorption?, diffusivity?, source?);
    let coefficients = Coefficients { absorption: &absorption, diffusivity: &diffusivity };
    let boundary = Boundary { reflection: [f64::INFINITY, f64::INFINITY, 1.0] };
    let mut solver = Solver::altered(&device, dims, DVec3::splat(h), boundary, bench.alter)?;
    let mut row = |name: &str, method: Method| -> Result<Measurement> {
        let settings = Settings::new(method);
        let solution = solver.solve(&device, &coefficients, &source, &settings)?;
        let phi = solution.phi.read(&device)?;
        let error = |(i, phi): (usize, &f32)| (f64::from(*phi) - exact[i / (dims[0] * dims[1])]).abs();
        // The inverse of the equation has no negative entries, and its largest row sum is the largest fluence of a
        // source of 1: so far can a residual take the solution.
        let amplified = settings.tolerance * (cells as f64).sqrt();
        Ok(Measurement::within(
            format!(
                "{name}, {} iterations: largest error of a cell over the brightest",
                solution.outcome.iterations
            ),
            phi.iter().enumerate().map(error).fold(0.0, maximum) / brightest,
            0.0,
            amplified + 16.0 * EPS * (cells as f64).sqrt(),
            format!("residual of {:.0e}, and 16 roundings a cell", settings.tolerance),
        ))
    };
    Ok(vec![
        row("multigrid", Method::Multigrid)?,
        row("over-relaxation", Method::OverRelaxation { factor: None })?,
    ])
}

/// Fluence of layers `h` thick with a source of 1, nothing absorbed.
fn in_series(diffusivity: &[f32], h: f64) -> Vec<f64> {
    let half = |k: usize| 0.5 * h / f64::from(diffusivity[k]);
    let last = diffusivity.len() - 1;
    let ends = [2.0 + half(0), 2.0 + half(last)];
    let inner: Vec<f64> = (0..last).map(|k| half(k) + half(k + 1)).collect();
    // The flux through face k is k h less what leaves at the first end.
    let weighted: f64 = inner.iter().enumerate().map(|(k, r)| (k + 1) as f64 * h * r).sum();
    let whole = (last + 1) as f64 * h;
    let leaving = (weighted + whole * ends[1]) / (ends[0] + ends[1] + inner.iter().sum::<f64>());
    let mut phi = vec![leaving * ends[0]];
    for (k, r) in inner.iter().enumerate() {
        phi.push(phi[k] - ((k + 1) as f64 * h - leaving) * r);
    }
    phi
}

#[cfg(test)]
mod tests {
    use super::in_series;

    /// φ(z) = Q H + Q z (H − z) / 2D, and Q h² / 8D more in cells of size h.
    #[test]
    fn even_layers_in_series_are_the_closed_form() {
        let (h, n, d) = (0.25, 16, 0.7_f32);
        let whole = h * n as f64;
        for (k, phi) in in_series(&vec![d; n], h).into_iter().enumerate() {
            let z = (k as f64 + 0.5) * h;
            let exact = whole + (z * (whole - z) / 2.0 + h * h / 8.0) / f64::from(d);
            assert!((phi - exact).abs() < 1e-12 * exact, "{k}: {phi} {exact}");
        }
    }
}
