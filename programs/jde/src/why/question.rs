//! A question about a selection in a user's words: `did vff take over from goon at 12.4 s?`
//!
//! Names are those of the application. Filler words are skipped, and any other word is refused.

use jde_nearest::nearest;

use crate::failure::Failure;

/// A question about a selection.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Question {
    /// The schema that took over, or [`NOBODY`]; with [`Self::negated`], the schema that did not.
    pub(crate) winner: Option<String>,
    /// The winner before, or [`NOBODY`].
    pub(crate) loser: Option<String>,
    /// The group.
    pub(crate) group: Option<String>,
    /// The time, s since the application's start.
    pub(crate) time_s: Option<f64>,
    /// Whether the question is why the schema did not win.
    pub(crate) negated: bool,
}

/// The word for the absence of a winner.
pub(crate) const NOBODY: &str = "nobody";

/// Words without a meaning in a question.
const FILLERS: [&str; 30] = [
    "why", "did", "does", "do", "is", "was", "has", "had", "take", "takes", "took", "taken", "over", "win",
    "wins", "won", "winner", "chosen", "the", "a", "at", "time", "control", "in", "group", "act", "who",
    "drove", "drives", "driving",
];

/// The words before the name of the loser.
const LOSER_PREPOSITIONS: [&str; 5] = ["from", "instead", "of", "after", "before"];

/// Examples of questions, for error messages.
const EXAMPLES: &str = "examples: jde why vff, jde why not goon, jde why nobody, jde why who drove at 5s, \
     jde why did vff take over from goon at 12.4s";

impl Question {
    /// Reads the words of a question, given the names of schemas and groups.
    pub(crate) fn parse(words: &[String], schemas: &[String], groups: &[String]) -> Result<Self, Failure> {
        let mut question = Self::default();
        let mut is_loser = false;
        let mut number: Option<f64> = None;
        let sentence = words.join(" ");
        for word in sentence.split_whitespace() {
            let word = word.trim_end_matches(['?', ',', ';']);
            let plain = word.to_lowercase();
            if word == NOBODY || schemas.iter().any(|name| name == word) {
                question.set_schema(word, is_loser)?;
                is_loser = false;
            } else if groups.iter().any(|name| name == word) {
                question.group = Some(word.to_owned());
            } else if LOSER_PREPOSITIONS.contains(&plain.as_str()) {
                is_loser = true;
            } else if ["not", "never", "didn't", "isn't", "wasn't", "doesn't"].contains(&plain.as_str()) {
                question.negated = true;
            } else if let Some(time) = parse_time(&plain, number) {
                question.time_s = Some(time);
                number = plain.parse().ok();
            } else if !FILLERS.contains(&plain.as_str()) && !word.is_empty() {
                let names = schemas.iter().chain(groups).map(String::as_str);
                if nearest(word, names.clone()).is_none() {
                    let message = format!("there is no schema or group `{word}`");
                    return Err(Failure::usage(message, EXAMPLES));
                }
                return Err(Failure::unknown("schema or group", word, names));
            }
        }
        if question.negated && question.winner.is_none() {
            return Err(Failure::usage(
                "the question does not name the schema that did not win",
                EXAMPLES,
            ));
        }
        Ok(question)
    }

    fn set_schema(&mut self, name: &str, is_loser: bool) -> Result<(), Failure> {
        let slot = match (is_loser, &self.winner) {
            (true, _) => &mut self.loser,
            (false, None) => &mut self.winner,
            (false, Some(_)) => &mut self.loser,
        };
        if let Some(other) = slot {
            let message = format!("the question names `{other}` and `{name}` in the same position");
            return Err(Failure::usage(message, EXAMPLES));
        }
        *slot = Some(name.to_owned());
        Ok(())
    }
}

/// A time in seconds, such as "12.4s", "12.4" or "1min"; or the number `before` in the unit `word`.
fn parse_time(word: &str, before: Option<f64>) -> Option<f64> {
    let digits = word
        .find(|letter: char| letter.is_ascii_alphabetic())
        .unwrap_or(word.len());
    let (number, unit) = word.split_at(digits);
    let number = if number.is_empty() {
        before?
    } else {
        number.parse().ok()?
    };
    let scale = match unit {
        "" if before.is_none() => 1.0,
        "s" | "sec" | "seconds" => 1.0,
        "ms" => 1e-3,
        "min" | "m" | "minutes" => 60.0,
        "h" => 3600.0,
        _ => return None,
    };
    let time = number * scale;
    (time.is_finite() && time >= 0.0).then_some(time)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(words: &str) -> Result<Question, String> {
        let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
        let schemas = ["stop", "vff", "goon", "example"].map(str::to_owned);
        Question::parse(&words, &schemas, &["roots".to_owned(), "example/base".to_owned()]).map_err(
            |failure| match failure {
                Failure::Run(crate::failure::RunFailure::Usage { message, help }) => {
                    format!("{message}; {help}")
                }
                other => other.to_string(),
            },
        )
    }

    fn of(winner: Option<&str>, loser: Option<&str>, at: Option<f64>) -> Question {
        Question {
            winner: winner.map(str::to_owned),
            loser: loser.map(str::to_owned),
            time_s: at,
            ..Question::default()
        }
    }

    #[test]
    fn a_sentence_and_its_names_alone_are_the_same_question() {
        let expected = of(Some("vff"), Some("goon"), Some(12.4));
        assert_eq!(
            parse("did vff take over from goon at 12.4 s?"),
            Ok(expected.clone())
        );
        assert_eq!(parse("vff goon 12.4s"), Ok(expected.clone()));
        assert_eq!(parse("vff instead of goon at 12400 ms"), Ok(expected));
        assert_eq!(parse("goon"), Ok(of(Some("goon"), None, None)));
        assert_eq!(parse("at 2 min"), Ok(of(None, None, Some(120.0))));
        assert_eq!(parse("who drove at 5s"), Ok(of(None, None, Some(5.0))));
        assert_eq!(parse("who drives"), Ok(of(None, None, None)));
        assert_eq!(parse("from goon"), Ok(of(None, Some("goon"), None)));
        assert_eq!(parse("why did nobody win"), Ok(of(Some("nobody"), None, None)));
    }

    #[test]
    fn a_question_can_name_a_group_or_a_schema_that_did_not_win() {
        assert_eq!(
            parse("example/base").unwrap().group.as_deref(),
            Some("example/base")
        );
        let negated = parse("is goon not the winner").unwrap();
        assert!(negated.negated && negated.winner.as_deref() == Some("goon"));
        assert!(parse("not").unwrap_err().contains("that did not win"));
    }

    #[test]
    fn unknown_names_are_refused_with_the_nearest() {
        let error = parse("did vf take over").unwrap_err();
        assert_eq!(error, "there is no schema or group `vf`; did you mean `vff`?");
        let error = parse("did it stand").unwrap_err();
        assert!(
            error.starts_with("there is no schema or group `it`; examples: jde why "),
            "{error}"
        );
        assert!(parse("-3s").is_err());
        assert!(parse("vff goon stop").unwrap_err().contains("same position"));
    }
}
