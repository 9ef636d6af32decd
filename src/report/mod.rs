//! The report of a bench: plots and one HTML page, from [`crate::bench::results::Results`] alone.

pub mod numbers;
pub mod plot;
