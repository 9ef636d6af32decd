//! Whole scenes against the plain path tracer in double precision, block by block.

mod common;

use common::scattering::{Twin, compare_blocks, write_map};
use common::{Case, noisy, smooth};
use svetlo::volume::Volume;

const SIDE: usize = 24;

/// The medium, filling the picture: blocks that few paths reach would have no errors to speak of.
fn view(from: [f64; 3]) -> String {
    format!(
        "[image]\nwidth = {SIDE}\nheight = {SIDE}\n[camera]\nposition = {from:?}\ntarget = [3.5, 4.5, 4]\nfov = 15\n\
         [volume]\nspacing = [1, 1.2, 0.9]\nwindow = {{ lo = 0, hi = 1 }}\n"
    )
}

const OUTSIDE: [f64; 3] = [19.0, 16.0, -14.0];
const DIMS: [usize; 3] = [7, 8, 9];

const LIGHTS: &str = "[[light]]\nkind = \"point\"\nposition = [14, 9, 2]\nintensity = [200, 100, 50]\n\
                      [[light]]\nkind = \"directional\"\ndirection = [0.3, -1, 0.8]\nirradiance = [1, 2, 3]\n\
                      [[light]]\nkind = \"rectangle\"\ncentre = [3, 12, 1]\nedge_u = [6, 0, 1]\nedge_v = [0, -1, 5]\n\
                      radiance = [0.5, 1, 4]\n";

const TWO_D: &str = "[transfer]\nkind = \"2d\"\nresolution = [9, 7]\ngradient_max = 0.6\nshapes = [\n\
                     { shape = \"ellipse\", centre = [0.5, 0.4], size = [0.9, 0.9], color = [0.9, 0.8, 0.3], opacity = 0.9, softness = 0.7 },\n\
                     { shape = \"triangle\", centre = [0.7, 0.5], size = [0.5, 1], color = [0.2, 0.6, 1], opacity = 0.7, softness = 0.3 }]\n";

const ONE_D: &str = "[transfer]\nresolution = 6\npoints = [{ value = 0.2, opacity = 0, color = [1, 0.3, 0.1] },\n\
                     { value = 0.6, opacity = 0.9, color = [0.9, 0.9, 0.5] }, { value = 0.8, opacity = 0.2, color = [0.1, 0.8, 1] }]\n";

/// The kernels' pictures of a scene are the twin's, in 9 blocks of 3 channels, each of 5120 of the twin's paths:
/// fewer would leave rare, bright ones out of its error. `variants` replace a word of the scene and
/// must not change what it looks like.
#[track_caller]
fn same(what: &str, text: &str, volume: fn() -> Volume, word: &str, variants: &[&str]) {
    let case = Case::new(text, volume());
    let twin = Twin::new(&case).image(80);
    for variant in variants {
        assert!(text.contains(word), "{word:?} is in the scene");
        let case = Case::new(&text.replace(word, variant), volume());
        compare_blocks(
            &format!("{what}, {}", variant.replace('\n', ", ")),
            &case.film_of(128),
            &twin,
            SIDE,
            3,
        );
    }
}

#[test]
fn two_dimensional_transfer_functions_under_all_lights() {
    let folder = tempfile::tempdir().unwrap();
    let map = write_map(folder.path(), 8, 4, |x, y| {
        // A bright spot in a dim, coloured sky.
        let spot = if (x, y) == (2, 1) { 12.0 } else { 0.0 };
        [0.2 + spot, 0.3 + 0.1 * x as f32 + spot, 0.9 - 0.2 * y as f32 + spot]
    });
    for order in ["single", "multiple"] {
        let text = format!(
            "{}{TWO_D}[medium]\nsigma_max = 0.9\nalbedo = [0.95, 0.9, 0.8]\n\
             [phase]\nkind = \"two-lobe\"\ng = [0.8, -0.4]\nweight = 0.7\n{LIGHTS}\
             [background]\nenvironment = '{}'\nrotation = 70\nintensity = 0.7\nsampling = \"auto\"\n\
             [method]\nkind = \"{order}-scattering\"\n",
            view(OUTSIDE),
            map.display()
        );
        same(order, &text, || smooth(DIMS, 3), "\"auto\"", &["\"importance\"", "\"escape\""]);
    }
}

#[test]
fn estimators_of_transmittance_make_the_same_picture() {
    let text = format!(
        "{}{ONE_D}[medium]\nsigma_max = 0.8\nalbedo = 0.9\n[phase]\nkind = \"henyey-greenstein\"\ng = 0.6\n{LIGHTS}\
         [method]\nkind = \"multiple-scattering\"\ntransmittance = \"auto\"\n",
        view(OUTSIDE)
    );
    let variants =
        ["\"analog\"", "\"ratio\"\nmajorant_scale = 1.5", "\"residual-ratio\"", "\"auto\"\npaths = 5"];
    same("estimators", &text, || noisy(DIMS, 7), "\"auto\"", &variants);
}

#[test]
fn channels_with_their_own_extinction() {
    for order in ["single", "multiple"] {
        let text = format!(
            "{}{ONE_D}[medium]\nsigma_max = 0.8\nalbedo = [0.7, 0.9, 0.99]\nextinction_color = [1, 0.5, 0.15]\n\
             [phase]\nkind = \"rayleigh\"\n{LIGHTS}[background]\ncolor = [0.2, 0.5, 1]\n[method]\nkind = \"{order}-scattering\"\n",
            view(OUTSIDE)
        );
        same(&format!("{order}, chromatic"), &text, || noisy(DIMS, 7), "", &[""]);
    }
}

#[test]
fn channels_that_do_not_see_the_medium() {
    let text = format!(
        "{}{ONE_D}[medium]\nsigma_max = 0.8\nextinction_color = [0, 3, 0.5]\n{LIGHTS}[background]\ncolor = [0.2, 0.5, 1]\n\
         [method]\nkind = \"multiple-scattering\"\n",
        view(OUTSIDE)
    );
    same("one channel clear", &text, || smooth(DIMS, 5), "", &[""]);
}

#[test]
fn media_that_glow() {
    let glowing = "[transfer]\nresolution = 6\npoints = [{ value = 0.2, opacity = 0, color = [1, 0.3, 0.1] },\n\
                   { value = 0.6, opacity = 0.9, color = [0.9, 0.9, 0.5], emission = [3, 1, 0] },\n\
                   { value = 0.8, opacity = 0.4, color = 0, emission = [0, 0, 5] }]\n";
    for (order, medium) in [
        ("single", ""),
        ("multiple", ""),
        ("multiple", "extinction_color = [1, 0.4, 2]\n"),
        ("multiple", "albedo = 0\n"),
    ] {
        let text = format!(
            "{}{glowing}[medium]\nsigma_max = 0.7\n{medium}[phase]\nkind = \"henyey-greenstein\"\ng = -0.3\n\
             [method]\nkind = \"{order}-scattering\"\n",
            view(OUTSIDE)
        );
        same(&format!("glow, {order}, {medium:?}"), &text, || noisy(DIMS, 9), "", &[""]);
    }
}

#[test]
fn cut_orders_and_opacity_media() {
    for orders in [2, 4] {
        let text = format!(
            "{}{ONE_D}[medium]\nmode = \"opacity\"\nreference_length = 1.5\nalbedo = 0.97\n[background]\ncolor = 0.5\n{LIGHTS}\
             [method]\nkind = \"multiple-scattering\"\nmax_order = {orders}\n",
            view(OUTSIDE)
        );
        same(&format!("{orders} orders"), &text, || smooth(DIMS, 11), "", &[""]);
    }
}

#[test]
fn cameras_inside_see_rectangles_in_the_medium() {
    let text = format!(
        "{}{ONE_D}[medium]\nsigma_max = 0.5\n{LIGHTS}[[light]]\nkind = \"rectangle\"\ncentre = [5, 5, 6]\n\
         edge_u = [3, 0, 0]\nedge_v = [0, -3, 0.5]\nradiance = 2\n[background]\ncolor = [0.1, 0.2, 0.3]\n\
         [method]\nkind = \"multiple-scattering\"\n",
        view([3.0, 4.0, 2.0]).replace("target = [3.5, 4.5, 4]\nfov = 15", "target = [5, 5, 6]\nfov = 80")
    );
    same("inside", &text, || noisy(DIMS, 13), "", &[""]);
}
