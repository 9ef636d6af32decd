//! What OpenCL platforms and devices this machine has, what they can do, and how to pick one.

use super::api;
use crate::{Error, Result};
use ocl::core::{
    self, DeviceId, DeviceInfo as Query, DeviceInfoResult, DeviceType, PlatformId, PlatformInfo,
};
use serde::{Deserialize, Serialize};

/// What a device is, in the order in which the default selection prefers them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DeviceKind {
    /// A graphics processor.
    Gpu,
    /// A dedicated accelerator.
    Accelerator,
    /// The host's processor.
    Cpu,
    /// Anything else.
    Other,
}

/// Everything svetlo asks a device for, asked once.
#[derive(Clone, Debug, Serialize)]
pub struct DeviceInfo {
    /// The selector that picks exactly this device: `PLATFORM:DEVICE` indices.
    pub selector: String,
    /// Platform name, as the driver reports it.
    pub platform: String,
    /// Platform version string.
    pub platform_version: String,
    /// Device name.
    pub name: String,
    /// Vendor name.
    pub vendor: String,
    /// Driver version.
    pub driver: String,
    /// Device version string, such as `OpenCL 3.0 …`.
    pub version: String,
    /// Kind of device.
    pub kind: DeviceKind,
    /// Parallel compute units.
    pub compute_units: u32,
    /// Maximum clock in MHz, 0 when unknown.
    pub clock_mhz: u32,
    /// Global memory in bytes.
    pub global_memory: u64,
    /// Largest single allocation in bytes.
    pub max_allocation: u64,
    /// Local memory in bytes.
    pub local_memory: u64,
    /// Largest work-group.
    pub max_work_group: usize,
    /// Floats in a vector that the device computes with at once; 0 if unknown.
    pub vector_width: u32,
    /// Whether the device computes in double precision.
    pub fp64: bool,
    #[serde(skip)]
    pub(super) platform_id: PlatformId,
    #[serde(skip)]
    pub(super) device_id: DeviceId,
}

/// What people call a device, wherever it is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeviceName {
    /// As `svetlo devices` lists it; of a device of another process, after the name of that.
    pub selector: String,
    /// Device name.
    pub name: String,
    /// Platform name.
    pub platform: String,
    /// Driver version.
    pub driver: String,
}

/// The devices found, and remarks on platforms that could not be used.
#[derive(Clone, Debug, Serialize)]
pub struct Catalog {
    /// Usable devices, in platform order.
    pub devices: Vec<DeviceInfo>,
    /// One line per platform that offers no device or failed to answer.
    pub remarks: Vec<String>,
}

impl Catalog {
    /// Asks every platform; one that fails becomes a remark, never an error.
    pub fn enumerate() -> Self {
        let _guard = api::one_at_a_time();
        let mut catalog = Self { devices: Vec::new(), remarks: Vec::new() };
        if api::platform_count() == 0 {
            return catalog;
        }
        let platforms = match core::get_platform_ids() {
            Ok(platforms) => platforms,
            Err(error) => {
                catalog.remarks.push(format!("the OpenCL loader could not list platforms: {error}"));
                return catalog;
            }
        };
        for (index, platform) in platforms.into_iter().enumerate() {
            catalog.add_platform(index, platform);
        }
        catalog
    }

    fn add_platform(&mut self, index: usize, platform: PlatformId) {
        let name = platform_text(platform, PlatformInfo::Name);
        match core::get_device_ids(platform, Some(DeviceType::ALL), None) {
            Ok(ids) => {
                for (device, id) in ids.into_iter().enumerate() {
                    self.devices.push(DeviceInfo::query(index, device, platform, id));
                }
            }
            Err(_) => {
                let hint = if name == "Portable Computing Language" {
                    "; PoCL needs a cache folder it can write to: set POCL_CACHE_DIR"
                } else {
                    ""
                };
                self.remarks.push(format!("platform {index} ({name}) offers no device{hint}"));
            }
        }
    }

    /// The device that `selector` names, or the best one when there is no selector.
    ///
    /// A selector is `PLATFORM:DEVICE`, a position in the list of `svetlo devices`, a kind (`cpu`, `gpu`,
    /// `accelerator`), or part of a device, platform or vendor name or of the platform's version; letter case does not matter.
    ///
    /// # Errors
    /// [`Error::Failed`] when there is no device at all, [`Error::Input`] when none matches.
    pub fn select(&self, selector: Option<&str>) -> Result<&DeviceInfo> {
        if self.devices.is_empty() {
            return Err(Error::Failed(self.nothing_found()));
        }
        let matches = |device: &&DeviceInfo| selector.is_none_or(|text| device.matches(text));
        let by_position = selector.and_then(|text| text.trim().parse::<usize>().ok());
        let found = match by_position {
            Some(position) => self.devices.get(position),
            None => self.devices.iter().filter(matches).max_by_key(|device| device.rank()),
        };
        found.ok_or_else(|| Error::Input(self.no_match(selector.unwrap_or_default())))
    }

    /// The devices that `selectors` name, each once, in their order; the best one where there are none.
    ///
    /// A selector is one of [`Catalog::select`], or `all`, or `all:` and part of a name or a kind: every device that has it.
    ///
    /// # Errors
    /// As [`Catalog::select`], and [`Error::Input`] when two selectors name the same device.
    pub fn select_several(&self, selectors: &[String]) -> Result<Vec<&DeviceInfo>> {
        let mut chosen: Vec<&DeviceInfo> = Vec::new();
        for selector in selectors {
            let found = self.all_of(selector)?;
            if let Some(twice) =
                found.iter().find(|one| chosen.iter().any(|other| other.selector == one.selector))
            {
                return Err(Error::Input(format!(
                    "--device '{selector}' is {} ({}), which another --device names already",
                    twice.name, twice.selector
                )));
            }
            chosen.extend(found);
        }
        if selectors.is_empty() { Ok(vec![self.select(None)?]) } else { Ok(chosen) }
    }

    /// This device and those that are like it: of its kind, platform and name.
    pub fn like(&self, device: &DeviceInfo) -> Vec<&DeviceInfo> {
        let traits = |one: &DeviceInfo| (one.kind, one.platform.clone(), one.name.clone());
        self.devices.iter().filter(|other| traits(other) == traits(device)).collect()
    }

    fn all_of(&self, selector: &str) -> Result<Vec<&DeviceInfo>> {
        let word = selector.trim().to_lowercase();
        let Some(rest) = word.strip_prefix("all").map(|rest| rest.strip_prefix(':').unwrap_or(rest)) else {
            return Ok(vec![self.select(Some(selector))?]);
        };
        // Says what there is, if there is nothing.
        self.select(Some(rest).filter(|rest| !rest.is_empty()))?;
        Ok(self.devices.iter().filter(|device| rest.is_empty() || device.matches(rest)).collect())
    }

    fn nothing_found(&self) -> String {
        let mut text = String::from(
            "no OpenCL device was found; install a runtime, for a CPU on Debian or Ubuntu: \
             apt-get install pocl-opencl-icd (for a GPU: its vendor's OpenCL driver)",
        );
        for remark in &self.remarks {
            text.push_str("\n  ");
            text.push_str(remark);
        }
        text
    }

    fn no_match(&self, selector: &str) -> String {
        let mut text = format!("no OpenCL device matches '{selector}'; there are:");
        for device in &self.devices {
            text.push_str(&format!("\n  {}  {} ({})", device.selector, device.name, device.platform));
        }
        text
    }
}

impl DeviceInfo {
    fn query(platform_index: usize, index: usize, platform_id: PlatformId, device_id: DeviceId) -> Self {
        let kind = match core::get_device_info(device_id, Query::Type) {
            Ok(DeviceInfoResult::Type(kind)) if kind.contains(DeviceType::GPU) => DeviceKind::Gpu,
            Ok(DeviceInfoResult::Type(kind)) if kind.contains(DeviceType::ACCELERATOR) => {
                DeviceKind::Accelerator
            }
            Ok(DeviceInfoResult::Type(kind)) if kind.contains(DeviceType::CPU) => DeviceKind::Cpu,
            _ => DeviceKind::Other,
        };
        let number = |query| device_number(device_id, query).unwrap_or(0);
        Self {
            selector: format!("{platform_index}:{index}"),
            platform: platform_text(platform_id, PlatformInfo::Name),
            platform_version: platform_text(platform_id, PlatformInfo::Version),
            name: device_text(device_id, Query::Name),
            vendor: device_text(device_id, Query::Vendor),
            driver: device_text(device_id, Query::DriverVersion),
            version: device_text(device_id, Query::Version),
            kind,
            compute_units: number(Query::MaxComputeUnits) as u32,
            clock_mhz: number(Query::MaxClockFrequency) as u32,
            global_memory: number(Query::GlobalMemSize),
            max_allocation: number(Query::MaxMemAllocSize),
            local_memory: number(Query::LocalMemSize),
            max_work_group: (number(Query::MaxWorkGroupSize) as usize).max(1),
            vector_width: number(Query::NativeVectorWidthFloat) as u32,
            fp64: number(Query::DoubleFpConfig) != 0,
            platform_id,
            device_id,
        }
    }

    /// What people call it.
    pub fn names(&self) -> DeviceName {
        DeviceName {
            selector: self.selector.clone(),
            name: self.name.clone(),
            platform: self.platform.clone(),
            driver: self.driver.clone(),
        }
    }

    /// Samples that one launch may add to a pixel.
    ///
    /// llvmpipe leaves all loops of a work-item after 65535 iterations in total, without a word
    /// (`LP_MAX_TGSI_LOOP_ITERATIONS` in Mesa's gallivm): a launch of many samples would lose their ends.
    pub fn samples_per_launch(&self) -> u32 {
        if self.ends_long_loops() { 1 } else { u32::MAX }
    }

    /// Whether the device leaves loops after 65535 turns without a word; see [`samples_per_launch`](Self::samples_per_launch).
    pub fn ends_long_loops(&self) -> bool {
        self.is_llvmpipe()
    }

    /// Rays that a work-item follows side by side through a padded grid of so many voxels (`WIDTH` in
    /// `cl/common/lanes.cl`): as many as the vectors of CPUs have lanes. More than one lane indexes voxels in 32 bits.
    pub fn lanes(&self, voxels: u64) -> u32 {
        let lanes = match self.vector_width {
            16.. => 16,
            8.. => 8,
            4.. => 4,
            _ => 1,
        };
        if self.kind == DeviceKind::Cpu && voxels < 1 << 31 { lanes } else { 1 }
    }

    /// Whether functions may be inlined by force. Oclgrind 21.10 stops at what LLVM leaves behind
    /// (`llvm.experimental.noalias.scope.decl`).
    pub fn can_force_inlining(&self) -> bool {
        self.platform != "Oclgrind"
    }

    fn is_llvmpipe(&self) -> bool {
        self.name.to_lowercase().contains("llvmpipe")
    }

    fn matches(&self, selector: &str) -> bool {
        let wanted = selector.trim().to_lowercase();
        let kind = match self.kind {
            DeviceKind::Gpu => "gpu",
            DeviceKind::Accelerator => "accelerator",
            DeviceKind::Cpu => "cpu",
            DeviceKind::Other => "other",
        };
        if ["gpu", "cpu", "accelerator"].contains(&wanted.as_str()) {
            return wanted == kind;
        }
        // The version has the name that people use for PoCL.
        let names = [&self.name, &self.platform, &self.platform_version, &self.vendor];
        !wanted.is_empty()
            && (wanted == self.selector || names.iter().any(|name| name.to_lowercase().contains(&wanted)))
    }

    /// Sort key of the default selection: kind first, then native compilers before software rasterisers
    /// (llvmpipe runs kernels several times slower than PoCL on the same CPU), then width and clock.
    fn rank(&self) -> (std::cmp::Reverse<DeviceKind>, bool, u64, std::cmp::Reverse<String>) {
        let software = self.is_llvmpipe();
        let kind = if software { DeviceKind::Cpu } else { self.kind };
        let throughput = u64::from(self.compute_units) * u64::from(self.clock_mhz.max(1));
        (std::cmp::Reverse(kind), !software, throughput, std::cmp::Reverse(self.selector.clone()))
    }
}

fn platform_text(platform: PlatformId, query: PlatformInfo) -> String {
    core::get_platform_info(platform, query).map_or_else(|_| "unknown".into(), |text| text.to_string())
}

fn device_text(device: DeviceId, query: Query) -> String {
    core::get_device_info(device, query)
        .map_or_else(|_| "unknown".into(), |text| text.to_string().trim().into())
}

/// A numeric property; an optional query that fails is `None`, never fatal.
fn device_number(device: DeviceId, query: Query) -> Option<u64> {
    let bytes = core::get_device_info_raw(device, query as u32).ok()?;
    match bytes.len() {
        4 => Some(u64::from(u32::from_ne_bytes(bytes.try_into().ok()?))),
        8 => Some(u64::from_ne_bytes(bytes.try_into().ok()?)),
        _ => None,
    }
}
