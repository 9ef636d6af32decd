//! The `svetlo` command; everything is in the library.

fn main() -> std::process::ExitCode {
    svetlo::cli::main().into()
}
