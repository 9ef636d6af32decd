//! The contract of the command line: the real binary, its exit codes, what it prints where, and the files it leaves.
//!
//! The tests render a few pixels and need an OpenCL device.
#![cfg(unix)]

mod bad_input;
mod bad_volumes;
mod caustics;
mod contract;
mod device_faults;
mod devices;
mod documents;
mod examples;
mod faults;
mod interrupt;
mod kills;
mod light;
mod mpi;
mod output;
mod parts;
mod resume;
mod scattering;
mod selftest;
mod support;
mod surroundings;
