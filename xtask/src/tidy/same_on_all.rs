//! What decides computes the same on every machine: the standard library takes its functions of real numbers from the C
//! library, which has others for each processor and in each version. `libm` has one of each (R16).

use super::tree::{File, Tree, Violation};

/// The folders of what decides, and of what it decides from.
const DECIDES: &[&str] = &[
    "base/",
    "devices/",
    "drivers/",
    "plugin/",
    "robotics/",
    "rules/",
    "runtime/",
    "schemas/",
];
/// Its lanes of numbers have functions of their own.
const LANES: &str = "robotics/mppi/src/";

/// The functions whose last digit depends on the C library.
const FUNCTIONS: &[&str] = &[
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "cos", "cosh", "exp", "exp2",
    "exp_m1", "hypot", "ln", "ln_1p", "log10", "log2", "powf", "sin", "sin_cos", "sinh", "tan", "tanh",
];

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.rust().flat_map(check_file).collect()
}

fn check_file(file: &File) -> Vec<Violation> {
    let path = file.path.as_str();
    let decides = DECIDES.iter().any(|folder| path.starts_with(folder));
    if !decides || path.starts_with(LANES) || path.contains("/tests/") || path.contains("/examples/") {
        return Vec::new();
    }
    let lines = file.numbered().filter(|(_, line)| !line.test);
    let found = lines.flat_map(|(number, line)| {
        let called = FUNCTIONS.iter().filter(|name| calls(&line.code, name));
        called.map(move |name| {
            let what = format!("`{name}` of the standard library differs between machines in the last digit");
            let help = "use the function of `libm`, which is the same everywhere";
            Violation::new(path, number, what, help)
        })
    });
    found.collect()
}

/// Whether the code calls a function as a method, or names it as that of a type of numbers.
fn calls(code: &str, name: &str) -> bool {
    let method = format!(".{name}(");
    let ends = |rest: &str| !rest.starts_with(|letter: char| letter.is_alphanumeric() || letter == '_');
    let of_type = |kind| {
        let path = format!("{kind}::{name}");
        code.match_indices(&path)
            .any(|(at, _)| ends(&code[at + path.len()..]))
    };
    code.contains(&method) || of_type("f64") || of_type("f32")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(path: &str, code: &str) -> usize {
        check_file(&File::new(path, format!("fn a() {{ {code}; }}\n"))).len()
    }

    #[test]
    fn functions_of_the_c_library_are_found_where_something_is_decided() {
        for code in ["x.sin()", "x.hypot(y)", "xs.map(f64::exp)", "f32::atan2(y, x)"] {
            assert_eq!(count("schemas/a/src/b.rs", code), 1, "{code}");
            for path in [
                "programs/a/src/b.rs",
                "schemas/a/tests/b.rs",
                "robotics/a/examples/b.rs",
            ] {
                assert_eq!(count(path, code), 0, "{path}: {code}");
            }
        }
    }

    #[test]
    fn exact_functions_are_free() {
        for code in [
            "x.sqrt()",
            "libm::sin(x)",
            "x.sin",
            "f64::exponent(x)",
            "x.powi(2)",
        ] {
            assert_eq!(count("robotics/a/src/b.rs", code), 0, "{code}");
        }
    }
}
