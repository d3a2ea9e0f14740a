//! Tests of expressions as a user evaluates them, and of the words for their operators.

use super::*;

fn value(text: &str, fast: f64) -> Option<f64> {
    let mut expression = Expression::new(text, &names()).unwrap();
    assert_eq!(expression.inputs().collect::<Vec<_>>(), ["goon.fast"]);
    expression.set(0, Some(fast.as_bytes()));
    expression.value()
}

#[test]
fn the_value_is_a_number_and_a_bool_is_0_or_1() {
    assert_eq!(value("goon.fast * 2.0", 1.5), Some(3.0));
    assert_eq!(value("goon.fast > 1", 1.5), Some(1.0));
    assert_eq!(value("goon.fast > 1", 0.5), Some(0.0));
    assert_eq!(value("goon.fast > 1 ? 7 : 8", 0.5), Some(8.0));
}

#[test]
fn there_is_no_value_if_one_is_missing_or_the_evaluation_fails_or_the_result_is_a_nan() {
    let mut expression = Expression::condition("goon.fast > 1", &names()).unwrap();
    assert_eq!((expression.value(), expression.is_true()), (None, false));
    expression.set(0, Some(2.0_f64.as_bytes()));
    assert!(expression.is_true());
    expression.set(0, None);
    assert_eq!((expression.value(), expression.is_true()), (None, false));
    expression.set(1, Some(&[]));
    assert_eq!(value("goon.fast", f64::NAN), None);
    assert_eq!(value("goon.fast > 1", f64::NAN), None);
    assert_eq!(value("goon.fast > 1 ? 7 / 0 : 8", 2.0), None);
}

#[test]
fn inputs_have_an_order_and_occur_once() {
    let text = " left-eye.laser.range_max > 3 and goon.fast < 1 or goon.fast > time ";
    let expression = Expression::condition(text, &names()).unwrap();
    assert_eq!(
        expression.inputs().collect::<Vec<_>>(),
        ["goon.fast", "left-eye.laser", "time"]
    );
    assert_eq!(expression.text(), text.trim());
}

#[test]
fn a_result_of_another_kind_is_refused() {
    let names = names();
    let reason = |result: Result<Expression, BadCondition>| result.unwrap_err().reason.to_string();
    assert_eq!(
        reason(Expression::number("goon.fast > 1", &names)),
        "the result is a bool, not a number"
    );
    assert_eq!(
        reason(Expression::new("guide.mission.note", &names)),
        "the result is a text, not a bool or a number"
    );
    assert_eq!(
        reason(Expression::condition("goon.fast", &names)),
        "the result is a double, not a bool: compare it with something, as in `> 0.5`"
    );
    assert!(
        Expression::number("collision", &names).is_err(),
        "it is a keyword of conditions"
    );
}

#[test]
fn words_stand_for_operators_and_columns_stay() {
    let truth = [0.5, 1.5, 2.5].map(|fast| value("goon.fast > 1 and not (goon.fast > 2 or false)", fast));
    assert_eq!(truth, [Some(0.0), Some(1.0), Some(0.0)]);
    assert_eq!(
        error("goon.fast > 1 and not goon.fsat > 1"),
        "23: no variable is called `goon.fsat`; did you mean `goon.fast`?"
    );
    assert_eq!(
        error("goon.fast and goon.count > 1"),
        "11: `&&` takes bools, not a double and a bool"
    );
}

#[test]
fn names_may_be_words_for_operators() {
    let mut names = names();
    let number = Arc::new(f64::describe());
    for name in ["and.or", "not-and.not"] {
        names.variables.insert(name.to_owned(), Arc::clone(&number));
    }
    let text = "and.or > 1 and not-and.not > 1 or not (and.or > 1)";
    let mut expression = Expression::condition(text, &names).unwrap();
    assert_eq!(expression.inputs().collect::<Vec<_>>(), ["and.or", "not-and.not"]);
    expression.set(0, Some(0.5_f64.as_bytes()));
    assert!(expression.is_true());
}
