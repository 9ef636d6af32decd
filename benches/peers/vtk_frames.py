"""Frame times of VTK's volume mappers on the scenes of `benches/frames.rs`, to be run beside it on the same machine.

    python3 -m venv venv && venv/bin/pip install vtk numpy OpenEXR
    apt-get install libosmesa6                       # VTK's off-screen GL
    svetlo render benches/scenes/cloud.toml -o cloud.exr --set method.termination=0
    venv/bin/python benches/peers/vtk_frames.py cloud.exr [bonsai_256x256x256_uint8.raw.gz]

The cloud's error is against that picture, whose own error is below 2e-6 RMSE.
"""

import gzip
import os
import sys
import time

os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")

import numpy as np
import OpenEXR
import vtk
from vtk.util import numpy_support

FRAMES = 9


def cloud():
    n = 128
    a = (np.arange(n) + 0.5) / n
    z, y, x = np.meshgrid(a, a, a, indexing="ij")
    r = np.sqrt((x - 0.5) ** 2 + (y - 0.5) ** 2 + (z - 0.5) ** 2)
    wave = np.sin(12 * np.pi * x) * np.sin(9 * np.pi * y) * np.sin(7 * np.pi * z)
    return (np.maximum(0, 1 - r / 0.4) * (0.5 + 0.5 * wave)).astype(np.float32)


def image(voxels, spacing):
    data = vtk.vtkImageData()
    data.SetDimensions(*reversed(voxels.shape))
    data.SetSpacing(spacing, spacing, spacing)
    data.SetOrigin(spacing / 2, spacing / 2, spacing / 2)
    data.GetPointData().SetScalars(numpy_support.numpy_to_vtk(voxels.ravel(), deep=True))
    return data


def mapper(kind, data, step):
    if kind == "gpu":
        result = vtk.vtkGPUVolumeRayCastMapper()
        result.UseJitteringOff()
    else:
        result = vtk.vtkFixedPointVolumeRayCastMapper()
        result.SetInteractiveSampleDistance(step)
        result.SetImageSampleDistance(1.0)
        result.SetNumberOfThreads(os.cpu_count())
        result.IntermixIntersectingGeometryOff()
    result.SetInputData(data)
    result.AutoAdjustSampleDistancesOff()
    result.SetSampleDistance(step)
    return result


def frames(kind, voxels, spacing, step, opacity, color, unit, camera, size):
    """Median, least and largest milliseconds of a frame, and the last frame as floats in [0, 1], top row first."""
    prop = vtk.vtkVolumeProperty()
    points = vtk.vtkPiecewiseFunction()
    for value, alpha in opacity:
        points.AddPoint(value, alpha)
    colors = vtk.vtkColorTransferFunction()
    for value, rgb in color:
        colors.AddRGBPoint(value, *rgb)
    prop.SetScalarOpacity(points)
    prop.SetColor(colors)
    prop.SetScalarOpacityUnitDistance(unit)
    prop.SetInterpolationTypeToLinear()
    prop.ShadeOff()
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper(kind, image(voxels, spacing), step))
    volume.SetProperty(prop)
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.AddVolume(volume)
    view = renderer.GetActiveCamera()
    position, target, up, fov = camera
    view.SetPosition(*position)
    view.SetFocalPoint(*target)
    view.SetViewUp(*up)
    view.SetViewAngle(fov)
    renderer.ResetCameraClippingRange()
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(size, size)
    window.AddRenderer(renderer)
    window.Render()
    times = []
    buffer = vtk.vtkUnsignedCharArray()
    for _ in range(FRAMES):
        view.Azimuth(1e-9)
        volume.Modified()
        start = time.perf_counter()
        window.Render()
        window.GetRGBACharPixelData(0, 0, size - 1, size - 1, 1, buffer)
        times.append(1e3 * (time.perf_counter() - start))
    pixels = numpy_support.vtk_to_numpy(buffer).reshape(size, size, 4)[::-1, :, :3] / 255.0
    return np.median(times), min(times), max(times), pixels


def row(name, result, reference=None):
    error = "" if reference is None else f"{np.sqrt(np.mean((result[3][:, :, 0] - reference) ** 2)):9.1e}"
    print(f"{name:<26} {result[0]:9.2f} {result[1]:8.2f} {result[2]:8.2f} {error}")


def main():
    print(f"{vtk.vtkVersion().GetVTKSourceVersion()}\n{'case':<26} {'median ms':>9} {'min ms':>8} {'max ms':>8} {'RMSE':>9}")
    channels = OpenEXR.File(sys.argv[1], separate_channels=True).channels()
    reference = np.array(channels["R"].pixels)
    density = cloud()
    unit = 1 / 128
    opacity = [(v, 1 - np.exp(-40 * v * unit)) for v in np.linspace(0, 1, 2049)]
    black = [(0, (0, 0, 0)), (1, (0, 0, 0))]
    camera = ((0.5, 0.5, -2), (0.5, 0.5, 0.5), (0, 1, 0), 35)
    for kind, step in (("fixed", unit), ("fixed", unit / 2), ("gpu", unit / 2)):
        result = frames(kind, density, unit, step, opacity, black, unit, camera, 256)
        row(f"cloud 256², {kind}, step {step * 128}", result, reference)
    if len(sys.argv) > 2:
        voxels = np.frombuffer(gzip.open(sys.argv[2]).read(), np.uint8).reshape(256, 256, 256)
        opacity = [(0, 0), (30, 0), (120, 0.3), (255, 1)]
        color = [(0, (0.1, 0.2, 0.1)), (120, (0.6, 0.5, 0.4)), (255, (1, 1, 1))]
        camera = ((128, -420, 200), (128, 128, 128), (0, 0, 1), 30)
        row("bonsai 1024², fixed", frames("fixed", voxels, 1, 1, opacity, color, 1, camera, 1024))


main()
