//! The light that cameras project: on the device and as numbers.

use super::{DirectLight, LightGrid};
use crate::Result;
use crate::device::{Arg, Buffer, Device, Program, ProgramSpec};

/// A light volume on the device, as `cl/irradiance/light.cl` reads it.
pub struct LightBuffers {
    grid: LightGrid,
    device_grid: Buffer<super::DeviceLightGrid>,
    /// Fluence: of all light, or of what is not unscattered where there is `directed`.
    light: Buffer<[f32; 4]>,
    direct: Buffer<[f32; 4]>,
    directed: Option<Directed>,
    /// Stands in for what is not there.
    none: Buffer<[f32; 4]>,
}

/// Where light goes, in media that do not scatter into all directions alike.
struct Directed {
    drift: Buffer<[f32; 4]>,
    flow: Buffer<[f32; 4]>,
}

/// A light volume as numbers, per cell, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct LightData {
    /// Cells per axis.
    pub dims: [usize; 3],
    /// Fluence per channel: of all light, or where there are `directions`, of all but unscattered light.
    pub fluence: Vec<[f32; 3]>,
    /// Fluence of unscattered light.
    pub direct: Vec<[f32; 3]>,
    /// `None` where the medium scatters into all directions alike.
    pub directions: Option<Directions>,
}

/// Mean directions of light: flux over fluence, of the channels' mean, at most 1 long.
#[derive(Clone, Debug, PartialEq)]
pub struct Directions {
    /// Of all but unscattered light.
    pub drift: Vec<[f32; 3]>,
    /// Of unscattered light.
    pub flow: Vec<[f32; 3]>,
}

impl LightBuffers {
    /// Puts unscattered and scattered fluence together; `drift`: the mean direction of all but unscattered light, where
    /// the medium does not scatter into all directions alike.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    pub fn new(
        device: &Device,
        grid: LightGrid,
        direct: DirectLight,
        scattered: Buffer<[f32; 4]>,
        drift: Option<Buffer<[f32; 4]>>,
    ) -> Result<Self> {
        let directed = direct.flow.zip(drift).map(|(flow, drift)| Directed { drift, flow });
        let spec = ProgramSpec::new("irradiance/combine.cl").feature("DIRECTED", directed.is_some());
        let mut kernel = Program::build(device, &spec)?.kernel(device, "irradiance_combine")?;
        let light = scattered;
        let reduced = direct.reduced.as_ref().unwrap_or(&direct.fluence);
        let arguments: [Arg<'_>; 4] =
            [(&light).into(), (&direct.fluence).into(), reduced.into(), (light.len() as u32).into()];
        kernel.run(device, &arguments, light.len())?;
        Self::of(device, grid, light, direct.fluence, directed)
    }

    fn of(
        device: &Device,
        grid: LightGrid,
        light: Buffer<[f32; 4]>,
        direct: Buffer<[f32; 4]>,
        directed: Option<Directed>,
    ) -> Result<Self> {
        let device_grid = Buffer::from_slice(device, &[grid.device()])?;
        Ok(Self { grid, device_grid, light, direct, directed, none: Buffer::zeroed(device, 1)? })
    }

    /// Uploads a light volume that was read or computed before.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device lacks memory.
    pub fn upload(device: &Device, grid: LightGrid, data: &LightData) -> Result<Self> {
        let float4 = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        let upload = |values: &[[f32; 3]]| -> Result<Buffer<[f32; 4]>> {
            Buffer::from_slice(device, &values.iter().map(|&v| float4(v)).collect::<Vec<_>>())
        };
        let directed = match &data.directions {
            Some(Directions { drift, flow }) => Some(Directed { drift: upload(drift)?, flow: upload(flow)? }),
            None => None,
        };
        Self::of(device, grid, upload(&data.fluence)?, upload(&data.direct)?, directed)
    }

    /// Reads it back.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    pub fn read(&self, device: &Device) -> Result<LightData> {
        let rgb = |buffer: &Buffer<[f32; 4]>| -> Result<Vec<[f32; 3]>> {
            Ok(buffer.read(device)?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect())
        };
        let directions = match &self.directed {
            Some(Directed { drift, flow }) => Some(Directions { drift: rgb(drift)?, flow: rgb(flow)? }),
            None => None,
        };
        Ok(LightData {
            dims: self.grid.dims,
            fluence: rgb(&self.light)?,
            direct: rgb(&self.direct)?,
            directions,
        })
    }

    /// Grid, light, drift, direct light, flow: as `render_light_volume` takes them.
    pub fn arguments(&self) -> [Arg<'_>; 5] {
        let directed = self.directed.as_ref();
        [
            (&self.device_grid).into(),
            (&self.light).into(),
            directed.map_or(&self.none, |d| &d.drift).into(),
            directed.map_or(&self.none, |_| &self.direct).into(),
            directed.map_or(&self.none, |d| &d.flow).into(),
        ]
    }
}
