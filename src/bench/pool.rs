//! Several independent pictures of one scene as one.

use crate::picture::Picture;

const COLOUR: [&str; 4] = ["R", "G", "B", "A"];

/// The mean of independent renders with equal weights, where each counts as one sample: `samples` is their number and
/// `variance.*` that between them, which is right however the samples within a render depend on each other. One picture
/// stays as it is; `None` without any.
pub fn pool_equal(pictures: &[Picture]) -> Option<Picture> {
    let first = pictures.first()?;
    if pictures.len() == 1 {
        return Some(without_state(first.clone()));
    }
    let count = pictures.len() as f64;
    let pixels = first.width * first.height;
    let mut pooled = Picture::new(first.width, first.height);
    for name in COLOUR {
        let planes: Option<Vec<_>> =
            pictures.iter().map(|picture| Some(picture.channel(name)?.to_f32())).collect();
        let Some(planes) = planes else { continue };
        let values = |p: usize| planes.iter().map(move |plane| f64::from(plane[p]));
        let mean = |p: usize| values(p).sum::<f64>() / count;
        let variance = |p: usize| {
            let mean = mean(p);
            values(p).map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0)
        };
        pooled = pooled
            .with_channel(name, (0..pixels).map(|p| mean(p) as f32).collect())
            .with_channel(&format!("variance.{name}"), (0..pixels).map(|p| variance(p) as f32).collect());
    }
    let meaning = format!(
        "mean of {count} independent renders; samples is their number and variance.* that between them"
    );
    pooled.metadata.insert("svetlo.content".into(), meaning);
    Some(pooled.with_counts("samples", vec![pictures.len() as u32; pixels]))
}

/// What a picture needs no more when it will not be continued.
pub fn without_state(mut picture: Picture) -> Picture {
    picture.channels.retain(|channel| !channel.name.starts_with("state."));
    picture.metadata.retain(|key, _| !key.starts_with("svetlo.state"));
    picture
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_and_variances_are_those_between_pictures() {
        let picture = |red: f32| {
            Picture::new(1, 1)
                .with_channel("R", vec![red])
                .with_channel("variance.R", vec![100.0])
                .with_channel("state.x", vec![1.0])
                .with_counts("samples", vec![7])
        };
        let value = |picture: &Picture, name: &str| picture.channel(name).unwrap().to_f32()[0];
        let pooled = pool_equal(&[picture(1.0), picture(2.0), picture(6.0)]).unwrap();
        // Mean 3, deviations −2, −1, 3: 14/2.
        let found = ["R", "variance.R", "samples"].map(|name| value(&pooled, name));
        assert_eq!(found, [3.0, 7.0, 3.0]);
        let one = pool_equal(&[picture(1.0)]).unwrap();
        assert_eq!((value(&one, "samples"), one.channel("state.x")), (7.0, None));
        assert_eq!(pool_equal(&[]), None);
    }
}
