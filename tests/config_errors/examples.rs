//! Every construct of the scene language, in scenes that must load.

use svetlo::config;
use svetlo::scene::Scene;

use super::{SCENE, read};

/// Name and text; what a text leaves out of camera, volume, medium and method is added by [`with_rest`].
pub const EXAMPLES: [(&str, &str); 29] = [
    ("image", "seed = 18446744073709551615\n[image]\nwidth = 640\nheight = 480\nfilter = \"point\"\n"),
    (
        "thin lens",
        "[camera]\nkind = \"perspective\"\nposition = [0.5, 0.5, -2.0]\ntarget = [0.5, 0.5, 0.5]\n\
         up = [0, 1, 0]\nfov = 35.0\naperture = 0.0\nfocus = 2.5\n",
    ),
    (
        "orthographic",
        "[camera]\nkind = \"orthographic\"\nposition = [0, 0, -2]\ntarget = [0, 0, 0]\nheight = 1.2\n",
    ),
    (
        "placement",
        "[volume]\nfield = { kind = \"constant\", value = 1.0 }\ndims = [4, 4, 4]\nspacing = [1, 1, 2.5]\n\
         origin = \"centre\"\nwindow = { lo = 0, hi = 255 }\n",
    ),
    (
        "level window",
        "[volume]\nfield = { kind = \"ramp\", from = 1.0, to = 5.0, axis = \"z\" }\ndims = [4, 4, 4]\n\
         spacing = 0.5\norigin = [0, 0, 0]\nwindow = { centre = 40, width = 400 }\n",
    ),
    (
        "sphere",
        "[volume]\ndims = [4, 4, 4]\nfield = { kind = \"sphere\", centre = [0.5, 0.5, 0.5], radius = 0.3 }
",
    ),
    (
        "marschner-lobb",
        "[volume]\ndims = [4, 4, 4]\nfield = { kind = \"marschner-lobb\", frequency = 6, alpha = 0.25 }\n",
    ),
    (
        "shepp-logan",
        "[volume]\ndims = [4, 4, 4]\nfield = { kind = \"shepp-logan\", rotation = \"own-axis\" }\n",
    ),
    (
        "hydrogen",
        "[volume]\ndims = [4, 4, 4]\nfield = { kind = \"hydrogen\", n = 3, l = 2, m = -1, extent = 20 }\n",
    ),
    ("opacity medium", "[medium]\nmode = \"opacity\"\nreference_length = 1.0\n"),
    ("extinction medium", "[medium]\nmode = \"extinction\"\nsigma_max = 0\n"),
    (
        "points",
        "[transfer]\nkind = \"1d\"\ndomain = \"normalized\"\ncolormap = \"viridis\"\nresolution = 1024\n\
         points = [ { value = 0.0, opacity = 0.0, color = [1,1,1] }, { value = 1.0, opacity = 1.0 } ]\n",
    ),
    (
        "points in data units",
        "[transfer]\ndomain = \"data\"\n[[transfer.points]]\nvalue = -1000\nopacity = 0\ncolor = \"#ff8000\"\n\
         [[transfer.points]]\nvalue = 3000\nopacity = 1\ncolor = 0.5\n",
    ),
    (
        "shapes",
        "[transfer]\nkind = \"2d\"\nresolution = [256, 128]\ngradient_max = 0.1\nshapes = [\n\
         { shape = \"rectangle\", centre = [0.5, 0.3], size = [0.2, 0.4], color = 1, opacity = 0.8, softness = 0.1 },\n\
         { shape = \"ellipse\", centre = [0.5, 0.3], size = [0.2, 0.4] },\n\
         { shape = \"triangle\", centre = [0.5, 0.3], size = [0.2, 0.4] },\n]\n",
    ),
    ("colour background", "[background]\ncolor = [1, 1, 1]\n"),
    (
        "lights",
        "[[light]]\nkind = \"point\"\nposition = [1, 2, 3]\nintensity = 5\n[[light]]\nkind = \"directional\"\n\
         direction = [-1, -1, -1]\nirradiance = \"#ffeedd\"\n",
    ),
    (
        "step",
        "[method]\nkind = \"emission-absorption\"\nradiance = 1.0\nquadrature = \"step\"\nstep = 0.5\njitter = true\n\
         compositing = \"linear\"\ntermination = 0.0009765625\n",
    ),
    ("mip", "[method]\nkind = \"mip\"\ncolormap = \"turbo\"\n"),
    (
        "isosurface",
        "[method]\nkind = \"isosurface\"\nvalue = 300\ndomain = \"data\"\ncolor = [0.8,0.8,0.8]\nambient = 0.1\n\
         diffuse = 0.9\nspecular = 0.2\nshininess = 32\n",
    ),
    (
        "scattering medium",
        "[medium]\nsigma_max = 40\nalbedo = 0.9\nextinction_color = [1, 0.8, 0.5]\n[phase]\nkind = \"two-lobe\"\n\
         g = [0.9, -0.3]\nweight = 0.7\n[method]\nkind = \"multiple-scattering\"\n",
    ),
    ("rayleigh", "[medium]\nmode = \"opacity\"\nalbedo = \"#ff8000\"\n[phase]\nkind = \"rayleigh\"\n"),
    ("isotropic", "[phase]\n"),
    (
        "single scattering",
        "[method]\nkind = \"single-scattering\"\ntransmittance = \"ratio\"\nmajorant_scale = 2\npaths = 4\n\
         [phase]\nkind = \"henyey-greenstein\"\ng = 0.9\n[film]\nauxiliary = true\n",
    ),
    (
        "multiple scattering",
        "[method]\nkind = \"multiple-scattering\"\nmax_order = 8\ntransmittance = \"residual-ratio\"\n\
         majorant_scale = 1.5\npaths = 1\n",
    ),
    (
        "rectangle light",
        "[[light]]\nkind = \"rectangle\"\ncentre = [0, 3, 0]\nedge_u = [0, 0, 2]\nedge_v = [2, 0, 0]\nradiance = 5\n",
    ),
    (
        "emission",
        "[transfer]\npoints = [ { value = 0.0, opacity = 0.0 }, { value = 1.0, opacity = 1.0, emission = [8, 4, 1] } ]\n",
    ),
    ("film", "[film]\ntonemap = \"filmic\"\nexposure = 2\ngamma = 2.2\n"),
    ("stop", "[stop]\nsamples = 16\ntime = \"30s\"\nerror = \"1%\"\n"),
    ("stop by fraction", "[stop]\ntime = \"500ms\"\nerror = 0.01\n"),
];

/// The text with the tables of the valid scene that it lacks.
pub fn with_rest(text: &str) -> String {
    SCENE.split_inclusive("\n[").fold(text.to_owned(), |mut all, table| {
        let table = format!("[{}", table.trim_start_matches('[').trim_end_matches('['));
        let header = table.lines().next().unwrap_or_default();
        if !all.contains(header) {
            all.push_str(&table);
        }
        all
    })
}

#[test]
fn every_example_loads() {
    for (name, text) in EXAMPLES {
        if let Err(error) = read(&with_rest(text), &[]) {
            panic!("{name}:\n{error}");
        }
    }
}

#[test]
fn files_are_found_beside_the_scene() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["brain_4x4x4_uint8.raw", "tf2d.png", "studio.exr"] {
        std::fs::write(folder.path().join(name), b"").expect("written");
    }
    let text = with_rest(
        "[volume]\nfile = \"brain_4x4x4_uint8.raw\"\ndims = [4, 4, 4]\ntype = \"uint8\"\nendian = \"big\"\noffset = 0\n\
         [transfer]\nkind = \"2d\"\ntable = \"tf2d.png\"\n\
         [background]\nenvironment = \"studio.exr\"\nintensity = 2\nrotation = 90\nsampling = \"importance\"\n",
    );
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, format!("\u{feff}{text}")).expect("written");
    if let Err(error) = Scene::load(&path, &[]) {
        panic!("{error}");
    }
}

#[test]
fn overrides_create_tables_and_take_bare_words_and_lists() {
    let sets = [
        "image.width=17",
        "transfer.colormap = hot",
        "camera.target=[1, 2, 3]",
        "stop.time=30s",
        "method={ kind = \"mip\" }",
        "volume.dims.2=9",
    ];
    let scene = read(SCENE, &sets).expect("valid");
    assert_eq!(scene.image.width, 17);
    assert_eq!(scene.camera.target.to_array(), [1.0, 2.0, 3.0]);
    assert!(matches!(
        scene.volume.unwrap().source,
        svetlo::scene::VolumeSource::Field { dims: [8, 8, 9], .. }
    ));
    assert!(matches!(scene.method, svetlo::scene::Method::Mip { .. }));
}

#[test]
fn files_that_are_no_scene_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        path
    };
    let cases = [
        (folder.path().join("none.toml"), "there is no such file"),
        (folder.path().to_owned(), "it is a directory"),
        (file("latin.toml", b"a = 1\n# caf\xe9\n"), "it is not UTF-8 text (byte 11, line 2)"),
        (
            file("huge.toml", &vec![b'\n'; (16 << 20) + 1]),
            "it is larger than 16 MiB; a scene is a short TOML text",
        ),
    ];
    for (path, reason) in cases {
        let error = config::load(&path, &[]).expect_err("no scene");
        assert_eq!(error.to_string(), format!("cannot read the scene {}: {reason}", path.display()));
        assert_eq!(error.exit_code(), 2);
    }
}
