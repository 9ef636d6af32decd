//! Benches: suites of scenes × methods × devices, measured for speed and error together.

pub mod results;
