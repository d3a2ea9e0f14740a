//! A plugin in C with one planted offence at a time: exactly the check that is meant for it names it.
//!
//! The processes of checks run this test program: see [`served`].

mod planted;

/// The entry point of those processes, which select it by its exact name. Among the other tests it does nothing.
#[test]
fn served() {
    let arguments: Vec<String> = std::env::args().collect();
    let Some(separator) = arguments.iter().position(|argument| argument == "served") else {
        return;
    };
    if let [file, check, number] = &arguments[separator + 1..] {
        let served = jde_validate::serve(&[file.clone(), check.clone(), number.clone()]);
        std::process::exit(i32::from(served.is_err()));
    }
}
