//! The words `and`, `or` and `not`, which may be written for `&&`, `||` and `!`.

/// Replaces the words by CEL's operators of the same length, so that columns do not change. A word is an
/// operator only where an operator can be: `and` and `or` after an operand, `not` before one. So a schema, a
/// variable or a field may have such a name, as in `not.period > 0.1 and x.and`. Texts and comments stay as
/// they are.
pub(crate) fn replace_words(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    let mut rest = text;
    // Whether the last token ends an operand.
    let mut after_operand = false;
    let mut after_dot = false;
    while let Some(letter) = rest.chars().next() {
        let length = if letter.is_whitespace() {
            letter.len_utf8()
        } else if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if let Some(length) = literal_length(rest) {
            (after_operand, after_dot) = (true, false);
            length
        } else if is_of_word(letter) {
            let length = rest.find(|letter| !is_of_word(letter)).unwrap_or(rest.len());
            let operator = match &rest[..length] {
                _ if after_dot => None,
                "and" if after_operand => Some("&& "),
                "or" if after_operand => Some("||"),
                "not" if !after_operand && begins_operand(&rest[length..]) => Some("!  "),
                _ => None,
            };
            after_operand = operator.is_none() && &rest[..length] != "in";
            after_dot = false;
            if let Some(operator) = operator {
                result.push_str(operator);
                rest = &rest[length..];
                continue;
            }
            length
        } else {
            after_operand = matches!(letter, ')' | ']' | '}');
            after_dot = letter == '.';
            letter.len_utf8()
        };
        result.push_str(&rest[..length]);
        rest = &rest[length..];
    }
    result
}

fn is_of_word(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || letter == '_'
}

/// Returns whether an operand of `not` begins there.
fn begins_operand(text: &str) -> bool {
    let first = text.trim_start().chars().next();
    first.is_some_and(|first| is_of_word(first) || matches!(first, '(' | '!' | '\'' | '"'))
}

/// Returns the length of the text literal at the beginning of `text`, in bytes. A literal without an end is
/// the rest.
fn literal_length(text: &str) -> Option<usize> {
    let prefix = text.find(|letter: char| !matches!(letter, 'r' | 'R' | 'b' | 'B'))?;
    let quoted = &text[prefix..];
    let quote = ["'''", "\"\"\"", "'", "\""]
        .into_iter()
        .find(|quote| quoted.starts_with(quote))?;
    let is_raw = text[..prefix].contains(['r', 'R']);
    let mut at = prefix + quote.len();
    while let Some(letter) = text[at..].chars().next() {
        if text[at..].starts_with(quote) {
            return Some(at + quote.len());
        }
        at += letter.len_utf8();
        if letter == '\\' && !is_raw {
            at += text[at..].chars().next().map_or(0, char::len_utf8);
        }
    }
    Some(text.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: &str) {
        let replaced = replace_words(text);
        assert_eq!(replaced, expected);
        assert_eq!(
            replaced.chars().count(),
            text.chars().count(),
            "columns do not change"
        );
    }

    #[test]
    fn words_are_operators_where_an_operator_can_be() {
        check("a.b and c.d", "a.b &&  c.d");
        check("a.b > 1 or not c.d", "a.b > 1 || !   c.d");
        check("(a.b)and(c.d)", "(a.b)&& (c.d)");
        check("not(a.b or not not c.d)", "!  (a.b || !   !   c.d)");
        check("x.y[0]or true", "x.y[0]|| true");
        check("a and not 'b' in c.d", "a &&  !   'b' in c.d");
    }

    #[test]
    fn names_that_contain_or_are_such_words_stay() {
        check("band.order > android.nothing", "band.order > android.nothing");
        check("x.and and x.or or x.not", "x.and &&  x.or || x.not");
        check("x . and > 1", "x . and > 1");
        check(
            "and.x > 1 and or.x > 1 and not.x > 1",
            "and.x > 1 &&  or.x > 1 &&  not.x > 1",
        );
        check("not not.ready", "!   not.ready");
        check("x.y.exists(or, or > 1)", "x.y.exists(or, or > 1)");
        check("1 in and.list", "1 in and.list");
    }

    #[test]
    fn texts_and_comments_stay() {
        check("a == ' and ' and b", "a == ' and ' &&  b");
        check(
            r#"a == "x' or " or b == 'it\'s not' or c"#,
            r#"a == "x' or " || b == 'it\'s not' || c"#,
        );
        check(r"a == r'\' and b", r"a == r'\' &&  b");
        check("a == '''it's and''' and b", "a == '''it's and''' &&  b");
        check("a // not and\nand b", "a // not and\n&&  b");
        check("größe == 'ö and' and b", "größe == 'ö and' &&  b");
    }

    #[test]
    fn a_text_without_an_end_stays() {
        check("a and 'b and", "a &&  'b and");
        check("a and r", "a &&  r");
        check("a == '\\", "a == '\\");
    }
}
