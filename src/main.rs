//! The `svetlo` command.
fn main() {}
