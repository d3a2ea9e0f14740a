//! The one executable.

fn main() -> std::process::ExitCode {
    jde::main()
}
