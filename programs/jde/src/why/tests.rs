//! Tests of questions about a drive, and of the printed answers.

use std::sync::LazyLock;

use jde_core::{Case, State};
use jde_records::event::{OperatorAction, Outcome, StateChange, What};
use jde_records::{CandidateRecord, DecidedBy, Decision, RefusedCandidate, RunRecord};
use jde_timeline::{Hierarchy, Keep, Timeline};

use super::{Answer, DueStep, KnownSpan, Past, Question, write};

fn decision(number: u64, time_s: f64, before: Option<&str>, choice: Option<&str>) -> Decision {
    let candidate = |name: &str| CandidateRecord {
        name: name.to_owned(),
        state: if before == Some(name) {
            State::Winner
        } else {
            State::Checking
        },
        ready: choice == Some(name),
        urgency: Some(0.0),
    };
    Decision {
        number,
        time_s,
        group: "example/base".to_owned(),
        case: if choice.is_some() {
            Case::Alone
        } else {
            Case::Absence
        },
        candidates: ["stop", "vff", "goon"].map(candidate).to_vec(),
        before: before.map(str::to_owned),
        choice: choice.map(str::to_owned),
        decider: DecidedBy::Nobody,
        reason: format!("only {} is ready", choice.unwrap_or("nobody")),
        cause: "the readiness of vff changed".to_owned(),
        changed: before != choice,
        takeover_us: choice.map(|_| 400.0),
        refused: Vec::new(),
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

fn question(words: &str) -> Question {
    let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
    Question::parse(&words, &names(), &["example/base".to_owned()]).unwrap()
}

/// What is known of a run without states.
fn past(decisions: &[Decision], known: KnownSpan) -> Past<'_> {
    static NOTHING: LazyLock<Timeline> = LazyLock::new(Timeline::default);
    Past {
        timeline: &NOTHING,
        decisions,
        events: &[],
        steps: &[],
        known,
    }
}

fn found(text: &str) -> u64 {
    match question(text).answer(past(&drive(), KNOWN), &[]) {
        Answer::Match { decision, .. } => decision.number,
        Answer::NoMatch(reason) => panic!("{reason}"),
        Answer::Asleep(asleep) => panic!("{asleep:?}"),
    }
}

fn error(text: &str) -> String {
    match question(text).answer(past(&drive(), KNOWN), &[]) {
        Answer::Match { decision, .. } => panic!("found {}", decision.number),
        Answer::NoMatch(reason) => reason,
        Answer::Asleep(asleep) => panic!("{asleep:?}"),
    }
}

#[test]
fn a_question_with_a_time_finds_the_nearest_matching_takeover() {
    assert_eq!(found("did vff take over from goon at 12.4 s?"), 3);
    assert_eq!(found("vff at 29s"), 5);
    assert_eq!(found("vff"), 5);
    assert_eq!(found("goon at 13s"), 4);
}

#[test]
fn a_time_alone_finds_the_takeover_in_force() {
    assert_eq!(found("at 6.5"), 1);
    assert_eq!(found("at 12.4"), 3);
    assert_eq!(found("at 100"), 6);
}

#[test]
fn a_negated_question_finds_a_selection_that_another_schema_won() {
    assert_eq!(found("not vff at 20s"), 4);
    assert_eq!(found("is goon not the winner"), 6);
}

#[test]
fn a_question_about_nobody_finds_a_selection_without_a_winner() {
    assert_eq!(found("nobody"), 6);
    assert_eq!(found("why nobody instead of vff"), 6);
    assert_eq!(found("goon from nobody"), 1);
    let none = "every selection after stop from 0.00 s to 31.00 s has a winner";
    assert_eq!(error("nobody from stop"), none);
    let mut decisions = drive();
    decisions.push(decision(7, 31.5, None, None));
    let number =
        |words: &str, decisions: &[Decision]| match question(words).answer(past(decisions, KNOWN), &[]) {
            Answer::Match { decision, .. } => Ok(decision.number),
            Answer::NoMatch(reason) => Err(reason),
            Answer::Asleep(asleep) => panic!("{asleep:?}"),
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
    let expected = "every selection of example/base from 0.00 s to 30.00 s has a winner";
    assert_eq!(
        number("nobody in example/base", &drive()[..5]),
        Err(expected.to_owned())
    );
}

#[test]
fn a_schema_that_was_not_awake_is_marked_as_such() {
    let mut decisions = drive();
    let mut last = decision(7, 32.0, None, Some("vff"));
    last.candidates.retain(|candidate| candidate.name != "goon");
    decisions.push(last);
    let mut output = Vec::new();
    write(
        &question("not goon").answer(past(&decisions, KNOWN), &[]),
        Some("goon"),
        &mut output,
    )
    .unwrap();
    let text = jde_terminal::escape::without_styles(&String::from_utf8(output).unwrap());
    assert!(
        text.starts_with("example/base at 32.000 s: nobody -> vff"),
        "{text}"
    );
    assert!(text.contains("goon  was not awake"), "{text}");
}

#[test]
fn a_question_without_a_match_is_answered_with_the_reason() {
    assert_eq!(error("stop"), "stop never took over from 0.00 s to 31.00 s");
    assert_eq!(
        error("vff from stop"),
        "vff never took over from stop, only from goon"
    );
    assert_eq!(
        question("vff").answer(past(&[], KNOWN), &[]),
        Answer::NoMatch("no selection has been made yet".to_owned())
    );
}

#[test]
fn an_answer_shows_case_decider_cause_and_every_candidate() {
    let decisions = drive();
    let mut output = Vec::new();
    write(
        &question("vff goon 12.4s").answer(past(&decisions, KNOWN), &[]),
        Some("stop"),
        &mut output,
    )
    .unwrap();
    let text = jde_terminal::escape::without_styles(&String::from_utf8(output).unwrap());
    let expected = "\
example/base at 12.402 s: goon -> vff  (selection 3)
  reason      only vff is ready
  case        alone: exactly one was ready, so there is no choice
  decided by  nobody: there was no choice
  cause       the readiness of vff changed
  took        400 µs from the cause to its first iteration
  candidates  stop  checking not ready  <- its precondition did not hold
              vff   checking ready  <- chosen
              goon  winner   not ready
  before        0.000 s  example/base: nobody -> goon  only goon is ready, took 400 µs
  after        14.000 s  example/base: vff -> goon  only goon is ready, took 400 µs
";
    assert_eq!(text, expected);
}

#[test]
fn an_answer_shows_which_guard_a_candidate_waits_for() {
    let mut decisions = drive();
    decisions[2].refused.push(RefusedCandidate {
        name: "stop".to_owned(),
        reason: "command refused by the guard `net`: too near".to_owned(),
        left_s: 0.32,
    });
    let found = question("vff goon 12.4s").answer(past(&decisions, KNOWN), &[]);
    for marked in [None, Some("stop")] {
        let mut output = Vec::new();
        write(&found, marked, &mut output).unwrap();
        let text = jde_terminal::escape::without_styles(&String::from_utf8(output).unwrap());
        let expected = "stop  checking not ready  \
            <- command refused by the guard `net`: too near; not ready for 0.32 s more\n";
        assert!(text.contains(expected), "{text}");
        assert!(!text.contains("its precondition"), "{text}");
    }
}

#[test]
fn an_answer_shows_how_the_commands_of_the_chosen_schema_were_limited() {
    let limit = |time_s: f64, schema: &str| {
        let limited = What::Limited {
            schema: schema.to_owned(),
            description: format!("guard: too fast at {time_s}"),
        };
        limited.at((time_s * 1e9) as u64)
    };
    let limits = [
        limit(11.0, "vff"),
        limit(12.5, "goon"),
        limit(12.6, "vff"),
        limit(13.0, "vff"),
        limit(30.5, "vff"),
    ];
    let mut output = Vec::new();
    let decisions = drive();
    let answer = question("vff goon 12.4s").answer(past(&decisions, KNOWN), &limits);
    write(&answer, None, &mut output).unwrap();
    let text = jde_terminal::escape::without_styles(&String::from_utf8(output).unwrap());
    assert!(
        text.contains("limited     at 12.600 s: guard: too fast at 12.6\n"),
        "{text}"
    );
    assert!(
        text.contains("and once more\n") && !text.contains("too fast at 11"),
        "{text}"
    );
}

#[test]
fn an_answer_shows_the_first_and_the_last_command_of_a_chunk_that_came_due() {
    let due = |schema: &str, time_s: f64, step| DueStep {
        schema: schema.to_owned(),
        time_s,
        chunk: 3,
        step,
        steps: 16,
        age_s: 0.25,
    };
    let steps = [
        due("vff", 11.0, 1),
        due("vff", 12.5, 2),
        due("goon", 12.6, 3),
        due("vff", 13.0, 4),
        due("vff", 13.9, 5),
        due("vff", 30.9, 6),
    ];
    let decisions = drive();
    let text = |words: &str| {
        let mut output = Vec::new();
        let known = Past {
            steps: &steps,
            ..past(&decisions, KNOWN)
        };
        write(&question(words).answer(known, &[]), None, &mut output).unwrap();
        jde_terminal::escape::without_styles(&String::from_utf8(output).unwrap())
    };
    let shown = text("vff goon 12.4s");
    let expected = "  came due    at 12.500 s: step 2 of 16 of chunk 3, seen 0.250 s before
              at 13.900 s: step 5 of 16 of chunk 3, seen 0.250 s before
";
    assert!(shown.contains(expected), "{shown}");
    // Nobody was chosen at 31 s: the last one is what led to it.
    let shown = text("nobody");
    assert!(shown.contains("at 30.900 s: step 6 of 16"), "{shown}");
}

#[test]
fn a_time_outside_the_known_span_has_no_answer() {
    let known = KnownSpan {
        from: 10.0,
        until: 32.0,
    };
    let answer = |words: &str| match question(words).answer(past(&drive(), known), &[]) {
        Answer::Match { decision, .. } => decision.number.to_string(),
        Answer::NoMatch(reason) => reason,
        Answer::Asleep(asleep) => panic!("{asleep:?}"),
    };
    let expected = "99999 s is after the known selections, which end at 32.00 s";
    assert_eq!(answer("at 99999s"), expected);
    assert_eq!(answer("vff at 99999s"), expected);
    assert_eq!(answer("is goon not the winner at 99999s"), expected);
    assert_eq!(
        answer("vff at 3s"),
        "3 s is before the known selections, which begin at 10.00 s"
    );
    assert_eq!(answer("at 32.05s"), "6", "a rounded time");
}

#[test]
fn a_choice_that_was_made_before_the_known_selections_is_found_while_it_is_in_force() {
    let halt = |number: u64, time_s: f64| decision(number, time_s, Some("stop"), Some("stop"));
    let decisions = [halt(900, 557.0), halt(901, 600.0), halt(902, 624.0)];
    let known = KnownSpan {
        from: 557.0,
        until: 624.0,
    };
    let number = |words: &str| match question(words).answer(past(&decisions, known), &[]) {
        Answer::Match { decision, .. } => Ok(decision.number),
        Answer::NoMatch(reason) => Err(reason),
        Answer::Asleep(asleep) => panic!("{asleep:?}"),
    };
    assert_eq!(number("stop"), Ok(900));
    assert_eq!(number("stop at 610s"), Ok(901));
    assert_eq!(number("at 623s"), Ok(902));
    assert!(number("vff").is_err_and(|reason| reason.contains("never took over")));
}

/// A run in which `ana` stopped `example`, the father of the drive, at 40 s.
fn stopped_run(last: State) -> (Timeline, [jde_records::event::Occurrence<String>; 2]) {
    let mut hierarchy = Hierarchy::default();
    hierarchy.describe_group("roots", None, ["example"]);
    hierarchy.describe_group("example/base", Some("example"), ["stop", "vff", "goon"]);
    let mut timeline = Timeline::new(hierarchy, Keep::ALL);
    for (time_s, schema, from, to) in [
        (0.0, "example", State::Checking, State::Winner),
        (0.0, "goon", State::Checking, State::Winner),
        (0.0, "vff", State::Slept, State::Checking),
        (0.0, "stop", State::Slept, State::Checking),
        (20.0, "example", State::Winner, last),
        // What is below a father sleeps with it, whether or not its records arrive.
        (40.0, "example", last, State::Slept),
    ] {
        let schema = schema.to_owned();
        let time = (time_s * 1e9) as u64;
        timeline.add(&RunRecord::State(StateChange {
            time,
            schema,
            from,
            to,
        }));
    }
    let stop = What::Operator {
        by: "ana@laptop".to_owned(),
        action: OperatorAction::Stop {
            schema: "example".to_owned(),
        },
        losses: Vec::new(),
    };
    let outcome = Outcome::Stopped;
    (
        timeline,
        [
            stop.at(40_000_000_000),
            What::Ended { outcome }.at(50_000_000_000),
        ],
    )
}

#[test]
fn nobody_wins_in_a_group_that_sleeps_and_the_answer_says_who_put_it_to_sleep() {
    let (timeline, events) = stopped_run(State::Winner);
    let decisions = drive()[..5].to_vec();
    let answer = |words: &str| {
        let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
        let groups = ["roots", "example/base"].map(str::to_owned);
        let question = Question::parse(&words, &names(), &groups).unwrap();
        let past = Past {
            timeline: &timeline,
            events: &events,
            ..past(&decisions, KNOWN)
        };
        let mut output = Vec::new();
        write(&question.answer(past, &[]), None, &mut output).unwrap();
        jde_terminal::escape::without_styles(&String::from_utf8(output).unwrap())
    };
    let roots = "\
roots since 40.000 s: nobody
  reason      its members sleep, so there is nobody to select
  cause       ana@laptop stopped example, at 40.000 s
  until then  example
";
    assert_eq!(answer("nobody in roots"), roots);
    assert_eq!(answer("nobody"), roots);
    let base = answer("why nobody in example/base at 60s");
    assert!(
        base.starts_with("example/base since 40.000 s: nobody\n"),
        "{base}"
    );
    assert!(
        base.contains("because their father example lost\n  cause       ana@laptop stopped example"),
        "{base}"
    );
    let before = answer("nobody in roots at 30s");
    assert!(before.contains("has a winner"), "{before}");
}

#[test]
fn the_end_of_a_run_does_not_hide_when_nobody_won_before() {
    // Whether it won until then, or nobody had been ready for a while.
    for last in [State::Winner, State::Checking] {
        let (timeline, mut events) = stopped_run(last);
        // Everything sleeps because the application ended.
        events[1].time = 40_000_000_001;
        let decisions = drive();
        let past = Past {
            timeline: &timeline,
            events: &events[1..],
            ..past(&decisions, KNOWN)
        };
        let answer = question("nobody").answer(past, &[]);
        assert!(
            matches!(answer, Answer::Match { decision, .. } if decision.number == 6),
            "{answer:?}"
        );
    }
}
