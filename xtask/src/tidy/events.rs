//! What reads events lists every kind of them: no arm of a match stands for all others, so that the compiler names each
//! reader when there is a new event.

use super::tree::{File, Tree, Violation};

/// How the arms of a match on events begin.
const ARMS: [&str; 5] = [
    "What::",
    "RunRecord::",
    "Event::Decision",
    "Event::State",
    "Event::Other",
];

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.rust().flat_map(check_file).collect()
}

fn check_file(file: &File) -> Vec<Violation> {
    let mut found = Vec::new();
    // The indentation of the arms of the matches on events around a line, from the outermost.
    let mut matches: Vec<usize> = Vec::new();
    for (number, line) in file.numbered() {
        let code = line.code.trim_start();
        if code.is_empty() || line.test {
            continue;
        }
        let indentation = line.code.len() - code.len();
        while matches.pop_if(|arms| *arms > indentation).is_some() {}
        let arm = code.trim_start_matches("| ");
        if matches.last() == Some(&indentation) && is_of_all_others(code) {
            found.push(Violation::new(
                file.path.as_str(),
                number,
                "an arm for all other events",
                "list them: a new event shall be an error here; where one kind matters, use `if let` or `matches!`",
            ));
        } else if is_of_event(file, arm) && matches.last() != Some(&indentation) {
            matches.push(indentation);
        }
    }
    found
}

/// Whether an arm is of an event. Their own module names them by `Self`.
fn is_of_event(file: &File, arm: &str) -> bool {
    ARMS.iter().any(|begin| arm.starts_with(begin))
        || file.path.starts_with("runtime/records/src/event/") && arm.starts_with("Self::")
}

/// Whether an arm has no pattern: `_ => ..`, `_ if ..`, `other => ..`.
fn is_of_all_others(code: &str) -> bool {
    let name = code
        .split(|letter: char| !(letter.is_ascii_lowercase() || letter == '_'))
        .next();
    let rest = name.map_or(code, |name| &code[name.len()..]);
    name.is_some_and(|name| !name.is_empty()) && (rest.starts_with(" =>") || rest.starts_with(" if "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<usize> {
        let file = File::new("rules/a/src/b.rs", text);
        let found = check_file(&file);
        found.iter().map(|violation| violation.line).collect()
    }

    #[test]
    fn an_arm_for_all_other_events_is_found() {
        let text = "fn a(what: &What) {\n    match what {\n        What::Ended { .. } => 1,\n        _ => 2,\n    };\n}\n";
        assert_eq!(lines(text), [4]);
        assert_eq!(lines(&text.replace("_ =>", "other =>")), [4]);
        assert_eq!(lines(&text.replace("_ =>", "_ if a =>")), [4]);
        assert_eq!(lines(&text.replace("_ =>", "What::Hung { .. } =>")), [0; 0]);
    }

    #[test]
    fn matches_on_other_things_are_free() {
        let text = "fn a() {\n    match what {\n        What::Ended { outcome } => match outcome {\n            A => 1,\n            _ => 2,\n        },\n        What::Hung { .. } => 3,\n    };\n    match b {\n        C => 1,\n        _ => 2,\n    }\n}\n";
        assert_eq!(lines(text), [0; 0]);
    }
}
