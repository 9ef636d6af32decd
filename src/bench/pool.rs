//! Several independent pictures of one scene as one.

use crate::picture::Picture;

const COLOUR: [&str; 4] = ["R", "G", "B", "A"];

/// The mean of pictures with `variance.*` and `samples`, weighted by their samples, with the variance of one sample of
/// all of them (Chan, Golub & LeVeque 1979). `None` without a picture.
pub fn pool(pictures: &[Picture]) -> Option<Picture> {
    let first = pictures.first()?;
    let mut pooled = Picture::new(first.width, first.height);
    let pixels = first.width * first.height;
    let counts: Vec<Vec<f64>> = pictures.iter().map(|picture| plane(picture, "samples", pixels)).collect();
    let total: Vec<f64> = (0..pixels).map(|p| counts.iter().map(|count| count[p]).sum()).collect();
    for name in COLOUR.into_iter().filter(|name| first.channel(name).is_some()) {
        let variance_name = format!("variance.{name}");
        let means: Vec<Vec<f64>> = pictures.iter().map(|picture| plane(picture, name, pixels)).collect();
        let variances: Vec<Vec<f64>> =
            pictures.iter().map(|picture| plane(picture, &variance_name, pixels)).collect();
        let mean = |p: usize| {
            let sum: f64 = means.iter().zip(&counts).map(|(mean, count)| mean[p] * count[p]).sum();
            sum / total[p].max(1.0)
        };
        let squares = |p: usize, mean: f64| -> f64 {
            let of = |i: usize| {
                let (n, d) = (counts[i][p], means[i][p] - mean);
                variances[i][p] * (n - 1.0).max(0.0) + d * d * n
            };
            (0..pictures.len()).map(of).sum()
        };
        let (mut mean_plane, mut variance_plane) = (Vec::with_capacity(pixels), Vec::with_capacity(pixels));
        for p in 0..pixels {
            let mean = mean(p);
            mean_plane.push(mean as f32);
            variance_plane.push((squares(p, mean) / (total[p] - 1.0).max(1.0)) as f32);
        }
        pooled = pooled.with_channel(name, mean_plane).with_channel(&variance_name, variance_plane);
    }
    pooled
        .metadata
        .insert("svetlo.content".into(), format!("mean of {} independent renders", pictures.len()));
    Some(pooled.with_counts("samples", total.iter().map(|&count| count as u32).collect()))
}

fn plane(picture: &Picture, name: &str, pixels: usize) -> Vec<f64> {
    match picture.channel(name) {
        Some(samples) => samples.to_f32().iter().map(|&value| f64::from(value)).collect(),
        None => vec![0.0; pixels],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and variance of one sample of a pixel, as a file would hold them.
    fn picture(samples: &[f64]) -> Picture {
        let count = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / count;
        let variance = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Picture::new(1, 1)
            .with_channel("R", vec![mean as f32])
            .with_channel("variance.R", vec![variance as f32])
            .with_counts("samples", vec![samples.len() as u32])
    }

    #[test]
    fn parts_pool_to_the_whole() {
        let all = [1.0, 2.5, 0.25, 4.0, 3.0, 1.5, 8.0];
        let pooled = pool(&[picture(&all[..3]), picture(&all[3..])]).unwrap();
        let whole = picture(&all);
        for name in ["R", "variance.R", "samples"] {
            let [a, b] = [&pooled, &whole].map(|picture| picture.channel(name).unwrap().to_f32()[0]);
            // Two roundings of float32 in the parts.
            assert!((a - b).abs() <= 4.0 * f32::EPSILON * b, "{name}: {a} {b}");
        }
        assert_eq!(pool(&[]), None);
    }
}
