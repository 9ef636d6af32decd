"""The caustic of a glass sphere: svetlo's photons beside Mitsuba's light tracer, time against error, in one run.

    cargo build --release
    python3 -m venv venv && venv/bin/pip install mitsuba numpy
    venv/bin/python benches/peers/mitsuba_caustic.py REFERENCE.npz [--svetlo target/release/svetlo] [--rounds 3]

REFERENCE.npz holds `mean` and `var` (512 x 512, one channel, variance of one sample) and `spp` of a long render of the
scene of configs/glass_sphere.toml. The error is relMSE over the points of the plane within 0.6 of the axis, with the
reference's variance taken out: mean of ((x - r)^2 - var / spp) / (r^2 + (0.1 mean r)^2). Wall times of whole processes for
svetlo (start, build from the cache and writing included), of rendering alone for Mitsuba.
"""

import argparse
import json
import os
import subprocess
import tempfile
import time

import mitsuba as mi
import numpy as np

SAMPLES = [1, 2, 4, 8, 16, 32]
LIGHT_TRACER_SAMPLES = [16, 64, 256]


def region():
    """Pixels that see the plane within 0.6 of the axis, past the sphere."""
    forward = np.array([0, 4, -2.8])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    across = (2 * (np.arange(512) + 0.5) / 512 - 1) * np.tan(np.radians(20))
    x, y = np.meshgrid(across, -across)
    ray = forward + x[..., None] * right + y[..., None] * up
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    eye = np.array([0, -4, 3.0])
    point = eye + (-eye[2] / ray[..., 2])[..., None] * ray
    to_eye = eye - np.array([0, 0, 0.8])
    along = (ray * to_eye).sum(-1)
    sphere = along * along - (to_eye @ to_eye - 0.25) > 0
    return (ray[..., 2] < 0) & ~sphere & (np.hypot(point[..., 0], point[..., 1]) < 0.6)


def light_tracer(samples, seed):
    scene = light_tracer.scene
    start = time.perf_counter()
    picture = np.array(mi.render(scene, spp=samples, seed=seed), dtype=np.float64)[..., 0]
    return time.perf_counter() - start, picture


def load_peer():
    mi.set_variant("llvm_ad_rgb")
    transform = mi.ScalarTransform4f
    look = transform().look_at(origin=[0, -4, 3], target=[0, 0, 0.2], up=[0, 0, 1])
    film = {"type": "hdrfilm", "width": 512, "height": 512, "component_format": "float32", "pixel_format": "rgb",
            "rfilter": {"type": "box"}}
    light_tracer.scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "ptracer", "max_depth": 8, "rr_depth": 100},
        "sensor": {"type": "perspective", "fov": 40.0, "fov_axis": "x", "to_world": look, "film": film,
                   "sampler": {"type": "independent"}},
        "light": {"type": "point", "position": [0, 0, 4], "intensity": {"type": "rgb", "value": 10.0}},
        "plane": {"type": "rectangle", "to_world": transform().scale([5, 5, 1]),
                  "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.8}}},
        "sphere": {"type": "sphere", "center": [0, 0, 0.8], "radius": 0.5,
                   "bsdf": {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}},
    })
    light_tracer(1, 0)


def green(path):
    bitmap = mi.Bitmap(path)
    names = [field.name for field in bitmap.struct_()]
    return np.array(bitmap)[..., names.index("G")].astype(np.float64)


def photons(svetlo, samples, seed, folder):
    path = os.path.join(folder, "caustic.exr")
    command = [svetlo, "render", "configs/glass_sphere.toml", "-o", path, "--samples", str(samples), "--seed", str(seed),
               "--json"]
    start = time.perf_counter()
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    wall = time.perf_counter() - start
    return wall, json.loads(done.stdout)["seconds"]["device"], green(path)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("reference")
    arguments.add_argument("--svetlo", default="target/release/svetlo")
    arguments.add_argument("--rounds", type=int, default=3)
    options = arguments.parse_args()
    data = np.load(options.reference)
    mask = region()
    r = data["mean"].astype(np.float64)[mask]
    noise = data["var"].astype(np.float64)[mask] / float(data["spp"])
    weight = 1 / (r**2 + (0.1 * r.mean()) ** 2)

    def error(picture):
        return float((((picture[mask] - r) ** 2 - noise) * weight).mean())

    load_peer()
    print(f"reference mean {r.mean():.5f} over {mask.sum()} pixels; one line a round")
    print("renderer      samples   wall s  device s   relMSE     mean")
    with tempfile.TemporaryDirectory() as folder:
        photons(options.svetlo, 1, 1, folder)
        for turn in range(options.rounds):
            for samples in SAMPLES:
                wall, device, picture = photons(options.svetlo, samples, 1 + turn, folder)
                print(f"svetlo       {samples:8} {wall:8.3f} {device:9.3f} {error(picture):8.5f} {picture[mask].mean():8.5f}")
            for samples in LIGHT_TRACER_SAMPLES:
                wall, picture = light_tracer(samples, 1 + turn)
                print(f"light tracer {samples:8} {wall:8.3f}         - {error(picture):8.5f} {picture[mask].mean():8.5f}")


if __name__ == "__main__":
    main()
