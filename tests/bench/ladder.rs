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
    let all = [
        "emission-absorption",
        "single-scattering",
        "convection-diffusion",
        "hybrid-diffusion",
        "multiple-scattering",
    ];
    assert_eq!(methods, all);
    assert_eq!(ladder["left_out"], serde_json::json!([]));
    for rung in rungs {
        // 1 % is a fifth of the tolerance, which the references were asked for.
        for error in ["model_error", "single_error"] {
            assert!(rung[error]["value"].as_f64().unwrap() < 0.01, "{rung}");
        }
        let lit = rung["method"].as_str().unwrap().ends_with("diffusion");
        assert_eq!(rung["light_seconds"].as_f64().unwrap() > 0.0, lit, "{rung}");
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
    assert_eq!(single["single_error"]["value"], 0.0);
    // Diffusion knows of what is scattered often; steps in time that move light out of the cells do not.
    let error = |rung: usize| ladder["rungs"][rung]["model_error"]["value"].as_f64().unwrap();
    assert!(error(3) < 0.5 * error(1) && error(3) < error(2), "{ladder}");
    assert_eq!(error(4), 0.0);
    assert!(ladder["rungs"][4]["single_error"]["low"].as_f64().unwrap() > 0.05, "{ladder}");
}

#[test]
fn a_model_that_the_lights_do_not_allow_is_left_out() {
    let window = "light=[{kind=\"rectangle\",centre=[0.5,2,0.5],edge_u=[1,0,0],edge_v=[0,0,1],radiance=9}]";
    let folder = Folder::new();
    let ran = folder.succeed(&[
        "ladder",
        "scene.toml",
        "--time",
        "50ms",
        "--no-selftest",
        "--quiet",
        "--set",
        window,
    ]);
    assert!(ran.out.contains("convection-diffusion left out: `light.0` is a rectangle"), "{}", ran.out);
    for column in ["vs multiple", "vs single", "light s", "itself"] {
        assert!(ran.out.contains(column), "{}", ran.out);
    }
    assert_eq!(ran.out.lines().count(), 1 + 4 + 1 + 1, "{}", ran.out);
}

#[test]
fn a_dark_scene_is_refused() {
    let folder = Folder::new();
    let ran = folder.run(&["ladder", "scene.toml", "--time", "100ms", "--no-selftest", "--quiet"]);
    ran.fails_with(2, "no light reaches the camera by scattering");
}
