//! The model ladder names the cheapest model that will do.

use crate::support::Folder;

/// Climbs the ladder of the sphere.
fn ladder(set: &[&str], more: &[&str]) -> serde_json::Value {
    let folder = Folder::new();
    let sets = ["image.width=32", "image.height=32"];
    let sets = sets.iter().chain(set).flat_map(|set| ["--set", set]);
    let fixed = ["ladder", "scene.toml", "--time", "300ms", "--no-selftest", "--json", "--quiet"];
    let ran = folder.succeed(&fixed.into_iter().chain(sets).chain(more.iter().copied()).collect::<Vec<_>>());
    serde_json::from_str(&ran.out).unwrap()
}

#[test]
fn where_nothing_scatters_every_model_is_right() {
    let ladder = ladder(&["medium.albedo=0", "background.color=1"], &[]);
    let rungs = ladder["rungs"].as_array().unwrap();
    let methods: Vec<&str> = rungs.iter().map(|rung| rung["method"].as_str().unwrap()).collect();
    assert_eq!(methods, ["emission-absorption", "single-scattering", "multiple-scattering"]);
    for rung in rungs {
        // 1 % is a fifth of the tolerance, which the reference was asked for.
        assert!(rung["model_error"]["value"].as_f64().unwrap() < 0.01, "{rung}");
        assert!(rung["seconds_to_tolerance"].as_f64().unwrap() > 0.0, "{rung}");
    }
    assert_eq!(ladder["complete"], true);
    assert!(methods.contains(&ladder["cheapest"].as_str().unwrap()));
}

#[test]
fn where_light_is_scattered_often_only_the_last_is() {
    // A white medium in the sun: single scattering loses what is scattered more than once, and a glow has no shadow.
    let sun = "light=[{kind=\"directional\",direction=[1,-1,1],irradiance=3}]";
    let ladder = ladder(&[sun, "medium.sigma_max=20"], &["--tolerance", "2%"]);
    assert_eq!(ladder["cheapest"], "multiple-scattering");
    let single = &ladder["rungs"][1];
    assert!(single["model_error"]["low"].as_f64().unwrap() > 0.05, "{single}");
    assert!(single["seconds_to_tolerance"].is_null());
    assert_eq!(ladder["rungs"][2]["model_error"]["value"], 0.0);
}

#[test]
fn a_dark_scene_is_refused() {
    let folder = Folder::new();
    let ran = folder.run(&["ladder", "scene.toml", "--time", "100ms", "--no-selftest", "--quiet"]);
    ran.fails_with(2, "no light reaches the camera by scattering");
}
