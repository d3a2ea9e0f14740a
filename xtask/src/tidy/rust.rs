//! Splits a Rust file line by line into code, comments and string literals, and marks the lines of tests. It
//! does not parse Rust beyond that.

/// One line of a Rust file.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(crate) struct SourceLine {
    /// The code, without comments and with empty string literals.
    pub(crate) code: String,
    /// The text of comments and doc comments, with their slashes.
    pub(crate) comment: String,
    /// The text of string literals.
    pub(crate) literal: String,
    /// Whether the line belongs to an item under `#[cfg(test)]`.
    pub(crate) test: bool,
}

/// Splits a file into lines.
pub(crate) fn scan(text: &str) -> Vec<SourceLine> {
    let mut lines = split(text);
    mark_tests(&mut lines);
    lines
}

#[derive(Clone, Copy)]
enum LexState {
    Code,
    LineComment,
    BlockComment { depth: usize },
    Text,
    RawText { hashes: usize },
}

fn split(text: &str) -> Vec<SourceLine> {
    let chars: Vec<char> = text.chars().collect();
    let mut lines = Vec::new();
    let mut line = SourceLine::default();
    let mut within = LexState::Code;
    let mut at = 0;
    while at < chars.len() {
        let c = chars[at];
        if c == '\n' {
            lines.push(std::mem::take(&mut line));
            if matches!(within, LexState::LineComment) {
                within = LexState::Code;
            }
            at += 1;
            continue;
        }
        let next = chars.get(at + 1).copied();
        let taken = match within {
            LexState::Code => {
                let (after, taken) = enter(&chars, at);
                match after {
                    LexState::LineComment | LexState::BlockComment { .. } => {
                        line.comment.extend(&chars[at..at + taken]);
                    }
                    LexState::Code | LexState::Text | LexState::RawText { .. } => {
                        line.code.extend(&chars[at..at + taken]);
                    }
                }
                within = after;
                taken
            }
            LexState::LineComment => {
                line.comment.push(c);
                1
            }
            LexState::BlockComment { depth } => {
                let (deeper, taken) = match (c, next) {
                    ('/', Some('*')) => (depth + 1, 2),
                    ('*', Some('/')) => (depth - 1, 2),
                    _ => (depth, 1),
                };
                line.comment.extend(&chars[at..at + taken]);
                within = if deeper == 0 {
                    LexState::Code
                } else {
                    LexState::BlockComment { depth: deeper }
                };
                taken
            }
            LexState::Text => {
                if c == '"' {
                    line.code.push('"');
                    within = LexState::Code;
                    1
                } else if c == '\\' && next.is_some_and(|escaped| escaped != '\n') {
                    line.literal.extend(&chars[at..at + 2]);
                    2
                } else {
                    line.literal.push(c);
                    1
                }
            }
            LexState::RawText { hashes } => {
                if c == '"' && count_hashes(&chars, at + 1) >= hashes {
                    line.code.push('"');
                    within = LexState::Code;
                    1 + hashes
                } else {
                    line.literal.push(c);
                    1
                }
            }
        };
        at += taken;
    }
    if !text.is_empty() && !text.ends_with('\n') {
        lines.push(line);
    }
    lines
}

/// Returns what begins at a place in code, and the number of characters of its opening.
fn enter(chars: &[char], at: usize) -> (LexState, usize) {
    let next = chars.get(at + 1).copied();
    match (chars[at], next) {
        ('/', Some('/')) => (LexState::LineComment, 2),
        ('/', Some('*')) => (LexState::BlockComment { depth: 1 }, 2),
        ('"', _) => (LexState::Text, 1),
        ('r', Some('"' | '#')) if starts_word(chars, at) => {
            let hashes = count_hashes(chars, at + 1);
            if chars.get(at + 1 + hashes) == Some(&'"') {
                (LexState::RawText { hashes }, 2 + hashes)
            } else {
                (LexState::Code, 1)
            }
        }
        // A character literal, such as `'"'` or `'\''`. A lifetime has no quote after it.
        ('\'', Some('\\')) => {
            let quote = chars[at + 3..].iter().position(|&c| c == '\'' || c == '\n');
            (LexState::Code, quote.map_or(1, |far| far + 4))
        }
        ('\'', Some(_)) if chars.get(at + 2) == Some(&'\'') => (LexState::Code, 3),
        _ => (LexState::Code, 1),
    }
}

/// Returns whether a word can start at this position. A raw string may follow the prefix `b` or `c`, but no
/// other part of a name.
fn starts_word(chars: &[char], at: usize) -> bool {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    match at.checked_sub(1).map(|before| chars[before]) {
        Some('b' | 'c') => at < 2 || !is_name(chars[at - 2]),
        Some(before) => !is_name(before),
        None => true,
    }
}

fn count_hashes(chars: &[char], from: usize) -> usize {
    chars[from.min(chars.len())..]
        .iter()
        .take_while(|&&c| c == '#')
        .count()
}

/// Marks the lines from each `#[cfg(test)]` or `#[cfg(all(test, ...))]` to the end of its item.
fn mark_tests(lines: &mut [SourceLine]) {
    let mut inside = false;
    let mut depth = 0usize;
    for line in lines {
        let code = line.code.as_str();
        let mut rest = code;
        if !inside {
            let Some(found) = ["#[cfg(test)]", "#[cfg(all(test,"]
                .iter()
                .find_map(|mark| code.find(mark).map(|start| &code[start + mark.len()..]))
            else {
                continue;
            };
            rest = found;
            inside = true;
            depth = 0;
        }
        line.test = true;
        for c in rest.chars() {
            match c {
                '{' => depth += 1,
                '}' => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth == 0 && (c == '}' || c == ';') {
                inside = false;
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn only(text: &str) -> SourceLine {
        let lines = scan(text);
        assert_eq!(lines.len(), 1, "{lines:?}");
        lines.into_iter().next().unwrap()
    }

    #[test]
    fn code_comments_and_literals_are_distinguished() {
        let line = only(r#"let a = "x // y\" z"; // say "hi""#);
        assert_eq!(line.code, r#"let a = ""; "#);
        assert_eq!(line.literal, r#"x // y\" z"#);
        assert_eq!(line.comment, r#"// say "hi""#);
    }

    #[test]
    fn raw_strings_end_at_their_own_hashes() {
        let line = only(r###"f(br##"a "# b"##, r"\", r#type)"###);
        assert_eq!(line.literal, r##"a "# b\"##);
        assert_eq!(line.code, r##"f(br##"", r"", r#type)"##);
    }

    #[test]
    fn quotes_within_characters_open_no_string() {
        let line = only(r#"match c { '"' => '\'', '\u{22}' => 'b', _ => x::<'a>() } // end"#);
        assert_eq!(line.literal, "");
        assert_eq!(line.comment, "// end");
    }

    #[test]
    fn block_comments_nest_and_span_lines() {
        let lines = scan("a /* b /* c */\n d */ e\n");
        assert_eq!(lines[0].code, "a ");
        assert_eq!(lines[1].comment, " d */");
        assert_eq!(lines[1].code, " e");
    }

    #[test]
    fn strings_span_lines() {
        let lines = scan("let a = \"one\n// two\";\nlet b;\n");
        assert_eq!(lines[1].literal, "// two");
        assert_eq!(lines[2].code, "let b;");
    }

    #[test]
    fn a_test_module_is_marked_to_its_end() {
        let text = "fn a() {}\n#[cfg(test)]\nmod tests {\n    fn b() { \"}\" }\n}\nfn c() {}\n";
        let marks: Vec<bool> = scan(text).iter().map(|line| line.test).collect();
        assert_eq!(marks, [false, true, true, true, true, false]);
    }

    #[test]
    fn a_test_declaration_is_marked_to_its_semicolon() {
        let marks: Vec<bool> = scan("#[cfg(test)]\nmod tests;\nfn c() {}\n")
            .iter()
            .map(|line| line.test)
            .collect();
        assert_eq!(marks, [true, true, false]);
    }
}
