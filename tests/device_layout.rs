//! The structs shared with kernels have one layout, on the host and on the device.

mod common;

use svetlo::device::layout::{StructLayout, probe};
use svetlo::render::LAYOUTS;

#[test]
fn every_shared_struct_has_the_layout_of_the_device() {
    probe(&common::device(), LAYOUTS).unwrap();
}

#[test]
fn a_field_that_moved_is_named_with_both_offsets() {
    let StructLayout { name, file, size, fields } = LAYOUTS[0].clone();
    let (field, offset) = fields[1];
    let moved: &'static [(&'static str, usize)] = vec![fields[0], (field, offset + 4)].leak();
    let error = probe(&common::device(), &[StructLayout { name, file, size, fields: moved }]).unwrap_err();
    let expected =
        format!("offset of {name}.{field} is {offset} bytes on the device, {} on the host", offset + 4);
    assert!(error.to_string().contains(&expected), "{error}");
}
