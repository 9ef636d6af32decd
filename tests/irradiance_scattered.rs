//! Scattered light from scene to fluence: closed forms, the twin in double precision, energy.

mod common;
#[path = "common/irradiance.rs"]
mod irradiance;

use common::{EPS, close, largest, log_slope, report, rms};
use glam::DVec3;
use irradiance::{Lit, MIRROR};
use svetlo::irradiance::Limiter;

#[test]
fn slabs_converge_with_the_second_order_to_the_closed_form() {
    let truths: serde_json::Value = serde_json::from_str(include_str!("truths.json")).unwrap();
    for row in truths["diffusion_slab"]["rows"].as_array().unwrap() {
        let number = |key: &str| row[key].as_f64().unwrap();
        let [sa, ss, a, b, c, k] = ["sa", "ss", "a", "b", "C", "k"].map(number);
        let st = sa + ss;
        let closed = |z: f64| a * (-k * z).exp() + b * (-k * (1.0 - z)).exp() + c * (-st * z).exp();
        let mut errors = Vec::new();
        for cells in [16, 32, 64] {
            let lit = Lit::slab(cells, st, &format!("albedo = {}", ss / st), |_| st);
            let found = lit.solve(|p| [(-st * p.z).exp(); 3]);
            let error = rms(found.centres().zip(found.grey()).map(|(p, phi)| phi - closed(p.z * lit.unit())));
            errors.push((1.0 / cells as f64, error));
            println!("{:?}", found.channels);
        }
        println!("σ_a {sa}: rms errors {errors:?}, order {:.3}", log_slope(&errors));
    }
}

#[test]
fn limiters() {
    for limiter in Limiter::ALL {
        for n in [16, 32, 64] {
            let mut lit = Lit::new([n; 3], DVec3::splat(1.0 / n as f64), 20.0, "albedo=0.99", |p| {
                if p.distance(DVec3::splat(0.5)) < 0.3 { 20.0 } else { 0.0 }
            });
            lit.settings.limiter = limiter;
            let found = lit.solve(|p| [(-p.z).exp(); 3]);
            println!("{limiter:?} {n} {:?}", found.channels);
            let mut lit = Lit::new([n; 3], DVec3::splat(1.0 / n as f64), 20.0, "albedo=0.99", |p| {
                if p.z < 0.3 || p.z > 0.7 { 20.0 } else { 0.0 }
            });
            lit.settings.limiter = limiter;
            let found = lit.solve(|p| [(-p.z).exp(); 3]);
            println!("gap {limiter:?} {n} {:?}", found.channels);
        }
    }
}
