//! Structs shared with kernels: one `repr(C)` mirror per device type, and the probe that proves the layout.

use super::{Buffer, Device, Program};
use crate::{Error, Result};

/// Name, size and field offsets of a shared struct, in bytes.
#[derive(Clone, Debug)]
pub struct StructLayout {
    /// The struct's name in Rust; in OpenCL C it is the same without the prefix `Device`, which sets mirrors apart
    /// from types of the scene.
    pub name: &'static str,
    /// The file below `cl/` that declares it.
    pub file: &'static str,
    /// Size in bytes.
    pub size: usize,
    /// Name and offset of each field.
    pub fields: &'static [(&'static str, usize)],
}

/// Declares a struct shared with kernels and its [`StructLayout`].
///
/// Only `f32`, `i32`, `u32` and four-element arrays of them may be fields: their layout is the same in
/// every OpenCL C compiler when four-element arrays (`float4`) come first.
#[macro_export]
macro_rules! device_struct {
    ($file:literal, $(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* pub $field:ident: $type:ty,)* }) => {
        $(#[$meta])*
        #[repr(C, align(16))]
        #[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $($(#[$field_meta])* pub $field: $type,)* }

        impl $name {
            /// The layout that the device must agree with.
            pub const LAYOUT: $crate::device::layout::StructLayout = $crate::device::layout::StructLayout {
                name: stringify!($name),
                file: $file,
                size: std::mem::size_of::<$name>(),
                fields: &[$((stringify!($field), std::mem::offset_of!($name, $field)),)*],
            };
        }
    };
}

/// Compares `layouts` with what the device's compiler makes of the same structs.
///
/// # Errors
/// [`Error::Failed`] naming the first struct or field that differs, with both numbers.
pub fn probe(device: &Device, layouts: &[StructLayout]) -> Result<()> {
    let mut source = String::new();
    let mut body = String::new();
    let mut expected = Vec::new();
    let mut files = Vec::new();
    for layout in layouts {
        // A file may declare several structs.
        if !files.contains(&layout.file) {
            source.push_str(&super::source::resolve(layout.file)?);
            files.push(layout.file);
        }
        let device_name = layout.name.strip_prefix("Device").unwrap_or(layout.name);
        body.push_str(&format!("{{ __private struct {device_name} s; *out++ = sizeof(s);"));
        expected.push((format!("sizeof({})", layout.name), layout.size));
        for (field, offset) in layout.fields {
            body.push_str(&format!(" *out++ = (uint)((__private char *)&s.{field} - (__private char *)&s);"));
            expected.push((format!("offset of {}.{field}", layout.name), *offset));
        }
        body.push_str(" }\n");
    }
    source.push_str(&format!(
        "#line 1 \"probe\"\n__kernel void probe_layout(__global uint *out) {{\nif (get_global_id(0) != 0) return;\n{body}}}\n"
    ));
    let program = Program::build_source(device, &source, "-cl-std=CL1.2")?;
    let buffer = Buffer::<u32>::zeroed(device, expected.len())?;
    program.kernel(device, "probe_layout")?.run(device, &[(&buffer).into()], 1)?;
    for ((what, host), found) in expected.iter().zip(buffer.read(device)?) {
        if *host != found as usize {
            return Err(Error::Failed(format!(
                "{}: {what} is {found} bytes on the device, {host} on the host",
                device.info().name
            )));
        }
    }
    Ok(())
}
