//! Names in C's style, and comments with such names.

use std::collections::BTreeSet;

/// Returns the C name of a structure: `jde_child_status` for `ChildStatus`, `jde_pose2d` for `Pose2D`.
pub(super) fn structure(name: &str) -> String {
    let letters: Vec<char> = name.chars().collect();
    let mut snake = String::from("jde");
    for (at, letter) in letters.iter().enumerate() {
        let begins = at == 0 || (letters[at - 1].is_lowercase() && letter.is_uppercase());
        if begins {
            snake.push('_');
        }
        snake.extend(letter.to_lowercase());
    }
    snake
}

/// Returns the C name of a constant: `JDE_ABI_MAJOR` for `ABI_MAJOR`.
pub(super) fn constant(name: &str) -> String {
    format!("JDE_{name}")
}

/// Returns a Rust comment with its links replaced by C names.
pub(super) fn comment(text: &str, constants: &BTreeSet<String>) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("[`") {
        let Some((link, end)) = after.split_once("`]") else {
            break;
        };
        out.push_str(before);
        // C has a single name space.
        let link = link.strip_prefix("super::").unwrap_or(link);
        out.push_str(&match link.rsplit_once("::") {
            Some((owner, member)) => format!("{}.{member}", structure(owner)),
            None if constants.contains(link) => constant(link),
            None => structure(link),
        });
        rest = end;
    }
    out.push_str(rest);
    out.replace("`u32`", "`uint32_t`")
}

/// Returns the C name of a member. Keywords of C and C++ get an underscore at the end.
pub(super) fn member(name: &str) -> String {
    if [
        "case", "default", "switch", "register", "class", "template", "operator", "new",
    ]
    .contains(&name)
    {
        return format!("{name}_");
    }
    name.to_owned()
}

/// Returns a block comment for a declaration.
pub(super) fn block(text: &str, indent: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    match lines.as_slice() {
        [] => String::new(),
        [line] => format!("{indent}/** {line} */\n"),
        lines => {
            let body: String = lines
                .iter()
                .map(|line| format!("{indent} * {line}\n").replace("* \n", "*\n"))
                .collect();
            format!("{indent}/**\n{body}{indent} */\n")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_snake_case_with_one_prefix() {
        for (rust, c) in [
            ("ChildStatus", "jde_child_status"),
            ("Pose2D", "jde_pose2d"),
            ("UInt8", "jde_uint8"),
            ("Float64", "jde_float64"),
        ] {
            assert_eq!(structure(rust), c);
        }
    }

    #[test]
    fn keywords_of_c_get_an_underscore() {
        assert_eq!(
            (member("case"), member("winner")),
            ("case_".to_owned(), "winner".to_owned())
        );
    }

    #[test]
    fn links_become_c_names() {
        let constants = BTreeSet::from(["OK".to_owned()]);
        assert_eq!(
            comment("[`OK`], or see [`Host::fail`] of [`Host`].", &constants),
            "JDE_OK, or see jde_host.fail of jde_host."
        );
    }
}
