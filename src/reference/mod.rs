//! Plain Rust twins of the kernels, in double precision, written for reading: the truth of the tests.
//!
//! Nothing here needs a device, skips anything or is tuned. Each file states the model it evaluates; where a kernel
//! uses a shortcut, the twin takes the long way (dense brackets, adaptive quadrature), so that the two agree only
//! when both are right. Lengths are in scene units.
//!
//! - [`field`]: the trilinear field, its window and its gradient; where a ray crosses its cells
//! - [`camera`]: rays through pixels and lenses
//! - [`cubic`]: the field along a ray inside a cell
//! - [`quadrature`]: Gauss–Legendre rules
//! - [`medium`], [`emission_absorption`]: the transfer function and the integral along a ray
//! - [`mip`], [`isosurface`]: the largest value, the first surface and its shading
//! - [`phase`]: phase functions
//! - [`optics`], [`metaballs`]: boundaries of glass, and a surface that rays meet
//! - [`lights`]: direct light at a point, and the environment map
//! - [`scattering`]: plain Monte Carlo for any scene, and single scattering in a homogeneous box by quadrature
//! - [`slab`], [`half_space`]: layers, half spaces and infinite media that scatter, by transport theory
//! - [`convection`]: direct light by upwind differences, scattered light by explicit diffusion
//! - [`diffusion`]: the steady diffusion equation by conjugate gradients
//! - [`surfaces`]: where rays meet surfaces
//! - [`photons`]: irradiance from photons
//! - [`random`], [`sobol`]: random numbers, bit for bit
//! - [`film`]: statistics of samples
//! - [`sort`]: the order of keys, and the items of each cell

pub mod camera;
pub mod convection;
pub mod cubic;
pub mod diffusion;
pub mod emission_absorption;
pub mod field;
pub mod film;
pub mod half_space;
pub mod isosurface;
pub mod lights;
pub mod medium;
pub mod metaballs;
pub mod mip;
pub mod optics;
pub mod phase;
pub mod photons;
pub mod quadrature;
pub mod random;
pub mod scattering;
pub mod slab;
pub mod sobol;
pub mod sort;
pub mod surfaces;
