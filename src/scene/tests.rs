//! The values of validated scenes, and the hash.

use std::path::Path;
use std::time::Duration;

use glam::DVec3;

use super::*;
use crate::config;

const SCENE: &str = r#"[camera]
position = [0, 0, -2]
target = [0, 0, 0]
[volume]
field = { kind = "cloud" }
dims = [8, 8, 8]
[medium]
sigma_max = 40
[method]
kind = "emission-absorption"
"#;

fn scene(text: &str, sets: &[&str]) -> Scene {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    config::parse("s.toml", text, &sets)
        .and_then(|loaded| Scene::from_loaded(&loaded, Path::new("")))
        .unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn defaults() {
    let scene = scene(SCENE, &[]);
    assert_eq!(scene.seed, 1);
    assert_eq!(scene.image, Image { width: 512, height: 512, filter: Filter::Box });
    let kind = CameraKind::Perspective { fov: 40f64.to_radians(), aperture: 0.0, focus: 2.0 };
    assert_eq!(
        scene.camera,
        Camera { position: DVec3::new(0.0, 0.0, -2.0), target: DVec3::ZERO, up: DVec3::Y, kind }
    );
    assert_eq!(scene.camera.forward(), DVec3::Z);
    assert_eq!(
        scene.volume,
        Some(Volume {
            source: VolumeSource::Field { kind: FieldKind::Cloud, dims: [8; 3] },
            spacing: None,
            origin: Origin::Corner(DVec3::ZERO),
            window: None,
        })
    );
    assert_eq!(scene.medium, Medium::Extinction { sigma_max: 40.0 });
    assert_eq!(scene.scattering, ScatteringMedium { albedo: [1.0; 3], extinction_color: None });
    assert_eq!(scene.phase, Phase::Isotropic);
    let Transfer::OneD(transfer) = scene.transfer else { panic!("one-dimensional") };
    assert_eq!((transfer.domain, transfer.colormap, transfer.resolution), (Domain::Normalized, None, 1021));
    assert_eq!(
        transfer.points,
        [0.0, 1.0].map(|value| Point { value, opacity: value, color: None, emission: [0.0; 3] })
    );
    assert_eq!((scene.lights, scene.background), (vec![], Background::Constant([0.0; 3])));
    let method =
        Method::EmissionAbsorption { radiance: 1.0, quadrature: Quadrature::Cell, termination: 0.0009765625 };
    assert_eq!(scene.method, method);
    assert_eq!(
        scene.film,
        FilmSettings { tonemap: Tonemap::Reinhard, exposure: 1.0, gamma: None, auxiliary: false }
    );
    assert_eq!(scene.stop, Stop { samples: Some(16), time: None, error: None });
}

#[test]
fn values_are_resolved() {
    let text = format!(
        "{SCENE}quadrature = \"step\"\n[stop]\ntime = \"2m\"\nerror = \"5%\"\n\
         [[light]]\nkind = \"directional\"\ndirection = [0, -4, 0]\nirradiance = 3\n"
    );
    let sets = ["volume.window={centre = 40, width = 400}", "volume.spacing=0.5", "volume.origin=centre"];
    let scene = scene(&text, &[&sets[..], &["volume.field={kind = \"hydrogen\", n = 2, l = 1}"]].concat());
    assert_eq!(scene.stop, Stop { samples: None, time: Some(Duration::from_secs(120)), error: Some(0.05) });
    let light = Light::Directional { direction: DVec3::NEG_Y, irradiance: [3.0; 3] };
    assert_eq!(scene.lights, [light]);
    let volume = scene.volume.unwrap();
    assert_eq!(volume.window, Some((-160.0, 240.0)));
    assert_eq!((volume.spacing, volume.origin), (Some(DVec3::splat(0.5)), Origin::Centre));
    let kind = FieldKind::Hydrogen { n: 2, l: 1, m: 0, extent: 16.0 };
    assert_eq!(volume.source, VolumeSource::Field { kind, dims: [8; 3] });
    let step = Quadrature::Step { step: 0.5, jitter: true, compositing: Compositing::Exponential };
    assert!(matches!(scene.method, Method::EmissionAbsorption { quadrature, .. } if quadrature == step));
}

#[test]
fn scattering_methods() {
    let single = scene(SCENE, &["method={kind = \"single-scattering\"}"]);
    let defaults = Scattering {
        orders: Orders::Single,
        transmittance: Transmittance::Auto,
        majorant_scale: 1.0,
        paths: None,
    };
    assert_eq!(single.method, Method::Scattering(defaults));
    assert_eq!(method_with("kind = \"multiple-scattering\"").orders, Orders::Multiple { max: None });
    let given = "kind = \"multiple-scattering\", max_order = 8, transmittance = \"residual-ratio\", \
                 majorant_scale = 2, paths = 4";
    let expected = Scattering {
        orders: Orders::Multiple { max: Some(8) },
        transmittance: Transmittance::ResidualRatio,
        majorant_scale: 2.0,
        paths: Some(4),
    };
    assert_eq!(method_with(given), expected);
}

fn method_with(keys: &str) -> Scattering {
    match scene(SCENE, &[&format!("method={{{keys}}}")]).method {
        Method::Scattering(settings) => settings,
        other => panic!("{other:?}"),
    }
}

#[test]
fn scattering_media() {
    let medium = |sets: &[&str]| scene(SCENE, sets).scattering;
    assert_eq!(medium(&["medium.albedo=0.9"]).albedo, [0.9; 3]);
    assert_eq!(medium(&["medium={mode = \"opacity\", albedo = [1, 0.5, 0]}"]).albedo, [1.0, 0.5, 0.0]);
    let coloured = medium(&["medium.extinction_color=[0, 0.8, 2]"]);
    assert_eq!(coloured.extinction_color, Some([0.0, 0.8, 2.0]));
    assert_eq!(medium(&["medium.extinction_color=1"]).extinction_color, None, "1 changes nothing");
    let phases = [
        ("isotropic\"", Phase::Isotropic),
        ("henyey-greenstein\", g = -0.999", Phase::HenyeyGreenstein { g: -0.999 }),
        ("rayleigh\"", Phase::Rayleigh),
        ("two-lobe\", g = [0.9, -0.3], weight = 0.7", Phase::TwoLobe { g: [0.9, -0.3], weight: 0.7 }),
    ];
    for (text, phase) in phases {
        assert_eq!(scene(SCENE, &[&format!("phase={{kind = \"{text}}}")]).phase, phase);
    }
}

#[test]
fn emission_of_points_and_shapes() {
    let points =
        "transfer.points=[{ value = 0, opacity = 1 }, { value = 1, opacity = 1, emission = [3, 2, 0] }]";
    let Transfer::OneD(transfer) = scene(SCENE, &[points]).transfer else { panic!("one-dimensional") };
    assert_eq!([transfer.points[0].emission, transfer.points[1].emission], [[0.0; 3], [3.0, 2.0, 0.0]]);
    let shape = "{ shape = \"ellipse\", centre = [0.5, 0.5], size = [1, 1], emission = 7 }";
    let Transfer::TwoD(Transfer2d { table: Table2d::Shapes { shapes, .. }, .. }) =
        scene(SCENE, &[&format!("transfer={{kind = \"2d\", shapes = [{shape}]}}")]).transfer
    else {
        panic!("two-dimensional")
    };
    assert_eq!(shapes[0].emission, [7.0; 3]);
}

#[test]
fn rectangle_lights() {
    let keys = "centre = [0, 3, 0]\nedge_u = [0, 0, 2]\nedge_v = [4, 0, 0]\nradiance = [5, 4, 3]";
    let light = Light::Rectangle {
        centre: DVec3::new(0.0, 3.0, 0.0),
        edge_u: DVec3::new(0.0, 0.0, 2.0),
        edge_v: DVec3::new(4.0, 0.0, 0.0),
        radiance: [5.0, 4.0, 3.0],
    };
    assert_eq!(scene(&format!("{SCENE}[[light]]\nkind = \"rectangle\"\n{keys}\n"), &[]).lights, [light]);
}

#[test]
fn without_points_the_ramp_runs_over_the_window_in_either_domain() {
    let scene = scene(SCENE, &["transfer.domain=data"]);
    assert!(matches!(scene.transfer, Transfer::OneD(Transfer1d { domain: Domain::Normalized, .. })));
}

#[test]
fn the_hash_ignores_what_does_not_change_the_pixels() {
    let base = scene(SCENE, &[]);
    assert_eq!(base.hash.len(), 32);
    assert!(base.hash.bytes().all(|b| b.is_ascii_hexdigit()));
    let reordered = "# a comment\nseed = 1\n[method]\nkind = \"emission-absorption\"\n[volume]\ndims = [8, 8, 8]\n\
                     field.kind = \"cloud\"\n[medium]\nmode = \"extinction\"\nsigma_max = 40.0\n\
                     [camera]\ntarget = [0.0, 0.0, 0.0]\nkind = \"perspective\"\nposition = [0, 0, -2]\n";
    assert_eq!(scene(reordered, &[]).hash, base.hash);
    for set in ["stop.samples=999", "stop.time=1h", "film.exposure=3", "film.tonemap=linear"] {
        assert_eq!(scene(SCENE, &[set]).hash, base.hash, "{set}");
    }
    let scattering = "method={kind = \"single-scattering\"}";
    let auxiliary = scene(SCENE, &[scattering, "film.auxiliary=true"]);
    assert!(auxiliary.film.auxiliary);
    assert_eq!(auxiliary.hash, scene(SCENE, &[scattering]).hash);
    let colours = ["background.color=1", "background.color=[1, 1, 1]", "background.color=\"#ffffff\""];
    let hashes = colours.map(|set| scene(SCENE, &[set]).hash);
    assert!(hashes.iter().all(|hash| *hash == hashes[0]));
}

#[test]
fn the_hash_covers_what_changes_the_pixels() {
    let mut hashes = vec![scene(SCENE, &[]).hash];
    let sets = [
        "seed=2",
        "image.width=511",
        "image.filter=point",
        "camera.fov=41",
        "camera.position=[0, 0, -2.0000000001]",
        "volume.dims=[8, 8, 9]",
        "volume.spacing=2",
        "medium.sigma_max=41",
        "transfer.resolution=1023",
        "transfer.colormap=hot",
        "background.color=0.5",
        "method.radiance=2",
        "method.termination=0",
        "method={kind = \"mip\"}",
        "method={kind = \"single-scattering\"}",
        "method={kind = \"multiple-scattering\"}",
        "method={kind = \"multiple-scattering\", max_order = 8}",
        "method={kind = \"multiple-scattering\", transmittance = \"ratio\"}",
        "method={kind = \"multiple-scattering\", majorant_scale = 2}",
        "method={kind = \"multiple-scattering\", paths = 2}",
        "medium.albedo=0.5",
        "medium.extinction_color=[1, 0.8, 0.5]",
        "phase.kind=rayleigh",
        "phase={kind = \"henyey-greenstein\", g = 0.5}",
        "phase={kind = \"henyey-greenstein\", g = -0.5}",
    ];
    hashes.extend(sets.iter().map(|set| scene(SCENE, &[set]).hash));
    let count = hashes.len();
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), count);
}

#[test]
fn seeds_differ_in_the_hash_only() {
    let [a, b] = ["seed=1", "seed=2"].map(|set| scene(SCENE, &[set]));
    assert_ne!(a.hash, b.hash);
    assert_eq!(a.seedless_hash, b.seedless_hash);
    assert_ne!(a.seedless_hash, scene(SCENE, &["image.width=3"]).seedless_hash);
}

#[test]
fn a_turntable_turns_about_the_target() {
    let table = "camera.turntable={frames = 4, angle = 360}";
    let turned = scene(SCENE, &["camera.position=[1, 0, -2]", "camera.target=[1, 0, 0]", table]);
    let positions: Vec<_> = turned.views.iter().map(|view| view.camera.position.to_array()).collect();
    // Counterclockwise as seen from +y: from −z to −x, +z, +x.
    let exact = [[1.0, 0.0, -2.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 2.0], [3.0, 0.0, 0.0]];
    for (found, exact) in positions.iter().zip(exact) {
        assert!(found.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} {exact:?}");
    }
    assert_eq!(turned.camera, turned.views[0].camera);
    assert!(turned.views.iter().all(|view| view.camera.up == turned.camera.up));
    let half = scene(SCENE, &["camera.turntable={frames = 3, angle = -90, axis = [1, 0, 0]}"]);
    let third = half.views[2].camera.position;
    let exact = [0.0, -2.0 * f64::sin(60_f64.to_radians()), -2.0 * f64::cos(60_f64.to_radians())];
    assert!((third - glam::DVec3::from_array(exact)).length() < 1e-12, "{third}");
}

#[test]
fn views_replace_what_they_name() {
    let sets = ["camera.views=[{}, {position = [0, 3, 0], up = [1, 0, 0]}, {target = [0, 1, 0]}]"];
    let scene = scene(SCENE, &sets);
    let places: Vec<_> =
        scene.views.iter().map(|v| (v.camera.position.to_array(), v.camera.target.y)).collect();
    assert_eq!(places, [([0.0, 0.0, -2.0], 0.0), ([0.0, 3.0, 0.0], 0.0), ([0.0, 0.0, -2.0], 1.0)]);
    assert_eq!(scene.views[1].camera.up, glam::DVec3::X);
}

#[test]
fn a_view_is_the_scene_with_its_camera_alone() {
    let alone = scene(SCENE, &["camera.position=[0, 3, 1]"]);
    let both = scene(SCENE, &["camera.views=[{}, {position = [0, 3, 1]}]"]);
    assert_eq!(both.hash, scene(SCENE, &[]).hash);
    assert_eq!(both.of_view(&both.views[1]), alone);
    // Light knows no camera.
    assert_eq!(both.light_hash, alone.light_hash);
    let others = ["seed=2", "medium.sigma_max=41", "light=[]", "background.color=0.5", "volume.spacing=2"];
    let differs = |set: &&str| scene(SCENE, &[set]).light_hash != alone.light_hash;
    assert_eq!(others.iter().filter(|set| differs(set)).count(), 4, "all but the empty list of lights");
}

#[test]
fn methods_of_light_volumes_have_their_defaults() {
    let method = |set: &str| match scene(SCENE, &[set]).method {
        Method::LightVolume(settings) => settings,
        other => panic!("{other:?}"),
    };
    let hybrid = method("method={kind = \"hybrid-diffusion\", coarsening = 2}");
    assert_eq!((hybrid.coarsening, hybrid.direct_coarsening), (2, 1));
    assert_eq!(hybrid.direct, DirectLight::Tracking { estimates: 32 });
    assert!(matches!(
        hybrid.scattered,
        ScatteredLight::Steady(Steady { solver: DiffusionSolver::Multigrid, .. })
    ));
    let paper =
        method("method={kind = \"hybrid-diffusion\", model = \"paper\", iterations = 7, coarsening = 2}");
    assert!(matches!(paper.scattered, ScatteredLight::Steps { count: Some(7), .. }));
    assert_eq!((paper.coarsening, paper.direct_coarsening), (2, 2));
    let convection = method("method={kind = \"convection-diffusion\"}");
    assert!(matches!(
        convection.scattered,
        ScatteredLight::Steps { count: None, courant: 0.5, spreading: 0.1 }
    ));
}
