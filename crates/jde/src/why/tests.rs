//! Questions about a drive, and their answers in words.

use jde_records::{CandidateRecord, Decision};

use super::{Answer, KnownSpan, Question, write};

fn decision(number: u64, time_s: f64, before: Option<&str>, choice: Option<&str>) -> Decision {
    let candidate = |name: &str| CandidateRecord {
        name: name.to_owned(),
        state: if before == Some(name) {
            "winner"
        } else {
            "checking"
        }
        .to_owned(),
        ready: choice == Some(name),
        urgency: Some(0.0),
    };
    Decision {
        number,
        time_s,
        group: "example/base".to_owned(),
        case: if choice.is_some() { "alone" } else { "absence" }.to_owned(),
        candidates: ["stop", "vff", "goon"].map(candidate).to_vec(),
        before: before.map(str::to_owned),
        choice: choice.map(str::to_owned),
        decider: "nobody".to_owned(),
        reason: format!("only {} is ready", choice.unwrap_or("nobody")),
        cause: "the readiness of vff changed".to_owned(),
        changed: before != choice,
        takeover_us: choice.map(|_| 400.0),
    }
}

const KNOWN: KnownSpan = KnownSpan {
    from: 0.0,
    until: 200.0,
};

/// goon drives, and an obstacle is in the way twice.
fn drive() -> Vec<Decision> {
    vec![
        decision(1, 0.0, None, Some("goon")),
        decision(2, 6.0, Some("goon"), Some("goon")),
        decision(3, 12.402, Some("goon"), Some("vff")),
        decision(4, 14.0, Some("vff"), Some("goon")),
        decision(5, 30.0, Some("goon"), Some("vff")),
        decision(6, 31.0, Some("vff"), None),
    ]
}

fn names() -> Vec<String> {
    ["stop", "vff", "goon", "example"].map(str::to_owned).to_vec()
}

fn ask(words: &str) -> Question {
    let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
    Question::parse(&words, &names(), &["example/base".to_owned()]).unwrap()
}

fn found(words: &str) -> u64 {
    match ask(words).answer(&drive(), KNOWN) {
        Answer::Match { decision, .. } => decision.number,
        Answer::NoMatch(reason) => panic!("{reason}"),
    }
}

fn refused(words: &str) -> String {
    match ask(words).answer(&drive(), KNOWN) {
        Answer::Match { decision, .. } => panic!("found {}", decision.number),
        Answer::NoMatch(reason) => reason,
    }
}

#[test]
fn the_nearest_takeover_of_the_right_ones_is_meant() {
    assert_eq!(found("did vff take over from goon at 12.4 s?"), 3);
    assert_eq!(found("vff at 29s"), 5);
    assert_eq!(found("vff"), 5);
    assert_eq!(found("goon at 13s"), 4);
}

#[test]
fn a_time_alone_asks_for_what_was_in_force() {
    assert_eq!(found("at 6.5"), 1);
    assert_eq!(found("at 12.4"), 3);
    assert_eq!(found("at 100"), 6);
}

#[test]
fn who_did_not_win_is_found_where_somebody_else_did() {
    assert_eq!(found("not vff at 20s"), 4);
    assert_eq!(found("is goon not the winner"), 6);
}

#[test]
fn nobody_is_found_where_no_schema_won() {
    assert_eq!(found("nobody"), 6);
    assert_eq!(found("why nobody instead of vff"), 6);
    assert_eq!(found("goon from nobody"), 1);
    let none = "every selection after stop from 0.00 s to 31.00 s has a winner";
    assert_eq!(refused("nobody from stop"), none);
    let mut decisions = drive();
    decisions.push(decision(7, 31.5, None, None));
    let number = |words: &str, decisions: &[Decision]| match ask(words).answer(decisions, KNOWN) {
        Answer::Match { decision, .. } => Ok(decision.number),
        Answer::NoMatch(reason) => Err(reason),
    };
    assert_eq!(
        number("nobody", &decisions),
        Ok(7),
        "the newest state of the candidates"
    );
    assert_eq!(number("nobody at 31 s", &decisions), Ok(6));
    let mut other = [
        decision(8, 40.0, Some("a"), None),
        decision(9, 41.0, None, Some("a")),
    ];
    other
        .iter_mut()
        .for_each(|decision| decision.group = "roots".to_owned());
    decisions.extend(other);
    assert_eq!(number("nobody", &decisions), Ok(7), "it is still in force");
    let some = "every selection of example/base from 0.00 s to 30.00 s has a winner";
    assert_eq!(
        number("nobody in example/base", &drive()[..5]),
        Err(some.to_owned())
    );
}

#[test]
fn who_was_not_awake_did_not_win_for_that() {
    let mut decisions = drive();
    let mut last = decision(7, 32.0, None, Some("vff"));
    last.candidates.retain(|candidate| candidate.name != "goon");
    decisions.push(last);
    let mut words = Vec::new();
    write(
        &ask("not goon").answer(&decisions, KNOWN),
        Some("goon"),
        &mut words,
    )
    .unwrap();
    let words = anstream::adapter::strip_str(&String::from_utf8(words).unwrap()).to_string();
    assert!(
        words.starts_with("example/base at 32.000 s: nobody -> vff"),
        "{words}"
    );
    assert!(words.contains("goon  was not awake"), "{words}");
}

#[test]
fn what_never_happened_is_said_with_what_did() {
    assert_eq!(
        refused("stop"),
        "stop took over at no time from 0.00 s to 31.00 s"
    );
    assert_eq!(
        refused("vff from stop"),
        "vff never took over from stop, only from goon"
    );
    assert_eq!(
        ask("vff").answer(&[], KNOWN),
        Answer::NoMatch("no selection has been made yet".to_owned())
    );
}

#[test]
fn an_answer_names_case_decider_cause_and_every_candidate() {
    let decisions = drive();
    let mut words = Vec::new();
    write(
        &ask("vff goon 12.4s").answer(&decisions, KNOWN),
        Some("stop"),
        &mut words,
    )
    .unwrap();
    let words = anstream::adapter::strip_str(&String::from_utf8(words).unwrap()).to_string();
    let expected = "\
example/base at 12.402 s: goon -> vff  (selection 3)
  because     only vff is ready
  case        alone: exactly one was ready, and nobody is asked
  decided by  nobody: there was nothing to decide
  set off by  the readiness of vff changed
  took        0.40 ms from the cause to its first iteration
  candidates  stop  checking not ready  <- its precondition did not hold
              vff   checking ready  <- chosen
              goon  winner   not ready
  before        0.000 s  example/base: nobody -> goon  only goon is ready, took 0.40 ms
  after        14.000 s  example/base: vff -> goon  only goon is ready, took 0.40 ms
";
    assert_eq!(words, expected);
}

#[test]
fn of_a_time_that_is_not_known_nothing_is_told() {
    let known = KnownSpan {
        from: 10.0,
        until: 32.0,
    };
    let asked = |words: &str| match ask(words).answer(&drive(), known) {
        Answer::Match { decision, .. } => decision.number.to_string(),
        Answer::NoMatch(reason) => reason,
    };
    let beyond = "99999 s lies beyond what is known, which ends at 32.00 s";
    assert_eq!(asked("at 99999s"), beyond);
    assert_eq!(asked("vff at 99999s"), beyond);
    assert_eq!(asked("is goon not the winner at 99999s"), beyond);
    assert_eq!(
        asked("vff at 3s"),
        "3 s lies before what is known, which begins at 10.00 s"
    );
    assert_eq!(asked("at 32.05s"), "6", "a time that was read off and rounded");
}
